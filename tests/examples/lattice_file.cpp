#include "files/lattice_file.hpp"
#include "cli/mesh_cage.hpp"
#include "files/cage_file.hpp"
#include "files/obj_file.hpp"
#include "svg/document.hpp"

#include "catch.hpp"

#include <random>
#include <string>
#include <vector>

namespace lattice_file_tests {

using namespace cageform_support;

namespace {

using Vec2 = cageform::Vec<double, 2>;

std::string refusal(const std::string& word) {
    const auto read = parse_lattice_word(word);
    INFO(word);
    REQUIRE_FALSE(read);
    return to_string(read.error());
}

LatticeBox<2> lattice_of(const std::string& word) {
    const auto read = parse_lattice_word(word);
    REQUIRE(read);
    auto lattice = lattice_about<2>(*read, std::vector<Vec2>{{0, 0}, {30, 40}}, 0.1, "figure.svg");
    REQUIRE(lattice);
    return *lattice;
}

/// The points of the rows, then those of the columns.
std::vector<std::vector<Point2>> lines_of(const CageFile& cage) {
    std::vector<std::vector<Point2>> lines;
    for (const CageBlock& block : cage.blocks) lines.push_back(block.points);
    return lines;
}

template <std::size_t D>
bool same(const LatticeBox<D>& a, const LatticeBox<D>& b) {
    for (std::size_t k = 0; k < D; ++k) {
        if (a.axes[k].points != b.axes[k].points || a.axes[k].degree != b.axes[k].degree ||
            a.axes[k].knots != b.axes[k].knots || a.frame.columns[k] != b.frame.columns[k])
            return false;
    }
    return a.frame.translation == b.frame.translation && a.falloff == b.falloff;
}

} // namespace

TEST_CASE("lattices are read from text", "[examples][lattice]") {
    const auto plain = lattice_of("4x5");
    CHECK(plain.axes[0].points == 4);
    CHECK(plain.axes[1].points == 5);
    CHECK(plain.axes[1].degree == 3);
    CHECK(plain.falloff == 0);
    CHECK(plain.frame.translation == Vec2{-5, -5}); // a tenth of the diagonal, 50
    CHECK(plain.frame.columns[0] == Vec2{40, 0});
    CHECK(plain.frame.columns[1] == Vec2{0, 50});
    CHECK(lattice_of("2x6/2").axes[0].degree == 1);
    CHECK(lattice_of("2x6/2").axes[1].degree == 2);
    CHECK(lattice_of("9x64/bernstein").axes[0].degree == 8);
    CHECK(std::fabs(lattice_of("4x4/1+0.5").falloff - 0.5 * std::hypot(40, 50)) <= 1e-12);
    const auto three = parse_lattice_word("4x5x6/bernstein+1e-1");
    REQUIRE(three);
    CHECK(three->points == std::vector<std::size_t>{4, 5, 6});
    CHECK(three->falloff == 0.1);

    // A turned box contains the figure, and is smaller for a figure that is turned in the same way.
    const auto turned = lattice_of("4x4@53.13010235415598"); // along the diagonal, of length 50
    CHECK(std::fabs(turned.frame.columns[0][0] - 36) <= 1e-9);
    CHECK(std::fabs(turned.frame.columns[0][1] - 48) <= 1e-9);
    CHECK(std::fabs(dot(turned.frame.columns[0], turned.frame.columns[1])) <= 1e-9);

    for (const char* word : {"", "4", "4x", "x4", "4xx4", "4.5x4", "ax4", "4x4x", "-4x4", "nanx4"})
        CHECK(refusal(word) == "lattice:" + std::string(word) +
                                   (std::string(word) == "4"
                                        ? ": a lattice has two axes, for a drawing, or three, for a mesh"
                                        : ": write the numbers of points along the axes, such as 4x4 or "
                                          "4x4x4"));
    CHECK(refusal("0x4") == "lattice:0x4: an axis has 2 points or more");
    CHECK(refusal("4x1") == "lattice:4x1: an axis has 2 points or more");
    CHECK(refusal("4x4x4x4") ==
          "lattice:4x4x4x4: a lattice has two axes, for a drawing, or three, for a mesh");
    CHECK(refusal("9999x9999") == "lattice:9999x9999: a lattice has at most 16,777,216 points");
    CHECK(refusal("1e300x1e300") == "lattice:1e300x1e300: a lattice has at most 16,777,216 points");
    for (const char* degree : {"9", "0", "4", "x", "", "2.5", "bern"})
        CHECK(refusal("4x4/" + std::string(degree)) ==
              "lattice:4x4/" + std::string(degree) +
                  ": the degree is 1, 2 or 3; for the highest, use /bernstein");
    CHECK(refusal("65x4/bernstein") ==
          "lattice:65x4/bernstein: Bernstein polynomials take at most 64 points along an axis");
    CHECK(refusal("4x4+-1") == "lattice:4x4+-1: +R is a number of at least 0");
    CHECK(refusal("4x4+inf") == "lattice:4x4+inf: not a number: \"inf\"");
    CHECK(refusal("4x4@") == "lattice:4x4@: not a number: \"\"");
    CHECK(refusal("4x4x4@30") == "lattice:4x4x4@30: @ANGLE is only for the box of a drawing");
    CHECK(refusal("4x4@30+1") == "lattice:4x4@30+1: not a number: \"30+1\"");
    CHECK(refusal("4x4/2/3") == "lattice:4x4/2/3: unexpected text: \"/3\"");

    const auto flat = lattice_about<2>(*parse_lattice_word("4x4x4"), {{0, 0}, {1, 1}}, 0, "f.svg");
    REQUIRE_FALSE(flat);
    CHECK(to_string(flat.error()) == "f.svg: a lattice about a drawing has two axes: lattice:4x4");
    const auto point = lattice_about<2>(*parse_lattice_word("4x4"), {{1, 1}, {1, 1}}, 0.1, "f.svg");
    REQUIRE_FALSE(point);
    CHECK(to_string(point.error()) == "f.svg: no lattice about it: the figure has no extent, or no area");
}

TEST_CASE("a lattice written and read is unchanged to the bit", "[examples][lattice][property]") {
    const int seed = GENERATE(range(0, 20));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const auto number = [&] { return double(random() >> 11) * 0x1p-50 - 4; };
    LatticeBox<3> lattice;
    for (std::size_t k = 0; k < 3; ++k) {
        lattice.axes[k] = {3 + random() % 4, 1 + random() % 2, {}};
        if (random() % 2 == 0) lattice.axes[k] = {4, 2, {0, 0, 0, 0.1 + 0.01 * number(), 1, 1, 1}};
        for (double& x : lattice.frame.columns[k].v) x = number();
    }
    lattice.frame.translation = {number(), number(), number()};
    lattice.falloff = std::fabs(number());
    const auto text = to_json(lattice);
    const auto read = parse_lattice<3>(text, "l.lattice.json");
    REQUIRE(read);
    CHECK(same(*read, lattice));
    CHECK_FALSE(parse_lattice<2>(text, "l.lattice.json"));
    for (std::size_t n = 0; n + 2 < text.size(); n += 1 + random() % 20) { // truncated anywhere
        CAPTURE(n);
        CHECK_FALSE(parse_lattice<3>(text.substr(0, n), "l"));
    }
}

TEST_CASE("a file that is not a lattice is refused with a reason", "[examples][lattice][faults]") {
    const std::string axes = R"("axes": [{"points": 4, "degree": 3}, {"points": 4, "degree": 3}])";
    const std::string box = R"("frame_columns": [[1, 0], [0, 1]], "origin": [0, 0])";
    const auto parse = [](const std::string& members) {
        return parse_lattice<2>(R"({"format": "lattice/1", )" + members + '}', "l");
    };
    const auto says = [&](const std::string& members) {
        const auto read = parse(members);
        INFO(members);
        REQUIRE_FALSE(read);
        return to_string(read.error());
    };
    CHECK(parse(axes + ", " + box));
    const std::string none =
        R"(l: is no lattice: "format": "lattice/1" and two or three "axes" are expected)";
    for (const std::string text :
         {"[]", "1", "{}", R"({"axes": []})", R"({"format": "lattice/2", "axes": [1, 2]})"}) {
        const auto read = parse_lattice<2>(text, "l");
        REQUIRE_FALSE(read);
        CHECK(to_string(read.error()) == none);
    }
    CHECK(says(box) == none);
    const std::string no_axis = R"( is no object of "points", "degree" and optional "knots")";
    for (const char* axis :
         {"7", R"({"points": 4})", R"({"points": -4, "degree": 3})", R"({"points": 4.5, "degree": 3})",
          R"({"points": 99999999999, "degree": 3})", R"({"points": 4, "degree": 3, "knots": 1})",
          R"({"points": 4, "degree": 3, "knots": ["0"]})"})
        CHECK(says(R"("axes": [{"points": 4, "degree": 3}, )" + std::string(axis) + "], " + box) ==
              "l: axis 1" + no_axis);
    const std::string no_box = R"(l: "frame_columns" and "origin" are not vectors with a number per axis)";
    for (const char* wrong : {R"("frame_columns": [[1, 0], [0, 1]])", R"("origin": [0, 0])",
                              R"("frame_columns": [[1, 0], [0]], "origin": [0, 0])",
                              R"("frame_columns": [[1, 0], [0, "1"]], "origin": [0, 0])",
                              R"("frame_columns": [[1, 0]], "origin": [0, 0])",
                              R"("frame_columns": [[1, 0], [0, 1]], "origin": [0, 0, 0])"})
        CHECK(says(axes + ", " + wrong) == no_box);
    CHECK(says(axes + ", " + box + R"(, "falloff": "1")") == R"(l: "falloff" is no number)");
    // Only the library refuses these:
    CHECK(says(axes + ", " + box + R"(, "falloff": -1)").find("falloff of a lattice") != std::string::npos);
    CHECK(says(axes + R"(, "frame_columns": [[1, 0], [2, 0]], "origin": [0, 0])").find("do not span") !=
          std::string::npos);
    CHECK(
        says(R"("axes": [{"points": 4, "degree": 3}, {"points": 1, "degree": 1}], )" + box).find("degree") !=
        std::string::npos);
}

TEST_CASE("a lattice in the plane is its rows and columns", "[examples][lattice]") {
    const auto cage = make_cage("l", lattice_of("3x4/2+0.5"));
    REQUIRE(cage.blocks.size() == 4 + 3);
    CHECK(cage.handles[0] == std::vector<std::size_t>{0, 1, 2});
    CHECK(cage.handles[3] == std::vector<std::size_t>{9, 10, 11});
    CHECK(cage.handles[4] == std::vector<std::size_t>{0, 3, 6, 9});
    CHECK(cage.handles[6] == std::vector<std::size_t>{2, 5, 8, 11});
    CHECK(cage.vertices.size() == 12 + 3); // and the fixed handles
    CHECK(cage.vertices[12] == cage.vertices[0]);
    CHECK(cage.vertices[13] == cage.vertices[2]);
    CHECK(cage.vertices[14] == cage.vertices[9]);

    auto moved = cage.places();
    moved[4] = moved[4] + Vec2{1, 2};
    const CageFile pose = moved_cage(cage, moved);
    const auto text = to_svg(pose, {0, 0, 100, 100});
    REQUIRE(text);
    const auto document = parse_svg(*text, "p.svg");
    REQUIRE(document);
    const auto lines = straight_lines(*document);
    REQUIRE(lines);
    CHECK(*lines == lines_of(pose));
    const auto read = make_lattice_pose("p.svg", *lines, cage);
    REQUIRE(read);
    CHECK(read->vertices == pose.vertices);
}

TEST_CASE("a point of a pose may be moved in its row, in its column, or in both", "[examples][lattice]") {
    const auto cage = make_cage("l", lattice_of("3x4"));
    const auto rest = lines_of(cage);
    const auto with = [&](double in_row, double in_column) { // of point 4, in row 1 and column 1
        auto lines = rest;
        lines[1][1].x += in_row;
        lines[4 + 1][1].x += in_column;
        return make_lattice_pose("p", lines, cage);
    };
    for (const auto& [row, column] :
         std::vector<std::pair<double, double>>{{2, 2}, {2, 0}, {0, 2}, {2, 1e-7}}) {
        CAPTURE(row, column);
        const auto pose = with(row, column);
        REQUIRE(pose);
        for (std::size_t i = 0; i < cage.vertices.size(); ++i)
            CHECK(std::fabs(pose->vertices[i].x - cage.vertices[i].x - (i == 4 ? 2 : 0)) <= 1e-6);
        CHECK(pose->blocks[1].points[1] == pose->blocks[4 + 1].points[1]);
    }
    const auto torn = with(2, 3);
    REQUIRE_FALSE(torn);
    CHECK(to_string(torn.error()) ==
          "p: point 4 of the lattice l is at (17, 11.6667) in its row and at (18, 11.6667) in column 1; move "
          "it in both, or in one");
    auto lines = rest;
    lines.pop_back();
    auto wrong = make_lattice_pose("p", lines, cage);
    REQUIRE_FALSE(wrong);
    CHECK(to_string(wrong.error()) == "p: holds 6 lines, and the lattice l has 4 rows and 3 columns");
    lines = rest;
    lines[5].pop_back();
    wrong = make_lattice_pose("p", lines, cage);
    REQUIRE_FALSE(wrong);
    CHECK(to_string(wrong.error()) == "p: line 6, column 1 of the lattice, has 3 points in place of 4");
}

TEST_CASE("a lattice in space is a closed mesh of its outer points", "[examples][lattice]") {
    const auto lattice = lattice_about<3>(*parse_lattice_word("3x4x5+0.1"), {{0, 0, 0}, {1, 2, 3}}, 0.1, "f");
    REQUIRE(lattice);
    const MeshFile mesh = lattice_mesh("l", *lattice);
    REQUIRE(mesh.lattice);
    CHECK(mesh.vertices.size() == 60 + 4);
    CHECK(mesh.faces.size() == 2 * (2 * 3 + 3 * 4 + 2 * 4));
    double volume = 0; // positive: the faces point outwards
    for (const auto& [a, b, c] : mesh.triangles)
        volume += dot(mesh.vertices[a], cross(mesh.vertices[b], mesh.vertices[c])) / 6;
    const auto& frame = lattice->frame;
    CHECK(std::fabs(volume - frame.columns[0][0] * frame.columns[1][1] * frame.columns[2][2]) <= 1e-9);
    const auto again = parse_obj(to_text(mesh, mesh.vertices), "p");
    REQUIRE(again);
    CHECK(pose_difference(mesh, *again).empty());
}

} // namespace lattice_file_tests
