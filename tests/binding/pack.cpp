// Packing: rest, affine poses and the largest weights are preserved, and the report has all
// losses.
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/packed.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/greedy_row_selection.hpp>
#include <cageform/binding/detail/stored_weights.hpp>
#include <cageform/binding/detail/weight_loss.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

namespace pack_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::BlobCheck;
using cageform::epsilon;
using cageform::pack;
using cageform::PackOptions;

namespace {

const auto formats = {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8};

/// A random cage with points in and around it, bound by mean value coordinates. With `most` > 1, random
/// points are repeated up to `most` times, and one 50 times.
template <class T, std::size_t D>
struct Bound {
    std::vector<Vec<T, D>> handles, points;
    Binding<T, D> binding;

    explicit Bound(std::uint64_t seed, std::size_t most = 1) {
        if constexpr (D == 2) {
            handles = random_star<T>(seed);
            const cageform::Polygon<T> cage(handles);
            Random random(seed + 7);
            for (int i = 0; i < 300; ++i) points.push_back(random_inside(cage, random, 0));
            points.push_back(cage[0]);
            repeat(seed, most);
            binding = cageform::bind(cageform::MeanValueCoordinates<T, 2>(cage), points).value;
        } else {
            const auto data = random_large_mesh(seed);
            const auto mesh = data.template mesh<T>();
            handles.assign(mesh.vertices().begin(), mesh.vertices().end());
            for (const auto& p : points_about(data, 300, seed)) {
                if (cageform::locate(mesh, cageform::vec_cast<T>(p), T(0)) == PointState::inside)
                    points.push_back(cageform::vec_cast<T>(p));
            }
            points.push_back(handles[0]);
            repeat(seed, most);
            binding = cageform::bind(cageform::MeanValueCoordinates<T, 3>(mesh), points).value;
        }
        REQUIRE(binding.point_count() == points.size());
    }

    void repeat(std::uint64_t seed, std::size_t most) {
        if (most == 1) return;
        std::mt19937_64 random(seed);
        const auto single = points;
        for (const auto& p : single) points.insert(points.end(), random() % most, p);
        points.insert(points.end(), 49, single[7]);
        std::shuffle(points.begin(), points.end(), random);
    }

    std::vector<double> row(std::size_t i) const {
        std::vector<double> weights;
        for (std::size_t h = 0; h < handles.size(); ++h) weights.push_back(double(binding.weight(i, h)));
        return weights;
    }
};

template <class T, std::size_t D>
std::vector<Vec<T, D>> cloned(const cageform::PackedBinding<T, D>& packed,
                              const std::vector<Vec<T, D>>& pose) {
    std::vector<Vec<T, D>> out(packed.view().point_count());
    REQUIRE(cageform::clone(packed.view(), pose, out) == Status::ok);
    return out;
}

template <class T, std::size_t D>
std::vector<PackOptions> all_options() {
    std::vector<PackOptions> all;
    for (const WeightFormat format : formats) {
        all.push_back({.format = format});
        all.push_back({.format = format, .largest = D + 1});
        all.push_back({.format = format, .largest = 8});
        all.push_back({.format = format, .threshold = 0.02});
        all.push_back({.format = format, .largest = 6, .threshold = 0.1});
    }
    return all;
}

struct Float2 {
    using T = float;
    static constexpr std::size_t D = 2;
};
struct Double2 {
    using T = double;
    static constexpr std::size_t D = 2;
};
struct Float3 {
    using T = float;
    static constexpr std::size_t D = 3;
};
struct Double3 {
    using T = double;
    static constexpr std::size_t D = 3;
};

} // namespace

TEMPLATE_TEST_CASE("packed bindings preserve rest and affine poses", "[pack][affine]", Float2, Double2,
                   Float3, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    const Bound<T, D> bound{std::uint64_t(seed)};
    Random random(std::uint64_t(seed) + 1);
    const auto map = random_affine<D>(random, size_of(bound.handles));
    const auto pose = map(std::span<const Vec<T, D>>(bound.handles));
    for (const auto& options : all_options<T, D>()) {
        CAPTURE(int(options.format.value()), options.largest, options.threshold);
        const auto [packed, report] = pack(bound.binding, options);
        REQUIRE(report.status == Status::ok);
        CHECK(cloned(packed, bound.handles) == bound.points);
        const auto moved = cloned(packed, pose);
        // As for a dense binding, times the growth of changed weights.
        const double size = std::max(size_of(bound.handles), size_of(pose));
        const double bound_of_error = 32 * double(epsilon<T>) * size * (1 + report.error.value);
        for (std::size_t i = 0; i < moved.size(); ++i) {
            CAPTURE(i);
            CHECK(distance(moved[i], map(cageform::vec_cast<long double>(bound.points[i]))) <=
                  bound_of_error);
        }
    }
}

