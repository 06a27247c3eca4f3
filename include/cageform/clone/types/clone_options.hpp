// The options of a clone.
#pragma once

#include <cageform/core/view.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// The points to which a clone adds its displacements.
enum class CloneOnto : std::uint8_t {
    rest, ///< the bound points
    /// The points in the output, so that clones by several bindings of the same points add up.
    output,
};

template <Scalar T>
struct CloneOptions {
    /// A factor of each point's displacement; empty: no mask. May be part of a vertex buffer.
    StridedPoints<const T, 1> mask{nullptr, 0};
    CloneOnto onto = CloneOnto::rest;
};

} // namespace cageform::inline CAGEFORM_ABI
