#include "cli/pose_operations.hpp"
#include "files/cage_file.hpp"
#include "svg/document.hpp"

#include "catch.hpp"
#include "support/larger.hpp"

#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace pose_operations_tests {

using namespace cageform_support;
using cageform::Vec;
using cageform_tests::larger;

namespace {

template <std::size_t D>
using Points = std::vector<Vec<double, D>>;

template <std::size_t D>
Points<D> random_points(unsigned seed, std::size_t count = 12) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1, 1);
    Points<D> points(count);
    for (auto& p : points) {
        for (double& x : p.v) x = place(random);
    }
    return points;
}

template <std::size_t D>
std::string refusal(PoseOperation operation, const std::string& word) {
    const auto rest = random_points<D>(1);
    auto pose = rest;
    const std::string why = apply_operation<D>(operation, word, std::span(rest), std::span(pose));
    CHECK(pose == rest);
    return why;
}

using Step = std::pair<PoseOperation, std::string>;

template <std::size_t D>
Points<D> posed(const Points<D>& rest, const std::vector<Step>& steps) {
    auto pose = rest;
    for (const auto& [operation, word] : steps) {
        INFO(word);
        REQUIRE(apply_operation<D>(operation, word, std::span(rest), std::span(pose)) == "");
    }
    return pose;
}

template <std::size_t D>
double distance(const Vec<double, D>& a, const Vec<double, D>& b) {
    return std::sqrt(dot(a - b, a - b));
}
template <std::size_t D>
double largest_distance(const Points<D>& a, const Points<D>& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = larger(worst, distance(a[i], b[i]));
    return worst;
}

template <std::size_t D>
std::vector<std::size_t> selected(const Points<D>& rest, const std::string& word) {
    const auto found = parse_selection<D>(word, std::span(rest));
    INFO(word);
    REQUIRE(found);
    return *found;
}

constexpr auto move = PoseOperation::move, turn = PoseOperation::turn, scale = PoseOperation::scale,
               bend = PoseOperation::bend, twist = PoseOperation::twist;

} // namespace

TEST_CASE("selections are numbers, ranges and boxes", "[examples][pose]") {
    const Points<2> rest{{0, 0}, {10, 0}, {20, 5}, {10, 10}, {0, 10}};
    using List = std::vector<std::size_t>;
    CHECK(selected(rest, "3") == List{3});
    CHECK(selected(rest, "4,1-2, 2 - 3") == List{1, 2, 3, 4});
    CHECK(selected(rest, "all") == List{0, 1, 2, 3, 4});
    CHECK(selected(rest, "x>5") == List{1, 2, 3});
    CHECK(selected(rest, "x > 5 & y < 1e1") == List{1, 2});
    CHECK(selected(rest, "x<5&y>-1&y<1,2") == List{0, 2});
    CHECK(selected(Points<3>{{0, 0, 0}, {0, 0, 1}}, "z>0.5") == List{1});

    const auto why = [&](const std::string& word) {
        const auto found = parse_selection<2>(word, std::span(std::as_const(rest)));
        INFO(word);
        REQUIRE_FALSE(found);
        return to_string(found.error());
    };
    CHECK(why("5") == "there is no vertex 5: the cage has 5, 0 to 4");
    CHECK(why("99999999999999999999") == "there is no vertex 99999999999999999999: the cage has 5, 0 to 4");
    CHECK(why("3-1") == "\"3-1\" counts backwards");
    CHECK(why("1-") == "\"\" is not a vertex number");
    CHECK(why("1x") == "\"1x\" is not a vertex number");
    CHECK(why("x>20") == "\"x>20\" holds for no vertex of the cage");
    CHECK(why("x>far") == "not a number: \"far\"");
    CHECK(why("x>nan") == "\"nan\" is not a finite number");
    for (const char* word : {"", "1,", "z>0", "left", "x", "x=3", "-1", "all&x>0", "x>0&"}) {
        CHECK_THAT(why(word), containing("selects nothing: write a number, 5-9, all, or a condition"));
    }
}