TEMPLATE_TEST_CASE("reported errors are those of the effective weights, and bound those in poses",
                   "[pack][report]", Float2, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(20, 26));
    CAPTURE(seed);
    const Bound<T, D> bound{std::uint64_t(seed)};
    const double size = size_of(bound.handles);
    auto pose = bound.handles;
    Random random{std::uint64_t(seed)};
    double reach = 0;
    for (std::size_t h = 0; h < pose.size(); ++h) {
        for (std::size_t k = 0; k < D; ++k) pose[h][k] += T(size * random.uniform(-0.5, 0.5));
        reach = cageform_tests::larger(reach, distance(pose[h], bound.handles[h]));
    }
    const auto exact = cageform_tests::cloned(bound.binding, pose);
    for (const auto& options : all_options<T, D>()) {
        CAPTURE(int(options.format.value()), options.largest, options.threshold);
        const auto [packed, report] = pack(bound.binding, options);
        REQUIRE(report.status == Status::ok);
        REQUIRE(report.errors.size() == bound.points.size());
        const auto weights = effective_weights(packed.view());
        const auto moved = cloned(packed, pose);
        double largest = 0, sum = 0;
        for (std::size_t i = 0; i < bound.points.size(); ++i) {
            CAPTURE(i);
            const auto before = bound.row(i);
            double error = 0;
            for (std::size_t h = 0; h < before.size(); ++h) error += std::fabs(weights[i][h] - before[h]);
            const double rounding =
                4 * double(epsilon<T>) * double(before.size()) * (1 + absolute_sum(weights[i]));
            CHECK(std::fabs(double(report.errors[i]) - error) <= rounding + 1e-7 * error);
            CHECK(distance(moved[i], exact[i]) <=
                  error * reach + 64 * double(epsilon<T>) * size * (1 + error));
            largest = cageform_tests::larger(largest, double(report.errors[i]));
            sum += double(report.errors[i]);
        }
        CHECK(report.error.value == largest);
        CHECK(report.mean_error == Approx(sum / double(bound.points.size())).margin(1e-300));
        CHECK(report.points == bound.points.size());
        CHECK(report.handles == bound.handles.size());
        CHECK(report.bytes == packed.bytes().size());
        CHECK(report.rows == packed.view().row_count());
    }
}

TEMPLATE_TEST_CASE("every point keeps its largest weights, up to the change by restoring", "[pack][sparse]",
                   Float2, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(40, 46));
    const std::size_t largest = GENERATE(4u, 8u, 16u);
    CAPTURE(seed, largest);
    const Bound<T, D> bound{std::uint64_t(seed)};
    const auto [packed, report] = pack(bound.binding, {.largest = largest});
    REQUIRE(report.status == Status::ok);
    const auto view = packed.view();
    if (largest >= bound.handles.size()) {
        CHECK(view.row_begin == nullptr);
        return;
    }
    std::size_t seen = 0;
    for (std::size_t place = 0; place < view.points; ++place) {
        const std::size_t block = place / cageform::lane_count<T>, i = view.order[place];
        const auto row = bound.row(i);
        std::vector<std::size_t> ranked(row.size());
        std::iota(ranked.begin(), ranked.end(), std::size_t{0});
        std::sort(ranked.begin(), ranked.end(), [&](std::size_t a, std::size_t b) {
            const double of_a = std::fabs(row[a]), of_b = std::fabs(row[b]);
            return of_a != of_b ? of_a > of_b : a < b;
        });
        std::vector<std::uint16_t> handles(view.row_handle + view.first_row(block),
                                           view.row_handle + view.first_row(block + 1));
        CHECK(std::is_sorted(handles.begin(), handles.end()));
        for (std::size_t n = 0; n < largest; ++n) {
            if (row[ranked[n]] == 0) break;
            CHECK(std::count(handles.begin(), handles.end(), ranked[n]) == 1);
            ++seen;
        }
    }
    CHECK(seen >= view.points); // the check is not vacuous
    std::vector<char> there(view.points, 0);
    for (std::size_t place = 0; place < view.points; ++place) there[view.order[place]] = 1;
    CHECK(std::count(there.begin(), there.end(), 1) == std::ptrdiff_t(view.points));
}

