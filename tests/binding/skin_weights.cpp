// Skins of bindings: laws of every skin, optimality, and the correctness of
// reports.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/meshes.hpp"
#include "support/weights.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

#include <Eigen/LU>

#include <functional>
#include <map>
#include <set>

namespace skin_weights_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::BindingView;
using cageform::SkinWeights;
using cageform::SkinWeightsReport;

namespace {

using Indices = std::vector<std::size_t>;

/// A random cage of 3 to 258 vertices in 2D or 3D, and points in it.
template <class T, std::size_t D>
Binding<T, D> random_binding(std::uint64_t seed) {
    Random random(seed);
    if constexpr (D == 2) {
        const cageform::Polygon<T> cage(random_star<T>(seed));
        Points2<T> points;
        for (int i = 0; i < 40; ++i) points.push_back(random_inside(cage, random, 1e-3));
        return cageform::bind(cageform::MeanValueCoordinates<T, 2>(cage), points).value;
    } else {
        const MeshData data = random_mesh(seed);
        const cageform::MeanValueCoordinates<T, 3> coordinates(data.mesh<T>());
        Points3<double> inside;
        for (const auto& p : points_about(data, 120, seed)) {
            std::vector<T> row(data.vertices.size());
            if (weights_at(coordinates, cageform::vec_cast<T>(p), row) == PointState::inside)
                inside.push_back(p);
        }
        return cageform::bind(coordinates, inside).value;
    }
}

template <class T, std::size_t D>
double size_of(const Binding<T, D>& binding) {
    const auto view = binding.view();
    return double(cageform::bounds_of(std::span(view.rest_handles, binding.handle_count())).diagonal());
}

/// Σw(c − p) of a point, in double.
template <class T, std::size_t D>
Vec<double, D> miss(const Binding<T, D>& binding, const SkinWeights& skin, std::size_t point) {
    Vec<double, D> sum{};
    const auto p = cageform::vec_cast<double>(binding.rest_point(point));
    for (std::size_t k = 0; k < skin.influences; ++k) {
        const std::size_t at = point * skin.influences + k;
        sum = sum + double(skin.weights[at]) *
                        (cageform::vec_cast<double>(binding.rest_handle(skin.joints[at])) - p);
    }
    return sum;
}

bool contains(const Indices& list, std::size_t i) {
    return std::find(list.begin(), list.end(), i) != list.end();
}

/// Checks the laws of every skin and recomputes the numbers of its report.
template <class T, std::size_t D>
void check_skin(const Binding<T, D>& binding, const SkinWeights& skin, const SkinWeightsReport& report,
                std::size_t influences) {
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.points == binding.point_count());
    REQUIRE(skin.influences == influences);
    REQUIRE(skin.point_count() == binding.point_count());
    REQUIRE(skin.weights.size() == skin.joints.size());
    REQUIRE(report.weight_errors.size() == binding.point_count());
    cageform::Extreme error, partition, reproduction;
    double mean = 0, used_sum = 0;
    for (std::size_t i = 0; i < skin.point_count(); ++i) {
        CAPTURE(i);
        const float* const weights = skin.weights.data() + i * influences;
        const std::uint16_t* const joints = skin.joints.data() + i * influences;
        std::set<std::uint16_t> used;
        double sum = 0;
        std::vector<double> difference;
        for (std::size_t h = 0; h < binding.handle_count(); ++h)
            difference.push_back(-double(binding.weight(i, h)));
        for (std::size_t k = 0; k < influences; ++k) {
            REQUIRE(weights[k] >= 0);
            REQUIRE((k == 0 || weights[k - 1] >= weights[k]));
            REQUIRE(joints[k] < binding.handle_count());
            if (weights[k] == 0) REQUIRE(joints[k] == 0);
            if (weights[k] > 0) REQUIRE(used.insert(joints[k]).second);
            sum += double(weights[k]);
            difference[joints[k]] += double(weights[k]);
        }
        if (contains(report.without_weights, i)) {
            REQUIRE(used.empty());
            continue;
        }
        REQUIRE(std::fabs(sum - 1) <= 0x1p-25);
        double total = 0;
        for (const double d : difference) total += std::fabs(d);
        REQUIRE(std::fabs(total - double(report.weight_errors[i])) <= 1e-6 * (1 + total));
        error.raise({total, i});
        partition.raise({std::fabs(sum - 1), i});
        const auto missed = miss(binding, skin, i);
        reproduction.raise({std::sqrt(dot(missed, missed)), i});
        mean += total;
        used_sum += double(used.size());
    }
    const double bound = double(skin.point_count() - report.without_weights.size());
    if (bound == 0) return;
    CHECK(std::fabs(report.weight_error.value - error.value) <= 1e-9 * (1 + error.value));
    CHECK(std::fabs(report.partition_error.value - partition.value) <= 1e-12);
    CHECK(std::fabs(report.reproduction_error.value - reproduction.value) <=
          1e-6 * reproduction.value + 1e-12 * size_of(binding));
    CHECK(std::fabs(report.mean_weight_error - mean / bound) <= 1e-9 * (1 + mean));
    CHECK(std::fabs(report.mean_influences - used_sum / bound) <= 1e-9 * used_sum);
}

