// The clone operator: the rest pose, affine poses, linearity, and guarantees of a frame.
#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/bindings.hpp"
#include "support/larger.hpp"
#include "support/uniform_harmonic.hpp"
#include "support/weights.hpp"

#include <cageform/adapt/eigen.hpp>
#include <cageform/adapt/glm.hpp>
#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

#include <array>
#include <cstdlib>
#include <cstring>

namespace clone_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::block_count;
using cageform::epsilon;
using cageform::lane_count;
using cageform::Lanes;
using cageform::OutsidePoints;
using cageform::Polygon;

namespace {

template <class T>
using Mean = cageform::MeanValueCoordinates<T, 2>;
template <class T>
using Harmonic = cageform_tests::UniformHarmonic<T, 2>;
template <class T, std::size_t D>
using Bary = cageform::BarycentricCoordinates<T, D>;

template <class C>
inline constexpr bool is_simplex_type = false;
template <class T, std::size_t D>
inline constexpr bool is_simplex_type<Bary<T, D>> = true;

/// A binding of one of the types, with points inside, on the boundary and outside.
template <class C>
struct Case {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

    std::vector<Vec<T, D>> handles;
    std::vector<Vec<T, D>> inside, outside;

    explicit Case(std::uint64_t seed) {
        Random random(seed + 100);
        if constexpr (is_simplex_type<C>) {
            handles = random_simplex<T, D>(seed);
            for (int i = 0; i < 60; ++i) {
                auto shares = random_shares(D + 1, random);
                if (i % 5 == 0) { // onto a face
                    shares[1] += shares[0];
                    shares[0] = 0;
                }
                inside.push_back(cageform::vec_cast<T>(combine(shares, handles)));
            }
        } else {
            handles = random_star<T>(seed);
            const Polygon<T> cage(handles);
            for (int i = 0; i < 60; ++i) inside.push_back(random_inside(cage, random, 0));
            for (std::size_t edge = 0; edge < cage.size(); ++edge) {
                inside.push_back(cage[edge]);
                inside.push_back(on_edge(cage, edge, random.uniform(0, 1)).position);
            }
        }
        const T size = T(size_of(handles));
        for (int i = 0; i < 20; ++i) {
            Vec<T, D> p = handles[0];
            for (std::size_t k = 0; k < D; ++k)
                p[k] += size * T(random.uniform(1, 2)) * T(i % 2 == 0 ? 1 : -1);
            outside.push_back(p);
        }
    }

    C coordinates() const {
        if constexpr (is_simplex_type<C>) {
            return C(handles);
        } else {
            return C(Polygon<T>(handles));
        }
    }
};

template <class T>
bool same_bits(T a, T b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Whether a range of any point type equals `expected`.
template <class R, class T, std::size_t D>
bool are_equal(const R& range, const std::vector<Vec<T, D>>& expected) {
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (cageform::to_vec<T>(range[i]) != expected[i]) return false;
    }
    return true;
}

} // namespace

// All types, scalars and dimensions, but not all combinations, which the tests of binding cover.
#define CAGEFORM_TEST_TYPES                                                                                  \
    (Bary<double, 1>), (Bary<float, 2>), (Bary<double, 3>), (Mean<double>), (Harmonic<float>)

TEMPLATE_TEST_CASE("the rest pose gives the bound points bit for bit", "[clone][rest]", CAGEFORM_TEST_TYPES) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(6));
    const auto policy =
        GENERATE(OutsidePoints::extend, OutsidePoints::keep_in_place, OutsidePoints::nearest_boundary);
    CAPTURE(seed, int(policy));
    const Case<TestType> example{std::uint64_t(seed)};
    auto points = example.inside;
    points.insert(points.end(), example.outside.begin(), example.outside.end());
    for (const T x : {std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(),
                      -std::numeric_limits<T>::infinity()}) {
        points.push_back(points[0]);
        points.back()[D - 1] = x;
    }
    const auto [binding, report] = cageform::bind(example.coordinates(), points, {.outside = policy});
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.not_finite.size() == 3);
    REQUIRE(!report.outside.empty());
    std::vector<Vec<T, D>> out(points.size());
    REQUIRE(cageform::clone(binding, example.handles, out) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        for (std::size_t k = 0; k < D; ++k) CHECK(same_bits(out[i][k], points[i][k]));
    }
}

