// Gradients, patterns and regions of filters follow their shapes, and visible parts stay visible.

#include "svg/motion.hpp"
#include "svg/style.hpp"
#include "svg/walk.hpp"
#include "svg/xml.hpp"

#include "svg_texts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace svg_paint_tests {

using namespace cageform_support;
using detail::Box;
using namespace svg_texts;
using Result = Deformed;

namespace {

/// Bends the x axis.
bool bend(std::span<const Point2> in, std::span<Point2> out) {
    std::transform(in.begin(), in.end(), out.begin(),
                   [](const Point2& p) { return Point2{p.x, p.y + 0.01 * (p.x - 50) * (p.x - 50)}; });
    return true;
}

Affine2 transform_of(pugi::xml_node node) {
    const auto map = parse_transform(node.attribute("transform").value());
    REQUIRE(map);
    return *map;
}

std::string number(double v) {
    return format_number(v, 9);
}

/// The attribute of a gradient or pattern, or of those that it refers to.
std::string chain_text(const SvgDocument& document, pugi::xml_node node, const char* name) {
    for (int i = 0; node && i < 9; ++i) {
        if (node.attribute(name)) return node.attribute(name).value();
        const std::string next = detail::reference_of(node);
        node = next.empty() ? pugi::xml_node() : by_id(document, next.substr(1));
    }
    return {};
}

/// The map from a paint server's coordinates to the root, as in a renderer, for the only shape of a document.
Affine2 server_to_root(const SvgDocument& document, std::string_view property, const char* transform,
                       const char* units) {
    SvgDocument copy = detail::copy_of(document);
    const pugi::xml_node root = detail::root_element(copy.xml);
    detail::StyleSheets styles(copy);
    detail::IdTable ids(root);
    std::vector<std::string> ignored;
    const auto drawing = detail::walk(copy, styles, ids, {}, ignored);
    REQUIRE(drawing);
    REQUIRE(drawing->shapes.size() == 1);
    const detail::DrawnShape& shape = drawing->shapes.front();
    const std::string id = detail::referenced_id(property == "fill" ? shape.fill : shape.stroke);
    const pugi::xml_node server = by_id(copy, id);
    INFO(id);
    REQUIRE(server);
    const auto map = parse_transform(chain_text(copy, server, transform));
    REQUIRE(map);
    if (chain_text(copy, server, units) == "userSpaceOnUse") return compose(shape.to_root, *map);
    const Box box = detail::bounds(shape.path, shape.from_root);
    return compose(compose(shape.to_root, {box.width(), 0, 0, box.height(), box.x0, box.y0}), *map);
}

double distance(const Point2& a, const Point2& b) {
    return std::hypot(a.x - b.x, a.y - b.y);
}

/// A shape painted by url(#paint), written in one of the possible ways.
std::string painted_shape(Random& random, const std::string& property) {
    const std::string value = random.below(2) == 0 ? "url(#paint)" : "url('#paint') red";
    const std::string transform =
        random.below(3) == 0 ? "" : " transform=\"" + detail::write_transform(random.map(9)) + '"';
    std::string sheet, own, outer;
    switch (random.below(6)) {
    case 0: own = ' ' + property + "=\"" + value + '"'; break;
    case 1: own = " style=\"fill-opacity:1; " + property + ": " + value + " ;stroke-width:2\""; break;
    case 2: outer = ' ' + property + "=\"" + value + '"'; break;
    case 3: own = " class=\"x a\"", sheet = ".a, b { " + property + ":" + value + " }"; break;
    case 4:
        own = " class=\"a\" " + property + "=\"blue\" style=\"opacity:.5\"";
        sheet = "g > .a{" + property + ":" + value + "!important}";
        break;
    default: own = " id=\"s\"", sheet = "#s{" + property + ":" + value + "}"; break;
    }
    const double x = random.in(10, 60), y = random.in(10, 60), w = random.in(5, 30), h = random.in(5, 30);
    std::string shape;
    switch (random.below(3)) {
    case 0:
        shape = "<rect x=\"" + number(x) + "\" y=\"" + number(y) + "\" width=\"" + number(w) +
                "\" height=\"" + number(h) + '"';
        break;
    case 1:
        shape = "<ellipse cx=\"" + number(x) + "\" cy=\"" + number(y) + "\" rx=\"" + number(w) + "\" ry=\"" +
                number(h) + '"';
        break;
    default:
        shape = "<path d=\"M" + number(x) + ' ' + number(y) + " c " + number(w) + " 0 0 " + number(h) + ' ' +
                number(w) + ' ' + number(-h) + " z\"";
    }
    return (sheet.empty() ? "" : "<style>" + sheet + "</style>") + "<g" + outer + transform + '>' + shape +
           own + "/></g>";
}

} // namespace

