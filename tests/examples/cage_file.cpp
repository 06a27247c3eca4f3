#include "files/cage_file.hpp"
#include "cli/pins.hpp"
#include "files/bind_report.hpp"
#include "files/clip_file.hpp"
#include "files/marker_file.hpp"
#include "files/mesh_file.hpp"
#include "files/pose_rows.hpp"

#include "catch.hpp"
#include "support/temporary_file.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace cage_file_tests {

using namespace cageform_support;
using cageform::CageFaultKind;
using cageform_tests::TemporaryFile;

namespace {

const std::string square = "0,0\n4,0\n4,4\n0,4\n";

Expected<std::vector<CageBlock>> parse(const std::string& text) {
    return parse_cage_csv(text, "c.csv");
}

CageFile cage_of(const std::string& text, const std::string& name = "c.csv") {
    auto blocks = parse(text);
    INFO(text);
    if (!blocks) FAIL(to_string(blocks.error()));
    return make_cage(name, std::move(*blocks));
}

std::string refusal(const std::string& text) {
    const auto blocks = parse(text);
    INFO(text);
    REQUIRE_FALSE(blocks);
    return to_string(blocks.error());
}

std::string pose_refusal(const std::string& cage, const std::string& pose) {
    const auto made = make_pose(cage_of(pose, "p.csv"), cage_of(cage));
    INFO(pose);
    REQUIRE_FALSE(made);
    return to_string(made.error());
}

} // namespace

TEST_CASE("the blocks of a cage file are loops, chains and points", "[examples][cage]") {
    const auto blocks =
        parse("\xef\xbb\xbf"
              "x,y\r\n# a comment\r\n" +
              square +
              "\n\n# the spine\n# chain\n1, 2\n# in between\n+2,2\n\t\n#point 0.5 \n3,3\n\n1,1\n2,1\n1,1.5");
    REQUIRE(blocks);
    REQUIRE(blocks->size() == 4);
    const auto expect = [&](std::size_t b, CageBlock::Kind kind, const std::vector<Point2>& points) {
        CAPTURE(b);
        CHECK((*blocks)[b].kind == kind);
        CHECK((*blocks)[b].points == points);
    };
    expect(0, CageBlock::Kind::loop, {{0, 0}, {4, 0}, {4, 4}, {0, 4}});
    expect(1, CageBlock::Kind::chain, {{1, 2}, {2, 2}});
    expect(2, CageBlock::Kind::point, {{3, 3}});
    expect(3, CageBlock::Kind::loop, {{1, 1}, {2, 1}, {1, 1.5}});
    CHECK((*blocks)[2].radius == 0.5);

    // A line that only resembles the first line of a block is a comment.
    CHECK(parse("# chains\n# points 3\n# Chain\n" + square)->size() == 1);
}

TEST_CASE("a fault in a block is reported with file and line", "[examples][cage]") {
    CHECK(refusal(square + "\n# point\n1,1\n") == "c.csv:6: the radius is missing: \"# point RADIUS\"");
    CHECK(refusal(square + "\n# point wide\n1,1\n") == "c.csv:6: not a number: \"wide\"");
    CHECK(refusal(square + "\n# point 1 2\n1,1\n") == "c.csv:6: not a number: \"1 2\"");
    CHECK(refusal(square + "\n# point 1e999\n1,1\n") == "c.csv:6: \"1e999\" is not a finite number");
    CHECK(refusal(square + "\n# point 1\n1,1\n2,2\n") == "c.csv:6: more than one point follows");
    CHECK(refusal(square + "\n# point 1\n\n1,1\n") == "c.csv:6: no points follow");
    CHECK(refusal(square + "\n# chain\n1,1\n\n2,2\n") == "c.csv:6: a chain has two points or more");
    CHECK(refusal(square + "\n# chain\n") == "c.csv:6: no points follow");
    CHECK(refusal(square + "\n# chain of bones\n1,1\n2,2\n") ==
          "c.csv:6: \"# chain\" must be alone on its line");
    CHECK(refusal(square + "# chain\n1,1\n2,2\n") == "c.csv:5: an empty line is missing before # chain");
    CHECK(refusal(square + "\n# chain\n# point 1\n1,1\n") ==
          "c.csv:7: an empty line is missing before # point 1");
    CHECK(refusal(square + "\n# chain\n1,1\n2\n") ==
          "c.csv:8: 1 column, but a point in the plane has two: x,y");
    CHECK(refusal("0,0,0\n") == "c.csv:1: 3 columns, but a point in the plane has two: x,y");
    CHECK(refusal("0,\n") == "c.csv:1: not a number: \"\"");
    CHECK(refusal("# chain\n1,1\n2,2\n") == "c.csv: holds no loop");
    CHECK(refusal("# nothing\n\n") == "c.csv: holds no points");
}

