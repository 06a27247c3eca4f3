// Maximum entropy coordinates: reference values of 70 digits, laws on random cages, and the solver's descent.
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/points_inside.hpp"
#include "../support/polyhedra.hpp"

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/maximum_entropy.hpp>
#include <cageform/coordinates/project.hpp>

namespace maximum_entropy_tests {

using namespace cageform_tests;
using cageform::EntropyPrior;
using cageform::epsilon;
using cageform::Polygon;
using cageform::project;
using cageform::TriangleMesh;

namespace {

template <class T, std::size_t D>
using Entropy = cageform::MaximumEntropyCoordinates<T, D>;

template <class T, std::size_t D>
std::vector<Vec<T, D>> points_of(const nlohmann::json& list) {
    std::vector<Vec<T, D>> points;
    for (const auto& p : list) {
        for (std::size_t k = 0; k < D; ++k)
            (k == 0 ? points.emplace_back() : points.back())[k] = T(p[k].template get<double>());
    }
    return points;
}

/// Compares weights and gradients with those of a file.
template <class T, std::size_t D, class C>
void compare(const C& coordinates, const nlohmann::json& json, const char* key) {
    const auto points = points_of<T, D>(json["points"]);
    REQUIRE(points.size() >= 14);
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const auto gradients = gradients_of<T, D>(coordinates, points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::string tag = json["point_tags"][i];
        CAPTURE(key, i, tag);
        if (tag.starts_with("on_")) CHECK(weights.states[i] == PointState::on_boundary);
        if (tag == "inside" || tag.find("0.001") != tag.npos) CHECK(weights.states[i] == PointState::inside);
        for (std::size_t k = 0; k < weights.rows[i].size(); ++k) {
            const auto expected = json["coordinates"][key][i][k].template get<double>();
            CHECK(std::fabs(double(weights.rows[i][k]) - expected) <= (sizeof(T) == 8 ? 1e-14 : 1e-5));
        }
        if (tag != "inside") continue;
        const auto& row = json["gradients"][key][inside++];
        double largest = 0, error = 0;
        for (std::size_t k = 0; k < weights.rows[i].size(); ++k) {
            for (std::size_t axis = 0; axis < D; ++axis) {
                const auto expected = row[axis][k].template get<double>();
                largest = larger(largest, std::fabs(expected));
                error = larger(error, std::fabs(double(gradients.rows[i][k][axis]) - expected));
            }
        }
        CHECK(error <= largest * (sizeof(T) == 8 ? 1e-11 : 1e-6));
    }
    CHECK(inside > 0);
}

nlohmann::json read_case(const std::string& name) {
    return read_json("../positive/" + name);
}

/// Checks the laws that hold for every cage: 0 ≤ w, Σ w = 1, Σ w C = p, before anything restores them.
template <class T, std::size_t D, class Cage, class C>
void check_laws(const Cage& cage, const C& coordinates, Random& random) {
    REQUIRE(coordinates.cage_report().status == Status::ok);
    const auto points = points_inside(cage, effort<std::size_t>(64, 16), random);
    if (points.empty()) return; // a thin cage
    const auto weights = evaluate_all(coordinates, points);
    const auto bounds = cageform::bounds_of(cage.vertices());
    const double size = double(bounds.diagonal()), rounding = double(epsilon<T>);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1]);
        CHECK((weights.states[i] == PointState::inside || weights.states[i] == PointState::on_boundary));
        double least = 1;
        for (const T w : weights.rows[i]) least = std::fmin(least, double(w));
        CHECK(least >= 0);
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= 32 * rounding);
        CHECK(distance(combine(weights.rows[i], cage.vertices()), points[i]) <=
              32 * rounding * (size + double(bounds.magnitude())));
    }
}

/// A star with a star-shaped hole.
template <class T>
Polygon<T> star_with_hole(std::uint64_t seed) {
    Points2<T> outer = random_star<T>(seed), hole;
    Vec<T, 2> centre{};
    for (const auto& v : outer) centre = centre + T(1.0 / double(outer.size())) * v;
    for (const auto& v : random_star<T>(seed)) hole.push_back(centre + T(0.3) * (v - centre));
    const std::size_t count = outer.size();
    outer.insert(outer.end(), hole.rbegin(), hole.rend());
    return {outer, std::vector<std::size_t>{count, count}};
}

