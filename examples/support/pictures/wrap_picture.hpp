#pragma once

// Pictures of a source that is wrapped onto a target.

#include "pictures/mesh_picture.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform_support {

/// A mesh, points or bones that follow a source.
struct WrapFollower {
    std::span<const Point3> places; ///< on the target
    std::span<const std::array<std::uint32_t, 3>> triangles;
    std::span<const std::array<std::size_t, 2>> segments; ///< drawn as lines; indices of places
};

struct WrapScene {
    MeshView source, target, wrapped;
    std::span<const double> distances; ///< of the wrapped vertices from the target, in percent of its height
    double most = 1;                   ///< the distance of the darkest colour
    std::vector<WrapFollower> followers;
};

/// Returns a round number at which most distances are below: the 95th percentile, rounded up to a digit 1, 2
/// or 5.
double scale_of_distances(std::span<const double> distances);

/// Draws side by side: the source; and with one camera the target, the wrapped source, the followers on the
/// target if there are any, and the distances in colours with a scale. Points without triangles and segments
/// become crosses.
Picture draw_wrap(const WrapScene& scene, const ViewAngles& sight);

} // namespace cageform_support