TEST_CASE("handles are the loops' vertices, then the new ones of chains and points", "[examples][cage]") {
    const auto cage =
        cage_of("# chain\n4,4\n3,3\n2,3\n\n" + square + "\n# point 0.25\n1,1\n\n# chain\n2,3\n2,2\n");
    CHECK(cage.handles == std::vector<std::vector<std::size_t>>{{2, 4, 5}, {0, 1, 2, 3}, {6}, {5, 7}});
    CHECK(cage.vertices ==
          std::vector<Point2>{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {3, 3}, {2, 3}, {1, 1}, {2, 2}});
    const auto complex = cage.complex<double>();
    REQUIRE(complex.size() == cage.vertices.size());
    for (std::size_t i = 0; i < complex.size(); ++i)
        CHECK((Point2{complex[i][0], complex[i][1]} == cage.vertices[i]));
    CHECK(complex.cells().facets.size() == 3);
    CHECK(complex.cells().bones.size() == 1);
    std::vector<std::array<std::size_t, 2>> edges;
    cage.for_each_edge([&](std::size_t i, std::size_t j) { edges.push_back({i, j}); });
    CHECK(edges == std::vector<std::array<std::size_t, 2>>{
                       {2, 4}, {4, 5}, {3, 0}, {0, 1}, {1, 2}, {2, 3}, {6, 6}, {5, 7}});

    // Coincident vertices of loops are kept: the library reports them.
    CHECK(cage_of("0,0\n4,0\n4,0\n0,4\n").vertices.size() == 4);
    const auto facets = [](const auto& shape) { return cageform::interior_cells(shape).facets.size(); };
    CHECK(cage.visit<float>(facets) == 3);
    CHECK(cage_of(square).visit<float>(facets) == 0);
}

TEST_CASE("a pose has the blocks of its cage", "[examples][cage]") {
    const std::string cells = "\n# chain\n4,4\n2,2\n\n# point 0.25\n1,2\n";
    const auto cage = cage_of(square + cells);
    const auto pose =
        make_pose(cage_of("0,0\n4,0\n5,5\n0,4\n\n# chain\n5,5\n2,3\n\n# point 0.25\n0,4\n"), cage);
    REQUIRE(pose);
    CHECK(pose->vertices == std::vector<Point2>{{0, 0}, {4, 0}, {5, 5}, {0, 4}, {2, 3}, {0, 4}});
    CHECK(pose->handles == cage.handles);

    CHECK(pose_refusal(square, "0,0\n4,0\n4,4\n") ==
          "p.csv: the pose has a loop of 3 vertices, the cage c.csv a loop of 4 vertices");
    CHECK(pose_refusal(square + cells, square) == "p.csv: the pose has 1 block, the cage c.csv 3 blocks");
    CHECK(pose_refusal(square + cells, square + "\n# chain\n4,4\n2,2\n1,1\n\n# point 0.25\n1,2\n") ==
          "p.csv: block 2: the pose has a chain of 3 points, the cage c.csv a chain of 2 points");
    CHECK(pose_refusal(square + cells, square + "\n# chain\n4,4\n2,2\n\n# point 0.5\n1,2\n") ==
          "p.csv: block 3: the pose has a point of radius 0.5, the cage c.csv a point of radius 0.25");
    CHECK(pose_refusal(square + cells, square + "\n# chain\n5,5\n2,2\n\n# point 0.25\n1,2\n") ==
          "p.csv: vertex 2 of the cage c.csv is at (4, 4) and, in block 2, at (5, 5)");
}

TEST_CASE("points are read with the columns of the cage", "[examples][cage]") {
    std::array<double, 3> p{};
    CHECK(detail::parse_point<3>("1, +2 ,-3e1", p).empty());
    CHECK(p == std::array<double, 3>{1, 2, -30});
    CHECK(detail::parse_point<3>("1,2", p) == "2 columns, but a point in space has three: x,y,z");
    CHECK(detail::parse_point<3>("1,2,", p) == "not a number: \"\"");
}

