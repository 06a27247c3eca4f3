#include "cli/pins.hpp"
#include "files/marker_file.hpp"
#include "io/csv.hpp"

#include "catch.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace pins_tests {

using namespace cageform_support;
using cageform::Vec;

namespace {

constexpr double degree = std::numbers::pi / 180;
const std::vector<Vec<double, 3>> vertices{{0, 0, 0}, {1, 2, 3}, {4, 5, 6}};

template <std::size_t D>
Pin<D> pin_of(const std::string& word) {
    INFO(word);
    std::vector<Vec<double, D>> known;
    if constexpr (D == 3) known = vertices;
    const auto pin = parse_pin<D>(word, std::span<const Vec<double, D>>(known));
    REQUIRE(pin);
    return *pin;
}
template <std::size_t D>
std::string refusal_of(const std::string& word) {
    const auto pin = parse_pin<D>(word);
    REQUIRE(!pin);
    return pin.error().message;
}

template <std::size_t D>
std::string text_of(const Vec<double, D>& p) {
    std::string text;
    for (const double x : p.v) text += (text.empty() ? "" : ",") + detail::digits_of(x);
    return text;
}

} // namespace

TEST_CASE("a pin has a place, a target and a turn", "[pins]") {
    const auto stays = pin_of<2>("915,165");
    CHECK(stays.place == Vec<double, 2>{915, 165});
    CHECK(stays.target == stays.place);
    CHECK(!stays.turn);
    CHECK(stays.weight == 1);
    CHECK(pin_of<2>(" 915 , 165 : 760 , 60 ").target == Vec<double, 2>{760, 60});
    CHECK(pin_of<2>("915,165:+20,-5").target == Vec<double, 2>{935, 160});
    CHECK(pin_of<2>("915,165:-20,5").target == Vec<double, 2>{895, 170}); // one sign is enough
    CHECK(pin_of<2>("915,165:20,+5").target == Vec<double, 2>{935, 170});
    CHECK(pin_of<2>("915,165:=-20,5").target == Vec<double, 2>{-20, 5});
    CHECK(pin_of<2>("-9,-5:=1e2,5").place == Vec<double, 2>{-9, -5});
    const auto turns = pin_of<2>("1,2:+0,+0@-40");
    REQUIRE(turns.turn);
    CHECK((*turns.turn)[0] == -40 * degree);
    CHECK(turns.target == turns.place);
    CHECK(pin_of<2>("1,2@90").turn == Vec<double, 1>{90 * degree});
}

TEST_CASE("a pin in space may name a vertex, and turns about an axis", "[pins]") {
    const auto moved = pin_of<3>("1:+0.5,0,-1@30,y");
    CHECK(moved.place == vertices[1]);
    CHECK(moved.target == Vec<double, 3>{1.5, 2, 2});
    REQUIRE(moved.turn);
    CHECK(*moved.turn == Vec<double, 3>{0, 30 * degree, 0});
    const auto skew = pin_of<3>("1,2,3@90,0,3,4");
    REQUIRE(skew.turn);
    CHECK(std::fabs((*skew.turn)[1] - 90 * degree * 0.6) < 1e-15);
    CHECK(std::fabs((*skew.turn)[2] - 90 * degree * 0.8) < 1e-15);
    CHECK(refusal_of<3>("3:0,0,0").find("there is no vertex 3: the figure has 0") != std::string::npos);
    CHECK(refusal_of<3>("1.5").find("is not the number of a vertex") != std::string::npos);
    CHECK(refusal_of<3>("1,2").find("is not a place: write x,y,z, or the number of a vertex") !=
          std::string::npos);
    CHECK(refusal_of<3>("1,2,3@30").find("is not an angle and an axis") != std::string::npos);
    CHECK(refusal_of<3>("1,2,3@30,0,0,0").find("has an axis of length zero") != std::string::npos);
    CHECK(refusal_of<3>("1e308,2,3:+1e308,0,0").ends_with("the target exceeds the range of numbers"));
}