template <class T, std::size_t D>
void check_random_skins() {
    const auto seed = GENERATE(range(0, effort(24, 8)));
    CAPTURE(seed);
    const auto binding = random_binding<T, D>(std::uint64_t(seed));
    REQUIRE(binding.point_count() > 0);
    for (const std::size_t influences : {1u, 2u, 3u, 4u, 5u, 8u, 16u, 300u}) {
        CAPTURE(influences);
        const auto [skin, report] = cageform::skin_weights(binding, {.influences = influences});
        check_skin(binding, skin, report, influences);
        CHECK(report.without_weights.empty());
        if (influences <= D) continue;
        CHECK(report.not_reproduced.empty());
        CHECK(report.reproduction_error.value <= 1e-6 * size_of(binding));
    }
}

const Points2<double> square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};

} // namespace

TEST_CASE("skins of random 2D cages satisfy the laws", "[binding][skin_weights][property]") {
    check_random_skins<double, 2>();
}

TEST_CASE("skins of random 3D cages satisfy the laws", "[binding][skin_weights][property]") {
    check_random_skins<float, 3>();
}

TEST_CASE("with as many influences as handles the weights are optimal", "[binding][skin_weights][property]") {
    const auto seed = GENERATE(range(0, 24));
    CAPTURE(seed);
    const auto binding = random_binding<double, 2>(std::uint64_t(seed));
    const std::size_t handles = binding.handle_count();
    const auto [skin, report] = cageform::skin_weights(binding, {.influences = handles});
    REQUIRE(report.status == Status::ok);
    const double size = size_of(binding);
    for (std::size_t i = 0; i < binding.point_count(); ++i) {
        std::vector<double> w(handles, 0.0);
        for (std::size_t k = 0; k < handles; ++k)
            w[skin.joints[i * handles + k]] += double(skin.weights[i * handles + k]);
        // The optimality conditions: w = w0 + an affine function of the handle, or this is negative and w
        // = 0.
        std::vector<std::size_t> positive;
        for (std::size_t h = 0; h < handles; ++h) {
            if (w[h] > 1e-6) positive.push_back(h);
        }
        const auto row = [&](std::size_t h) {
            const auto c = (1 / size) * (binding.rest_handle(h) - binding.rest_point(i));
            return Vec<double, 3>{1, c[0], c[1]};
        };
        Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(3, 3);
        Eigen::VectorXd right = Eigen::VectorXd::Zero(3);
        for (const std::size_t h : positive) {
            const auto a = row(h);
            for (long r = 0; r < 3; ++r) {
                for (long c = 0; c < 3; ++c) normal(r, c) += a.v[r] * a.v[c];
                right[r] += a.v[r] * (w[h] - binding.weight(i, h));
            }
        }
        const Eigen::VectorXd solution = normal.fullPivLu().solve(right);
        const Vec<double, 3> y{solution[0], solution[1], solution[2]};
        const double scale = 1 + std::sqrt(dot(y, y));
        const auto nearest = [&](std::size_t h) { return binding.weight(i, h) + dot(row(h), y); };
        for (const std::size_t h : positive) CHECK(std::fabs(w[h] - nearest(h)) <= 1e-5 * scale);
        if (positive.size() <= 3) continue; // the function is not determined
        for (std::size_t h = 0; h < handles; ++h) {
            if (w[h] <= 1e-6) CHECK(nearest(h) <= 1e-4 * scale);
        }
    }
}

