// Green coordinates of curved cages: reference values, the laws of Cauchy's integral, faults by name.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/green.hpp"

#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>

#include <nlohmann/json.hpp>

#include <complex>
#include <fstream>

namespace curved_green_tests {

using namespace cageform;
using namespace cageform_tests;

namespace {

using Complex = std::complex<double>;
using Json = nlohmann::json;

static_assert(GradientCoordinates<CurvedGreenCoordinates<float>>);
static_assert(GradientCoordinates<CurvedGreenCoordinates<double>>);

double number(const Json& x) {
    return x.is_string() ? std::stod(x.get<std::string>()) : x.get<double>();
}
template <class T = double>
Vec<T, 2> vec(const Json& x) {
    return {T(number(x[0])), T(number(x[1]))};
}
Json read(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/curved/" + name);
    return Json::parse(file);
}
template <class T>
CurvedGreenCoordinates<T> coordinates_of(const Json& json, CurvedGreenOptions<T> options = {}) {
    std::vector<typename CurvedPolygon<T>::Loop> loops;
    for (const auto& loop : json["loops"]) {
        auto& edges = loops.emplace_back();
        for (const auto& edge : loop) {
            auto& points = edges.emplace_back();
            for (const auto& p : edge) points.push_back(vec<T>(p));
        }
    }
    for (const auto& loop : json["posed_degrees"]) {
        for (const auto& m : loop) options.posed_degrees.push_back(m.get<std::size_t>());
    }
    return CurvedGreenCoordinates<T>(CurvedPolygon<T>(std::move(loops)), options);
}

/// The largest difference of weights, where those of the legs of a loop may all differ by one number.
template <class T>
double difference_of_rows(const CurvedGreenCoordinates<T>& green, const std::vector<T>& row, const Json& points,
                          const Json& legs) {
    const std::size_t count = points.size();
    double worst = row.size() == 2 * count ? 0 : 1e9;
    for (std::size_t i = 0; i < count; ++i)
        worst = larger(worst, std::fabs(double(row[i]) - number(points[i])));
    std::size_t first = 0;
    for (const auto& loop : green.cage().loops()) {
        std::size_t last = first;
        for (std::size_t e = 0; e < loop.size(); ++e) last += 3; // all files have posed edges of degree 3
        double mean = 0;
        for (std::size_t i = first; i < last; ++i)
            mean += (double(row[count + i]) - number(legs[i])) / double(last - first);
        for (std::size_t i = first; i < last; ++i)
            worst = larger(worst, std::fabs(double(row[count + i]) - mean - number(legs[i])));
        first = last;
    }
    return first == count ? worst : 1e9;
}

template <class T>
void compare_with_reference(const std::string& name) {
    const double tolerance = std::is_same_v<T, float> ? 1e-5 : 1e-13;
    const Json json = read(name);
    const auto green = coordinates_of<T>(json);
    REQUIRE(green.cage_report().status == Status::ok);
    const std::size_t count = json["handles"].size();
    REQUIRE(green.handles().size() == 2 * count);
    for (std::size_t i = 0; i < count; ++i) {
        CHECK(distance(green.handles()[i], vec(json["handles"][i])) <= tolerance);
        const auto leg = json["legs"][i];
        CHECK(green.handle_faces()[i] == HandleFace<2>{leg[0].get<std::uint32_t>(), leg[1].get<std::uint32_t>()});
    }
    std::vector<Vec<T, 2>> points, pose;
    std::vector<Vec<double, 2>> posed(2 * count);
    for (const auto& row : json["rows"]) points.push_back(vec<T>(row["point"]));
    for (std::size_t i = 0; i < count; ++i) posed[i] = vec(json["pose"][i]);
    for (std::size_t i = 0; i < count; ++i)
        posed[count + i] = edge_handle(posed[green.handle_faces()[i][0]], posed[green.handle_faces()[i][1]]);
    const auto found = evaluate_all(green, points);
    const auto slopes = gradients_of<T, 2>(green, points);
    REQUIRE(found.status() == Status::ok);
    std::size_t derivatives = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto& row = json["rows"][n];
        const std::string state = row["state"];
        // In float the points next to the boundary are on it, or beyond.
        if (std::is_same_v<T, float> && n >= 4 && n < 8) continue;
        CAPTURE(name, n, points[n][0], points[n][1], state);
        CHECK(to_string(found.states[n]) == state);
        CHECK(difference_of_rows(green, found.rows[n], row["points_a"], row["legs_b"]) <= tolerance);
        const auto at = combine(found.rows[n], posed);
        CHECK(distance(at, vec(row["posed"])) <= 4 * tolerance);
        if (row.contains("legs_b_diagonal")) {
            for (std::size_t i = 0; i < count; ++i)
                CHECK(std::fabs(double(found.rows[n][count + i]) - number(row["legs_b_diagonal"][i])) <= tolerance);
        }
        if (!row.contains("derivative")) continue;
        ++derivatives;
        double largest = 0, worst = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Complex expected(number(row["derivative"][i][0]), number(row["derivative"][i][1]));
            const auto& gradient = slopes.rows[n][i];
            largest = std::max(largest, std::abs(expected));
            worst = larger(worst, std::abs(Complex(double(gradient[0]), -double(gradient[1])) - expected));
        }
        CHECK(worst <= tolerance * largest);
        const auto j = jacobian(slopes.rows[n], [&] {
            std::vector<Vec<T, 2>> all;
            for (const auto& p : posed) all.push_back(vec_cast<T>(p));
            return all;
        }());
        const auto f = vec(row["posed_derivative"]);
        CHECK(std::fabs(double(j[0][0]) - f[0]) <= 8 * tolerance * largest);
        CHECK(std::fabs(double(j[1][0]) - f[1]) <= 8 * tolerance * largest);
        CHECK(std::fabs(double(j[0][0] - j[1][1])) <= 8 * tolerance * largest);
        CHECK(std::fabs(double(j[0][1] + j[1][0])) <= 8 * tolerance * largest);
    }
    CHECK(derivatives >= 4);
}

} // namespace

