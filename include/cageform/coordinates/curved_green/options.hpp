// Options of CurvedGreenCoordinates.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstddef>
#include <optional>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A disk in the plane.
template <Scalar T>
struct CurvedGreenDisk {
    Vec<T, 2> centre{};
    T radius = 0;
};

template <Scalar T>
struct CurvedGreenOptions {
    /// The posed degree, at most 5, of edges whose degree at rest is not higher.
    std::size_t posed_degree = 3;
    /// The posed degree of each edge. If empty, the larger of `posed_degree` and the degree at rest. If the
    /// number of entries is not that of the edges: fault curve_degree, with the number of entries as `a`.
    std::vector<std::size_t> posed_degrees{};
    /// Replaces the logarithm by Green's function of a disk that contains all control points. Poses are then
    /// harmonic in the disk, not holomorphic, and follow a round cage more closely.
    std::optional<CurvedGreenDisk<T>> disk{};
};

} // namespace cageform::inline CAGEFORM_ABI
