#include "svg/path.hpp"

#include "catch.hpp"
#include "support/larger.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace svg_path_tests {

using namespace cageform_support;

namespace {

double distance(const Point2& a, const Point2& b) {
    return std::hypot(a.x - b.x, a.y - b.y);
}

bool near(const Point2& a, const Point2& b, double tolerance = 1e-12) {
    return distance(a, b) <= tolerance;
}

Point2 lerp(const Point2& a, const Point2& b, double t) {
    return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
}

/// A point of a cubic by repeated bisection of its polygon, which is not the library's method.
Point2 on_cubic(const Point2& p0, const Segment& s, double t) {
    const Point2 a = lerp(p0, s.p1, t);
    const Point2 b = lerp(s.p1, s.p2, t);
    const Point2 c = lerp(s.p2, s.p3, t);
    return lerp(lerp(a, b, t), lerp(b, c, t), t);
}

Path parsed(std::string_view text) {
    const auto path = parse_path_data(text);
    INFO(text);
    REQUIRE(path);
    return *path;
}

/// The data as absolute M, L, C and Z with up to six decimals.
std::string normal(std::string_view text) {
    return write_path_data(parsed(text), 6);
}

FileError path_error(std::string_view text) {
    const auto path = parse_path_data(text);
    INFO(text);
    REQUIRE_FALSE(path);
    return path.error();
}

/// The largest relative distance of a path's samples from the unit circle after `to_unit`.
double deviation_from_circle(const Path& path, const Affine2& to_unit) {
    double worst = 0;
    for (const Subpath& subpath : path) {
        Point2 from = subpath.start;
        for (const Segment& s : subpath.segments) {
            for (int i = 0; i <= 64; ++i) {
                const Point2 p = apply(to_unit, on_cubic(from, s, i / 64.0));
                worst = cageform_tests::larger(worst, std::abs(std::hypot(p.x, p.y) - 1));
            }
            from = s.p3;
        }
    }
    return worst;
}

Affine2 affine(std::string_view text) {
    const auto map = parse_transform(text);
    INFO(text);
    REQUIRE(map);
    return *map;
}

} // namespace

TEST_CASE("path data: every command is read, absolute and relative", "[examples][svg_path]") {
    CHECK(normal("M 10 20 L 30 40") == "M10 20 L30 40");
    CHECK(normal("m 10 20 l 30 40") == "M10 20 L40 60");
    CHECK(normal("M1 2H5V7") == "M1 2 L5 2 L5 7");
    CHECK(normal("m1 2h5v7") == "M1 2 L6 2 L6 9");
    CHECK(normal("M0 0C1 2 3 4 5 6") == "M0 0 C1 2 3 4 5 6");
    CHECK(normal("m1 1c1 2 3 4 5 6") == "M1 1 C2 3 4 5 6 7");
    CHECK(normal("M0 0C0 1 2 3 4 4S6 7 8 8") == "M0 0 C0 1 2 3 4 4 C6 5 6 7 8 8");
    CHECK(normal("M1 1c0 1 2 3 4 4s2 3 4 4") == "M1 1 C1 2 3 4 5 5 C7 6 7 8 9 9");
    CHECK(normal("M0 0Q3 3 6 0") == "M0 0 C2 2 4 2 6 0");
    CHECK(normal("M1 1q3 3 6 0") == "M1 1 C3 3 5 3 7 1");
    CHECK(normal("M0 0Q3 3 6 0T12 0") == "M0 0 C2 2 4 2 6 0 C8 -2 10 -2 12 0");
    CHECK(normal("M0 0q3 3 6 0t6 0") == "M0 0 C2 2 4 2 6 0 C8 -2 10 -2 12 0");
    CHECK(normal("M0 0L4 0L4 4Z") == "M0 0 L4 0 L4 4 Z");
    CHECK(normal("m0 0l4 0l0 4z") == "M0 0 L4 0 L4 4 Z");
    CHECK(normal("") == "");
    CHECK(normal(" \t\r\n ") == "");
    CHECK(normal("M3 4") == "M3 4");
}