TEST_CASE("Weights of curved cages are those of the oracle", "[coordinates][curved_green][oracle]") {
    for (const char* name : {"curved_l_straight.json", "curved_mixed.json", "curved_blob.json",
                             "curved_leaf.json", "curved_hole.json"}) {
        compare_with_reference<double>(name);
        compare_with_reference<float>(name);
    }
}

TEST_CASE("Weights of curved cages in a disk are those of the oracle", "[coordinates][curved_green][oracle]") {
    const Json json = read("disk.json");
    for (const auto& test : json["cases"]) {
        CurvedGreenOptions<double> options;
        options.disk = CurvedGreenDisk<double>{vec(test["centre"]), number(test["radius"])};
        const auto green = coordinates_of<double>(read(test["cage"]), options);
        REQUIRE(green.cage_report().status == Status::ok);
        std::vector<Vec<double, 2>> points, posed;
        for (const auto& row : test["rows"]) points.push_back(vec(row["point"]));
        for (const auto& p : test["pose"]) posed.push_back(vec(p));
        for (const auto& [from, to] : green.handle_faces()) posed.push_back(edge_handle(posed[from], posed[to]));
        const auto found = evaluate_all(green, points);
        REQUIRE(found.status() == Status::ok);
        for (std::size_t n = 0; n < points.size(); ++n) {
            CAPTURE(test["cage"].get<std::string>(), n);
            const auto& row = test["rows"][n];
            for (std::size_t i = 0; i < row["weights"].size(); ++i)
                CHECK(std::fabs(found.rows[n][i] - number(row["weights"][i][0])) <= 1e-13);
            CHECK(distance(combine(found.rows[n], posed), vec(row["posed"])) <= 1e-13);
        }
    }
}

} // namespace curved_green_tests
