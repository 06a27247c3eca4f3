#include "svg/css_colour.hpp"

#include "svg/path.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>

namespace cageform_examples {

namespace detail {

struct NamedColour {
    std::string_view name;
    std::uint32_t rgb;
};

/// CSS Color Module Level 4, sec. 6.1; sorted.
constexpr NamedColour colour_names[] = {{"aliceblue", 0xf0f8ff},
                                        {"antiquewhite", 0xfaebd7},
                                        {"aqua", 0x00ffff},
                                        {"aquamarine", 0x7fffd4},
                                        {"azure", 0xf0ffff},
                                        {"beige", 0xf5f5dc},
                                        {"bisque", 0xffe4c4},
                                        {"black", 0x000000},
                                        {"blanchedalmond", 0xffebcd},
                                        {"blue", 0x0000ff},
                                        {"blueviolet", 0x8a2be2},
                                        {"brown", 0xa52a2a},
                                        {"burlywood", 0xdeb887},
                                        {"cadetblue", 0x5f9ea0},
                                        {"chartreuse", 0x7fff00},
                                        {"chocolate", 0xd2691e},
                                        {"coral", 0xff7f50},
                                        {"cornflowerblue", 0x6495ed},
                                        {"cornsilk", 0xfff8dc},
                                        {"crimson", 0xdc143c},
                                        {"cyan", 0x00ffff},
                                        {"darkblue", 0x00008b},
                                        {"darkcyan", 0x008b8b},
                                        {"darkgoldenrod", 0xb8860b},
                                        {"darkgray", 0xa9a9a9},
                                        {"darkgreen", 0x006400},
                                        {"darkgrey", 0xa9a9a9},
                                        {"darkkhaki", 0xbdb76b},
                                        {"darkmagenta", 0x8b008b},
                                        {"darkolivegreen", 0x556b2f},
                                        {"darkorange", 0xff8c00},
                                        {"darkorchid", 0x9932cc},
                                        {"darkred", 0x8b0000},
                                        {"darksalmon", 0xe9967a},
                                        {"darkseagreen", 0x8fbc8f},
                                        {"darkslateblue", 0x483d8b},
                                        {"darkslategray", 0x2f4f4f},
                                        {"darkslategrey", 0x2f4f4f},
                                        {"darkturquoise", 0x00ced1},
                                        {"darkviolet", 0x9400d3},
                                        {"deeppink", 0xff1493},
                                        {"deepskyblue", 0x00bfff},
                                        {"dimgray", 0x696969},
                                        {"dimgrey", 0x696969},
                                        {"dodgerblue", 0x1e90ff},
                                        {"firebrick", 0xb22222},
                                        {"floralwhite", 0xfffaf0},
                                        {"forestgreen", 0x228b22},
                                        {"fuchsia", 0xff00ff},
                                        {"gainsboro", 0xdcdcdc},
                                        {"ghostwhite", 0xf8f8ff},
                                        {"gold", 0xffd700},
                                        {"goldenrod", 0xdaa520},
                                        {"gray", 0x808080},
                                        {"green", 0x008000},
                                        {"greenyellow", 0xadff2f},
                                        {"grey", 0x808080},
                                        {"honeydew", 0xf0fff0},
                                        {"hotpink", 0xff69b4},
                                        {"indianred", 0xcd5c5c},
                                        {"indigo", 0x4b0082},
                                        {"ivory", 0xfffff0},
                                        {"khaki", 0xf0e68c},
                                        {"lavender", 0xe6e6fa},
                                        {"lavenderblush", 0xfff0f5},
                                        {"lawngreen", 0x7cfc00},
                                        {"lemonchiffon", 0xfffacd},
                                        {"lightblue", 0xadd8e6},
                                        {"lightcoral", 0xf08080},
                                        {"lightcyan", 0xe0ffff},
                                        {"lightgoldenrodyellow", 0xfafad2},
                                        {"lightgray", 0xd3d3d3},
                                        {"lightgreen", 0x90ee90},
                                        {"lightgrey", 0xd3d3d3},
                                        {"lightpink", 0xffb6c1},
                                        {"lightsalmon", 0xffa07a},
                                        {"lightseagreen", 0x20b2aa},
                                        {"lightskyblue", 0x87cefa},
                                        {"lightslategray", 0x778899},
                                        {"lightslategrey", 0x778899},
                                        {"lightsteelblue", 0xb0c4de},
                                        {"lightyellow", 0xffffe0},
                                        {"lime", 0x00ff00},
                                        {"limegreen", 0x32cd32},
                                        {"linen", 0xfaf0e6},
                                        {"magenta", 0xff00ff},
                                        {"maroon", 0x800000},
                                        {"mediumaquamarine", 0x66cdaa},
                                        {"mediumblue", 0x0000cd},
                                        {"mediumorchid", 0xba55d3},
                                        {"mediumpurple", 0x9370db},
                                        {"mediumseagreen", 0x3cb371},
                                        {"mediumslateblue", 0x7b68ee},
                                        {"mediumspringgreen", 0x00fa9a},
                                        {"mediumturquoise", 0x48d1cc},
                                        {"mediumvioletred", 0xc71585},
                                        {"midnightblue", 0x191970},
                                        {"mintcream", 0xf5fffa},
                                        {"mistyrose", 0xffe4e1},
                                        {"moccasin", 0xffe4b5},
                                        {"navajowhite", 0xffdead},
                                        {"navy", 0x000080},
                                        {"oldlace", 0xfdf5e6},
                                        {"olive", 0x808000},
                                        {"olivedrab", 0x6b8e23},
                                        {"orange", 0xffa500},
                                        {"orangered", 0xff4500},
                                        {"orchid", 0xda70d6},
                                        {"palegoldenrod", 0xeee8aa},
                                        {"palegreen", 0x98fb98},
                                        {"paleturquoise", 0xafeeee},
                                        {"palevioletred", 0xdb7093},
                                        {"papayawhip", 0xffefd5},
                                        {"peachpuff", 0xffdab9},
                                        {"peru", 0xcd853f},
                                        {"pink", 0xffc0cb},
                                        {"plum", 0xdda0dd},
                                        {"powderblue", 0xb0e0e6},
                                        {"purple", 0x800080},
                                        {"rebeccapurple", 0x663399},
                                        {"red", 0xff0000},
                                        {"rosybrown", 0xbc8f8f},
                                        {"royalblue", 0x4169e1},
                                        {"saddlebrown", 0x8b4513},
                                        {"salmon", 0xfa8072},
                                        {"sandybrown", 0xf4a460},
                                        {"seagreen", 0x2e8b57},
                                        {"seashell", 0xfff5ee},
                                        {"sienna", 0xa0522d},
                                        {"silver", 0xc0c0c0},
                                        {"skyblue", 0x87ceeb},
                                        {"slateblue", 0x6a5acd},
                                        {"slategray", 0x708090},
                                        {"slategrey", 0x708090},
                                        {"snow", 0xfffafa},
                                        {"springgreen", 0x00ff7f},
                                        {"steelblue", 0x4682b4},
                                        {"tan", 0xd2b48c},
                                        {"teal", 0x008080},
                                        {"thistle", 0xd8bfd8},
                                        {"tomato", 0xff6347},
                                        {"turquoise", 0x40e0d0},
                                        {"violet", 0xee82ee},
                                        {"wheat", 0xf5deb3},
                                        {"white", 0xffffff},
                                        {"whitesmoke", 0xf5f5f5},
                                        {"yellow", 0xffff00},
                                        {"yellowgreen", 0x9acd32}};

PaintColour of_bytes(std::uint32_t rgb, std::uint32_t alpha) {
    const auto channel = [&](int shift) { return float((rgb >> shift) & 255u) / 255.0f; };
    return {{channel(16), channel(8), channel(0)}, float(alpha) / 255.0f};
}

std::optional<PaintColour> of_hex(std::string_view digits) {
    std::uint32_t number = 0;
    const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), number, 16);
    if (fault != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    std::array<std::uint32_t, 4> channel{0, 0, 0, 255};
    const bool is_short = digits.size() < 6;
    const std::size_t count = is_short ? digits.size() : digits.size() / 2;
    if (count < 3 || count > 4 || (!is_short && digits.size() % 2 != 0)) return std::nullopt;
    for (std::size_t k = count; k-- > 0; number >>= is_short ? 4 : 8)
        channel[k] = is_short ? 17 * (number & 15u) : number & 255u;
    return of_bytes(channel[0] << 16 | channel[1] << 8 | channel[2], channel[3]);
}

/// Reads the arguments of rgb() or rgba().
std::optional<PaintColour> of_numbers(std::string text) {
    std::array<double, 4> value{0, 0, 0, 1};
    std::size_t count = 0;
    for (char& c : text) {
        if (c == ',' || c == '/') c = ' ';
    }
    for (std::size_t at = 0; (at = text.find_first_not_of(" \t\r\n", at)) != std::string::npos; ++count) {
        if (count == 4) return std::nullopt;
        const std::size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
        const bool percent = text[end - 1] == '%';
        const char* const last = text.data() + end - (percent ? 1 : 0);
        const auto [stop, fault] = std::from_chars(text.data() + at, last, value[count]);
        if (fault != std::errc() || stop != last || !std::isfinite(value[count])) return std::nullopt;
        value[count] = std::clamp(value[count] / (percent ? 100 : count < 3 ? 255 : 1), 0.0, 1.0);
        at = end;
    }
    if (count < 3) return std::nullopt;
    return PaintColour{{float(value[0]), float(value[1]), float(value[2])}, float(value[3])};
}

} // namespace detail

