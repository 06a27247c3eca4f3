// The simplest cage in space: an axis-aligned box whose faces are divided into rectangles.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/cage/types/report.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// An axis-aligned box. Each face is divided into rectangles, and the rectangles' corners are the
/// vertices, numbered with the first axis fastest. Two divisions along each axis make 26 vertices.
/// Boundary data is bilinear within a rectangle.
///
/// `check` reports whether the box can serve as a cage. Memory and time are proportional to the
/// number of vertices.
template <Scalar T>
class Box {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    using Divisions = std::array<std::size_t, 3>; ///< along each axis; `check` refuses 0

    Box() = default;
    Box(const Vec<T, 3>& lower, const Vec<T, 3>& upper, const Divisions& divisions = {1, 1, 1})
        : lower_(lower)
        , upper_(upper)
        , divisions_(divisions)
        , status_(detail::guard_memory([&] { return fill(); })) {
        if (status_ != Status::ok) vertices_.clear();
    }

    /// Limits the vertices: binding stores one weight per vertex and point.
    static constexpr std::size_t most_vertices = std::size_t{1} << 24;

    /// Returns too_many_handles beyond `most_vertices` (found before any allocation) or
    /// out_of_memory. The box then has no vertices, and `check` reports the status. (Copying
    /// throws, as copying a std::vector does.)
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 3>> vertices() const noexcept { return vertices_; }
    const Vec<T, 3>& lower() const noexcept { return lower_; }
    const Vec<T, 3>& upper() const noexcept { return upper_; }
    const Divisions& divisions() const noexcept { return divisions_; }

    /// Returns the boundary data at a point on the upper or lower face across `axis`. `part` gives
    /// the point in fractions of the box's extents; its component along `axis` is ignored.
    BoundaryValue<3> on_face(std::size_t axis, bool upper, const Vec<double, 3>& part) const noexcept {
        std::array<std::size_t, 3> low{};
        std::array<double, 3> beyond{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (k == axis) {
                low[k] = upper ? divisions_[k] : 0;
                continue;
            }
            const double t = std::clamp(part[k], 0.0, 1.0) * double(divisions_[k]);
            low[k] = (std::min)(std::size_t(t), divisions_[k] - 1);
            beyond[k] = t - double(low[k]);
        }
        const auto [a, b] = detail::other_axes[axis];
        BoundaryValue<3> value;
        for (std::size_t n = 0; n < 4; ++n) {
            auto index = low;
            index[a] += n & 1u;
            index[b] += n >> 1;
            value.handle[n] = std::uint32_t(number_of(index));
            value.weight[n] =
                ((n & 1u) != 0 ? beyond[a] : 1 - beyond[a]) * ((n >> 1) != 0 ? beyond[b] : 1 - beyond[b]);
        }
        return value;
    }

    /// Calls f(triangle) with arrays of vertices. Each rectangle is cut into two triangles,
    /// counter-clockwise seen from outside.
    template <class F>
    void for_each_triangle(F&& f) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [a, b] = detail::other_axes[axis];
            for (const bool upper : {false, true}) {
                std::array<std::size_t, 3> low{};
                low[axis] = upper ? divisions_[axis] : 0;
                for (low[b] = 0; low[b] < divisions_[b]; ++low[b]) {
                    for (low[a] = 0; low[a] < divisions_[a]; ++low[a]) {
                        const auto corner = [&](std::size_t n) { // around the rectangle
                            auto index = low;
                            index[a] += n == 1 || n == 2 ? 1 : 0;
                            index[b] += n >= 2 ? 1 : 0;
                            return std::uint32_t(number_of(index));
                        };
                        const bool turned = upper == (axis == 1); // the axes a, b and `axis` form a
                                                                  // left-handed frame
                        f(std::array{corner(0), corner(turned ? 2 : 1), corner(turned ? 1 : 2)});
                        f(std::array{corner(0), corner(turned ? 3 : 2), corner(turned ? 2 : 3)});
                    }
                }
            }
        }
    }

    /// Returns the position of a point in fractions of the box's extents: 0 at the lower end, 1 at
    /// the upper.
    Vec<double, 3> parts(const Vec<double, 3>& p) const noexcept {
        Vec<double, 3> part;
        for (std::size_t k = 0; k < 3; ++k)
            part[k] = (p[k] - double(lower_[k])) / (double(upper_[k]) - double(lower_[k]));
        return part;
    }