TEMPLATE_TEST_CASE("an affine pose moves every point by the affine map", "[clone][affine]",
                   CAGEFORM_TEST_TYPES) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(12));
    CAPTURE(seed);
    const Case<TestType> example{std::uint64_t(seed)};
    const auto [binding, report] = cageform::bind(example.coordinates(), example.inside);
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.unreached.empty());
    REQUIRE(report.outside.empty());
    REQUIRE(!report.on_boundary.empty());
    Random random(std::uint64_t(seed) + 1);
    for (int n = 0; n < 5; ++n) {
        const auto map = random_affine<D>(random, size_of(example.handles));
        const auto pose = map(std::span<const Vec<T, D>>(example.handles));
        const auto moved = cloned(binding, pose);
        const double bound = 32 * double(epsilon<T>) * std::max(size_of(example.handles), size_of(pose));
        for (std::size_t i = 0; i < moved.size(); ++i) {
            CAPTURE(n, i);
            CHECK(distance(moved[i], map(cageform::vec_cast<long double>(example.inside[i]))) <= bound);
        }
    }
}

TEMPLATE_TEST_CASE("clones are linear in the displacement of the pose", "[clone][linear]",
                   CAGEFORM_TEST_TYPES) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(6));
    CAPTURE(seed);
    const Case<TestType> example{std::uint64_t(seed)};
    const auto binding = cageform::bind(example.coordinates(), example.inside).value;
    REQUIRE(binding.point_count() == example.inside.size());
    const double size = size_of(example.handles);
    Random random(std::uint64_t(seed) + 2);
    auto a = example.handles, b = example.handles, both = example.handles;
    const T s = T(random.uniform(-2, 2)), t = T(random.uniform(-2, 2));
    for (std::size_t h = 0; h < example.handles.size(); ++h) {
        for (std::size_t k = 0; k < D; ++k) {
            const T u = T(size * random.uniform(-1, 1)), v = T(size * random.uniform(-1, 1));
            a[h][k] += u;
            b[h][k] += v;
            both[h][k] += s * u + t * v;
        }
    }
    const auto of_a = cloned(binding, a), of_b = cloned(binding, b), of_both = cloned(binding, both);
    for (std::size_t i = 0; i < example.inside.size(); ++i) {
        const auto p = cageform::vec_cast<double>(example.inside[i]);
        const auto expected = p + double(s) * (cageform::vec_cast<double>(of_a[i]) - p) +
                              double(t) * (cageform::vec_cast<double>(of_b[i]) - p);
        std::vector<T> row;
        for (std::size_t h = 0; h < binding.handle_count(); ++h) row.push_back(binding.weight(i, h));
        CAPTURE(i);
        // Displacements are up to four sizes, two of them scaled by up to two: some ten roundings of each.
        CHECK(distance(of_both[i], expected) <= 64 * double(epsilon<T>) * size * absolute_sum(row));
    }
}

TEMPLATE_TEST_CASE("clones of any number of handles and points are the plain sum", "[clone][oracle]",
                   CAGEFORM_SCALARS) {
    // Handles are processed in groups of 256, points in blocks of 8 or 16, blocks in tiles.
    using T = TestType;
    const std::size_t handles = GENERATE(1u, 3u, 4u, 17u, 255u, 256u, 257u, 511u, 512u, 513u, 1000u);
    const std::size_t points = GENERATE(0u, 1u, 7u, 8u, 9u, 15u, 16u, 17u, 100u, 391u);
    CAPTURE(handles, points);
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        CAPTURE(D);
        const auto binding = random_binding<T, D>(points, handles, handles + points);
        const auto pose = random_points<T, D>(handles, 10, handles);
        const auto moved = cloned(binding, pose);
        double worst = 0;
        for (std::size_t i = 0; i < points; ++i)
            worst = cageform_tests::larger(worst, distance(moved[i], by_definition(binding, pose, i)));
        // Sums stay below 40. Each addition of a term of 20 / #handles rounds in a random direction.
        CHECK(worst <=
              8 * double(epsilon<T>) * 40 * std::sqrt(double(D) * std::max(1.0, double(handles) / 16)));
    };
    check(std::integral_constant<std::size_t, 1>{});
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
}