TEST_CASE("path data: smooth commands reflect only after their own kind", "[examples][svg_path]") {
    CHECK(normal("M0 0L2 2S4 0 6 6") == "M0 0 L2 2 C2 2 4 0 6 6");
    CHECK(normal("M0 0Q3 3 6 0S8 1 9 0") == "M0 0 C2 2 4 2 6 0 C6 0 8 1 9 0");
    CHECK(normal("M0 0C0 1 2 3 3 3T6 0") == "M0 0 C0 1 2 3 3 3 C3 3 4 2 6 0"); // control at 3 3
    CHECK(normal("M0 0T6 3") == "M0 0 C0 0 2 1 6 3");
    CHECK(normal("M0 0Q3 3 6 0T12 0 18 0") ==
          "M0 0 C2 2 4 2 6 0 C8 -2 10 -2 12 0 C14 2 16 2 18 0"); // reflects the reflected one
}

TEST_CASE("path data: repeated commands and compact numbers are read", "[examples][svg_path]") {
    CHECK(normal("M1-2") == "M1 -2");
    CHECK(normal("M.5.5") == "M0.5 0.5");
    CHECK(normal("M1e-3,2E+1") == "M0.001 20");
    CHECK(normal("M+1 -.25") == "M1 -0.25");
    CHECK(normal("M0 0 1 1 2 0") == "M0 0 L1 1 L2 0");
    CHECK(normal("m1 1 1 1 1-2") == "M1 1 L2 2 L3 0");
    CHECK(normal("M0 0H1 2 3V4 5") == "M0 0 L1 0 L2 0 L3 0 L3 4 L3 5");
    CHECK(normal("M0 0 1 1 2 2m1 1 1 1") == "M0 0 L1 1 L2 2 M3 3 L4 4");
    CHECK(normal("\n M 0 , 0 \r\n L\t1 ,1 ") == "M0 0 L1 1");
    CHECK(normal("M0 0C0 1 1 2 2 2 3 2 4 1 4 0") == "M0 0 C0 1 1 2 2 2 C3 2 4 1 4 0");
    CHECK(normal("M1e-999 -0") == "M0 0");
}

TEST_CASE("path data: subpaths, and drawing after Z", "[examples][svg_path]") {
    CHECK(normal("M1 1L2 1L2 2ZL5 5") == "M1 1 L2 1 L2 2 Z M1 1 L5 5");
    CHECK(normal("m1 1l1 0l0 1zm2 2l1 1") == "M1 1 L2 1 L2 2 Z M3 3 L4 4");
    CHECK(normal("M1 1h1v1zh3zz") == "M1 1 L2 1 L2 2 Z M1 1 L4 1 Z");
    CHECK(normal("M0 0Z") == "M0 0 Z");
    CHECK(normal("M0 0L1 1L0 0L0 0Z") == "M0 0 L1 1 L0 0 L0 0 Z");

    const Path square = parsed("M0 0H2V2H0Z");
    REQUIRE(square.size() == 1);
    CHECK(square[0].closed);
    REQUIRE(square[0].segments.size() == 4); // including the closing line
    CHECK(square[0].segments.back().p3 == square[0].start);
    CHECK(square[0].segments.back().is_line());
    const Path returned = parsed("M0 0H2V2H0V0Z");
    CHECK(returned[0].segments.size() == 4);
    CHECK(normal("M0 0H2V2H0V0Z") == "M0 0 L2 0 L2 2 L0 2 Z");
    const Path summed = parsed("m.1.1.1.1.1-.3.1.1z"); // 0.1 + 0.1 + 0.1 + 0.1 ... misses by rounding
    CHECK(summed[0].segments.back().p3 == summed[0].start);
    const Path almost = parsed("m.1.2.2 0-.1.1-.1-.1z"); // back up to rounding
    CHECK(almost[0].segments.size() == 3);
    CHECK(almost[0].segments.back().p3 == almost[0].start);
    // small steps far from the origin are not mistaken for rounding errors
    CHECK(parsed("M10555555555555552 40h64v8h-32z")[0].segments.size() == 4);
}

