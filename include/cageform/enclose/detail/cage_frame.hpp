// The local coordinates in which make_cage computes, and its checks of options, in the plane and in space.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>

#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Maps to coordinates in which the diagonal of the figure's bounds lies between 1/2 and 1 and the
/// mirror at x = 0.
template <std::size_t D>
struct CageFrame {
    using Point = Vec<double, D>;
    Point origin{};
    double scale = 1;     ///< a power of two, so that scaling is exact
    std::size_t axis = 0; ///< the mirror's axis, swapped with the first one

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
    /// Whether the map reverses orientation: counter-clockwise becomes clockwise.
    bool reverses_orientation() const noexcept { return axis != 0; }
};

/// The largest coordinate of a figure; areas or volumes of larger figures overflow.
template <Scalar T, std::size_t D>
constexpr T largest_figure_coordinate() noexcept {
    return T((std::min)(double((std::numeric_limits<T>::max)()) / 64, D == 2 ? 1e150 : 1e100));
}

/// The least diagonal of a figure's bounds; areas or volumes of smaller figures underflow.
template <std::size_t D>
constexpr double least_figure_diagonal() noexcept {
    return D == 2 ? 0 : 1e-100;
}

/// Whether coordinates of type T can resolve the margin. Far from 0 their spacing may be too coarse.
template <Scalar T, std::size_t D>
bool can_tell(double margin, const Bounds<double, D>& box) noexcept {
    double farthest = 0;
    for (std::size_t k = 0; k < D; ++k)
        farthest = (std::max)({farthest, std::fabs(box.lower[k]), std::fabs(box.upper[k])});
    return margin > 4 * double(std::numeric_limits<T>::epsilon()) * farthest;
}

/// Whether the cage in the report keeps the promises of make_cage.
inline bool holds_figure(const MakeCageReport& report) noexcept {
    return report.cage.status == Status::ok && report.clearance >= 0.9 * report.margin;
}

/// Checks the options for D dimensions.
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
