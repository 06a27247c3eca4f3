// Drawings in several frames: every frame is the picture deformed by its pose. Text on a path moves with it.

#include "svg/document.hpp"
#include "svg/drawn_figure.hpp"
#include "svg/shapes.hpp"
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

namespace svg_animation_tests {

using namespace cageform_support;
using svg_texts::by_id;
using svg_texts::by_name;
using svg_texts::parsed;

namespace {

constexpr std::size_t frame_count = 5;

const std::string drawing = R"x(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">
<linearGradient id="fade" gradientUnits="userSpaceOnUse" x1="10" x2="60"><stop stop-color="red"/></linearGradient>
<radialGradient id="ball"><stop stop-color="blue"/></radialGradient>
<pattern id="dots" width="0.2" height="0.25"><circle r="1"/></pattern>
<clipPath id="window"><circle cx="50" cy="50" r="30"/></clipPath>
<filter id="blur"><feGaussianBlur stdDeviation="1"/></filter>
<filter id="lamp" primitiveUnits="userSpaceOnUse"><feDiffuseLighting><fePointLight x="20" y="30" z="9"/></feDiffuseLighting></filter>
<g transform="rotate(10) translate(3 1)">
<rect id="a" x="10" y="10" width="40" height="20" fill="url(#fade)"/>
<circle id="b" cx="60" cy="50" r="20" fill="url(#ball)" stroke="url(#fade)"/>
<ellipse id="c" cx="40" cy="70" rx="20" ry="9" fill="url(#dots)" filter="url(#blur)"/></g>
<path id="d" d="M5 5C40 0 60 90 95 95L90 50z" clip-path="url(#window)" filter="url(#lamp)"/>
<line id="e" x1="5" y1="90" x2="95" y2="80" stroke="black"/>
<text id="f" x="20" y="60" font-size="8" transform="scale(1.5)">letters</text>
<image id="g" x="70" y="5" width="9" height="20" href="data:,"/>
</svg>)x";

/// A map of the plane that is not affine; its inverse is not needed.
struct Wave {
    Affine2 map;
    double height = 0, pace = 0;

    Point2 operator()(const Point2& p) const {
        const Point2 q = apply(map, p);
        return {q.x + height * std::sin(pace * q.y), q.y + height * std::cos(pace * q.x)};
    }
};

std::vector<Wave> random_waves(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    std::vector<Wave> waves;
    for (std::size_t f = 0; f < frame_count; ++f) {
        waves.push_back({{1 + 0.3 * share(random), 0.3 * share(random), 0.3 * share(random),
                          1 + 0.3 * share(random), 10 * share(random), 10 * share(random)},
                         3 * share(random),
                         0.1 * share(random)});
    }
    return waves;
}

FrameDeformer by(const std::vector<Wave>& waves) {
    return [&waves](std::span<const Point2> in, std::span<const PointRole>, std::span<Point2> out) {
        for (std::size_t f = 0; f < waves.size(); ++f) {
            std::transform(in.begin(), in.end(), out.begin() + std::ptrdiff_t(f * in.size()), waves[f]);
        }
        return true;
    };
}

Deformer by(const Wave& wave) {
    return [&wave](std::span<const Point2> in, std::span<Point2> out) {
        std::transform(in.begin(), in.end(), out.begin(), wave);
        return true;
    };
}

AnimatedSvg animated(std::string_view text, const std::vector<Wave>& waves,
                     const DeformOptions& options = {}) {
    auto result = animate(parsed(text), by(waves), waves.size(), options);
    INFO((result ? std::string() : to_string(result.error())));
    REQUIRE(result);
    return std::move(*result);
}

std::string letters_of(std::string_view data) {
    std::string letters;
    std::copy_if(data.begin(), data.end(), std::back_inserter(letters),
                 [](char c) { return c >= 'A' && c <= 'Z'; });
    return letters;
}

/// The largest distance of points of a path, at equal parameters of its segments, from another path.
double distance_between(const Path& path, const Path& other) {
    double farthest = 0;
    const auto places = [](const Path& p, std::size_t steps) {
        std::vector<Point2> all;
        for (const Subpath& subpath : p) {
            Point2 from = subpath.start;
            for (const Segment& s : subpath.segments) {
                for (std::size_t k = 0; k <= steps; ++k)
                    all.push_back(place_on(from, s, double(k) / double(steps)));
                from = s.p3;
            }
        }
        return all;
    };
    const auto fine = places(other, 400); // a line between two points is less than 0.001 from the curve
    for (const Point2& p : places(path, 7)) {
        double least = 1e9;
        for (std::size_t i = 0; i + 1 < fine.size(); ++i) {
            const Point2 &a = fine[i], &b = fine[i + 1];
            const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
            const double t =
                square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0;
            least = std::min(least, std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy));
        }
        farthest = std::max(farthest, least);
    }
    return farthest;
}

