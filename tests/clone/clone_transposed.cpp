// Transposed clones: the law of the adjoint for every format, finite differences of clones, threads.
#include "../support/allocation_count.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/packed.hpp"

#include <cageform/clone/clone_transposed.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/parallel/threads.hpp>

#include <functional>

namespace clone_transposed_tests {

using namespace cageform_tests;
using cageform::CloneMode;
using cageform::CloneOptions;
using cageform::epsilon;
using cageform::StridedMatrices;
using cageform::StridedPoints;

namespace {

const auto formats = {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8};

template <std::size_t D, class A, class B>
long double product_sum(const A& a, const B& b) {
    long double sum = 0;
    for (std::size_t i = 0; i < std::size(a); ++i) {
        for (std::size_t k = 0; k < D; ++k)
            sum += static_cast<long double>(a[i][k]) * static_cast<long double>(b[i][k]);
    }
    return sum;
}

/// The sizes of the terms of a clone, [point][handle]: stored numbers and residuals, which may cancel.
template <class T, std::size_t D>
std::vector<std::vector<double>> sizes_of_terms(const PackedBindingView<T, D>& view) {
    constexpr std::size_t lanes = cageform::lane_count<T>;
    std::vector<std::vector<double>> sizes(view.points, std::vector<double>(view.handles, 0.0));
    for (std::size_t place = 0; place < view.points; ++place) {
        const std::size_t block = place / lanes, lane = place % lanes;
        auto& row = sizes[view.order != nullptr ? view.order[place] : place];
        for (std::size_t r = view.first_row(block); r < view.first_row(block + 1); ++r)
            row[view.handle_of_row(block, r)] += (view.scale != nullptr ? double(view.scale[block]) : 1.0) *
                                                 std::fabs(stored_number(view, r, lane));
        for (std::size_t h = 0; view.residual != nullptr && h < view.handles; ++h) {
            for (std::size_t k = 0; k <= D; ++k)
                row[h] += std::fabs(double(view.residual[block * (D + 1) + k][lane]) *
                                    double(view.affine_fit[h][k]));
        }
    }
    return sizes;
}

/// Calls check(packed view) for a binding in all formats, with all rows and with some rows, and in the order
/// of the binding.
template <class T, std::size_t D>
void for_packed(const cageform::Binding<T, D>& binding, std::size_t largest,
                const std::function<void(const PackedBindingView<T, D>&)>& check) {
    for (const WeightFormat format : formats) {
        for (const std::size_t count : {std::size_t{0}, largest}) {
            const auto [packed, report] = cageform::pack(binding, {.format = format, .largest = count});
            REQUIRE(report.status == Status::ok);
            CAPTURE(int(format), count);
            check(packed.view());
            if (count != 0) check(packed.view().in_order());
        }
    }
}

template <class T, std::size_t D>
struct Adjoint {
    std::vector<Vec<T, D>> gradients, pose, moved, pulled;
    std::vector<T> mask;
    CloneOptions<T> options;

