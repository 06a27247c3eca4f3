#pragma once

// Pictures of splats, drawn without any graphics library.

#include "pictures/mesh_picture.hpp"
#include "splats/splat_file.hpp"

#include <cageform/parallel/running.hpp>

#include <cstddef>

namespace cageform_support {

/// Draws a scene beside the mesh that it was made from, if there is one, seen from the same place.
///
/// A splat becomes the Gaussian on the picture that its covariance has to first order about its middle
/// (Zwicker, Pfister, van Baar, Gross, EWA Splatting, IEEE TVCG 8, 2002, sec. 6.1.4), widened by 0.3 squared
/// pixels, as 3D Gaussian splatting does, out to three deviations. They cover each other from the nearest
/// middle to the farthest. The frame holds all middles.
///
///   mesh      null: the scene alone has all of the width
///   running   in bands of rows; the picture does not depend on it
Picture draw_splats(const SplatFile& scene, const MeshView* mesh, std::size_t width, std::size_t height,
                    const MeshSight& sight, const cageform::Running& running = {});

} // namespace cageform_support
