#include "cli/pose_operations.hpp"
#include "files/cage_file.hpp"
#include "svg/document.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/curved_green.hpp>

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace curved_cage_tests {

using namespace cageform_support;

namespace {

namespace fs = std::filesystem;

SvgDocument document_of(const std::string& content) {
    auto document = parse_svg("<svg xmlns=\"http://www.w3.org/2000/svg\">" + content + "</svg>", "test.svg");
    REQUIRE(document);
    return std::move(*document);
}

std::vector<Subpath> outline_of(const std::string& content) {
    auto outline = first_outline(document_of(content));
    INFO(content);
    if (!outline) FAIL(to_string(outline.error()));
    return *outline;
}

std::string refusal(const std::string& content) {
    const auto outline = first_outline(document_of(content));
    INFO(content);
    REQUIRE_FALSE(outline);
    return to_string(outline.error());
}

std::vector<unsigned> degrees_of(const Subpath& subpath) {
    std::vector<unsigned> degrees;
    for (const Segment& s : subpath.segments) degrees.push_back(s.degree);
    return degrees;
}

CageFile cage_of(const std::string& data, const std::string& name = "cage.svg") {
    return make_curved_cage(name, outline_of("<path d=\"" + data + "\"/>"));
}

std::string pose_refusal(const std::string& cage, const std::string& pose) {
    const auto made = make_pose(cage_of(pose, "pose.svg"), cage_of(cage));
    INFO(pose);
    REQUIRE_FALSE(made);
    return to_string(made.error());
}

/// Path data of a closed loop of segments of random degrees.
std::string random_loop(std::mt19937& random, std::size_t edges) {
    std::uniform_real_distribution<double> place(-100, 100);
    std::uniform_int_distribution<int> degree(1, 3);
    const auto point = [&] {
        return ' ' + std::to_string(place(random)) + ' ' + std::to_string(place(random));
    };
    std::string text = 'M' + point();
    for (std::size_t e = 0; e < edges; ++e) {
        const int n = degree(random);
        text += n == 1 ? 'L' : n == 2 ? 'Q' : 'C';
        for (int k = 0; k < n; ++k) text += point();
    }
    return text + 'Z';
}

/// A point of a Bézier curve of any degree, by de Casteljau's algorithm.
Point2 place_of(std::vector<cageform::Vec<double, 2>> points, double t) {
    for (; points.size() > 1; points.pop_back()) {
        for (std::size_t k = 0; k + 1 < points.size(); ++k)
            points[k] = (1 - t) * points[k] + t * points[k + 1];
    }
    return {points[0][0], points[0][1]};
}

double distance(const Point2& p, const Point2& q) {
    return std::hypot(p.x - q.x, p.y - q.y);
}

} // namespace

TEST_CASE("an outline keeps the degrees of its commands", "[examples][curved_cage]") {
    const auto loops =
        outline_of(R"(<path d="M0 0L9 0H20V5C20 6 19 7 18 8S14 9 12 8Q8 6 6 9T2 8A4 4 0 0 1 0 4Z"/>)");
    REQUIRE(loops.size() == 1);
    auto degrees = degrees_of(loops[0]);
    REQUIRE(degrees.size() > 8);
    CHECK(std::vector<unsigned>(degrees.begin(), degrees.begin() + 7) ==
          std::vector<unsigned>{1, 1, 1, 3, 3, 2, 2});
    CHECK(degrees.back() == 1); // Z
    CHECK(std::all_of(degrees.begin() + 7, degrees.end() - 1, [](unsigned n) { return n == 3; }));

    // Each subpath is a loop and keeps its orientation.
    const auto ring = outline_of(R"(<path d="M0 0H9V9Z M3 1Q4 1 4 2T3 1M7 7"/>)");
    REQUIRE(ring.size() == 2);
    CHECK(degrees_of(ring[0]) == std::vector<unsigned>{1, 1, 1});
    CHECK(degrees_of(ring[1]) == std::vector<unsigned>{2, 2});
    CHECK(ring[1].start == Point2{3, 1});
    CHECK(ring[1].segments[0].p3 == Point2{4, 2});

    // A cubic whose control points coincide with its ends stays a cubic: a pose may move them.
    CHECK(degrees_of(outline_of(R"(<path d="M0 0C0 0 9 0 9 0L9 9Z"/>)")[0]) ==
          std::vector<unsigned>{3, 1, 1});
    CHECK(degrees_of(outline_of(R"(<polygon points="0,0 4,0 4,4"/>)")[0]) == std::vector<unsigned>{1, 1, 1});
}

TEST_CASE("arcs of an outline are cubics of at most 45 degrees", "[examples][curved_cage]") {
    for (const auto& [content, count] : std::vector<std::pair<std::string, std::size_t>>{
             {R"(<circle r="3"/>)", 8},
             {R"(<ellipse rx="3" ry="3"/>)", 8},
             {R"(<path d="M3 0A3 3 0 0 1 -3 0 3 3 0 0 1 3 0"/>)", 8},
             {R"(<path d="M3 0A3 3 0 0 1 2.1213203435596424 2.1213203435596424A3 3 0 1 1 3 0Z"/>)", 8}}) {
        INFO(content);
        const auto loops = outline_of(content);
        REQUIRE(loops.size() == 1);
        CHECK(loops[0].segments.size() == count);
        CHECK(loops[0].segments.back().p3 == loops[0].start);
        double worst = 0;
        Point2 from = loops[0].start;
        for (const Segment& s : loops[0].segments) {
            for (int i = 0; i <= 64; ++i) {
                const Point2 p = place_on(from, s, i / 64.0);
                worst = std::max(worst, std::fabs(std::hypot(p.x, p.y) / 3 - 1));
            }
            from = s.p3;
        }
        CHECK(worst <= 4.3e-6);
    }
    CHECK(outline_of(R"(<rect width="9" height="6" rx="1"/>)")[0].segments.size() == 4 + 4 * 2);
    const auto figure = shapes(document_of(R"(<circle r="3"/>)")); // of a figure they are as they were
    REQUIRE(figure);
    CHECK((*figure)[0].path[0].segments.size() == 4);
}

TEST_CASE("an outline that is not closed is refused", "[examples][curved_cage]") {
    const auto one_loop = [](const std::string& data) { return outline_of("<path d=\"" + data + "\"/>")[0]; };
    CHECK(one_loop("M0 0H4V4Z").segments.size() == 3);
    CHECK(one_loop("M0 0H4V4L0 0").segments.size() == 3);
    CHECK(one_loop("M0 0H4V4L0 0Z").segments.size() == 3);
    CHECK(one_loop("M0 0H4V4L0 1e-9Z").segments.size() == 4);
    // 8 units of rounding of the diagonal: Z adds no line for that.
    for (const char* end : {"1e-15Z", "1e-15"}) {
        const Subpath snapped = one_loop(std::string("M0 0H4V4C3 4 1 3 0 ") + end);
        CHECK(snapped.segments.size() == 3);
        CHECK(snapped.segments.back().p3 == Point2{0, 0});
        CHECK(snapped.segments.back().degree == 3);
    }
    const std::string fault = "a loop of curves is not closed: an edge ends where the next does not begin";
    CHECK(refusal(R"(<path id="p" d="M0 0C1 0 2 1 2 2"/>)") ==
          "test.svg: no closed outline: " + fault +
              ": subpath 0, counted from 0, of path \"p\" (line 1) begins at (0, 0) and ends at (2, 2)");
    CHECK(refusal(R"(<path d="M0 0H4V4ZM1 1L2 1M9 9Q8 8 7 9L9 9"/>)").find(": subpath 1, counted") !=
          std::string::npos);
    CHECK(refusal(R"(<path d="M0 0H4V4L0 1e-9"/>)").find(fault) != std::string::npos);
    CHECK(refusal("") == "test.svg: no closed outline: there is no shape");
    CHECK(refusal(R"(<path d="M0 0"/>)") == "test.svg: no closed outline: there is no shape");
    // Open lines before the outline are ignored; an open subpath next to a closed one is an error.
    CHECK(outline_of(R"(<path d="M0 0L1 1"/><path d="M5 5H6V6Z"/>)")[0].start == Point2{5, 5});
    CHECK(refusal(R"(<path id="q" d="M0 0L1 1M0 0H1V1Z"/><path d="M5 5H6V6Z"/>)").find("path \"q\"") !=
          std::string::npos);
}

TEST_CASE("transforms act on control points", "[examples][curved_cage][property]") {
    const auto plain = outline_of(R"(<path d="M1 2C3 4 5 6 9 2Q8 1 7 0L1 0Z"/>)");
    const auto mapped = outline_of(
        R"x(<g transform="translate(10 20)"><path transform="matrix(2 1 -1 3 0 0)" d="M1 2C3 4 5 6 9 2Q8 1 7 0L1 0Z"/></g>)x");
    const auto map = [](const Point2& p) { return Point2{2 * p.x - p.y + 10, p.x + 3 * p.y + 20}; };
    REQUIRE(mapped.size() == 1);
    CHECK(degrees_of(mapped[0]) == degrees_of(plain[0]));
    CHECK(mapped[0].start == map(plain[0].start));
    for (std::size_t k = 0; k < plain[0].segments.size(); ++k) {
        CHECK(distance(mapped[0].segments[k].p1, map(plain[0].segments[k].p1)) <= 1e-13);
        CHECK(distance(mapped[0].segments[k].p2, map(plain[0].segments[k].p2)) <= 1e-13);
        CHECK(distance(mapped[0].segments[k].p3, map(plain[0].segments[k].p3)) <= 1e-13);
    }
}

TEST_CASE("a cage of cubic curves has three control points per edge", "[examples][curved_cage][property]") {
    const unsigned seed = std::random_device()();
    CAPTURE(seed);
    std::mt19937 random(seed);
    for (int round = 0; round < 50; ++round) {
        const std::string data = random_loop(random, 4) + random_loop(random, 3);
        CAPTURE(data);
        const auto loops = outline_of("<path d=\"" + data + "\"/>");
        const CageFile cage = make_curved_cage("cage.svg", loops);
        REQUIRE(cage.blocks.size() == 2);
        REQUIRE(cage.curves);
        CHECK(cage.vertices.size() == 3 * (loops[0].segments.size() + loops[1].segments.size()));
        const auto polygon = cage.curved_polygon<double>();
        REQUIRE(polygon.loops().size() == 2);
        for (std::size_t b = 0; b < 2; ++b) {
            CHECK(cage.curves->degrees[b] == degrees_of(loops[b]));
            Point2 from = loops[b].start;
            for (std::size_t e = 0; e < loops[b].segments.size(); ++e) {
                const Segment& s = loops[b].segments[e];
                const auto& edge = polygon.loops()[b][e];
                REQUIRE(edge.size() == s.degree + 1);
                CHECK(cage.vertices[cage.handles[b][3 * e]] == from);
                CHECK(cage.vertices[cage.handles[b][3 * e + 1]] == s.p1);
                CHECK(cage.vertices[cage.handles[b][3 * e + 2]] == s.p2);
                for (const double t : {0.0, 0.25, 0.7, 1.0})
                    CHECK(distance(place_of(edge, t), place_on(from, s, t)) <= 1e-12);
                from = s.p3;
            }
        }
        // Written and read, it is unchanged to the bit.
        const auto text = to_svg(cage, {0, 0, 1, 1});
        REQUIRE(text);
        const auto document = parse_svg(*text, "written.svg");
        REQUIRE(document);
        const auto again = first_outline(*document);
        REQUIRE(again);
        CHECK(make_curved_cage("again.svg", *again).vertices == cage.vertices);
        // A moved cage is written as cubics with the given control points.
        auto places = cage.places();
        for (auto& p : places) p = 2.0 * p;
        const CageFile moved = moved_cage(cage, places);
        const auto cubics = moved.curved_polygon<double>();
        for (const auto& loop : cubics.loops()) {
            for (const auto& edge : loop) CHECK(edge.size() == 4);
        }
    }
}

TEST_CASE("vertices of a cage of curves are the handles of its coordinates", "[examples][curved_cage]") {
    // Also for loops of the wrong orientation: a pose has the orientation of its cage.
    for (const char* data :
         {"M0 0L6 0Q8 3 6 6C4 7 2 7 0 6Z", "M0 0L0 6C2 7 4 7 6 6Q8 3 6 0Z",
          "M0 0L6 0Q8 3 6 6C4 7 2 7 0 6ZM1 1H2Q2 2 1 2Z", "M0 0L6 0L6 6L0 6ZM1 1V2H2V1Z"}) {
        CAPTURE(data);
        const CageFile cage = cage_of(data);
        const cageform::CurvedGreenCoordinates<double> coordinates(cage.curved_polygon<double>());
        REQUIRE(coordinates.cage_report().status == cageform::Status::ok);
        const auto handles = coordinates.handles();
        REQUIRE(handles.size() == 2 * cage.vertices.size());
        for (std::size_t i = 0; i < cage.vertices.size(); ++i)
            CHECK(distance({handles[i][0], handles[i][1]}, cage.vertices[i]) <= 4e-15);
        // A pose from a file deforms the figure in the same way as its control points.
        const std::vector<cageform::Vec<double, 2>> points{{3, 5}, {5, 3}, {0.5, 2.5}};
        const auto [binding, report] = cageform::bind(coordinates, points);
        REQUIRE(report.status == cageform::Status::ok);
        auto places = cage.places();
        for (auto& p : places) p = {3 - 2 * p[1], 1 + 2 * p[0]}; // a similarity
        std::vector<cageform::Vec<double, 2>> all(binding.handle_count()), out(points.size());
        REQUIRE(pose_handles(binding, places, all).status == cageform::Status::ok);
        REQUIRE(clone(binding, all, out) == cageform::Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CHECK(std::fabs(out[i][0] - (3 - 2 * points[i][1])) <= 1e-13);
            CHECK(std::fabs(out[i][1] - (1 + 2 * points[i][0])) <= 1e-13);
        }
    }
}

TEST_CASE("a polygon becomes a cage of curves", "[examples][curved_cage]") {
    const auto made =
        with_curves(make_cage("c.csv", {{CageBlock::Kind::loop, 0, {{0, 0}, {6, 0}, {6, 6}}},
                                        {CageBlock::Kind::loop, 0, {{4, 1}, {5, 1}, {5, 2}, {4, 2}}}}));
    REQUIRE(made);
    CHECK(made->vertices.size() == 3 * 7);
    CHECK(made->vertices[3] == Point2{6, 0});
    CHECK(distance(made->vertices[1], {2, 0}) <= 1e-15);
    CHECK(made->curves->degrees == std::vector<std::vector<unsigned>>{{1, 1, 1}, {1, 1, 1, 1}});
    CHECK(with_curves(*made)->vertices == made->vertices);
    // Two coincident vertices of a pose stay two vertices.
    CHECK(with_curves(make_cage("p.csv", {{CageBlock::Kind::loop, 0, {{0, 0}, {6, 0}, {0, 0}}}}))
              ->vertices.size() == 9);
    const auto refused = with_curves(make_cage("c.csv", {{CageBlock::Kind::loop, 0, {{0, 0}, {6, 0}, {6, 6}}},
                                                         {CageBlock::Kind::point, 1, {{5, 1}}}}));
    REQUIRE_FALSE(refused);
    CHECK(to_string(refused.error()).starts_with("c.csv: "));
    CHECK(to_string(refused.error()).find("--coordinates curved-green supports only loops, harmonic also") !=
          std::string::npos);
}

TEST_CASE("a pose has the commands of its cage, or ones of higher degree", "[examples][curved_cage]") {
    const std::string cage = "M0 0L6 0Q8 3 6 6C4 7 2 7 0 6Z";
    const auto bent =
        make_pose(cage_of("M0 0C2 1 4 1 6 0C8 2 8 4 6 6C4 9 2 9 0 6Q-1 3 0 0Z", "pose.svg"), cage_of(cage));
    REQUIRE(bent);
    CHECK(bent->vertices.size() == 12);
    CHECK(bent->vertices[1] == Point2{2, 1});
    // A pose keeps its own orientation, also if it is mirrored.
    const auto mirrored = make_pose(cage_of("M0 0L-6 0Q-8 3 -6 6C-4 7 -2 7 0 6Z", "pose.svg"), cage_of(cage));
    REQUIRE(mirrored);
    CHECK(mirrored->vertices[3] == Point2{-6, 0});

    CHECK(pose_refusal(cage, "M0 0L6 0Q8 3 6 6Q4 7 0 6Z") ==
          "pose.svg: edge 2, counted from 0, a quadratic (Q), is a cubic (C) in the cage cage.svg");
    CHECK(pose_refusal(cage, "M0 0L6 0L6 6C4 7 2 7 0 6Z") ==
          "pose.svg: edge 1, counted from 0, a line (L), is a quadratic (Q) in the cage cage.svg");
    CHECK(pose_refusal(cage, "M0 0L6 0C4 7 2 7 0 6Z") ==
          "pose.svg: the pose has 3 edges, the cage cage.svg 4: edge 2, counted from 0, a line (L), is a "
          "cubic (C) "
          "in the cage");
    CHECK(pose_refusal(cage, "M0 0L6 0Q8 3 6 6C4 7 2 7 0 0Z") ==
          "pose.svg: the pose has 3 edges, the cage cage.svg 4: edge 3, counted from 0, a line (L), is "
          "missing");
    CHECK(pose_refusal(cage, "M0 0L6 0Q8 3 6 6C4 7 2 7 0 6L0 3Z") ==
          "pose.svg: the pose has 5 edges, the cage cage.svg 4: edge 4, counted from 0, a line (L), is one "
          "too many");
    CHECK(pose_refusal(cage, "M0 0H4V4ZM1 1H2V2Z") ==
          "pose.svg: the pose has 2 loops, the cage cage.svg 1 loop");
    CHECK(pose_refusal("M0 0H4V4ZM1 1H2V2Z", "M0 0H4V4ZM1 1H2Z")
              .starts_with("pose.svg: loop 1: the pose has 2"));
}

TEST_CASE("cages of lines and of curves are read from one file", "[examples][curved_cage]") {
    const fs::path folder =
        fs::temp_directory_path() / ("cageform-curves-" + std::to_string(std::random_device()()));
    fs::create_directories(folder);
    const auto file = [&](const std::string& name, const std::string& text) {
        std::ofstream(folder / name) << text;
        return (folder / name).string();
    };
    const auto svg = [&](const std::string& name, const std::string& data) {
        return file(name,
                    "<svg xmlns=\"http://www.w3.org/2000/svg\"><path id=\"c\" d=\"" + data + "\"/></svg>");
    };
    const std::string curve = svg("curve.svg", "M0 0Q9 0 9 9Z"), lines = svg("lines.svg", "M0 0H9V9Z");
    CHECK(load_cage(lines)->vertices.size() == 3);
    CHECK_FALSE(load_cage(lines, CageEdges::as_drawn)->curves);
    CHECK(load_cage(lines, CageEdges::curves)->vertices.size() == 9);
    CHECK(load_cage(curve, CageEdges::curves)->vertices.size() == 6);
    CHECK(load_cage(curve, CageEdges::as_drawn)->vertices.size() == 6);
    const auto refused = load_cage(curve);
    REQUIRE_FALSE(refused);
    CHECK(to_string(refused.error()) ==
          "curve.svg: no closed polygon: the first shape is a path with curves: path \"c\" (line 1); "
          "--coordinates curved-green takes curves");
    const auto open = load_cage(svg("open.svg", "M0 0Q9 0 9 9"));
    REQUIRE_FALSE(open);
    CHECK(to_string(open.error()).find("curved") == std::string::npos);

    // A CSV polygon can have a pose of curves, and an outline of lines a CSV pose.
    const auto csv = load_cage(file("loop.csv", "0,0\n9,0\n9,9\n"), CageEdges::curves);
    REQUIRE(csv);
    const auto bent = load_pose(svg("bent.svg", "M0 0C3 -2 6 -2 9 0L9 9Z"), *csv);
    REQUIRE(bent);
    CHECK(bent->vertices[1] == Point2{3, -2});
    CHECK(load_pose(file("pose.csv", "0,0\n9,0\n9,8\n"), *load_cage(lines, CageEdges::curves))->vertices[6] ==
          Point2{9, 8});
    const auto of_curve =
        load_pose(file("pose.csv", "0,0\n9,0\n9,8\n"), *load_cage(curve, CageEdges::curves));
    REQUIRE_FALSE(of_curve);
    CHECK(to_string(of_curve.error()).find("the pose has 3 edges") != std::string::npos);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
}

TEST_CASE("moving the end of an edge moves its control points", "[examples][curved_cage][property]") {
    using Vec2 = cageform::Vec<double, 2>;
    const unsigned seed = std::random_device()();
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::size_t> edges(1, 6), number(0, 1000);
    for (int round = 0; round < 100; ++round) {
        const CageFile cage =
            cage_of(random_loop(random, edges(random)) + random_loop(random, edges(random)));
        const auto rest = cage.places();
        const std::size_t count = cage.handles[0].size(), n = number(random) % count;
        const auto followers = cage.followers();
        auto pose = rest;
        CAPTURE(n, count);
        REQUIRE(apply_operation<2>(PoseOperation::move, std::to_string(n) + ":3,4", std::span(rest),
                                   std::span(pose), followers)
                    .empty());
        for (std::size_t i = 0; i < rest.size(); ++i) {
            const bool is_beside =
                n % 3 == 0 && i < count && (i == (n + 1) % count || i == (n + count - 1) % count);
            CHECK(pose[i] == (i == n || is_beside ? rest[i] + Vec2{3, 4} : rest[i]));
        }
        // An end that is turned about itself stays, and its control points turn.
        if (n % 3 != 0) continue;
        pose = rest;
        REQUIRE(apply_operation<2>(PoseOperation::turn, std::to_string(n) + ":90", std::span(rest),
                                   std::span(pose), followers)
                    .empty());
        CHECK(pose[n] == rest[n]);
        const auto before = rest[(n + 1) % count] - rest[n], after = pose[(n + 1) % count] - pose[n];
        CHECK(std::hypot(after[0] + before[1], after[1] - before[0]) <= 1e-12);
    }
    const CageFile polygon = make_cage("c.csv", {{CageBlock::Kind::loop, 0, {{0, 0}, {6, 0}, {6, 6}}}});
    CHECK(polygon.followers().empty());
}

TEST_CASE("moving a control point moves nothing else", "[examples][curved_cage]") {
    const CageFile cage = cage_of("M0 0H9V9ZM5 1H6V2Z");
    const auto rest = cage.places();
    auto pose = rest;
    CHECK(move_control_point("1:3:0.5,-1", cage.handles, pose).empty());
    for (std::size_t i = 0; i < rest.size(); ++i)
        CHECK(pose[i] == (i == 12 ? rest[i] + cageform::Vec<double, 2>{0.5, -1} : rest[i]));
    pose[3] = {1e308, 0};
    const auto before = pose;
    const auto refused = [&](const std::string& word) {
        const std::string why = move_control_point(word, cage.handles, pose);
        CHECK(pose == before);
        return why;
    };
    CHECK(refused("2:0:1,1") == "there is no loop 2: the cage has 2, 0 to 1");
    CHECK(refused("1:9:1,1") == "there is no control point 9: the loop has 9, 0 to 8");
    CHECK(refused("1:1") == "\"1:1\" is not LOOP:K:DX,DY: a loop, one of its control points, and a move");
    CHECK(refused("1::1,1") == "\"\" is not a control point number");
    CHECK(refused("1:-1:1,1") == "\"-1\" is not a control point number");
    CHECK(refused("0:1:1") == "\"1\" is not x,y");
    CHECK(refused("0:1:1,nan") == "\"nan\" is not a finite number");
    CHECK(refused("0:3:1e308,0") == "control point 3 exceeds the range of numbers");
}

TEST_CASE("the picture of a cage of curves shows ends and control points", "[examples][curved_cage]") {
    SvgDocument document = document_of("");
    draw_cage(document, cage_of("M0 0L9 0Q12 5 9 9C6 12 3 12 0 9Z"), 100, "#c2377a");
    const std::string text = to_text(document);
    const auto count = [&](const std::string& word) {
        std::size_t n = 0;
        for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) ++n;
        return n;
    };
    CHECK(count("<rect") == 4);
    CHECK(count("<circle") == 4); // none on lines
    CHECK(text.find("C6 12 3 12 0 9") != std::string::npos);
}

} // namespace curved_cage_tests
