// Numbers on pictures agree with the drawing: axes of plots, colour bars.
#include "pictures/picture.hpp"
#include "catch.hpp"
#include "support/cages.hpp"
#include "support/larger.hpp"

#include <set>

namespace picture_tests {

using namespace cageform_tests;
using namespace cageform_support;

TEST_CASE("the number at a tick of an axis is the value there", "[examples][picture][property]") {
    const auto seed = GENERATE(seeds(500));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 11);
    const double length = std::pow(10.0, random.uniform(-30, 30));
    const double from = random.below(3) == 0 ? -length / 2 : length * random.uniform(-1000, 1000);
    const Axis axis{from, from + length, random.uniform(0, 100), random.uniform(200, 1000)};
    const int most = 1 + int(random.below(12));
    const auto marks = marks_of(axis, most);
    CAPTURE(axis.from, axis.to, most);
    CHECK(marks.size() <= std::size_t(most) + 1);
    if (most >= 5) CHECK(marks.size() >= 2);
    std::set<std::string> numbers;
    double before = -std::numeric_limits<double>::infinity();
    for (const auto& [value, number] : marks) {
        CAPTURE(value, number);
        CHECK(std::fabs(axis.at(std::stod(number)) - axis.at(value)) < 1e-3); // in pixels
        CHECK((axis.at(value) >= axis.begin - 1e-3 && axis.at(value) <= axis.end + 1e-3));
        CHECK(value > before);
        CHECK(numbers.insert(number).second);
        before = value;
    }
}

TEST_CASE("numbers on axes are short", "[examples][picture]") {
    const auto words = [](double from, double to, int most, double least_step = 0) {
        std::vector<std::string> all;
        for (const auto& mark : marks_of({from, to, 0, 1}, most, least_step)) all.push_back(mark.number);
        return all;
    };
    using Words = std::vector<std::string>;
    CHECK(words(0, 1, 5) == Words{"0", "0.2", "0.4", "0.6", "0.8", "1.0"});
    CHECK(words(-0.00141, 0.00141, 6) == Words{"-0.0010", "-0.0005", "0", "0.0005", "0.0010"});
    CHECK(words(-2e-16, 2e-16, 6) == Words{"-2e-16", "-1e-16", "0", "1e-16", "2e-16"});
    CHECK(words(0, 3e7, 3) == Words{"0", "1e7", "2e7", "3e7"});
    CHECK(words(5, 9, 10, 1) == Words{"5", "6", "7", "8", "9"});
    CHECK(words(1e9, 1e9 + 1e-6, 5).empty()); // no doubles in between
    CHECK(words(3, 3, 5).empty());
}

TEST_CASE("the colour next to a number of a colour bar is that of the number",
          "[examples][picture][property]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 23);
    const Axis axis{-random.uniform(0, 0.5), random.uniform(0.3, 1), 570, 30};
    Picture picture(160, 600);
    const auto marks = marks_of(axis, 8);
    REQUIRE(marks.size() >= 2);
    draw_colour_bar(picture, axis, marks, 10, 30, 2);
    const auto unlike = [](const Colour& a, const Colour& b) {
        return std::max({std::fabs(a.r - b.r), std::fabs(a.g - b.g), std::fabs(a.b - b.b)});
    };
    for (const auto& [value, number] : marks) {
        CAPTURE(value, number);
        const auto row = std::size_t(std::min(axis.at(value), axis.begin - 1));
        const bool at_end = row < 33 || row > 566; // in the column of the bar's outline
        if (!at_end) CHECK(unlike(picture.at(25, row), heat(std::stod(number))) < 0.02f);
        // The tick is in this row, with a number next to it.
        CHECK(picture.at(44, row).r < 0.8f);
        bool written = false;
        for (std::size_t y = row > 7 ? row - 7 : 0; y < std::min<std::size_t>(row + 7, 600); ++y) {
            for (std::size_t x = 50; x < 160; ++x) written = written || picture.at(x, y).r < 0.5f;
        }
        CHECK(written);
    }
}

TEST_CASE("the colour map is white at zero", "[examples][picture]") {
    double before = 0;
    for (int n = -1000; n < 1000; ++n) {
        const Colour a = heat(n * 1e-3), b = heat((n + 1) * 1e-3);
        const double step = std::max({std::fabs(a.r - b.r), std::fabs(a.g - b.g), std::fabs(a.b - b.b)});
        CAPTURE(n);
        CHECK(step < 0.01);
        before = cageform_tests::larger(before, step);
    }
    CHECK(before > 0);
    CHECK(heat(-0.03).b > heat(-0.03).r); // blue below zero, red above
    CHECK(heat(0.03).b < heat(0.03).r);
}

TEST_CASE("a picture is placed into another and cut off at its border", "[examples][picture]") {
    Picture board(5, 4, {0, 0, 0});
    board.place(Picture(3, 3, {1, 0.5f, 0}), 3, 2);
    for (std::size_t y = 0; y < 4; ++y) {
        for (std::size_t x = 0; x < 5; ++x) CHECK(board.at(x, y).g == (x >= 3 && y >= 2 ? 0.5f : 0.0f));
    }
    CHECK(board.png().starts_with("\x89PNG\r\n\x1a\n"));
}

} // namespace picture_tests