TEMPLATE_TEST_CASE("seams stay closed: points with equal positions keep equal weights",
                   "[pack][sparse][property]", Float2, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(60, 64));
    CAPTURE(seed);
    const Bound<T, D> bound(std::uint64_t(seed), 7);
    Random random(std::uint64_t(seed) + 1);
    auto pose = bound.handles;
    for (auto& p : pose) {
        for (std::size_t k = 0; k < D; ++k) p[k] += T(random.uniform(-1, 1));
    }
    double size = 0;
    for (const auto& p : pose) size = std::fmax(size, std::sqrt(double(dot(p, p))));
    for (const PackOptions& options :
         {PackOptions{.largest = D + 1}, PackOptions{.largest = 6, .threshold = 0.02}}) {
        const auto packed = pack(bound.binding, options);
        REQUIRE(packed.report.status == Status::ok);
        const auto moved = cloned(packed.value, pose);
        std::map<std::array<T, D>, Vec<T, D>> place_of;
        double apart = 0;
        for (std::size_t n = 0; n < moved.size(); ++n) {
            std::array<T, D> at{};
            for (std::size_t k = 0; k < D; ++k) at[k] = bound.points[n][k];
            const Vec<T, D> gap = place_of.insert({at, moved[n]}).first->second - moved[n];
            apart = std::fmax(apart, std::sqrt(double(dot(gap, gap))));
        }
        CHECK(place_of.size() < moved.size() / 2);
        CHECK(apart <= 16 * double(epsilon<T>) * size); // rows are summed in another order
    }
}

TEMPLATE_TEST_CASE("more weights and finer formats give smaller errors", "[pack][report]", Float3, Double3) {
    using T = typename TestType::T;
    const auto seed = GENERATE(range(60, 64));
    const Bound<T, 3> bound{std::uint64_t(seed)};
    CAPTURE(seed);
    const auto error = [&](const PackOptions& options) {
        return pack(bound.binding, options).report.mean_error;
    };
    CHECK(error({.largest = 8}) <= error({.largest = 4}));
    CHECK(error({.largest = 16}) <= error({.largest = 8}));
    CHECK(error({}) == 0);
    // One rounding per weight: half a step of its format.
    double largest_weight = 0;
    for (std::size_t i = 0; i < bound.points.size(); ++i) {
        for (const double w : bound.row(i))
            largest_weight = cageform_tests::larger(largest_weight, std::fabs(w));
    }
    const double handles = double(bound.handles.size());
    CHECK(pack(bound.binding, {.format = WeightFormat::int16}).report.error.value <=
          2 * handles * 0.5 * largest_weight / 32767);
    CHECK(pack(bound.binding, {.format = WeightFormat::int8}).report.error.value <=
          2 * handles * 0.5 * largest_weight / 127);
    for (std::size_t i = 0; i < bound.points.size(); ++i)
        CHECK(pack(bound.binding, {.format = WeightFormat::half}).report.errors[i] <=
              4 * std::ldexp(1.0, -11) * absolute_sum(bound.row(i)));
}

TEST_CASE("16-bit weights need half the memory of float, sparse ones a fraction", "[pack]") {
    const auto binding = random_binding<float, 3>(16000, 112, 1);
    const auto size = [&](const PackOptions& options) { return double(pack(binding, options).report.bytes); };
    const double dense = double(pack(binding).report.dense_bytes);
    // In addition: the points at rest and four numbers for residuals.
    CHECK(size({.format = WeightFormat::int16}) <= (0.5 * 112 + 3 + 4 + 1) / (112 + 3) * dense);
    CHECK(size({.format = WeightFormat::int8}) <= (0.25 * 112 + 3 + 4 + 1) / (112 + 3) * dense);
}

TEST_CASE("to_half rounds to nearest, ties to even, and flushes subnormals", "[pack][half]") {
    using cageform::detail::from_half;
    using cageform::detail::to_half;
    for (std::uint32_t bits = 0; bits < 0x7C00; ++bits) {
        const auto half = static_cast<std::uint16_t>(bits);
        const double x = plain_half(half);
        if (bits >= 0x0400) { // not subnormal
            CHECK(to_half(x) == half);
            CHECK(from_half(half) == x);
            CHECK(from_half(static_cast<std::uint16_t>(half | 0x8000)) == -x);
        } else {
            CHECK(to_half(x) == 0);
        }
    }
    CHECK(plain_half(to_half(1 + 0x1p-11)) == 1);
    CHECK(plain_half(to_half(1 + 0x1p-10 + 0x1p-11)) == 1 + 0x1p-9);
    CHECK(plain_half(to_half(-1.5)) == -1.5);
}