/// The largest distance between the images of a unit square's corners under two transforms.
double difference(const std::string& a, const std::string& b) {
    const auto one = parse_transform(a), other = parse_transform(b);
    REQUIRE(one);
    REQUIRE(other);
    double most = 0;
    for (const Point2& p : {Point2{0, 0}, Point2{1, 0}, Point2{0, 1}}) {
        const Point2 q = apply(*one, p), r = apply(*other, p);
        most = std::max(most, std::hypot(q.x - r.x, q.y - r.y));
    }
    return most;
}

} // namespace

TEST_CASE("a frame is the picture deformed by its pose", "[examples][svg_document][animate][property]") {
    const unsigned seed = GENERATE(1u, 2u, 3u, 4u);
    CAPTURE(seed);
    const auto waves = random_waves(seed);
    AnimatedSvg moving = animated(drawing, waves);
    std::vector<std::string> first_letters;
    for (std::size_t f = 0; f < frame_count; ++f) {
        CAPTURE(f);
        moving.show(f);
        SvgDocument still = parsed(drawing);
        REQUIRE(deform(still, by(waves[f])));
        for (const char* id : {"a", "b", "c", "d", "e"}) {
            CAPTURE(id);
            const auto frame = by_id(moving.document, id), alone = by_id(still, id);
            const std::string data = frame.attribute("d").value();
            const auto path = parse_path_data(data), other = parse_path_data(alone.attribute("d").value());
            REQUIRE(path);
            REQUIRE(other);
            CHECK(distance_between(*path, *other) < 0.007); // two tolerances, and the 0.001 above
            CHECK(distance_between(*other, *path) < 0.007);
            if (f == 0) {
                first_letters.push_back(letters_of(data));
            } else {
                const std::size_t n = std::size_t(id[0] - 'a');
                CHECK(letters_of(data) == first_letters[n]); // otherwise browsers do not interpolate them
            }
            for (const char* property : {"fill", "stroke"}) {
                const auto server_of = [&](pugi::xml_node node, const SvgDocument& document) {
                    const std::string value = node.attribute(property).value();
                    return by_id(document, detail::referenced_id(value));
                };
                const auto one = server_of(frame, moving.document), two = server_of(alone, still);
                REQUIRE(bool(one) == bool(two));
                const char* const name =
                    detail::local_name(one) == "pattern" ? "patternTransform" : "gradientTransform";
                if (one) CHECK(difference(one.attribute(name).value(), two.attribute(name).value()) < 1e-3);
            }
        }
        for (const char* id : {"f", "g"}) {
            CHECK(difference(by_id(moving.document, id).attribute("transform").value(),
                             by_id(still, id).attribute("transform").value()) < 1e-6);
        }
        const auto light = [](const SvgDocument& document) {
            const auto node = by_name(document.xml, "fePointLight");
            return std::array{node.attribute("x").as_double(), node.attribute("y").as_double()};
        };
        CHECK(light(moving.document)[0] == Approx(light(still)[0]).epsilon(0).margin(1e-3));
        CHECK(light(moving.document)[1] == Approx(light(still)[1]).epsilon(0).margin(1e-3));
    }
}

