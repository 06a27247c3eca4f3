#pragma once

// Software renderer of splats.

#include "pictures/mesh_picture.hpp"
#include "splats/splat_file.hpp"

#include <cageform/parallel/running.hpp>

#include <cstddef>

namespace cageform_support {

/// Draws a scene, optionally beside a mesh from the same view.
///
/// A splat is projected to first order about its centre (Zwicker, Pfister, van Baar, Gross, EWA Splatting,
/// IEEE TVCG 8, 2002, section 6.1.4). As in 3D Gaussian splatting, 0.3 squared pixels are added to its
/// variance; splats are blended from the nearest centre to the farthest. The frame contains all centres.
///
///   mesh      null: the scene has the full width
///   running   in bands of rows; does not affect the result
Picture draw_splats(const SplatFile& scene, const MeshView* mesh, std::size_t width, std::size_t height,
                    const ViewAngles& sight, const cageform::Running& running = {});

} // namespace cageform_support
