// The lattice of a wrap: weights of points as blocks of 4 × 4 × 4 numbers.
#pragma once

#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/lattice/refine.hpp>
#include <cageform/pose/detail/stretches.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

using Point = Vec<double, 3>;

inline Point product(const LinearMap<double, 3>& m, const Point& v) noexcept {
    Point to{};
    for (std::size_t r = 0; r < 3; ++r) to[r] = m.at[r][0] * v[0] + m.at[r][1] * v[1] + m.at[r][2] * v[2];
    return to;
}

/// Rows of 64 weights, of the handles in a block of a lattice.
struct LatticeRows {
    static constexpr std::size_t width = 64;
    std::array<std::size_t, 3> counts{}; ///< control points of the lattice along each axis
    std::vector<std::uint32_t> first;    ///< #rows: the handle of the first weight
    std::vector<double> weights;         ///< #rows · 64, the first axis fastest

    std::size_t size() const noexcept { return first.size(); }
    /// Calls f(handle, weight) for the weights of a row.
    template <class F>
    void for_each(std::size_t row, const F& f) const {
        const double* w = weights.data() + row * width;
        for (std::size_t z = 0; z < 4; ++z) {
            for (std::size_t y = 0; y < 4; ++y) {
                const std::size_t run = first[row] + (z * counts[1] + y) * counts[0];
                for (std::size_t x = 0; x < 4; ++x) f(run + x, *w++);
            }
        }
    }
    Point product(std::size_t row, const std::vector<Point>& p) const noexcept {
        Point sum{};
        for_each(row, [&](std::size_t i, double w) { sum = sum + w * p[i]; });
        return sum;
    }
    void add(std::size_t row, const Point& value, std::vector<Point>& sums) const noexcept {
        for_each(row, [&](std::size_t i, double w) { sums[i] = sums[i] + w * value; });
    }
};

class LatticeMatrix;
class LatticeFactors;

/// A lattice of cubic B-splines in a box of cubic cells.
class WrapLattice {
public:
    using Rows = LatticeRows;
    using Matrix = LatticeMatrix;
    using Factors = LatticeFactors;

    /// Covers a box with cells of edge h, with half a cell to spare at each side.
    WrapLattice(const Bounds<double, 3>& box, double h) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double extent = box.upper[k] - box.lower[k];
            const auto cells = std::size_t(std::ceil(extent / h + 1e-6)) + 1;
            size_[k] = double(cells) * h;
            lower_[k] = 0.5 * (box.lower[k] + box.upper[k] - size_[k]);
            set_axis(k, {cells + 3, 3, {}});
        }
        cell_ = h;
        for (std::size_t n = 0; n < size(); ++n) rest_.push_back(rest_place(n));
    }

    /// A cubic lattice in the coordinates of its box, [0, 1]³.
    template <Scalar T>
    explicit WrapLattice(const LatticeCoordinates<T, 3>& lattice)
        : size_{1, 1, 1} {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto knots = lattice.knots(k);
            set_axis(k, {lattice.points(k), 3, {knots.begin(), knots.end()}});
        }
    }

    std::size_t size() const noexcept { return counts_[0] * counts_[1] * counts_[2]; }
    double cell() const noexcept { return cell_; }
    const std::array<LatticeAxis, 3>& axes() const noexcept { return axes_; }
    const Point& lower() const noexcept { return lower_; }
    const Point& extent() const noexcept { return size_; }
    const std::vector<Point>& rest() const noexcept { return rest_; }
    LatticeMatrix matrix(const std::vector<std::uint32_t>& unknowns) const;

    /// Halves the cells. `pose` keeps the map.
    void refine(std::vector<Point>& pose) {
        for (std::size_t k = 0; k < 3; ++k) {
            const RefinedAxis finer = halve_spans(axes_[k]).value;
            pose = refined_points<double, 3>(pose, counts_, k, finer);
            set_axis(k, finer.axis);
        }
        cell_ /= 2;
        rest_.clear();
        for (std::size_t n = 0; n < size(); ++n) rest_.push_back(rest_place(n));
    }

    Status weights(std::span<const Point> points, LatticeRows& rows) const {
        start(rows, points.size());
        for (const Point& p : points) {
            const Functions f(*this, p);
            append(rows, f, f.value[0], f.value[1], f.value[2]);
        }
        return Status::ok;
    }
    /// Returns three rows per point: the derivatives along the axes of the space before the stage.
    ///
    ///   before  the Jacobian of the map before the stage at each point; empty: the identity
    Status gradients(std::span<const Point> points, std::span<const LinearMap<double, 3>> before,
                     LatticeRows& rows) const {
        start(rows, 3 * points.size());
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Functions f(*this, points[n]);
            for (std::size_t k = 0; k < 3; ++k)
                append(rows, f, k == 0 ? f.slope[0] : f.value[0], k == 1 ? f.slope[1] : f.value[1],
                       k == 2 ? f.slope[2] : f.value[2]);
            if (before.empty()) continue;
            double* const w = rows.weights.data() + rows.weights.size() - 3 * LatticeRows::width;
            for (std::size_t m = 0; m < LatticeRows::width; ++m) {
                const Point g{w[m], w[m + LatticeRows::width], w[m + 2 * LatticeRows::width]};
                for (std::size_t k = 0; k < 3; ++k) {
                    double sum = 0;
                    for (std::size_t c = 0; c < 3; ++c) sum += g[c] * before[n].at[c][k];
                    w[m + k * LatticeRows::width] = sum;
                }
            }
        }
        return Status::ok;
    }

    /// Adds second differences of the control points to a matrix. The differences are divided by those of the
    /// Greville abscissae, so that they are zero for affine maps.
    ///
    ///   is_unknown  #handles
    void add_ridge(LatticeMatrix& matrix, const std::vector<char>& is_unknown, double factor) const noexcept;

