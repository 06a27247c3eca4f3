// Local harmonic coordinates: exact values on rectangles, laws on random cages with both solvers.
#include "../catch.hpp"
#include "../support/aligned.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/points_inside.hpp"
#include "../support/polyhedra.hpp"
#include "../support/weights.hpp"

#include <cageform/coordinates/uniform_harmonic.hpp>

namespace local_harmonic_tests {

using namespace cageform_tests;
using cageform::CellComplex;
using cageform::epsilon;
using cageform::HarmonicCoordinates;
using cageform::HarmonicOptions;
using cageform::Polygon;

namespace {

/// Checks 0 ≤ w, Σ w = 1, Σ w C = p, Σ ∇w = 0 and Σ C ∇wᵀ = 1.
///
///   limit  of the errors of gradients
template <class C, class Points>
void check_laws(const C& coordinates, const Points& points, double limit) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const auto gradients = gradients_of<T, D>(coordinates, points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    const auto bounds = cageform::bounds_of(coordinates.handles());
    const double size = double(bounds.diagonal()), rounding = double(epsilon<T>);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1]);
        if (weights.states[i] != PointState::inside) continue;
        ++inside;
        const auto& row = weights.rows[i];
        CHECK(*std::min_element(row.begin(), row.end()) >= 0);
        CHECK(std::fabs(double(sum_of(row)) - 1) <= 32 * rounding);
        CHECK(distance(combine(row, coordinates.handles()), points[i]) <=
              32 * rounding * (size + double(bounds.magnitude())));
        // Rounding errors of slopes grow as 1/distance next to the boundary.
        std::vector<T> of_place(row.size());
        if (distance(coordinates.nearest_boundary(points[i], of_place), points[i]) < 1e-3 * size) continue;
        for (std::size_t axis = 0; axis < D; ++axis) {
            double sum = 0;
            Vec<double, D> moved{};
            for (std::size_t k = 0; k < row.size(); ++k) {
                const auto slope = double(gradients.rows[i][k][axis]);
                sum += slope;
                for (std::size_t c = 0; c < D; ++c) moved[c] += slope * double(coordinates.handles()[k][c]);
            }
            moved[axis] -= 1;
            CHECK(std::fabs(sum) * size <= limit);
            CHECK(distance(moved, Vec<double, D>{}) <= limit);
        }
    }
    CHECK(inside * 2 > points.size());
}

/// Checks the laws on a cage with a random locality, with both solvers.
///
///   limit  of the errors of gradients, in roundings
template <class Cage>
void check_cage(const Cage& cage, Random& random, double limit = 1e5) {
    constexpr std::size_t D = Cage::dimension;
    limit *= double(epsilon<typename Cage::scalar>);
    HarmonicOptions options{.accuracy = effort(0.02, 0.05), .locality = random.uniform(0.1, 40)};
    CAPTURE(options.locality);
    const HarmonicCoordinates adaptive(cage, options);
    REQUIRE(adaptive.cage_report().status == Status::ok);
    const auto points = points_inside(cage, effort<std::size_t>(48, 16), random);
    if (points.size() < 8) return; // a thin cage
    check_laws(adaptive, points, limit);
    options.resolution = D == 2 ? 96 : 40;
    const HarmonicCoordinates uniform(cage, options, cageform::UniformGrid{});
    const auto status = evaluate_all(uniform, points).status();
    if (status != Status::grid_too_coarse) check_laws(uniform, points, limit);
}

} // namespace

