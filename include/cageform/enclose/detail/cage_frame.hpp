// Local coordinates of make_cage and checks of its options, 2D and 3D.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>

#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Maps the figure to coordinates in which its diagonal lies between 1/2 and 1 and the mirror plane is x = 0.
template <std::size_t D>
struct CageFrame {
    using Point = Vec<double, D>;
    Point origin{};
    double scale = 1;     ///< power of two, so scaling is exact
    std::size_t axis = 0; ///< axis of the mirror, swapped with the first

    CageFrame() = default;
    CageFrame(const Bounds<double, D>& box, const std::optional<MirrorPlane>& mirror) noexcept
        : origin(0.5 * (box.lower + box.upper))
        , scale(unit_scale(box)) {
        if (!mirror) return;
        axis = mirror->axis;
        origin[axis] = mirror->position.value_or(origin[axis]);
    }

    Point to_local(const Point& p) const noexcept {
        Point q = scale * (p - origin);
        std::swap(q[0], q[axis]);
        return q;
    }
    Point from_local(Point q) const noexcept {
        std::swap(q[0], q[axis]);
        return origin + (1 / scale) * q;
    }
    /// True if the map turns counter-clockwise into clockwise.
    bool reverses_orientation() const noexcept { return axis != 0; }
};

/// Largest valid coordinate; areas or volumes of larger figures overflow.
template <Scalar T, std::size_t D>
constexpr T largest_figure_coordinate() noexcept {
    return T((std::min)(double((std::numeric_limits<T>::max)()) / 64, D == 2 ? 1e150 : 1e100));
}

/// Smallest valid diagonal; areas or volumes of smaller figures underflow.
template <std::size_t D>
constexpr double least_figure_diagonal() noexcept {
    return D == 2 ? 0 : 1e-100;
}

/// True if coordinates of type T resolve the margin. Far from the origin their spacing may be too coarse.
template <Scalar T, std::size_t D>
bool resolves_margin(double margin, const Bounds<double, D>& box) noexcept {
    double farthest = 0;
    for (std::size_t k = 0; k < D; ++k)
        farthest = (std::max)({farthest, std::fabs(box.lower[k]), std::fabs(box.upper[k])});
    return margin > 4 * double(std::numeric_limits<T>::epsilon()) * farthest;
}

/// True if the cage meets the guarantees of make_cage.
inline bool meets_guarantees(const MakeCageReport& report) noexcept {
    return report.cage.status == Status::ok && report.clearance >= 0.9 * report.margin;
}

template <std::size_t D>
Status check_options(const MakeCageOptions& options) noexcept {
    if (options.vertices != 0 && options.vertices <= D) return Status::too_few_cage_vertices;
    if (!is_finite(options.margin) || options.margin < 0) return Status::margin_not_positive;
    if (!options.mirror) return Status::ok;
    const auto& position = options.mirror->position;
    return options.mirror->axis >= D || (position && !is_finite(*position)) ? Status::mirror_not_supported
                                                                            : Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
