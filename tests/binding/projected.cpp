// Restoring linear precision keeps weights from turning negative: bind, pack and the class that both of them test.
#include "../support/effort.hpp"
#include "../support/meshes.hpp"
#include "../support/packed.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/maximum_entropy.hpp>
#include <cageform/coordinates/project.hpp>
#include <cageform/core/affine/linear_restorer.hpp>

#include <Eigen/Dense>

namespace projected_tests {

using namespace cageform_tests;
using cageform::bind;
using cageform::epsilon;
using cageform::Lanes;
using cageform::LinearPrecision;
using cageform::project;

namespace {

/// Random handles, and for each lane positive weights near to weights that reproduce a point.
template <class T, std::size_t D>
struct Block {
    static constexpr std::size_t lanes = cageform::lane_count<T>;
    using Restorer = cageform::detail::LinearRestorer<T, D>;

    std::vector<Vec<T, D>> handles;
    std::vector<Vec<T, D>> points;
    std::vector<Lanes<T>> rows;

    explicit Block(Random& random)
        : handles(D + 3 + random.below(40))
        , points(lanes)
        , rows(handles.size()) {
        for (auto& h : handles) {
            for (T& x : h.v) x = T(random.uniform(-1, 1));
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const double error = std::pow(10.0, random.uniform(-5, -0.5));
            std::vector<double> near(handles.size()), exact(handles.size());
            for (std::size_t h = 0; h < handles.size(); ++h) {
                const bool is_zero = h > 2 * D + 2 && random.below(8) == 0;
                near[h] = is_zero ? 0 : std::pow(10.0, random.uniform(-4, 0));
                exact[h] = near[h] * (1 + error * random.uniform(-1, 1));
            }
            const double of_near = std::accumulate(near.begin(), near.end(), 0.0);
            const double of_exact = std::accumulate(exact.begin(), exact.end(), 0.0);
            Vec<double, D> p{};
            for (std::size_t h = 0; h < handles.size(); ++h) {
                rows[h][lane] = T(near[h] / of_near);
                p = p + (exact[h] / of_exact) * cageform::vec_cast<double>(handles[h]);
            }
            points[lane] = cageform::vec_cast<T>(p);
        }
    }

    std::vector<double> row(const std::vector<Lanes<T>>& of, std::size_t lane) const {
        std::vector<double> row;
        for (const Lanes<T>& w : of) row.push_back(double(w[lane]));
        return row;
    }

    /// Restores copies of the rows. The other lanes than `only` get no weights.
    std::vector<Lanes<T>> restored(std::size_t only, typename Restorer::Result& result,
                                   bool local = false) const {
        const Restorer restorer(cageform::HandleView<T, D>(handles), local);
        typename Restorer::Scratch scratch;
        std::vector<Lanes<T>> copy(rows), target(D), bound(1);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const bool is_bound = only == lanes || lane == only;
            bound[0][lane] = is_bound ? T(1) : T(0);
            for (std::size_t k = 0; k < D; ++k) target[k][lane] = is_bound ? points[lane][k] : handles[0][k];
            for (Lanes<T>& w : copy) w[lane] = is_bound ? w[lane] : T(0);
        }
        result = restorer.run(target.data(), bound[0], copy.data(), true, scratch);
        return copy;
    }
    std::vector<Lanes<T>> restored() const {
        typename Restorer::Result result;
        return restored(lanes, result);
    }

    /// The reference: the minimum-norm change of the weights of a lane, among the handles of `row` that are
    /// not zero with `local`.
    std::vector<double> least_change(std::size_t lane, bool local) const {
        auto changed = row(rows, lane);
        Eigen::MatrixXd sums(D + 1, long(handles.size()));
        Eigen::VectorXd missing = Eigen::VectorXd::Zero(D + 1);
        for (std::size_t r = 0; r <= D; ++r) {
            missing[long(r)] = r == 0 ? 1 : double(points[lane][r - 1]);
            for (std::size_t h = 0; h < handles.size(); ++h) {
                const double entry = r == 0 ? 1 : double(handles[h][r - 1]);
                missing[long(r)] -= changed[h] * entry;
                sums(long(r), long(h)) = local && changed[h] == 0 ? 0 : entry;
            }
        }
        const Eigen::VectorXd change = sums.completeOrthogonalDecomposition().solve(missing);
        for (std::size_t h = 0; h < handles.size(); ++h) changed[h] += change[long(h)];
        return changed;
    }
};

template <class Scalar, std::size_t Dimension>
struct Type {
    using T = Scalar;
    static constexpr std::size_t D = Dimension;
};
using Float2 = Type<float, 2>;
using Double2 = Type<double, 2>;
using Float3 = Type<float, 3>;
using Double3 = Type<double, 3>;

template <class T>
double least_of(const std::vector<T>& row) {
    return double(*std::min_element(row.begin(), row.end()));
}

} // namespace