TEMPLATE_TEST_CASE("an invalid pose leaves the output unchanged", "[clone][status]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = random_binding<T, 2>(20, 5, 1);
    const auto pose = random_points<T, 2>(5, 10, 2);
    const auto untouched = random_points<T, 2>(20, 10, 3);
    auto out = untouched;

    auto longer = pose, shorter = pose;
    longer.push_back(pose[0]);
    shorter.pop_back();
    CHECK(cageform::clone(binding, longer, out) == Status::pose_size_differs);
    CHECK(out == untouched);
    CHECK(cageform::clone(binding, shorter, out) == Status::pose_size_differs);
    CHECK(out == untouched);
    CHECK(cageform::clone(binding, std::vector<Vec<T, 2>>{}, out) == Status::pose_size_differs);
    CHECK(out == untouched);

    for (const T bad : {std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(),
                        -std::numeric_limits<T>::infinity()}) {
        for (std::size_t handle = 0; handle < 5; ++handle) {
            for (std::size_t axis = 0; axis < 2; ++axis) {
                auto spoilt = pose;
                spoilt[handle][axis] = bad;
                CHECK(cageform::clone(binding, spoilt, out) == Status::pose_not_finite);
                CHECK(out == untouched);
            }
        }
    }

    const auto few = std::vector<Vec<T, 2>>(untouched.begin(), untouched.begin() + 19);
    auto small = few;
    CHECK(cageform::clone(binding, pose, small) == Status::output_too_small);
    CHECK(small == few);
    CHECK(cageform::clone(binding, pose, std::span<Vec<T, 2>>{}) == Status::output_too_small);

    CHECK(cageform::clone(binding, pose, out) == Status::ok); // valid without the fault
    CHECK(out != untouched);
}

TEST_CASE("a pose too large for the binding's scalar is not finite", "[clone][status]") {
    const auto binding = random_binding<float, 2>(3, 4, 1);
    auto pose = random_points<double, 2>(4, 10, 2);
    std::vector<Vec<float, 2>> out(3);
    CHECK(cageform::clone(binding, pose, out) == Status::ok);
    pose[2][1] = 1e39;
    CHECK(cageform::clone(binding, pose, out) == Status::pose_not_finite);
}

TEST_CASE("a larger output is unchanged beyond the points", "[clone]") {
    const std::size_t points = GENERATE(0u, 1u, 15u, 16u, 17u);
    const auto binding = random_binding<float, 3>(points, 6, 4);
    const auto pose = random_points<float, 3>(6, 10, 5);
    const auto before = random_points<float, 3>(points + 20, 10, 6);
    auto out = before;
    REQUIRE(cageform::clone(binding, pose, out) == Status::ok);
    const auto exact = cloned(binding, pose);
    CHECK(std::equal(exact.begin(), exact.end(), out.begin()));
    CHECK(std::equal(before.begin() + std::ptrdiff_t(points), before.end(),
                     out.begin() + std::ptrdiff_t(points)));
}

TEST_CASE("an empty binding clones nothing from an empty pose", "[clone]") {
    const Binding<double, 2> binding;
    std::vector<Vec<double, 2>> nothing;
    CHECK(cageform::clone(binding, nothing, nothing) == Status::ok);
    CHECK(cageform::clone(binding, std::vector<Vec<double, 2>>(1), nothing) == Status::pose_size_differs);
}

TEST_CASE("a clone allocates nothing and never throws", "[clone][frame]") {
    const auto binding = random_binding<float, 3>(5000, 700, 7);
    const auto pose = random_points<float, 3>(700, 10, 8);
    std::vector<Vec<float, 3>> out(5000);
    const auto view = binding.view();
    STATIC_REQUIRE(noexcept(cageform::clone(binding, pose, out)));
    STATIC_REQUIRE(noexcept(cageform::clone(view, pose, out, {}, cageform::SerialFor{})));

    const std::size_t before = allocations;
    const Status of_binding = cageform::clone(binding, pose, out);
    const Status of_view = cageform::clone(view, pose, cageform::StridedPoints<float, 3>(out[0].v, 5000));
    const Status refused = cageform::clone(view, pose, std::span(out).first(10));
    const std::size_t after = allocations;
    CHECK(after == before);
    CHECK(of_binding == Status::ok);
    CHECK(of_view == Status::ok);
    CHECK(refused == Status::output_too_small);

    const std::vector<int> counted_indeed(3); // proves that allocations are counted
    CHECK(allocations > after);
}