TEST_CASE("the skin of a valid skin is the same", "[binding][skin_weights]") {
    const Points2<double> triangle{{0, 0}, {5, 1}, {2, 6}};
    const Points2<double> points{{2, 2}, {3, 1.5}, {0, 0}, {2.5, 0.5}};
    const auto binding = cageform::bind(cageform::BarycentricCoordinates<double, 2>(triangle), points).value;
    const auto [skin, report] = cageform::skin_weights(binding);
    check_skin(binding, skin, report, 4);
    CHECK(report.weight_error.value <= 1e-7);
    CHECK(report.weight_added.value <= 1e-7);
    CHECK(skin.weights[8] == 1); // only the vertex
    CHECK(skin.joints[8] == 0);
    CHECK(skin.weights[9] == 0);

    const cageform::Polygon<double> cage(random_star<double>(4));
    Random random(4);
    Points2<double> inside;
    for (int i = 0; i < 20; ++i) inside.push_back(random_inside(cage, random, 0.01));
    const auto harmonic = cageform::bind(cageform::HarmonicCoordinates<double, 2>(cage, {.resolution = 64},
                                                                                  cageform::UniformGrid{}),
                                         inside)
                              .value;
    const auto all = cageform::skin_weights(harmonic, {.influences = harmonic.handle_count()});
    CHECK(all.report.weight_error.value <= 1e-5);
}

TEST_CASE("points on vertices, edges and faces are in the hull", "[binding][skin_weights]") {
    const MeshData data = sphere(1);
    Points3<double> points = data.vertices;
    for (const auto& face : data.faces) {
        const auto &a = data.vertices[std::size_t(face[0])], &b = data.vertices[std::size_t(face[1])],
                   &c = data.vertices[std::size_t(face[2])];
        points.push_back(0.5 * (a + b));
        points.push_back((1.0 / 3) * (a + b + c));
        points.push_back(0.999 * a + 0.001 * b);
    }
    const auto binding =
        cageform::bind(cageform::MeanValueCoordinates<double, 3>(data.mesh<double>()), points).value;
    const auto [skin, report] = cageform::skin_weights(binding);
    check_skin(binding, skin, report, 4);
    CHECK(report.not_reproduced.empty());
    CHECK(report.weight_error.value <= 1e-6);
    for (std::size_t i = 0; i < data.vertices.size(); ++i) {
        CHECK(skin.joints[4 * i] == i);
        CHECK(skin.weights[4 * i] == 1);
    }
}

TEST_CASE("outside the hull the skin reproduces the nearest point and lists the point",
          "[binding][skin_weights]") {
    const Points2<double> points{{1, 1}, {6, 1}, {-1, -2}, {2, 5}};
    const auto bound = cageform::bind(cageform::MeanValueCoordinates<double, 2>(square), points);
    const auto [skin, report] = cageform::skin_weights(bound.value, {.influences = 3});
    check_skin(bound.value, skin, report, 3);
    CHECK(report.not_reproduced == Indices{1, 2, 3});
    const Points2<double> nearest{{1, 1}, {4, 1}, {0, 0}, {2, 4}};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto off = miss(bound.value, skin, i) + (points[i] - nearest[i]);
        CHECK(std::sqrt(dot(off, off)) <= 1e-4);
    }
    CHECK(report.reproduction_error.point == 2);
    CHECK(std::fabs(report.reproduction_error.value - std::sqrt(5.0)) <= 1e-4);
}

TEST_CASE("points with nearest_boundary are reproduced at the boundary", "[binding][skin_weights]") {
    const Points2<double> points{{6, 1}, {-1, -2}};
    const auto bound = cageform::bind(cageform::MeanValueCoordinates<double, 2>(square), points,
                                      {.outside = cageform::OutsidePoints::nearest_boundary});
    const auto [skin, report] = cageform::skin_weights(bound.value);
    REQUIRE(report.status == Status::ok);
    CHECK(report.not_reproduced.empty());
    CHECK(report.weight_error.value <= 1e-6);
    CHECK(skin.joints[4] == 0);
    CHECK(skin.weights[4] == 1);
}

