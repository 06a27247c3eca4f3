#include "files/pose_rows.hpp"
#include "cli/row_range.hpp"
#include "files/obj_file.hpp"
#include "files/posed_file.hpp"
#include "io/csv.hpp"

#include "catch.hpp"
#include "support/effort.hpp"
#include "support/temporary_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace pose_rows_tests {

using namespace cageform_support;
using cageform::Vec;
using cageform_tests::TemporaryFile;

namespace {

/// Any finite number.
template <class T>
T any_number(std::mt19937& random) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    for (;;) {
        const T number = std::bit_cast<T>(Bits(std::uint64_t{random()} << 32 | random()));
        if (std::isfinite(number)) return number;
    }
}
template <class T, std::size_t D>
std::vector<Vec<T, D>> any_points(std::size_t count, std::mt19937& random) {
    std::vector<Vec<T, D>> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k) p[k] = any_number<T>(random);
    }
    return points;
}

template <std::size_t D>
std::string refusal(const std::string& text, std::size_t vertices) {
    const TemporaryFile file(text, "rows.csv");
    PoseRows<D> rows(file.path, std::vector<Vec<double, D>>(vertices), 10);
    PoseRow row;
    std::string why;
    while (why.empty() && rows.next(row)) {
        const auto pose = rows.pose_of(row);
        if (!pose) why = to_string(pose.error());
    }
    if (why.empty()) why = rows.error();
    const std::size_t at = why.find(file.path);
    return at == why.npos ? why : why.replace(at, file.path.size(), "file");
}

/// A table of random poses, with everything allowed between rows.
template <std::size_t D>
void check_table(std::mt19937& random) {
    const std::size_t vertices = 1 + random() % 40, count = 1 + random() % 60;
    std::vector<std::vector<Vec<double, D>>> poses;
    const std::string end = random() % 2 == 0 ? "\n" : "\r\n";
    std::string text = random() % 2 == 0 ? "\xef\xbb\xbfx0,y0" + end : "# poses" + end;
    for (std::size_t r = 0; r < count; ++r) {
        poses.push_back(any_points<double, D>(vertices, random));
        if (random() % 4 == 0) text += random() % 2 == 0 ? end : " # a comment, 1,2" + end;
        for (std::size_t n = 0; n < D * vertices; ++n)
            text += (n > 0 ? random() % 3 == 0 ? " , " : "," : "") +
                    detail::digits_of(poses.back()[n / D][n % D]);
        if (r + 1 < count || random() % 2 == 0) text += end;
    }
    const TemporaryFile file(text, "rows.csv");
    const std::vector<Vec<double, D>> rest(vertices);
    for (int part = 0; part < 4; ++part) {
        const std::size_t first = random() % (count + 2), most = 1 + random() % count;
        PoseRows<D> rows(file.path, rest, 30);
        REQUIRE(rows.error().empty());
        rows.skip(first);
        PoseRow row;
        std::size_t done = 0;
        while (done < most && rows.next(row)) {
            CHECK(row.row == first + done);
            const auto pose = rows.pose_of(row);
            REQUIRE(pose);
            CHECK(std::memcmp(pose->data(), poses[row.row].data(), vertices * sizeof(Vec<double, D>)) == 0);
            ++done;
        }
        CHECK(rows.error().empty());
        CHECK(done == std::min(most, count - std::min(first, count)));
        CHECK(rows.row() == std::min(first, count) + done);
    }
}

template <class X>
X number_at(std::string_view bytes, std::size_t offset) {
    X value;
    REQUIRE(offset + sizeof(X) <= bytes.size());
    std::memcpy(&value, bytes.data() + offset, sizeof(X));
    return value;
}

/// Returns the text after `label`.
std::string_view after(std::string_view text, std::string_view what) {
    const std::size_t at = text.find(what);
    INFO(what);
    REQUIRE(at != text.npos);
    return text.substr(at + what.size());
}

/// Returns the next number of a text, exact to the bit.
template <class T>
T take_number(std::string_view& text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\n' || text.front() == 'v'))
        text.remove_prefix(1);
    T number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    REQUIRE(error == std::errc{});
    text.remove_prefix(std::size_t(end - text.data()));
    return number;
}