TEST_CASE("lines are split as by std::getline", "[examples][csv][property]") {
    const auto seed = GENERATE(range(0, 50));
    CAPTURE(seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    std::string text;
    for (auto n = random() % 20; n > 0; --n) text += "a\n\r\n"[random() % 4];
    std::istringstream stream(text);
    std::string_view rest = text, line;
    for (std::string expected; std::getline(stream, expected);) {
        REQUIRE(take_line(rest, line));
        CHECK(line == expected);
    }
    CHECK_FALSE(take_line(rest, line));
}

TEST_CASE("batches of points do not depend on the sizes of the reads", "[examples][csv][property]") {
    const auto seed = GENERATE(range(0, 6));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::vector<std::array<double, 2>> points(1 + random() % 9000);
    std::string text = seed % 2 == 0 ? "x,y\r\n" : "";
    for (auto& [x, y] : points) {
        x = double(random() % 100000) / 8;
        y = -double(random() % 1000000);
        std::ostringstream row;
        row << std::setprecision(17) << x << ", " << y;
        if (random() % 500 == 0) text += "# " + std::string(random() % 70000, '-') + '\n';
        text += row.str() + (random() % 2 == 0 ? "\n" : " \r\n\n");
    }
    while (seed % 3 == 0 && text.back() < ' ') text.pop_back(); // no line break at the end
    const TemporaryFile file(text, "points.csv");
    const auto whole = read_file(file.path);
    PointReader<2> reader(file.path);
    std::vector<std::array<double, 2>> batch, all;
    while (reader.read(batch, 1 + random() % 4000)) {
        CHECK(reader.fraction() <= 1);
        all.insert(all.end(), batch.begin(), batch.end());
    }
    CHECK(reader.error().empty());
    CHECK(all == points);
    REQUIRE(whole);
    CHECK(*whole == text);
}

using Random = std::mt19937_64;

std::string number_of(Random& random) {
    return std::to_string(int(random() % 2000) - 1000) + '.' + std::to_string(1 + random() % 99);
}

std::string row_of(std::size_t count, Random& random) {
    std::string row = number_of(random);
    while (--count > 0) row += ',' + number_of(random);
    return row + '\n';
}

/// A kind of CSV file: an example, a matching header, and its reader, whose result is text.
struct Kind {
    std::string header, text;
    Expected<std::string> (*read)(const std::string& path);
};

template <std::size_t D>
Expected<std::string> points_in(const std::string& path) {
    std::ostringstream text;
    PointReader<D> reader(path);
    for (std::vector<std::array<double, D>> next; reader.read(next, 1);) {
        for (const double x : next[0]) text << x << ' ';
    }
    if (!reader.error().empty()) return FileError{reader.error()};
    return text.str();
}

std::vector<Kind> kinds(Random& random) {
    std::string points, poses, clip, pins, keys;
    for (int n = 0; n < 4; ++n) {
        points += row_of(2, random);
        poses += row_of(12, random);
        clip += "pose," + std::to_string(n) + (n % 2 == 0 ? ",ease\n" : "\n");
        for (int k = 0; k < 4; ++k) clip += row_of(3, random);
        pins += row_of(std::array<std::size_t, 3>{4, 5, 4}[random() % 3], random);
        keys += std::to_string(n / 2.0) + ',' + row_of(3, random);
        keys.insert(keys.size() - 1, n % 2 == 0 ? ",ease" : ",linear");
    }
    std::string markers;
    for (int n = 0; n < 4; ++n) markers += std::to_string(n) + ".25," + row_of(4, random);
    return {
        {"x,y\n", points, points_in<2>},
        {"u,v\n", points,
         [](const std::string& path) -> Expected<std::string> {
             const auto blocks = read_cage_csv(path);
             if (!blocks) return blocks.error();
             return blocks->size() == 1 ? to_csv(make_cage("c.csv", *blocks)) : "many blocks";
         }},
        {"v0 x,v0 y,\"v0, z\",and so on\n", poses,
         [](const std::string& path) -> Expected<std::string> {
             std::ostringstream text;
             PoseRows<3> rows(path, std::vector<cageform::Vec<double, 3>>(4), 24);
             for (PoseRow row; rows.next(row);) {
                 const auto pose = rows.pose_of(row);
                 if (!pose) return pose.error();
                 for (const auto& p : *pose) text << p[0] << ' ' << p[1] << ' ' << p[2] << ' ';
             }
             if (!rows.error().empty()) return FileError{rows.error()};
             return text.str();
         }},
        {"word,time,way\n", "length,4.5\n" + clip,
         [](const std::string& path) -> Expected<std::string> {
             const auto read = load_pose_clip(path, 4);
             return read ? Expected<std::string>(pose_clip_text(*read, "")) : read.error();
         }},
        {"word,number\n", "length,1.5\ncontrol,arm\nvertices,0:0.5,3\npivot,1.5,2.5\n" + keys,
         [](const std::string& path) -> Expected<std::string> {
             const auto read = load_clip(path, 4);
             return read ? Expected<std::string>(clip_text(*read, "")) : read.error();
         }},
        {"x,y,to x,to y\n", pins,
         [](const std::string& path) -> Expected<std::string> {
             const auto read = load_pins<2>(path, {});
             if (!read) return read.error();
             std::ostringstream text;
             for (const auto& pin : *read)
                 text << pin.place[0] << ' ' << pin.target[1] << ' ' << (pin.turn ? (*pin.turn)[0] : 0)
                      << '\n';
             return text.str();
         }},
        {"frame,marker 1 x,marker 1 y,marker 2 x,marker 2 y\n", markers,
         [](const std::string& path) -> Expected<std::string> {
             const auto read = load_markers(path);
             return read ? Expected<std::string>(clip_text(*read, "")) : read.error();
         }},
    };
}

/// The text in the format of spreadsheets.
std::string decorated(const std::string& text, Random& random) {
    std::string result = random() % 2 == 0 ? "\xef\xbb\xbf" : "";
    const bool has_quotes = random() % 2 == 0, has_more = random() % 2 == 0;
    const std::string end = std::string(has_more ? ",, ," : "") + (random() % 2 == 0 ? "\r\n" : "\n");
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        for (const std::string_view cell : detail::cells_of(line)) {
            const bool is_quoted = has_quotes || cell.find(',') != cell.npos;
            result += (is_quoted ? " \"" + std::string(cell) + "\"" : std::string(cell)) + ',';
        }
        result.pop_back();
        result += end;
    }
    for (std::size_t n = random() % 3; n > 0; --n) result += end;
    return result;
}