/// A random mesh, with its copies: one in a cavity or one beside it.
MeshData random_shells(std::uint64_t seed) {
    MeshData data = random_mesh(seed);
    const std::size_t count = data.vertices.size(), faces = data.faces.size();
    const auto bounds = cageform::bounds_of(std::span<const Vec<double, 3>>(data.vertices));
    const Vec<double, 3> centre = 0.5 * (bounds.lower + bounds.upper);
    const bool is_cavity = seed % 4 != 3; // else a torus
    for (std::size_t k = 0; k < count; ++k) {
        auto copy = data.vertices[k];
        if (is_cavity)
            copy = centre + 0.4 * (copy - centre);
        else
            copy[0] += 1.1 * (bounds.upper[0] - bounds.lower[0]);
        data.vertices.push_back(copy);
    }
    for (std::size_t f = 0; f < faces; ++f) {
        auto face = data.faces[f];
        for (auto& k : face) k += int(count);
        if (is_cavity) std::swap(face[0], face[1]);
        data.faces.push_back(face);
    }
    return data;
}

/// Checks that rows at a distance of 1e-12 diagonals from facets are close to barycentric rows.
template <std::size_t D, class Cage>
void check_facets(const Cage& cage, Random& random) {
    const Entropy<double, D> coordinates(cage);
    const double size = double(cageform::bounds_of(cage.vertices()).diagonal());
    for (const auto& p : points_inside(cage, 16, random)) {
        std::vector<double> hats(cage.size());
        const auto place = coordinates.nearest_boundary(p, hats);
        const std::vector beside{place + (1e-12 * size / (1e-12 * size + distance(p, place))) * (p - place)};
        const auto weights = evaluate_all(coordinates, beside);
        // Small facets have slopes of up to 500 per diagonal; the median difference is 4e-12.
        CHECK(difference(weights.rows[0], hats) <= 1e-9);
    }
}

} // namespace

TEMPLATE_TEST_CASE("maximum entropy weights and gradients are those of the references",
                   "[coordinates][entropy][oracle]", CAGEFORM_SCALARS) {
    using T = TestType;
    for (const char* name :
         {"biped", "cat", "hexagon_triangle_hole", "l_shape", "square_extra_vertex", "star", "unit_square"}) {
        CAPTURE(name);
        const auto json = read_case(std::string("positive2d_") + name);
        std::vector<std::size_t> sizes;
        for (const auto& loop : json["cage"]["loops"]) sizes.push_back(loop.size());
        const Polygon<T> cage(points_of<T, 2>(json["cage"]["vertices"]), sizes);
        compare<T, 2>(Entropy<T, 2>(cage), json, "maximum_entropy_mean_value_1.5");
        compare<T, 2>(Entropy<T, 2>(cage, EntropyPrior::mec1), json, "maximum_entropy_1");
        compare<T, 2>(Entropy<T, 2>(cage, EntropyPrior::mec2), json, "maximum_entropy_2");
    }
    for (const char* name :
         {"cube", "cube_cavity", "l_prism", "l_prism_turned", "octahedron", "spike", "tetrahedron"}) {
        CAPTURE(name);
        const auto json = read_case(std::string("positive3d_") + name);
        std::vector<std::array<int, 3>> faces;
        for (const auto& f : json["cage"]["faces"]) faces.push_back({f[0], f[1], f[2]});
        const TriangleMesh<T> cage(points_of<T, 3>(json["cage"]["vertices"]), faces);
        compare<T, 3>(Entropy<T, 3>(cage), json, "maximum_entropy_mean_value_1.5");
    }
}

TEMPLATE_TEST_CASE("maximum entropy weights are never negative, sum to 1 and reproduce the point",
                   "[coordinates][entropy][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(50, 8)));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const Polygon<T> star(random_star<T>(std::uint64_t(seed)));
    for (const auto prior : {EntropyPrior::facing, EntropyPrior::mec1, EntropyPrior::mec2})
        check_laws<T, 2>(star, Entropy<T, 2>(star, prior), random);
    const auto hollow = star_with_hole<T>(std::uint64_t(seed));
    if (Entropy<T, 2>(hollow).cage_report().status == Status::ok)
        check_laws<T, 2>(hollow, Entropy<T, 2>(hollow), random);
    for (const auto& data : {random_mesh(std::uint64_t(seed)), random_shells(std::uint64_t(seed))}) {
        const auto mesh = data.template mesh<T>();
        check_laws<T, 3>(mesh, Entropy<T, 3>(mesh), random);
        if constexpr (sizeof(T) == 8) check_facets<3>(mesh, random);
    }
    if constexpr (sizeof(T) == 8) check_facets<2>(star, random);
}