TEST_CASE("pins written and read are unchanged", "[pins]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> number(-1e3, 1e3);
    const auto place = [&](auto p) {
        for (double& x : p.v) x = number(random);
        return p;
    };
    std::string plane = "x,y,tx,ty,angle,weight\r\n# a comment\n", space = "vertex or x,y,z\n\n";
    std::vector<Pin<2>> in_plane;
    std::vector<Pin<3>> in_space;
    for (int n = 0; n < 60; ++n) {
        Pin<2> flat{"", place(Vec<double, 2>{}), place(Vec<double, 2>{}), {}, 1};
        Pin<3> deep{"", place(Vec<double, 3>{}), place(Vec<double, 3>{}), {}, 1};
        if (n % 2 == 1) deep.place = vertices[std::size_t(n) % 3];
        plane += text_of(flat.place) + ',' + text_of(flat.target);
        space += (n % 2 == 1 ? std::to_string(n % 3) : text_of(deep.place)) + ',' + text_of(deep.target);
        const Vec<double, 3> degrees = place(Vec<double, 3>{});
        if (n % 3 == 1) { // turns without targets
            flat.turn = degree * Vec<double, 1>{degrees[0]};
            deep.turn = degree * degrees;
            plane += ',' + detail::digits_of(degrees[0]);
            space += ',' + text_of(degrees);
        }
        if (n % 3 == 2) { // weights only
            flat.weight = deep.weight = std::fabs(number(random));
            plane += ",," + detail::digits_of(flat.weight);
            space += ",,,," + detail::digits_of(deep.weight);
        }
        plane += '\n';
        space += "\r\n";
        in_plane.push_back(flat);
        in_space.push_back(deep);
    }
    const auto check = [](const auto& read, const auto& written) {
        REQUIRE(read);
        REQUIRE(read->size() == written.size());
        for (std::size_t n = 0; n < written.size(); ++n) {
            CAPTURE(n, (*read)[n].name);
            CHECK((*read)[n].place == written[n].place);
            CHECK((*read)[n].target == written[n].target);
            CHECK((*read)[n].turn == written[n].turn);
            CHECK((*read)[n].weight == written[n].weight);
        }
    };
    check(parse_pins<2>(plane, "pins.csv"), in_plane);
    check(parse_pins<3>(space, "pins.csv", std::span(vertices)), in_space);
    CHECK(parse_pins<2>(plane, "pins.csv")->at(1).name == "pins.csv:4");
}

TEST_CASE("invalid lines of pins are refused with their number", "[pins]") {
    const auto refused = [](const std::string& text, auto dimension) {
        const auto pins = parse_pins<decltype(dimension)::value>(text, "p.csv");
        return pins ? std::string("taken") : pins.error().message;
    };
    using Plane = std::integral_constant<std::size_t, 2>;
    using Space = std::integral_constant<std::size_t, 3>;
    CHECK(refused("", Plane()) == "p.csv: holds no pins");
    CHECK(refused("x,y\n", Plane()) == "p.csv: holds no pins");
    CHECK(refused("1,2,3,4\n\n1,2,3\n", Plane()).starts_with("p.csv:3: 3 columns"));
    CHECK(refused("1,2,3,4,5,6,7", Plane()).starts_with("p.csv:1: 7 columns"));
    CHECK(refused("1,2,3,4,5,0", Plane()) == "p.csv:1: the weight \"0\" is not positive");
    CHECK(refused("1,2,3,4,5,,,", Plane()) == "taken");
    CHECK(refused("1,2,,", Plane()) == "p.csv:1: not a number: \"\"");
    CHECK(refused("1,2,3,4,nan", Plane()) == "p.csv:1: \"nan\" is not a finite number");
    for (const int columns : {1, 2, 3, 5, 11, 12}) {
        std::string line = "1";
        for (int k = 1; k < columns; ++k) line += ",1";
        CHECK(refused(line, Space()).starts_with("p.csv:1: " + std::to_string(columns) + " column"));
    }
    CHECK(refused("1,2,3,4,5,6,1,,", Space()) == "p.csv:1: not a number: \"\"");
    CHECK(refused("0,1,2,3", Space()) == "p.csv:1: there is no vertex 0: the figure has 0, counted from 0");
}