TEMPLATE_TEST_CASE_SIG("an operation and its inverse return to rest", "[examples][pose]",
                       ((std::size_t D), D), 2, 3) {
    const unsigned seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    const auto rest = random_points<D>(seed);
    const bool plane = D == 2;
    const std::vector<std::pair<Step, Step>> pairs{
        {{move, plane ? "all:3,-2" : "all:3,-2,1"}, {move, plane ? "all:-3,2" : "all:-3,2,-1"}},
        {{turn, plane ? "2-7:40" : "2-7:40,1,2,-1"}, {turn, plane ? "2-7:-40" : "2-7:-40,1,2,-1"}},
        {{turn, plane ? "3:190@1,2" : "3:190,z@1,2,3"}, {turn, plane ? "3:-190@1,2" : "3:-190,z@1,2,3"}},
        {{scale, "1,5,9:4"}, {scale, "1,5,9:0.25"}},
        {{scale, plane ? "all:-1,2" : "all:-1,2,1"}, {scale, plane ? "all:-1,0.5" : "all:-1,0.5,1"}}};
    for (const auto& [there, back] : pairs) {
        CHECK(largest_distance(posed(rest, {there}), rest) > 0.01);
        CHECK(largest_distance(posed(rest, {there, back}), rest) < 1e-14);
    }
    if constexpr (D == 3) {
        CHECK(largest_distance(
                  posed(rest, {{twist, "all:y,-0.5,0.5,70@0,0,0"}, {twist, "all:y,-0.5,0.5,-70@0,0,0"}}),
                  rest) < 1e-14);
    }
}

TEST_CASE("operations are applied in their order", "[examples][pose]") {
    const Points<2> rest{{1, 0}, {2, 0}};
    CHECK(posed(rest, {{move, "all:1,0"}, {turn, "all:90@0,0"}}) == Points<2>{{0, 2}, {0, 3}});
    CHECK(posed(rest, {{turn, "all:90@0,0"}, {move, "all:1,0"}}) == Points<2>{{1, 1}, {1, 2}});
    // Means are those of the current pose; selections use the positions at rest.
    CHECK(posed(rest, {{move, "1:3,4"}, {turn, "0:180@v1"}, {turn, "0:90@vall"}}) ==
          Points<2>{{5, 8}, {5, 4}});
    CHECK(posed(rest, {{move, "all:10,0"}, {scale, "all:2"}}) == Points<2>{{10.5, 0}, {12.5, 0}});
    CHECK(posed(rest, {{move, "x>1.5:10,0"}, {move, "x<1.5:5,0"}, {move, "x>1.5:1,0"}}) ==
          Points<2>{{6, 0}, {13, 0}});
}

TEMPLATE_TEST_CASE_SIG("moves and turns keep lengths and the points that are not selected",
                       "[examples][pose]", ((std::size_t D), D), 2, 3) {
    const unsigned seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    const auto rest = random_points<D>(seed);
    const auto pose = posed(rest, {{turn, D == 2 ? "0-5:77" : "0-5:77,3,-1,2"},
                                   {move, D == 2 ? "0-5:1,2" : "0-5:1,2,3"},
                                   {turn, D == 2 ? "0-5:-200@4,4" : "0-5:-200,x@4,4,4"}});
    double worst = 0;
    for (std::size_t i = 0; i <= 5; ++i) {
        for (std::size_t j = 0; j < i; ++j)
            worst = larger(worst, std::fabs(distance(pose[i], pose[j]) - distance(rest[i], rest[j])));
    }
    CHECK(worst < 1e-14);
    for (std::size_t i = 6; i < rest.size(); ++i) CHECK(pose[i] == rest[i]);
}

TEST_CASE("right angles are exact, and angles turn from x towards y", "[examples][pose]") {
    const Points<2> rest{{3, 1}};
    for (const char* angle : {"90", "-270", "450", "36000090"})
        CHECK(posed(rest, {{turn, std::string("0:") + angle + "@0,0"}}) == Points<2>{{-1, 3}});
    CHECK(posed(rest, {{turn, "0:1e300@3,1"}}) == rest);
    const Points<3> space{{3, 1, 5}};
    CHECK(posed(space, {{turn, "0:90,z@0,0,0"}}) == Points<3>{{-1, 3, 5}});
    CHECK(posed(space, {{turn, "0:90,0,0,1e300@0,0,0"}}) == Points<3>{{-1, 3, 5}});
    CHECK(posed(space, {{turn, "0:90,x@0,0,0"}}) == Points<3>{{3, -5, 1}});
    CHECK(posed(space, {{twist, "0:y,0,2,180@0,0,0"}}) == Points<3>{{5, 1, -3}}); // half of it at y = 1
}