TEST_CASE("maximum entropy weights of a simplex are barycentric, and do not depend on the unit of length",
          "[coordinates][entropy][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto check_simplex = [&]<std::size_t D>(const auto& cage, const auto& corners) {
        const auto points = points_inside(cage, 16, random);
        const auto weights = evaluate_all(Entropy<double, D>(cage), points);
        const auto expected = evaluate_all(cageform::BarycentricCoordinates<double, D>(corners), points);
        for (std::size_t i = 0; i < points.size(); ++i)
            CHECK(difference(weights.rows[i], expected.rows[i]) <= 1e-13);
    };
    Points2<double> triangle(3);
    for (auto& v : triangle) v = {random.uniform(-1, 1), random.uniform(-1, 1)};
    check_simplex.template operator()<2>(Polygon<double>(triangle), triangle);
    Points3<double> corners(4);
    for (auto& v : corners) v = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const TriangleMesh<double> tetrahedron(
        corners, std::vector<std::array<int, 3>>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
    check_simplex.template operator()<3>(tetrahedron, corners);

    const double scale = std::ldexp(1.0, int(random.below(40)) - 20);
    auto star = random_star<double>(std::uint64_t(seed)), larger_star = star;
    for (auto& v : larger_star) v = scale * v;
    const Polygon<double> cage(star), larger_cage(larger_star);
    auto points = points_inside(cage, 16, random);
    const auto weights = evaluate_all(Entropy<double, 2>(cage), points);
    for (auto& p : points) p = scale * p;
    const auto same = evaluate_all(Entropy<double, 2>(larger_cage), points);
    CHECK(weights.rows == same.rows);
}

TEMPLATE_TEST_CASE("gradients of maximum entropy weights on and next to the boundary keep the laws",
                   "[coordinates][entropy][gradients]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(10, 3)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 60);
    const auto check = [&]<std::size_t D>(const auto& cage, const std::vector<Vec<T, D>>& points) {
        const auto gradients = gradients_of<T, D>(Entropy<T, D>(cage), points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(D, i);
            CHECK((gradients.states[i] == PointState::on_boundary ||
                   gradients.states[i] == PointState::inside));
            // 1e-6 diagonals inside, K has an eigenvalue of about 1e-6.
            CHECK(law_error<T, D>(cage.vertices(), points[i], gradients.rows[i]) <=
                  (sizeof(T) == 8 ? 1e-8 : 2e-5));
        }
    };
    const auto mesh = random_mesh(std::uint64_t(seed)).template mesh<T>();
    std::vector<Vec<T, 3>> in_space;
    for (int n = 0; n < 60; ++n) { // on faces, edges and vertices
        const auto& face = mesh.faces()[random.below(mesh.faces().size())];
        const double u = n % 3 == 2 ? 0.0 : random.uniform(0, 1);
        const double v = n % 3 == 0 ? random.uniform(0, 1 - u) : 0.0;
        in_space.push_back(mesh[face[0]] + T(u) * (mesh[face[1]] - mesh[face[0]]) +
                           T(v) * (mesh[face[2]] - mesh[face[0]]));
    }
    check.template operator()<3>(mesh, in_space);
    const Polygon<T> star(random_star<T>(std::uint64_t(seed)));
    std::vector<Vec<T, 2>> in_plane;
    for (std::size_t k = 0; k < star.size(); ++k) {
        in_plane.push_back(star[k]);
        in_plane.push_back(star[k] + T(random.uniform(0, 1)) * (star[(k + 1) % star.size()] - star[k]));
    }
    check.template operator()<2>(star, in_plane);
}

TEST_CASE("maximum entropy weights of faces of any shape are continuous and not negative",
          "[coordinates][entropy][polyhedral]") {
    const int seed = GENERATE(seeds(effort(10, 3)));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    for (const auto& data : {l_prism(), random_prism(std::uint64_t(seed))}) {
        const auto cage = data.cage<double>();
        const cageform::MaximumEntropyCoordinates coordinates(cage);
        REQUIRE(coordinates.cage_report().status == Status::ok);
        check_laws<double, 3>(cage, coordinates, random);
        const double size = double(cageform::bounds_of(cage.vertices()).diagonal());
        Points3<double> on, beside;
        for (const auto& p : points_inside(cage, 40, random)) {
            Vec<double, 3> place;
            (void)cageform::nearest_boundary_value(cage, p, place);
            on.push_back(place);
            beside.push_back(place + (1e-9 * size / (1e-12 + distance(p, place))) * (p - place));
        }
        const auto rows = evaluate_all(coordinates, on), rows_beside = evaluate_all(coordinates, beside);
        for (std::size_t i = 0; i < on.size(); ++i) {
            if (rows_beside.states[i] != PointState::inside) continue;
            CHECK(*std::min_element(rows.rows[i].begin(), rows.rows[i].end()) >= 0);
            CHECK(difference(rows.rows[i], rows_beside.rows[i]) <= 1e-6);
        }
    }
}

