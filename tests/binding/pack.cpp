// Packing: what must stay (rest, affine poses, the largest weights), and that the report tells what did not.
#include "../support/meshes.hpp"
#include "../support/packed.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/mean_value_3d.hpp>
#include <cageform/core/threads.hpp>

namespace pack_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::BlobCheck;
using cageform::epsilon;
using cageform::pack;
using cageform::PackOptions;

namespace {

const auto formats = {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8};

/// A random cage with points inside and about it, bound by mean value coordinates.
template <class T, std::size_t D>
struct Bound {
    std::vector<Vec<T, D>> handles, points;
    Binding<T, D> binding;

    explicit Bound(std::uint64_t seed) {
        if constexpr (D == 2) {
            handles = random_star<T>(seed);
            const cageform::Polygon<T> cage(handles);
            Random random(seed + 7);
            for (int i = 0; i < 300; ++i) points.push_back(random_inside(cage, random, 0));
            points.push_back(cage[0]);
            binding = cageform::bind(cageform::MeanValueCoordinates<T, 2>(cage), points).binding;
        } else {
            const auto data = random_large_mesh(seed);
            const auto mesh = data.template mesh<T>();
            handles.assign(mesh.vertices().begin(), mesh.vertices().end());
            for (const auto& p : points_about(data, 300, seed)) {
                if (cageform::locate(mesh, cageform::vec_cast<T>(p), T(0)) == PointState::inside)
                    points.push_back(cageform::vec_cast<T>(p));
            }
            points.push_back(handles[0]);
            binding = cageform::bind(cageform::MeanValueCoordinates<T, 3>(mesh), points).binding;
        }
        REQUIRE(binding.point_count() == points.size());
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

TEMPLATE_TEST_CASE("packed bindings keep rest and affine poses, whatever is dropped or rounded",
                   "[pack][affine]", Float2, Double2, Float3, Double3) {
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
        // As for a plain binding, times what kept weights grow to where they were changed.
        const double size = std::max(size_of(bound.handles), size_of(pose));
        const double bound_of_error = 32 * double(epsilon<T>) * size * (1 + report.error.value);
        for (std::size_t i = 0; i < moved.size(); ++i) {
            CAPTURE(i);
            CHECK(distance(moved[i], map(cageform::vec_cast<long double>(bound.points[i]))) <=
                  bound_of_error);
        }
    }
}

TEMPLATE_TEST_CASE("the report's errors are those of the weights in effect, and bound those of poses",
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
        reach = std::max(reach, distance(pose[h], bound.handles[h]));
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
            largest = std::max(largest, double(report.errors[i]));
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

TEMPLATE_TEST_CASE("every point keeps its largest weights, within what restoring changes", "[pack][sparse]",
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
    CHECK(seen >= view.points); // or nothing was looked at
    std::vector<char> there(view.points, 0);
    for (std::size_t place = 0; place < view.points; ++place) there[view.order[place]] = 1;
    CHECK(std::count(there.begin(), there.end(), 1) == std::ptrdiff_t(view.points));
}

TEMPLATE_TEST_CASE("more weights, and finer ones, make smaller errors", "[pack][report]", Float3, Double3) {
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
    // One rounding a weight: half a step of its format.
    double largest_weight = 0;
    for (std::size_t i = 0; i < bound.points.size(); ++i) {
        for (const double w : bound.row(i)) largest_weight = std::max(largest_weight, std::fabs(w));
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

TEST_CASE("sixteen bits take half the memory of single precision weights, and sparse ones a fraction",
          "[pack]") {
    const auto binding = random_binding<float, 3>(16000, 112, 1);
    const auto size = [&](const PackOptions& options) { return double(pack(binding, options).report.bytes); };
    const double dense = double(pack(binding).report.dense_bytes);
    // Beside the weights: the points at rest and four numbers of what is missing.
    CHECK(size({.format = WeightFormat::int16}) <= (0.5 * 112 + 3 + 4 + 1) / (112 + 3) * dense);
    CHECK(size({.format = WeightFormat::int8}) <= (0.25 * 112 + 3 + 4 + 1) / (112 + 3) * dense);
}

TEST_CASE("halves round to nearest, ties to even, and tiny ones to zero", "[pack][half]") {
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

TEST_CASE("packing does not depend on threads, tells its progress, and can be cancelled", "[pack][threads]") {
    const auto binding = random_binding<float, 3>(3000, 40, 2);
    PackOptions options{.format = WeightFormat::int16, .largest = 8};
    const auto alone = pack(binding, options);
    cageform::Running running{cageform::ThreadedFor{3}};
    const auto together = pack(binding, options, running);
    const auto a = alone.binding.bytes(), b = together.binding.bytes();
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
    CHECK(stopped.binding.bytes().empty());
}

TEST_CASE("an order of one's own is kept, as vectors need that of their points", "[pack][sparse]") {
    const auto points = random_binding<float, 3>(100, 30, 6), vectors = random_binding<float, 3>(100, 30, 7);
    const auto packed = pack(points, {.largest = 8}).binding;
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

TEST_CASE("what cannot be packed is refused by name", "[pack][status]") {
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
    CHECK(refused.binding.bytes().empty());

    const auto empty = pack(Binding<float, 3>{}, {.format = WeightFormat::half, .largest = 8});
    CHECK(empty.report.status == Status::ok);
    CHECK(empty.binding.view().point_count() == 0);
}

TEST_CASE("points kept in place stay there in every pose", "[pack]") {
    const std::vector<Vec<double, 2>> cage{{0, 0}, {4, 0}, {4, 2}, {0, 2}, {-1, 1}};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Vec<double, 2>> points{{1, 1}, {50, 50}, {nan, 1}, {3, 1}};
    const auto bound = cageform::bind(cageform::MeanValueCoordinates<double, 2>(cage), points,
                                      {.outside = cageform::OutsidePoints::keep_in_place});
    auto pose = cage;
    pose[2] = {9, 9};
    for (const WeightFormat format : formats) {
        const auto [packed, report] = pack(bound.binding, {.format = format, .largest = 3});
        REQUIRE(report.status == Status::ok);
        const auto out = cloned(packed, pose);
        CHECK(out[1] == points[1]);
        CHECK((out[2][0] != out[2][0] && out[2][1] == 1));
        CHECK(out[0] != points[0]);
    }
}

} // namespace pack_tests