namespace {

std::vector<double> flat(const Path& path) {
    std::vector<double> numbers;
    for (const Subpath& subpath : path) {
        numbers.insert(numbers.end(), {subpath.start.x, subpath.start.y});
        for (const Segment& s : subpath.segments)
            for (const Point2& p : {s.p1, s.p2, s.p3}) numbers.insert(numbers.end(), {p.x, p.y});
    }
    return numbers;
}

std::vector<std::string> parts_of(const std::string& text) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == ';')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

/// The height of a CSS easing curve, by bisection.
double eased(const std::vector<double>& controls, double time) {
    const auto at = [&](double t, std::size_t axis) {
        const double u = 1 - t;
        return 3 * u * u * t * controls[axis] + 3 * u * t * t * controls[axis + 2] + t * t * t;
    };
    double low = 0, high = 1;
    for (int n = 0; n < 60; ++n) (at((low + high) / 2, 0) < time ? low : high) = (low + high) / 2;
    return at(low, 1);
}

/// The interpolated numbers of an animation at a fraction of its duration, by the rules of SMIL.
std::vector<double> played(pugi::xml_node animation, double time) {
    const auto values = parts_of(animation.attribute("values").value());
    std::vector<double> times;
    for (std::size_t k = 0; k < values.size(); ++k) times.push_back(double(k) / double(values.size() - 1));
    if (animation.attribute("keyTimes")) {
        times.clear();
        for (const auto& each : parts_of(animation.attribute("keyTimes").value()))
            times.push_back(std::stod(each));
    }
    REQUIRE(times.size() == values.size());
    const auto numbers = [&](std::size_t k) {
        if (std::string_view(animation.attribute("attributeName").value()) != "d")
            return *parse_numbers(values[k]);
        const auto path = parse_path_data(values[k]);
        REQUIRE(path);
        return flat(*path);
    };
    if (values.size() == 1) return numbers(0);
    std::size_t k = 0;
    while (k + 2 < times.size() && times[k + 1] <= time) ++k;
    double share = (time - times[k]) / (times[k + 1] - times[k]);
    if (animation.attribute("keySplines")) {
        CHECK(std::string_view(animation.attribute("calcMode").value()) == "spline");
        const auto splines = parts_of(animation.attribute("keySplines").value());
        REQUIRE(splines.size() + 1 == values.size());
        share = eased(*parse_numbers(splines[k]), share);
    }
    auto from = numbers(k);
    const auto to = numbers(k + 1);
    REQUIRE(from.size() == to.size());
    for (std::size_t i = 0; i < from.size(); ++i) from[i] += share * (to[i] - from[i]);
    return from;
}

/// A smooth motion from one wave through others and back to it.
std::vector<Wave> smooth_waves(unsigned seed, std::size_t frames) {
    const auto ends = random_waves(seed);
    std::vector<Wave> waves;
    for (std::size_t f = 0; f < frames; ++f) {
        const double turn = 2 * 3.14159265358979 * double(f) / double(frames);
        const double shares[] = {(1 - std::cos(turn)) / 2, std::sin(turn) / 2, std::sin(2 * turn) / 4};
        Wave wave{{}, 0, 0.1};
        for (std::size_t n = 0; n < 3; ++n) {
            const auto& [map, height, pace] = ends[n];
            wave.map.a += shares[n] * (map.a - 1);
            wave.map.b += shares[n] * map.b;
            wave.map.c += shares[n] * map.c;
            wave.map.d += shares[n] * (map.d - 1);
            wave.map.e += shares[n] * map.e;
            wave.map.f += shares[n] * map.f;
            wave.height += shares[n] * height;
        }
        waves.push_back(wave);
    }
    return waves;
}

/// The animations of an element: inside it, or next to it if it takes its content from another one.
std::vector<pugi::xml_node> animations_of(pugi::xml_node node, const std::string& attribute) {
    std::vector<pugi::xml_node> found;
    const std::string id = std::string("#") + node.attribute("id").value();
    for (const pugi::xml_node parent : {node, node.parent()}) {
        for (const pugi::xml_node child : parent.children()) {
            const bool is_for_it = parent == node || detail::reference_of(child) == id;
            if (is_for_it && child.attribute("attributeName").value() == attribute) found.push_back(child);
        }
    }
    return found;
}

} // namespace