TEST_CASE("path data: arcs follow their ellipse", "[examples][svg_path][arc]") {
    SECTION("a quarter of a circle, all four ways") {
        struct Way {
            std::string_view flags;
            Point2 centre;
            std::size_t segments;
        };
        const std::vector<Way> ways = {
            {"0 0", {10, 10}, 1}, {"0 1", {0, 0}, 1}, {"1 0", {0, 0}, 3}, {"1 1", {10, 10}, 3}};
        for (const Way& way : ways) {
            CAPTURE(way.flags);
            const Path path = parsed("M10 0A10 10 0 " + std::string(way.flags) + " 0 10");
            REQUIRE(path.size() == 1);
            CHECK(path[0].segments.size() == way.segments);
            const Affine2 to_unit{0.1, 0, 0, 0.1, -way.centre.x / 10, -way.centre.y / 10};
            CHECK(deviation_from_circle(path, to_unit) < 3e-4);
            CHECK(path[0].segments.back().p3 == Point2{0, 10});
        }
    }
    SECTION("turned ellipses through random points") {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> unit(-1, 1);
        for (int i = 0; i < 200; ++i) {
            CAPTURE(i);
            const double rx = 20 + 15 * unit(random);
            const double ry = 20 + 15 * unit(random);
            const double degrees = 400 * unit(random);
            const Point2 centre{100 * unit(random), 100 * unit(random)};
            const double from = std::numbers::pi * unit(random);
            const double turn = std::numbers::pi * 1.99 * unit(random);
            const Affine2 frame = compose(compose({1, 0, 0, 1, centre.x, centre.y},
                                                  affine("rotate(" + format_number(degrees, 17) + ")")),
                                          {rx, 0, 0, ry, 0, 0});
            const Point2 begin = apply(frame, {std::cos(from), std::sin(from)});
            const Point2 end = apply(frame, {std::cos(from + turn), std::sin(from + turn)});
            const Point2 middle = apply(frame, {std::cos(from + turn / 2), std::sin(from + turn / 2)});
            PathBuilder builder;
            builder.move_to(begin);
            builder.arc_to({rx, ry, degrees, std::abs(turn) > std::numbers::pi, turn > 0}, end);
            const Path path = builder.take();
            CHECK(deviation_from_circle(path, *inverse(frame)) < 3e-4);
            double nearest = 1e9; // it passes the middle of the angle, so it is the right one
            Point2 at = begin;
            for (const Segment& s : path[0].segments) {
                for (int k = 0; k <= 64; ++k)
                    nearest = std::min(nearest, distance(on_cubic(at, s, k / 64.0), middle));
                at = s.p3;
            }
            CHECK(nearest < 1.5);
        }
    }
    SECTION("radii too small grow until they reach") {
        const Path path = parsed("M-5 0A1 1 0 0 1 5 0");
        CHECK(deviation_from_circle(path, {0.2, 0, 0, 0.2, 0, 0}) < 3e-4);
        CHECK(path[0].segments.size() == 2);
        const Path flat = parsed("M-5 0A1 .5 0 0 1 5 0");
        CHECK(deviation_from_circle(flat, {0.2, 0, 0, 0.4, 0, 0}) < 3e-4);
    }
    SECTION("special cases of the recommendation") {
        CHECK(normal("M0 0A0 5 0 0 1 5 5") == "M0 0 L5 5");
        CHECK(normal("M0 0A5 0 0 0 1 5 5") == "M0 0 L5 5");
        CHECK(normal("M1 1A5 5 0 1 1 1 1L2 2") == "M1 1 L2 2");
        CHECK(normal("M0 0A-5-5 0 0 1 5 5") == normal("M0 0A5 5 0 0 1 5 5"));
        CHECK(normal("M0 0a1 1 0 01.5.5") == normal("M0 0A1 1 0 0 1 0.5 0.5"));
        CHECK(normal("M0 0a1 1 0 1110 0") == normal("M0 0A1 1 0 1 1 10 0"));
        CHECK(normal("M0 0a1,1 0 0,1,.5,.5 1 1 0 00.5.5") == normal("M0 0A1 1 0 0 1 .5 .5 A1 1 0 0 0 1 1"));
    }
    SECTION("extreme radii neither crash nor stray") {
        for (const std::string_view text : {"M0 0A1e200 1e200 0 0 1 5 5", "M0 0A1e-300 1 0 0 1 5 5"}) {
            const auto path = parse_path_data(text);
            if (path) CHECK(near((*path)[0].segments.back().p3, {5, 5}));
        }
    }
}