TEST_CASE("gradients follow affine maps of their shapes exactly",
          "[examples][svg_document][paint][property]") {
    const auto seed = GENERATE(range(0, 60));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const std::string kind = random.below(2) == 0 ? "linearGradient" : "radialGradient";
    const std::string property = random.below(3) == 0 ? "stroke" : "fill";
    const std::string units = random.below(3) == 0 ? "" : " gradientUnits=\"userSpaceOnUse\"";
    const std::string own =
        random.below(2) == 0 ? "" : " gradientTransform=\"" + detail::write_transform(random.map(3)) + '"';
    const bool refers = random.below(2) == 0; // stops and attributes are inherited
    const bool is_linear = kind == "linearGradient";
    const std::string place = random.below(2) == 0 ? ""
                              : is_linear          ? " x1=\".3\" y2=\"7\""
                                                   : " cx=\".3\" fy=\"7\"";
    std::string text = "<" + kind + " id=\"" + (refers ? "base" : "paint") + "\"" + units + own + place +
                       "><stop offset=\"0\"/></" + kind + ">";
    if (refers) text += "<" + kind + " id=\"paint\" href=\"#base\"/>";
    text = svg(text + painted_shape(random, property));
    CAPTURE(text);
    const Affine2 pose = random.map(30);
    const Result result = deformed(text, by(pose));
    CAPTURE(result.text);
    const Affine2 before = server_to_root(parsed(text), property, "gradientTransform", "gradientUnits");
    const Affine2 after = server_to_root(result.document, property, "gradientTransform", "gradientUnits");
    const double unit = units.empty() ? 1 : 50;
    for (const Point2& p : Box{0, 0, unit, unit}.corners()) {
        CHECK(distance(apply(after, p), apply(pose, apply(before, p))) < 0.02);
    }
    CHECK(result.report.warnings.empty());
    const SvgDocument document = parsed(text);
    for (const pugi::xml_node copy : detail::root_element(result.document.xml).children(kind.c_str())) {
        const std::string_view id = copy.attribute("id").value();
        if (id == "base" || id == "paint" || id.ends_with("-stops-2")) continue;
        // It has its own coordinates, and inherits only stops.
        const auto given = [&](const char* name, std::string_view otherwise) {
            const std::string value = chain_text(document, by_id(document, "paint"), name);
            CHECK(std::string_view(copy.attribute(name).value()) == (value.empty() ? otherwise : value));
        };
        given("gradientUnits", "objectBoundingBox");
        for (const char* name : {"x1", "y1"}) given(name, is_linear ? "0%" : "");
        given("x2", is_linear ? "100%" : "");
        given("y2", is_linear ? "0%" : "");
        for (const char* name : {"cx", "cy", "r"}) given(name, is_linear ? "" : "50%");
        for (const char* name : {"fx", "fy", "spreadMethod"}) given(name, "");
        const auto stops = by_id(result.document, detail::reference_of(copy).substr(1));
        CHECK(stops.child("stop"));
        for (const auto attribute : stops.attributes()) CHECK(std::string_view(attribute.name()) == "id");
    }
    // again: the copy of a gradient can be copied
    const Result again = deformed(result.text, by(pose));
    const Affine2 twice = server_to_root(again.document, property, "gradientTransform", "gradientUnits");
    CHECK(distance(apply(twice, {}), apply(pose, apply(pose, apply(before, {})))) < 0.06);
}