TEMPLATE_TEST_CASE_SIG("a bend keeps the lengths of its axis", "[examples][pose]", ((std::size_t D), D), 2,
                       3) {
    const std::string degrees = GENERATE("90", "-35", "400", "0", "1e-9");
    const bool backwards = GENERATE(false, true);
    CAPTURE(degrees, backwards);
    constexpr std::size_t count = 3001;
    const double from = backwards ? 2 : 1, to = backwards ? 1 : 2;
    Points<D> axis(count);
    for (std::size_t i = 0; i < count; ++i) axis[i][0] = 3.0 * double(i) / (count - 1);
    const std::string place = D == 2 ? "@0,0" : "@0,0,0";
    const auto pose =
        posed(axis, {{bend, std::string("all:xy,") + (backwards ? "2,1," : "1,2,") + degrees + place}});
    const double step = 3.0 / (count - 1), angle = std::stod(degrees) * 3.14159265358979323846 / 180;
    double worst = 0, kept = 0;
    for (std::size_t i = 0; i + 1 < count; ++i) // chord and arc differ by angle² / 24
        worst = larger(worst, std::fabs(distance(pose[i], pose[i + 1]) - step));
    CHECK(worst < step * (angle * step * angle * step / 20 + 1e-10));
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_before = backwards ? axis[i][0] >= from : axis[i][0] <= from;
        if (is_before) CHECK(pose[i] == axis[i]);
        if (D == 3) CHECK(pose[i][D - 1] == 0);
    }
    // The part beyond the bend rotates by the whole angle about one point: it stays straight, of equal length.
    const std::size_t end = backwards ? 0 : count - 1, near = backwards ? count / 3 - 1 : 2 * count / 3 + 1;
    const auto beyond = pose[end] - pose[near];
    const double length = std::fabs(axis[end][0] - axis[near][0]), sign = to > from ? 1 : -1;
    kept = larger(kept, std::fabs(sign * beyond[0] - length * std::cos(angle)));
    kept = larger(kept, std::fabs(beyond[1] - length * std::sin(angle)));
    CHECK(kept < 1e-12);
}

TEST_CASE("a bend is perpendicular to its axis and smooth", "[examples][pose]") {
    const unsigned seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> along(-1, 4), across(-0.2, 0.2);
    const double x = along(random), y = across(random);
    const Points<2> rest{{x, 0}, {x, y}, {x + 1e-7, y}};
    const auto pose = posed(rest, {{bend, "all:xy,0,2,70@0,0"}});
    CHECK(std::fabs(distance(pose[0], pose[1]) - std::fabs(y)) < 1e-14);
    CHECK(distance(pose[1], pose[2]) < 1.2e-7 * (1 + 0.2 * 1.3));
}

TEST_CASE("a twist keeps heights and distances from its axis", "[examples][pose]") {
    const unsigned seed = GENERATE(range(0u, 20u));
    const std::size_t axis = GENERATE(0u, 1u, 2u);
    CAPTURE(seed, axis);
    const auto rest = random_points<3>(seed, 40);
    const std::string word = std::string("all:") + "xyz"[axis] + ",-0.5,0.5,120@0.1,0.2,0.3";
    const auto pose = posed(rest, {{twist, word}});
    const Vec<double, 3> centre{0.1, 0.2, 0.3};
    double worst = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        CHECK(pose[i][axis] == rest[i][axis]);
        auto before = rest[i] - centre, after = pose[i] - centre;
        before[axis] = after[axis] = 0;
        worst = larger(worst, std::fabs(std::sqrt(dot(before, before)) - std::sqrt(dot(after, after))));
        const double share = std::clamp(rest[i][axis] + 0.5, 0.0, 1.0);
        const double turned = std::atan2(cross(before, after)[axis], dot(before, after));
        worst = larger(worst, std::fabs(turned - share * 120 * 3.14159265358979323846 / 180));
        if (rest[i][axis] <= -0.5) CHECK(pose[i] == rest[i]);
    }
    CHECK(worst < 1e-12);
}

