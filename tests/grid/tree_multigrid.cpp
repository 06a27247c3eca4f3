// The equations of a tree's nodes and their multigrid: properties of every row, order, slits, cycles.
#include "../catch.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"

#include <cageform/grid/tree/multigrid.hpp>
#include <cageform/grid/tree/refinement.hpp>

namespace tree_multigrid_tests {

using namespace cageform;
using namespace cageform::grid;
using cageform_tests::larger;
using cageform_tests::Random;

namespace {

/// A size limit at a point: the leaf that contains it has at most `size` units.
template <std::size_t D>
struct SizeSample {
    Vec<double, D> position;
    double size;
};

/// A cage on a tree.
template <std::size_t D>
struct Problem {
    TreeBoundary<D> boundary;
    CutTree<D> tree;
    TreeNodes<D> nodes;

    template <class Cage>
    explicit Problem(const Cage& cage, const RefinementOptions& options, unsigned depth = 12)
        : boundary(cage, depth)
        , tree(boundary) {
        FinestCells<D> finest;
        REQUIRE(refine(tree, options, 1000000, finest));
        number_nodes();
    }
    /// Leaves are no larger than `largest` of the cube, and than the limits in them.
    template <class Cage>
    Problem(const Cage& cage, unsigned depth, double largest, const std::vector<SizeSample<D>>& samples)
        : boundary(cage, depth)
        , tree(boundary) {
        const auto& cells = tree.cells();
        for (std::size_t n = 0; n < cells.cells(); ++n) { // the loop includes cells that it adds
            const auto cell = cells.cell(std::uint32_t(n));
            if (cells.is_leaf(cell.number) && cell.size > largest * double(cells.size())) tree.split(cell);
        }
        for (const auto& [position, size] : samples) {
            typename CellTree<D>::Index doubled{};
            for (std::size_t k = 0; k < D; ++k) doubled[k] = std::int32_t(std::floor(2 * position[k]));
            for (auto leaf = cells.leaf_at(doubled); leaf.size > 1 && leaf.size > size;
                 leaf = cells.leaf_at(doubled))
                tree.split(leaf);
        }
        tree.find_states();
        balance(tree);
        number_nodes();
    }
    Problem(const Problem&) = delete;
    Problem& operator=(const Problem&) = delete;

private:
    void number_nodes() {
        nodes = nodes_of(tree);
        REQUIRE(nodes.count() > 0);
    }
};

template <std::size_t D>
std::vector<SizeSample<D>> random_samples(Random& random, unsigned depth) {
    std::vector<SizeSample<D>> samples;
    const double size = std::ldexp(1.0, int(depth));
    for (std::size_t n = 0; n < (D == 2 ? 20u : 12u); ++n) {
        SizeSample<D> sample{{}, std::ldexp(size, -int(3 + random.below(D == 2 ? 5 : 3)))};
        for (std::size_t k = 0; k < D; ++k) sample.position[k] = random.uniform(0, size);
        samples.push_back(sample);
    }
    return samples;
}

/// The properties of every row, on a randomly refined tree.
template <std::size_t D, class Cage>
void check_rows(const Cage& cage, std::uint64_t seed) {
    Random random(seed);
    CAPTURE(seed, D);
    const unsigned depth = 9;
    const Problem<D> problem(cage, depth, 1.0 / 8, random_samples<D>(random, depth));
    const TreeLinks links = links_of(problem.tree, problem.nodes);
    CHECK(links.least_share >= 1 - 0.25 * (D - 1));
    CHECK(std::is_sorted(links.data.begin(), links.data.end(), [](const auto& a, const auto& b) {
        return a.handle != b.handle ? a.handle < b.handle : a.node < b.node;
    }));
    const std::uint32_t count = problem.nodes.count();
    REQUIRE(links.equations.neighbours.rows() == count);
    std::vector<double> sums(count), data_weight(count);
    std::vector<Vec<double, D>> moved(count);
    const auto place = [&](std::uint32_t node) { return node_position<D>(problem.nodes.index(node)); };
    for (const auto& [handle, node, weight] : links.data) {
        REQUIRE(weight > 0);
        data_weight[node] += double(weight);
        moved[node] =
            moved[node] + double(weight) * (problem.boundary.in_units(cage.vertices()[handle]) - place(node));
    }
    std::size_t hanging = 0, open = 0;
    for (std::uint32_t node = 0; node < count; ++node) {
        const double diagonal = links.equations.diagonal[node], volume = double(links.volume[node]);
        std::array<std::array<double, D>, D> seconds{};
        double sum = data_weight[node];
        for (const auto& [column, weight] : links.equations.neighbours.of(node)) {
            REQUIRE(weight > 0);
            REQUIRE(column != node);
            sum += double(weight);
            const auto offset = place(column) - place(node);
            moved[node] = moved[node] + double(weight) * offset;
            for (std::size_t k = 0; k < D; ++k) {
                for (std::size_t l = 0; l < D; ++l) seconds[k][l] += double(weight) * offset[k] * offset[l];
            }
        }
        CHECK(std::fabs(sum - diagonal) <= 1e-12 * diagonal);
        // Linear functions: the mean of the positions of the neighbours and the data is the node.
        CHECK(detail::length(moved[node]) <= 1e-5 * problem.tree.cells().size() * diagonal * 0.01);
        if (data_weight[node] > 0) continue;
        ++open;
        hanging += links.equations.neighbours.of(node).size() > 2 * D ? 1 : 0;
        for (std::size_t k = 0; k < D; ++k) { // squares
            for (std::size_t l = 0; l < D; ++l)
                CHECK(std::fabs(seconds[k][l] - (k == l ? 2 * volume : 0)) <= 1e-5 * volume);
        }
    }
    CHECK(open > 0);
    CHECK(hanging > 0);
}

TEST_CASE("equations on trees have positive weights and are exact for linear functions and squares",
          "[grid][tree][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 6)));
    check_rows<2>(Polygon<double>(cageform_tests::random_star<double>(seed)), seed);
    if (seed % 2 == 0) check_rows<3>(cageform_tests::random_mesh(seed).mesh<double>(), seed);
}

TEST_CASE("a uniform tree has the equations of a lattice", "[grid][tree]") {
    const auto box = cageform_tests::divided_box({1, 1, 1}, 2.0).mesh<double>();
    const Problem<3> problem(box, 4, 1.0 / 8, {});
    CHECK(problem.nodes.count() == 7 * 7 * 7);
    const TreeLinks links = links_of(problem.tree, problem.nodes);
    const std::array weights{0.0, 28.0 / 30, 6.0 / 30, 2.0 / 30}; // weights of the 26 nodes, times the side
    for (std::uint32_t node = 0; node < problem.nodes.count(); ++node) {
        const auto& index = problem.nodes.index(node);
        const bool is_inner =
            std::all_of(index.begin(), index.end(), [](std::int32_t x) { return x >= 4 && x <= 12; });
        const auto neighbours = links.equations.neighbours.of(node);
        if (is_inner) CHECK(neighbours.size() == 26);
        const double diagonal = is_inner ? 256.0 / 30 : 12; // sides of 2 units: 8 · 6/4
        CHECK(std::fabs(links.equations.diagonal[node] - diagonal) < 1e-5);
        for (const auto& [column, weight] : neighbours) {
            const auto& there = problem.nodes.index(column);
            std::size_t apart = 0;
            for (std::size_t k = 0; k < 3; ++k) apart += there[k] != index[k] ? 1 : 0;
            CHECK(std::fabs(double(weight) - (is_inner ? weights[apart] : 2)) < 1e-6);
        }
    }
    CHECK(links.least_share == 1);
}

/// A function on the boundary, between 0 and 1, as the data of handle 0; handle 1 has the rest.
template <class F>
struct FunctionData {
    const std::vector<Vec<double, 2>>& vertices;
    const F& function;