    Adjoint(const PackedBindingView<T, D>& view, bool masked, std::uint64_t seed)
        : gradients(random_points<T, D>(view.points, 1, seed))
        , pose(random_points<T, D>(view.handles, 10, seed + 1))
        , moved(view.points, Vec<T, D>{})
        , pulled(view.handles, Vec<T, D>{}) {
        Random random(seed + 2);
        for (std::size_t i = 0; masked && i < view.points; ++i) mask.push_back(T(random.uniform(-1, 1)));
        options.mask = {mask.data(), mask.size()};
        options.mode = CloneMode::add; // added to zeros: displacements without the rounding of points
        REQUIRE(cageform::clone(view, pose, moved, options) == Status::ok);
        options.mode = CloneMode::replace;
        REQUIRE(cageform::clone_transposed(view, gradients, pulled, options) == Status::ok);
    }
};

template <class T, std::size_t D>
void check_adjoint(const PackedBindingView<T, D>& view, bool masked, std::uint64_t seed) {
    CAPTURE(view.points, view.handles, masked, seed, D);
    const Adjoint<T, D> adjoint(view, masked, seed);
    std::vector<Vec<T, D>> moves;
    for (std::size_t h = 0; h < view.handles; ++h) moves.push_back(adjoint.pose[h] - view.rest_handles[h]);
    const auto sizes = sizes_of_terms(view);
    double size = 0;
    for (std::size_t i = 0; i < view.points; ++i) {
        for (std::size_t h = 0; h < view.handles; ++h) {
            for (std::size_t k = 0; k < D; ++k)
                size +=
                    std::fabs(double(adjoint.gradients[i][k])) * sizes[i][h] * std::fabs(double(moves[h][k]));
        }
    }
    const double gap =
        double(product_sum<D>(adjoint.gradients, adjoint.moved) - product_sum<D>(adjoint.pulled, moves));
    CHECK(std::fabs(gap) <= 64 * double(epsilon<T>) * size);
}

} // namespace

TEMPLATE_TEST_CASE("a transposed clone is the adjoint of the clone, for every format, order and mask",
                   "[clone][transposed]", CAGEFORM_SCALARS) {
    using T = TestType;
    // 32 kB hold the sums of 170 handles in 3D, 256 in 2D. Blocks are processed in groups of three, four or
    // six.
    const std::size_t handles = GENERATE(4u, 12u, 171u, 260u);
    const std::size_t points = GENERATE(1u, 15u, 16u, 100u, effort(333u, 47u));
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        const std::uint64_t seed = 1000 * handles + 10 * points + D;
        const auto binding = random_binding<T, D>(points, handles, seed);
        for_packed<T, D>(binding, 4, [&](const PackedBindingView<T, D>& view) {
            check_adjoint(view, false, seed);
            check_adjoint(view, true, seed);
        });
        check_adjoint(PackedBindingView<T, D>(binding.view()), true, seed);
    };
    check(std::integral_constant<std::size_t, 1>{});
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
}

TEMPLATE_TEST_CASE("each gradient is the sum of the weights in effect, also for many points",
                   "[clone][transposed][oracle]", CAGEFORM_SCALARS) {
    using T = TestType;
    constexpr std::size_t D = 3;
    const std::size_t points = effort(7000u, 3300u), handles = 11; // sums move to double at least twice
    const auto binding = random_binding<T, D>(points, handles, 51);
    for_packed<T, D>(binding, 5, [&](const PackedBindingView<T, D>& view) {
        const Adjoint<T, D> adjoint(view, false, 52);
        const auto weights = effective_weights(view), sizes = sizes_of_terms(view);
        for (std::size_t h = 0; h < handles; ++h) {
            for (std::size_t k = 0; k < D; ++k) {
                long double sum = 0;
                double size = 0;
                for (std::size_t i = 0; i < points; ++i) {
                    sum += static_cast<long double>(weights[i][h]) *
                           static_cast<long double>(adjoint.gradients[i][k]);
                    size += sizes[i][h] * std::fabs(double(adjoint.gradients[i][k]));
                }
                CAPTURE(h, k);
                CHECK(std::fabs(double(sum) - double(adjoint.pulled[h][k])) <=
                      64 * double(epsilon<T>) * size);
            }
        }
    });
}

TEST_CASE("gradients agree with central differences of a function of the clone", "[clone][transposed]") {
    // f is a sum of quartic and mixed terms, so its gradient varies between points.
    using T = double;
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        const auto binding = random_binding<T, D>(41, 9, 61 + D);
        const auto pose = random_points<T, D>(9, 10, 62 + D);
        const auto targets = random_points<T, D>(41, 10, 63 + D);
        for_packed<T, D>(binding, 4, [&](const PackedBindingView<T, D>& view) {
            const auto f = [&](const std::vector<Vec<T, D>>& h, std::vector<Vec<T, D>>* gradients) {
                std::vector<Vec<T, D>> out(41);
                REQUIRE(cageform::clone(view, h, out) == Status::ok);
                long double sum = 0;
                for (std::size_t i = 0; i < out.size(); ++i) {
                    const auto d = out[i] - targets[i];
                    const T square = dot(d, d) / 100;
                    sum += static_cast<long double>(square * square);
                    if (gradients != nullptr) gradients->push_back((4 * square / 100) * d);
                }
                return sum;
            };
            std::vector<Vec<T, D>> gradients, pulled(9);
            (void)f(pose, &gradients);
            REQUIRE(cageform::clone_transposed(view, gradients, pulled) == Status::ok);
            double largest = 0, worst = 0;
            for (std::size_t h = 0; h < 9; ++h) {
                for (std::size_t k = 0; k < D; ++k) {
                    const double step = 1e-4;
                    auto ahead = pose, behind = pose;
                    ahead[h][k] += step;
                    behind[h][k] -= step;
                    const auto difference =
                        double(f(ahead, nullptr) - f(behind, nullptr)) / (ahead[h][k] - behind[h][k]);
                    worst = cageform_tests::larger(worst, std::fabs(difference - pulled[h][k]));
                    largest = cageform_tests::larger(largest, std::fabs(pulled[h][k]));
                }
            }
            CAPTURE(D);
            CHECK(largest > 0.1);
            CHECK(worst <= 1e-8 * largest);
        });
    };
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
}