TEST_CASE("path data: errors have line, column and reason", "[examples][svg_path][error]") {
    const auto check = [](std::string_view text, std::size_t line, std::size_t column,
                          std::string_view reason) {
        CAPTURE(text);
        const FileError error = path_error(text);
        CHECK(error.line == line);
        CHECK(error.column == column);
        CHECK(error.message == reason);
    };
    check("L1 1", 1, 1, "a path begins with M");
    check("  1 1", 1, 3, "expected a command letter");
    check("M1", 1, 3, "expected a number");
    check("M5. 6", 1, 3, "expected a digit after the point");
    check("M5 6.e1", 1, 5, "expected a digit after the point");
    check("M1 1 X", 1, 6, "expected a command letter");
    check("M1 1\nL2 2\n  L3,", 3, 6, "expected a number");
    check("M0 0 1", 1, 7, "expected a number");
    check("M0 0,", 1, 6, "expected a number");
    check("M0 0,,1 1", 1, 6, "expected a number");
    check("M,0 0", 1, 2, "expected a number");
    check("M0,0,1,1,L2,2", 1, 10, "expected a number"); // a comma stands between numbers only
    check("M0 0Z5 5", 1, 6, "expected a command letter");
    check("M0 0A1 1 0 2 0 5 5", 1, 12, "expected a flag, 0 or 1");
    check("M0 0A1 1 0 1", 1, 13, "expected a flag, 0 or 1");
    check("M0 0L1e999 0", 1, 6, "number out of range");
    check("M0 0L-1e999 0", 1, 6, "number out of range");
    check("M0 0L" + std::string(400, '9') + " 0", 1, 6, "number out of range");
    check("M1e308 0l1e308 0", 1, 9, "coordinates out of range");
    check("M0 0l1e308 0 1e308 0", 1, 14, "coordinates out of range");
    check("M0 0Lnan 0", 1, 6, "expected a number");
    check("M0 0Linf 0", 1, 6, "expected a number");
    check("M- 1", 1, 2, "expected a number");
    check("M1e 1", 1, 3, "expected a number");
    check(std::string_view("M0 0\0L1 1", 9), 1, 5, "expected a command letter");
    CHECK(to_string(path_error("M0 0\nX")) == "expected a command letter (line 2, column 1)");
}

TEST_CASE("path data: the part before a fault is read", "[examples][svg_path][error][property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto numbers = [&](int count) {
        std::string text;
        for (int k = 0; k < count; ++k) text += ' ' + std::to_string(int(random() % 200) - 100);
        return text;
    };
    const std::vector<std::pair<char, int>> commands = {{'L', 2}, {'l', 2}, {'H', 1}, {'v', 1},
                                                        {'C', 6}, {'c', 6}, {'S', 4}, {'Q', 4},
                                                        {'T', 2}, {'z', 0}, {'m', 2}};
    std::string before = "M1 2";
    for (int k = 0; k < 12; ++k) {
        const auto [letter, count] = commands[random() % commands.size()];
        const std::string rest = k % 3 == 0 && count > 0 ? numbers(count) : ""; // more of the same
        before += letter + numbers(count) + (letter == 'm' ? "" : rest);
        const std::string whole = write_path_data(*parse_path_data(before), 9);
        for (const std::string& fault :
             {std::string("L x 9 9"), "C" + numbers(5) + "z", "A1 1 0 2 0 5 5" + numbers(2), std::string("#"),
              std::string(","), "Q" + numbers(3) + "L" + numbers(2)}) {
            const std::string text = before + fault + 'L' + numbers(2);
            CAPTURE(text);
            const auto read = read_path_data(text);
            CHECK(read.fault);
            CHECK(write_path_data(read.path, 9) == whole);
            CHECK_FALSE(parse_path_data(text));
        }
    }
    CHECK(read_path_data("M0 0L1e308 0l1e308 0").path.empty());
}