template <class T, std::size_t D>
void check_formats(std::mt19937& random) {
    const auto points = any_points<T, D>(random() % 50, random);
    std::vector<std::array<std::uint32_t, 3>> triangles(points.empty() ? 0 : random() % 9);
    for (auto& triangle : triangles) {
        for (auto& corner : triangle) corner = std::uint32_t(random() % points.size());
    }
    const auto contents = [&](PosedFormat format) {
        return *PosedFile(format, D, sizeof(T), points.size(), triangles)
                    .contents(std::span<const Vec<T, D>>(points));
    };
    const auto same = [](T a, T b) { return std::memcmp(&a, &b, sizeof(T)) == 0; };

    const std::string npy = contents(PosedFormat::npy);
    REQUIRE(npy.starts_with(std::string_view("\x93NUMPY\x01\x00", 8)));
    const std::size_t head = 10 + number_at<std::uint16_t>(npy, 8);
    CHECK(head % 64 == 0);
    CHECK(npy[head - 1] == '\n');
    const std::string shape = "(" + std::to_string(points.size()) + ", " + std::to_string(D) + ")";
    CHECK(npy.find("'shape': " + shape + ", }") < head);
    CHECK(npy.find(sizeof(T) == 4 ? "'descr': '<f4'" : "'descr': '<f8'") < head);
    REQUIRE(npy.size() == head + points.size() * D * sizeof(T));
    for (std::size_t n = 0; n < D * points.size(); ++n)
        CHECK(same(number_at<T>(npy, head + n * sizeof(T)), points[n / D][n % D]));

    const std::string ply = contents(PosedFormat::ply), as_text = contents(PosedFormat::ply_text),
                      obj = contents(PosedFormat::obj);
    CHECK(ply.find(sizeof(T) == 4 ? "property float z\n" : "property double z\n") != ply.npos);
    CHECK((ply.find("element face") != ply.npos) == !triangles.empty());
    const std::string_view body = after(ply, "end_header\n");
    std::string_view words = after(as_text, "end_header\n"), lines = obj;
    REQUIRE(body.size() == points.size() * 3 * sizeof(T) + triangles.size() * 13);
    for (std::size_t n = 0; n < 3 * points.size(); ++n) {
        const T number = n % 3 < D ? points[n / 3][n % 3] : T(0);
        CHECK(same(number_at<T>(body, n * sizeof(T)), number));
        CHECK(same(take_number<T>(words), number));
        CHECK(same(take_number<T>(lines), number));
    }
    std::size_t at = points.size() * 3 * sizeof(T);
    for (const auto& triangle : triangles) {
        CHECK(number_at<std::uint8_t>(body, at) == 3);
        CHECK(take_number<int>(words) == 3);
        lines = after(lines, "f");
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(number_at<std::uint32_t>(body, at + 1 + 4 * k) == triangle[k]);
            CHECK(take_number<std::uint32_t>(words) == triangle[k]);
            CHECK(take_number<std::uint32_t>(lines) == triangle[k] + 1);
        }
        at += 13;
    }
    CHECK(words == (points.empty() ? "" : "\n"));
    CHECK(lines == (points.empty() ? "" : "\n"));
}

} // namespace