TEST_CASE("pins at one place with two targets contradict each other", "[pins]") {
    std::vector<Pin<2>> pins{pin_of<2>("1,2:3,4"), pin_of<2>("1,2:3,4"), pin_of<2>("1,3:5,6")};
    CHECK(contradiction(pins) == "");
    pins.push_back(pin_of<2>("1,3"));
    CHECK(contradiction(pins) ==
          "pin 4 (--pin \"1,3\") at (1, 3) has another target than --pin \"1,3:5,6\" at "
          "the same position: the figure moves between both targets");
}

TEST_CASE("markers written and read are unchanged", "[pins]") {
    std::mt19937 random(11);
    std::uniform_int_distribution<int> hundredths(-10000, 10000);
    const auto point = [&] { return Point2{hundredths(random) / 100.0, hundredths(random) / 100.0}; };
    Tracks tracks;
    for (int n = 0; n < 5; ++n) tracks.rest.push_back(point());
    for (int k = 0; k < 9; ++k) {
        tracks.times.push_back(0.25 * k);
        auto& row = tracks.places.emplace_back();
        for (int n = 0; n < 5; ++n) row.push_back(point());
    }
    tracks.places.back() = tracks.places.front();
    ClipFile of;
    of.late.push_back({"legs", 0.5});
    of.ground = {7, -3};
    const auto clip = parse_markers(markers_text(tracks, of, "a heading"), "m.csv");
    REQUIRE(clip);
    CHECK(clip->length == 2);
    REQUIRE(clip->late.size() == 1);
    CHECK(clip->late[0].element == "legs");
    REQUIRE(clip->ground);
    CHECK(clip->ground->speed == -3);
    REQUIRE(clip->controls.size() == 5);
    for (std::size_t n = 0; n < 5; ++n) {
        const ClipControl& marker = clip->controls[n];
        CHECK(marker.name == "marker " + std::to_string(n + 1));
        REQUIRE(marker.pin);
        CHECK(marker.pin->place == tracks.rest[n]);
        REQUIRE(marker.rows.size() == 9);
        for (std::size_t k = 0; k < 9; ++k) {
            CHECK(marker.rows[k].time == tracks.times[k]);
            CHECK(marker.rows[k].move[0] == tracks.places[k][n].x - tracks.rest[n].x);
            CHECK(marker.rows[k].move[1] == tracks.places[k][n].y - tracks.rest[n].y);
        }
    }
    // Pins written as a clip are unchanged to the bit.
    const auto again = parse_clip(clip_text(*clip, "a heading"), "c.csv", 0);
    REQUIRE(again);
    REQUIRE(again->has_pins());
    for (std::size_t n = 0; n < 5; ++n) {
        CHECK(again->controls[n].pin->place == clip->controls[n].pin->place);
        CHECK(again->controls[n].rows.size() == 9);
        for (std::size_t k = 0; k < 9; ++k)
            CHECK(again->controls[n].rows[k].move == clip->controls[n].rows[k].move);
    }
}

TEST_CASE("a lost marker is interpolated to its next position", "[pins]") {
    const auto clip = parse_markers("3,1,1,9,9\n4,,,8,8\n5,3,1,,\n6,,,7,8\n", "m.csv");
    REQUIRE(clip);
    CHECK(clip->length == 3.5); // back to the first row
    const auto times = [&](std::size_t n) {
        std::vector<double> all;
        for (const auto& row : clip->controls[n].rows) all.push_back(row.time);
        return all;
    };
    CHECK(times(0) == std::vector<double>{0, 2, 3, 3.5});
    CHECK(times(1) == std::vector<double>{0, 1, 3, 3.5});
    CHECK(clip->controls[0].rows[2].move[0] == 2);
    CHECK(clip->controls[0].rows[3].move[0] == 0);
}

} // namespace pins_tests
