#pragma once

// A region of one picture in another without a seam: the source's colours plus a smooth function. On the
// region's outline that function is the difference of the target to the source. It is a membrane
// (pictures/membrane.hpp), or it solves the Poisson equation (Pérez, Gangnet, Blake, Poisson image editing,
// ACM Trans. Graph. 22(3) (2003), sec. 2), which cageform::solve_dirichlet does.

#include "pictures/membrane.hpp"

#include <cageform/parallel/running.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Where the upper left corner of a region's box goes in a target.
struct PixelPlace {
    std::int64_t x = 0, y = 0;
};

/// Why a region does not fit into a target there: how far it reaches beyond, and which places fit. Empty
/// where it fits.
std::string fault_of_place(const PixelRegion& region, const Pixels& target, const PixelPlace& at);

/// The colours of the target less those of the source, 0 to 255, at the pixels of the outline.
///
///   at   a place where the region fits, here and below
std::vector<Membrane::Values> outline_differences(const Pixels& source, const PixelRegion& region,
                                                  const Pixels& target, const PixelPlace& at);

/// The discrete harmonic function with these values on the outline.
///
///   returns   of each pixel of the region's box; 0 outside the region
///   fails     as cageform::solve_dirichlet does
Expected<std::vector<Membrane::Values>> poisson_function(const PixelRegion& region,
                                                         std::span<const Membrane::Values> outline,
                                                         const cageform::Running& running = {});

/// Puts a region into a picture: the colours of the source inside, plus `added`. Pixels of the outline stay
/// as they are, and so does alpha. Where the source is translucent, what is there shines through.
///
///   picture   the target, or a copy of it
///   added     of each pixel of the region's box, or a membrane with the outline's differences
void paste(const Pixels& source, const PixelRegion& region, const PixelPlace& at,
           std::span<const Membrane::Values> added, Pixels& picture);
void paste(const Pixels& source, const PixelRegion& region, const PixelPlace& at,
           std::span<const Membrane::Values> differences, Membrane& membrane, Pixels& picture);

/// How far two pictures of one size are apart inside a region, of 255 a channel.
struct ColourDifference {
    int largest = 0;
    double mean = 0;
};
ColourDifference colour_difference(const Pixels& a, const Pixels& b, const PixelRegion& region,
                                   const PixelPlace& at);

} // namespace cageform_support
