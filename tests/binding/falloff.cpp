// Falloff: displacements outside decrease with the distance from the cage.
#include "../catch.hpp"
#include "../support/bindings.hpp"
#include "../support/effort.hpp"
#include "../support/figures.hpp"
#include "../support/uniform_harmonic.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/clone/folds.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>

#include <cstring>

namespace falloff_tests {

using namespace cageform_tests;
using cageform::bind_vectors;
using cageform::epsilon;
using cageform::OutsidePoints;
using cageform::Polygon;

namespace {

template <class T, std::size_t D>
using Bary = cageform::BarycentricCoordinates<T, D>;
template <class T, std::size_t D>
using Mean = cageform::MeanValueCoordinates<T, D>;
template <class T, std::size_t D>
using Green = cageform::GreenCoordinates<T, D>;
template <class T, std::size_t D>
using Lattice = cageform::LatticeCoordinates<T, D>;
template <class T>
using Curved = cageform::CurvedGreenCoordinates<T>;
template <class T, std::size_t D>
using Sibson = cageform::SibsonCoordinates<T, D>;
template <class T>
using Harmonic = cageform_tests::UniformHarmonic<T, 2>;

/// A lattice with axes of different lengths, not orthogonal.
template <class T, std::size_t D>
Lattice<T, D> random_lattice(std::uint64_t seed, T falloff = 0) {
    Random random(seed);
    cageform::Transform<T, D> box{};
    std::array<cageform::LatticeAxis, D> axes;
    for (std::size_t k = 0; k < D; ++k) {
        axes[k] = {3 + random.below(3), 1 + random.below(3), {}};
        for (std::size_t a = 0; a < D; ++a)
            box.columns[k][a] = T((a == k ? 1 + double(k) : 0) + random.uniform(-0.3, 0.3));
        box.translation[k] = T(random.uniform(-2, 2));
    }
    return Lattice<T, D>(axes, box, falloff);
}

/// Coordinates of a type for a random cage.
template <class C>
C random_coordinates(std::uint64_t seed) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    if constexpr (std::is_same_v<C, Bary<T, D>>) {
        return C(random_simplex<T, D>(seed));
    } else if constexpr (requires(C c) { c.box(); }) {
        return random_lattice<T, D>(seed);
    } else if constexpr (std::is_same_v<C, Sibson<T, D>>) {
        return C(cageform::PointSet<T, D>(random_points<T, D>(20, 1, seed)));
    } else if constexpr (std::is_same_v<C, Curved<T>>) {
        return C(cageform::CurvedPolygon<T>(Polygon<T>(random_star<T>(seed))));
    } else if constexpr (D == 2) {
        return C(Polygon<T>(random_star<T>(seed)));
    } else {
        return C(random_mesh(seed).template mesh<T>());
    }
}

/// A random cage, points around it including the handles, and a pose.
template <class C>
struct Scene {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

    C coordinates;
    std::vector<Vec<T, D>> points, pose;
    double size;

    Scene(std::uint64_t seed, int count)
        : coordinates(random_coordinates<C>(seed))
        , points(corners_of(coordinates)) {
        const auto bounds = cageform::bounds_of(std::span<const Vec<T, D>>(points));
        size = double(bounds.diagonal());
        Random random(seed + 77);
        for (int n = 0; n < count; ++n) {
            Vec<T, D> p;
            for (std::size_t k = 0; k < D; ++k)
                p[k] = T(double(bounds.lower[k]) - 0.6 * size +
                         random.uniform(0, 1) * (double(bounds.upper[k] - bounds.lower[k]) + 1.2 * size));
            points.push_back(p);
        }
        pose = shaken(coordinates.handles(), 0.2 * size, seed + 5);
    }

