// A custom solver in this file alone: HarmonicCoordinates, gradients and bind accept it like the library's
// solvers.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic/multigrid_solver.hpp>
#include <cageform/coordinates/harmonic/solution.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

#include <Eigen/SparseCholesky>

namespace toy_solver_tests {

using namespace cageform_tests;
using cageform::Polygon;

namespace {

/// The factorised equations of the embedded grid.
template <std::size_t D>
class DirectSolver {
    static constexpr std::size_t width = 3; // functions per group
    using Grid = cageform::detail::EmbeddedCage<D>;

public:
    static constexpr std::size_t dimension = D;

    static Status make(const cageform::SolverInput<D>& input, cageform::SolverReport& report,
                       std::optional<DirectSolver>& made, const cageform::Running& /*running*/) {
        std::optional<Grid> grid;
        const Status status = Grid::make(input, report, grid);
        if (status != Status::ok) return status;
        made.emplace(std::move(*grid));
        report.cells = made->count();
        return Status::ok;
    }
    explicit DirectSolver(Grid grid)
        : grid_(std::move(grid)) {
        const auto& [nodes, cuts, values] = grid_.problem();
        std::vector<bool> is_cut(2 * D * count());
        std::vector<Eigen::Triplet<double>> entries;
        for (const auto& cut : cuts) {
            is_cut[2 * D * cut.node + cut.direction] = true;
            entries.emplace_back(int(cut.node), int(cut.node), cut.weight);
        }
        nodes.for_each([&](const auto& index, std::uint32_t node) {
            slots_.push_back(node);
            for (std::size_t direction = 0; direction < 2 * D; ++direction) {
                if (is_cut[2 * D * node + direction]) continue;
                auto next = index;
                next[direction / 2] += (direction & 1) != 0 ? 1 : -1;
                entries.emplace_back(int(node), int(node), 1.0);
                entries.emplace_back(int(node), int(grid_.problem().nodes.find(next)), -1.0);
            }
        });
        const auto n = Eigen::Index(count());
        Eigen::SparseMatrix<double> matrix(n, n);
        matrix.setFromTriplets(entries.begin(), entries.end());
        factor_ = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(matrix);
    }

    cageform::SolverMemory memory() const {
        return {sizeof(double) * count(), sizeof(double) * count() * width};
    }
    struct Block {
        std::vector<std::array<double, width>> values;
        const std::array<double, width>& value(std::uint32_t node) const { return values[node]; }
    };
    using Functions = Block;
    using Samples = cageform::detail::CutSamples<D>;

    std::size_t groups() const { return (grid_.cage().size() + width - 1) / width; }
    Block make_block() const { return {std::vector<std::array<double, width>>(count())}; }
    Status solve(std::size_t group, Block& block, cageform::grid::GroupWork& work) const {
        const auto [first, handles] = handles_of(group);
        for (auto& values : block.values) values.fill(0.0);
        grid_.add_data(first, handles, slots_, std::span(block.values));
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, int(width), Eigen::RowMajor>> values(
            block.values.data()->data(), long(count()), long(width));
        values = factor_->solve(Eigen::MatrixXd(values)).eval();
        work.report.solves = handles;
        return work.keep_going(1) ? Status::ok : Status::cancelled;
    }
    Functions keep(const Block& block) const { return block; }

    template <class T>
    Samples samples(const cageform::Batch<T>& batch, std::span<const std::size_t> points) const {
        Samples samples;
        for (const std::size_t i : points) samples.add(i, grid_.stencil(batch, i), grid_.data());
        return samples;
    }
    template <class T>
    void sample(const Samples& samples, std::size_t group, const Functions& functions,
                cageform::BlockView<T> rows) const {
        const auto [first, handles] = handles_of(group);
        samples.sample(functions, first, handles, rows);
    }
    template <class T>
    void finish(const Samples& /*samples*/, cageform::BlockView<T> /*rows*/) const {}

    double spacing(const Vec<double, D>& /*p*/) const { return grid_.lattice().spacing; }
    PointState state_of(const Vec<double, D>& p) const { return grid_.state_of(p); }
    double free_distance(const Vec<double, D>& p, std::size_t axis, bool up, double limit) const {
        return grid_.free_distance(p, axis, up, limit);
    }

private:
    std::size_t count() const { return grid_.problem().nodes.count(); }
    std::pair<std::size_t, std::size_t> handles_of(std::size_t group) const {
        return {group * width, std::min(width, grid_.cage().size() - group * width)};
    }

    Grid grid_;
    std::vector<std::uint32_t> slots_; ///< a right-hand side for each node
    std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> factor_;
};

template <class C>
auto direct(const C& cage, const cageform::HarmonicOptions& options) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    return cageform::HarmonicCoordinates(cage, options, cageform::make_functions<DirectSolver<D>, T, D>);
}

template <class Solver>
constexpr bool is_model = cageform::CageSolver<Solver> && cageform::DifferentiableSolver<Solver>;

} // namespace

TEST_CASE("the library's solvers and a custom solver model the concepts", "[coordinates][solver]") {
    STATIC_REQUIRE(is_model<cageform::MultigridSolver<2>>);
    STATIC_REQUIRE(is_model<cageform::MultigridSolver<3>>);
    STATIC_REQUIRE(is_model<cageform::TreeSolver<2>>);
    STATIC_REQUIRE(is_model<cageform::TreeSolver<3>>);
    STATIC_REQUIRE(is_model<DirectSolver<2>>);
    STATIC_REQUIRE(is_model<DirectSolver<3>>);
    STATIC_REQUIRE(!cageform::CageSolver<cageform::grid::Multigrid<2>>);
}