TEST_CASE("packing does not depend on threads, reports progress and can be cancelled", "[pack][threads]") {
    const auto binding = random_binding<float, 3>(3000, 40, 2);
    PackOptions options{.format = WeightFormat::int16, .largest = 8};
    const auto alone = pack(binding, options);
    cageform::Running running{cageform::ThreadedFor{3}};
    const auto together = pack(binding, options, running);
    const auto a = alone.value.bytes(), b = together.value.bytes();
    REQUIRE(a.size() == b.size());
    CHECK(std::memcmp(a.data(), b.data(), a.size()) == 0);
    CHECK(alone.report.errors == together.report.errors);

    std::vector<double> told;
    running.parallel = cageform::SerialFor{};
    running.progress = [&told](double done) {
        told.push_back(done);
        return true;
    };
    CHECK(pack(binding, options, running).report.status == Status::ok);
    CHECK(!told.empty());
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.back() <= 1);
    running.progress = [](double) { return false; };
    const auto stopped = pack(binding, options, running);
    CHECK(stopped.report.status == Status::cancelled);
    CHECK(stopped.value.bytes().empty());
}

TEST_CASE("a given order is kept, as vectors need that of their points", "[pack][sparse]") {
    const auto points = random_binding<float, 3>(100, 30, 6), vectors = random_binding<float, 3>(100, 30, 7);
    const auto packed = pack(points, {.largest = 8}).value;
    const std::span<const std::uint32_t> order(packed.view().order, 100);
    const auto [packed_vectors, report] = pack(vectors, {.largest = 8, .order = order});
    REQUIRE(report.status == Status::ok);
    CHECK(std::equal(order.begin(), order.end(), packed_vectors.view().order));
    std::vector<std::uint32_t> twice(order.begin(), order.end()), beyond = twice;
    twice[3] = twice[4];
    beyond[3] = 100;
    CHECK(pack(vectors, {.largest = 8, .order = twice}).report.status == Status::order_not_a_permutation);
    CHECK(pack(vectors, {.largest = 8, .order = beyond}).report.status == Status::order_not_a_permutation);
    CHECK(pack(vectors, {.largest = 8, .order = order.first(99)}).report.status ==
          Status::order_not_a_permutation);
}

TEST_CASE("invalid input of pack is rejected with its status", "[pack][status]") {
    const auto binding = random_binding<float, 3>(40, 20, 3);
    CHECK(pack(binding, {.largest = 3}).report.status == Status::too_few_weights);
    CHECK(pack(binding, {.largest = 4}).report.status == Status::ok);
    CHECK(pack(random_binding<double, 2>(3, 70000, 4), {.largest = 8}).report.status ==
          Status::too_many_handles);
    CHECK(pack(random_binding<double, 2>(3, 70000, 4)).report.status == Status::ok);

    auto spoilt = random_binding<float, 3>(40, 20, 5);
    std::vector<Vec<float, 3>> handles;
    for (std::size_t h = 0; h < 20; ++h) handles.push_back(spoilt.rest_handle(h));
    auto [weights, rest] = std::move(spoilt).release();
    cageform::BlockView<float>{weights.data(), 20, 40}(33, 7) = std::numeric_limits<float>::quiet_NaN();
    spoilt = {std::move(weights), std::move(rest), std::move(handles), 40};
    const auto refused = pack(spoilt, {.largest = 8});
    CHECK(refused.report.status == Status::weight_not_finite);
    CHECK(refused.report.culprit == 33);
    CHECK(refused.value.bytes().empty());

    const auto empty = pack(Binding<float, 3>{}, {.format = WeightFormat::half, .largest = 8});
    CHECK(empty.report.status == Status::ok);
    CHECK(empty.value.view().point_count() == 0);
}

TEST_CASE("packed points kept in place do not move in any pose", "[pack]") {
    const std::vector<Vec<double, 2>> cage{{0, 0}, {4, 0}, {4, 2}, {0, 2}, {-1, 1}};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Vec<double, 2>> points{{1, 1}, {50, 50}, {nan, 1}, {3, 1}};
    const auto bound = cageform::bind(cageform::MeanValueCoordinates<double, 2>(cage), points,
                                      {.outside = cageform::OutsidePoints::keep_in_place});
    auto pose = cage;
    pose[2] = {9, 9};
    for (const WeightFormat format : formats) {
        const auto [packed, report] = pack(bound.value, {.format = format, .largest = 3});
        REQUIRE(report.status == Status::ok);
        const auto out = cloned(packed, pose);
        CHECK(out[1] == points[1]);
        CHECK((out[2][0] != out[2][0] && out[2][1] == 1));
        CHECK(out[0] != points[0]);
    }
}

