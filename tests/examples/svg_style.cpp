// CSS in drawings: which rules apply, geometry and transforms in rules, and what is not applied.
#include "svg/document.hpp"
#include "svg/style.hpp"
#include "svg/walk.hpp"
#include "svg/xml.hpp"

#include "svg_texts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace svg_style_tests {

using namespace cageform_support;
using svg_texts::by;
using svg_texts::by_name;
using svg_texts::Deformed;
using svg_texts::parsed;
using svg_texts::Random;

namespace {

/// A drawing of 200 by 100 units.
std::string svg(std::string_view content) {
    return svg_texts::svg(content, "0 0 200 100");
}

struct Result {
    SvgDocument document;
    std::string text;
    std::vector<std::string> warnings;
};

Result deformed(std::string_view text, const Affine2& pose) {
    Deformed result = svg_texts::deformed(text, by(pose), {.decimals = 9});
    return {std::move(result.document), std::move(result.text), std::move(result.report.warnings)};
}

/// The shapes of a drawing in the user space of the root, after a map.
std::string drawn(std::string_view text, const Affine2& map = {}) {
    const auto all = shapes(parsed(text));
    INFO(text);
    INFO((all ? std::string() : to_string(all.error())));
    REQUIRE(all);
    std::string result;
    for (const SvgShape& shape : *all) result += write_path_data(transformed(shape.path, map), 3) + '\n';
    return result;
}

const Affine2 slanted{0.9, 0.4, -0.3, 1.2, 7, -5};

} // namespace

