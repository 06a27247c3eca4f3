#include "svg/properties.hpp"

#include "svg/css_colour.hpp"
#include "svg/style.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <unordered_map>

namespace cageform_support::detail {

namespace {

constexpr std::string_view placing_names =
    "x y width height cx cy r rx ry d transform transform-origin transform-box translate rotate scale";

constexpr std::string_view read_names = R"(
alignment-baseline clip-path color display dominant-baseline fill fill-opacity fill-rule filter font-size
marker marker-end marker-mid marker-start mask
opacity overflow stop-color stop-opacity stroke stroke-dasharray stroke-linecap stroke-linejoin
stroke-miterlimit stroke-opacity stroke-width text-anchor text-decoration text-decoration-line text-transform
visibility word-spacing)";

constexpr std::string_view kept_names = R"(
animation-composition animation-delay animation-direction animation-duration
animation-fill-mode animation-iteration-count animation-play-state animation-range animation-timeline
animation-timing-function backface-visibility background background-attachment background-clip
background-color background-image background-origin background-position background-repeat background-size
baseline-shift baseline-source block-size border border-bottom border-collapse border-color border-left
border-radius border-right border-spacing border-style border-top border-width bottom box-shadow box-sizing
caret-color clear clip clip-rule color-interpolation color-interpolation-filters color-profile
color-rendering color-scheme contain content cursor direction enable-background
flex flex-direction float flood-color flood-opacity font font-family font-feature-settings
font-kerning font-language-override font-optical-sizing font-palette font-size-adjust font-stretch
font-style font-synthesis font-variant font-variant-alternates font-variant-caps font-variant-east-asian
font-variant-ligatures font-variant-numeric font-variant-position font-variation-settings font-weight
forced-color-adjust glyph-orientation-horizontal glyph-orientation-vertical hyphens image-rendering
inline-size inset isolation kerning left letter-spacing lighting-color line-break line-height margin
margin-bottom margin-left margin-right margin-top mask-clip mask-composite mask-mode mask-origin
mask-position mask-repeat mask-size mask-type max-height max-width min-height min-width mix-blend-mode
object-fit object-position offset-anchor offset-distance offset-position offset-rotate orphans outline
outline-color outline-offset outline-style outline-width overflow-wrap overflow-x overflow-y padding
padding-bottom padding-left padding-right padding-top page paint-order perspective-origin pointer-events
position print-color-adjust quotes right shape-image-threshold shape-margin shape-outside shape-padding
shape-rendering solid-color solid-opacity src stroke-dashoffset
tab-size text-align text-align-all text-align-last text-combine-upright
text-decoration-color text-decoration-fill text-decoration-skip-ink
text-decoration-stroke text-decoration-style text-decoration-thickness text-indent text-orientation
text-overflow text-rendering text-shadow text-size-adjust text-underline-offset
text-underline-position top touch-action transform-style transition-behavior transition-delay
transition-duration transition-timing-function unicode-bidi user-select vector-effect vertical-align
white-space white-space-collapse widows will-change word-break word-wrap writing-mode z-index
-inkscape-font-specification -inkscape-stroke -inkscape-text-align -moz-osx-font-smoothing -moz-user-select
-ms-user-select -webkit-font-smoothing -webkit-tap-highlight-color -webkit-text-size-adjust
-webkit-transform-origin -webkit-user-select)";

constexpr std::string_view not_applied_names = R"(
all animation animation-name backdrop-filter mask-border mask-image offset offset-path perspective
shape-inside shape-subtract transition transition-property zoom -webkit-animation -webkit-clip-path
-webkit-mask -webkit-mask-image -webkit-transform -webkit-transition -moz-transform -ms-transform
-o-transform)";