TEST_CASE("points with falloff are listed and have the skin without falloff",
          "[binding][skin_weights][falloff]") {
    const Points2<double> points{{1, 1}, {6, 1}, {-1, -2}, {4, 4.5}, {2, 9}};
    for (const auto outside : {cageform::OutsidePoints::extend, cageform::OutsidePoints::nearest_boundary}) {
        const cageform::MeanValueCoordinates<double, 2> coordinates(square);
        const auto plain = cageform::bind(coordinates, points, {.outside = outside});
        const auto faded = cageform::bind(coordinates, points, {.outside = outside, .falloff = 4});
        CHECK(faded.report.faded == Indices{1, 2, 3});
        const auto expected = cageform::skin_weights(plain.value),
                   found = cageform::skin_weights(faded.value);
        REQUIRE(found.report.status == Status::ok);
        CHECK(expected.report.faded.empty());
        CHECK(found.report.faded == faded.report.faded);
        CHECK(found.report.without_weights == Indices{4});
        const auto last = std::size_t(found.value.influences) * 4;
        for (std::size_t k = 0; k < last; ++k)
            CHECK(std::fabs(found.value.weights[k] - expected.value.weights[k]) <= 1e-6F);
        CHECK(std::equal(found.value.joints.begin(), found.value.joints.begin() + std::ptrdiff_t(last),
                         expected.value.joints.begin()));
        for (std::size_t i = 0; i < 4; ++i)
            CHECK(std::fabs(found.report.weight_errors[i] - expected.report.weight_errors[i]) <= 1e-5F);
    }
}

TEST_CASE("with too few influences the point is listed", "[binding][skin_weights]") {
    const Points2<double> points{{2, 2}, {2, 0}, {4, 4}};
    const auto bound = cageform::bind(cageform::MeanValueCoordinates<double, 2>(square), points);
    const auto one = cageform::skin_weights(bound.value, {.influences = 1});
    CHECK(one.report.not_reproduced == Indices{0, 1});
    CHECK(one.value.weights == std::vector<float>{1, 1, 1});
    CHECK(one.value.joints[2] == 2);
    const auto two = cageform::skin_weights(bound.value, {.influences = 2});
    check_skin(bound.value, two.value, two.report, 2);
    CHECK(two.report.not_reproduced.empty()); // the centre lies between opposite vertices
}

TEST_CASE("points kept in place and points that are not finite have no weights", "[binding][skin_weights]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const Points2<double> points{{1, 1}, {nan, 1}, {6, 1}, {2, 3}};
    const auto bound = cageform::bind(cageform::MeanValueCoordinates<double, 2>(square), points,
                                      {.outside = cageform::OutsidePoints::keep_in_place});
    const auto [skin, report] = cageform::skin_weights(bound.value);
    check_skin(bound.value, skin, report, 4);
    CHECK(report.without_weights == Indices{1, 2});
    CHECK(report.not_reproduced.empty());
    for (const std::size_t i : {1u, 2u}) CHECK(report.weight_errors[i] == 0);
    for (const int integer : cageform::to_normalised<std::uint8_t>(skin)) CHECK(integer >= 0);
    const auto [played, status] = cageform::skin_to_binding(bound.value, skin);
    REQUIRE(status == Status::ok);
    Points2<double> pose = square, out(points.size());
    pose[2] = {9, 9};
    REQUIRE(clone(played, pose, out) == Status::ok);
    CHECK(out[2] == points[2]);
    CHECK(out[0][0] > 1);
}

TEST_CASE("weights below the threshold are dropped where possible", "[binding][skin_weights]") {
    const auto binding = random_binding<double, 2>(6);
    const auto plain = cageform::skin_weights(binding, {.influences = 16});
    const auto [skin, report] = cageform::skin_weights(binding, {.influences = 16, .threshold = 0.05});
    check_skin(binding, skin, report, 16);
    CHECK(report.not_reproduced.empty());
    CHECK(report.mean_influences < 0.8 * plain.report.mean_influences);
    std::size_t least = 0;
    for (const float w : skin.weights) least += w > 0 && w < 0.05F ? 1 : 0;
    CHECK(least <= 2 * binding.point_count()); // only where the hull needs them, for instance near an edge
}