TEMPLATE_TEST_CASE("weights that are not negative stay so when linear precision is restored",
                   "[binding][linear_precision][property]", Float2, Double2, Float3, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(seeds(effort(60, 10)));
    const bool local = GENERATE(false, true);
    CAPTURE(seed, local);
    Random random{std::uint64_t(seed) + 3000};
    std::size_t projected = 0, changed = 0;
    const double eps = double(epsilon<T>);
    for (int round = 0; round < 4; ++round) {
        const Block<T, D> block(random);
        typename Block<T, D>::Restorer::Result result;
        const auto rows = block.restored(block.lanes, result, local);
        for (std::size_t lane = 0; lane < block.lanes; ++lane) {
            const auto before = block.row(block.rows, lane), after = block.row(rows, lane);
            const auto& p = block.points[lane];
            std::vector<double> projection(before.size());
            std::vector<Vec<double, D>> handles;
            for (const auto& h : block.handles) handles.push_back(cageform::vec_cast<double>(h));
            const auto target = cageform::vec_cast<double>(p);
            CAPTURE(round, lane, text(before), text(after));
            REQUIRE(project<double, D>(before, handles, target, projection) == Status::ok);
            CHECK(least_of(after) >= 0);
            CHECK(double(result.least[lane]) == least_of(after));
            CHECK(result.missed[lane] == T(0));
            CHECK(std::fabs(double(sum_of(after)) - 1) <= 32 * eps);
            CHECK(distance(combine(after, handles), target) <= 64 * eps);
            const auto least = block.least_change(lane, local);
            if (least_of(least) < -64 * eps) {
                ++projected;
                CHECK(difference(after, projection) <= 1024 * eps);
                for (std::size_t h = 0; h < before.size(); ++h) CHECK((before[h] != 0 || after[h] == 0));
            } else if (least_of(least) > 0 || (local && least_of(least) >= 0)) {
                ++changed;
                CHECK(difference(after, least) <= 64 * eps);
            }
        }
    }
    CHECK(projected > 0);
    CHECK(changed > 0);
}

TEMPLATE_TEST_CASE("restored weights of a point do not depend on the other points of its block",
                   "[binding][linear_precision][property]", Float3, Double2) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(seeds(effort(40, 10)));
    CAPTURE(seed);
    Random random{std::uint64_t(seed) + 3100};
    const Block<T, D> block(random);
    const auto together = block.restored();
    for (std::size_t lane = 0; lane < block.lanes; ++lane) {
        typename Block<T, D>::Restorer::Result result;
        CHECK(block.row(block.restored(lane, result), lane) == block.row(together, lane));
    }
}

TEST_CASE("the least change is made if no other weights are positive", "[binding][linear_precision]") {
    Random random(3200);
    Block<double, 2> block(random);
    // Only the three handles of one side have weights, and they do not surround the points.
    block.handles = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    block.rows.resize(4);
    for (std::size_t lane = 0; lane < block.lanes; ++lane) {
        block.points[lane] = {1 + 0.1 * double(lane), 1.5};
        for (std::size_t h = 0; h < 4; ++h) block.rows[h][lane] = h < 2 ? 0.5 : 0;
    }
    block.rows[0][0] = block.rows[1][0] = 0; // no weights at all
    Block<double, 2>::Restorer::Result result;
    const auto rows = block.restored(block.lanes, result);
    for (std::size_t lane = 0; lane < block.lanes; ++lane) {
        CAPTURE(lane);
        CHECK(difference(block.row(rows, lane), block.least_change(lane, false)) <= 1e-15);
        CHECK(result.missed[lane] == 0);
    }
}