TEMPLATE_TEST_CASE("threads, and any ranges of handles, give the same bits", "[clone][transposed][threads]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = random_binding<T, 3>(4000, 200, 71);
    const auto gradients = random_points<T, 3>(4000, 1, 72);
    const auto backwards = [](std::size_t count, std::size_t, const auto& body) {
        for (std::size_t end = count; end > 0; end -= end < 3 ? end : 3) body(end < 3 ? 0 : end - 3, end);
    };
    const auto check = [&](const auto& view) {
        std::vector<Vec<T, 3>> expected(200), threaded(200), cut(200);
        CHECK(cageform::clone_transposed(view, gradients, expected) == Status::ok);
        CHECK(cageform::clone_transposed(view, gradients, threaded, {}, cageform::ThreadedFor{3}) ==
              Status::ok);
        CHECK(cageform::clone_transposed(view, gradients, cut, {}, backwards) == Status::ok);
        CHECK(threaded == expected);
        CHECK(cut == expected);
    };
    check(binding.view());
    for_packed<T, 3>(binding, 10, check);
}

TEMPLATE_TEST_CASE("gradients replace what the output holds or are added to it, in any layout",
                   "[clone][transposed][ranges]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = random_binding<T, 3>(37, 20, 81);
    const auto gradients = random_points<T, 3>(37, 1, 82), before = random_points<T, 3>(20, 1, 83);
    std::vector<Vec<T, 3>> expected(20), added = before;
    REQUIRE(cageform::clone_transposed(binding, gradients, expected) == Status::ok);
    REQUIRE(cageform::clone_transposed(binding, gradients, added, {.mode = CloneMode::add}) == Status::ok);
    for (std::size_t h = 0; h < 20; ++h)
        CHECK(distance(added[h], before[h] + expected[h]) <= 4 * double(epsilon<T>));
    // x x x … y y y … z z z … of the other scalar, read and written.
    using S = std::conditional_t<std::is_same_v<T, float>, double, float>;
    std::vector<S> numbers(3 * 37), result(3 * 25, S(7));
    for (std::size_t i = 0; i < 37; ++i) {
        for (std::size_t k = 0; k < 3; ++k) numbers[k * 37 + i] = S(float(gradients[i][k]));
    }
    std::vector<Vec<T, 3>> rounded;
    for (const auto& g : gradients) rounded.push_back(cageform::vec_cast<T>(cageform::vec_cast<float>(g)));
    REQUIRE(cageform::clone_transposed(binding, rounded, expected) == Status::ok);
    const StridedPoints<const S, 3> source(numbers.data(), 37, sizeof(S), 37 * sizeof(S));
    StridedPoints<S, 3> target(result.data(), 25, sizeof(S), 25 * sizeof(S));
    REQUIRE(cageform::clone_transposed(binding, source, target) == Status::ok);
    for (std::size_t h = 0; h < 20; ++h)
        CHECK(distance(target[h], expected[h]) <= 2 * double(epsilon<float>));
    for (std::size_t h = 20; h < 25; ++h) CHECK(target[h] == Vec<S, 3>{7, 7, 7}); // after the last handle
}