TEST_CASE("numbers are written short and read back", "[examples][svg_path][number]") {
    CHECK(format_number(0, 3) == "0");
    CHECK(format_number(-0.0, 3) == "0");
    CHECK(format_number(-0.0001, 3) == "0");
    CHECK(format_number(1.5, 3) == "1.5");
    CHECK(format_number(0.1, 17) == "0.1");
    CHECK(format_number(2.0 / 3, 4) == "0.6667");
    CHECK(format_number(-1234.5678, 2) == "-1234.57");
    CHECK(format_number(100, 0) == "100");
    CHECK(format_number(1e20, 3) == "1e+20");
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1000, 1000);
    for (int i = 0; i < 200; ++i) {
        const double value = any(random);
        const auto exact = parse_numbers(format_number(value, 17));
        REQUIRE(exact);
        CHECK(exact->at(0) == value);
        const auto rounded = parse_numbers(format_number(value, 3));
        REQUIRE(rounded);
        CHECK(std::abs(rounded->at(0) - value) <= 0.5e-3 * (1 + 1e-9));
    }
}

TEST_CASE("written path data reads back as the same path", "[examples][svg_path][property]") {
    const Path path = parsed("M1.25 2.5C3 4 5.125 6 7 8L9 1Q3 2 1 0Z M4 4A3 2 30 1 0 5 5 L0.3 0.7");
    const Path again = parsed(write_path_data(path, 17));
    REQUIRE(again.size() == path.size());
    for (std::size_t i = 0; i < path.size(); ++i) {
        CHECK(again[i].start == path[i].start);
        CHECK(again[i].closed == path[i].closed);
        REQUIRE(again[i].segments.size() == path[i].segments.size());
        for (std::size_t k = 0; k < path[i].segments.size(); ++k) {
            CHECK(again[i].segments[k].p3 == path[i].segments[k].p3);
            CHECK(again[i].segments[k].is_line() == path[i].segments[k].is_line());
        }
    }
    CHECK(write_path_data(again, 17) == write_path_data(path, 17));
}

