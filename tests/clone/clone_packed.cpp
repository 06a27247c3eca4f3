// Clones by packed bindings: every format and layout against its documentation, and laws shared with dense
// bindings.
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/packed.hpp"

#include <cageform/parallel/threads.hpp>

namespace clone_packed_tests {

using namespace cageform_tests;
using cageform::CloneMode;
using cageform::CloneOptions;
using cageform::epsilon;
using cageform::StridedPoints;

namespace {

const auto formats = {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8};

template <class T, std::size_t D>
std::vector<Vec<T, D>> cloned(const PackedBindingView<T, D>& binding, const std::vector<Vec<T, D>>& pose,
                              const CloneOptions<T>& options = {}) {
    std::vector<Vec<T, D>> out(binding.point_count());
    REQUIRE(cageform::clone(binding, pose, out, options) == Status::ok);
    return out;
}

} // namespace

TEST_CASE("a view in order clones points in the order of the binding", "[clone][packed]") {
    const auto packed = cageform::pack(random_binding<float, 3>(100, 9, 1), {.largest = 4});
    REQUIRE(packed.report.status == Status::ok);
    const auto view = packed.value.view();
    REQUIRE(view.order != nullptr);
    const auto pose = random_points<float, 3>(9, 10, 2);
    const auto as_bound = cloned(view, pose), in_order = cloned(view.in_order(), pose);
    for (std::size_t n = 0; n < as_bound.size(); ++n) CHECK(in_order[n] == as_bound[view.order[n]]);
}

TEMPLATE_TEST_CASE("a clone by a packed binding is the sum of its weights, for every format and size",
                   "[clone][packed][oracle]", CAGEFORM_SCALARS) {
    // A table holds up to 512 handles; dense rows come in groups of 256; blocks have 8 or 16 points.
    using T = TestType;
    const std::size_t handles = GENERATE(5u, 6u, 17u, 256u, 257u, 513u, 600u);
    const std::size_t points = GENERATE(1u, 7u, 8u, 9u, 16u, 17u, effort(100u, 33u));
    const std::size_t largest = GENERATE(0u, 4u, 20u);
    CAPTURE(handles, points, largest);
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        const auto binding = random_binding<T, D>(points, handles, handles + points + largest);
        const auto pose = random_points<T, D>(handles, 10, handles);
        for (const WeightFormat format : formats) {
            CAPTURE(D, int(format));
            const auto [packed, report] = cageform::pack(binding, {.format = format, .largest = largest});
            REQUIRE(report.status == Status::ok);
            const auto view = packed.view();
            REQUIRE((view.row_begin != nullptr) == (largest != 0 && largest < handles));
            const auto moved = cloned(view, pose);
            const auto weights = effective_weights(view);
            double worst = 0, reach = 0;
            for (std::size_t i = 0; i < points; ++i) {
                auto p = cageform::vec_cast<double>(binding.rest_point(i));
                double sum = 10;
                for (std::size_t h = 0; h < handles; ++h) {
                    p = p + weights[i][h] * (cageform::vec_cast<double>(pose[h]) -
                                             cageform::vec_cast<double>(binding.rest_handle(h)));
                    sum += 20 * std::fabs(weights[i][h]);
                }
                worst = cageform_tests::larger(worst, distance(moved[i], p));
                reach = cageform_tests::larger(reach, sum);
            }
            // The terms sum to at most `reach`; each addition rounds.
            CHECK(worst <= 2 * double(epsilon<T>) * reach * std::sqrt(double(D * handles)));
        }
    };
    // Reading of formats does not depend on the dimension, so one scalar suffices for one dimension.
    if constexpr (std::is_same_v<T, float>) {
        check(std::integral_constant<std::size_t, 1>{});
        check(std::integral_constant<std::size_t, 2>{});
    }
    check(std::integral_constant<std::size_t, 3>{});
}