TEST_CASE("points outside, in holes and in cavities have no maximum entropy weights",
          "[coordinates][entropy]") {
    const auto json = read_case("positive2d_hexagon_triangle_hole");
    const Polygon<double> cage(points_of<double, 2>(json["cage"]["vertices"]),
                               std::vector<std::size_t>{6, 3});
    const auto weights =
        evaluate_all(Entropy<double, 2>(cage), Points2<double>{{0, 0}, {9, 9}, {-2, 0}, {0, 1e6}});
    CHECK(weights.states ==
          std::vector{PointState::outside, PointState::outside, PointState::inside, PointState::outside});
    STATIC_REQUIRE(!Entropy<double, 2>::has_extension);
    STATIC_REQUIRE(cageform::GradientCoordinates<Entropy<float, 3>>);
}

TEMPLATE_TEST_CASE("a projected row is not negative, reproduces its point, and needs at most 60 passes",
                   "[coordinates][entropy][solver]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(300, 40)));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const std::size_t count = 5 + random.below(60);
    std::vector<Vec<T, 3>> handles(count);
    std::vector<T> prior(count), weights(count, T(7));
    Vec<T, 3> p{};
    double sum = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double size = std::pow(10.0, random.uniform(-2, 0));
        for (T& x : handles[k].v) x = T(size * random.uniform(-1, 1) + 3);
        prior[k] = T(std::pow(10.0, random.uniform(sizeof(T) == 8 ? -20 : -10, 0)));
        const double share = random.uniform(0.05, 1);
        p = p + T(share) * handles[k];
        sum += share;
    }
    p = T(1 / sum) * p; // well inside the hull
    const auto u = [&](std::size_t k) { return handles[k] - p; };
    cageform::detail::EntropySolver<T, 3, decltype(u)> solver(prior, u, weights);
    CHECK(solver.solve(0, false) == 1);
    CHECK(solver.passes() <= 60);
    REQUIRE(project<T, 3>(prior, handles, p, weights) == Status::ok);
    CHECK(*std::min_element(weights.begin(), weights.end()) >= 0);
    CHECK(std::fabs(double(sum_of(weights)) - 1) <= 32 * double(epsilon<T>));
    CHECK(distance(combine(weights, handles), p) <= 32 * double(epsilon<T>) * 4);
    std::vector<T> again(count); // a row that reproduces its point is kept
    REQUIRE(project<T, 3>(weights, handles, p, again) == Status::ok);
    // Rounding errors grow with the condition of the handles' covariance.
    CHECK(difference(weights, again) <= 512 * double(epsilon<T>));
    const Vec<T, 3> outside{T(9), 3, 3};
    CHECK(project<T, 3>(prior, handles, outside, weights) == Status::point_not_surrounded);
}

TEST_CASE("a projection refuses what has no weights", "[coordinates][entropy][solver]") {
    const Points2<double> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> weights(4, 7);
    const auto refused = [&](std::vector<double> prior, Vec<double, 2> p) {
        const Status status = project<double, 2>(prior, square, p, weights);
        CHECK(weights == std::vector<double>(4, 7));
        return status;
    };
    CHECK(refused({1, 1, 1}, {0.5, 0.5}) == Status::weights_do_not_match);
    CHECK(refused({1, 1, -1, 1}, {0.5, 0.5}) == Status::weights_not_positive);
    CHECK(refused({1, 1, nan, 1}, {0.5, 0.5}) == Status::weights_not_positive);
    CHECK(refused({0, 0, 0, 0}, {0.5, 0.5}) == Status::weights_not_positive);
    CHECK(refused({1, 1, 1, 1}, {nan, 0.5}) == Status::value_not_finite);
    CHECK(refused({1, 1, 0, 0}, {0.5, 0.5}) == Status::point_not_surrounded);
    CHECK(refused({1, 1, 1, 1}, {2, 0.5}) == Status::point_not_surrounded);
    CHECK(project<double, 2>(std::vector<double>{1, 1, 1, 1}, square, {0.25, 0.5}, weights) == Status::ok);
    CHECK(difference(weights, std::vector<double>{0.375, 0.125, 0.125, 0.375}) <= 1e-15);
}

} // namespace maximum_entropy_tests
