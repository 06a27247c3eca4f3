// Options and reports of folds: places where a deformation inverts space.
#pragma once

#include <cageform/core/status.hpp>

#include <array>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

struct FoldOptions {
    /// A place is folded if the determinant of the deformation (volume over volume at rest) is not above this
    /// value. Must be finite and below 1.
    double threshold = 0;
};

/// Folds at points or of cells. A place is the index of a point or cell.
struct FoldReport {
    static constexpr std::size_t nowhere = static_cast<std::size_t>(-1);

    Status status = Status::ok;
    std::size_t culprit = nowhere; ///< the cell that caused the status
    std::size_t count = 0;         ///< number of folded places
    /// The first folded places in the order of the binding or the cells: min(count, 64) entries.
    std::array<std::size_t, 64> folded{};
    std::size_t skipped = 0;      ///< number of places with a number that is not finite
    double least_determinant = 0; ///< 0 if there are no places, like all members below
    std::size_t least_determinant_at = nowhere;
    double largest_stretch = 0; ///< the largest singular value
    std::size_t largest_stretch_at = nowhere;
    double least_stretch = 0; ///< the least singular value
    std::size_t least_stretch_at = nowhere;
};

/// The largest step from one pose towards another without a fold.
struct StepReport {
    static constexpr std::size_t nowhere = FoldReport::nowhere;

    Status status = Status::ok;
    double step = 0;               ///< in [0, 1]: the pose `from + step (to - from)` has no fold
    std::size_t culprit = nowhere; ///< the place that limits the step, or that caused the status
};

} // namespace cageform::inline CAGEFORM_ABI