namespace {

/// Bending poses of the handles: affine images with a smooth wave added.
template <class T, std::size_t D>
std::vector<std::vector<Vec<T, D>>> bent_poses(const std::vector<Vec<T, D>>& handles, std::size_t count,
                                               std::uint64_t seed) {
    Random random(seed);
    const double size = size_of(handles);
    std::vector<std::vector<Vec<T, D>>> poses;
    for (std::size_t n = 0; n < count; ++n) {
        const auto map = random_affine<D>(random, size);
        auto pose = map(std::span<const Vec<T, D>>(handles));
        const double reach = size * random.uniform(0.02, 0.2), turns = random.uniform(2, 6) / size;
        for (std::size_t h = 0; h < pose.size(); ++h) {
            for (std::size_t k = 0; k < D; ++k)
                pose[h][k] += T(reach * std::sin(turns * double(handles[h][(k + 1) % D]) + double(n)));
        }
        poses.push_back(std::move(pose));
    }
    return poses;
}

/// By definition: the largest distance of each point between two clones.
template <class T, std::size_t D>
std::vector<double> distances(const Binding<T, D>& binding, const cageform::PackedBinding<T, D>& packed,
                              const std::vector<std::vector<Vec<T, D>>>& poses) {
    std::vector<double> largest(binding.point_count(), 0.0);
    for (const auto& pose : poses) {
        const auto exact = cageform_tests::cloned(binding, pose), moved = cloned(packed, pose);
        for (std::size_t i = 0; i < exact.size(); ++i)
            largest[i] = cageform_tests::larger(largest[i], double(distance(exact[i], moved[i])));
    }
    return largest;
}

/// The rounding of the sums of two clones, as in the test of errors above.
template <class T, std::size_t D>
double rounding_of_clones(const std::vector<Vec<T, D>>& handles,
                          const std::vector<std::vector<Vec<T, D>>>& poses, double error) {
    double size = size_of(handles);
    for (const auto& pose : poses) size = cageform_tests::larger(size, double(size_of(pose)));
    return 64 * double(epsilon<T>) * size * (1 + error);
}

const auto all_formats = {std::optional<WeightFormat>{}, std::optional(WeightFormat::scalar),
                          std::optional(WeightFormat::half), std::optional(WeightFormat::int16),
                          std::optional(WeightFormat::int8)};

} // namespace

TEMPLATE_TEST_CASE("clones meet the tolerance over poses in every format, or the format is rejected",
                   "[pack][tolerance]", Float2, Double2, Float3, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(80, 83));
    const double share = GENERATE(1e-2, 1e-4);
    CAPTURE(seed, share);
    const Bound<T, D> bound{std::uint64_t(seed)};
    const double tolerance = share * size_of(bound.handles);
    const auto poses = bent_poses(bound.handles, 5, std::uint64_t(seed));
    std::vector<double> numbers;
    for (const auto& pose : poses) cageform::append_pose(numbers, pose);
    std::size_t open_bytes = 0, least_bytes = ~std::size_t{0};
    for (const auto& format : all_formats) {
        CAPTURE(format ? int(*format) : -1);
        const PackOptions options{.format = format, .tolerance = tolerance, .poses = numbers};
        const auto [packed, report] = pack(bound.binding, options);
        CHECK(report.poses == poses.size());
        if (format && *format != WeightFormat::scalar && report.status != Status::ok) {
            // The reported reachable distance can be met.
            REQUIRE(report.status == Status::format_too_coarse);
            CHECK(packed.bytes().empty());
            CHECK(report.distance.value > tolerance);
            CHECK(report.culprit == report.distance.point);
            auto looser = options;
            looser.tolerance = 1.001 * report.distance.value;
            CHECK(pack(bound.binding, looser).report.status == Status::ok);
            continue;
        }
        REQUIRE(report.status == Status::ok);
        CHECK(report.distance.value <= tolerance);
        if (!format) open_bytes = report.bytes;
        if (format) {
            CHECK(report.format == *format);
            least_bytes = std::min(least_bytes, report.bytes);
        }
        const auto measured = distances(bound.binding, packed, poses);
        const double rounding = rounding_of_clones(bound.handles, poses, report.error.value);
        double largest = 0, sum = 0;
        for (std::size_t i = 0; i < measured.size(); ++i) {
            CHECK(measured[i] <= tolerance + rounding);
            CHECK(std::fabs(measured[i] - double(report.distances[i])) <= rounding + 1e-6 * measured[i]);
            largest = cageform_tests::larger(largest, double(report.distances[i]));
            sum += double(report.distances[i]);
        }
        CHECK(report.distance.value == Approx(largest).epsilon(1e-6));
        CHECK(report.mean_distance == Approx(sum / double(measured.size())).margin(1e-300));
        // Point and pose are those of the largest distance.
        REQUIRE(report.distance.point < measured.size());
        REQUIRE(report.distance_pose < poses.size());
        const auto in_that_pose = distances(bound.binding, packed, {poses[report.distance_pose]});
        CHECK(std::fabs(in_that_pose[report.distance.point] - report.distance.value) <= rounding);
        // Rest and affine poses are preserved.
        CHECK(cloned(packed, bound.handles) == bound.points);
        Random random(std::uint64_t(seed) + 1);
        const auto map = random_affine<D>(random, size_of(bound.handles));
        const auto affine = map(std::span<const Vec<T, D>>(bound.handles));
        const auto moved = cloned(packed, affine);
        const double affine_rounding = rounding_of_clones<T, D>(bound.handles, {affine}, report.error.value);
        for (std::size_t i = 0; i < moved.size(); ++i)
            CHECK(distance(moved[i], map(cageform::vec_cast<long double>(bound.points[i]))) <=
                  affine_rounding);
    }
    CHECK(open_bytes == least_bytes); // the smallest such format
}