TEST_CASE("weights by a custom solver keep the laws", "[coordinates][solver][property]") {
    using T = double;
    const int seed = GENERATE(seeds(effort(6, 2)));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    Random random(std::uint64_t(seed) + 1);
    std::vector<Vec<T, 2>> points;
    for (int i = 0; i < 200; ++i) points.push_back(random_inside(cage, random, 1e-4));
    points.push_back(cage[0]);
    const auto bounds = cageform::bounds_of(cage.vertices());
    points.push_back(bounds.upper + (bounds.upper - bounds.lower));
    const auto coordinates = direct(cage, {.resolution = 40});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    CHECK(weights.evaluation.solver.solves == cage.size());
    CHECK(weights.evaluation.solver.cells > 100);
    CHECK(weights.states.back() == PointState::outside);
    const double rounding = 50 * double(cageform::epsilon<T>) * double(cage.size());
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= rounding);
        CHECK(distance(combine(weights.rows[i], cage.vertices()), points[i]) <=
              rounding * size_of(cage.vertices()));
        for (const T w : weights.rows[i]) CHECK((w >= T(0) && w <= T(1)));
    }
    const auto bound = cageform::bind(coordinates, points);
    REQUIRE(bound.report.status == Status::ok);
    CHECK(bound.report.weight_change.value <= rounding);
    const auto gradients = gradients_of<T, 2>(coordinates, points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (gradients.states[i] != PointState::inside) continue;
        Vec<double, 2> sum{};
        for (const auto& g : gradients.rows[i]) sum = sum + vec_cast<double>(g);
        CHECK(std::sqrt(dot(sum, sum)) * size_of(cage.vertices()) <= 400 * 40 * rounding);
    }
}

TEST_CASE("a custom solver agrees with the multigrid, in the plane and in space", "[coordinates][solver]") {
    const auto check_same = [](const auto& direct, const auto& multigrid, const auto& points) {
        const auto expected = evaluate_all(multigrid, points), weights = evaluate_all(direct, points);
        REQUIRE(weights.status() == Status::ok);
        REQUIRE(expected.status() == Status::ok);
        CHECK(weights.states == expected.states);
        CHECK(weights.evaluation.solver.cells == expected.evaluation.solver.cells);
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (expected.states[i] != PointState::inside) continue;
            CHECK(difference(weights.rows[i], expected.rows[i]) <= 2e-10);
        }
    };
    Random random(3);
    const Polygon<double> star(random_star<double>(5));
    std::vector<Vec<double, 2>> in_plane(100);
    for (auto& p : in_plane) p = random_inside(star, random);
    check_same(direct(star, {.resolution = 50}),
               cageform::HarmonicCoordinates<double, 2>(
                   star, {.resolution = 50, .multigrid = {.tolerance = 1e-10, .corner_functions = false}},
                   cageform::UniformGrid{}),
               in_plane);
    const auto mesh = random_mesh(2).mesh<double>();
    std::vector<Vec<double, 3>> in_space;
    const auto bounds = cageform::bounds_of(mesh.vertices());
    for (int i = 0; i < 300; ++i) {
        Vec<double, 3> p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = random.uniform(bounds.lower[k], bounds.upper[k]);
        in_space.push_back(p);
    }
    check_same(direct(mesh, {.resolution = 24}),
               cageform::HarmonicCoordinates<double, 3>(
                   mesh, {.resolution = 24, .multigrid = {.tolerance = 1e-10}}, cageform::UniformGrid{}),
               in_space);
}

TEST_CASE("a custom solver has the driver's threads, progress, cancellation and refusals",
          "[coordinates][solver][threads]") {
    const Polygon<double> cage(random_star<double>(7));
    Random random(4);
    std::vector<Vec<double, 2>> points(3000);
    for (auto& p : points) p = random_inside(cage, random);
    auto coordinates = direct(cage, {.resolution = 30});
    const auto expected = evaluate_all(coordinates, points);
    REQUIRE(expected.status() == Status::ok);
    cageform::Running running;
    running.parallel = cageform::ThreadedFor{3};
    CHECK(evaluate_all(coordinates, points, running).rows == expected.rows);

    std::vector<double> told;
    running.parallel = cageform::SerialFor{};
    running.progress = [&](double done) {
        told.push_back(done);
        return done < 0.5;
    };
    CHECK(coordinates.solve(running).status == Status::cancelled);
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.back() >= 0.5);
    REQUIRE(coordinates.solve().status == Status::ok);
    CHECK(evaluate_all(coordinates, points).rows == expected.rows);
    const auto memory = coordinates.solver_memory();
    CHECK(coordinates.solve().solver.bytes == memory.hierarchy + memory.block);

    CHECK(direct(cage, {.resolution = 4}).solve().status == Status::resolution_not_supported);
    const Polygon<double> crossed(Points2<double>{{0, 0}, {1, 1}, {1, 0}, {0, 1}});
    CHECK(direct(crossed, {}).solve().status == Status::cage_self_crossing);
}

} // namespace toy_solver_tests
