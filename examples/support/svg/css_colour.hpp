#pragma once

// Colours in SVG and CSS notation.

#include <optional>
#include <string_view>

namespace cageform_support {

struct Colour {
    float r = 0, g = 0, b = 0; // in [0, 1], sRGB
};

struct PaintColour {
    Colour colour;
    float alpha = 1;
};

/// Parses #rgb, #rgba, #rrggbb, #rrggbbaa, rgb() and rgba() of numbers or percentages, CSS colour names and
/// `transparent`. Returns nothing for other texts, such as `none`, url() and `currentColor`.
std::optional<PaintColour> parse_colour(std::string_view text);

/// Opacity of a CSS colour in any notation; 1 if the text has none.
double alpha_of(std::string_view text);

/// Conversion between sRGB values and linear light: IEC 61966-2-1.
double to_linear(double displayed);
double to_displayed(double linear);

} // namespace cageform_support