constexpr std::string_view not_inherited_names = R"(
clip-path:none display:inline filter:none mask:none opacity:1 overflow:visible mix-blend-mode:normal
isolation:auto stop-color:black stop-opacity:1 flood-color:black flood-opacity:1 vector-effect:none
text-decoration:none alignment-baseline:auto baseline-shift:baseline animation:none transition:none
mask-type:luminance)";

struct Grammar {
    std::string_view names; // of properties and functions
    /// Up to three lists, separated by "|": values of one word, first words of longer values, and their other
    /// words. Without a third list the second is used.
    std::string_view words;
};

/// A word in angle brackets is a class of words, see is_of_kind().
constexpr Grammar grammars[] = {
    {"clip-path", "none <url> <function> fill-box stroke-box view-box border-box padding-box content-box "
                  "margin-box|<function> fill-box stroke-box view-box border-box padding-box content-box "
                  "margin-box"},
    {"cx cy x x1 x2 y y1 y2", "<length>"},
    {"d", "none <function>"},
    {"display", "none inline block contents flex grid inline-block inline-flex inline-grid list-item table "
                "inline-table table-cell table-row table-column table-caption table-row-group "
                "table-header-group table-footer-group table-column-group flow-root flow ruby ruby-text math "
                "-webkit-box -webkit-inline-box|inline block flow flow-root table flex grid ruby list-item"},
    {"fill stroke",
     "none currentcolor context-fill context-stroke <colour> <url>|<url>|none currentcolor <colour>"},
    {"fill-opacity opacity stroke-opacity", "<number>"},
    {"fill-rule", "nonzero evenodd"},
    {"filter", "none <url> <function>|<url> <function>"},
    {"font-size", "<positive> xx-small x-small small medium large x-large xx-large xxx-large smaller larger "
                  "math"},
    {"height width", "<positive> auto min-content max-content fit-content stretch -webkit-fill-available"},
    {"marker marker-end marker-mid marker-start", "none <url>"},
    {"overflow", "visible hidden scroll auto clip overlay|visible hidden scroll auto clip"},
    {"path()", "<path>|nonzero evenodd <path>"},
    {"r stroke-miterlimit stroke-width", "<size>"},
    {"rotate", "none <angle>|<angle> <number> x y z"},
    {"rotate() skewx() skewy()", "<angle>"},
    {"rx ry", "<size> auto"},
    {"scale", "none <number>|<number>"},
    {"scale()", "<number>|<number>"},
    {"stroke-dasharray", "none <size>|<size>"},
    {"stroke-linecap", "butt round square"},
    {"stroke-linejoin", "miter round bevel"},
    {"text-anchor", "start middle end"},
    {"transform", "none <function>|<function>"},
    {"transform-box", "fill-box stroke-box view-box border-box content-box"},
    {"transform-origin", "left right top bottom center <distance>|left right top bottom center <distance>"},
    {"translate", "none <distance>|<distance>"},
    {"translate()", "<distance>|<distance>"},
    {"translatex() translatey()", "<distance>"},
    {"visibility", "visible hidden collapse"}};

/// Colours that parse_colour() does not support.
constexpr std::string_view other_colours = R"(
hsl() hsla() hwb() lab() lch() oklab() oklch() color() color-mix() light-dark()
accentcolor accentcolortext activeborder activecaption activetext appworkspace background buttonborder
buttonface buttonhighlight buttonshadow buttontext canvas canvastext captiontext field fieldtext graytext
highlight highlighttext inactiveborder inactivecaption inactivecaptiontext infobackground infotext linktext
mark marktext menu menutext scrollbar selecteditem selecteditemtext threeddarkshadow threedface
threedhighlight threedlightshadow threedshadow visitedtext window windowframe windowtext -webkit-activelink
-webkit-focus-ring-color -webkit-link -webkit-text)";

constexpr std::string_view math_functions = R"(
abs() acos() asin() atan() atan2() calc() calc-size() clamp() cos() exp() hypot() log() max() min() mod()
pow() rem() round() sign() sin() sqrt() tan())";

