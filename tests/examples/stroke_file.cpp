// Drawings whose strokes have values, colours in CSS notation, level lines.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include "files/stroke_file.hpp"
#include "pictures/level_lines.hpp"

#include <cstdio>
#include <fstream>

namespace stroke_file_tests {

using namespace cageform_support;

namespace {

Expected<StrokeFile> strokes_of(const std::string& content) {
    const std::string path = "stroke_file_test.svg";
    std::ofstream(path) << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 50\">" << content
                        << "</svg>";
    auto file = load_strokes(path, {"data-height"});
    std::remove(path.c_str());
    return file;
}
Expected<std::vector<double>> number(const std::string& word) {
    if (word == "x") return FileError{"no number"};
    return std::vector<double>{std::stod(word)};
}
std::string words_of(const std::optional<PaintColour>& colour) {
    if (!colour) return "none";
    const auto& [r, g, b] = colour->colour;
    return std::to_string(std::lround(255 * r)) + " " + std::to_string(std::lround(255 * g)) + " " +
           std::to_string(std::lround(255 * b)) + " " + std::to_string(std::lround(255 * colour->alpha));
}

} // namespace

TEST_CASE("colours are read as CSS writes them", "[examples][strokes]") {
    const std::vector<std::pair<std::string, std::string>> known{{"#f80", "255 136 0 255"},
                                                                 {"#F808", "255 136 0 136"},
                                                                 {"#12abef", "18 171 239 255"},
                                                                 {" #12abef80 ", "18 171 239 128"},
                                                                 {"rgb(1,2,3)", "1 2 3 255"},
                                                                 {"rgb( 100% 50% 0 / 0.5 )", "255 128 0 128"},
                                                                 {"RGBA(300, -4, 7, 25%)", "255 0 7 64"},
                                                                 {"AliceBlue", "240 248 255 255"},
                                                                 {"yellowgreen", "154 205 50 255"},
                                                                 {"rebeccapurple", "102 51 153 255"},
                                                                 {"transparent", "0 0 0 0"}};
    for (const auto& [text, expected] : known) {
        CAPTURE(text);
        CHECK(words_of(parse_colour(text)) == expected);
    }
    for (const char* text :
         {"", "none", "#", "#12", "#12345", "#1234567", "#123456789", "#ggg", "rgb(1,2)", "rgb(1,2,3,4,5)",
          "rgb(1,2,x)", "rgb(1,2,nan)", "rgb(1,2,3", "hsl(1,2,3)", "bluee", "url(#a)", "currentColor"}) {
        CAPTURE(text);
        CHECK(!parse_colour(text));
    }
    for (int byte = 0; byte <= 255; ++byte)
        CHECK(std::lround(255 * to_displayed(to_linear(byte / 255.0))) == byte);
}

TEST_CASE("strokes of a drawing have values along their length", "[examples][strokes]") {
    const auto file =
        strokes_of("<g transform=\"translate(10 0)\"><path id=\"a\" stroke=\"red\" data-height=\"0 1\" "
                   "d=\"M0,10 H30 V40\"/></g><circle data-height=\"0.5\" cx=\"80\" cy=\"20\" r=\"8\"/>"
                   "<rect width=\"5\" height=\"5\"/><path data-height=\"1\" d=\"M3,3 L3,3\"/>");
    REQUIRE(file);
    CHECK(file->canvas.width == 100);
    REQUIRE(file->lines.size() == 2); // elements without a stroke or of length 0 are ignored
    const auto& path = file->lines[0];
    CHECK(path.label == "path \"a\" (line 1)");
    CHECK(path.stroke == "red");
    CHECK(path.points == std::vector<cageform::Vec<double, 2>>{{10, 10}, {40, 10}, {40, 40}});
    CHECK((!path.closed && path.vertices == 3));
    CHECK(*values_along(path, "0 1", 1, number) == std::vector<double>{0, 0.5, 1});
    CHECK(*values_along(path, "0 3 1", 1, number) == std::vector<double>{0, 3, 1});
    CHECK(*values_along(path, "7", 1, number) == std::vector<double>{7, 7, 7});
    CHECK(values_along(path, "1 2 3 4", 1, number).error().message ==
          "4 values for 3 vertices: give one, two for the ends, or one for each");
    CHECK(values_along(path, "1 x", 1, number).error().message == "no number");
    CHECK(!values_along(path, "", 1, number));

    const auto& circle = file->lines[1];
    CHECK((circle.closed && circle.vertices == 4));
    CHECK(circle.points.front() == circle.points.back());
    for (const auto& p : circle.points) CHECK(std::fabs(std::hypot(p[0] - 80, p[1] - 20) - 8) < 0.02);
    const auto around = values_along(circle, "0 1 2 3", 1, number);
    REQUIRE(around);
    CHECK(around->front() == around->back());       // back to the first vertex
    CHECK(!values_along(circle, "0 1", 1, number)); // no ends

    CHECK(strokes_of("<rect width=\"5\" height=\"5\"/>").error().message ==
          "stroke_file_test.svg: holds no stroke");
    CHECK(strokes_of("<path id=\"far\" stroke=\"red\" d=\"M0,0 L101,4\"/>").error().message ==
          "stroke_file_test.svg: path \"far\" (line 1) extends beyond the picture (its viewBox)");
}

TEST_CASE("level lines lie where the field has the value, and end only at the boundary",
          "[examples][strokes][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    cageform_tests::Random random{std::uint64_t(seed)};
    const std::size_t width = 3 + random.below(30), height = 3 + random.below(30);
    std::vector<double> values(width * height);
    for (double& value : values) value = random.uniform(-1, 1);
    std::size_t crossings = 0, points = 0; // of the sides of squares
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % width + 1 < width) crossings += (values[i] > 0.1) != (values[i + 1] > 0.1) ? 1 : 0;
        if (i + width < values.size()) crossings += (values[i] > 0.1) != (values[i + width] > 0.1) ? 1 : 0;
    }
    for (const auto& line : level_lines(values, width, 0.1)) {
        REQUIRE(line.size() >= 2);
        const bool closed = line.front() == line.back();
        points += line.size() - (closed ? 1 : 0);
        for (const Point2& p : line) {
            const auto x = std::min(std::size_t(p.x), width - 2), y = std::min(std::size_t(p.y), height - 2);
            const double u = p.x - double(x), v = p.y - double(y);
            const double at =
                (1 - v) * ((1 - u) * values[y * width + x] + u * values[y * width + x + 1]) +
                v * ((1 - u) * values[(y + 1) * width + x] + u * values[(y + 1) * width + x + 1]);
            CHECK(std::fabs(at - 0.1) < 1e-12);
        }
        if (closed) continue;
        for (const Point2& end : {line.front(), line.back()})
            CHECK((end.x == 0 || end.y == 0 || end.x == double(width - 1) || end.y == double(height - 1)));
    }
    CHECK(points == crossings);
    values[width + 1] = std::nan("");
    for (const auto& line : level_lines(values, width, 0.1)) {
        for (const Point2& p : line) CHECK((std::isfinite(p.x) && std::isfinite(p.y)));
    }
    CHECK(level_lines({}, 0, 0.1).empty());
}

} // namespace stroke_file_tests