TEMPLATE_TEST_CASE("without poses a tolerance holds for all poses within the reach", "[pack][tolerance]",
                   Float2, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(90, 93));
    const double share = GENERATE(0.0, 0.02); // relative to the cage's size; 0: a tenth
    CAPTURE(seed, share);
    const Bound<T, D> bound{std::uint64_t(seed)};
    const double size = cageform::bounds_of(std::span<const Vec<T, D>>(bound.handles)).diagonal();
    const PackOptions options{.tolerance = 5e-3 * size, .reach = share * size};
    const auto [packed, report] = pack(bound.binding, options);
    REQUIRE(report.status == Status::ok);
    CHECK(report.reach == Approx(share > 0 ? share * size : 0.1 * size));
    CHECK(report.poses == 0);
    CHECK(report.distance_pose == cageform::Extreme::none);
    CHECK(report.distance.value <= options.tolerance);
    CHECK(report.distance.value == Approx(report.reach * report.error.value));
    CHECK(report.distance.value >= 0.1 * options.tolerance); // weights were dropped
    Random random{std::uint64_t(seed)};
    std::vector<std::vector<Vec<T, D>>> poses;
    for (int n = 0; n < 20; ++n) {
        const auto map = random_affine<D>(random, size);
        auto pose = map(std::span<const Vec<T, D>>(bound.handles));
        for (auto& handle : pose) {
            for (std::size_t k = 0; k < D; ++k) // to a corner of the cube within the reach
                handle[k] += T((random.uniform(-1, 1) > 0 ? 1 : -1) * report.reach / std::sqrt(double(D)));
        }
        poses.push_back(std::move(pose));
    }
    const double rounding = rounding_of_clones(bound.handles, poses, report.error.value);
    for (const double distance : distances(bound.binding, packed, poses))
        CHECK(distance <= options.tolerance + rounding);
}

TEST_CASE(
    "eight weights of a bent box are a tenth of it off, and the report says so, a tolerance takes fewer",
    "[pack][tolerance]") {
    // A box of 2 by 2 by 4 faces, 42 vertices, bent by a right angle.
    const cageform_tests::MeshData box = divided_box({2, 2, 4}, 0.5);
    const auto mesh = box.mesh<float>();
    const std::vector<Vec<float, 3>> handles(mesh.vertices().begin(), mesh.vertices().end());
    REQUIRE(handles.size() == 42);
    std::vector<Vec<float, 3>> points;
    Random random(5);
    for (int i = 0; i < 1000; ++i)
        points.push_back({float(random.uniform(-0.4, 0.4)), float(random.uniform(-0.4, 0.4)),
                          float(random.uniform(-0.9, 0.9))});
    const auto binding = cageform::bind(cageform::MeanValueCoordinates<float, 3>(mesh), points).value;
    std::vector<std::vector<Vec<float, 3>>> poses;
    std::vector<double> numbers;
    for (const double angle : {0.5, 1.0, 1.57}) {
        auto& pose = poses.emplace_back(handles);
        const double radius = 2 / angle;
        for (auto& p : pose) {
            const double at = angle * (double(p[2]) + 1) / 2, arm = radius - double(p[0]);
            p = {float(radius - arm * std::cos(at)), p[1], float(arm * std::sin(at))};
        }
        cageform::append_pose(numbers, pose);
    }
    const auto eight = pack(binding, {.format = WeightFormat::int16, .largest = 8, .poses = numbers});
    REQUIRE(eight.report.status == Status::ok);
    const auto measured = distances(binding, eight.value, poses);
    const double worst = *std::max_element(measured.begin(), measured.end());
    CHECK(worst > 0.02 * eight.report.size);
    CHECK(eight.report.distance.value == Approx(worst).epsilon(1e-4));
    const auto kept = pack(binding, {.tolerance = 1e-3 * eight.report.size, .poses = numbers});
    REQUIRE(kept.report.status == Status::ok);
    CHECK(kept.report.distance.value <= 1e-3 * kept.report.size);
    CHECK(kept.report.bytes <= eight.report.bytes);
}

