#include "catch.hpp"
#include "support/gradients.hpp"
#include "support/oracle.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/sibson.hpp>

using namespace cageform;
using namespace cageform_tests;

namespace {

template <std::size_t D>
using Points = std::vector<Vec<double, D>>;

template <std::size_t D>
Points<D> read_points(const nlohmann::json& list) {
    Points<D> points;
    for (const auto& p : list) {
        Vec<double, D> x{};
        for (std::size_t k = 0; k < D; ++k) x[k] = p[k].get<double>();
        points.push_back(x);
    }
    return points;
}
nlohmann::json read_sets(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/sibson/" + name + ".json");
    return nlohmann::json::parse(file)["sets"];
}

template <class T, class S, std::size_t D>
std::vector<Vec<T, D>> cast(const std::vector<Vec<S, D>>& points) {
    std::vector<Vec<T, D>> result;
    for (const auto& p : points) result.push_back(vec_cast<T>(p));
    return result;
}

template <class T, std::size_t D>
void check_reference(const std::string& file, int degree) {
    std::size_t points = 0;
    for (const auto& set : read_sets(file)) {
        CAPTURE(set["name"].get<std::string>());
        const auto sites = read_points<D>(set["sites"]);
        const SibsonCoordinates<T, D> sibson(cast<T>(sites), {.degree = degree});
        REQUIRE(sibson.cage_report().status == Status::ok);
        for (const auto& entry : set["points"]) {
            CAPTURE(entry["point"].dump());
            const auto p = read_points<D>(nlohmann::json::array({entry["point"]}));
            // Rounding sites and points to float moves them; what is left to compare are the doubles.
            const bool same = std::is_same_v<T, double> ||
                              (cast<double>(cast<T>(p)) == p && cast<double>(cast<T>(sites)) == sites);
            const auto row = evaluate_all(sibson, cast<T>(p));
            REQUIRE(row.status() == Status::ok);
            CHECK(row.states[0] != PointState::outside);
            const double tolerance = std::is_same_v<T, double> ? 1e-13 : same ? 1e-6 : 1e-5;
            for (std::size_t i = 0; i < sites.size(); ++i) {
                CAPTURE(i);
                CHECK(std::fabs(double(row.rows[0][i]) - entry["weights"][i].get<double>()) <= tolerance);
            }
            ++points;
            if (!entry.contains("gradients") || !std::is_same_v<T, double>) continue;
            const auto expected = read_points<D>(entry["gradients"]);
            const auto found = gradients_of<T, D>(sibson, cast<T>(p));
            for (std::size_t i = 0; i < sites.size(); ++i)
                CHECK(distance(found.rows[0][i], expected[i]) <= 1e-12);
        }
    }
    CHECK(points >= 25);
}

} // namespace

TEMPLATE_TEST_CASE("sibson has the exact weights of the reference files", "[coordinates][sibson]", CAGEFORM_SCALARS) {
    check_reference<TestType, 2>("sibson-2d", 1);
    check_reference<TestType, 3>("sibson-3d", 1);
    check_reference<TestType, 2>("sibson-c1-2d", 3);
    check_reference<TestType, 3>("sibson-c1-3d", 3);
}