TEMPLATE_TEST_CASE("a skin preserves rest bit for bit and affine poses", "[binding][skin_weights][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    const auto binding = random_binding<T, 3>(std::uint64_t(seed));
    const auto [skin, report] = cageform::skin_weights(binding);
    const auto [played, status] = cageform::skin_to_binding(binding, skin);
    REQUIRE(status == Status::ok);
    Points3<T> pose, out(binding.point_count());
    for (std::size_t h = 0; h < binding.handle_count(); ++h) pose.push_back(binding.rest_handle(h));
    REQUIRE(clone(played, pose, out) == Status::ok);
    for (std::size_t i = 0; i < out.size(); ++i) CHECK(out[i] == binding.rest_point(i));
    const auto affine = [](const Vec<T, 3>& p) {
        return Vec<T, 3>{T(1.5) * p[0] - p[1], p[2] + T(0.25) * p[0], p[1] - T(2) * p[2]};
    };
    double reach = 0;
    for (auto& p : pose) {
        reach = cageform_tests::larger(reach, std::sqrt(double(dot(p, p))));
        p = affine(p);
    }
    REQUIRE(clone(played, pose, out) == Status::ok);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const auto off =
            cageform::vec_cast<double>(out[i]) - cageform::vec_cast<double>(affine(binding.rest_point(i)));
        CHECK(std::sqrt(dot(off, off)) <= 1e-5 * reach);
    }
}

TEMPLATE_TEST_CASE("normalised integers have the exact sum and descend", "[binding][skin_weights][property]",
                   std::uint8_t, std::uint16_t) {
    constexpr int most = std::numeric_limits<TestType>::max();
    const auto seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    const auto binding = random_binding<double, 3>(std::uint64_t(seed));
    for (const std::size_t influences : {1u, 3u, 4u, 8u, 16u}) {
        const auto skin = cageform::skin_weights(binding, {.influences = influences}).value;
        const auto integers = cageform::to_normalised<TestType>(skin);
        REQUIRE(integers.size() == skin.weights.size());
        for (std::size_t i = 0; i < skin.point_count(); ++i) {
            int sum = 0;
            for (std::size_t k = 0; k < influences; ++k) {
                const std::size_t at = i * influences + k;
                sum += integers[at];
                CHECK(std::fabs(double(integers[at]) - double(skin.weights[at]) * most) <= 1.01);
                if (k > 0) CHECK(integers[at] <= integers[at - 1]);
            }
            CHECK(sum == most);
        }
    }
    const SkinWeights thirds{3, {0, 1, 2}, {1.0F / 3, 1.0F / 3, 1.0F / 3}};
    CHECK(cageform::to_normalised<TestType>(thirds) ==
          std::vector<TestType>{TestType(most / 3), TestType(most / 3), TestType(most / 3)});
    const SkinWeights halves{2, {0, 1}, {0.5F, 0.5F}};
    CHECK(cageform::to_normalised<TestType>(halves) ==
          std::vector<TestType>{TestType(most / 2 + 1), TestType(most / 2)});
}