TEST_CASE("shortened path data is accurate to half of its last digit", "[examples][svg_path][property]") {
    const unsigned seed = GENERATE(range(0u, 40u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto in = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
    const auto point = [&] { return Point2{in(seed % 3 == 0 ? 0.2 : 300), in(30)}; };
    const int decimals = int(seed % 4);
    Path path;
    for (unsigned n = 0; n <= seed % 3; ++n) {
        PathBuilder builder;
        builder.move_to(point());
        for (unsigned k = 0; k < 9; ++k)
            random() % 2 == 0 ? builder.line_to(point()) : builder.cubic_to(point(), point(), point());
        if (random() % 2 == 0) builder.close();
        path.push_back(builder.take().front());
    }
    const std::string text = write_short_path_data(path, decimals);
    CAPTURE(text);
    CHECK(text.size() < write_path_data(path, decimals).size());
    const Path again = parsed(text);
    REQUIRE(again.size() == path.size());
    const double half = 0.5000001 * std::pow(10, -decimals);
    const auto check = [&](const Point2& p, const Point2& q) {
        CHECK(std::abs(p.x - q.x) <= half);
        CHECK(std::abs(p.y - q.y) <= half);
    };
    for (std::size_t k = 0; k < path.size(); ++k) {
        check(path[k].start, again[k].start);
        CHECK(path[k].closed == again[k].closed);
        // A closing line that rounds to a point is omitted.
        REQUIRE(again[k].segments.size() + (path[k].closed ? 1 : 0) >= path[k].segments.size());
        for (std::size_t i = 0; i < again[k].segments.size(); ++i) {
            const Segment &s = path[k].segments[i], &t = again[k].segments[i];
            if (s.degree == 3) check(s.p1, t.p1), check(s.p2, t.p2);
            check(s.p3, t.p3);
        }
    }
    // Equal pieces get equal commands.
    Path other = path;
    for (Subpath& subpath : other) subpath.segments[3] = {{0, 0}, {0, 0}, {0, 0}, subpath.segments[3].degree};
    const auto commands = [](std::string data) {
        std::erase_if(data, [](char c) { return c < 'A'; });
        return data;
    };
    CHECK(commands(write_short_path_data(other, decimals)) == commands(text));
}

TEST_CASE("transforms", "[examples][svg_path][transform]") {
    const Point2 p{3, 5};
    CHECK(affine("") == Affine2());
    CHECK(apply(affine("matrix(1 2 3 4 5 6)"), p) == Point2{1 * 3 + 3 * 5 + 5, 2 * 3 + 4 * 5 + 6});
    CHECK(apply(affine("translate(7)"), p) == Point2{10, 5});
    CHECK(apply(affine("translate(7, -1)"), p) == Point2{10, 4});
    CHECK(apply(affine("scale(2)"), p) == Point2{6, 10});
    CHECK(apply(affine("scale(2 -3)"), p) == Point2{6, -15});
    CHECK(near(apply(affine("rotate(90)"), p), {-5, 3}));
    CHECK(near(apply(affine("rotate(90 3 4)"), p), {2, 4}));
    CHECK(near(apply(affine("skewX(45)"), p), {8, 5}));
    CHECK(near(apply(affine("skewY(45)"), p), {3, 8}));
    CHECK(apply(affine(" translate (1 , 2) scale( 2 ),translate(10)\n"), p) == Point2{27, 12});
    CHECK(apply(affine("translate(1-2)scale(.5.25)"), p) == Point2{2.5, -0.75});

    const Affine2 map = affine("rotate(33) translate(4 5) skewX(20) scale(2 3)");
    const auto back = inverse(map);
    REQUIRE(back);
    CHECK(near(apply(*back, apply(map, p)), p));
    CHECK(near(apply(map, apply(*back, p)), p));
    CHECK_FALSE(inverse(affine("scale(0)")));
    CHECK_FALSE(inverse(affine("matrix(1 2 2 4 0 0)")));
    CHECK_FALSE(inverse(affine("matrix(.1 .3 .2 .6 0 0)"))); // singular but for rounding
    CHECK_FALSE(inverse(affine("scale(1e-300)")));
    CHECK(inverse(affine("scale(1e-9)")));
}

TEST_CASE("transforms: errors", "[examples][svg_path][transform][error]") {
    const auto check = [](std::string_view text, std::size_t column, std::string_view reason) {
        CAPTURE(text);
        const auto map = parse_transform(text);
        REQUIRE_FALSE(map);
        CHECK(map.error().line == 1);
        CHECK(map.error().column == column);
        CHECK(map.error().message == reason);
    };
    check("turn(3)", 1, "no transform turn with 1 number");
    check("rotate(1 2)", 1, "no transform rotate with 2 numbers");
    check("scale(1) translate()", 10, "no transform translate with 0 numbers");
    check("translate", 1, "expected a transform such as translate(1 2)");
    check("translate(1", 12, "expected a number");
    check("translate(1,)", 13, "expected a number");
    check("translate(a)", 11, "expected a number");
    check("scale(2),", 10, "expected a transform such as translate(1 2)");
    check("scale(2) 3", 10, "expected a transform such as translate(1 2)");
    check("scale(1e200)scale(1e200)", 1, "transform out of range");
}

TEST_CASE("lengths and lists of numbers", "[examples][svg_path][length]") {
    const auto length = [](std::string_view text, double whole = 0) {
        CAPTURE(text);
        const auto value = parse_length(text, whole);
        REQUIRE(value);
        return *value;
    };
    CHECK(length("12.5") == 12.5);
    CHECK(length(" -3px ") == -3);
    CHECK(length("1in") == 96);
    CHECK(length("72pt") == Approx(96));
    CHECK(length("6pc") == 96);
    CHECK(length("25.4mm") == Approx(96));
    CHECK(length("2.54cm") == Approx(96));
    CHECK(length("25%", 80) == Approx(20));
    CHECK(length("2em") == 32);
    CHECK(length("2ex") == 16);
    CHECK(length("1e2") == 100);
    CHECK(length("calc(25% + 50px)", 200) == 100);
    CHECK(length(" Calc( (1in - 2*3px) / 4 + -1.5px*calc(2) )") == 19.5);
    for (const char* odd :
         {"calc(1px", "calc()", "calc(1px 2px)", "calc(1/0)", "(3px)", "calc(1px +)", "calc 1", "calc(2)px"})
        CHECK_FALSE(parse_length(odd, 1));
    CHECK_FALSE(parse_length("calc" + std::string(100'000, '('), 1));
    CHECK(length("1e2em") == 1600);
    CHECK_FALSE(parse_length("", 1));
    CHECK_FALSE(parse_length("px", 1));
    CHECK_FALSE(parse_length("3 apples", 1));
    CHECK_FALSE(parse_length("1e308in", 1));

    const auto numbers = parse_numbers(" 1,2 -3-4\n.5 ");
    REQUIRE(numbers);
    CHECK(*numbers == std::vector<double>{1, 2, -3, -4, 0.5});
    CHECK(parse_numbers("")->empty());
    CHECK_FALSE(parse_numbers("1,"));
    CHECK_FALSE(parse_numbers(",1"));
    CHECK_FALSE(parse_numbers("1 2 x"));
}

TEST_CASE("path data: mutated text does not crash the parser", "[examples][svg_path][fuzz]") {
    const std::vector<std::string> corpus = {
        "M10 20L30 40h5v6c1 2 3 4 5 6s7 8 9 10q1 2 3 4t5 6a1 2 30 0 1 7 8z",
        "m.5.5 1-2e-3 1e5,6a1 1 0 01.5.5ZL1 1", "translate(1,2)rotate(30 4 5) matrix(1 2 3 4 5 6)skewX(3)",
        "12.5e1mm"};
    const std::string_view letters = "MmLlHhVvCcSsQqTtAaZz0123456789.,-+eE ()\n\t%x";
    const unsigned seed = 20;
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::size_t valid = 0;
    for (int i = 0; i < 4000; ++i) {
        std::string text = corpus[random() % corpus.size()];
        const std::size_t changes = random() % 4;
        for (std::size_t k = 0; k < changes && !text.empty(); ++k) {
            const std::size_t at = random() % text.size();
            switch (random() % 8) {
            case 0: text[at] = letters[random() % letters.size()]; break;
            case 1: text.insert(at, 1, letters[random() % letters.size()]); break;
            case 2: text.erase(at, 1 + random() % 3); break;
            case 3: text[at] = static_cast<char>(random() % 256); break;
            default: text.insert(at, 1, letters[20 + random() % 13]); break; // a digit, a dot or a sign
            }
        }
        const auto path = parse_path_data(text);
        if (path) {
            ++valid;
            const std::string written = write_path_data(*path, 17);
            const auto again = parse_path_data(written);
            INFO(text << "\n" << written);
            REQUIRE(again);
            REQUIRE(write_path_data(*again, 17) == written);
            for (const Subpath& subpath : *path) {
                if (subpath.closed && !subpath.segments.empty()) {
                    REQUIRE(subpath.segments.back().p3 == subpath.start);
                }
            }
        } else {
            REQUIRE(path.error().line >= 1);
            REQUIRE(path.error().column >= 1);
            REQUIRE_FALSE(path.error().message.empty());
        }
        (void)static_cast<bool>(parse_transform(text));
        (void)static_cast<bool>(parse_length(text, 100));
        (void)static_cast<bool>(parse_numbers(text));
    }
    CHECK(valid > 500); // otherwise only refusals are tested
}

} // namespace svg_path_tests