TEMPLATE_TEST_CASE("for vectors, the tolerance limits the length of their change", "[pack][tolerance]",
                   Float2, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(range(95, 97));
    CAPTURE(seed);
    const Bound<T, D> bound{std::uint64_t(seed)};
    const auto poses = bent_poses(bound.handles, 4, std::uint64_t(seed));
    std::vector<double> numbers;
    for (const auto& pose : poses) cageform::append_pose(numbers, pose);
    const auto points =
        pack(bound.binding, {.tolerance = 1e-3 * size_of(bound.handles), .poses = numbers}).value;
    const std::span<const std::uint32_t> order(points.view().order, bound.points.size());
    const auto vectors = random_binding<T, D>(bound.points.size(), bound.handles.size(), std::uint64_t(seed));
    const auto [packed, report] = pack(vectors, {.tolerance = 0.01, .poses = numbers, .order = order});
    REQUIRE(report.status == Status::ok);
    CHECK(std::equal(order.begin(), order.end(), packed.view().order));
    for (const double distance : distances(vectors, packed, poses))
        CHECK(distance <= 0.01 + rounding_of_clones(bound.handles, poses, report.error.value));
}

TEST_CASE("required rows are kept in addition to those of the tolerance", "[pack][tolerance]") {
    const Bound<float, 3> bound(99);
    const auto poses = bent_poses(bound.handles, 3, 99);
    std::vector<double> numbers;
    for (const auto& pose : poses) cageform::append_pose(numbers, pose);
    const double tolerance = 0.02 * size_of(bound.handles);
    const auto asked = pack(bound.binding, {.largest = 8});
    const auto both = pack(bound.binding, {.largest = 8, .tolerance = tolerance, .poses = numbers});
    REQUIRE(both.report.status == Status::ok);
    CHECK(both.report.distance.value <= tolerance);
    CHECK(both.report.rows >= asked.report.rows);
    CHECK(pack(bound.binding, {.tolerance = tolerance, .poses = numbers}).report.rows < both.report.rows);
}

TEST_CASE("a tolerance does not depend on threads, and can be cancelled", "[pack][tolerance][threads]") {
    const auto binding = random_binding<float, 3>(3000, 40, 2);
    const PackOptions options{.tolerance = 0.2};
    const auto alone = pack(binding, options);
    REQUIRE(alone.report.status == Status::ok);
    cageform::Running running{cageform::ThreadedFor{3}};
    const auto together = pack(binding, options, running);
    const auto a = alone.value.bytes(), b = together.value.bytes();
    REQUIRE(a.size() == b.size());
    CHECK(std::memcmp(a.data(), b.data(), a.size()) == 0);
    CHECK(alone.report.distances == together.report.distances);
    running.progress = [](double done) { return done < 0.3; };
    CHECK(pack(binding, options, running).report.status == Status::cancelled);
}

TEST_CASE("invalid poses and tolerances are rejected with their status", "[pack][tolerance][status]") {
    const auto binding = random_binding<float, 2>(40, 7, 3);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> poses(3 * 7 * 2);
    for (std::size_t n = 0; n < poses.size(); ++n) poses[n] = double(n * n % 11);
    const auto status = [&](const PackOptions& options) { return pack(binding, options).report.status; };
    CHECK(status({.tolerance = 0.1, .poses = poses}) == Status::ok);
    for (const WeightFormat format : {WeightFormat::int8, WeightFormat::int16, WeightFormat::half})
        CHECK(status({.format = format, .tolerance = 1e-9, .poses = poses}) == Status::format_too_coarse);
    CHECK(status({.tolerance = 1e-9, .poses = poses}) == Status::ok);
    CHECK(status({.tolerance = -0.1, .poses = poses}) == Status::value_not_finite);
    CHECK(status({.tolerance = nan, .poses = poses}) == Status::value_not_finite);
    CHECK(status({.tolerance = 0.1, .reach = -1}) == Status::value_not_finite);
    CHECK(status({.reach = nan}) == Status::value_not_finite);
    CHECK(status({.tolerance = 0.1, .poses = std::span(poses).first(41)}) == Status::pose_size_differs);
    poses[2 * 14 + 5] = 1e39; // overflows float
    const auto refused = pack(binding, {.poses = poses});
    CHECK(refused.report.status == Status::pose_not_finite);
    CHECK(refused.report.culprit == 2);
    CHECK(pack(random_binding<double, 2>(3, 70000, 4), {.tolerance = 0.1}).report.status ==
          Status::too_many_handles);
}