TEMPLATE_TEST_CASE("lanes without a point are not read, and a gradient that is not finite propagates",
                   "[clone][transposed]", CAGEFORM_SCALARS) {
    using T = TestType;
    constexpr T nan = std::numeric_limits<T>::quiet_NaN();
    const auto binding = random_binding<T, 2>(21, 6, 91);
    const auto handles = binding_handles(binding);
    auto gradients = random_points<T, 2>(21, 1, 92);
    std::vector<Vec<T, 2>> expected(6), pulled(6);
    REQUIRE(cageform::clone_transposed(binding, gradients, expected) == Status::ok);
    auto [weights, rest] = cageform::Binding<T, 2>(binding).release();
    const std::size_t last = weights.size() / 6 - 1; // block
    for (std::size_t h = 0; h < 6; ++h) {
        for (std::size_t lane = 21 - last * cageform::lane_count<T>; lane < cageform::lane_count<T>; ++lane)
            weights[last * 6 + h][lane] = nan;
    }
    const cageform::Binding<T, 2> spoilt(std::move(weights), std::move(rest), handles, 21);
    REQUIRE(cageform::clone_transposed(spoilt, gradients, pulled) == Status::ok);
    CHECK(pulled == expected);
    gradients[3][1] = nan;
    REQUIRE(cageform::clone_transposed(binding, gradients, pulled) == Status::ok);
    for (std::size_t h = 0; h < 6; ++h) {
        CHECK(std::isnan(pulled[h][1]));
        CHECK(pulled[h][0] == expected[h][0]);
    }
    // No points: no gradient.
    const auto none = random_binding<T, 2>(0, 6, 93);
    REQUIRE(cageform::clone_transposed(none, std::vector<Vec<T, 2>>{}, pulled) == Status::ok);
    CHECK(pulled == std::vector<Vec<T, 2>>(6));
}

namespace {

/// Checks gradients of a function of a pose, `value(pose)`, in random directions against central differences.
template <class T, std::size_t D, class Value>
void check_directions(const std::vector<Vec<T, D>>& pose, const std::vector<Vec<T, D>>& gradients,
                      double tolerance, std::uint64_t seed, const Value& value) {
    for (std::uint64_t n = 0; n < 10; ++n) {
        const auto direction = random_points<T, D>(pose.size(), 1, seed + n);
        const T step = T(1e-5);
        auto ahead = pose, behind = pose;
        double size = 0;
        for (std::size_t h = 0; h < pose.size(); ++h) {
            ahead[h] = pose[h] + step * direction[h];
            behind[h] = pose[h] - step * direction[h];
            for (std::size_t k = 0; k < D; ++k)
                size += std::fabs(double(gradients[h][k]) * double(direction[h][k]));
        }
        const double difference = double(value(ahead) - value(behind)) / (2 * double(step));
        CAPTURE(seed, n, D);
        CHECK(std::fabs(difference - double(product_sum<D>(gradients, direction))) <= tolerance * size);
    }
}

} // namespace

TEST_CASE("transposed clones of Jacobians add up those of their columns", "[clone][transposed][jacobians]") {
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        std::array<cageform::PackedBinding<double, D>, D> columns;
        for (std::size_t k = 0; k < D; ++k)
            columns[k] = cageform::pack(random_binding<double, D>(53, 10, 100 + k),
                                        {.format = WeightFormat::int16, .largest = 5 + k})
                             .value;
        Random random(104);
        std::vector<double> matrices(53 * D * D);
        for (double& x : matrices) x = random.uniform(-1, 1);
        const StridedMatrices<const double, D> gradients(matrices.data(), 53);
        const auto pose = random_points<double, D>(10, 10, 105);
        std::vector<Vec<double, D>> pulled(10), sum(10), added = pose;
        REQUIRE(cageform::clone_jacobians_transposed(columns, gradients, pulled) == Status::ok);
        for (std::size_t k = 0; k < D; ++k)
            REQUIRE(cageform::clone_transposed(columns[k], gradients.column(k), sum,
                                               {.mode = CloneMode::add}) == Status::ok);
        for (std::size_t h = 0; h < 10; ++h) CHECK(distance(sum[h], pulled[h]) <= 1e-14);
        REQUIRE(cageform::clone_jacobians_transposed(columns, gradients, added, CloneMode::add) ==
                Status::ok);
        for (std::size_t h = 0; h < 10; ++h) CHECK(distance(added[h], pose[h] + pulled[h]) <= 1e-14);
        check_directions<double, D>(pose, pulled, 1e-8, 106, [&](const std::vector<Vec<double, D>>& h) {
            std::vector<double> jacobians(matrices.size());
            REQUIRE(clone_jacobians(columns, h, StridedMatrices<double, D>(jacobians.data(), 53)) ==
                    Status::ok);
            long double f = 0;
            for (std::size_t i = 0; i < matrices.size(); ++i)
                f += static_cast<long double>(jacobians[i]) * static_cast<long double>(matrices[i]);
            return f;
        });
    };
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
}

