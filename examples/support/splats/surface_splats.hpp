#pragma once

// Converts a mesh to a scene of splats.

#include "files/mesh_file.hpp"
#include "splats/splat_file.hpp"

#include <cstddef>
#include <cstdint>

namespace cageform_support {

struct SurfaceSplatOptions {
    std::size_t count = 50000;
    std::size_t degree = 3; ///< of the harmonics, 0 to 3
    std::uint64_t seed = 1;
};

/// Distributes splats evenly over the faces of a mesh. Each is flat on its face; its standard deviation is
/// 1.3 times the radius of a disk with its share of the area. Bands of colour make stretching visible. The
/// harmonics add gloss: a reflection of a light from above and the left.
///
///   mesh      with positive area
///   returns   the same scene for the same options, on all machines with the same mathematical library
SplatFile splats_on(const MeshFile& mesh, const SurfaceSplatOptions& options);

/// The area of all faces.
double area_of(const MeshFile& mesh);

} // namespace cageform_support