/// Units relative to the window or to font metrics.
constexpr std::string_view page_units = R"(
cap ic lh rcap ric rlh vw vh vi vb vmin vmax svw svh svi svb svmin svmax lvw lvh lvi lvb lvmin lvmax
dvw dvh dvi dvb dvmin dvmax cqw cqh cqi cqb cqmin cqmax)";

constexpr std::string_view attribute_names = R"(
accent-height accumulate additive alphabetic amplitude arabic-form ascent attributeName attributeType
azimuth baseFrequency baseProfile bbox begin bias by calcMode cap-height class clipPathUnits
contentScriptType contentStyleType crossorigin cy data decoding descent diffuseConstant divisor download dur
dx dy edgeMode elevation end exponent externalResourcesRequired fetchpriority filterRes filterUnits focusable
font fr from fx fy g1 g2 glyph-name glyphRef gradientTransform gradientUnits hanging height horiz-adv-x
horiz-origin-x horiz-origin-y href hreflang id ideographic in in2 intercept k k1 k2 k3 k4 kernelMatrix
kernelUnitLength keyPoints keySplines keyTimes lang lengthAdjust limitingConeAngle local markerHeight
markerUnits markerWidth maskContentUnits maskUnits mathematical max media method min mode name nonce
numOctaves offset operator order orient orientation origin overline-position overline-thickness panose-1
path pathLength patternContentUnits patternTransform patternUnits ping points pointsAtX pointsAtY pointsAtZ
preserveAlpha preserveAspectRatio primitiveUnits radius refX refY referrerpolicy rel repeatCount repeatDur
requiredExtensions requiredFeatures requiredFonts requiredFormats restart result role rotate seed side slope
spacing specularConstant specularExponent spreadMethod startOffset stdDeviation stemh stemv stitchTiles
strikethrough-position strikethrough-thickness string style surfaceScale systemLanguage tabindex tableValues
target targetX targetY textLength title to type u1 u2 underline-position underline-thickness unicode
unicode-range units-per-em v-alphabetic v-hanging v-ideographic v-mathematical values version vert-adv-y
vert-origin-x vert-origin-y viewBox viewTarget width widths x-height x1 x2 xChannelSelector xmlns y1 y2
yChannelSelector z zoomAndPan)";

constexpr std::string_view element_names = R"(
a altGlyph altGlyphDef altGlyphItem animate animateColor animateMotion animateTransform circle clipPath
color-profile cursor defs desc discard ellipse feBlend feColorMatrix feComponentTransfer feComposite
feConvolveMatrix feDiffuseLighting feDisplacementMap feDistantLight feDropShadow feFlood feFuncA feFuncB
feFuncG feFuncR feGaussianBlur feImage feMerge feMergeNode feMorphology feOffset fePointLight
feSpecularLighting feSpotLight feTile feTurbulence filter font font-face font-face-format font-face-name
font-face-src font-face-uri foreignObject g glyph glyphRef hkern image line linearGradient link marker mask
metadata missing-glyph mpath path pattern polygon polyline radialGradient rect script set solidColor stop
style svg switch symbol text textPath title tref tspan use view vkern)";

std::set<std::string_view> set_of(std::string_view list) {
    const auto words = words_of(list);
    return {words.begin(), words.end()};
}