std::optional<PaintColour> parse_colour(std::string_view text) {
    std::string word(detail::trimmed(text));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : char(c); });
    if (word.empty()) return std::nullopt;
    if (word[0] == '#') return detail::of_hex(std::string_view(word).substr(1));
    const std::size_t open = word.find('(');
    if (open != std::string::npos) {
        if ((word.substr(0, open) != "rgb" && word.substr(0, open) != "rgba") || word.back() != ')')
            return std::nullopt;
        return detail::of_numbers(word.substr(open + 1, word.size() - open - 2));
    }
    if (word == "transparent") return PaintColour{{0, 0, 0}, 0};
    const auto* const end = std::end(detail::colour_names);
    const auto* const found =
        std::lower_bound(std::begin(detail::colour_names), end, word,
                         [](const detail::NamedColour& a, const std::string& b) { return a.name < b; });
    if (found == end || found->name != word) return std::nullopt;
    return detail::of_bytes(found->rgb, 255);
}

double alpha_of(std::string_view text) {
    if (const auto colour = parse_colour(text)) return colour->alpha;
    constexpr std::array notations{"rgb(", "rgba(", "hsl(",   "hsla(",  "hwb(",
                                   "lab(", "lch(",  "oklab(", "oklch(", "color("};
    const std::string word = detail::lowered(detail::trimmed(text));
    const auto begins = [&](const char* notation) { return word.starts_with(notation); };
    if (std::none_of(notations.begin(), notations.end(), begins) || !word.ends_with(')')) return 1;
    const bool has_commas = std::count(word.begin(), word.end(), ',') == 3;
    const std::size_t at = word.rfind(has_commas ? ',' : '/');
    if (at == std::string::npos) return 1;
    const std::string_view given =
        detail::trimmed(std::string_view(word).substr(at + 1, word.size() - at - 2));
    const auto alpha = parse_length(given, 1);
    return given == "none" ? 0 : alpha ? *alpha : 1;
}

double to_linear(double displayed) {
    return displayed <= 0.04045 ? displayed / 12.92 : std::pow((displayed + 0.055) / 1.055, 2.4);
}
double to_displayed(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

} // namespace cageform_examples