    template <class Use>
    void for_each_weight(const cageform::BoundaryValue<2>& value, const Use& use) const {
        const double f = function(value.weight[0] * vertices[value.handle[0]] +
                                  value.weight[1] * vertices[value.handle[1]]);
        use(std::uint32_t{0}, f);
        use(std::uint32_t{1}, 1 - f);
    }
};

/// Solves for a function given on the boundary; returns values per node.
template <class F>
std::vector<double> solve(const Problem<2>& problem, const std::vector<Vec<double, 2>>& vertices,
                          const F& function) {
    const TreeMultigrid<2> multigrid(
        problem.tree, problem.nodes,
        links_of(problem.tree, problem.nodes, FunctionData<F>{vertices, function}));
    auto block = multigrid.make_block();
    multigrid.start(block, 0);
    for (int c = 0; c < 12; ++c) {
        (void)multigrid.cycle(block, 1);
        if (c % 2 == 1) multigrid.refine(block);
    }
    std::vector<double> u;
    for (std::uint32_t node = 0; node < multigrid.unknowns(); ++node) u.push_back(block.value(node)[0]);
    return u;
}

TEST_CASE("on a refined patch in 2D the order is four", "[grid][tree]") {
    std::vector<Vec<double, 2>> circle; // edges at all angles
    for (int n = 0; n < 20; ++n) {
        const double angle = 2 * std::numbers::pi * (n + 0.3) / 20;
        circle.push_back({std::cos(angle), std::sin(angle)});
    }
    const auto function = [](const Vec<double, 2>& p) {
        return 0.4 + 0.05 * (std::exp(1.5 * p[0]) * std::cos(1.5 * p[1]) + p[0] * p[0] - p[1] * p[1]);
    };
    std::vector<double> errors;
    for (const unsigned level : {3u, 4u, 5u}) { // the coarse cells per side
        const unsigned depth = level + 2;
        std::vector<SizeSample<2>> samples; // two levels finer in a patch that reaches the boundary
        const int cells = 4 << level;
        for (int x = cells / 2; x < cells; ++x) {
            for (int y = 3 * cells / 8; y < 5 * cells / 8; ++y) samples.push_back({{x + 0.5, y + 0.5}, 1.0});
        }
        const Problem<2> problem(Polygon<double>(circle), depth, std::ldexp(1.0, -int(level)), samples);
        const auto u = solve(problem, circle, function);
        double error = 0;
        for (std::uint32_t node = 0; node < u.size(); ++node) {
            const auto p = problem.boundary.in_cage(node_position<2>(problem.nodes.index(node)));
            error = larger(error, std::fabs(u[node] - function(p)));
        }
        errors.push_back(error);
    }
    CAPTURE(errors);
    CHECK(errors[0] < 1e-4);
    CHECK(std::log2(errors[0] / errors[1]) > 3.2);
    CHECK(errors[2] < 1e-7); // for coefficients in float
}

TEST_CASE("starts, cycles and refinements of a large grid call KeepGoing", "[grid][tree][progress]") {
    const std::vector<Vec<double, 2>> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const Problem<2> problem(Polygon<double>(square), 10, std::ldexp(1.0, -10), {});
    const TreeMultigrid<2> multigrid(problem.tree, problem.nodes);
    auto block = multigrid.make_block();
    REQUIRE(multigrid.unknowns() > 800000);
    int asked = 0, most = 1000000;
    const TreeMultigrid<2>::KeepGoing keep_going = [&] { return ++asked < most; };
    const auto asked_in = [&](const auto& work) {
        asked = 0;
        work();
        return asked;
    };
    const auto start = [&] { multigrid.start(block, 0, 0, keep_going); };
    const auto cycle = [&] { (void)multigrid.cycle(block, multigrid.width, keep_going); };
    const auto refine = [&] { multigrid.refine(block, keep_going); };
    const auto value = [&] { return block.value(multigrid.unknowns() / 2); };
    CHECK(asked_in(start) >= 6); // sets all values to zero, interpolates
    const int in_cycle = asked_in(cycle);
    CHECK(in_cycle >= 15); // three sweeps, restricts, interpolates
    CHECK(asked_in(refine) >= 6);
    const auto exact = value();
    most = 1; // each sweep ends at its call
    CHECK(asked_in(cycle) <= 6);
    CHECK(asked_in(refine) <= 2);
    CHECK(asked_in(start) <= 40);
    block = multigrid.make_block();
    CHECK(asked_in(start) <= 40);
    most = 1000000; // an interrupted block can be started again
    start();
    cycle();
    refine();
    CHECK(value() == exact);
}

/// The slowest of the cycles that reduce the error of functions well above rounding.
template <std::size_t D>
double convergence_factor(const Problem<D>& problem) {
    const TreeMultigrid<D> multigrid(problem.tree, problem.nodes);
    auto block = multigrid.make_block();
    multigrid.start(block, 0);
    double before = 0, factor = 0;
    for (int c = 0; c < 14; ++c) {
        const double change = multigrid.cycle(block, multigrid.width);
        if (c > 1 && before > 0) factor = larger(factor, std::pow(change / before, 1.0));
        before = change;
        multigrid.refine(block);
        // No measurement where few nodes remain active after the first cycle.
        if (change < 1e-13) break;
    }
    CHECK(before < 1e-8);
    return factor;
}
TEST_CASE("a cycle reduces the error by at least four on every reference cage", "[grid][tree][oracle]") {
    for (const char* name :
         {"biped", "cat", "hexagon", "hole_hexagon_triangle_hole", "hole_square_square_hole", "l_shape",
          "rectangle", "spiral", "square_extra_vertex", "star", "triangle",
          "splitting_chain_hexagonlike_split_chain", "straight_chain_square_straight_chain", "unit_square"}) {
        CAPTURE(name);
        const auto oracle = cageform_tests::read_oracle(std::string("harmonic2d_") + name);
        const RefinementOptions options{.corner_levels = 5.0};
        const auto factor = oracle.chain.empty()
                                ? convergence_factor(Problem<2>(oracle.cage<double>(), options))
                                : convergence_factor(Problem<2>(oracle.complex<double>(), options));
        CHECK(factor <= 0.25);
    }
    for (const char* name : {"cube_triangulated", "l_prism_triangulated", "tetrahedron"}) {
        CAPTURE(name);
        const auto json = cageform_tests::read_json(std::string("harmonic3d_") + name);
        const auto vertices = json["cage"]["vertices"].get<std::vector<std::array<double, 3>>>();
        const auto faces = json["cage"]["faces"].get<std::vector<std::array<int, 3>>>();
        const TriangleMesh<double> mesh(vertices, faces);
        CHECK(convergence_factor(Problem<3>(mesh, RefinementOptions{.across = 4, .edge_levels = 2})) <= 0.25);
    }
}

TEST_CASE("functions solved with a cutoff differ by at most half of it", "[grid][tree][property]") {
    // A long bar with handles from one end to the other: sixteen of them affect few nodes.
    const auto bar = cageform_tests::divided_box({16, 1, 1}, 1.0).mesh<double>();
    const Problem<3> problem(bar, RefinementOptions{.across = 4});
    const TreeMultigrid<3> multigrid(problem.tree, problem.nodes);
    auto full = multigrid.make_block(), local = multigrid.make_block();
    for (const double cutoff : {1e-2, 1e-3, 1e-5}) {
        for (std::size_t first = 0; first < bar.size(); first += 32) {
            CAPTURE(cutoff, first);
            multigrid.start(full, first);
            multigrid.start(local, first, cutoff);
            for (int c = 0; c < 8; ++c) {
                (void)multigrid.cycle(full, 16);
                (void)multigrid.cycle(local, 16);
            }
            CHECK(full.active() == multigrid.unknowns());
            double off = 0, largest = 0, least = 0;
            std::vector<bool> valued(multigrid.unknowns());
            for (const std::uint32_t node : local.valued()) valued[node] = true;
            for (std::uint32_t node = 0; node < multigrid.unknowns(); ++node) {
                const auto a = full.value(node), b = local.value(node);
                for (std::size_t k = 0; k < 16; ++k) {
                    off = larger(off, std::fabs(b[k] - a[k]));
                    largest = larger(largest, b[k]);
                    least = larger(least, -b[k]);
                    if (!valued[node]) REQUIRE(b[k] == 0);
                }
            }
            CHECK(largest > 0.5);
            CHECK(off <= 0.5 * cutoff + 1e-6); // rounding of float
            CHECK(least <= 1e-6);              // at most this far below zero
            CHECK(3 * local.active() < 2 * multigrid.unknowns());
        }
    }
}

TEST_CASE("values on one side of a wall or a common plane do not affect the other side", "[grid][tree]") {
    // Two boxes with a common face, each with its own vertices.
    const auto box = cageform_tests::divided_box({1, 1, 1}, 1.0);
    auto vertices = box.vertices;
    auto faces = box.faces;
    for (auto p : box.vertices) {
        p[0] += 1.0;
        vertices.push_back(p);
    }
    const int moved = int(box.vertices.size());
    for (const auto& [a, b, c] : box.faces) faces.push_back({a + moved, b + moved, c + moved});
    for (const double turn : {0.0, 0.4}) {
        CAPTURE(turn);
        auto turned = vertices;
        for (auto& p : turned)
            p = {std::cos(turn) * p[0] - std::sin(turn) * p[1], std::sin(turn) * p[0] + std::cos(turn) * p[1],
                 p[2]};
        const Problem<3> problem(TriangleMesh<double>(turned, faces), RefinementOptions{.across = 3});
        const TreeMultigrid<3> multigrid(problem.tree, problem.nodes);
        auto block = multigrid.make_block();
        multigrid.start(block, 0);
        for (int c = 0; c < 6; ++c) (void)multigrid.cycle(block, 16);
        std::size_t first = 0, second = 0;
        for (std::uint32_t node = 0; node < multigrid.unknowns(); ++node) {
            const auto p = problem.boundary.in_cage(node_position<3>(problem.nodes.index(node)));
            const double x = std::cos(turn) * p[0] + std::sin(turn) * p[1];
            const auto values = block.value(node);
            double own = 0, other = 0;
            for (std::size_t k = 0; k < 16; ++k) ((k < 8) == (x < 0.5) ? own : other) += values[k];
            CHECK(std::fabs(own - 1) < 1e-5);
            CHECK(other == 0);
            ++(x < 0.5 ? first : second);
        }
        CHECK(first > 20);
        CHECK(second > 20);
    }
    const auto oracle = cageform_tests::read_oracle("harmonic2d_splitting_chain_hexagonlike_split_chain");
    const Problem<2> problem(oracle.complex<double>(), RefinementOptions{});
    const TreeMultigrid<2> multigrid(problem.tree, problem.nodes);
    auto block = multigrid.make_block();
    multigrid.start(block, 0);
    for (int c = 0; c < 8; ++c) (void)multigrid.cycle(block, 16);
    std::size_t zeros = 0, checked = 0;
    for (std::size_t n = 0; n < oracle.points.size(); ++n) {
        // The nearest node is on the same side but next to the chain.
        const auto p = problem.boundary.in_units(oracle.points[n]);
        const auto leaf = problem.tree.cells().leaf_at(
            {std::int32_t(std::floor(2 * p[0])), std::int32_t(std::floor(2 * p[1]))});
        const auto node = problem.nodes.find(leaf.low);
        if (problem.tree.state(leaf.number) != CellState::in || node == TreeNodes<2>::none) continue;
        ++checked;
        for (std::size_t i = 0; i < oracle.vertices.size(); ++i) {
            if (oracle.coordinates[n][i] != 0) continue;
            ++zeros;
            CHECK(block.value(node)[i] == 0);
        }
    }
    CHECK(checked > 3);
    CHECK(zeros > 5);
}

} // namespace
} // namespace tree_multigrid_tests