TEST_CASE("gradients of normals agree with central differences", "[clone][transposed][normals]") {
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        const std::size_t points = 700, handles = 12; // three tiles of tangents
        std::array<cageform::Binding<double, D>, D - 1> dense;
        std::array<cageform::PackedBinding<double, D>, D - 1> packed;
        std::vector<std::uint32_t> order(points);
        for (std::size_t n = 0; n < points; ++n) order[n] = std::uint32_t(n * 37 % points);
        std::array<PackedBindingView<double, D>, D - 1> views;
        for (std::size_t k = 0; k + 1 < D; ++k) {
            dense[k] = random_binding<double, D>(points, handles, 110 + k);
            packed[k] = cageform::pack(dense[k], {.format = WeightFormat::int8}).value;
            views[k] = packed[k].view();
            views[k].order = order.data();
        }
        const auto gradients = random_points<double, D>(points, 1, 112);
        const auto run = [&](const auto& tangents) {
            auto pose = random_points<double, D>(handles, 1, 113);
            for (std::size_t h = 0; h < handles; ++h) pose[h] = pose[h] + dense[0].rest_handle(h);
            std::vector<Vec<double, D>> pulled(handles), threaded(handles), added = pose;
            REQUIRE(cageform::clone_normals_transposed(tangents, pose, gradients, pulled) == Status::ok);
            const auto each = [](std::size_t count, std::size_t, const auto& body) {
                for (std::size_t i = 0; i < count; ++i) body(i, i + 1);
            };
            REQUIRE(cageform::clone_normals_transposed(tangents, pose, gradients, threaded,
                                                       CloneMode::replace, each) == Status::ok);
            CHECK(threaded == pulled);
            REQUIRE(cageform::clone_normals_transposed(tangents, pose, gradients, added, CloneMode::add) ==
                    Status::ok);
            for (std::size_t h = 0; h < handles; ++h) CHECK(distance(added[h], pose[h] + pulled[h]) <= 1e-12);
            check_directions<double, D>(pose, pulled, 1e-6, 114, [&](const std::vector<Vec<double, D>>& h) {
                std::vector<Vec<double, D>> normals(points);
                REQUIRE(cageform::clone_normals(tangents, h, normals) == Status::ok);
                return product_sum<D>(normals, gradients);
            });
        };
        run(dense);
        run(views);
    };
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
}

TEST_CASE("tangents of very different sizes, and nearly parallel ones, have gradients of normals too",
          "[clone][transposed][normals]") {
    // One handle of weight 1 and its tangent in each of D − 1 bindings, posed separately. The pose is the
    // tangent, so the gradients are known.
    const auto tangent = [](const Vec<double, 3>& rest, std::size_t handle) {
        std::vector<cageform::Lanes<double>> weights(2), place(3);
        for (std::size_t lane = 0; lane < 8; ++lane) {
            for (std::size_t h = 0; h < 2; ++h) weights[h][lane] = h == handle ? 1 : 0;
            for (std::size_t k = 0; k < 3; ++k) place[k][lane] = rest[k];
        }
        return cageform::Binding<double, 3>(std::move(weights), std::move(place),
                                            std::vector<Vec<double, 3>>(2), 1);
    };
    const std::array bound{tangent({1, 0, 0}, 0), tangent({0, 1, 0}, 1)};
    const std::vector<Vec<double, 3>> gradient{{0.3, -0.5, 0.7}};
    std::vector<Vec<double, 3>> pulled(2);
    // t' = size (1, 0, 0) and b' = (0, 1, 0): a change dz of t' changes n by (−dz/size, …).
    for (const double size : {1.0, 1e-3, 1e-11, 1e12}) {
        const std::vector<Vec<double, 3>> pose{{size - 1, 0, 0}, {0, 0, 0}};
        REQUIRE(cageform::clone_normals_transposed(bound, pose, gradient, pulled) == Status::ok);
        CAPTURE(size);
        const double moved = (size - 1) + 1; // rounded as by the clone
        CHECK(std::fabs(pulled[0][2] * moved + 0.3) <= 1e-12);
        CHECK(std::fabs(pulled[1][2] - 0.5) <= 1e-12);
        for (const std::size_t h : {0u, 1u}) {
            for (const std::size_t k : {0u, 1u}) CHECK(pulled[h][k] == 0);
        }
    }
    // b' = (1, tilt, 0) beside t' = (1, 0, 0), with c = (0, 0, tilt).
    const double tilt = 1e-5;
    REQUIRE(cageform::clone_normals_transposed(bound,
                                               std::vector<Vec<double, 3>>{{0, 0, 0}, {1, tilt - 1, 0}},
                                               gradient, pulled) == Status::ok);
    // dn = (−b'_y dt_z, b'_x dt_z …) / tilt: for t'_z, c moves by (−tilt, 1, 0) dz.
    CHECK(std::fabs(pulled[0][2] - (-0.3 - 0.5 / tilt)) <= 1e-5);
    CHECK(std::fabs(pulled[1][2] - 0.5 / tilt) <= 1e-5);
    // Parallel or zero tangents: the normal is that at rest and has no gradient.
    for (const Vec<double, 3>& second : {Vec<double, 3>{2, -1, 0}, Vec<double, 3>{0, -1, 0}}) {
        REQUIRE(cageform::clone_normals_transposed(bound, std::vector<Vec<double, 3>>{{0, 0, 0}, second},
                                                   gradient, pulled) == Status::ok);
        CHECK(pulled == std::vector<Vec<double, 3>>(2));
    }
}