    /// The distance from the nearest point of the boundary, with its rounding.
    double distance_of(const Vec<T, D>& p) const {
        std::vector<T> row(coordinates.handles().size());
        return distance(p, coordinates.nearest_boundary(p, row));
    }
    /// Returns the rounding of distances, in units of the falloff.
    double rounding(double falloff) const {
        double largest = size;
        for (const auto& p : points) largest = std::max(largest, distance(p, Vec<T, D>{}));
        return 32 * double(epsilon<T>) * largest / falloff;
    }
};

double kept_at(double x) {
    return x < 1 ? (1 - x) * (1 - x) * (1 + 2 * x) : 0;
}

template <class T, std::size_t D>
bool same_bits(const Vec<T, D>& a, const Vec<T, D>& b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

/// The policies with weights outside.
template <class C>
std::vector<OutsidePoints> policies() {
    if (!C::has_extension) return {OutsidePoints::nearest_boundary};
    return {OutsidePoints::extend, OutsidePoints::nearest_boundary};
}

} // namespace

TEMPLATE_TEST_CASE(
    "weights outside are multiplied by the falloff, and those inside are unchanged bit for bit",
    "[binding][falloff]", (Mean<float, 2>), (Mean<double, 2>), (Mean<float, 3>), (Mean<double, 3>),
    (Green<float, 2>), (Green<double, 3>), (Lattice<double, 2>), (Lattice<float, 3>), (Bary<double, 3>),
    (Bary<float, 1>), Curved<double>, Harmonic<float>, Harmonic<double>, (Sibson<double, 2>),
    (Sibson<float, 3>)) {
    using T = typename TestType::scalar;
    const auto seed = std::uint64_t(GENERATE(seeds(effort(6, 2))));
    CAPTURE(seed);
    const Scene<TestType> scene(seed, 60);
    const double falloff = scene.size * (seed % 2 == 0 ? 0.3 : 0.05), rounding = scene.rounding(falloff);
    for (const auto policy : policies<TestType>()) {
        CAPTURE(int(policy));
        const auto plain = cageform::bind(scene.coordinates, scene.points, {.outside = policy});
        const auto faded =
            cageform::bind(scene.coordinates, scene.points, {.outside = policy, .falloff = falloff});
        REQUIRE(plain.report.status == Status::ok);
        REQUIRE(faded.report.status == Status::ok);
        REQUIRE(faded.report.outside.size() > 10);
        CHECK(faded.report.outside == plain.report.outside);
        CHECK(faded.report.on_boundary == plain.report.on_boundary);
        CHECK(faded.report.unreached == plain.report.unreached);
        CHECK(plain.report.faded.empty());
        CHECK(faded.report.partition_error.value <= plain.report.partition_error.value);
        CHECK(faded.report.reproduction_error.value <= plain.report.reproduction_error.value);
        const auto moved = cloned(faded.value, scene.pose), unfaded = cloned(plain.value, scene.pose);
        double least = 1, amplification = 0;
        std::vector<std::size_t> within;
        for (std::size_t i = 0; i < scene.points.size(); ++i) {
            CAPTURE(i);
            const auto &list = faded.report.outside, &fading = faded.report.faded;
            const bool is_outside = std::binary_search(list.begin(), list.end(), i);
            const double x = is_outside ? scene.distance_of(scene.points[i]) / falloff : 0;
            const bool is_still = is_outside && !std::binary_search(fading.begin(), fading.end(), i);
            if (std::fabs(x - 1) > rounding) CHECK(is_still == (x >= 1));
            double sizes = 0, of_plain = 0;
            for (std::size_t h = 0; h < scene.pose.size(); ++h) {
                const T w = plain.value.weight(i, h), v = faded.value.weight(i, h);
                sizes += std::fabs(double(v));
                of_plain += std::fabs(double(w));
                if (sizes > 0) least = std::min(least, double(v));
                if (!is_outside) CHECK(std::memcmp(&w, &v, sizeof(T)) == 0);
                if (is_still) CHECK(v == T(0));
                if (is_outside)
                    CHECK(std::fabs(double(v) - kept_at(x) * double(w)) <=
                          2 * rounding * std::fabs(double(w)));
            }
            amplification = std::max(amplification, sizes);
            if (!is_outside) CHECK(same_bits(moved[i], unfaded[i]));
            if (is_still) CHECK(same_bits(moved[i], scene.points[i]));
            // Continuous across the boundary, with its slope: f is 1 − 3x² + 2x³.
            if (is_outside)
                CHECK(distance(moved[i], unfaded[i]) <=
                      (3 * x * x + 4 * rounding) * of_plain * 0.35 * scene.size + rounding * falloff);
        }
        CHECK(std::fabs(faded.report.amplification.value - amplification) <=
              1e-5 * std::max(1.0, amplification));
        CHECK(faded.report.least_weight.value <= least + 1e-5);
        const auto rest = cloned(faded.value, scene.coordinates.handles());
        for (std::size_t i = 0; i < rest.size(); ++i) CHECK(same_bits(rest[i], scene.points[i]));
    }
}

TEMPLATE_TEST_CASE("a falloff of any length is continuous at the boundary", "[binding][falloff]",
                   (Mean<double, 2>), (Mean<float, 3>), (Green<double, 2>), (Lattice<double, 3>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const Scene<TestType> scene(seed, 40);
    const auto listed = cageform::bind(scene.coordinates, scene.points).report.outside;
    std::vector<Vec<T, D>> feet, before;
    std::vector<double> steps;
    std::vector<T> row(scene.pose.size());
    for (const std::size_t i : listed) {
        const auto& p = scene.points[i];
        const auto foot = scene.coordinates.nearest_boundary(p, row);
        for (const double part : {1e-2, 1e-4, 1e-6}) {
            feet.push_back(foot);
            before.push_back(foot + T(part) * (p - foot));
            steps.push_back(distance(before.back(), foot));
        }
    }
    // Points on the boundary have no falloff; the difference grows with the squared distance.
    for (const double falloff : {1e-2 * scene.size, scene.size, 1e200}) {
        const cageform::BindOptions options{.falloff = falloff};
        const auto at = cloned(cageform::bind(scene.coordinates, feet).value, scene.pose);
        const auto faded_at = cloned(cageform::bind(scene.coordinates, feet, options).value, scene.pose);
        const auto off = cageform::bind(scene.coordinates, before);
        const auto faded = cloned(cageform::bind(scene.coordinates, before, options).value, scene.pose);
        const auto unfaded = cloned(off.value, scene.pose);
        const double most = 0.35 * scene.size * off.report.amplification.value,
                     rounding = scene.rounding(falloff);
        for (std::size_t n = 0; n < feet.size(); ++n) {
            CAPTURE(n, falloff, steps[n]);
            const double x = steps[n] / falloff;
            CHECK(distance(faded_at[n], at[n]) <= 3 * rounding * rounding * most);
            CHECK(distance(faded[n], unfaded[n]) <=
                  3 * (x + rounding) * (x + rounding) * most + 8 * double(epsilon<T>) * most);
            if (falloff > 1e100) CHECK(same_bits(faded[n], unfaded[n]));
        }
    }
}

TEMPLATE_TEST_CASE("vectors outside equal differences of clones with falloff", "[binding][falloff][vectors]",
                   (Mean<double, 2>), (Mean<double, 3>), (Green<double, 2>), (Green<double, 3>),
                   (Lattice<double, 2>), (Lattice<double, 3>), (Bary<double, 3>), Curved<double>) {
    constexpr std::size_t D = TestType::dimension;
    const auto seed = std::uint64_t(GENERATE(seeds(effort(5, 1))));
    CAPTURE(seed);
    const Scene<TestType> scene(seed, 150);
    const double falloff = 0.4 * scene.size, step = 1e-5 * scene.size;
    const cageform::BindOptions options{.falloff = falloff};
    const auto vectors = random_points<double, D>(scene.points.size(), 1, seed);
    const auto [binding, report] = bind_vectors(scene.coordinates, scene.points, vectors, options);
    REQUIRE(report.status == Status::ok);
    CHECK(report.faded == cageform::bind(scene.coordinates, scene.points, options).report.faded);
    CHECK(report.outside.size() > report.faded.size());
    const auto moved = cloned(binding, scene.pose);
    std::vector<Vec<double, D>> ahead, behind;
    for (std::size_t i = 0; i < scene.points.size(); ++i) {
        ahead.push_back(scene.points[i] + step * vectors[i]);
        behind.push_back(scene.points[i] - step * vectors[i]);
    }
    const auto a = cloned(cageform::bind(scene.coordinates, ahead, options).value, scene.pose);
    const auto b = cloned(cageform::bind(scene.coordinates, behind, options).value, scene.pose);
    std::size_t compared = 0;
    for (const std::size_t i : report.outside) {
        const double x = scene.distance_of(scene.points[i]) / falloff;
        if (x < 0.1 || std::fabs(x - 1) < 0.05) continue; // higher derivatives are large or discontinuous
        // Between two parts of the cage the distance has a ridge.
        const auto n = cageform::detail::outside_distance(scene.coordinates, ahead[i]).gradient;
        const auto m = cageform::detail::outside_distance(scene.coordinates, behind[i]).gradient;
        if (distance(n, m) > 1e-2) continue;
        ++compared;
        CAPTURE(i, x);
        CHECK(distance(moved[i], (0.5 / step) * (a[i] - b[i])) <= 2e-5);
        if (x >= 1) CHECK(same_bits(moved[i], vectors[i]));
    }
    CHECK(compared > 20);
}

TEMPLATE_TEST_CASE("vectors with nearest_boundary have a falloff", "[binding][falloff][vectors]",
                   (Mean<double, 2>), (Mean<double, 3>), (Lattice<double, 2>)) {
    constexpr std::size_t D = TestType::dimension;
    const auto seed = std::uint64_t(GENERATE(seeds(effort(3, 1))));
    CAPTURE(seed);
    const Scene<TestType> scene(seed, 60);
    const double falloff = 0.4 * scene.size;
    const cageform::BindOptions options{.outside = OutsidePoints::nearest_boundary, .falloff = falloff};
    const auto vectors = random_points<double, D>(scene.points.size(), 1, seed);
    const auto [binding, report] = bind_vectors(scene.coordinates, scene.points, vectors, options);
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.faded.size() > 5);
    const auto moved = cloned(binding, scene.pose);
    std::vector<Vec<double, D>> feet;
    std::vector<double> row(scene.pose.size());
    for (const auto& p : scene.points) feet.push_back(scene.coordinates.nearest_boundary(p, row));
    const auto turned = cloned(bind_vectors(scene.coordinates, feet, vectors).value, scene.pose);
    const auto shifted = cloned(cageform::bind(scene.coordinates, feet).value, scene.pose);
    for (const std::size_t i : report.faded) {
        const auto from_cage = cageform::detail::outside_distance(scene.coordinates, scene.points[i]);
        const double x = from_cage.distance / falloff,
                     slope = -6 * x * (1 - x) / falloff * cageform::dot(from_cage.gradient, vectors[i]);
        CAPTURE(i, x);
        const auto expected =
            vectors[i] + kept_at(x) * (turned[i] - vectors[i]) + slope * (shifted[i] - feet[i]);
        CHECK(distance(moved[i], expected) <= 1e-9);
    }
}

TEMPLATE_TEST_CASE("the falloff of bind equals the falloff of a lattice", "[binding][falloff]",
                   (Lattice<float, 2>), (Lattice<double, 2>), (Lattice<float, 3>), (Lattice<double, 3>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = std::uint64_t(GENERATE(seeds(effort(5, 1))));
    CAPTURE(seed);
    const Scene<TestType> scene(seed, 80);
    const double falloff = 0.3 * scene.size;
    const auto own = random_lattice<T, D>(seed, T(falloff));
    auto pose = scene.pose;
    for (std::size_t n = own.handles().size() - own.frame_handles(); n < own.handles().size(); ++n)
        pose.push_back(own.handles()[n]);
    const auto vectors = random_points<T, D>(scene.points.size(), 1, seed);
    const cageform::BindOptions options{.falloff = double(T(falloff))};
    const auto a = cloned(cageform::bind(own, scene.points).value, pose);
    const auto b = cloned(cageform::bind(scene.coordinates, scene.points, options).value, scene.pose);
    const auto c = cloned(bind_vectors(own, scene.points, vectors).value, pose);
    const auto d = cloned(bind_vectors(scene.coordinates, scene.points, vectors, options).value, scene.pose);
    for (std::size_t i = 0; i < scene.points.size(); ++i) {
        CAPTURE(i);
        CHECK(distance(a[i], b[i]) <= 4000 * double(epsilon<T>) * scene.size);
        CHECK(distance(c[i], d[i]) <= 40000 * double(epsilon<T>));
    }
}

TEST_CASE("a shift folds the figure only beyond two thirds of the falloff", "[binding][falloff][folds]") {
    const auto seed = std::uint64_t(GENERATE(seeds(5)));
    CAPTURE(seed);
    const Scene<Mean<double, 2>> scene(seed, 4000);
    Random random(seed);
    const double falloff = 0.3 * scene.size, angle = random.uniform(0, 6.3);
    const auto axes = cageform::bind_jacobians(scene.coordinates, scene.points, {.falloff = falloff});
    REQUIRE(axes.report.status == Status::ok);
    for (const double share : {0.3, 0.66, 0.9}) {
        CAPTURE(share);
        auto pose = corners_of(scene.coordinates);
        for (auto& p : pose) p = p + share * falloff * Vec<double, 2>{std::cos(angle), std::sin(angle)};
        const auto folds = cageform::report_folds(axes.value, pose);
        REQUIRE(folds.status == Status::ok);
        CHECK((folds.count == 0) == (share < 2.0 / 3));
    }
}

TEST_CASE("the head of the cat moves without a fold if the falloff is 1.5 times the displacement",
          "[binding][falloff][folds]") {
    // A cage around the head, and cells in and around it.
    const Points2<double> head{{325, 275}, {325, 150}, {300, 50}, {250, 112.5}, {187.5, 112.5},
                               {125, 50},  {100, 175}, {50, 250}, {125, 325}};
    constexpr std::uint32_t side = 80;
    Points2<double> points;
    std::vector<std::array<std::uint32_t, 3>> cells;
    for (std::uint32_t n = 0; n < side * side; ++n) {
        points.push_back({-250 + 11.0 * (n % side), -250 + 11.0 * (n / side)});
        if (n % side + 1 == side || n / side + 1 == side) continue;
        cells.insert(cells.end(), {{n, n + 1, n + side}, {n + 1, n + side + 1, n + side}});
    }
    auto nod = head, shift = head; // by at most 81 and 71 units
    for (std::size_t i = 0; i < head.size(); ++i) {
        const auto [x, y] = std::array{head[i][0] - 230, head[i][1] - 300};
        nod[i] = {230 + std::cos(0.3) * x - std::sin(0.3) * y, 300 + std::sin(0.3) * x + std::cos(0.3) * y};
        shift[i] = shift[i] - Vec<double, 2>{50, 50};
    }
    const auto folds_of = [&](const auto& coordinates, double falloff, const auto& pose) {
        const auto bound = cageform::bind(coordinates, points, {.falloff = falloff});
        REQUIRE(bound.report.status == Status::ok);
        Points2<double> handles(coordinates.handles().size());
        REQUIRE(cageform::pose_handles(bound.value, pose, handles).status == Status::ok);
        return cageform::report_folds(points, cloned(bound.value, handles), cells).count;
    };
    for (const auto& pose : {nod, shift}) {
        const Mean<double, 2> mean_value{Polygon<double>(head)};
        const Green<double, 2> green{Polygon<double>(head)};
        CHECK(folds_of(mean_value, 240, pose) == 0);
        CHECK(folds_of(green, 240, pose) == 0);
        CHECK(folds_of(mean_value, 60, pose) > 50);
        CHECK(folds_of(green, 60, pose) > 50);
    }
}

} // namespace falloff_tests
