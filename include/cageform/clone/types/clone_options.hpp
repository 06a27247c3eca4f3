// The options of a clone.
#pragma once

#include <cageform/core/view.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// What a clone does with the previous points of the output.
enum class CloneMode : std::uint8_t {
    replace, ///< overwrites them with the moved points
    add,     ///< adds displacements to them, so that clones by several bindings of the same points add up
};

template <Scalar T>
struct CloneOptions {
    /// #points factors of the points' displacements; empty: no mask. May be part of a vertex buffer.
    StridedPoints<const T, 1> mask{nullptr, 0};
    CloneMode mode = CloneMode::replace;
};

} // namespace cageform::inline CAGEFORM_ABI
