// Reports of folds: where a deformation turns space inside out.
#pragma once

#include <cageform/core/status.hpp>

#include <array>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

struct FoldOptions {
    /// A place is folded where the determinant of the deformation, the ratio of volumes, is not above this.
    /// Finite and below 1, the determinant at rest.
    double threshold = 0;
};

/// Folds at some points, or of some cells. Places are indices of points or of cells.
struct FoldReport {
    static constexpr std::size_t nowhere = static_cast<std::size_t>(-1);

    Status status = Status::ok;
    std::size_t culprit = nowhere; ///< the cell for which it was refused
    std::size_t count = 0;         ///< of folded places
    /// The first of the folded places, in the order of the binding or of the cells; `count` of them if there
    /// are fewer.
    std::array<std::size_t, 64> folded{};
    std::size_t skipped = 0;      ///< places where a number is not finite
    double least_determinant = 0; ///< 0 as all below, if there is no place
    std::size_t least_determinant_at = nowhere;
    double largest_stretch = 0; ///< the largest singular value
    std::size_t largest_stretch_at = nowhere;
    double least_stretch = 0; ///< the least singular value
    std::size_t least_stretch_at = nowhere;
};

/// How far a figure may go from one pose towards another.
struct StepReport {
    static constexpr std::size_t nowhere = FoldReport::nowhere;

    Status status = Status::ok;
    double step = 0;               ///< in [0, 1]: the pose `from + step (to - from)` has no fold
    std::size_t culprit = nowhere; ///< the place that stops it, or for which it was refused
};

} // namespace cageform::inline CAGEFORM_ABI