TEST_CASE("text that is not an operation is reported", "[examples][pose]") {
    CHECK(refusal<2>(move, "3,1,2") ==
          "\"3,1,2\" has no colon between the vertices and the numbers, such as 5-9:30");
    CHECK(refusal<2>(move, "12:1,2") == "there is no vertex 12: the cage has 12, 0 to 11");
    CHECK(refusal<2>(move, "1:1") == "\"1\" is not x,y");
    CHECK(refusal<3>(move, "1:1,2") == "\"1,2\" is not x,y,z");
    CHECK(refusal<2>(move, "1:1,b") == "not a number: \"b\"");
    CHECK(refusal<2>(move, "1:1,inf") == "\"inf\" is not a finite number");
    CHECK(refusal<2>(move, "1:1,2@0,0") == "\"1:1,2@0,0\" has a point, which a move does not use");
    CHECK(refusal<2>(turn, "1:") == "not a number: \"\"");
    CHECK(refusal<2>(turn, "1:30,x") == "\"30,x\" is not one angle");
    CHECK(refusal<2>(turn, "1:30@1") == "\"1\" is not a point: write x,y, or v and vertices such as v2,7");
    CHECK(refusal<3>(turn, "1:30@1,2") ==
          "\"1,2\" is not a point: write x,y,z, or v and vertices such as v2,7");
    CHECK(refusal<2>(turn, "1:30@v12") == "there is no vertex 12: the cage has 12, 0 to 11");
    CHECK(refusal<2>(turn, "1:30@1,c") == "not a number: \"c\"");
    CHECK(refusal<3>(turn, "1:30") == "\"30\" is not an angle and an axis, such as 30,y or 30,1,1,0");
    CHECK(refusal<3>(turn, "1:30,w") == "\"30,w\" has no axis x, y or z");
    CHECK(refusal<3>(turn, "1:30,0,0,0") == "\"30,0,0,0\" has an axis of length zero");
    CHECK(refusal<2>(scale, "1:1,2,3") == "\"1,2,3\" is neither a factor nor x,y");
    CHECK(refusal<2>(bend, "1:xy,0,1") == "\"xy,0,1\" is not AXES,FROM,TO,DEGREES");
    for (const char* axes : {"x", "xx", "xz", "xyx", "", "ab"}) {
        CHECK_THAT(refusal<2>(bend, std::string("1:") + axes + ",0,1,30"),
                   Catch::Matchers::EndsWith("must begin with xy or yx"));
    }
    CHECK(refusal<2>(bend, "1:xy,1,1,30") == "\"xy,1,1,30\" begins and ends at the same position");
    CHECK(refusal<2>(twist, "1:x,0,1,30") == "\"x,0,1,30\" is for cages in space");
    CHECK_THAT(refusal<3>(twist, "1:xy,0,1,30"), Catch::Matchers::EndsWith("must begin with x, y or z"));
    CHECK(refusal<2>(scale, "all:1e300@1e300,1e300") == "vertex 0 exceeds the range of numbers");
}

TEST_CASE("cages written and read are unchanged to the bit", "[examples][cage]") {
    const unsigned seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    std::vector<CageBlock> blocks;
    for (const unsigned loop : {0u, 1u}) {
        auto& block = blocks.emplace_back();
        for (const auto& p : random_points<2>(2 * seed + loop, 5))
            block.points.push_back({1e3 * p[0], p[1] / 3});
    }
    const auto cage = make_cage("cage", blocks);
    const auto text = to_svg(cage, {-1000, -1, 2000, 2});
    REQUIRE(text);
    const auto document = parse_svg(*text, "c.svg");
    REQUIRE(document);
    const auto loops = first_polygon(*document);
    REQUIRE(loops);
    CHECK(*loops == std::vector{blocks[0].points, blocks[1].points});

    blocks.push_back({CageBlock::Kind::chain, 0, {{0.1, 0.2}, {1e-30, 1e300}}});
    blocks.push_back({CageBlock::Kind::point, 1.0 / 3, {{0.3, 0.1}}});
    const auto read = parse_cage_csv(to_csv(make_cage("cage", blocks)), "c.csv");
    REQUIRE(read);
    REQUIRE(read->size() == blocks.size());
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        CHECK((*read)[b].kind == blocks[b].kind);
        CHECK((*read)[b].radius == blocks[b].radius);
        CHECK((*read)[b].points == blocks[b].points);
    }

    blocks[1].points.back() = blocks[1].points.front();
    const auto closed = to_svg(make_cage("cage", {blocks[1]}), {0, 0, 1, 1});
    REQUIRE_FALSE(closed);
    CHECK_THAT(to_string(closed.error()), containing("two vertices lie at the same position"));
}

} // namespace pose_operations_tests
