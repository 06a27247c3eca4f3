#pragma once

// Colours as SVG and CSS write them.

#include <optional>
#include <string_view>

namespace cageform_support {

struct Colour {
    float r = 0, g = 0, b = 0; // in [0, 1], as displayed
};

struct PaintColour {
    Colour colour; // as displayed
    float alpha = 1;
};

/// #rgb, #rgba, #rrggbb, #rrggbbaa, rgb() and rgba() of numbers or percentages, the names of CSS,
/// transparent. Nothing where the text is none of these: `none`, a gradient, `currentColor`.
std::optional<PaintColour> parse_colour(std::string_view text);

/// The opacity of a colour in any notation of CSS; 1 where the text gives none.
double alpha_of(std::string_view text);

/// Light, in proportion to its energy, from what a display is sent, and back: IEC 61966-2-1 (sRGB).
double to_linear(double displayed);
double to_displayed(double linear);

} // namespace cageform_support
