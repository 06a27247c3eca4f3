#include "cli/landmarks.hpp"
#include "files/obj_file.hpp"
#include "files/point_table.hpp"
#include "files/welded_mesh.hpp"
#include "io/csv.hpp"

#include "catch.hpp"

#include <random>
#include <string>
#include <vector>

namespace wrap_mesh_tests {

using namespace cageform_support;

namespace {

const std::vector<Point3> source{{0, 0, 0}, {1, 2, 3}}, target{{4, 5, 6}, {7, 8, 9}, {-1, 0, 1}};

std::string refusal(const std::string& rows) {
    Landmarks landmarks;
    return parse_landmarks(rows, "pairs.csv", {source, target}, landmarks);
}

PointTable parsed(const std::string& text) {
    auto table = parse_point_table(text, "joints.csv");
    INFO(text);
    if (!table) FAIL(to_string(table.error()));
    return std::move(*table);
}

std::string refusal_of_points(const std::string& text) {
    const auto table = parse_point_table(text, "joints.csv");
    INFO(text);
    REQUIRE_FALSE(table);
    return to_string(table.error());
}

bool contains(const std::string& text, const std::string& part) {
    INFO(text);
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("a landmark is a place or vertex of the source and one of the target", "[wrap_mesh]") {
    Landmarks landmarks;
    for (const char* word : {"1:-1,5,0.5", "1:=-1,5,0.5", "1,2,3:2", " 0 : +1 , 2 , 3 "})
        CHECK(parse_landmark(word, {source, target}, landmarks).empty());
    REQUIRE(landmarks.marks.size() == 4);
    CHECK(landmarks.names[2] == "--landmark \"1,2,3:2\"");
    for (const std::size_t n : {0u, 1u}) {
        CHECK(landmarks.marks[n].from == source[1]);
        CHECK(landmarks.marks[n].to == Point3{-1, 5, 0.5}); // a sign makes no displacement
    }
    CHECK(landmarks.marks[2].from == Point3{1, 2, 3});
    CHECK(landmarks.marks[2].to == target[2]);
    CHECK(landmarks.marks[3].to == Point3{1, 2, 3});
    for (const auto& [word, why] : std::vector<std::array<std::string, 2>>{
             {"1", "write SOURCE:TARGET"},
             {"1,2:0", "a point is x,y,z or the number of a vertex"},
             {"2:0", "source: there is no vertex 2: the figure has 2, counted from 0"},
             {"0:3", "target: there is no vertex 3: the figure has 3, counted from 0"},
             {"-1:0", "source: "},
             {"0:1,nan,2", "target: \"nan\" is not a finite number"}}) {
        CHECK(contains(parse_landmark(word, {source, target}, landmarks), why));
    }
    CHECK(landmarks.marks.size() == 4);
}

TEST_CASE("a file of landmarks has one per line, with an optional weight", "[wrap_mesh]") {
    Landmarks landmarks;
    const std::string rows = "vertex,x,y,z\n# knees\n1,4,5,6\n\n0,2\n1,2,3,4,5,6,0.5\n1,1,2\r\n0,7,8,9,3,,\n";
    CHECK(parse_landmarks(rows, "pairs.csv", {source, target}, landmarks).empty());
    REQUIRE(landmarks.marks.size() == 5);
    CHECK(landmarks.marks[0].to == Point3{4, 5, 6});
    CHECK(landmarks.marks[1].to == target[2]);
    CHECK(landmarks.marks[2].from == Point3{1, 2, 3});
    CHECK(landmarks.marks[2].weight == 0.5);
    CHECK(landmarks.marks[3].to == target[1]);
    CHECK(landmarks.marks[3].weight == 2);
    CHECK(landmarks.marks[4].weight == 3);
    CHECK(landmarks.names[4] == "pairs.csv:8");

    CHECK(contains(refusal("1,4,5,6\n9,4,5,6\n"), "pairs.csv:2: source: there is no vertex 9"));
    CHECK(contains(refusal("1,x,5,6\n"), "pairs.csv:1: target: not a number: \"x\""));
    CHECK(contains(refusal("1\n"), "pairs.csv:1: 1 column, but a landmark has"));
    CHECK(contains(refusal("1,2,3,4,5,6,7,8\n"), "pairs.csv:1: 8 columns"));
    CHECK(contains(refusal("1;4;5;6\n"), "the line is separated by semicolons"));
    CHECK(contains(refusal("1,4,5,6,0\n"), "the weight \"0\" is not positive"));
    CHECK(contains(refusal("x,y\n"), "pairs.csv: holds no landmarks"));
}

TEST_CASE("two files of points are landmarks, if their names are the same", "[wrap_mesh]") {
    Landmarks landmarks;
    const auto from = parsed("name,x,y,z\nknee,1,2,3\nheel,4,5,6\n"), to = parsed("knee,7,8,9\nheel, 0,0,1");
    CHECK(add_landmarks(from, to, landmarks).empty());
    REQUIRE(landmarks.marks.size() == 2);
    CHECK(landmarks.marks[1].from == Point3{4, 5, 6});
    CHECK(landmarks.marks[1].to == Point3{0, 0, 1});
    CHECK(add_landmarks(parsed("1,2,3\n4,5,6\n"), parsed("7,8,9\n0,0,1\n"), landmarks).empty());
    CHECK(landmarks.marks.size() == 4);
    const std::string bone = ",,0,1,0,0,2,0,0,0,0\n", longer = ",,0,1,0,0,3,0,0,0,0\n";
    CHECK(add_landmarks(parsed("hip" + bone), parsed("hip" + longer), landmarks).empty());
    CHECK(landmarks.marks[5].to == Point3{0, 3, 0});
    CHECK(contains(add_landmarks(from, parsed("knee,7,8,9\ntoe,0,0,1\n"), landmarks),
                   "joints.csv, point 2 is \"heel\", and in joints.csv \"toe\""));
    CHECK(contains(add_landmarks(from, parsed("knee,7,8,9\n"), landmarks),
                   "joints.csv has 1 point, joints.csv has 2: landmarks are pairs"));
}

TEST_CASE("points of a CSV file move, and everything else stays", "[wrap_mesh]") {
    const std::string text =
        "\xef\xbb\xbf# joints\r\nname,radius,X,Y,Z,note\r\nhip, 0.1 ,1.50,+2,3e0,\"a, b\"\r\n"
        "\r\nknee,9,4,5,6\r\n";
    const PointTable table = parsed(text);
    REQUIRE(table.points == std::vector<Point3>{{1.5, 2, 3}, {4, 5, 6}});
    CHECK(to_text(table, table.points) == text);
    CHECK(to_text(table, std::vector<Point3>{{1.5, 2, 0.25}, {4, -7, 6}}) ==
          "\xef\xbb\xbf# joints\r\nname,radius,X,Y,Z,note\r\nhip, 0.1 ,1.50,+2,0.25,\"a, b\"\r\n"
          "\r\nknee,9,4,-7,6\r\n");

    CHECK(parsed("1,2,3\n4,5,6").points.size() == 2);
    CHECK(parsed("hand,left,1,2,3,9\n").points[0] == Point3{1, 2, 3});
    CHECK(parsed("id,x,y,z\n7,1,2,3\n").points[0] == Point3{1, 2, 3});
    CHECK(contains(refusal_of_points("x,y\n"), "joints.csv: holds no points"));
    CHECK(contains(refusal_of_points("1,2,3\nhip,1,2\n"), "joints.csv:2: a point has three numbers"));
    CHECK(contains(refusal_of_points("1,inf,3\n"), "joints.csv:1: column 2: \"inf\" is not a finite number"));
    CHECK(contains(refusal_of_points("1,2,3\n1 2 3\n"), "joints.csv:2: a point has three numbers"));
}

TEST_CASE("heads and tails of bones move", "[wrap_mesh]") {
    const std::string text = "name,parent,head x,y,z,tail x,y,z,turn about x,y,z (degrees)\n"
                             "hips,,0,1,0,0,1.2,0,0,0,0\nleg,hips,0.1,1,0,0.1,0.5,0,0,0,30\n";
    const PointTable table = parsed(text);
    REQUIRE(table.points.size() == 4);
    REQUIRE(table.segments == std::vector<std::array<std::size_t, 2>>{{0, 1}, {2, 3}});
    CHECK(table.points[3] == Point3{0.1, 0.5, 0});
    auto moved = table.points;
    for (Point3& p : moved) p = p + Point3{0, 0, 2};
    CHECK(to_text(table, moved) == "name,parent,head x,y,z,tail x,y,z,turn about x,y,z (degrees)\n"
                                   "hips,,0,1,2,0,1.2,2,0,0,0\nleg,hips,0.1,1,2,0.1,0.5,2,0,0,30\n");
}

TEST_CASE("random points keep their digits, or are restored by the new ones", "[wrap_mesh]") {
    const unsigned seed = std::random_device()();
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> coordinate(-1e3, 1e3);
    std::string text;
    std::vector<Point3> expected;
    for (int n = 0; n < 50; ++n) {
        Point3 p;
        for (double& x : p.v) x = coordinate(random);
        text += "bone_" + std::to_string(n);
        for (const double x : p.v) text += ',' + detail::digits_of(x);
        text += ",end\n";
        expected.push_back(p);
    }
    const PointTable table = parsed(text);
    REQUIRE(table.points == expected);
    for (Point3& p : expected) {
        for (double& x : p.v) x = random() % 2 == 0 ? x : coordinate(random);
    }
    const std::string written = to_text(table, expected);
    CHECK(parsed(written).points == expected);
    CHECK(to_text(parsed(written), table.points) == text);
}

TEST_CASE("copies of a vertex become one place, and unused vertices none", "[wrap_mesh]") {
    const auto file = parse_obj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 2 3 4\n"
                                "f 5 6 7\nf 3 5 6\n",
                                "file.obj");
    REQUIRE(file);
    const WeldedMesh mesh = welded_surface(*file);
    CHECK(mesh.places == std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
    CHECK(mesh.first == std::vector<std::uint32_t>{1, 2, 3, 5});
    CHECK(mesh.place_of == std::vector<std::uint32_t>{WeldedMesh::no_place, 0, 1, 2, 1, 3, 2});
    CHECK(mesh.triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {1, 3, 2}});
    CHECK(welded_mesh(*file).places.size() == 5);
}

} // namespace wrap_mesh_tests