TEMPLATE_TEST_CASE("harmonic weights are not negative when bound", "[binding][linear_precision]", Float2,
                   Double2) {
    using T = typename TestType::T;
    const auto seed = GENERATE(seeds(effort(8, 2)));
    CAPTURE(seed);
    const cageform::Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    Random random{std::uint64_t(seed) + 3300};
    Points2<T> points;
    for (int i = 0; i < 100; ++i) points.push_back(random_inside(cage, random, 0));
    const cageform::HarmonicCoordinates<T, 2> coordinates(cage);
    const auto left = bind(coordinates, points, {.linear_precision = LinearPrecision::leave});
    const auto restored = bind(coordinates, points);
    REQUIRE(restored.report.status == Status::ok);
    REQUIRE(left.report.least_weight.value >= 0);
    CHECK(restored.report.least_weight.value >= 0);
    CHECK(restored.report.amplification.value <= 1 + 64 * double(epsilon<T>));
}

TEMPLATE_TEST_CASE("kept weights that are not negative stay so when a binding is packed", "[pack][property]",
                   Float2, Double2, Float3, Double3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    std::size_t not_surrounded = 0, bound_points = 0; // of all seeds
    const auto check = [&](const auto& coordinates, const std::vector<Vec<T, D>>& points) {
        const auto bound = bind(coordinates, points);
        REQUIRE(bound.report.status == Status::ok);
        REQUIRE(bound.report.least_weight.value >= 0);
        const auto packed = cageform::pack(bound.value, {.format = WeightFormat::scalar, .largest = D + 2});
        REQUIRE(packed.report.status == Status::ok);
        const auto view = packed.value.view();
        if (view.row_begin == nullptr) return; // all weights are kept
        const auto weights = effective_weights(view);
        std::vector<Vec<double, D>> handles;
        for (const auto& h : coordinates.handles()) handles.push_back(cageform::vec_cast<double>(h));
        for (std::size_t place = 0; place < view.points; ++place) {
            const std::size_t block = place / cageform::lane_count<T>, i = view.order[place];
            std::vector<double> kept(handles.size(), 0.0), projection(handles.size());
            for (std::size_t r = view.first_row(block); r < view.first_row(block + 1); ++r) {
                const std::size_t h = view.handle_of_row(block, r);
                kept[h] = double(bound.value.weight(i, h));
            }
            const auto p = cageform::vec_cast<double>(points[i]);
            const Status status = project<double, D>(kept, handles, p, projection);
            CAPTURE(i, text(kept), text(weights[i]), int(status));
            CHECK((least_of(weights[i]) >= 0 || status == Status::point_not_surrounded));
            not_surrounded += status == Status::ok ? 0 : 1;
            ++bound_points;
            const double rounding = 256 * double(epsilon<T>) * (1 + size_of(coordinates.handles()));
            CHECK(std::fabs(double(sum_of(weights[i])) - 1) <= rounding);
            CHECK(distance(combine(weights[i], handles), p) <= rounding * absolute_sum(weights[i]));
        }
    };
    for (int seed = 0; seed < effort(8, 2); ++seed) {
        CAPTURE(seed);
        if constexpr (D == 2) {
            const cageform::Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
            Random random{std::uint64_t(seed) + 3400};
            Points2<T> points;
            for (int i = 0; i < 200; ++i) points.push_back(random_inside(cage, random, 0));
            check(cageform::MaximumEntropyCoordinates<T, 2>(cage), points);
        } else {
            const auto data = random_large_mesh(std::uint64_t(seed));
            const auto mesh = data.template mesh<T>();
            std::vector<Vec<T, 3>> points;
            for (const auto& p : points_about(data, 300, std::uint64_t(seed))) {
                if (cageform::locate(mesh, cageform::vec_cast<T>(p), T(0)) == PointState::inside)
                    points.push_back(cageform::vec_cast<T>(p));
            }
            check(cageform::MaximumEntropyCoordinates<T, 3>(mesh), points);
        }
    }
    CHECK(bound_points > 0);
    CHECK(2 * not_surrounded <= bound_points);
}

} // namespace projected_tests