TEST_CASE("selectors match and rank as in CSS", "[examples][svg_style][selector]") {
    const SvgDocument document =
        parsed(svg(R"x(<g id="g" class="outer one"><rect id="r" class="a b" width="6"/>
        <circle id="c" data-kind="Big round" lang="de-CH"/>
        <path id="p" class="a"/><path id="q"/><g id="e"/></g>)x"));
    const detail::IdTable ids(detail::root_element(document.xml));
    const auto found = [&](std::string_view text) {
        bool complete = false;
        std::string result;
        detail::SelectorSearch search{1'000'000};
        for (const detail::Selector& selector : detail::parse_selectors(text, complete)) {
            for (const char* id : {"g", "r", "c", "p", "q", "e"}) {
                if (selector.matches(ids.find(id), search)) result += id;
            }
        }
        return complete ? result : "?";
    };
    const auto rank = [](std::string_view text) {
        bool complete = false;
        const auto all = detail::parse_selectors(text, complete);
        return all.size() == 1 ? all.front().specificity : 0;
    };
    struct Case {
        std::string_view text, found;
        std::size_t rank; // numbers of ids, classes and types as decimal digits
    };
    for (const Case& c : std::vector<Case>{{"path", "pq", 1},
                                           {"*", "grcpqe", 0},
                                           {"#r", "r", 1000000},
                                           {".a.b", "r", 2000},
                                           {".A", "", 1000},
                                           {"svg|path.a", "p", 1001},
                                           {"[width]", "r", 1000},
                                           {"rect[width='6']", "r", 1001},
                                           {"[width=\"60\"]", "", 1000},
                                           {"[data-kind~=round]", "c", 1000},
                                           {"[data-kind='big ROUND' i]", "c", 1000},
                                           {"[lang|=de]", "c", 1000},
                                           {"[id^=r]", "r", 1000},
                                           {"[class$=ne]", "g", 1000},
                                           {"[class*=' ']", "gr", 1000},
                                           {"[class*='']", "", 1000},
                                           {"g path", "pq", 2},
                                           {"svg > path", "", 2},
                                           {"g>path", "pq", 2},
                                           {"rect + circle", "c", 2},
                                           {"rect + path", "", 2},
                                           {"rect ~ path", "pq", 2},
                                           {"svg rect ~ path + g", "e", 4},
                                           {":root > g > :first-child", "r", 2001},
                                           {"path:first-of-type", "p", 1001},
                                           {"path:last-of-type", "q", 1001},
                                           {":last-child", "ge", 1000},
                                           {":only-child", "g", 1000},
                                           {"rect:only-of-type", "r", 1001},
                                           {":nth-child(2n)", "cq", 1000},
                                           {":nth-child( odd )", "grpe", 1000},
                                           {":nth-child(-n + 2)", "grc", 1000},
                                           {":nth-last-child(2)", "q", 1000},
                                           {"path:nth-of-type(2)", "q", 1001},
                                           {"path:nth-last-of-type(2)", "p", 1001},
                                           {":empty", "rcpqe", 1000},
                                           {"path:not(.a)", "q", 1001},
                                           {":not(path, #g)", "rce", 1000000},
                                           {":is(rect, #q)", "rq", 1000000},
                                           {":where(#r, .a)", "rp", 0},
                                           {"g :not(rect + *):not(g)", "rpq", 3},
                                           {"path:not(:hover)", "pq", 1001},
                                           {"\\70 ath", "pq", 1},
                                           {"#\\72", "r", 1000000},
                                           {"path::before", "?", 0},
                                           {":unheard(2)", "?", 0},
                                           {"path >", "?", 0},
                                           {"> path", "?", 0},
                                           {"a[", "?", 0},
                                           {"a)", "?", 0}}) {
        CAPTURE(c.text);
        CHECK(found(c.text) == c.found);
        if (c.found != "?") CHECK(rank(c.text) == c.rank);
    }
    CHECK(found("rect, circle , .a:first-child") == "rcr");
    bool complete = false;
    const auto states = detail::parse_selectors("path:hover, path:not(:focus)", complete);
    CHECK((states[0].has_state && !states[1].has_state && complete));
}

TEST_CASE("a selector with many ways to match ends", "[examples][svg_style][selector]") {
    std::string deep = "<g>", selector = "x";
    for (int i = 0; i < 300; ++i) deep += "<g>";
    for (int i = 0; i < 60; ++i) selector += i % 2 == 0 ? " g" : " > g";
    for (int i = 0; i < 300; ++i) deep += "</g>";
    CHECK(deformed(svg("<style>" + selector + "{fill:red}</style>" + deep + "</g><path d='M0 0h1v1z'/>"),
                   slanted)
              .warnings.empty());
}

TEST_CASE("rules that take too long to match are reported and ignored", "[examples][svg_style][selector]") {
    const auto repeated = [](std::string_view part, std::size_t count) {
        std::string all;
        for (; count > 0; --count) all += part;
        return all;
    };
    constexpr std::size_t most = 30'000; // a thousandth of the limit for a drawing
    const std::string path = "<path class='k' d='M0 0h1v1z'/>", many = repeated(path, 400);
    const std::string deep = repeated("<g>", 60) + path + repeated("</g>", 60);
    const auto told = [&](const std::string& rule, const std::string& content) {
        SvgDocument document =
            parsed(svg("<style>" + rule + "{fill:red}path{fill:tan}</style>" + content + path));
        const detail::StyleSheets styles(document, most);
        const auto lines = styles.report.lines();
        const bool is_read = styles.value(document.xml.first_child().last_child(), "fill").text != "";
        CHECK(is_read == lines.empty());
        return lines == std::vector<std::string>{"style: its rules take too long to match and are not read"};
    };
    for (const std::string word : {":is(", ":where(", ":not("}) {
        std::string nested = "x";
        for (int i = 0; i < 7; ++i) nested = word + nested + " *)";
        CAPTURE(nested);
        CHECK_FALSE(told(nested + " z", deep));
        told(word + "z " + nested + " * * * *)", deep + many); // it ends
    }
    CHECK(told("z ~ *", many));
    CHECK(told(repeated("z ~ .k,", 5) + "z ~ .k", repeated("<g/><!---->", 90) + many));
    for (const std::string nth : {"*:nth-child(2n)", "*:nth-last-of-type(7)", ".k:first-child"})
        CHECK_FALSE(told(nth, repeated(path, 3'000))); // the positions of siblings are counted once
}

TEST_CASE("at-rules and media are read in any case of letters", "[examples][svg_style]") {
    const std::string rule = "{rect{height:9px}}", rect = "<rect width='3' height='1'/>";
    const auto applies = [&](const std::string& style) {
        return drawn(svg(style + rect)) == drawn(svg("<rect width='3' height='9'/>"));
    };
    for (const std::string at : {"@MEDIA Screen", "@Media print, ALL", "@media", "@media not print",
                                 "@Media NOT ALL, only screen", "@layer", "@LAYER a.b", "@SUPPORTS (d:none)",
                                 "@Supports (font-family: notable)", "@supports (--knot: 1)"}) {
        CAPTURE(at);
        CHECK(applies("<style>" + at + rule + "</style>"));
    }
    for (const std::string at :
         {"@MEDIA PRINT", "@media not screen", "@media print and (width:9px), not all",
          "@SUPPORTS NOT (d:none)", "@supports (not (d:none))", "@Supports (d:none) and (NOT (d:none))",
          "@supports (d:none) or (knot : 1)", "@FONT-FACE", "@KeyFrames a"}) {
        CAPTURE(at);
        CHECK_FALSE(applies("<style>" + at + rule + "</style>"));
    }
    CHECK(applies("<style media='SCREEN' type='text/css'>rect{height:9px}</style>"));
    CHECK_FALSE(applies("<style type='text/less'>rect{height:9px}</style>"));
    for (const std::string at :
         {"(min-width:1px)", "screen and (height:9px), print", "not all and (color)"}) {
        const Result kept = deformed(svg("<style>@media " + at + rule + "</style><g/>" + rect), slanted);
        CHECK(kept.warnings == std::vector<std::string>{
                                   "style (line 1): the property \"height\" of \"rect\" is not deformed"});
        CHECK(kept.text.find("<rect width=\"3\" height=\"1\"/>") != std::string::npos); // it stays
    }
    CHECK(deformed(svg("<style>@FONT-FACE{src:x}@KEYFRAMES a{to{x:1px}}</style>" + rect), slanted)
              .warnings.empty());
    CHECK(deformed(svg("<style>@property --a{syntax:'*'}@supports(knot:1){a{}}</style>" + rect), slanted)
              .warnings == std::vector<std::string>{"style (line 1): \"@property --a\" is not read",
                                                    "style (line 1): \"@supports(knot:1)\" is not read"});
}

TEST_CASE("layers, rules, style attributes and attributes rank as in CSS",
          "[examples][svg_style][property]") {
    const auto seed = GENERATE(range(0, 100));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const std::vector<std::string> selectors{"rect", ".k", "#i", ":is(.k, rect)"}, names{"a", "b", "a.c", ""};
    const std::vector<int> ranks{0, 1, 2, 1};
    const bool b_is_first = random.below(2) == 0;
    const std::vector<int> order{b_is_first ? 2 : 1, b_is_first ? 0 : 2, b_is_first ? 1 : 0, 3}; // of names
    std::string css = b_is_first ? "@layer b, a;" : "@layer a;@layer b;", wanted;
    std::array<int, 4> best{-1, 0, 0, 0}; // importance, layer, selector, order
    std::string attributes, style;
    if (random.below(2) == 0) attributes = " fill='" + (wanted = "#a00001") + '\'';
    for (int n = 0; n < 9; ++n) {
        const std::size_t layer = random.below(4), selector = random.below(4);
        const bool important = random.below(3) == 0, is_valid = random.below(4) != 0;
        const bool in_style = random.below(6) == 0;
        const std::string value = is_valid ? "#00000" + std::to_string(n) : "none red";
        const std::string declaration = "fill:" + value + (important ? "!important" : "");
        std::string rule = in_style ? "" : selectors[selector] + '{' + declaration + '}';
        if (in_style) {
            style += declaration + ';';
        } else if (names[layer] == "a.c" && random.below(2) == 0) {
            rule = "@layer a{@layer c{" + rule + "}}";
        } else if (!names[layer].empty()) {
            rule = "@layer " + names[layer] + '{' + rule + '}';
        }
        css += rule;
        const int of_layer = in_style ? 9 : important ? -order[layer] : order[layer];
        const std::array<int, 4> rank{important ? 1 : 0, of_layer, in_style ? 0 : ranks[selector], n};
        if (!is_valid || rank < best) continue;
        best = rank;
        wanted = value;
    }
    const std::string text =
        svg("<style>" + css + "</style><rect id='i' class='k' style='" + style + '\'' + attributes + "/>");
    CAPTURE(text);
    SvgDocument document = parsed(text);
    CHECK(detail::StyleSheets(document).value(by_name(document.xml, "rect"), "fill").text == wanted);
}

TEST_CASE("nested rules apply to the elements that they name", "[examples][svg_style][selector]") {
    const std::string content =
        "<g class='a'><rect class='b'/><circle/><g id='g'><rect/><circle class='a'/></g></g>"
        "<rect class='a b'/>";
    const auto fills = [&](const std::string& css) {
        SvgDocument document = parsed(svg("<style>" + css + "</style>" + content));
        const detail::StyleSheets styles(document);
        CHECK(styles.report.lines().empty());
        std::string all;
        const pugi::xml_node root = detail::root_element(document.xml);
        for (pugi::xml_node node = root; node; node = detail::next_node(node, root))
            all += styles.value(node, "fill").text + '|';
        return all;
    };
    const std::vector<std::array<std::string, 2>> cases{
        {"g{rect{fill:red}}", "g rect{fill:red}"},
        {"g{fill:tan;> rect,+.b{fill:red}}", "g{fill:tan}g > rect,g+.b{fill:red}"},
        {".a,#g{&.b{fill:red}rect{fill:tan}}", ":is(.a,#g).b{fill:red}:is(.a,#g) rect{fill:tan}"},
        {"rect{.a &{fill:red}}rect{fill:tan}", ".a rect{fill:red}rect{fill:tan}"},
        {"rect{fill:red;&{fill:tan}fill:blue}", "rect{fill:red}rect{fill:tan}rect{fill:blue}"},
        {"g{circle{&.a{fill:red}@media print{fill:tan}@supports (d:none){fill:blue}}}",
         "g circle.a{fill:red}g circle{fill:blue}"},
        {"g{:not(&){fill:red}[class='a&']{fill:tan}}", ":not(g){fill:red}"}};
    for (const auto& [nested, flat] : cases) {
        CAPTURE(nested);
        CHECK(fills(nested) == fills(flat));
    }
    std::string deep, twice = "g";
    for (int n = 0; n < 5'000; ++n) deep += "g{";
    for (int n = 0; n < 29; ++n) twice += "{& &";
    std::string many = "g";
    for (int n = 0; n < 2'000; ++n) many += ",g";
    many += '{' + std::string(300'000, '&') + "{fill:red}}"; // each "&" stands for the rule outside
    for (const std::string& hostile : {deep, twice + "{fill:red}", many}) {
        const std::string text = svg("<style>" + hostile + "</style><path d='M1 1h2v2z'/>");
        CHECK_FALSE(deformed(text, slanted).warnings.empty());
    }
}

TEST_CASE("changes of elements keep the style that rules gave them", "[examples][svg_style][property]") {
    const auto seed = GENERATE(range(0, 60));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const std::vector<std::string> kinds{"rect", "circle", "path", "g", "polygon", "ellipse"};
    const std::vector<std::string> parts{"rect",
                                         "path",
                                         "circle",
                                         ".a",
                                         ".b",
                                         "#i3",
                                         "*",
                                         "[width]",
                                         "[r='7']",
                                         "[class~=a]",
                                         ":first-child",
                                         "path:not(.a)",
                                         "g",
                                         "ellipse.b",
                                         ":nth-of-type(2)",
                                         ":nth-child(3)",
                                         ":is(rect,.b)",
                                         "[d]",
                                         ":where(#i1)",
                                         "[style]",
                                         "path:not([style])"};
    const std::vector<std::string> properties{"fill",       "stroke",    "opacity",
                                              "visibility", "fill-rule", "stroke-width"};
    const auto declaration = [&] {
        const std::string property = random.any_of(properties);
        const std::string value = property == "fill" || property == "stroke"
                                      ? random.any_of({"red", "tan", "none"})
                                  : property == "fill-rule"  ? random.any_of({"evenodd", "nonzero"})
                                  : property == "visibility" ? random.any_of({"hidden", "visible"})
                                                             : random.any_of({".5", "2", ".25"});
        return property + ':' + value + (random.below(5) == 0 ? "!important" : "");
    };
    std::string css, content;
    for (int n = 0; n < 8; ++n) {
        css += random.any_of(parts) + random.any_of({"", "", " ", ">", "+", "~"});
        css += random.any_of({"*", "rect", ".a", "path", "g *"}) + '{' + declaration() + ';' + declaration() +
               '}';
    }
    for (int n = 0; n < 12; ++n) {
        const std::string kind = random.any_of(kinds);
        content += '<' + kind + " id='i" + std::to_string(n) + "' class='" +
                   random.any_of({"", "a", "b", "a b"}) + "' " +
                   random.any_of({"", "fill='blue'", "opacity='.75'", "stroke='black' stroke-width='3'",
                                  "fill='nonsense' font-size='7'"});
        if (random.below(3) == 0) content += " style='" + declaration() + "'";
        const std::map<std::string, std::string> shape{
            {"rect", " width='9' height='4'/>"},    {"circle", " r='7'/>"},
            {"ellipse", " rx='7' ry='2'/>"},        {"path", " d='M1 2h3v4z'/>"},
            {"polygon", " points='0,0 4,0 4,4'/>"}, {"g", "><rect class='b' width='2' height='2'/></g>"}};
        content += shape.at(kind);
    }
    const std::string text = svg("<style>" + css + "</style>" + content);
    CAPTURE(text);
    SvgDocument before = parsed(text);
    Result after = deformed(text, slanted);
    CAPTURE(after.text);
    CHECK(after.text.find("cageform-") == std::string::npos); // no mark is left
    const detail::StyleSheets old(before), fresh(after.document);
    const pugi::xml_node root = detail::root_element(before.xml);
    pugi::xml_node now = detail::root_element(after.document.xml);
    for (pugi::xml_node was = root; was; was = detail::next_node(was, root)) {
        REQUIRE(now);
        CAPTURE(was.name(), detail::attribute_text(was, "id"));
        for (const std::string& property : properties) {
            CAPTURE(property);
            const auto neutral = [&](std::string value) {
                return value == detail::neutral_value(property) ? std::string() : value;
            };
            CHECK(neutral(fresh.value(now, property).text) == neutral(old.value(was, property).text));
        }
        now = detail::next_node(now, detail::root_element(after.document.xml));
    }
}

TEST_CASE("rules apply to copies and new elements as before", "[examples][svg_style]") {
    // a copy has the rules that would apply to the original element on its own
    const std::string defs =
        R"(<defs><g id="g" class="box"><path id="p" class="k" d="M0 0h9v9z"/></g></defs>)";
    const auto copy_of = [&](const std::string& css, const std::string& id) {
        Result copy =
            deformed(svg("<style>" + css + "</style>" + defs + "<use href='#" + id + "'/>"), slanted);
        const pugi::xml_node group = detail::root_element(copy.document.xml).last_child();
        return detail::attribute_text(group, "style") + '|' +
               detail::attribute_text(group.first_child(), "style") + '|' +
               detail::attribute_text(group.first_child().first_child(), "style");
    };
    CHECK(copy_of("use{opacity:.5} g > path{fill:red} svg path{stroke:tan}", "p") ==
          "opacity:.5|fill:inherit;stroke:inherit|");
    CHECK(copy_of("#p{fill:red} .k:first-child{opacity:.5}", "p") == "|fill:red|");
    CHECK(copy_of("g{opacity:.5} .box > .k{fill:red} defs .k{stroke:tan}", "g") == "opacity:1||");
    CHECK(copy_of("g g path{fill:red} #g > #p:nth-child(1){stroke:tan}", "g") == "||fill:inherit;stroke:tan");
    // a rule under a condition that no longer matches an element is reported; others are not
    const std::string shapes = "<rect width='9' height='9'/><path class='k' d='M1 1h2v2z'/>";
    const Result lost =
        deformed(svg("<style>rect:hover{fill:red}\n.k:hover{fill:red}\n@media print{rect{fill:tan}}"
                     "</style>" +
                     shapes),
                 slanted);
    REQUIRE(lost.warnings.size() == 2);
    CHECK(lost.warnings[0] == "style (line 3): \"rect\" no longer applies to path (line 3)");
    Result print = deformed(svg("<style media='print'>path{fill:red}</style><path d='M1 1h2v2z'/>"), slanted);
    CHECK(
        detail::StyleSheets(print.document).value(by_name(print.document.xml, "path"), "fill").text.empty());
    CHECK(lost.warnings[1] == "style (line 1): \"rect:hover\" no longer applies to path (line 3)");
    const Result words =
        deformed(svg("<style>@supports(d:none){rect{fill:tan}}p{height:9px}</style>"
                     "<foreignObject width='9' height='9'><p xmlns='h' style='width:5px'/></foreignObject>"
                     "<rect width='9' height='9'/>"),
                 slanted);
    CHECK(words.warnings.size() == 1);
    CHECK(words.text.find("<p xmlns=\"h\" style=\"height:9px;width:5px\"/>") != std::string::npos);
    CHECK(words.text.find("style=\"fill:tan\"") != std::string::npos);
    // an attribute needs no unit, unlike a style attribute, and may be invalid
    const Result sized = deformed(svg("<style>path{font-size:20px;fill:red}</style><rect font-size='7' "
                                      "fill='odd' width='9' height='9'/>"),
                                  slanted);
    CHECK(sized.text.find("style=\"fill:inherit;font-size:7px\"") != std::string::npos);
    // unmoved elements are unchanged
    const std::string still = svg(R"(<style>rect{fill:red;x:5px}</style><rect width="9" height="9"/>)");
    CHECK(deformed(still, {}).text == still);
    for (const std::string_view odd :
         {"/*", "/", "@", "rect", "{", "}", "rect{", "rect{/*", "@media{rect", "", "rect{x:", "rect{x:1px",
          "rect{x:;y:2px", "rect{a\"b='c':d}", "<![CDATA[rect{x:1px}]]>"}) {
        CAPTURE(odd);
        const Result result =
            deformed(svg("<style>" + std::string(odd) + "</style><rect width='1' height='1'/>"), slanted);
        CHECK(to_text(parsed(result.text)) == result.text);
    }
}

TEST_CASE("geometry and transforms in CSS are those of attributes", "[examples][svg_style][geometry]") {
    struct Case {
        std::string css, by_css, by_attributes;
    };
    const std::string rect = R"(<rect x="20" y="30" width="40" height="10")";
    const auto about = [](const std::string& x, const std::string& y, const std::string& map) {
        return " transform='translate(" + x + ' ' + y + ") " + map + " translate(-" + x + " -" + y + ")'";
    };
    const auto cases = std::vector<Case>{
        {".k{x:1px;y:2px;width:30px;height:40px;rx:4px}", "<rect class='k' rx='9'/>",
         "<rect x='1' y='2' width='30' height='40' rx='4'/>"},
        {"", "<rect style='width:25%;height:1in!important' height='2'/>", "<rect width='50' height='96'/>"},
        {"circle{cx:3px;cy:4px;r:5px}", "<circle r='9'/>", "<circle cx='3' cy='4' r='5'/>"},
        {"", "<ellipse style='cx:3px;cy:4px;rx:5px;ry:2px'/>", "<ellipse cx='3' cy='4' rx='5' ry='2'/>"},
        {"", "<path d='M0 0' style=\"d:path('M1 2 L9 9')\"/>", "<path d='M1 2 L9 9'/>"},
        {"path{d:path(\"M1 2C1 3 2 4 9 9\")}", "<path/>", "<path d='M1 2C1 3 2 4 9 9'/>"},
        {"", "<path d='M0 0' style='d:none'/>", ""},
        {".u{x:5px;y:6px}", "<defs><path id='p' d='M0 0h9'/></defs><use class='u' href='#p'/>",
         "<path d='M5 6h9'/>"},
        {"", rect + " style='transform:rotate(30deg)'/>", rect + " transform='rotate(30)'/>"},
        {"g{transform:translate(10px,5%) scale(2)}", "<g transform='scale(9)'>" + rect + "/></g>",
         "<g transform='translate(10 5) scale(2)'>" + rect + "/></g>"},
        {"", rect + " style='transform:translateX(1em) rotate(.25turn) skewX(20deg) scaleY(50%)'/>",
         rect + " transform='translate(16 0) rotate(90) skewX(20) scale(1 .5)'/>"},
        {"", rect + " style='transform:skew(10deg,20deg) matrix(1,2,3,4,5,6)'/>",
         rect + " transform='matrix(1 .36397 .176327 1 0 0) matrix(1 2 3 4 5 6)'/>"},
        {"", rect + " transform='rotate(20)' transform-origin='15 25'/>",
         rect + about("15", "25", "rotate(20)") + "/>"},
        {"", rect + " transform='rotate(20)' style='transform-origin:50% bottom'/>",
         rect + about("100", "100", "rotate(20)") + "/>"},
        {"", rect + " style='transform:scale(2);transform-origin:center;transform-box:fill-box'/>",
         rect + about("40", "35", "scale(2)") + "/>"},
        {"", "<g style='rotate:90deg;transform-origin:right top;transform-box:fill-box'>" + rect + "/></g>",
         "<g " + about("60", "30", "rotate(90)") + '>' + rect + "/></g>"},
        {"",
         rect + " style='translate:10% 3px;rotate:40grad;scale:2 "
                ".5;transform:skewX(9deg);transform-origin:left'/>",
         rect + about("0", "50", "translate(20 3) rotate(36) scale(2 .5) skewX(9)") + "/>"},
        {"", "<g font-size='10'><rect x='2em' y='1ex' width='3rem' style='height:2em;font-size:150%'/></g>",
         "<rect x='30' y='7.5' width='48' height='30'/>"},
        {".f{font:bold 10px/2 serif;font-size:5px}",
         "<g style='font:700 20px serif'><rect x='1em' width='3em' height='9'/>"
         "<rect class='f' width='3em' height='9'/></g>",
         "<rect x='20' width='60' height='9'/><rect width='15' height='9'/>"},
        {"",
         "<defs><g id='d'>" + rect +
             "/></g></defs><use href='#d' style='rotate:90deg;transform-box:fill-box;"
             "transform-origin:left top'/>",
         "<g " + about("20", "30", "rotate(90)") + "><g>" + rect + "/></g></g>"},
        {".k{x:min(9px,5%,1em);width:max(9px,3rem);height:clamp(4px,10%,8px)}",
         "<rect class='k' y='calc(2*max(3,min(9,4)))'/>", "<rect x='9' y='8' width='48' height='8'/>"},
        {"g{--w:calc(var(--half)*2);--half:9px}.k{width:var(--w);height:var(--h, 3px)}",
         "<g><rect class='k' x='var(--half)' y='var(--h)'/></g>", "<rect x='9' width='18' height='3'/>"},
        {"rect{--a:var(--b);--b:var(--a);height:2px;height:var(--a)}g{font:/ 3em x}",
         "<rect width='9' height='9'/>", ""},
        {"svg{font-size:8px}", "<rect x='1cm' y='1pc' width='3rem' height='40q'/>",
         "<rect x='37.795' y='16' width='24' height='37.795'/>"}};
    for (const Case& c : cases) {
        const std::string text = svg("<style>" + c.css + "</style>" + c.by_css);
        CAPTURE(text);
        CHECK(drawn(text) == drawn(svg(c.by_attributes)));
        const Result moved = deformed(text, slanted); // and no rule moves it back
        CAPTURE(moved.text);
        CHECK(drawn(moved.text) == drawn(svg(c.by_attributes), slanted));
        CHECK(moved.warnings.empty());
    }
    // geometry is removed from a style sheet, everything else is kept
    const Result moved =
        deformed(svg("<style>/* x:1 */ rect { fill:red; x: 5px ; stroke:tan;width:9px }</style>"
                     "<rect height='4'/>"),
                 slanted);
    CHECK(moved.text.find("<style>/* x:1 */ rect { fill:red;  stroke:tan;}</style>") != std::string::npos);
    // unreadable geometry is kept and reported
    const Result kept =
        deformed(svg("<style>rect{x:round(1px, 2px)}</style><rect width='9' height='9'/>\n"
                     "<g style='transform:rotate3d(1,1,1,9deg)'/><g style='offset-path:none'/>"
                     "<circle r='2' style='translate:1px;transform-origin:round(1px, 2px)'/>"),
                 slanted);
    REQUIRE(kept.warnings.size() == 3);
    CHECK(kept.warnings[0] == "rect (line 1): the property \"x\" is not deformed: round(1px, 2px)");
    CHECK(kept.warnings[1] == "g (line 2): the property \"transform\" is not deformed: rotate3d(1,1,1,9deg)");
    CHECK(kept.warnings[2] ==
          "circle (line 2): the property \"transform-origin\" is not deformed: round(1px, 2px)");
    CHECK(kept.text.find("x:round(1px, 2px)") != std::string::npos);
}

TEST_CASE("an invalid declaration is ignored", "[examples][svg_style][property]") {
    const auto seed = GENERATE(range(0, 80));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    struct Kind {
        std::string property;
        std::vector<std::string> valid, invalid;
    };
    const std::vector<Kind> kinds{
        {"fill",
         {"#c33", "RED", "url(#a) none", "hsl(9 8% 7%)", "Canvas", "inherit"},
         {"nonsense", "#12345", "rgb(1 2)", "none red", "url(#a) odd", "", "3"}},
        {"stroke-width", {"3", "5%", "calc(1px + 2px)", "0"}, {"-3", "3foo", "1 2", "thick"}},
        {"width", {"40px", "auto", "0", "max-content", "3vw"}, {"auto2", "-3px", "40", "none", "4 0px"}},
        {"opacity", {".5", "20%", "-1", "var(--a)"}, {"half", "3px", "1 1"}},
        {"stroke-dasharray", {"none", "4,2 6%", "0"}, {"1,-2", "a", "none 3"}},
        {"font-size", {"12px", "larger", "0", "2ch"}, {"12", "-1px", "big"}},
        {"transform",
         {"rotate(3deg)", "none", "scale(2)translate(0,3px)"},
         {"rotate(3)", "translate(3)", "x"}},
        {"clip-path", {"none", "url(#a)", "circle(3px)"}, {"a", "3px"}},
        {"text-anchor", {"start", "end"}, {"left", "start end"}}};
    for (const Kind& kind : kinds) {
        std::string css, style, wanted;
        bool is_important = false;
        for (std::string* const to : {&css, &style}) {
            for (int n = 0; n < 4; ++n) {
                const bool valid = random.below(3) == 0, important = random.below(4) == 0;
                const std::string value = random.any_of(valid ? kind.valid : kind.invalid);
                const std::string declaration =
                    kind.property + ':' + value + (important ? "!important;" : ";");
                *to += to == &css ? "rect{" + declaration + '}' : declaration;
                if (!valid || (is_important && !important)) continue;
                wanted = value;
                is_important = important;
            }
        }
        SvgDocument document = parsed(svg("<style>" + css + "</style><rect style='" + style + "'/>"));
        const detail::StyleSheets styles(document);
        CAPTURE(css, style);
        const std::string found = styles.value(by_name(document.xml, "rect"), kind.property).text;
        CHECK(found == (wanted == "var(--a)" ? "unset" : wanted)); // as --a has no value
    }
}

TEST_CASE("basic shapes clip as paths do", "[examples][svg_style][clip]") {
    const std::string box = "<rect x='20' y='30' width='40' height='20'";
    const auto clips = [&](const std::string& shape, const std::string& path) {
        const std::string by_shape = svg(box + " clip-path='" + shape + "'/>");
        const std::string by_path =
            svg("<clipPath id='c'><path d='" + path + "'/></clipPath>" + box + " clip-path='url(#c)'/>");
        const auto clip_of = [](const std::string& text) {
            const Result moved = deformed(text, slanted);
            const std::string data =
                detail::attribute_text(by_name(moved.document.xml, "clipPath").first_child(), "d");
            CHECK(moved.warnings.empty());
            return write_path_data(*parse_path_data(data), 3);
        };
        CAPTURE(by_shape);
        CHECK(clip_of(by_shape) == clip_of(by_path));
    };
    clips("polygon(50% 0, 100% 100%,0 100%)", "M40 30L60 50L20 50Z");
    clips("inset(0 round 50% / 25%)",
          "M20 35A20 5 0 0 1 40 30A20 5 0 0 1 60 35V45A20 5 0 0 1 40 50A20 5 0 0 1 20 45Z");
    clips("ellipse(25% farthest-side at 30px 5px) fill-box",
          "M60 35A10 15 0 0 1 50 50A10 15 0 0 1 40 35A10 15 0 0 1 50 20A10 15 0 0 1 60 35Z");
    CHECK(deformed(svg(box + " style='stroke:red;stroke-width:4;clip-path:inset(0)'/>"), {1, 0, 0, 1, 1, 0})
              .text.find("<path d=\"M19 28 L63 28 L63 52 L19 52 Z\"/>") != std::string::npos);
    const Result whole =
        deformed("<svg viewBox='0 0 90 90' style='clip-path:circle(9px)'>" + box + "/></svg>", slanted);
    CHECK(detail::root_element(whole.document.xml).child("clipPath")); // a document has one root
    for (const std::string_view odd :
         {"circle(", "polygon(1px)", "inset()", "ellipse(1px)", "xywh(0 0 1px)", "rect(1px 1px)",
          "circle(1px at)", "polygon()", "fill-box", "inset(1px round)", "()"}) {
        CAPTURE(odd);
        const Result left = deformed(svg(box + " clip-path=\"" + std::string(odd) + "\"/>"), slanted);
        REQUIRE(left.warnings.size() == 1);
        CHECK(left.warnings[0].find("the property \"clip-path\" is not deformed: " + std::string(odd)) !=
              std::string::npos);
    }
}

TEST_CASE("entities and namespace prefixes are resolved", "[examples][svg_style][entities]") {
    const std::string text = R"x(<!DOCTYPE svg [<!ENTITY n "http://www.w3.org/2000/svg"> <!ENTITY size '40'>
<!ENTITY box "<rect width='&size;' height='5'/>"><!ENTITY two '&box;<g fill="red">&box;</g>'>
<!ENTITY % own "9"><!ENTITY far SYSTEM "other.svg"><!ENTITY loop "&loop;">]>
<svg xmlns="&n;" viewBox="0 0 &size; 9">a&two;b
<path style="fill:&#x72;ed" d="M0 0h&size;"/>&far;&none;</svg>)x";
    const Result moved = deformed(text, slanted);
    const std::string plain =
        svg("<rect width='40' height='5'/><rect width='40' height='5'/><path d='M0 0h40'/>");
    CHECK(drawn(text) == drawn(plain));
    CHECK(drawn(moved.text) == drawn(plain, slanted));
    CHECK(moved.text.find("<!ENTITY size '40'>") != std::string::npos);
    CHECK(moved.text.find("fill:&#x72;ed") != std::string::npos);
    CHECK(moved.text.find("&far;&none;") != std::string::npos);
    std::string laughs = "<!DOCTYPE svg [<!ENTITY a0 'ha'>";
    for (int i = 1; i < 40; ++i) {
        const std::string before = "&a" + std::to_string(i - 1) + ';';
        laughs += "<!ENTITY a" + std::to_string(i) + " '" + before + before + "'>";
    }
    for (const std::string& bad :
         {laughs + "]><svg>&a19;&a20;&a21;&a22;</svg>", laughs + "]><svg a='&a39;'/>",
          std::string("<!DOCTYPE svg [<!ENTITY l '&l;'>]><svg>&l;</svg>"),
          std::string("<!DOCTYPE svg [<!ENTITY l '<g>'>]><svg>&l;</svg>"),
          std::string("<!DOCTYPE svg [<!ENTITY l '<'><!ENTITY m 'a&l;'>]><svg a='&m;'/>")}) {
        const auto refused = parse_svg(bad, "bad.svg");
        REQUIRE_FALSE(refused);
        CHECK(refused.error().message.find("entity") != std::string::npos);
    }

    // attributes declared in the document type; the first declaration of an attribute counts
    const std::string defaults = R"x(<!DOCTYPE svg [<!-- <!ATTLIST rect y CDATA "7"> --><!ENTITY w '31'>
<!ATTLIST rect width CDATA "&w;" kind (a|b) #REQUIRED note NOTATION (n) #IMPLIED height CDATA #FIXED '12'>
<!ATTLIST rect width CDATA "99" x NMTOKEN '5'>
<!ATTLIST g transform CDATA "translate(3 4)"><!ATTLIST rect>]>)x";
    CHECK(drawn(defaults + svg("<rect/><g><rect x='8' width='2'/></g>")) ==
          drawn(svg("<rect x='5' width='31' height='12'/><rect x='11' y='4' width='2' height='12'/>")));

    const std::string own =
        "<!DOCTYPE svg [<!ENTITY lt '&#38;#60;'><!ENTITY gt '&#62;'><!ENTITY amp '&#38;#38;'>"
        "<!ENTITY apos '&#39;'><!ENTITY quot '&#34;'><!ENTITY x 'y'>]>";
    const std::string kept = "<svg a=\"&lt;&amp;&quot;\">a &lt; &gt; &apos; ";
    CHECK(to_text(parsed(own + kept + "&x;</svg>")) == own + kept + "y</svg>");
    CHECK(to_text(parsed(own + "<svg a=\"&x\">&x</svg>")).ends_with("<svg a=\"&x\">&x</svg>"));
    const std::string unknown = std::string(300'000, '&') + ';'; // each lookup was complete
    CHECK(to_text(parsed(own + "<svg>" + unknown + "</svg>")).ends_with(unknown + "</svg>"));
    std::string open = "<!DOCTYPE svg [", nested;
    for (int i = 0; i < 60'000; ++i) open += i % 2 == 0 ? "<!ENTITY " : "<!ATTLIST ", nested += "<b:g>";
    for (int i = 0; i < 60'000; ++i) open += '>';
    CHECK(parse_svg(open + "]><svg/>", "open.svg"));
    for (int i = 0; i < 60'000; ++i) nested += "</b:g>";
    const auto too_deep = parse_svg("<svg xmlns:b='x'>" + nested + "</svg>", "deep.svg");
    CHECK((!too_deep && too_deep.error().message.find("nested too deeply") != std::string::npos));

    const std::string space = "http://www.w3.org/2000/svg", line = "line x2='9' y2='4'/>";
    for (const std::string& mixed :
         {"<svg xmlns='" + space + "' xmlns:s='" + space + "'><s:g><s:" + line + "</s:g><" + line + "</svg>",
          "<s:svg xmlns:s='" + space + "'><g xmlns='" + space + "'><" + line + "</g><s:" + line + "</s:svg>",
          "<svg xmlns='" + space + "'><q:" + line.substr(0, line.size() - 2) + " xmlns:q='" + space + "'/><" +
              line + "<o:" + line.substr(0, line.size() - 2) + " xmlns:o='other'/></svg>"}) {
        CAPTURE(mixed);
        const std::string once = "M0 0 L9 4\n";
        CHECK(drawn(mixed) == once + once);
    }
}

TEST_CASE("references are resolved to their ids", "[examples][svg_style][references]") {
    // an id of any characters; a reference may contain them directly, as bytes after "%", or as numbers
    const auto seed = GENERATE(range(0, 30));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    std::string id = "k", plain = "#k";
    for (std::size_t n = 1 + random.below(5); n > 0; --n) {
        const std::uint32_t code =
            std::vector<std::uint32_t>{'b', '-', 0xe9, 0x3b1, 0x4e2d, 0x1f600}[random.below(6)];
        const std::string letter = detail::utf8(code);
        const std::string numbered = "&#" + std::to_string(code) + ';';
        std::string bytes;
        for (const char c : letter) {
            constexpr std::string_view digits = "0123456789aBCDEF";
            const auto byte = static_cast<unsigned char>(c);
            bytes += {'%', digits[byte / 16], digits[byte % 16]};
        }
        id += random.any_of({letter, numbered});
        plain += random.any_of({letter, numbered, bytes});
    }
    CAPTURE(id, plain);
    const std::string shape = "<path id='" + id + "' d='M1 2h9v5z'/>";
    const std::string used = "<defs>" + shape + "</defs><use href='" + plain + "' x='4'/>";
    CHECK(drawn(svg(used)) == drawn(svg("<path d='M5 2h9v5z'/>")));
    const std::string cut = "<clipPath id='" + id + "'><path d='M1 1h5v5z'/></clipPath>" +
                            "<path d='M0 0h9v9z' clip-path='URL(" + plain + ")'/>";
    const Result moved = deformed(svg(cut), slanted);
    const auto clipped =
        parse_path_data(by_name(moved.document.xml, "clipPath").first_child().attribute("d").value());
    REQUIRE(clipped);
    CHECK(write_path_data(*clipped, 3) + '\n' == drawn(svg("<path d='M1 1h5v5z'/>"), slanted));
}

TEST_CASE("properties that are not applied are reported", "[examples][svg_style][warnings]") {
    const Result moved = deformed(R"(<?xml-stylesheet href="a.css"?>)" + svg(R"x(<style>
@import url(more.css);
@keyframes spin { to { transform: none } }
.s { animation: spin 2s; fill: red; -x-ink: 3; --own: 1 }
@scope (g) { path { fill: red } }
@media (max-width: 9px) { path { translate: 3px } }
</style>
<rect class="s" width="9" height="9" style="Offset-Path:none;-x-ink:4;offset-path:path('M0 0')"/>
<path d="M1 1h2v2z" zorble="3" data-x="1" onclick="x" aria-label="b"><animate attributeName="d" values=""/>
<animate attributeName="fill" values="red"/><animateTransform/><set attributeName="points"/></path>
<flowRoot><flowRegion><rect unheard="1"/></flowRegion></flowRoot><g transition="x 2s" animation="none"/>
<sodipodi:namedview zoom="3"/><foreignObject width="1" height="1"><p xmlns="h" odd="1"/></foreignObject>)x"),
                                  slanted);
    const std::vector<std::string> expected{
        "foreignObject (line 12): is not deformed; it moves and turns as a whole",
        "style (line 2): \"@import url(more.css)\" is not read",
        "style (line 4): the property \"animation\" is not deformed: spin 2s",
        "style (line 4): the property \"-x-ink\" is not known and stays unchanged (2 times)",
        "style (line 5): \"@scope (g)\" is not read",
        "style (line 6): the property \"translate\" of \"path\" is not deformed",
        "xml-stylesheet: another file is not read: href=\"a.css\"",
        "rect (line 8): the property \"offset-path\" is not deformed: path('M0 0')",
        "path (line 9): the property \"zorble\" is not known and stays unchanged",
        "animate (line 9): animate is not deformed: it animates d",
        "animateTransform (line 10): animateTransform is not deformed: it animates the transform",
        "set (line 10): set is not deformed: it animates points",
        "flowRoot (line 11): flowRoot is not deformed and stays unchanged",
        "g (line 11): the property \"transition\" is not deformed: x 2s"};
    for (std::size_t i = 0; i < std::max(expected.size(), moved.warnings.size()); ++i) {
        CHECK((i < moved.warnings.size() ? moved.warnings[i] : "") ==
              (i < expected.size() ? expected[i] : ""));
    }
}

TEST_CASE("every unknown property is reported", "[examples][svg_style][warnings][fuzz]") {
    const auto seed = GENERATE(range(0, 100));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const std::string letters = "abcdefghijklmnopqrstuvwxyz";
    std::map<std::string, int> counts;
    std::string content;
    const auto name = [&] {
        std::string made = random.any_of({"", "-", "-webkit-", "-inkscape-", "fill-", "stroke-", "x"});
        for (std::size_t n = 3 + random.below(6); n > 0; --n) made += letters[random.below(letters.size())];
        return made;
    };
    while (counts.size() < 6) {
        const std::string property = name();
        if (property.starts_with("on") || detail::use_of(property) != detail::PropertyUse::unknown) continue;
        if (counts[property] != 0) continue;
        for (std::size_t n = 1 + random.below(3); n > 0; --n) {
            ++counts[property];
            const std::string path = "<path d='M1 1h2v2z' ";
            switch (random.below(property.starts_with('-') ? 2 : 3)) {
            case 0: content += path + "style='fill:red;" + property + ": 1px'/>\n"; break;
            case 1: content += "<style>.none, path{" + property + ":2}</style>\n" + path + "/>"; break;
            default: content += path + property + "='3'/>\n"; break;
            }
        }
    }
    const auto warnings = deformed(svg(content), slanted).warnings;
    CHECK(warnings.size() == counts.size());
    for (const auto& [property, count] : counts) {
        CAPTURE(content, property);
        const std::string times = count > 1 ? " (" + std::to_string(count) + " times)" : "";
        const std::string end =
            "): the property \"" + property + "\" is not known and stays unchanged" + times;
        CHECK(std::count_if(warnings.begin(), warnings.end(),
                            [&](const std::string& each) { return each.ends_with(end); }) == 1);
    }
}

} // namespace svg_style_tests