TEST_CASE("a view of the caller's memory clones like the binding", "[clone]") {
    const auto binding = random_binding<double, 2>(30, 4, 9);
    const auto pose = random_points<double, 2>(4, 10, 10);
    const auto theirs = binding.view();
    const std::vector<Lanes<double>> weights(theirs.weights.data,
                                             theirs.weights.block(theirs.weights.blocks()));
    const std::vector<Lanes<double>> rest(theirs.rest.data, theirs.rest.block(theirs.rest.blocks()));
    const std::vector<Vec<double, 2>> handles(theirs.rest_handles, theirs.rest_handles + 4);
    const cageform::BindingView<double, 2> own{{weights.data(), 4, 30}, {rest.data(), 2, 30}, handles.data()};
    std::vector<Vec<double, 2>> out(30);
    REQUIRE(cageform::clone(own, pose, out) == Status::ok);
    CHECK(out == cloned(binding, pose));
}

TEMPLATE_TEST_CASE("poses and outputs may have any memory layout", "[clone][ranges]", CAGEFORM_SCALARS) {
    using T = TestType;
    constexpr std::size_t points = 21, handles = 5;
    const auto binding = random_binding<T, 3>(points, handles, 11);
    const auto pose = random_points<T, 3>(handles, 10, 12);
    const auto expected = cloned(binding, pose);
    const auto is_expected = [&](const auto& range) { return are_equal(range, expected); };

    std::vector<std::array<T, 3>> arrays(points);
    T c_array[points][3] = {};
    std::array<Vec<T, 3>, points> fixed{};
    CHECK(cageform::clone(binding, pose, arrays) == Status::ok);
    CHECK(is_expected(arrays));
    CHECK(cageform::clone(binding, pose, c_array) == Status::ok);
    CHECK(is_expected(c_array));
    CHECK(cageform::clone(binding, pose, fixed) == Status::ok);
    CHECK(is_expected(fixed));
    std::fill(arrays.begin(), arrays.end(), std::array<T, 3>{});
    CHECK(cageform::clone(binding, pose, std::span(arrays)) == Status::ok);
    CHECK(is_expected(arrays));

    std::vector<T> interleaved(points * 5, T(7)); // x y z and two other numbers
    const cageform::StridedPoints<T, 3> strided(interleaved.data(), points, 5 * sizeof(T));
    CHECK(cageform::clone(binding, pose, strided) == Status::ok);
    CHECK(is_expected(strided));
    CHECK(std::count(interleaved.begin(), interleaved.end(), T(7)) == 2 * points);
    std::vector<T> apart(points * 3); // all x, all y, all z
    const cageform::StridedPoints<T, 3> by_axis(apart.data(), points, sizeof(T), points * sizeof(T));
    CHECK(cageform::clone(binding, pose, by_axis) == Status::ok);
    CHECK(is_expected(by_axis));
    CHECK(apart[points + 2] == expected[2][1]);

    T c_pose[handles][3];
    for (std::size_t h = 0; h < handles; ++h) {
        for (std::size_t k = 0; k < 3; ++k) c_pose[h][k] = pose[h][k];
    }
    CHECK(cageform::clone(binding, c_pose, fixed) == Status::ok);
    CHECK(is_expected(fixed));
}

