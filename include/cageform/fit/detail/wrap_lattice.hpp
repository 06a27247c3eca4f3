// The lattice of a wrap: weights of points as blocks of 4 × 4 × 4 numbers, and the normal equations.
#pragma once

#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/lattice/refine.hpp>
#include <cageform/pose/detail/stretches.hpp>

#include <Eigen/SparseCholesky>

namespace cageform::inline CAGEFORM_ABI::detail {

using Point = Vec<double, 3>;

/// Returns the inverse of the linear part of a map; its columns must be linearly independent.
template <Scalar T>
LinearMap<double, 3> inverse_columns(const Transform<T, 3>& of) noexcept {
    std::array<Point, 3> column;
    for (std::size_t k = 0; k < 3; ++k) column[k] = vec_cast<double>(of.columns[k]);
    const double over = 1 / dot(column[0], cross(column[1], column[2]));
    LinearMap<double, 3> to;
    for (std::size_t k = 0; k < 3; ++k) {
        const Point row = over * cross(column[(k + 1) % 3], column[(k + 2) % 3]);
        for (std::size_t c = 0; c < 3; ++c) to.at[k][c] = row[c];
    }
    return to;
}
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

/// A symmetric matrix over some handles of a lattice. Handles couple if they are at most `reach` apart along
/// each axis.
///
///   memory  729 numbers per unknown
class LatticeMatrix {
    static constexpr std::size_t reach = 4, side = 2 * reach + 1, stencil = side * side * side;

public:
    /// Makes a zero matrix. Throws std::bad_alloc.
    ///
    ///   unknowns  handles, ascending
    LatticeMatrix(const std::array<std::size_t, 3>& counts, const std::vector<std::uint32_t>& unknowns)
        : counts_(counts)
        , unknowns_(unknowns)
        , slot_(counts[0] * counts[1] * counts[2], no_slot)
        , entries_(unknowns.size() * stencil) {
        for (std::size_t n = 0; n < unknowns.size(); ++n) slot_[unknowns[n]] = std::uint32_t(n);
    }

    /// Adds weight · (row a)ᵀ (row b). Rows whose cells are more than one apart along an axis do not couple.
    void add_product(const LatticeRows& rows, std::size_t a, std::size_t b, double weight) noexcept {
        if (!are_near(rows.first[a], rows.first[b])) return;
        const std::size_t base = centre + offset(rows.first[a], rows.first[b]);
        const double *of_a = rows.weights.data() + a * LatticeRows::width,
                     *of_b = rows.weights.data() + b * LatticeRows::width;
        for (std::size_t m = 0; m < LatticeRows::width; ++m) {
            const std::size_t x = m % 4, y = m / 4 % 4, z = m / 16;
            const std::size_t handle = rows.first[a] + (z * counts_[1] + y) * counts_[0] + x;
            if (slot_[handle] == no_slot) continue;
            double* const to = &entries_[slot_[handle] * stencil + base - (z * side + y) * side - x];
            const double factor = weight * of_a[m];
            for (std::size_t run = 0; run < 16; ++run) {
                double* const at = to + (run / 4 * side + run % 4) * side;
                for (std::size_t n = 0; n < 4; ++n) at[n] += factor * of_b[4 * run + n];
            }
        }
    }
    /// Handle i must be an unknown.
    void add_entry(std::size_t i, std::size_t j, double x) noexcept {
        entries_[slot_[i] * stencil + centre + offset(i, j)] += x;
    }
    double trace() const noexcept {
        double sum = 0;
        for (std::size_t n = 0; n < unknowns_.size(); ++n) sum += entries_[n * stencil + centre];
        return sum;
    }
    /// Sets the matrix to a + factor · b. All have the same unknowns.
    void set_sum(const LatticeMatrix& a, double factor, const LatticeMatrix& b) noexcept {
        for (std::size_t n = 0; n < entries_.size(); ++n)
            entries_[n] = a.entries_[n] + factor * b.entries_[n];
    }
    void clear() noexcept { std::fill(entries_.begin(), entries_.end(), 0); }

    /// Subtracts the products with handles that are not unknowns from the right-hand sides (#handles).
    void subtract_fixed(const std::vector<Point>& pose, std::vector<Point>& right) const noexcept {
        if (unknowns_.size() == slot_.size()) return;
        for (std::size_t n = 0; n < unknowns_.size(); ++n) {
            for (std::size_t at = 0; at < stencil; ++at) {
                const double entry = entries_[n * stencil + at];
                if (entry == 0) continue;
                const auto j = std::size_t(std::ptrdiff_t(unknowns_[n]) + displacement(at));
                if (slot_[j] == no_slot) right[unknowns_[n]] = right[unknowns_[n]] - entry * pose[j];
            }
        }
    }