TEMPLATE_TEST_CASE("skins of given weights keep the largest, normalised", "[binding][skin_weights][bones]",
                   CAGEFORM_SCALARS) {
    using W = TestType;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 300);
    const std::size_t bones = 1 + random.below(9), count = 50, most = 1 + random.below(5);
    std::vector<W> shares;
    for (std::size_t i = 0; i < count; ++i) {
        for (const double share : random_shares(bones, random))
            shares.push_back(random.below(3) == 0 ? W(0) : W(share));
    }
    const double threshold = seed % 2 == 0 ? 0 : 0.1;
    const auto [skin, report] = cageform::skin_weights(std::span<const W>(shares), bones,
                                                       {.influences = most, .threshold = threshold});
    REQUIRE(report.status == Status::ok);
    REQUIRE(skin.point_count() == count);
    for (std::size_t i = 0; i < count; ++i) {
        std::multimap<double, std::size_t, std::greater<>> sorted;
        for (std::size_t b = 0; b < bones; ++b) {
            if (const double share = double(shares[i * bones + b]); share > 0) sorted.emplace(share, b);
        }
        const bool none = std::count(report.without_weights.begin(), report.without_weights.end(), i) == 1;
        CHECK(none == sorted.empty());
        double sum = 0, kept = 0, error = 0;
        std::size_t used = 0;
        for (const auto& [share, bone] : sorted) {
            if (used < most && (used == 0 || share >= threshold)) {
                kept += share;
                ++used;
            }
        }
        std::set<std::size_t> joints;
        for (std::size_t k = 0; k < most; ++k) {
            const auto w = double(skin.weights[i * most + k]);
            const std::size_t joint = skin.joints[i * most + k];
            CAPTURE(i, k, w, joint);
            CHECK((w > 0) == (k < used));
            if (k >= used) continue;
            CHECK(joints.insert(joint).second);
            CHECK(std::fabs(w - double(shares[i * bones + joint]) / kept) <= 1e-6);
            if (k > 0) CHECK(skin.weights[i * most + k] <= skin.weights[i * most + k - 1]);
            sum += w;
            error += std::fabs(w - double(shares[i * bones + joint]));
        }
        for (const auto& [share, bone] : sorted) error += joints.count(bone) == 0 ? share : 0;
        if (none) continue;
        CHECK(std::fabs(sum - 1) <= 0x1p-24);
        CHECK(std::fabs(double(report.weight_errors[i]) - error) <= 1e-6);
    }
    shares[0] = std::numeric_limits<W>::quiet_NaN();
    CHECK(cageform::skin_weights(std::span<const W>(shares), bones).report.without_weights[0] == 0);
    const auto refused = [&](std::size_t of, const cageform::SkinWeightsOptions& options) {
        const auto result = cageform::skin_weights(std::span<const W>(shares), of, options);
        CHECK(result.value.point_count() == 0);
        return result.report.status;
    };
    CHECK(refused(0, {}) == Status::bone_weights_do_not_match);
    CHECK(refused(shares.size() + 1, {}) == Status::bone_weights_do_not_match);
    CHECK(refused(bones, {.influences = 0}) == Status::too_few_influences);
    CHECK(refused(bones, {.influences = 65536}) == Status::too_many_handles);
    CHECK(refused(bones, {.threshold = std::numeric_limits<double>::infinity()}) == Status::value_not_finite);
}

TEST_CASE("invalid input of skin_weights is rejected", "[binding][skin_weights]") {
    const auto binding = random_binding<double, 2>(1);
    const auto status = [&](const cageform::SkinWeightsOptions& options) {
        const auto [skin, report] = cageform::skin_weights(binding, options);
        CHECK(skin.joints.empty());
        CHECK(skin.weights.empty());
        return report.status;
    };
    CHECK(status({.influences = 0}) == Status::too_few_influences);
    CHECK(status({.influences = 65536}) == Status::too_many_handles);
    CHECK(status({.threshold = std::numeric_limits<double>::quiet_NaN()}) == Status::value_not_finite);
    CHECK(cageform::skin_weights(binding, {}, {.progress = [](double) { return false; }}).report.status ==
          Status::cancelled);
    BindingView<double, 2> large;
    large.weights.rows = 65536;
    CHECK(cageform::skin_weights(large).report.status == Status::too_many_handles);

    const auto nothing = cageform::skin_weights(Binding<float, 3>{});
    CHECK(nothing.report.status == Status::ok);
    CHECK(nothing.value.point_count() == 0);
}

TEST_CASE("a skin does not depend on threads", "[binding][skin_weights]") {
    const auto binding = random_binding<float, 3>(2);
    const auto one = cageform::skin_weights(binding),
               some = cageform::skin_weights(binding, {}, {.parallel = cageform::ThreadedFor{3}});
    CHECK(one.value.joints == some.value.joints);
    CHECK(one.value.weights == some.value.weights);
    CHECK(one.report.weight_error.value == some.report.weight_error.value);
    CHECK(one.report.mean_weight_error == some.report.mean_weight_error);
}

} // namespace skin_weights_tests