private:
    Status fill() {
        const auto [a, b, c] = divisions_;
        if (a == 0 || b == 0 || c == 0) return Status::ok; // `check` refuses these
        const double x = double(a), y = double(b), z = double(c);
        if (2 * (x * y + y * z + z * x + 1) > double(most_vertices)) return Status::too_many_handles;
        std::array<std::size_t, 3> index{};
        for (index[2] = 0; index[2] <= c; ++index[2]) {
            for (index[1] = 0; index[1] <= b; ++index[1]) {
                const bool whole = index[2] == 0 || index[2] == c || index[1] == 0 || index[1] == b;
                const std::size_t step = whole ? 1 : a; // jump over the interior
                for (index[0] = 0; index[0] <= a; index[0] += step) vertices_.push_back(place(index));
            }
        }
        return Status::ok;
    }
    Vec<T, 3> place(const std::array<std::size_t, 3>& index) const noexcept {
        Vec<T, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            const double t = double(index[k]) / double(divisions_[k]);
            p[k] = static_cast<T>((1 - t) * double(lower_[k]) + t * double(upper_[k]));
        }
        return p;
    }
    /// Returns the number of the vertex with these lattice indices on the surface, by counting the
    /// vertices before it.
    std::size_t number_of(const std::array<std::size_t, 3>& index) const noexcept {
        const auto [a, b, c] = divisions_;
        const auto [i, j, k] = index;
        const std::size_t layer = (a + 1) * (b + 1), ring = 2 * (a + b);
        if (k == 0) return j * (a + 1) + i;
        const std::size_t before = layer + (k - 1) * ring;
        if (k == c) return before + j * (a + 1) + i;
        if (j == 0) return before + i;
        const std::size_t row = before + (a + 1) + 2 * (j - 1);
        return row + (j == b ? i : std::min<std::size_t>(i, 1));
    }

    Vec<T, 3> lower_{}, upper_{};
    Divisions divisions_{};
    std::vector<Vec<T, 3>> vertices_;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Calls f(triangle) with arrays of vertices.
template <Scalar T, class F>
void for_each_facet(const Box<T>& box, F&& f) {
    box.for_each_triangle(f);
}

// ---- inside -------------------------------------------------------------------------------------

/// Classifies a point. It is on the boundary if it lies within `tolerance` of it (pass the cage's
/// coincidence_tolerance).
template <Scalar T>
PointState locate(const Box<T>& box, const Vec<T, 3>& p, T tolerance) noexcept {
    if (!is_finite(p)) return PointState::not_finite;
    double least = (std::numeric_limits<double>::max)(); // distance to the nearest face, negative outside
    for (std::size_t k = 0; k < 3; ++k) {
        least = std::fmin(
            least, std::fmin(double(p[k]) - double(box.lower()[k]), double(box.upper()[k]) - double(p[k])));
    }
    if (std::fabs(least) <= double(tolerance)) return PointState::on_boundary;
    return least > 0 ? PointState::inside : PointState::outside;
}

/// Finds the boundary point nearest to a finite point; returns the boundary data there and stores
/// the point in `place`.
template <Scalar T>
BoundaryValue<3> nearest_boundary_value(const Box<T>& box, const Vec<T, 3>& p, Vec<T, 3>& place) noexcept {
    std::size_t axis = 0;
    bool upper = false, outside = false;
    double least = (std::numeric_limits<double>::max)();
    place = p;
    for (std::size_t k = 0; k < 3; ++k) {
        for (const bool up : {false, true}) {
            const double distance =
                up ? double(box.upper()[k]) - double(p[k]) : double(p[k]) - double(box.lower()[k]);
            if (distance < 0) {
                place[k] = up ? box.upper()[k] : box.lower()[k];
                outside = true;
            }
            if (distance >= least) continue;
            least = distance;
            axis = k;
            upper = up;
        }
    }
    if (!outside) place[axis] = upper ? box.upper()[axis] : box.lower()[axis];
    return box.on_face(axis, upper, box.parts(vec_cast<double>(place)));
}

// ---- check --------------------------------------------------------------------------------------

/// Whether a box can serve as a cage: its corners are finite, and along every axis it has divisions
/// longer than coincidence_tolerance.
template <Scalar T>
CageReport check(const Box<T>& box) {
    return detail::report_on(box.status(), [&](CageReport& report) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (box.divisions()[k] == 0) report.add(CageFaultKind::no_volume, k);
        }
        if (report.status != Status::ok) return;
        for (std::size_t i = 0; i < box.size(); ++i) {
            if (!is_finite(box.vertices()[i])) report.add(CageFaultKind::vertex_not_finite, i);
        }
        if (report.status != Status::ok) return;
        const double tolerance = coincidence_tolerance(bounds_of(box.vertices()));
        for (std::size_t k = 0; k < 3; ++k) {
            if (double(box.upper()[k]) - double(box.lower()[k]) <= tolerance * double(box.divisions()[k]))
                report.add(CageFaultKind::no_volume, k);
        }
    });
}

} // namespace cageform::inline CAGEFORM_ABI