TEMPLATE_TEST_CASE("a binding viewed as packed clones the same bits", "[clone][packed]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = random_binding<T, 3>(1000, 300, 21);
    const auto pose = random_points<T, 3>(300, 10, 22);
    CHECK(cloned(PackedBindingView<T, 3>(binding.view()), pose) == cageform_tests::cloned(binding, pose));
    const auto [packed, report] = cageform::pack(binding);
    REQUIRE(report.status == Status::ok);
    std::vector<Vec<T, 3>> of_owner(1000);
    CHECK(cageform::clone(packed, pose, of_owner) == Status::ok);
    CHECK(of_owner == cageform_tests::cloned(binding, pose));
}

TEST_CASE("clone accepts owners and views of bindings only", "[clone][packed][concept]") {
    STATIC_REQUIRE(cageform::AnyBinding<cageform::Binding<float, 2>>);
    STATIC_REQUIRE(cageform::AnyBinding<cageform::BindingView<double, 3>>);
    STATIC_REQUIRE(cageform::AnyBinding<cageform::PackedBinding<double, 1>>);
    STATIC_REQUIRE(cageform::AnyBinding<PackedBindingView<float, 3>>);
    STATIC_REQUIRE(!cageform::AnyBinding<int>);
    STATIC_REQUIRE(!cageform::AnyBinding<std::vector<Vec<float, 3>>>);
}

TEMPLATE_TEST_CASE("packed bindings at rest give the bound points bit for bit", "[clone][packed][rest]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    auto binding = random_binding<T, 3>(100, 20, 23);
    auto [weights, rest] = std::move(binding).release();
    rest[0][0] = T(-0.0);
    rest[1][1] = std::numeric_limits<T>::quiet_NaN();
    rest[2][2] = std::numeric_limits<T>::infinity();
    const auto handles = random_points<T, 3>(20, 10, 24);
    binding = {std::move(weights), std::move(rest), handles, 100};
    for (const WeightFormat format : formats) {
        for (const std::size_t largest : {0u, 6u}) {
            const auto [packed, report] = cageform::pack(binding, {.format = format, .largest = largest});
            REQUIRE(report.status == Status::ok);
            const auto out = cloned(packed.view(), handles);
            for (std::size_t i = 0; i < 100; ++i) {
                const auto p = binding.rest_point(i);
                CAPTURE(int(format), largest, i);
                CHECK(std::memcmp(&p, &out[i], sizeof(p)) == 0);
            }
        }
    }
}

TEMPLATE_TEST_CASE("a mask scales displacements, and clones onto an output add up", "[clone][mask]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const std::size_t points = GENERATE(1u, 16u, 37u);
    const auto binding = random_binding<T, 3>(points, 20, 25);
    const auto pose = random_points<T, 3>(20, 10, 26);
    const auto full = cageform_tests::cloned(binding, pose);
    Random random(27);
    std::vector<std::array<T, 2>> vertex(points); // the mask is the second number of each vertex
    for (auto& v : vertex) v = {T(7), T(random.uniform(0, 1))};
    vertex[0][1] = 0;
    const CloneOptions<T> masked{.mask = {&vertex[0][1], points, sizeof(vertex[0])}};
    CloneOptions<T> added = masked;
    added.mode = CloneMode::add;
    const auto [packed, report] = cageform::pack(binding, {.largest = 8});
    const auto full_packed = cloned(packed.view(), pose);
    const auto check = [&](const auto& view, const auto& whole) {
        std::vector<Vec<T, 3>> out(points), twice;
        REQUIRE(cageform::clone(view, pose, out, masked) == Status::ok);
        CHECK(out[0] == binding.rest_point(0));
        twice = out;
        REQUIRE(cageform::clone(view, pose, twice, added) == Status::ok);
        for (std::size_t i = 0; i < points; ++i) {
            const auto p = binding.rest_point(i);
            const auto expected = p + vertex[i][1] * (whole[i] - p);
            CHECK(distance(out[i], expected) <= 100 * double(epsilon<T>));
            CHECK(distance(twice[i], expected + (expected - p)) <= 200 * double(epsilon<T>));
        }
        const CloneOptions<T> short_mask{.mask = {&vertex[0][1], points - 1, sizeof(vertex[0])}};
        if (points > 1) {
            const auto before = out;
            CHECK(cageform::clone(view, pose, out, short_mask) == Status::mask_too_small);
            CHECK(out == before);
        }
    };
    check(binding.view(), full);
    check(packed.view(), full_packed);
}