TEST_CASE("patterns follow affine maps of their shapes exactly",
          "[examples][svg_document][paint][property]") {
    const auto seed = GENERATE(range(0, 30));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const bool of_box = random.below(2) == 0;
    const bool content_of_box = random.below(2) == 0;
    std::string text =
        "<pattern id=\"paint\" x=\".1\" y=\"20%\" width=\".5\" height=\".25\" patternTransform=\"" +
        detail::write_transform(random.map(3)) + '"' + (of_box ? "" : " patternUnits=\"userSpaceOnUse\"") +
        (content_of_box ? " patternContentUnits=\"objectBoundingBox\"" : "") +
        "><path id=\"dot\" d=\"M0 0H.1V.1Z\"/></pattern>";
    text = svg(text + painted_shape(random, "fill"));
    CAPTURE(text);
    const Affine2 pose = random.map(30);
    const Result result = deformed(text, by(pose));
    CAPTURE(result.text);
    // From the coordinates of the tile (corner and units as in a renderer) to the root.
    const auto tile_to_root = [](const SvgDocument& document) {
        SvgDocument copy = detail::copy_of(document);
        const pugi::xml_node root = detail::root_element(copy.xml);
        detail::StyleSheets styles(copy);
        detail::IdTable ids(root);
        std::vector<std::string> ignored;
        const auto drawing = detail::walk(copy, styles, ids, {}, ignored);
        REQUIRE(drawing);
        const detail::DrawnShape& shape = drawing->shapes.front();
        const pugi::xml_node pattern = by_id(copy, detail::referenced_id(shape.fill));
        REQUIRE(pattern);
        const Box box = detail::bounds(shape.path, shape.from_root);
        const bool user = std::string_view(pattern.attribute("patternUnits").value()) == "userSpaceOnUse";
        const auto length = [&](const char* name, double whole, double start) {
            const double v = *parse_length(pattern.attribute(name).value(), user ? 100 : 1);
            return user ? v : start + v * whole;
        };
        const Point2 corner{length("x", box.width(), box.x0), length("y", box.height(), box.y0)};
        const Point2 size{length("width", box.width(), 0), length("height", box.height(), 0)};
        Point2 unit{1, 1};
        if (pattern.attribute("viewBox")) {
            const auto view = parse_numbers(pattern.attribute("viewBox").value());
            CHECK(std::string_view(pattern.attribute("preserveAspectRatio").value()) == "none");
            unit = {size.x / (*view)[2], size.y / (*view)[3]};
        } else if (std::string_view(pattern.attribute("patternContentUnits").value()) ==
                   "objectBoundingBox") {
            unit = {box.width(), box.height()};
        }
        const Affine2 map = *parse_transform(pattern.attribute("patternTransform").value());
        const Affine2 placed = compose(compose(shape.to_root, map), {1, 0, 0, 1, corner.x, corner.y});
        return std::pair(compose(placed, {unit.x, 0, 0, unit.y, 0, 0}),  // of the content
                         compose(placed, {size.x, 0, 0, size.y, 0, 0})); // of the tile
    };
    const auto before = tile_to_root(parsed(text));
    const auto after = tile_to_root(result.document);
    for (const Point2& p : Box{0, 0, 1, 1}.corners()) {
        CHECK(distance(apply(after.first, p), apply(pose, apply(before.first, p))) < 0.02);
        CHECK(distance(apply(after.second, p), apply(pose, apply(before.second, p))) < 0.02);
    }
}