TEST_CASE("poses and outputs may be points and matrices of other libraries", "[clone][ranges]") {
    constexpr std::size_t points = 21, handles = 5;
    const auto binding = random_binding<float, 3>(points, handles, 11);
    const auto pose = random_points<float, 3>(handles, 10, 12);
    const auto expected = cloned(binding, pose);
    const auto is_expected = [&](const auto& range) { return are_equal(range, expected); };
    std::vector<glm::vec3> glms(points);
    std::vector<Eigen::Vector3f> columns(points);
    CHECK(cageform::clone(binding, pose, glms) == Status::ok);
    CHECK(is_expected(glms));
    CHECK(cageform::clone(binding, pose, columns) == Status::ok);
    CHECK(is_expected(columns));
    Eigen::Matrix<float, 3, Eigen::Dynamic> wide(3, points);
    CHECK(cageform::clone(binding, pose, cageform::points_in_columns<3>(wide)) == Status::ok);
    CHECK(is_expected(cageform::points_in_columns<3>(wide)));
    CHECK(wide(1, 20) == expected[20][1]);
    Eigen::Matrix<float, Eigen::Dynamic, 4> tall(points, 4);
    tall.setConstant(7);
    auto block = tall.leftCols<3>();
    CHECK(cageform::clone(binding, pose, cageform::points_in_rows<3>(block)) == Status::ok);
    CHECK(is_expected(cageform::points_in_rows<3>(block)));
    CHECK((tall.col(3).array() == 7).all());

    std::vector<glm::vec3> glm_pose;
    Eigen::Matrix<float, Eigen::Dynamic, 3> pose_rows(handles, 3);
    for (std::size_t h = 0; h < handles; ++h) {
        glm_pose.emplace_back(pose[h][0], pose[h][1], pose[h][2]);
        for (std::size_t k = 0; k < 3; ++k) pose_rows(Eigen::Index(h), Eigen::Index(k)) = pose[h][k];
    }
    std::vector<Vec<float, 3>> out(points);
    CHECK(cageform::clone(binding, glm_pose, out) == Status::ok);
    CHECK(is_expected(out));
    CHECK(cageform::clone(binding, cageform::points_in_rows<3>(pose_rows), out) == Status::ok);
    CHECK(is_expected(out));
}

TEST_CASE("the output may have another scalar than the binding", "[clone][ranges]") {
    const auto binding = random_binding<double, 2>(19, 5, 13);
    const auto pose = random_points<double, 2>(5, 10, 14);
    const auto expected = cloned(binding, pose);
    std::vector<Vec<float, 2>> out(19);
    CHECK(cageform::clone(binding, pose, out) == Status::ok);
    for (std::size_t i = 0; i < 19; ++i) CHECK(out[i] == cageform::vec_cast<float>(expected[i]));
}

TEMPLATE_TEST_CASE("threads, and any ranges, give the same bits", "[clone][threads]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = random_binding<T, 3>(12345, 300, 15);
    const auto pose = random_points<T, 3>(300, 10, 16);
    const auto expected = cloned(binding, pose);
    for (const unsigned threads : {0u, 1u, 2u, 5u}) {
        std::vector<Vec<T, 3>> out(12345);
        CHECK(cageform::clone(binding, pose, out, {}, cageform::ThreadedFor{threads}) == Status::ok);
        CHECK(out == expected);
    }
    std::vector<Vec<T, 3>> out(12345);
    const auto backwards = [](std::size_t count, std::size_t, const auto& body) {
        for (std::size_t end = count, step = 1; end > 0; end -= std::min(end, step), step = step % 7 + 1)
            body(end - std::min(end, step), end);
    };
    CHECK(cageform::clone(binding, pose, out, {}, backwards) == Status::ok);
    CHECK(out == expected);
}

namespace {

template <class Pose, class Out>
concept CanClone = requires(const Binding<double, 2>& binding, const Pose& pose, Out&& out) {
    cageform::clone(binding, pose, out);
};

} // namespace

TEST_CASE("clone refuses unsupported ranges at compile time", "[clone][concept]") {
    using Points = std::vector<Vec<double, 2>>;
    STATIC_REQUIRE(CanClone<Points, Points&>);
    STATIC_REQUIRE(CanClone<std::vector<std::array<float, 2>>, Points&>);
    STATIC_REQUIRE(!CanClone<std::vector<Vec<double, 3>>, Points&>);
    STATIC_REQUIRE(!CanClone<Points, std::vector<Vec<double, 3>>&>);
    STATIC_REQUIRE(!CanClone<Points, const Points&>);
    STATIC_REQUIRE(!CanClone<Points, cageform::StridedPoints<const double, 2>&>);
    STATIC_REQUIRE(!CanClone<std::vector<double>, Points&>);
}

} // namespace clone_tests