TEST_CASE("a table gives the rows of any part, to the bit", "[examples][rows]") {
    const auto seed = GENERATE(range(0, cageform_tests::effort(30, 5)));
    CAPTURE(seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    check_table<2>(random);
    check_table<3>(random);
}

TEST_CASE("rows that are not poses are reported with their lines", "[examples][rows]") {
    CHECK(refusal<2>("", 1) == "file: is empty");
    CHECK(refusal<2>("# 1,2\n\n", 1) == "file: holds no poses");
    CHECK(refusal<2>("\n1,2\n3\n", 1) ==
          "file:3: 1 number, but a pose of the figure's cage has 2: x,y of 1 vertices");
    CHECK(refusal<3>("1,2,3\n1,2,3,4\n", 1) ==
          "file:2: 4 numbers, but a pose of the figure's cage has 3: x,y,z of 1 vertices");
    CHECK(refusal<2>("1,two\n", 1) == "file:1: column 2: not a number: \"two\"");
    CHECK(refusal<2>("nan,1\n", 1) == "file:1: column 1: \"nan\" is not a finite number");
    CHECK(refusal<2>("1,1e999\n", 1) == "file:1: column 2: \"1e999\" is not a finite number");
    CHECK(refusal<2>("1,2\n" + std::string(100000, '7'), 1) == "file:2: the line has more than 66560 bytes");
    CHECK(refusal<3>("\n# a clip\nlength,1\npose,0\n1,2\n", 1) ==
          "file:5: 2 columns, but a point in space has three: x,y,z");
    CHECK(
        refusal<2>("length,1\npin,a,1,2\n0,0,0,0,ease\n1,0,0,0,ease\n", 1).find("animate_svg --save-clip") !=
        std::string::npos);
}

TEST_CASE("rows of a clip are its poses at equal steps of time", "[examples][rows]") {
    const std::string text = "# a hop\nlength,2\npose,0,smooth\n0,0,0\n1,0,0\npose,0.5,linear\n0,1,0\n1,2,0\n"
                             "pose,1.25,ease\n0,0,3\n1,0,0\n";
    const TemporaryFile file(text, "rows.csv");
    const std::vector<Vec<double, 3>> rest(2);
    const auto clip = parse_pose_clip(text, "clip", 2);
    REQUIRE(clip);
    const auto motion = make_clip<double>(*clip);
    auto cursor = motion.make_cursor();
    for (const double rate : {0.4, 1.0, 7.0, 30.0}) {
        for (const auto first : {std::size_t{0}, std::size_t{3}, std::size_t{100}}) {
            PoseRows<3> rows(file.path, rest, rate);
            rows.skip(first);
            PoseRow row;
            std::size_t next = first;
            std::vector<Vec<double, 3>> expected(2);
            for (; rows.next(row); ++next) {
                CHECK(row.row == next);
                motion.sample(double(next) / rate, cursor, expected);
                const auto pose = rows.pose_of(row);
                REQUIRE(pose);
                CHECK(std::memcmp(pose->data(), expected.data(), sizeof(Vec<double, 3>) * 2) == 0);
            }
            CHECK(rows.row() == std::size_t(std::ceil(2 * rate)));
        }
    }
    CHECK(PoseRows<3>(file.path, rest, 10).name_of({4, 0, ""}) == file.path + " after 0.4 s");

    const TemporaryFile plane(
        "length,1\ncontrol,a\nvertices,0\ntime,x,y,turn,kind\n0,0,0,0,linear\n0.5,4,2,0,linear\n"
        "1,0,0,0,linear\n",
        "rows.csv");
    PoseRows<2> rows(plane.path, std::vector<Vec<double, 2>>{{1, 1}, {5, 5}}, 4);
    rows.skip(1);
    PoseRow row;
    REQUIRE(rows.next(row));
    const auto pose = rows.pose_of(row);
    REQUIRE(pose);
    CHECK((*pose)[0] == Vec<double, 2>{3, 2});
    CHECK((*pose)[1] == Vec<double, 2>{5, 5});
}

TEST_CASE("points and faces written and read in every format are unchanged to the bit", "[examples][rows]") {
    const auto seed = GENERATE(range(0, cageform_tests::effort(20, 4)));
    CAPTURE(seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    check_formats<float, 2>(random);
    check_formats<float, 3>(random);
    check_formats<double, 2>(random);
    check_formats<double, 3>(random);
}

TEST_CASE("a mesh at rest is written as its own file, also in single precision", "[examples][rows]") {
    const std::string text =
        "# a mesh\no box\nv 0.1 0.2 -0.30 1 0 0\nv 1.1 0 0\nv 0.7 1e-3 5\nv 3 3 0.3333333\n"
        "vn 0 0 1\nf 1//1 2//1 3//1 4//1\ns off\nf 3 2 1\n";
    const auto mesh = parse_obj(text, "mesh.obj");
    REQUIRE(mesh);
    std::vector<Vec<float, 3>> points;
    for (const Point3& p : mesh->vertices) points.push_back(cageform::to_vec<float>(p));
    const std::span<const Vec<float, 3>> rest(points);
    CHECK(*PosedFile(PosedFormat::mesh, 4, *mesh).contents(rest) == text);
    const std::string ply = *PosedFile(PosedFormat::ply_text, 4, *mesh).contents(rest);
    CHECK(after(ply, "element face 2\nproperty list uchar uint vertex_indices\nend_header\n") ==
          "0.1 0.2 -0.3\n1.1 0 0\n0.7 0.001 5\n3 3 0.3333333\n4 0 1 2 3\n3 2 1 0\n");

    std::string polygon = "f";
    std::string vertices;
    for (std::size_t n = 1; n <= 300; ++n) {
        vertices += "v " + std::to_string(n) + " " + std::to_string(n * n % 7) + " 0\n";
        polygon += ' ' + std::to_string(n);
    }
    const auto large = parse_obj(vertices + polygon + '\n', "large.obj");
    REQUIRE(large);
    const std::vector<Vec<float, 3>> many(300);
    const std::string bytes =
        *PosedFile(PosedFormat::ply, 4, *large).contents(std::span<const Vec<float, 3>>(many));
    const std::string_view body = after(bytes, "property list uint uint vertex_indices\nend_header\n");
    REQUIRE(body.size() == 300 * 12 + 4 + 300 * 4);
    CHECK(number_at<std::uint32_t>(body, 3600) == 300);
    CHECK(number_at<std::uint32_t>(body, 3604 + 4 * 299) == 299);
}

TEST_CASE("a range of rows is two numbers, and a path has one place for a number", "[examples][rows]") {
    const auto rows = [](const char* text) {
        const auto range = RowRange::of(text);
        return range ? std::pair(range->first, range->end) : std::pair(std::size_t{9}, std::size_t{0});
    };
    constexpr std::size_t all = std::numeric_limits<std::size_t>::max();
    const std::pair<std::size_t, std::size_t> none(9, 0);
    CHECK(rows("3:7") == std::pair<std::size_t, std::size_t>(3, 7));
    CHECK(rows("3:") == std::pair<std::size_t, std::size_t>(3, all));
    CHECK(rows(":7") == std::pair<std::size_t, std::size_t>(0, 7));
    CHECK(rows(":") == std::pair<std::size_t, std::size_t>(0, all));
    CHECK(rows("5") == std::pair<std::size_t, std::size_t>(5, 6));
    CHECK(rows("4:4") == std::pair<std::size_t, std::size_t>(4, 4));
    for (const char* wrong :
         {"", "4:3", "-1:2", "1:-2", "a:b", "1:2:3", " 1:2", "1.5:2", "99999999999999999999:"})
        CHECK(rows(wrong) == none);

    CHECK(RowPath("out/%06d.ply").of(42) == "out/000042.ply");
    CHECK(RowPath("out/%06d.ply").of(1234567) == "out/1234567.ply");
    CHECK(RowPath("%d").of(7) == "7");
    CHECK(RowPath("100%%/%03d_%%d.obj").of(7) == "100%/007_%d.obj");
    CHECK(RowPath("one.obj").of(7) == "one.obj");
    CHECK_FALSE(RowPath("100%%.obj").has_place());
    for (const char* fine : {"", "a", "%d", "%%", "%06d", "%012d", "a%%%dz"})
        CHECK(RowPath::fault(fine).empty());
    for (const char* wrong : {"%", "a%", "%s", "%6d", "%-6d", "%06", "%d%d", "%00001d", "%%%", "%06x"})
        CHECK_FALSE(RowPath::fault(wrong).empty());
}

TEST_CASE("lines are read one at a time", "[examples][rows]") {
    const std::string longest(200000, 'a');
    const TemporaryFile file("one\n\n" + longest + "\nlast\nrest\nwithout an end", "rows.csv");
    LineReader lines(file.path);
    std::string_view line;
    for (const std::string_view expected :
         {std::string_view("one"), std::string_view(), std::string_view(longest)}) {
        REQUIRE(lines.next(line));
        CHECK(line == expected);
    }
    CHECK(lines.line() == 3);
    REQUIRE(lines.next(line));
    std::string rest;
    lines.read_rest(rest);
    CHECK(rest == "rest\nwithout an end");
    CHECK_FALSE(lines.next(line));
    CHECK(lines.error().empty());
    CHECK(lines.fraction() == 1);

    LineReader bounded(file.path, 199999);
    CHECK(bounded.next(line));
    CHECK(bounded.next(line));
    CHECK_FALSE(bounded.next(line));
    CHECK(bounded.error() == file.path + ":3: the line has more than 199999 bytes");
    LineReader wide(file.path, 200000);
    for (int n = 0; n < 6; ++n) CHECK(wide.next(line));
    CHECK_FALSE(wide.next(line));
    CHECK(wide.error().empty());
}

} // namespace pose_rows_tests
