#include "svg/css_colour.hpp"

#include "svg/path.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <unordered_map>

namespace cageform_support {

namespace detail {

/// Colour names and values: CSS Color Module Level 4, section 6.1.
constexpr std::string_view colour_names = R"(
aliceblue f0f8ff antiquewhite faebd7 aqua 00ffff aquamarine 7fffd4 azure f0ffff beige f5f5dc bisque ffe4c4
black 000000 blanchedalmond ffebcd blue 0000ff blueviolet 8a2be2 brown a52a2a burlywood deb887
cadetblue 5f9ea0 chartreuse 7fff00 chocolate d2691e coral ff7f50 cornflowerblue 6495ed cornsilk fff8dc
crimson dc143c cyan 00ffff darkblue 00008b darkcyan 008b8b darkgoldenrod b8860b darkgray a9a9a9
darkgreen 006400 darkgrey a9a9a9 darkkhaki bdb76b darkmagenta 8b008b darkolivegreen 556b2f darkorange ff8c00
darkorchid 9932cc darkred 8b0000 darksalmon e9967a darkseagreen 8fbc8f darkslateblue 483d8b
darkslategray 2f4f4f darkslategrey 2f4f4f darkturquoise 00ced1 darkviolet 9400d3 deeppink ff1493
deepskyblue 00bfff dimgray 696969 dimgrey 696969 dodgerblue 1e90ff firebrick b22222 floralwhite fffaf0
forestgreen 228b22 fuchsia ff00ff gainsboro dcdcdc ghostwhite f8f8ff gold ffd700 goldenrod daa520
gray 808080 green 008000 greenyellow adff2f grey 808080 honeydew f0fff0 hotpink ff69b4 indianred cd5c5c
indigo 4b0082 ivory fffff0 khaki f0e68c lavender e6e6fa lavenderblush fff0f5 lawngreen 7cfc00
lemonchiffon fffacd lightblue add8e6 lightcoral f08080 lightcyan e0ffff lightgoldenrodyellow fafad2
lightgray d3d3d3 lightgreen 90ee90 lightgrey d3d3d3 lightpink ffb6c1 lightsalmon ffa07a lightseagreen 20b2aa
lightskyblue 87cefa lightslategray 778899 lightslategrey 778899 lightsteelblue b0c4de lightyellow ffffe0
lime 00ff00 limegreen 32cd32 linen faf0e6 magenta ff00ff maroon 800000 mediumaquamarine 66cdaa
mediumblue 0000cd mediumorchid ba55d3 mediumpurple 9370db mediumseagreen 3cb371 mediumslateblue 7b68ee
mediumspringgreen 00fa9a mediumturquoise 48d1cc mediumvioletred c71585 midnightblue 191970 mintcream f5fffa
mistyrose ffe4e1 moccasin ffe4b5 navajowhite ffdead navy 000080 oldlace fdf5e6 olive 808000 olivedrab 6b8e23
orange ffa500 orangered ff4500 orchid da70d6 palegoldenrod eee8aa palegreen 98fb98 paleturquoise afeeee
palevioletred db7093 papayawhip ffefd5 peachpuff ffdab9 peru cd853f pink ffc0cb plum dda0dd
powderblue b0e0e6 purple 800080 rebeccapurple 663399 red ff0000 rosybrown bc8f8f royalblue 4169e1
saddlebrown 8b4513 salmon fa8072 sandybrown f4a460 seagreen 2e8b57 seashell fff5ee sienna a0522d
silver c0c0c0 skyblue 87ceeb slateblue 6a5acd slategray 708090 slategrey 708090 snow fffafa
springgreen 00ff7f steelblue 4682b4 tan d2b48c teal 008080 thistle d8bfd8 tomato ff6347 turquoise 40e0d0
violet ee82ee wheat f5deb3 white ffffff whitesmoke f5f5f5 yellow ffff00 yellowgreen 9acd32)";

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
    const auto share = [&](std::size_t k) { return float(channel[k]) / 255.0f; };
    return PaintColour{{share(0), share(1), share(2)}, share(3)};
}

std::optional<PaintColour> of_name(const std::string& name) {
    static const std::unordered_map<std::string_view, std::string_view> numbers = [] {
        std::unordered_map<std::string_view, std::string_view> table;
        const auto words = words_of(colour_names);
        for (std::size_t k = 0; k < words.size(); k += 2) table[words[k]] = words[k + 1];
        return table;
    }();
    const auto found = numbers.find(name);
    return found == numbers.end() ? std::nullopt : of_hex(found->second);
}

/// Parses the arguments of rgb() or rgba().
std::optional<PaintColour> of_numbers(std::string text) {
    std::array<double, 4> value{0, 0, 0, 1};
    std::size_t count = 0;
    for (char& c : text) {
        if (c == ',' || c == '/') c = ' ';
    }
    for (const std::string_view word : words_of(text)) {
        const auto number = read_quantity(word);
        if (count == 4 || !number || !(number->unit.empty() || number->unit == "%")) return std::nullopt;
        const double whole = number->unit == "%" ? 100 : count < 3 ? 255 : 1;
        value[count++] = std::clamp(number->value / whole, 0.0, 1.0);
    }
    if (count < 3) return std::nullopt;
    return PaintColour{{float(value[0]), float(value[1]), float(value[2])}, float(value[3])};
}

} // namespace detail

std::optional<PaintColour> parse_colour(std::string_view text) {
    const std::string word = detail::lowered(detail::trimmed(text));
    if (word.empty()) return std::nullopt;
    if (word[0] == '#') return detail::of_hex(std::string_view(word).substr(1));
    const std::size_t open = word.find('(');
    if (open != std::string::npos) {
        if ((word.substr(0, open) != "rgb" && word.substr(0, open) != "rgba") || word.back() != ')')
            return std::nullopt;
        return detail::of_numbers(word.substr(open + 1, word.size() - open - 2));
    }
    if (word == "transparent") return PaintColour{{0, 0, 0}, 0};
    return detail::of_name(word);
}

double alpha_of(std::string_view text) {
    if (const auto colour = parse_colour(text)) return colour->alpha;
    const std::string word = detail::lowered(detail::trimmed(text)), name = word.substr(0, word.find('('));
    if (!word.ends_with(')') || !detail::has_word("rgb rgba hsl hsla hwb lab lch oklab oklch color", name))
        return 1;
    const bool has_commas = std::count(word.begin(), word.end(), ',') == 3;
    const std::size_t at = word.rfind(has_commas ? ',' : '/');
    if (at == std::string::npos) return 1;
    const std::string_view given =
        detail::trimmed(std::string_view(word).substr(at + 1, word.size() - at - 2));
    return given == "none" ? 0 : parse_length(given, 1).value_or(1);
}

double to_linear(double displayed) {
    return displayed <= 0.04045 ? displayed / 12.92 : std::pow((displayed + 0.055) / 1.055, 2.4);
}
double to_displayed(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

} // namespace cageform_support