TEST_CASE("a tolerance for trivial bindings", "[pack][tolerance]") {
    for (const auto& format : all_formats) {
        CHECK(pack(Binding<float, 3>{}, {.format = format, .tolerance = 1}).report.status == Status::ok);
        for (const std::size_t handles : {1u, 2u, 3u, 4u}) {
            const auto binding = random_binding<float, 3>(5, handles, handles);
            const auto [packed, report] = pack(binding, {.format = format, .tolerance = 1});
            REQUIRE(report.status == Status::ok);
            CHECK(packed.view().point_count() == 5);
        }
    }
    // Points kept in place need no rows; other points of their block do.
    const std::vector<Vec<double, 2>> cage{{0, 0}, {4, 0}, {4, 2}, {0, 2}, {-1, 1}};
    std::vector<Vec<double, 2>> points{{50, 50}, {60, 50}};
    const auto bind = [&] {
        return cageform::bind(cageform::MeanValueCoordinates<double, 2>(cage), points,
                              {.outside = cageform::OutsidePoints::keep_in_place})
            .value;
    };
    CHECK(pack(bind(), {.tolerance = 1e-3}).report.rows == 0);
    points.push_back({1, 1});
    const auto packed = pack(bind(), {.tolerance = 1e-3});
    REQUIRE(packed.report.status == Status::ok);
    CHECK(packed.report.rows > 0);
    auto pose = cage;
    pose[2] = {9, 9};
    CHECK(cloned(packed.value, pose)[0] == points[0]);
}

TEST_CASE("kept rows restore all sums with the least square loss", "[pack][property]") {
    constexpr std::size_t D = 2, L = 4;
    using cageform::detail::GreedyRowSelection;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 800);
    const std::size_t handles = 7 + random.below(6);
    std::vector<Vec<double, D>> rest(handles);
    for (auto& p : rest) p = {random.uniform(-1, 1), random.uniform(-1, 1)};
    const cageform::HandleView<double, D> view(rest);
    std::vector<double> places(3 * handles * D);
    for (double& x : places) x = random.uniform(-1, 1);
    PackOptions options;
    options.poses = places;
    cageform::detail::WeightLoss<D> poses;
    std::size_t culprit = 0;
    REQUIRE(poses.load(view, options, culprit) == Status::ok);
    const cageform::detail::Moments<D> moments(view);
    const cageform::detail::SquareLoss<D> loss(moments, poses);
    std::vector<double> weights(handles * L);
    for (double& w : weights) w = random.uniform(0, 1);
    GreedyRowSelection<D, L> pursuit(loss, weights);
    while (pursuit.order().size() < handles) pursuit.add(pursuit.best());

    std::vector<double> column(handles);
    const auto lost = [&](const std::vector<double>& change) {
        double sum = 0;
        for (std::size_t h = 0; h < handles; ++h) {
            loss.column(h, column);
            for (std::size_t other = 0; other < handles; ++other)
                sum += change[h] * column[other] * change[other];
        }
        return sum;
    };
    for (std::size_t count = D + 2; count <= handles; ++count) {
        CAPTURE(count);
        const auto kept = pursuit.solution(count);
        for (std::size_t lane = 0; lane < L; ++lane) {
            std::vector<double> change(handles);
            for (std::size_t h = 0; h < handles; ++h) change[h] = -weights[h * L + lane];
            for (std::size_t j = 0; j < count; ++j) change[pursuit.order()[j]] += kept[j][lane];
            Vec<double, D + 1> missing{};
            for (std::size_t h = 0; h < handles; ++h) missing = missing + change[h] * moments[h];
            for (const double x : missing.v) CHECK(std::fabs(x) <= 1e-9);
            // Other weights of the same rows with the same sums: a random step without its affine part.
            std::vector<double> step(handles);
            for (std::size_t j = 0; j < count; ++j) step[pursuit.order()[j]] = random.uniform(-1, 1);
            Vec<double, D + 1> sums{};
            for (std::size_t h = 0; h < handles; ++h) sums = sums + step[h] * moments[h];
            const auto inverse = cageform::detail::Moments<D>::power(
                moments.sum_of_squares([&](std::size_t h) { return step[h] != 0; }), -1);
            const auto part = cageform::detail::product(inverse, sums);
            for (std::size_t h = 0; h < handles; ++h) {
                if (step[h] != 0) step[h] -= dot(part, moments[h]);
            }
            for (const double size : {0.1, -0.1}) {
                auto other = change;
                for (std::size_t h = 0; h < handles; ++h) other[h] += size * step[h];
                CHECK(lost(other) >= lost(change) - 1e-9);
            }
        }
    }
}

} // namespace pack_tests