TEST_CASE("CSV files of spreadsheets are read, or refused with a reason", "[examples][csv][property]") {
    const auto seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const TemporaryFile file({}, "rows.csv");
    const std::string& path = file.path;
    const auto read = [&](const Kind& kind, const std::string& text) {
        std::ofstream(path, std::ios::binary) << text;
        return kind.read(path);
    };
    for (const Kind& kind : kinds(random)) {
        const auto plain = read(kind, kind.text);
        if (!plain) FAIL(to_string(plain.error()));
        REQUIRE(plain->size() > 20);
        for (const std::string& head : {std::string(), kind.header}) {
            const std::string text = decorated(head + kind.text, random);
            INFO(text);
            const auto result = read(kind, text);
            if (!result) FAIL(to_string(result.error()));
            CHECK(*result == *plain);
        }
        const auto refused = [&](const std::string& text, const std::string& why) {
            INFO(text);
            const auto result = read(kind, text);
            REQUIRE_FALSE(result);
            CHECK(to_string(result.error()).find(path) == 0);
            INFO(to_string(result.error()) << "\ndoes not say " << why);
            CHECK(to_string(result.error()).find(why) != std::string::npos);
        };
        std::string commas = kind.text;
        std::replace(commas.begin(), commas.end(), ',', ';');
        refused(commas, "separated by semicolons, but only commas are read");
        std::replace(commas.begin(), commas.end(), '.', ',');
        refused(commas, "separated by semicolons and has decimal commas");
        std::replace(commas.begin(), commas.end(), ';', '\t');
        refused(commas, "separated by tabs and has decimal commas");
        std::string quoted = "\"";
        for (const char c : kind.text)
            quoted += c == ',' ? "\",\"" : c == '\n' ? "\"\n\"" : c == '.' ? "," : std::string(1, c);
        refused(quoted.substr(0, quoted.size() - 1), "the line has decimal commas");
        std::string wide = "\xff\xfe";
        for (const char c : kind.text) (wide += c) += '\0';
        refused(wide, "is UTF-16 text");
    }
    std::ofstream(path, std::ios::binary) << "\xfe\xff" << std::string("\0v\0 \0001", 6);
    const auto mesh = load_mesh(path);
    REQUIRE_FALSE(mesh);
    CHECK(to_string(mesh.error()) == path + ": is UTF-16 text, but only UTF-8 is read: save it as UTF-8");
}