    /// Returns the lower triangle. Throws std::bad_alloc.
    Eigen::SparseMatrix<double> lower() const {
        const auto size = Eigen::Index(unknowns_.size());
        Eigen::SparseMatrix<double> lower(size, size);
        lower.reserve(size * 172);
        for (std::size_t n = 0; n < unknowns_.size(); ++n) {
            lower.startVec(Eigen::Index(n));
            const double* entry = &entries_[n * stencil];
            for (std::size_t at = 0; at < stencil; ++at, ++entry) {
                if (*entry == 0) continue;
                const std::uint32_t row = slot_[std::size_t(std::ptrdiff_t(unknowns_[n]) + displacement(at))];
                if (row >= n && row != no_slot) lower.insertBack(Eigen::Index(row), Eigen::Index(n)) = *entry;
            }
        }
        lower.finalize();
        return lower;
    }

private:
    static constexpr std::size_t centre = (reach * side + reach) * side + reach;
    static constexpr std::uint32_t no_slot = ~std::uint32_t{0};

    std::array<std::size_t, 3> place(std::size_t i) const noexcept {
        return {i % counts_[0], i / counts_[0] % counts_[1], i / counts_[0] / counts_[1]};
    }
    bool are_near(std::size_t i, std::size_t j) const noexcept {
        const auto a = place(i), b = place(j);
        bool near_all = true;
        for (std::size_t k = 0; k < 3; ++k) near_all = near_all && a[k] <= b[k] + 1 && b[k] <= a[k] + 1;
        return near_all;
    }
    /// Returns the offset in the stencil from handle i to handle j, modulo the size of std::size_t.
    std::size_t offset(std::size_t i, std::size_t j) const noexcept {
        const auto a = place(i), b = place(j);
        return ((b[2] - a[2]) * side + b[1] - a[1]) * side + b[0] - a[0];
    }
    /// Returns the number of handles from the centre of a stencil to one of its entries.
    std::ptrdiff_t displacement(std::size_t at) const noexcept {
        const auto nx = std::ptrdiff_t(counts_[0]), ny = std::ptrdiff_t(counts_[1]);
        constexpr auto r = std::ptrdiff_t(reach), s = std::ptrdiff_t(side);
        const auto n = std::ptrdiff_t(at);
        return ((n / (s * s) - r) * ny + n / s % s - r) * nx + n % s - r;
    }

    std::array<std::size_t, 3> counts_;
    std::vector<std::uint32_t> unknowns_, slot_; ///< `slot_`: #handles, the index among the unknowns
    std::vector<double> entries_; ///< #unknowns · 729: by handle i, the entries (i, j) by the offset of j
};

/// The Cholesky factors of a LatticeMatrix.
class LatticeFactors {
public:
    /// Returns whether the matrix is positive definite. Throws std::bad_alloc.
    bool factor(const LatticeMatrix& matrix) {
        const Eigen::SparseMatrix<double> lower = matrix.lower();
        if (lower.nonZeros() != entries_) factors_.analyzePattern(lower);
        entries_ = lower.nonZeros();
        factors_.factorize(lower);
        return factors_.info() == Eigen::Success;
    }
    /// Replaces the right-hand sides of the unknowns by the solution.
    void solve(std::vector<Point>& x) const {
        using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>;
        Rows right(x.data()->v, Eigen::Index(x.size()), 3);
        right = factors_.solve(Eigen::MatrixX3d(right));
    }

private:
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factors_;
    Eigen::Index entries_ = -1; ///< number of entries of the last matrix
};

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
    LatticeMatrix matrix(const std::vector<std::uint32_t>& unknowns) const { return {counts_, unknowns}; }

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
    void add_ridge(LatticeMatrix& matrix, const std::vector<char>& is_unknown, double factor) const noexcept {
        std::size_t stride = 1;
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t n = 0; n < size(); ++n) {
                const std::size_t i = n / stride % counts_[k];
                if (i + 2 >= counts_[k] || !is_unknown[n] || !is_unknown[n + stride] ||
                    !is_unknown[n + 2 * stride])
                    continue;
                const double scale = size_[k] / cell_; // in cells
                const double a = scale * (splines_[k].greville(i + 1) - splines_[k].greville(i)),
                             b = scale * (splines_[k].greville(i + 2) - splines_[k].greville(i + 1));
                const double of[3] = {2 / (a * (a + b)), -2 / (a * b), 2 / (b * (a + b))};
                for (std::size_t r = 0; r < 3; ++r) {
                    for (std::size_t c = 0; c < 3; ++c)
                        matrix.add_entry(n + r * stride, n + c * stride, factor * of[r] * of[c]);
                }
            }
            stride *= counts_[k];
        }
    }

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