TEST_CASE("local harmonic weights and gradients on rectangles are those of the sine series",
          "[coordinates][harmonic][oracle]") {
    for (const char* name : {"rectangle_2x1", "rectangle_uneven", "square_eight", "square_one_more",
                             "strip_4x1", "unit_square"}) {
        const auto json = read_json(std::string("../positive/local_harmonic2d_") + name);
        Points2<double> vertices, points;
        for (const auto& v : json["cage"]["vertices"]) vertices.push_back({v[0], v[1]});
        for (const auto& p : json["points"]) points.push_back({p[0], p[1]});
        for (const char* locality : {"0", "10", "20"}) {
            for (const double accuracy : {1e-2, 1e-4}) {
                CAPTURE(name, locality, accuracy);
                const HarmonicCoordinates coordinates(
                    vertices, {.accuracy = accuracy, .locality = std::stod(locality)});
                const auto weights = evaluate_all(coordinates, points);
                const auto gradients = gradients_of<double, 2>(coordinates, points);
                double error = 0, error_of_slope = 0;
                for (std::size_t i = 0; i < points.size(); ++i) {
                    const auto& exact = json["coordinates"][locality][i];
                    const bool is_inside = json["point_tags"][i].get<std::string>().starts_with("inside");
                    REQUIRE(weights.states[i] == (is_inside ? PointState::inside : PointState::on_boundary));
                    for (std::size_t k = 0; k < vertices.size(); ++k)
                        error = larger(error, std::fabs(weights.rows[i][k] - exact[k].get<double>()));
                    if (json["point_tags"][i] != "inside") continue; // these come first
                    const auto& slopes = json["gradients"][locality][i];
                    double largest = 0, worst = 0;
                    for (std::size_t axis = 0; axis < 2; ++axis) {
                        for (std::size_t k = 0; k < vertices.size(); ++k) {
                            const auto slope = slopes[axis][k].get<double>();
                            largest = larger(largest, std::fabs(slope));
                            worst = larger(worst, std::fabs(gradients.rows[i][k][axis] - slope));
                        }
                    }
                    error_of_slope = larger(error_of_slope, worst / largest);
                }
                CHECK(error <= 0.4 * accuracy); // measured: at most 0.22 of it
                CHECK(error_of_slope <= 8 * accuracy);
            }
            HarmonicOptions options{.locality = std::stod(locality)};
            std::array<double, 2> errors{};
            for (std::size_t n = 0; n < 2; ++n) {
                options.resolution = n == 0 ? 64 : 256;
                const HarmonicCoordinates<double, 2> coordinates(vertices, options, cageform::UniformGrid{});
                const auto weights = evaluate_all(coordinates, points);
                for (std::size_t i = 0; i < points.size(); ++i) {
                    for (std::size_t k = 0; k < vertices.size(); ++k) {
                        const auto exact = json["coordinates"][locality][i][k].get<double>();
                        errors[n] = larger(errors[n], std::fabs(weights.rows[i][k] - exact));
                    }
                }
            }
            CAPTURE(name, locality, errors[0], errors[1]);
            CHECK(errors[1] <= 1e-4);
            CHECK(errors[1] <= (std::max)(errors[0] / 4, 3e-6));
        }
    }
}

TEMPLATE_TEST_CASE("local harmonic weights are never negative, sum to 1 and reproduce the point",
                   "[coordinates][harmonic][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(6, 2)));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_cage(Polygon<T>(random_star<T>(std::uint64_t(seed))), random);
    check_cage(random_mesh(std::uint64_t(seed)).template mesh<T>(), random);
    // Cells inside: a point, a chain, a wall between two corners.
    CellComplex<T, 2> complex(Polygon<T>(Points2<T>{{0, 0}, {T(random.uniform(0.7, 2)), 0}, {1, 1}, {0, 1}}));
    (void)complex.add_point(Vec<T, 2>{T(random.uniform(0.2, 0.4)), T(0.7)}, T(0.01));
    (void)complex.add_chain(
        Points2<T>{{T(0.3), T(0.2)}, {T(0.5), T(random.uniform(0.1, 0.5))}, {T(0.6), T(0.3)}});
    check_cage(complex, random);
}

TEST_CASE("faces of any shape have local harmonic weights", "[coordinates][harmonic][polyhedral]") {
    // Differences reach the boundary, where rows of planar faces have the error of their solver.
    constexpr double limit = 1e12;
    Random random{3};
    check_cage(l_prism().cage<double>(), random, limit);
    check_cage(random_prism(3).cage<double>(), random, limit);
}

TEST_CASE("a larger locality concentrates the weights of the cat", "[coordinates][harmonic]") {
    // Not a theorem: it holds for the mean of Σ w² over a cage with limbs.
    const auto cage = read_oracle("harmonic2d_cat").cage<double>();
    Random random{1};
    const auto points = points_inside(cage, 64, random);
    double before = 0;
    for (const double locality : {0.0, 10.0, 20.0, 40.0}) {
        const HarmonicCoordinates coordinates(cage, {.accuracy = 0.01, .locality = locality});
        double squares = 0;
        for (const auto& row : evaluate_all(coordinates, points).rows) {
            for (const double w : row) squares += w * w;
        }
        CAPTURE(locality);
        CHECK(squares > before);
        before = squares;
    }
}

