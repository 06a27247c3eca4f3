#pragma once

// The images of the puppet's materials, as PNG.

#include <string>

namespace cageform_programs {

std::string cloth_image(); ///< the shirt's stripes, 128 × 128 pixels
std::string face_image();  ///< skin with a mouth, 256 × 128 pixels, for the face_chart
std::string knit_image();  ///< normal map of the cap's ribs, 64 × 64 pixels

} // namespace cageform_programs