/// Whether a word of a value, in lower case, is of a class.
bool is_of_kind(std::string_view word, std::string_view kind, bool is_attribute) {
    const std::size_t open = word.find('(');
    const bool is_function = open != std::string_view::npos && word.ends_with(')');
    const std::string name = is_function ? std::string(word.substr(0, open)) + "()" : std::string(word);
    if (kind == "<url>") return name == "url()" || name == "src()";
    if (kind == "<colour>") {
        const bool is_open = name.starts_with("rgb") && word.find_first_of("fn(", open + 1) < word.size();
        return parse_colour(word) || has_word(other_colours, name) || is_open; // with from, none, calc()
    }
    if (kind == "<function>")
        return is_function && is_valid(name, word.substr(open + 1, word.size() - open - 2));
    if (kind == "<path>") {
        const bool is_quoted = word.size() > 1 && (word[0] == '"' || word[0] == '\'');
        return is_quoted && parse_path_data(word.substr(1, word.size() - 2));
    }
    if (is_function) return has_word(math_functions, name);
    const auto quantity = read_quantity(word);
    if (!quantity) return false;
    const auto& [value, unit] = *quantity;
    const bool is_zero = unit.empty() && value == 0;
    if (kind == "<number>") return unit.empty() || unit == "%";
    if (kind == "<angle>") return is_zero || has_word("deg grad rad turn", unit);
    if (!has_word(page_units, unit) && !parse_length(word, 1)) return false;
    const bool needs_unit = (kind == "<positive>" || kind == "<distance>") && !is_attribute && !is_zero;
    const bool is_positive = kind == "<positive>" || kind == "<size>";
    return !(needs_unit && unit.empty()) && !(is_positive && value < 0);
}

/// The deformed property that an element animates; empty if there is none.
std::string animated_property(pugi::xml_node node, const std::string& kind) {
    if (kind == "animateMotion" || kind == "animateTransform") return "the transform";
    const std::string name = attribute_text(node, "attributeName");
    if (kind != "animate" && kind != "set") return {};
    constexpr std::array lists{"points", "x1", "y1", "x2", "y2", "viewBox", "href", "xlink:href"};
    const bool moves = std::find(lists.begin(), lists.end(), name) != lists.end();
    return moves || use_of(name) == PropertyUse::placing ? name : std::string();
}

} // namespace

PropertyUse use_of(std::string_view property) {
    static const std::unordered_map<std::string_view, PropertyUse> table = [] {
        std::unordered_map<std::string_view, PropertyUse> uses;
        const auto put = [&](std::string_view list, PropertyUse use) {
            for (const std::string_view word : words_of(list)) uses[word] = use;
        };
        put(placing_names, PropertyUse::placing);
        put(read_names, PropertyUse::read);
        put(kept_names, PropertyUse::kept);
        put(not_applied_names, PropertyUse::not_applied);
        return uses;
    }();
    if (property.starts_with("--")) return PropertyUse::kept; // custom property, for var()
    const auto found = table.find(property);
    return found == table.end() ? PropertyUse::unknown : found->second;
}

bool is_valid(std::string_view property, std::string_view value, bool is_attribute) {
    using Words = std::vector<std::string_view>;
    static const std::unordered_map<std::string_view, std::array<Words, 3>> table = [] {
        std::unordered_map<std::string_view, std::array<Words, 3>> words;
        for (auto [names, all] : grammars) {
            std::array<Words, 3> parts;
            for (Words& part : parts) {
                const std::size_t end = std::min(all.find('|'), all.size());
                part = words_of(all.substr(0, end));
                all.remove_prefix(std::min(end + 1, all.size()));
            }
            if (parts[2].empty()) parts[2] = parts[1];
            for (const std::string_view name : words_of(names)) words[name] = parts;
        }
        return words;
    }();
    const auto found = table.find(property);
    if (found == table.end()) return true;
    const auto& [single, first, others] = found->second;
    if (std::find(single.begin(), single.end(), value) != single.end()) return true;
    const std::string text = lowered(trimmed(value));
    const bool is_open = text.find("var(") != std::string::npos || text.find("env(") != std::string::npos;
    const auto words = css_words(text);
    if (is_open || !words || has_word(wide_keywords, text))
        return true; // the end of the text closes brackets
    const auto is_one_of = [&](std::string_view word, const Words& allowed) {
        return std::any_of(allowed.begin(), allowed.end(), [&](std::string_view each) {
            return each == word || (each.starts_with('<') && is_of_kind(word, each, is_attribute));
        });
    };
    return !words->empty() && is_one_of(words->front(), words->size() == 1 ? single : first) &&
           std::all_of(words->begin() + 1, words->end(),
                       [&, &rest = others](std::string_view word) { return is_one_of(word, rest); });
}