TEST_CASE("an animation shows every frame within the tolerance",
          "[examples][svg_document][animate][property]") {
    const unsigned seed = GENERATE(1u, 2u, 3u, 4u, 5u, 6u);
    CAPTURE(seed);
    constexpr std::size_t frames = 48;
    const double tolerance = GENERATE(0.02, 0.3);
    AnimatedSvg moving = animated(drawing, smooth_waves(seed, frames), {.tolerance = 0.02});
    moving.play(1, 7); // undone by the next call
    const std::size_t keys = moving.play(2.5, tolerance);
    std::size_t animations = 0;
    for (const auto& track : moving.tracks) {
        const auto all = animations_of(track.node, track.attribute);
        REQUIRE_FALSE(all.empty());
        animations += all.size();
        for (const pugi::xml_node each : all)
            CHECK(std::string_view(each.attribute("dur").value()) == "2.5s");
        double farthest = 0;
        for (std::size_t f = 0; f <= frames; ++f) {
            const double time = double(f) / frames;
            const std::size_t n = f % frames; // ends as it began
            const auto far = [&](double x, double y) {
                farthest = std::max(farthest, track.scale * std::hypot(x, y));
            };
            if (!track.numbers.empty()) far(played(all.front(), time)[0] - track.numbers[n], 0);
            if (!track.paths.empty()) {
                const auto shown = played(all.front(), time), exact = flat(track.paths[n]);
                REQUIRE(shown.size() <= exact.size()); // a closing line is omitted
                std::size_t i = 0;
                for (const Subpath& subpath : track.paths[n]) {
                    for (std::size_t k = 0; k < 6 * subpath.segments.size() + 2 && i < shown.size();
                         k += 2, i += 2)
                        far(shown[i] - exact[i], shown[i + 1] - exact[i + 1]);
                }
            }
            if (track.maps.empty()) continue;
            Affine2 product;
            for (const pugi::xml_node each : all) {
                const auto numbers = played(each, time);
                std::string step = each.attribute("type").value();
                step += '(' + format_number(numbers[0], 17);
                if (numbers.size() > 1) step += ' ' + format_number(numbers[1], 17);
                product = compose(product, *parse_transform(step + ')'));
            }
            for (const Point2& place : track.places) {
                const Point2 p = apply(product, place), q = apply(track.maps[n], place);
                far(p.x - q.x, p.y - q.y);
            }
        }
        CAPTURE(track.attribute, animations);
        CHECK(farthest < 1.05 * tolerance); // times and curves are written with five digits
    }
    CHECK(keys < animations * frames * (tolerance < 0.1 ? 2 : 1) / 3);
    CHECK(by_id(moving.document, "f").child("animateTransform"));
    CHECK(by_id(moving.document, "a").child("animate"));
}

TEST_CASE("a pose and the way back need three key frames", "[examples][svg_document][animate]") {
    const FrameDeformer there_and_back = [](std::span<const Point2> in, std::span<const PointRole>,
                                            std::span<Point2> out) {
        for (std::size_t n = 0; n < out.size(); ++n) {
            const auto f = double(n / in.size());
            const double share = eased({0.42, 0, 0.58, 1}, std::min(f, 60 - f) / 30);
            const Point2 p = in[n % in.size()];
            out[n] = {p.x + share * (40 + 5 * std::sin(0.1 * p.y)), p.y - share * 0.004 * p.x * p.x};
        }
        return true;
    };
    auto moving_or_not =
        animate(parsed(R"(<svg viewBox="0 0 100 100"><path id="a" d="M5 5C40 0 60 90 95 95L90 50z"/></svg>)"),
                there_and_back, 60, {.tolerance = 0.001});
    REQUIRE(moving_or_not);
    AnimatedSvg& moving = *moving_or_not;
    CHECK(moving.play(1, 0.001) == 3);
    const auto animation = by_id(moving.document, "a").child("animate");
    CHECK(std::string_view(animation.attribute("keyTimes").value()) == "0;0.5;1");
    for (const std::string& curve : parts_of(animation.attribute("keySplines").value())) {
        const auto numbers = parse_numbers(curve);
        REQUIRE(numbers);
        REQUIRE(numbers->size() == 4);
        for (const auto& [n, value] : {std::pair(0, 0.42), {1, 0.0}, {2, 0.58}, {3, 1.0}})
            CHECK((*numbers)[std::size_t(n)] == Approx(value).epsilon(0).margin(0.002));
    }
}