TEMPLATE_TEST_CASE("several bindings fill one buffer, in either layout", "[clone][ranges]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto body = random_binding<T, 3>(37, 20, 31);
    const auto coat = random_binding<T, 3>(21, 9, 32);
    const auto body_pose = random_points<T, 3>(20, 10, 33);
    const auto coat_pose = random_points<T, 3>(9, 10, 34);
    const auto first = cageform_tests::cloned(body, body_pose),
               second = cageform_tests::cloned(coat, coat_pose);
    const auto packed = cageform::pack(coat, {.format = WeightFormat::int16, .largest = 5}).value;
    const auto third = cloned(packed.view(), coat_pose);

    std::vector<T> numbers(3 * (37 + 21 + 21));
    const auto check = [&](const StridedPoints<T, 3>& buffer) {
        std::fill(numbers.begin(), numbers.end(), T(0));
        CHECK(cageform::clone(body, body_pose, buffer.subview(0, 37)) == Status::ok);
        CHECK(cageform::clone(coat, coat_pose, buffer.subview(37, 21)) == Status::ok);
        CHECK(cageform::clone(packed.view(), coat_pose, buffer.subview(58, 21)) == Status::ok);
        for (std::size_t i = 0; i < 37; ++i) CHECK(buffer[i] == first[i]);
        for (std::size_t i = 0; i < 21; ++i) CHECK(buffer[37 + i] == second[i]);
        for (std::size_t i = 0; i < 21; ++i) CHECK(buffer[58 + i] == third[i]);
    };
    check({numbers.data(), 79});                                          // x y z x y z …
    check({numbers.data(), 79, sizeof(T), 79 * sizeof(T)});               // x x x … y y y … z z z …
    check({numbers.data() + 78 * 3, 79, -3 * std::ptrdiff_t(sizeof(T))}); // backwards
}

TEMPLATE_TEST_CASE("threads, and any ranges, give the same bits from packed bindings",
                   "[clone][packed][threads]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = random_binding<T, 3>(5000, 100, 35);
    const auto pose = random_points<T, 3>(100, 10, 36);
    const auto packed = cageform::pack(binding, {.format = WeightFormat::int16, .largest = 10}).value;
    const auto expected = cloned(packed.view(), pose);
    std::vector<Vec<T, 3>> out(5000);
    CHECK(cageform::clone(packed.view(), pose, out, {}, cageform::ThreadedFor{3}) == Status::ok);
    CHECK(out == expected);
    const auto backwards = [](std::size_t count, std::size_t, const auto& body) {
        for (std::size_t end = count; end > 0; --end) body(end - 1, end);
    };
    std::fill(out.begin(), out.end(), Vec<T, 3>{});
    CHECK(cageform::clone(packed.view(), pose, out, {}, backwards) == Status::ok);
    CHECK(out == expected);
}

TEST_CASE("a packed binding refuses poses and outputs as a binding does", "[clone][packed][status]") {
    const auto binding = random_binding<float, 2>(20, 6, 37);
    const auto packed = cageform::pack(binding, {.largest = 4}).value;
    auto pose = random_points<float, 2>(6, 10, 38);
    std::vector<Vec<float, 2>> out(20);
    const auto before = out;
    CHECK(cageform::clone(packed.view(), std::vector<Vec<float, 2>>(5), out) == Status::pose_size_differs);
    CHECK(cageform::clone(packed.view(), pose, std::span(out).first(19)) == Status::output_too_small);
    pose[3][1] = std::numeric_limits<float>::infinity();
    CHECK(cageform::clone(packed.view(), pose, out) == Status::pose_not_finite);
    CHECK(out == before);
    std::vector<Vec<float, 2>> nothing;
    CHECK(cageform::clone(cageform::PackedBinding<float, 2>().view(), nothing, nothing) == Status::ok);
    STATIC_REQUIRE(noexcept(cageform::clone(packed.view(), pose, out)));
}

} // namespace clone_packed_tests
