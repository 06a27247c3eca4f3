#pragma once

// Seamless cloning of a region into another picture: the source's colours plus a smooth function that equals
// the difference of target and source on the region's outline. The function is a membrane
// (pictures/membrane.hpp), or the solution of the Poisson equation (Pérez, Gangnet, Blake, Poisson image
// editing, ACM Trans. Graph. 22(3) (2003), section 2) by cageform::solve_dirichlet.

#include "pictures/membrane.hpp"

#include <cageform/parallel/running.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Position of a region's upper left corner in a target.
struct PixelPlace {
    std::int64_t x = 0, y = 0;
};

/// Returns the error if a region does not fit into a target at a position: how far it extends beyond, and
/// which positions fit. Else empty.
std::string fault_of_place(const PixelRegion& region, const Pixels& target, const PixelPlace& at);

/// Colours of the target minus those of the source, 0 to 255, at the pixels of the outline.
///
///   at   position at which the region fits, here and below
std::vector<Membrane::Values> outline_differences(const Pixels& source, const PixelRegion& region,
                                                  const Pixels& target, const PixelPlace& at);

/// The discrete harmonic function with given values on the outline.
///
///   returns   one value per pixel of the region's box; 0 outside the region
///   fails     as cageform::solve_dirichlet
Expected<std::vector<Membrane::Values>> poisson_function(const PixelRegion& region,
                                                         std::span<const Membrane::Values> outline,
                                                         const cageform::Running& running = {});

/// Writes a region into a picture: the colours of the source plus `added`. Pixels of the outline and alpha
/// are unchanged. Translucent source pixels are blended.
///
///   picture   the target, or a copy of it
///   added     per pixel of the region's box, or a membrane with the differences on the outline
void paste(const Pixels& source, const PixelRegion& region, const PixelPlace& at,
           std::span<const Membrane::Values> added, Pixels& picture);
void paste(const Pixels& source, const PixelRegion& region, const PixelPlace& at,
           std::span<const Membrane::Values> differences, Membrane& membrane, Pixels& picture);

/// Difference of two pictures of equal size inside a region, 0 to 255 per channel.
struct ColourDifference {
    int largest = 0;
    double mean = 0;
};
ColourDifference colour_difference(const Pixels& a, const Pixels& b, const PixelRegion& region,
                                   const PixelPlace& at);

} // namespace cageform_support