TEST_CASE("transposed clones refuse invalid arguments, leave the output unchanged and allocate nothing",
          "[clone][transposed][status]") {
    using cageform::clone_jacobians_transposed;
    using cageform::clone_normals_transposed;
    using cageform::clone_transposed;
    const auto first = random_binding<float, 3>(20, 6, 121), fewer = random_binding<float, 3>(19, 6, 122),
               others = random_binding<float, 3>(20, 5, 123);
    const auto gradients = random_points<float, 3>(20, 1, 124);
    auto pose = random_points<float, 3>(6, 10, 125);
    const auto before = random_points<float, 3>(6, 1, 126);
    auto out = before;
    const std::span<const Vec<float, 3>> few_gradients(gradients.data(), 19);
    const std::span<Vec<float, 3>> few_out(out.data(), 5);
    const std::vector<float> numbers(9 * 20), mask(19);
    const StridedMatrices<const float, 3> matrices(numbers.data(), 20), few_matrices(numbers.data(), 19);
    const std::array three{first.view(), first.view(), first.view()};
    const std::array two{first.view(), first.view()};
    CHECK(clone_transposed(first, gradients, few_out) == Status::output_too_small);
    CHECK(clone_transposed(first, few_gradients, out) == Status::too_few_gradients);
    CHECK(clone_transposed(first, gradients, out, {{mask.data(), 19}}) == Status::mask_too_small);
    CHECK(clone_jacobians_transposed(three, matrices, few_out) == Status::output_too_small);
    CHECK(clone_jacobians_transposed(three, few_matrices, out) == Status::too_few_gradients);
    for (const auto& other : {fewer.view(), others.view()}) {
        CHECK(clone_jacobians_transposed(std::array{three[0], three[1], other}, matrices, out) ==
              Status::bindings_differ);
        CHECK(clone_normals_transposed(std::array{two[0], other}, pose, gradients, out) ==
              Status::bindings_differ);
    }
    CHECK(clone_normals_transposed(two, pose, gradients, few_out) == Status::output_too_small);
    CHECK(clone_normals_transposed(two, pose, few_gradients, out) == Status::too_few_gradients);
    CHECK(clone_normals_transposed(two, few_out, gradients, out) == Status::pose_size_differs);
    pose[2][1] = std::numeric_limits<float>::infinity();
    CHECK(clone_normals_transposed(two, pose, gradients, out) == Status::pose_not_finite);
    CHECK(out == before);
    pose[2][1] = 1;
    const std::size_t allocated = allocations;
    const Status statuses[] = {clone_transposed(first, gradients, out),
                               clone_jacobians_transposed(three, matrices, out),
                               clone_normals_transposed(two, pose, gradients, out)};
    const std::size_t after = allocations;
    CHECK(after == allocated);
    for (const Status status : statuses) CHECK(status == Status::ok);
    STATIC_REQUIRE(noexcept(clone_transposed(first, gradients, out)));
}

} // namespace clone_transposed_tests