std::string neutral_value(const std::string& property) {
    for (const std::string_view word : words_of(not_inherited_names)) {
        if (word.starts_with(property + ':')) return std::string(word.substr(property.size() + 1));
    }
    return use_of(property) == PropertyUse::unknown ? "unset" : "inherit";
}

void UnappliedReport::add(const std::string& where, const std::string& what, std::string_view value) {
    Place& place = places_[what];
    if (place.count++ > 0) return;
    place.first = where;
    place.value = value.substr(0, 60);
    order_.push_back(what);
}

void UnappliedReport::declare(const std::string& where, std::string_view property, std::string_view value) {
    switch (use_of(property)) {
    case PropertyUse::unknown:
        return add(where, "the property \"" + std::string(property) + "\" is not known and stays unchanged");
    case PropertyUse::not_applied:
        if (value == "none" || value == "auto" || value == "0" || value == "initial") return;
        return add(where, "the property \"" + std::string(property) + "\" is not deformed", value);
    default: return;
    }
}

void UnappliedReport::check(const SvgDocument& document) {
    static const std::set<std::string_view> known_elements = set_of(element_names);
    for (const pugi::xml_node node : document.xml.children()) {
        if (node.type() != pugi::node_pi || std::string_view(node.name()) != "xml-stylesheet") continue;
        add(node.name(), "another file is not read", node.value());
    }
    const pugi::xml_node root = root_element(document.xml);
    for (pugi::xml_node node = root; node;) {
        const std::string kind = local_name(node);
        const bool foreign = kind.empty() || kind.find(':') != std::string::npos;
        const bool known = known_elements.count(kind) != 0;
        if (!foreign && known) check(document, node, kind);
        if (!foreign && !known) add(label(document, node), kind + " is not deformed and stays unchanged");
        const bool opaque = !known || kind == "foreignObject" || kind == "metadata" || kind == "script";
        node = opaque ? node_after(node, root) : next_node(node, root);
    }
}

void UnappliedReport::check(const SvgDocument& document, pugi::xml_node node, const std::string& kind) {
    static const std::set<std::string_view> known_attributes = set_of(attribute_names);
    const auto tell = [&](std::string_view property, std::string_view value) {
        const PropertyUse use = use_of(property);
        if (use == PropertyUse::placing || use == PropertyUse::kept) return;
        if (use == PropertyUse::read && value.find('(') == std::string_view::npos) return;
        declare(label(document, node), property, unescaped(value));
    };
    for (const pugi::xml_attribute attribute : node.attributes()) {
        const std::string_view name = attribute.name();
        const bool foreign = name.find(':') != std::string_view::npos || name.starts_with("data-") ||
                             name.starts_with("aria-") || name.starts_with("on") ||
                             name.starts_with("cageform-"); // our own marks
        if (!foreign && known_attributes.count(name) == 0) tell(name, attribute.value());
    }
    for (const Declaration& d : declarations(node.attribute("style").value())) {
        tell(property_name(d.property), d.value);
    }
    const std::string animated = animated_property(node, kind);
    if (!animated.empty()) add(label(document, node), kind + " is not deformed: it animates " + animated);
}

std::vector<std::string> UnappliedReport::lines() const {
    std::vector<std::string> all;
    for (const std::string& what : order_) {
        const Place& place = places_.at(what);
        const std::string value = place.value.empty() ? "" : ": " + place.value;
        const std::string more = place.count > 1 ? " (" + std::to_string(place.count) + " times)" : "";
        all.push_back(place.first + ": " + what + value + more);
    }
    return all;
}

} // namespace cageform_support::detail