TEST_CASE("shapes that share a gradient share a copy where one map is right for both",
          "[examples][svg_document][paint]") {
    const std::string gradient =
        R"(<linearGradient id="g" gradientUnits="userSpaceOnUse" x2="100"><stop offset="0"/></linearGradient>)";
    const std::string shapes =
        R"x(<rect width="9" height="9" fill="url(#g)"/><rect id="g-2" x="80" width="9" height="9" fill="url(#g)"/>)x";
    const Result bent = deformed(svg(gradient + shapes), bend);
    CHECK(by_id(bent.document, "g-3")); // g-2 is taken
    CHECK(by_id(bent.document, "g-4"));
    CHECK(bent.text.find(R"(<linearGradient id="g-stops-2"><stop offset="0"/></linearGradient>)") !=
          std::string::npos);
    CHECK(bent.text.find("<stop") == bent.text.rfind("<stop", bent.text.rfind("<stop") - 1)); // two in all
    CHECK(bent.document.xml.document_element().attribute("xmlns:xlink"));
    // shapes with the same motion, up to the tolerance, share a copy; unmoved shapes keep the original
    const Deformer nearly = [](std::span<const Point2> in, std::span<Point2> out) {
        std::transform(in.begin(), in.end(), out.begin(),
                       [](const Point2& p) { return Point2{p.x + 5, p.y + 1e-6 * std::sin(p.x)}; });
        return true;
    };
    const Result shifted = deformed(svg(gradient + shapes), nearly);
    CHECK(by_id(shifted.document, "g-3"));
    CHECK_FALSE(by_id(shifted.document, "g-4"));
    const std::string box = R"x(<linearGradient id="b"/><rect width="9" height="9" fill="url(#b)"/>)x";
    CHECK_FALSE(by_id(deformed(svg(box), by({2, 0, 0, 3, 5, 0})).document, "b-2")); // goes with the box
    CHECK(by_id(deformed(svg(box), by({1, 1, 0, 1, 0, 0})).document, "b-2"));
    // cycles end, and other elements are not changed
    const Result odd =
        deformed(svg(R"x(<linearGradient id="a" href="#b"/><linearGradient id="b" href="#a"/><mask id="m"/>
                <rect width="9" height="9" fill="url(#a)" stroke="url(#m)"/>)x"),
                 by({1, 1, 0, 1, 0, 0}));
    CHECK(by_id(odd.document, "a-2"));
}

TEST_CASE("the best affine map of a motion is found", "[examples][svg_document][paint][property]") {
    const auto seed = GENERATE(range(0, 40));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    std::vector<Point2> points;
    const double thin = std::pow(10.0, random.in(-5, 0)); // perpendicular to a line of length 50 at any angle
    const double c = std::cos(seed), s = std::sin(seed);
    for (int i = 0; i < 30; ++i) {
        const double u = random.in(-25, 25), v = thin * random.in(-25, 25);
        points.push_back({c * u - s * v + 40, s * u + c * v - 300});
    }
    const auto motion_of = [&](const auto& map) {
        std::array<detail::Motion, 2> halves;
        for (std::size_t i = 0; i < points.size(); ++i) halves[i % 2].add(points[i], map(points[i]), 1);
        halves[0].add(halves[1]);
        return halves[0];
    };
    // affine motions are found exactly
    const Affine2 pose = random.map(50);
    const auto exact = motion_of([&](const Point2& p) { return apply(pose, p); }).best_map();
    REQUIRE(exact);
    for (const Point2& p : points) CHECK(distance(apply(*exact, p), apply(pose, p)) < 1e-6);

    // for others the sum of squares is minimal: no nearby map is better by more than the ridge term
    const auto bent = [](const Point2& p) { return Point2{p.x, p.y + 0.004 * (p.x - 40) * (p.x - 40)}; };
    const auto best = motion_of(bent).best_map();
    REQUIRE(best);
    const auto missed = [&](const Affine2& m) {
        double sum = 0;
        for (const Point2& p : points) sum += std::pow(distance(apply(m, p), bent(p)), 2);
        return sum;
    };
    for (int i = 0; i < 20; ++i) {
        Affine2 other = *best;
        for (double* entry : {&other.a, &other.b, &other.c, &other.d}) *entry += random.in(-0.2, 0.2);
        const Point2 p = apply(*best, {40, -300}), q = apply(other, {40, -300});
        other.e += p.x - q.x, other.f += p.y - q.y;
        CHECK(missed(*best) <= 1.05 * missed(other));
    }
    // points near the shape never move far away, however thin the shape is
    const Point2 beside{40 - 10 * s, -300 + 10 * c};
    CHECK(distance(apply(*best, beside), apply(*best, {40, -300})) < 60);
}

TEST_CASE("motions without an affine map are recognized", "[examples][svg_document][paint]") {
    detail::Motion point, line, gone, still;
    point.add({3, 4}, {5, 6}, 1);
    REQUIRE(point.best_map());
    CHECK(apply(*point.best_map(), {0, 0}) == Point2{2, 2});
    for (int i = 0; i <= 10; ++i) {
        line.add({double(i), 1}, {1, 2.0 * i}, 1); // a quarter turn and a scale of two
        gone.add({double(i), double(i * i)}, {7, 7}, 1);
        still.add({double(i), 1}, {double(i), 1}, 1);
    }
    REQUIRE(line.best_map());
    CHECK(distance(apply(*line.best_map(), {5, 2}), {-1, 10}) < 1e-6);
    CHECK_FALSE(gone.best_map());
    CHECK(*still.best_map() == Affine2());
    CHECK_FALSE(still.moved());
}

TEST_CASE("declarations and rules end where CSS says", "[examples][svg_document][style]") {
    const auto fill = [](std::string_view css, std::string_view element) {
        SvgDocument document =
            parsed(svg("<style>" + std::string(css) + "</style><g><a>" + std::string(element) + "</a></g>"));
        const detail::StyleSheets styles(document);
        return styles
            .value(document.xml.find_node(
                       [](pugi::xml_node node) { return detail::local_name(node) == "path"; }),
                   "fill")
            .text;
    };
    CHECK(fill("", "<path/>").empty());
    CHECK(fill("", "<path fill=' red '/>") == "red");
    CHECK(fill("path{fill:red !important}", "<path style='fill:blue ! important'/>") == "blue");
    CHECK(fill("", "<path style='fill:blue;fill:url(a;b)'/>") == "url(a;b)");
    CHECK(fill("", "<path style='font-family:&quot;a;fill:red&quot;;fill:tan'/>") == "tan");
    CHECK(fill("", "<path style='/*fill:red;*/fill-rule:evenodd;x:\"fill:red\"'/>").empty());
    CHECK(fill("path{fill:red}@media all{@media /**/{path{fill:tan}}@media tv{path{fill:blue}}}",
               "<path/>") == "tan");
    CHECK(fill("@media{@media{path{fill:red", "<path/>") == "red");
    std::string deep; // as deeply nested as an attacker likes
    for (int i = 0; i < 100'000; ++i) deep += "@media{";
    CHECK(fill(deep + "path{fill:red}", "<path/>").empty());
    CHECK(fill("@import 'x;{';/*}*/path{fill:red", "<path/>") == "red"); // the end closes what is open
    CHECK(fill("path:hover{fill:red}path[d]{fill:red}a+path{fill:red}", "<path/>").empty());
    CHECK(fill("<![CDATA[g path{fill:url(\"#a\")}]]>", "<path/>") == "url(\"#a\")");
    for (const std::string_view broken : {"{", "}", "path{", "path{fill", "a{}}path{x:(", "/*", "'", "@",
                                          ">{fill:red}", "{fill:red}", ",,{fill:red}", "path >{fill:red"}) {
        CAPTURE(broken);
        CHECK((fill(broken, "<path/>").empty() || fill(broken, "<path/>") == "red"));
    }
}

TEST_CASE("regions of filters and masks contain the moved shape",
          "[examples][svg_document][paint][property]") {
    const auto seed = GENERATE(range(0, 30));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const bool mask = random.below(2) == 0;
    const bool user = random.below(2) == 0;
    const std::string kind = mask ? "mask" : "filter";
    // 4 units around the shape
    const std::string region =
        user ? "x=\"26\" y=\"36\" width=\"28\" height=\"18\" " + kind + "Units=\"userSpaceOnUse\""
             : std::string("x=\"-.2\" y=\"-.4\" width=\"1.4\" height=\"1.8\"");
    const std::string content = mask ? "<rect width='100' height='100' fill='white'/>" : "<feGaussianBlur/>";
    const std::string text =
        svg("<" + kind + " id=\"r\" " + region + ">" + content + "</" + kind + "><g " + kind +
            "=\"url(#r)\"><rect x=\"30\" y=\"40\" width=\"20\" height=\"10\"/></g>");
    const Result result = deformed(text, by(random.map(20)));
    CAPTURE(result.text);
    const auto all = shapes(result.document);
    REQUIRE(all);
    const Affine2 own = transform_of(
        detail::root_element(result.document.xml).child("g")); // the filter moves with this transform
    const Box moved = detail::bounds(all->front().path, *inverse(own));
    const pugi::xml_node node = by_id(result.document, "r");
    const auto value = [&](const char* name) { return node.attribute(name).as_double(); };
    Box held{value("x"), value("y"), value("x") + value("width"), value("y") + value("height")};
    if (!user) {
        held = {moved.x0 + held.x0 * moved.width(), moved.y0 + held.y0 * moved.height(),
                moved.x0 + held.x1 * moved.width(), moved.y0 + held.y1 * moved.height()};
    }
    CHECK(held.contains(moved.grown(3.9)));
    CHECK(result.report.warnings.empty());

    const std::string cutting =
        svg(R"x(<mask id="r" x="35" width="5" height="100" maskUnits="userSpaceOnUse"/>
        <rect mask="url(#r)" x="30" y="40" width="20" height="10"/>)x");
    const Affine2 map = random.map(20);
    const Result cut = deformed(cutting, by(map)); // a clip path in the mask replaces its region
    const pugi::xml_node clip = by_id(cut.document, "r").child("clipPath").child("path");
    const auto path = parse_path_data(clip.attribute("d").value());
    REQUIRE(path);
    REQUIRE(path->size() == 1);
    const auto corners = Box{35, -10, 40, 90}.corners();
    CHECK(distance(path->front().start, apply(map, corners[0])) < 1e-3);
    for (std::size_t k = 1; k < 4; ++k)
        CHECK(distance(path->front().segments.at(k - 1).p3, apply(map, corners[k])) < 1e-3);
    CHECK(cut.report.warnings.empty());
}

TEST_CASE("primitives and lights of a filter in user space move with the shape",
          "[examples][svg_document][paint][property]") {
    const auto seed = GENERATE(range(0, 30));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const Affine2 map = random.map(20);
    const std::string rect =
        R"x(<rect filter="url(#r)" x="30" y="40" width="20" height="10" stroke="red"/>)x";
    const auto filter = [](const std::string& content) {
        return "<filter id=\"r\">" + content + "</filter>";
    };
    const auto find = [](const Result& result, std::string_view kind) {
        return result.document.xml.find_node(
            [&](pugi::xml_node node) { return detail::local_name(node) == kind; });
    };
    const auto box_of = [](pugi::xml_node node) {
        const auto value = [&](const char* name) { return node.attribute(name).as_double(); };
        return Box{value("x"), value("y"), value("x") + value("width"), value("y") + value("height")};
    };
    // 3 units around the shape
    const Result whole =
        deformed(svg(filter(R"(<feFlood x="27" y="37" width="26" height="16"/>)") + rect), by(map));
    const auto all = shapes(whole.document);
    REQUIRE(all);
    const Affine2 turn = transform_of(find(whole, "path")); // only the turn, as the stroke keeps its width
    const Affine2 left = compose(*inverse(turn), map);
    CHECK(std::abs(turn.a * turn.a + turn.b * turn.b - 1) < 1e-6);
    CHECK(std::abs(left.b - left.c) < 1e-6 * detail::largest_scale(map));
    CHECK(box_of(find(whole, "feFlood"))
              .contains(detail::bounds(all->front().path, *inverse(turn)).grown(2.9)));
    CHECK(whole.report.warnings.empty());

    // the left half of the filter's own region, which the missing attributes default to
    const Result half = deformed(svg(filter(R"(<feFlood width="12"/>)") + rect), by(map));
    Box cut;
    for (const Point2& p : Box{28, 39, 40, 51}.corners()) cut.add(apply(left, p));
    const Box held = box_of(find(half, "feFlood"));
    CHECK(held.x0 == Approx(cut.x0).epsilon(0).margin(1e-3));
    CHECK(held.y0 == Approx(cut.y0).epsilon(0).margin(1e-3));
    CHECK(held.x1 == Approx(cut.x1).epsilon(0).margin(1e-3));
    CHECK(held.y1 == Approx(cut.y1).epsilon(0).margin(1e-3));
    REQUIRE(half.report.warnings.size() == 1);
    CHECK(half.report.warnings[0].find("feFlood") == 0);

    const std::string lit =
        filter(R"(<feDiffuseLighting><feSpotLight x="31" y="42" z="9" pointsAtX="45"/></feDiffuseLighting>)");
    const Result moved = deformed(svg(lit + rect), by(map));
    const pugi::xml_node light = find(moved, "feSpotLight");
    const auto at = [&](const char* x, const char* y) {
        return Point2{light.attribute(x).as_double(), light.attribute(y).as_double()};
    };
    CHECK(distance(at("x", "y"), apply(left, {31, 42})) < 1e-4);
    CHECK(distance(at("pointsAtX", "pointsAtY"), apply(left, {45, 0})) < 1e-4);
    CHECK(light.attribute("z").as_double() == 9);
    CHECK(moved.report.warnings.empty());
    const Result shared = deformed(svg(lit + rect + rect), by(map)); // one light for two shapes
    CHECK(find(shared, "feSpotLight").attribute("x").as_double() == 31);
    REQUIRE(!shared.report.warnings.empty());
    CHECK(shared.report.warnings[0].find("feSpotLight") == 0);

    const std::string in_boxes =
        R"(<filter id="r" primitiveUnits="objectBoundingBox"><feFlood x=".1" width=".5"/></filter>)";
    CHECK(find(deformed(svg(in_boxes + rect), by(map)), "feFlood").attribute("x").as_double() == 0.1);

    // without a stroke the element itself moves, and its filter is unchanged
    const std::string plain = R"x(<rect filter="url(#r)" x="30" y="40" width="20" height="10"/>)x";
    const Result carried = deformed(svg(lit + plain + plain), by(map));
    CHECK(carried.text.find(lit) != std::string::npos);
    const Affine2 own = transform_of(find(carried, "path"));
    for (const Point2& p : Box{0, 0, 100, 100}.corners())
        CHECK(distance(apply(own, p), apply(map, p)) < 1e-5);
    CHECK(find(carried, "path").attribute("d").value() == std::string("M30 40 L50 40 L50 50 L30 50 Z"));
    CHECK(carried.report.warnings.empty());
    // noise is positioned in user space: a translation moves it too
    const Affine2 shift{1, 0, 0, 1, map.e, map.f};
    const Affine2 noisy =
        transform_of(find(deformed(svg(filter("<feTurbulence/>") + plain), by(shift)), "path"));
    CHECK(distance(apply(noisy, {}), apply(shift, {})) < 1e-5);
}

TEST_CASE("a nested svg clips the same content after a deformation", "[examples][svg_document][clip]") {
    const std::string inside = R"(<rect width="6" height="6"/>)";
    const std::string across = R"(<rect width="60" height="6"/>)";
    const std::string open = R"(<svg x="10" y="10" width="20" height="20" viewBox="0 0 10 10">)";
    // a clip without effect is removed
    const Result whole = deformed(svg(open + inside + "</svg>"), by({1, 0, 0, 1, 50, 0}));
    CHECK(whole.text.find("overflow=\"visible\"") != std::string::npos);
    CHECK(whole.text.find("clipPath") == std::string::npos);
    // a clip with an effect becomes a group with a clip path that moves
    for (const bool symbol : {false, true}) {
        CAPTURE(symbol);
        const std::string text = symbol
                                     ? R"(<symbol id="s" viewBox="0 0 10 10">)" + across +
                                           R"(</symbol><use href="#s" x="10" y="10" width="20" height="20"/>)"
                                     : open + across + "</svg>";
        const Result cut = deformed(svg(text), by({1, 0, 0, 1, 50, 0}));
        CAPTURE(cut.text);
        const pugi::xml_node clip = cut.document.xml.find_node(
            [](pugi::xml_node node) { return detail::local_name(node) == "clipPath"; });
        REQUIRE(clip);
        CHECK(std::string(clip.child("path").attribute("d").value()) == "M25 0 L35 0 L35 10 L25 10 Z");
        CHECK(std::string(clip.next_sibling().attribute("clip-path").value()) == "url(#cageform-clip-2)");
        CHECK(cut.report.cut_off == 0); // the clip path ends inside the picture
    }
    CHECK(deformed(svg(R"(<svg width="5" height="5" overflow="visible">)" + across + "</svg>"),
                   by({1, 0, 0, 1, 5, 0}))
              .text.find("clip") == std::string::npos);
}

TEST_CASE("the option --fit enlarges the picture to the moved shapes", "[examples][svg_document][fit]") {
    const std::string text =
        R"(<svg viewBox="0 0 100 50" width="200px" height="50mm"><rect width="10" height="10"/>
<rect x="-50" y="20" width="60" height="5"/><rect x="-300" width="5" height="5"/><rect x="80" width="9" height="9" fill="none"/></svg>)";
    const Affine2 right{1, 0, 0, 1, 100, 0};
    CHECK(deformed(text, by({1, 0, 0, 1, 80, 0})).report.cut_off == 0); // the second shape becomes visible
    const Result cut = deformed(text, by(right));
    CHECK(cut.report.cut_off == 2);
    CHECK(cut.text.find("viewBox=\"0 0 100 50\"") != std::string::npos);
    const Result fitted = deformed(text, by(right), {.fit = true});
    CHECK(fitted.report.cut_off == 0);
    const auto view = view_box(fitted.document);
    CHECK(view.x == Approx(0).epsilon(0).margin(0.5));
    CHECK(view.width == Approx(110).epsilon(0).margin(0.5)); // not enlarged for invisible shapes
    CHECK(view.height == Approx(50).epsilon(0).margin(0.5));
    const pugi::xml_node root = fitted.document.xml.document_element();
    CHECK(root.attribute("width").as_double() == Approx(2 * view.width));
    CHECK(std::string_view(root.attribute("height").value()).ends_with("mm"));
    CHECK(deformed(text, by({1, 0, 0, 1, 0, 1}), {.fit = true}).text.find("viewBox=\"0 0 100 50\"") !=
          std::string::npos);
    // an invalid unit is kept
    const Result odd =
        deformed(R"(<svg viewBox="0 0 9 9" width="9&quot;"><rect width="1" height="1"/></svg>)",
                 by({1, 0, 0, 1, 100, 0}), {.fit = true});
    CHECK(parse_svg(odd.text, "odd.svg"));
    // percentages still refer to the size at rest
    for (const char* content :
         {R"(<path d="M90 0h9" stroke="red" stroke-width="9%"/>)",
          R"(<style>path{stroke-dasharray:5%}</style><path d="M90 0h9" stroke="red"/>)",
          R"(<linearGradient id="g" gradientUnits="userSpaceOnUse" x1="3%"/><path d="M90 0h9v9z"/>)"}) {
        const std::string rect = R"(<rect id="still" x="20%" y="30%" width="8%" height="9%" fill="none"/>)";
        const auto beyond = [](std::span<const Point2> in, std::span<Point2> out) {
            for (std::size_t i = 0; i < in.size(); ++i) out[i] = {in[i].x + (in[i].x > 80 ? 50 : 0), in[i].y};
            return true;
        };
        const Result grown = deformed(svg(content + rect), beyond, {.fit = true});
        CAPTURE(grown.text);
        CHECK(view_box(grown.document).width > 130);
        CHECK(write_path_data(shapes(grown.document)->back().path, 6) == "M20 30 L28 30 L28 39 L20 39 Z");
    }
    // without a viewBox the size replaces it
    const Result bare = deformed(R"(<svg width="100" height="50"><rect width="10" height="10"/></svg>)",
                                 by(right), {.fit = true});
    CHECK(view_box(bare.document).width == Approx(110).epsilon(0).margin(0.5));
}

TEST_CASE("images in copies are written once and move with the copy", "[examples][svg_document][use]") {
    const std::string bytes(3000, 'A');
    const std::string text = svg(
        R"x(<g id="g" transform="translate(1 2)"><image transform="scale(2)" x="1" y="1" width="8" height="4" href="data:image/png;base64,)x" +
        bytes + R"x("/></g><use href="#g" x="10"/><use href="#g" y="20" transform="rotate(9)"/>)x");
    const Affine2 pose{0, 2, -2, 0, 90, 10};
    const Result result = deformed(text, by(pose));
    std::size_t repeats = 0;
    for (std::size_t at = result.text.find(bytes); at != std::string::npos;
         at = result.text.find(bytes, at + bytes.size()))
        ++repeats;
    CHECK(repeats == 2); // the displayed image, and the definition
    std::vector<pugi::xml_node> uses;
    const pugi::xml_node root = result.document.xml.document_element();
    for (pugi::xml_node node = root; node; node = detail::next_node(node, root)) {
        if (detail::local_name(node) == "use") uses.push_back(node);
    }
    REQUIRE(uses.size() == 2);
    const Affine2 turn = *parse_transform("rotate(9)");
    for (const std::size_t n : {0u, 1u}) {
        CAPTURE(n);
        const Affine2 outer = n == 0 ? Affine2{1, 0, 0, 1, 10, 0} : compose(turn, {1, 0, 0, 1, 0, 20});
        const Affine2 parent = compose(outer, {1, 0, 0, 1, 1, 2});
        const Affine2 moved = compose(parent, *parse_transform(uses[n].attribute("transform").value()));
        const Point2 p = apply(pose, apply(compose(parent, {2, 0, 0, 2, 0, 0}), {3, 4}));
        CHECK(distance(p, apply(moved, {3, 4})) < 1e-6);
        CHECK(by_id(result.document, detail::reference_of(uses[n]).substr(1)).attribute("width").as_int() ==
              8);
    }
}

TEST_CASE("a shape without interior is not filled after bending", "[examples][svg_document][paint]") {
    const std::string_view shape = GENERATE(
        R"(<line x1="10" y1="20" x2="90" y2="40" stroke="red"/>)", R"(<path d="M10 20L90 40" fill="tan"/>)",
        R"(<polyline points="10,20 50,30 90,40"/>)", R"(<path style="fill:tan" d="M10 20H90M10 30V90"/>)");
    CAPTURE(shape);
    Result line = deformed(svg(shape), bend);
    const auto all = line.document.xml.document_element().child("path");
    const detail::StyleSheets styles(line.document);
    CHECK(styles.value(all, "fill").text == "none");
    const Result area = deformed(svg(R"(<path d="M10 20L90 40 50 90" fill="tan"/>)"), bend);
    CHECK(area.text.find("fill=\"tan\"") != std::string::npos);
}

TEST_CASE("the direction of a curve is kept where its derivative vanishes",
          "[examples][svg_document][deform]") {
    // Editors write such curves for retracted handles. A stroke's corner shows the direction.
    const std::string_view data = GENERATE("M10 10C10 10 40 12 40 40L41 60", "M10 10C12 40 40 40 40 40L41 60",
                                           "M10 10C10 10 40 40 40 40L41 60");
    CAPTURE(data);
    const Result result = deformed(svg("<path d=\"" + std::string(data) + "\"/>"), bend, {.decimals = 10});
    const auto all = shapes(result.document);
    REQUIRE(all);
    const auto before = parse_path_data(data);
    const Subpath& rest = before->front();
    const Subpath& moved = all->front().path.front();
    const auto leaves = [](const Point2& p, const Segment& s) { // the first control point that differs
        const Point2 q = distance(p, s.p1) > 1e-9 ? s.p1 : distance(p, s.p2) > 1e-9 ? s.p2 : s.p3;
        return std::atan2(q.y - p.y, q.x - p.x);
    };
    const auto arrives = [](const Point2& p, const Segment& s) {
        const Point2 q = distance(s.p3, s.p2) > 1e-9 ? s.p2 : distance(s.p3, s.p1) > 1e-9 ? s.p1 : p;
        return std::atan2(s.p3.y - q.y, s.p3.x - q.x);
    };
    const auto slope = [](double angle, double x) { // after the deformation
        return std::atan2(std::sin(angle) + 0.02 * (x - 50) * std::cos(angle), std::cos(angle));
    };
    CHECK(leaves(moved.start, moved.segments.front()) ==
          Approx(slope(leaves(rest.start, rest.segments[0]), 10)).epsilon(0).margin(0.02));
    const auto joint = std::find_if(moved.segments.begin(), moved.segments.end(),
                                    [](const Segment& s) { return std::abs(s.p3.x - 40) < 1e-6; });
    REQUIRE(joint != moved.segments.end());
    const Point2 from = joint == moved.segments.begin() ? moved.start : std::prev(joint)->p3;
    CHECK(arrives(from, *joint) ==
          Approx(slope(arrives(rest.start, rest.segments[0]), 40)).epsilon(0).margin(0.02));
}

} // namespace svg_paint_tests