TEST_CASE("a first row with a number is not a header", "[examples][csv]") {
    for (const char* line : {"x,1", "1.5x,2", "x;2", "nan,y", "-,y", "\"1.5\",y", "?", "control,arm"})
        CHECK_FALSE(detail::is_header(line));
    for (const char* line : {"x,y", "\"a b\",", "X;Y", "größe\thöhe", "name,parent,x1"})
        CHECK(detail::is_header(line));
}

TEST_CASE("files of a sequence are sorted by their numbers, with signs", "[examples][property]") {
    const auto seed = GENERATE(range(0, 20));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    const bool has_signs = seed % 2 == 0;
    const std::string before = has_signs ? "n" : std::array{"frame-", "frame_", "2-a-", ""}[random() % 4];
    const int first = has_signs ? -1 - int(random() % 200) : int(random() % 20);
    std::vector<std::string> names;
    for (int n = first; n < first + 20 + int(random() % 300) || n < 2; ++n)
        names.push_back(before + std::to_string(n) + ".obj");
    auto sorted = names;
    std::sort(sorted.begin(), sorted.end());
    const auto notes = order_by_numbers(sorted);
    CHECK(sorted == names);
    CHECK(notes.size() == (std::is_sorted(names.begin(), names.end()) ? 0 : 1));
    sorted.erase(sorted.begin() + 3);
    CHECK(order_by_numbers(sorted).size() == 1);
}

TEST_CASE("an unreadable file is an error, not an empty file", "[examples][csv]") {
    for (const std::string path : {".", "no/such/file", "/proc/self/mem"}) {
        if (path == "/proc/self/mem" && !std::filesystem::exists(path)) continue; // not Linux
        CAPTURE(path);
        const std::string why = path == "."      ? ": is a folder"
                                : path[0] == 'n' ? ": no such file"
                                                 : ": cannot be read: ";
        const auto says = [&](const std::string& message) { return message.rfind(path + why, 0) == 0; };
        CHECK(says(PointReader<2>(path).error()));
        const auto text = read_file(path);
        const auto cage = read_cage_csv(path);
        const auto clip = load_clip(path, 4);
        const auto poses = load_pose_clip(path, 4);
        REQUIRE_FALSE((text || cage || clip || poses));
        for (const FileError& error : {text.error(), cage.error(), clip.error(), poses.error()})
            CHECK(says(to_string(error)));
    }
}

TEST_CASE("the first faults are listed, the others counted", "[examples][cage]") {
    cageform::BindReport report;
    for (int i = 0; i < 5000; ++i) report.cage.add(CageFaultKind::edges_cross, 3, 7);
    report.status = report.cage.status;
    report.cage.add(CageFaultKind::collinear_vertex, 3, 7); // no fault
    for (const std::string& text : {describe_faults("c.csv", report), describe(report)}) {
        CHECK(text.size() < 1000);
        CHECK(text.find("edges cross or touch (3, 7)") != std::string::npos);
    }
    CHECK(describe_faults("c.csv", report).ends_with("\n  and 4990 more"));
    CHECK(describe(report).find("\n  cage: and 4991 more\n") != std::string::npos);
}

TEST_CASE("descriptions of faults contain only the numbers that apply", "[examples][cage]") {
    const auto text = [](CageFaultKind kind) { return describe_fault({kind, 3, 7}); };
    CHECK(text(CageFaultKind::edges_cross) == "edges cross or touch (3, 7)");
    CHECK(text(CageFaultKind::gap_closed) == "open edge, closed (warning) (3, 7)");
    CHECK(text(CageFaultKind::radius_not_positive) == "radius not positive (3)");
    CHECK(text(CageFaultKind::interior_cell_outside) == "interior cell outside (3)");
    CHECK(text(CageFaultKind::interior_cells_not_supported) == "interior cells not supported (3)");
    CHECK(text(CageFaultKind::face_without_area) == "face without area (3)");
    CHECK(text(CageFaultKind::vertex_unused) == "unused vertex (warning) (3)");
    CHECK(text(CageFaultKind::degenerate_simplex) == "simplex without volume");
    CHECK(text(CageFaultKind::no_volume) == "no volume");
}

} // namespace cage_file_tests