TEST_CASE("an affine motion is written as a transform", "[examples][svg_document][animate]") {
    const Affine2 turned{0.8, 0.6, -0.6, 0.8, 30, -10}, stretched{1.5, 0, 0, 0.7, 3, 4};
    struct Case {
        const char* content;
        Affine2 map;
        double height; // of waves
        bool is_carried;
    };
    const std::string shapes =
        R"(<rect x="20" y="20" width="9" height="8" fill="red"/><circle cx="40" cy="30" r="6"/>)";
    const auto [content, map, height, is_carried] = GENERATE_COPY(values<Case>({
        {"<g id='g' transform='rotate(9)'>$</g>", stretched, 0, true},
        {"<g id='g'><g>$</g>$</g>", turned, 0, true},
        {"<g id='g' stroke='red' stroke-width='3'>$</g>", turned, 0, true},
        {"<g id='g' stroke='red' stroke-width='3'>$</g>", stretched, 0, false}, // strokes keep their width
        {"<g id='g' stroke='red' stroke-width='.001'>$</g>", stretched, 0, true},
        {"<g id='g' stroke='red' stroke-width='.001' stroke-dasharray='1'>$</g>", turned, 0, false},
        {"<g id='g'>$</g>", turned, 3, false},
        {"<clipPath id='c'><circle r='30'/></clipPath><g id='g'><g clip-path='url(#c)'>$</g></g>", turned, 0,
         false},
        {"<marker id='m'/><g id='g' marker-end='url(#m)'>$</g>", turned, 0, false},
    }));
    std::string text = R"(<svg viewBox="0 0 100 100">)" + std::string(content) + "</svg>";
    for (std::size_t at = 0; (at = text.find('$')) != std::string::npos;) text.replace(at, 1, shapes);
    CAPTURE(text);
    AnimatedSvg moving = animated(text, {Wave{}, Wave{map, height, 0.1}, Wave{}});
    const auto group = by_id(moving.document, "g");
    moving.show(1);
    const auto rect = by_name(group, "rect");
    CHECK(bool(rect) == is_carried);
    if (!is_carried) return;
    moving.play(1, 1e-3);
    CHECK(moving.tracks.size() == 1);
    CHECK(group.child("animateTransform"));
    const SvgDocument rest = parsed(text);
    const auto own = parse_transform(by_id(rest, "g").attribute("transform").value());
    moving.show(1);
    const auto now = parse_transform(group.attribute("transform").value());
    REQUIRE(now);
    const Point2 p = apply(*now, {25, 26}), q = apply(compose(map, *own), {25, 26});
    CHECK(std::hypot(p.x - q.x, p.y - q.y) < 1e-6);
}

TEST_CASE("the option --fit makes room for all frames", "[examples][svg_document][animate][fit]") {
    const std::string square =
        R"(<svg viewBox="0 0 100 100"><rect x="40" y="40" width="20" height="20"/></svg>)";
    const std::vector<Wave> waves{{{1, 0, 0, 1, 0, 0}}, {{1, 0, 0, 1, 100, 0}}, {{1, 0, 0, 1, 0, -90}}};
    const AnimatedSvg cut = animated(square, waves);
    CHECK(cut.report.cut_off == 1);
    const AnimatedSvg fitted = animated(square, waves, {.fit = true});
    CHECK(fitted.report.cut_off == 0);
    const auto view = view_box(fitted.document);
    CHECK(view.x + view.width == Approx(160).epsilon(0).margin(0.5));
    CHECK(view.y == Approx(-50).epsilon(0).margin(0.5));
    CHECK(view.y + view.height == Approx(100).epsilon(0).margin(0.5));
}

