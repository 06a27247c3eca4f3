// Options of coordinates of curved cages.
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
    /// The degree in poses of all edges that are of no higher degree at rest, up to 5.
    std::size_t posed_degree = 3;
    /// The degree of each edge in poses, in the order of the edges; empty: `posed_degree`, or the degree at
    /// rest if that is higher. Another number of them is the fault curve_degree, `a` that number.
    std::vector<std::size_t> posed_degrees{};
    /// Replaces the logarithm by Green's function of a disk that contains all control points: the map of a
    /// pose is then harmonic in the disk instead of holomorphic, and follows a round cage more closely.
    std::optional<CurvedGreenDisk<T>> disk{};
};

} // namespace cageform::inline CAGEFORM_ABI