TEST_CASE("local harmonic weights do not depend on the unit of length, nor on when functions are solved",
          "[coordinates][harmonic][property]") {
    Random random{7};
    const auto star = random_star<double>(7);
    const HarmonicOptions options{.accuracy = 0.01, .locality = 25};
    HarmonicCoordinates coordinates(star, options);
    auto points = points_inside(coordinates.cage(), 40, random);
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(coordinates.solve().status == Status::ok);
    const auto kept = evaluate_all(coordinates, points);
    for (std::size_t i = 0; i < points.size(); ++i) // kept functions leave out small values
        CHECK(difference(weights.rows[i], kept.rows[i]) <= 0.1 * options.accuracy);
    auto larger_star = star;
    const double scale = std::ldexp(1.0, 20);
    for (auto& v : larger_star) v = scale * v;
    for (auto& p : points) p = scale * p;
    CHECK(evaluate_all(HarmonicCoordinates(larger_star, options), points).rows == weights.rows);
}

TEST_CASE("local harmonic weights are accurate where all functions are small", "[coordinates][harmonic]") {
    // In the middle of a square the largest function is 7e-7; by symmetry all weights are equal.
    const Points2<double> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, middle{{0.5, 0.5}};
    HarmonicOptions options{.locality = 40};
    CHECK(difference(evaluate_all(HarmonicCoordinates(square, options), middle).rows[0],
                     std::vector<double>(4, 0.25)) <= 1e-4);
    options.resolution = 80;
    const HarmonicCoordinates<double, 2> uniform(square, options, cageform::UniformGrid{});
    CHECK(difference(evaluate_all(uniform, middle).rows[0], std::vector<double>(4, 0.25)) <= 1e-4);
    options.resolution = 50;
    HarmonicCoordinates<double, 2> coarse(square, options, cageform::UniformGrid{});
    const auto [status, solver] = coarse.solve();
    CHECK(status == Status::grid_too_coarse);
    CHECK(solver.sufficient_resolution == 57); // 2 κ
}

TEST_CASE("gradients on the boundary of the cage are those inside", "[coordinates][harmonic]") {
    const auto cage = read_oracle("harmonic2d_l_shape").cage<double>();
    const HarmonicCoordinates coordinates(cage, {.accuracy = 1e-3, .locality = 20});
    const auto corner = cage[0], next = cage[1];
    Points2<double> points;
    for (const double t : {0.2, 0.5, 0.8}) points.push_back(corner + t * (next - corner));
    const auto gradients = gradients_of<double, 2>(coordinates, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(gradients.states[i] == PointState::on_boundary);
        Vec<double, 2> moved{};
        for (std::size_t k = 0; k < cage.size(); ++k) moved = moved + gradients.rows[i][k][0] * cage[k];
        CHECK(distance(moved, Vec<double, 2>{1, 0}) <= 1e-6);
    }
}

TEST_CASE("a locality out of range is refused, and stored functions of another locality too",
          "[coordinates][harmonic]") {
    const Points2<double> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const auto status_of = [&](double locality, auto solver) {
        constexpr bool is_uniform = std::is_same_v<decltype(solver), cageform::UniformGrid>;
        const HarmonicOptions options{
            .accuracy = 0.05, .resolution = is_uniform ? 64u : 0u, .locality = locality};
        HarmonicCoordinates<double, 2> coordinates(square, options, solver);
        return coordinates.solve().status;
    };
    for (const double wrong :
         {-1e-9, 40.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        CHECK(status_of(wrong, cageform::AdaptiveGrid{}) == Status::locality_not_supported);
        CHECK(status_of(wrong, cageform::UniformGrid{}) == Status::locality_not_supported);
    }
    CHECK(status_of(HarmonicOptions::most_locality, cageform::UniformGrid{}) == Status::ok);
    HarmonicCoordinates<double, 2> local(square, {.accuracy = 0.05, .locality = 20});
    const auto saved = local.save_solution();
    REQUIRE(saved);
    Aligned memory(saved.value);
    for (const double locality : {0.0, 10.0, 20.0}) {
        HarmonicCoordinates<double, 2> reader(square, {.accuracy = 0.05, .locality = locality});
        CHECK(reader.load_solution(memory.bytes()).status ==
              (locality == 20 ? Status::ok : Status::blob_of_another_grid));
        if (locality == 20)
            CHECK(evaluate_all(reader, Points2<double>{{0.4, 0.3}}).rows ==
                  evaluate_all(local, Points2<double>{{0.4, 0.3}}).rows);
    }
}

} // namespace local_harmonic_tests