TEST_CASE("an element that does not move stays as written", "[examples][svg_document][animate]") {
    const SvgDocument document = parsed(drawing);
    const auto rest = animate(
        document,
        [](std::span<const Point2> in, std::span<const PointRole>, std::span<Point2> out) {
            for (std::size_t i = 0; i < out.size(); ++i) out[i] = in[i % in.size()];
            return true;
        },
        3);
    REQUIRE(rest);
    CHECK(to_text(rest->document) == to_text(document));
    CHECK(rest->tracks.empty());
}

TEST_CASE("a layer is the content of its element", "[examples][svg_document][animate]") {
    const std::string text =
        R"(<svg viewBox="0 0 9 9"><g id="late"><rect id="a" width="1" height="1"/></g><rect id="b" width="1" height="1"/></svg>)";
    const FrameDeformer by_layer = [](std::span<const Point2> in, std::span<const PointRole> roles,
                                      std::span<Point2> out) {
        for (std::size_t i = 0; i < in.size(); ++i) out[i] = {in[i].x + 3 * double(roles[i].layer), in[i].y};
        return true;
    };
    const auto moved = animate(parsed(text), by_layer, 1, {.layers = {"late"}});
    REQUIRE(moved);
    CHECK(std::string_view(by_id(moved->document, "a").attribute("d").value()).starts_with("M3 0"));
    CHECK(detail::local_name(by_id(moved->document, "b")) == "rect");
    const auto none = animate(parsed(text), by_layer, 1, {.layers = {"later"}});
    REQUIRE_FALSE(none);
    CHECK(to_string(none.error()) == "test.svg: the figure has no shape in \"later\"");
}

// ---- text on paths ----

namespace {

/// The bounding box of all drawn elements, including text on paths.
detail::Box drawn_box(std::string_view text) {
    SvgDocument document = parsed(text);
    detail::StyleSheets styles(document);
    detail::IdTable ids(detail::root_element(document.xml));
    std::vector<std::string> ignored;
    const auto all = detail::walk(document, styles, ids, {.boxes = true}, ignored);
    REQUIRE(all);
    detail::Box box;
    for (const auto& shape : all->shapes) box.add(detail::painted_box(shape, {}));
    return box;
}

} // namespace