private:
    /// The functions of the axes at a point, and their derivatives by the place.
    struct Functions {
        std::size_t first[3];
        std::array<double, 4> value[3], slope[3];

        Functions(const WrapLattice& lattice, const Point& p) noexcept {
            for (std::size_t k = 0; k < 3; ++k) {
                const double u = (p[k] - lattice.lower_[k]) / lattice.size_[k];
                const double inside = std::clamp(u, 0.0, 1.0);
                SplineAxis<double>::Values at, along;
                first[k] = lattice.splines_[k].evaluate(inside, at, along);
                for (std::size_t r = 0; r < 4; ++r) {
                    value[k][r] = at[r] + (u - inside) * along[r];
                    slope[k][r] = along[r] / lattice.size_[k];
                }
            }
        }
    };

    void set_axis(std::size_t k, const LatticeAxis& axis) {
        axes_[k] = axis;
        splines_[k] = SplineAxis<double>(axis);
        counts_[k] = axis.points;
    }
    Point rest_place(std::size_t n) const noexcept {
        Point p;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = lower_[k] + size_[k] * splines_[k].greville(n % counts_[k]);
            n /= counts_[k];
        }
        return p;
    }
    void start(LatticeRows& rows, std::size_t count) const {
        rows = {counts_, {}, {}};
        rows.first.reserve(count);
        rows.weights.reserve(count * LatticeRows::width);
    }
    void append(LatticeRows& rows, const Functions& f, const std::array<double, 4>& along_x,
                const std::array<double, 4>& along_y, const std::array<double, 4>& along_z) const {
        rows.first.push_back(std::uint32_t((f.first[2] * counts_[1] + f.first[1]) * counts_[0] + f.first[0]));
        for (const double z : along_z) {
            for (const double y : along_y) {
                for (const double x : along_x) rows.weights.push_back(x * (y * z));
            }
        }
    }

    std::array<LatticeAxis, 3> axes_;
    std::array<SplineAxis<double>, 3> splines_;
    std::array<std::size_t, 3> counts_{};
    Point lower_{}, size_{};
    double cell_ = 0;
    std::vector<Point> rest_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
