#pragma once

// A scene of splats made from a mesh.

#include "files/obj_file.hpp"
#include "splats/splat_file.hpp"

#include <cstddef>
#include <cstdint>

namespace cageform_support {

struct SurfaceSplatOptions {
    std::size_t count = 50000;
    std::size_t degree = 3; ///< of the harmonics, 0 to 3
    std::uint64_t seed = 1;
};

/// Spreads splats evenly by area over the faces of a mesh. Each lies flat on its face, a third wider than a
/// disc of its share of the area, with the face's normal; bands of colour show how the surface stretches. The
/// harmonics are a gloss: an eye sees it where the surface mirrors a light from above and the left.
///
///   mesh      with a face whose area is not 0
///   returns   the same scene for the same options, on all machines with the same mathematical functions
SplatFile splats_on(const ObjFile& mesh, const SurfaceSplatOptions& options);

/// The area of all faces.
double area_of(const ObjFile& mesh);

} // namespace cageform_support