TEST_CASE("text on a path moves with it, and only once", "[examples][svg_document][text]") {
    const Wave right{{1, 0, 0, 1, 30, 5}};
    const auto deformed = [&](std::string_view text) {
        SvgDocument document = parsed(text);
        REQUIRE(deform(document, by(right)));
        return document;
    };
    const auto path_start = [](const SvgDocument& document) {
        const auto text_path = by_name(document.xml, "textPath");
        const auto path = by_id(document, detail::reference_of(text_path).substr(1));
        const auto parsed_path = parse_path_data(path.attribute("d").value());
        REQUIRE(parsed_path);
        return parsed_path->front().start;
    };
    SECTION("that is drawn in the same place") {
        const auto document = deformed(
            R"x(<svg viewBox="0 0 100 100"><g transform="scale(2)"><path id="p" d="M5 10 L40 10" stroke="red"/>
<text font-size="4"><textPath href="#p">on it</textPath></text></g></svg>)x");
        CHECK(path_start(document).x == Approx(20).epsilon(0).margin(1e-3));
        CHECK(path_start(document).y == Approx(12.5).epsilon(0).margin(1e-3));
        const auto text = by_name(document.xml, "text");
        CHECK_FALSE(text.attribute("transform"));
        CHECK_FALSE(by_id(document, "p-2"));
    }
    SECTION("that is a definition, or drawn elsewhere") {
        const std::string_view place =
            GENERATE(R"x(<defs><path id="p" d="M5 10 L40 10"/></defs>)x",
                     R"x(<g transform="translate(9 70)"><path id="p" d="M5 10 L40 10" stroke="red"/></g>)x",
                     R"x(<path id="p" d="M5 10 L40 10" style="display:none"/>)x");
        const auto document =
            deformed(std::string(R"x(<svg viewBox="0 0 100 100">)x") + std::string(place) +
                     R"x(<text font-size="4"><textPath href="#p">on it</textPath></text></svg>)x");
        CHECK(path_start(document).x == Approx(35).epsilon(0).margin(1e-3));
        CHECK(path_start(document).y == Approx(15).epsilon(0).margin(1e-3));
        CHECK_FALSE(by_name(document.xml, "text").attribute("transform"));
    }
    SECTION("of a transform of its own, in a text of another") {
        const auto document = deformed(
            R"x(<svg viewBox="0 0 100 100"><defs><path id="p" transform="translate(1 2)" d="M5 10 L40 10"/></defs>
<text transform="scale(2)" font-size="4"><textPath href="#p">on it</textPath></text></svg>)x");
        // rest: 2 * ((5, 10) + (1, 2)) = (12, 24); moved (42, 29); back: (21, 14.5) - (1, 2)
        CHECK(path_start(document).x == Approx(20).epsilon(0).margin(1e-3));
        CHECK(path_start(document).y == Approx(12.5).epsilon(0).margin(1e-3));
    }
}

TEST_CASE("text on a path extends as far as its letters", "[examples][svg_document][text]") {
    // Three letters of size 10 from 20 along a line: from 25 to 43, 8 to either side.
    const auto box = drawn_box(
        R"x(<svg viewBox="0 0 100 100"><defs><path id="p" d="M5 50 L95 50"/></defs>
<text font-size="10"><textPath href="#p" startOffset="20">abc</textPath></text></svg>)x");
    CHECK(box.x0 > 5);
    CHECK(box.x0 < 25);
    CHECK(box.x1 > 43);
    CHECK(box.x1 < 60);
    CHECK(box.y0 == Approx(42));
    CHECK(box.y1 == Approx(58));
    CHECK(drawn_box(R"x(<svg viewBox="0 0 9 9"><text><textPath href="#none">abc</textPath></text></svg>)x")
              .empty());
}

TEST_CASE("a cage surrounds what is visible on the page", "[examples][svg_document][cage]") {
    const auto width_of = [](std::string_view text) {
        const auto figure = drawn_figure(parsed(text));
        REQUIRE(figure);
        double low = 1e9, high = -1e9;
        for (const auto& segment : figure->segments) {
            low = std::min({low, segment.a[0], segment.b[0]});
            high = std::max({high, segment.a[0], segment.b[0]});
        }
        return high - low;
    };
    const std::string on = R"(<rect x="3" y="3" width="2" height="2"/>)",
                      beside = R"(<rect x="50" y="3" width="4" height="2"/>)",
                      across = R"(<rect x="8" y="3" width="4" height="2"/>)";
    CHECK(width_of(R"(<svg viewBox="0 0 9 9">)" + on + beside + "</svg>") == Approx(2));
    CHECK(width_of(R"(<svg viewBox="0 0 9 9">)" + on + across + "</svg>") == Approx(9));
    CHECK(width_of(R"(<svg viewBox="0 0 9 9">)" + beside + "</svg>") == Approx(4));
    CHECK(width_of("<svg>" + on + beside + "</svg>") == Approx(51)); // has no page
    CHECK(width_of(R"(<svg width="9" height="9">)" + on + beside + "</svg>") == Approx(2));
}

TEST_CASE("elements that no renderer draws are ignored", "[examples][svg_document][text]") {
    CHECK(
        drawn_box(
            R"x(<svg viewBox="0 0 9 9"><switch><foreignObject requiredExtensions="&ns_ai;" width="1" height="1"/>
<rect x="3" y="3" width="2" height="2"/></switch></svg>)x")
            .x0 == Approx(2.5 + 0.5));
}

} // namespace svg_animation_tests
