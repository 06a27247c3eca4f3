// Trees of cells over a boundary: cells, unknowns, sizes, against a test of every position.
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"

#include <cageform/cage/cell_complex.hpp>
#include <cageform/grid/tree/nodes.hpp>
#include <cageform/grid/tree/refinement.hpp>

#include <map>

namespace tree_tests {

using namespace cageform;
using namespace cageform::grid;
using cageform_tests::Random;

namespace {

template <std::size_t D>
std::vector<typename CellTree<D>::Cell> leaves_of(const CellTree<D>& tree) {
    std::vector<typename CellTree<D>::Cell> leaves;
    tree.for_each_leaf([&](const auto& leaf) { leaves.push_back(leaf); });
    return leaves;
}
/// Whether the closed cells have a common point.
template <std::size_t D>
bool touch(const typename CellTree<D>::Cell& a, const typename CellTree<D>::Cell& b) {
    bool touch = true;
    for (std::size_t k = 0; k < D; ++k)
        touch = touch && a.low[k] <= b.low[k] + b.size && b.low[k] <= a.low[k] + a.size;
    return touch;
}

/// Split towards a few points.
template <std::size_t D>
CellTree<D> random_tree(Random& random) {
    CellTree<D> tree(7);
    for (std::size_t n = 0; n < 4; ++n) {
        typename CellTree<D>::Index place{};
        for (auto& x : place) x = std::int32_t(random.below(std::size_t(2 * tree.size())));
        for (int depth = 0; depth < 7; ++depth) {
            const auto leaf = tree.leaf_at(place);
            if (leaf.size > 1 && random.below(8) != 0) tree.split(leaf);
        }
    }
    return tree;
}

template <std::size_t D>
void check_cells(int seed) {
    CAPTURE(seed, D);
    Random random{std::uint64_t(seed)};
    CellTree<D> tree = random_tree<D>(random);
    // Cells of the lower half along the last axis do not count, nor do their children.
    const auto counts = [&](std::uint32_t number) {
        const auto cell = tree.cell(number);
        return cell.low[D - 1] + cell.size > tree.size() / 2;
    };
    const auto before = leaves_of(tree);
    balance(tree, counts, [&](const auto& leaf) {
        CHECK(counts(leaf.number));
        tree.split(leaf);
    });
    const auto leaves = leaves_of(tree);
    CHECK(leaves.size() == tree.leaves());
    CHECK(leaves.size() >= before.size());
    double volume = 0;
    for (const auto& leaf : leaves) {
        volume += std::pow(double(leaf.size), double(D));
        auto middle = leaf.low, upper = leaf.low;
        for (std::size_t k = 0; k < D; ++k) {
            middle[k] = 2 * leaf.low[k] + leaf.size;
            upper[k] = 2 * (leaf.low[k] + leaf.size) - 1;
        }
        CHECK(tree.leaf_at(middle).number == leaf.number);
        CHECK(tree.leaf_at(upper).number == leaf.number);
        const auto same = tree.cell(leaf.number);
        CHECK((same.low == leaf.low && same.size == leaf.size));
    }
    CHECK(volume == std::pow(double(tree.size()), double(D)));
    std::size_t unbalanced = 0;
    for (const auto& a : leaves) {
        for (const auto& b : leaves) {
            if (counts(a.number) && counts(b.number) && a.size > 2 * b.size && touch<D>(a, b)) ++unbalanced;
        }
    }
    CHECK(unbalanced == 0);
}

/// Against repeated tests of all pairs of leaves.
template <std::size_t D>
void check_least(int seed) {
    CAPTURE(seed, D);
    Random random{std::uint64_t(seed)};
    CellTree<D> tree = random_tree<D>(random), slow = tree;
    balance(tree, [](std::uint32_t) { return true; }, [&](const auto& leaf) { tree.split(leaf); });
    for (bool changed = true; changed;) {
        changed = false;
        const auto leaves = leaves_of(slow);
        for (const auto& a : leaves) {
            const bool is_large = std::any_of(leaves.begin(), leaves.end(), [&](const auto& b) {
                return a.size > 2 * b.size && touch<D>(a, b);
            });
            if (is_large) slow.split(a);
            changed = changed || is_large;
        }
    }
    const auto leaves = leaves_of(tree), expected = leaves_of(slow);
    REQUIRE(leaves.size() == expected.size());
    for (std::size_t n = 0; n < leaves.size(); ++n) CHECK(leaves[n].low == expected[n].low);
}

template <std::size_t D>
void check_nodes(int seed) {
    CAPTURE(seed, D);
    Random random{std::uint64_t(seed)};
    using Nodes = TreeNodes<D>;
    std::map<typename Nodes::Key, typename Nodes::Index> all;
    for (int n = 0; n < 300; ++n) {
        typename Nodes::Index index{};
        for (auto& x : index) x = std::int32_t(random.below(n < 100 ? 4 : (std::size_t{1} << 20) + 1));
        all[Nodes::key(index)] = index;
    }
    Buffer<typename Nodes::Key> keys;
    for (const auto& [key, index] : all) {
        if (random.below(2) == 0) keys.push_back(key);
    }
    const Nodes nodes{Buffer<typename Nodes::Key>(keys)};
    REQUIRE(nodes.count() == keys.size());
    std::uint32_t next = 0;
    for (const auto& [key, index] : all) {
        const bool there = next < keys.size() && keys[next] == key;
        CHECK(nodes.find(index) == (there ? next : Nodes::none));
        if (!there) continue;
        CHECK(nodes.index(next) == index);
        ++next;
    }
    CHECK(next == nodes.count());
}

TEST_CASE("trees are balanced across faces, edges and corners", "[grid][tree][property]") {
    const int seed = GENERATE(range(0, 8));
    check_cells<1>(seed);
    check_cells<2>(seed);
    if (seed < 3) check_cells<3>(seed);
}
TEST_CASE("balance makes only necessary splits", "[grid][tree][property]") {
    const int seed = GENERATE(range(0, 8));
    check_least<1>(seed);
    check_least<2>(seed);
    if (seed < 3) check_least<3>(seed);
}
TEST_CASE("sort_in_runs sorts and reports each step", "[grid][tree][property]") {
    const std::size_t count = GENERATE(0u, 1u, 99u, 100u, 101u, 300u, 499u, 500u, 777u);
    CAPTURE(count);
    Random random(count);
    Buffer<std::uint64_t> numbers;
    for (std::size_t n = 0; n < count; ++n) numbers.push_back(random.below(count));
    std::vector<std::uint64_t> expected(numbers.begin(), numbers.end());
    std::sort(expected.begin(), expected.end());
    double last = 0;
    std::size_t reports = 0;
    const auto progress = [&](double done) {
        CHECK(done >= last);
        last = done;
        ++reports;
        return true;
    };
    cageform::detail::sort_in_runs(numbers, {.progress = progress}, 100);
    CHECK(std::equal(numbers.begin(), numbers.end(), expected.begin(), expected.end()));
    const std::size_t runs = (count + 99) / 100;
    CHECK(reports >= (runs > 0 ? 2 * runs - 1 : 0)); // runs, and the merges that join them
}

TEST_CASE("nodes of a tree are found by their position", "[grid][tree][property]") {
    const int seed = GENERATE(range(0, 5));
    check_nodes<1>(seed);
    check_nodes<2>(seed);
    check_nodes<3>(seed);
    CHECK(TreeNodes<2>().find({0, 0}) == TreeNodes<2>::none);
}

// ---- boundaries -----------------------------------------------------------------------------------

template <class Cage>
void check_states(const Cage& cage, double across, std::uint64_t seed) {
    constexpr std::size_t D = Cage::dimension;
    REQUIRE(check(cage).status == Status::ok);
    const TreeBoundary<D> boundary(cage, 10);
    CutTree<D> tree(boundary);
    FinestCells<D> finest;
    REQUIRE(refine(tree, {.across = across}, 1000000, finest));
    // Leaves without facets are on one side, that of any point in them.
    Random random(seed);
    std::size_t inside = 0, beyond = 0;
    const auto state_at = [&](const Vec<double, D>& p) { return locate(cage, boundary.in_cage(p), 0.0); };
    tree.cells().for_each_leaf([&](const auto& leaf) {
        const CellState state = tree.state(leaf.number);
        REQUIRE(state != CellState::unknown);
        REQUIRE((state == CellState::cut) == !tree.facets(leaf.number).empty());
        if (state == CellState::cut || random.below(3) != 0) return;
        Vec<double, D> p{};
        for (std::size_t k = 0; k < D; ++k) p[k] = leaf.low[k] + leaf.size * random.uniform(0.01, 0.99);
        CHECK(state_at(p) == (state == CellState::in ? PointState::inside : PointState::outside));
        ++(state == CellState::in ? inside : beyond);
    });
    CHECK(inside > 0);
    CHECK(beyond > 0);
    // Nodes are inside; corners of leaves that are not nodes are not.
    const auto nodes = nodes_of(tree);
    REQUIRE(nodes.count() > 0);
    for (std::uint32_t node = 0; node < nodes.count(); node += 1 + std::uint32_t(random.below(8)))
        CHECK(state_at(node_position<D>(nodes.index(node))) == PointState::inside);
    tree.cells().for_each_leaf([&](const auto& leaf) {
        if (tree.state(leaf.number) == CellState::in) CHECK(nodes.find(leaf.low) != TreeNodes<D>::none);
        if (tree.state(leaf.number) != CellState::cut || random.below(8) != 0) return;
        if (nodes.find(leaf.low) != TreeNodes<D>::none) return;
        const auto p = node_position<D>(leaf.low);
        const bool on_facet = boundary.nearest(tree.facets(leaf.number), p).distance < 1e-5;
        CHECK((on_facet || state_at(p) == PointState::outside));
    });
    // Facets have the inside behind them.
    for (std::size_t n = 0; n < boundary.size(); ++n) {
        auto p = 1e-4 * boundary.normal(n);
        for (const auto& corner : boundary[n].corner) p = p + (1 / double(D)) * corner;
        const auto q = p - 2e-4 * boundary.normal(n);
        CHECK(state_at(p) == PointState::outside);
        CHECK(state_at(q) == PointState::inside);
    }
}

TEST_CASE("trees decide what is inside polygons", "[grid][tree][property]") {
    const int seed = GENERATE(range(0, 6));
    CAPTURE(seed);
    auto star = cageform_tests::random_star<double>(std::uint64_t(seed));
    check_states(Polygon<double>(star), 3, std::uint64_t(seed));
    // So thin that lines along it cross only cut leaves, and the other axis decides.
    for (auto& p : star) p[std::size_t(seed % 2)] *= 0.02;
    check_states(Polygon<double>(star), 3, std::uint64_t(seed));
}
TEST_CASE("trees decide what is inside meshes", "[grid][tree][property]") {
    const int seed = GENERATE(range(0, 3));
    CAPTURE(seed);
    check_states(cageform_tests::random_mesh(std::uint64_t(seed)).mesh<double>(), 1, std::uint64_t(seed));
    if (seed == 0) check_states(cageform_tests::divided_box({2, 1, 1}, 0.5).mesh<double>(), 2, 0);
}

/// A sharp wedge in 2D with sides of many edges.
Polygon<double> tessellated_wedge(int edges, double height) {
    std::vector<Vec<double, 2>> points;
    for (int n = 0; n <= edges; ++n) points.push_back({double(n) / edges, 0});
    for (int n = edges; n > 0; --n) points.push_back({double(n) / edges, height * n / edges});
    return Polygon<double>(points);
}
// The exact corner and the one rounded by the tree differ by 2^-30 of the cube.
TEST_CASE("rays meet exact facets, also where the rounded facets end before them", "[grid][tree]") {
    const Polygon<double> cage(std::vector<Vec<double, 2>>{{0, 0}, {1, 0}, {1, 1}, {0.3, 1}, {0, 1}});
    const TreeBoundary<2> boundary(cage, 20);
    const double exact = boundary.in_units(Vec<double, 2>{0.3, 1})[0];
    const double rounded =
        std::ldexp(std::round(std::ldexp(exact, boundary.fraction())), -boundary.fraction());
    REQUIRE(exact != rounded);
    const double top = boundary.in_units(Vec<double, 2>{0, 1})[1];
    for (int n = 0; n <= 10; ++n) {
        const Vec<double, 2> from{exact + 0.1 * n * (rounded - exact), top - 100};
        CHECK(boundary.free_distance({from, 1, true, 200}) == Approx(100).epsilon(1e-9));
        const auto met = boundary.first_met(from, Vec<double, 2>{0, 200});
        REQUIRE(met);
        CHECK(met->fraction == Approx(0.5).epsilon(1e-9));
    }
}

TEST_CASE("sizes have a lower bound at wedges and narrow gaps", "[grid][tree][sizing]") {
    for (const double height : {0.3, 0.01, 1e-4, 1e-6}) {
        CAPTURE(height);
        const TreeBoundary<2> boundary(tessellated_wedge(200, height), 12);
        CutTree<2> tree(boundary);
        FinestCells<2> finest;
        CHECK(refine(tree, {}, 200000, finest));
    }
}

// ---- sizes of cells --------------------------------------------------------------------------------

/// Checks the sizes of the cells around a cage, for cells with points inside.
template <class Cage>
void check_sizes(const Cage& cage, const RefinementOptions& options) {
    constexpr std::size_t D = Cage::dimension;
    const TreeBoundary<D> boundary(cage, 12);
    CutTree<D> tree(boundary);
    FinestCells<D> finest;
    REQUIRE(refine(tree, options, 2000000, finest));
    const double largest = options.largest * cageform::detail::CellSizes<D>::size_of_cage(boundary);
    std::int32_t smallest = tree.cells().size();
    tree.cells().for_each_leaf([&](const auto& leaf) {
        if (tree.state(leaf.number) == CellState::out) return;
        smallest = std::min(smallest, leaf.size);
        CHECK(leaf.size <= largest);
        for (const std::uint32_t n : tree.facets(leaf.number)) {
            const auto& c = boundary[n].corner;
            double altitude = cageform::detail::length(cageform::detail::normal_of(boundary[n]));
            if constexpr (D == 3) {
                double longest = 0;
                for (std::size_t k = 0; k < 3; ++k)
                    longest = std::max(longest, cageform::detail::length(c[(k + 1) % 3] - c[k]));
                altitude /= longest;
            }
            CHECK(leaf.size <= std::max(1.0, altitude / options.per_facet * (1 + 1e-9)));
        }
    });
    CHECK(finest.size >= smallest); // before balancing and thin parts require smaller cells
    CHECK(finest.size <= 4 * smallest);
}
TEST_CASE("cells have the sizes that facets allow", "[grid][tree][sizing][property]") {
    const int seed = GENERATE(range(0, 3));
    CAPTURE(seed);
    check_sizes(cageform_tests::random_mesh(std::uint64_t(seed)).mesh<double>(), {.across = 3});
    check_sizes(cageform_tests::divided_box({2, 1, 1}, 0.5).mesh<double>(),
                {.per_facet = 3, .largest = 0.03});
    const Polygon<double> star(cageform_tests::random_star<double>(std::uint64_t(seed)));
    check_sizes(star, {.across = 3});
    check_sizes(star, {.per_facet = 3, .corner_levels = 3, .corner_gradation = 2, .largest = 0.03});
}
/// Checks the size of the cell in the middle of a gap between a wall and the boundary.
template <class Cage>
void check_gap(const Cage& cage, const Vec<double, Cage::dimension>& middle, double gap) {
    constexpr std::size_t D = Cage::dimension;
    const TreeBoundary<D> boundary(cage, 10);
    CutTree<D> tree(boundary);
    FinestCells<D> finest;
    const RefinementOptions options{.across = 3};
    REQUIRE(refine(tree, options, 2000000, finest));
    const double size = tree.leaf_at(boundary.in_units(middle)).size;
    CHECK(boundary.unit() * size <= gap / options.across);
}
TEST_CASE("a gap on either side of a wall has the requested number of cells",
          "[grid][tree][sizing][property]") {
    const int seed = GENERATE(range(0, 3));
    const bool is_left = GENERATE(true, false), is_reversed = GENERATE(true, false);
    Random random(std::uint64_t(seed) + 70);
    const double gap = random.uniform(0.04, 0.1), x = is_left ? gap : 1 - gap;
    const double middle = is_left ? 0.5 * gap : 1 - 0.5 * gap;
    CAPTURE(seed, is_left, is_reversed, gap);
    CellComplex<double, 2> square(
        Polygon<double>(std::vector<Vec<double, 2>>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
    std::vector<Vec<double, 2>> chain{{x, 0.2}, {x, 0.8}};
    if (is_reversed) std::swap(chain[0], chain[1]);
    (void)square.add_chain(chain);
    check_gap(square, Vec<double, 2>{middle, 0.5}, gap);
    CellComplex<double, 3> cube(cageform_tests::divided_box({1, 1, 1}, 1).mesh<double>());
    std::vector<Vec<double, 3>> wall{{x, 0.2, 0.2}, {x, 0.8, 0.2}, {x, 0.5, 0.8}};
    for (auto& p : wall) p = p - Vec<double, 3>{0.5, 0.5, 0.5};
    if (is_reversed) std::swap(wall[0], wall[1]);
    (void)cube.add_faces(wall, std::vector<std::array<int, 3>>{{0, 1, 2}});
    check_gap(cube, Vec<double, 3>{middle - 0.5, -0.1, -0.1}, gap);
}
TEST_CASE("cells grow with the distance from a reflex vertex in 2D", "[grid][tree][sizing]") {
    const Polygon<double> cage(std::vector<Vec<double, 2>>{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}});
    for (const double gradation : {1.0, 2.0, 4.0}) {
        CAPTURE(gradation);
        const TreeBoundary<2> boundary(cage, 14);
        CutTree<2> tree(boundary);
        FinestCells<2> finest;
        // The exponent there is 2/3: 9 halvings of the largest cells.
        const RefinementOptions options{.across = 1, .corner_levels = 6, .corner_gradation = gradation};
        REQUIRE(refine(tree, options, 1000000, finest));
        CHECK(finest.reason == cageform::SizeReason::singular_vertex);
        const double expected = std::ldexp(1.0, 14 - 4 - 9);
        CHECK(finest.size == expected);
        const auto corner = boundary.in_units(Vec<double, 2>{1, 1});
        CHECK(cageform::detail::length(finest.position - corner) <= gradation * 2 * expected);
        tree.cells().for_each_leaf([&](const auto& leaf) {
            if (tree.state(leaf.number) == CellState::out) return;
            const double distance = cageform::detail::length(leaf.middle() - corner);
            CHECK(leaf.size <= std::max(expected, distance / gradation));
        });
    }
}
TEST_CASE("the finest cells are reported with their reason", "[grid][tree][sizing]") {
    const auto finest_of = [](const TriangleMesh<double>& mesh, const RefinementOptions& options) {
        const TreeBoundary<3> boundary(mesh, 12);
        CutTree<3> tree(boundary);
        FinestCells<3> finest;
        REQUIRE(refine(tree, options, 2000000, finest));
        return std::tuple(boundary.unit() * finest.size, boundary.in_cage(finest.position), finest.reason);
    };
    // A plate of thickness 0.1.
    auto plate = cageform_tests::divided_box({1, 1, 1}, 1.0);
    for (auto& p : plate.vertices) p[2] *= 0.1;
    {
        const auto [size, place, reason] = finest_of(plate.mesh<double>(), {.across = 5, .per_facet = 0.1});
        CHECK(reason == SizeReason::thickness);
        CHECK((size <= 0.02 && size > 0.005));
    }
    const auto box = cageform_tests::divided_box({1, 1, 1}, 1.0).mesh<double>();
    {
        const auto [size, place, reason] = finest_of(box, {.across = 1, .per_facet = 0.1});
        CHECK(reason == SizeReason::largest);
        CHECK((size <= std::sqrt(3) / 16 && size > std::sqrt(3) / 64));
    }
    {
        const auto [size, place, reason] = finest_of(box, {.across = 1, .at_vertex = 1e-3});
        CHECK(reason == SizeReason::singular_vertex);
        CHECK((size <= std::sqrt(3) * 1e-3 && size > std::sqrt(3) * 2.5e-4));
    }
    {
        const auto [size, place, reason] = finest_of(box, {.across = 1, .per_facet = 30});
        CHECK(reason == SizeReason::facet);
        CHECK((size <= std::sqrt(0.5) / 30 && size > std::sqrt(0.5) / 120));
    }
    // An L-shaped prism, whose only reflex edge is at (1, 1).
    const auto json = cageform_tests::read_json("harmonic3d_l_prism_triangulated");
    const TriangleMesh<double> prism(json["cage"]["vertices"].get<std::vector<std::array<double, 3>>>(),
                                     json["cage"]["faces"].get<std::vector<std::array<int, 3>>>());
    const auto [size, place, reason] = finest_of(prism, {.across = 2, .edge_levels = 5, .reflex_levels = 2});
    CHECK(reason == SizeReason::singular_edge);
    CHECK(std::hypot(place[0] - 1, place[1] - 1) < 4 * size);
}
template <class Cage>
void check_plan(const Cage& cage, const RefinementOptions& options) {
    constexpr std::size_t D = Cage::dimension;
    const auto plan = RefinementPlanner<D>(TreeBoundary<D>(cage, 12)).plan(options);
    CHECK((plan.scale >= 1 && plan.scale < 2));
    const TreeBoundary<D> boundary(cage, 12, 0, plan.scale);
    CutTree<D> tree(boundary);
    FinestCells<D> finest;
    REQUIRE(refine(tree, options, 4000000, finest));
    CAPTURE(D, plan.leaves, tree.cells().leaves());
    constexpr double factor = D == 2 ? 2 : 4;
    CHECK(plan.leaves < factor * double(tree.cells().leaves()));
    CHECK(plan.leaves > 1 / factor * double(tree.cells().leaves()));
}
TEST_CASE("the number of leaves is predicted", "[grid][tree][sizing]") {
    for (const double finer : {1.0, 2.0, 3.0}) {
        CAPTURE(finer);
        const RefinementOptions options{.across = 5 * finer, .per_facet = finer, .largest = 0.03 / finer};
        check_plan(cageform_tests::random_mesh(4).mesh<double>(), options);
        check_plan(Polygon<double>(cageform_tests::random_star<double>(4)), options);
    }
    // Two plates 1e-6 apart: more cells than allowed are counted, but not made.
    const auto box = cageform_tests::divided_box({1, 1, 1}, 1.0);
    auto vertices = box.vertices;
    for (auto& p : vertices) p[2] *= 1e-6;
    const TreeBoundary<3> boundary(TriangleMesh<double>(vertices, box.faces), 16);
    CHECK(RefinementPlanner<3>(boundary).plan({}).leaves > 1e9);
    CutTree<3> tree(boundary);
    FinestCells<3> finest;
    CHECK(!refine(tree, {}, 5000, finest));
    CHECK(tree.cells().leaves() < 6000);
}

} // namespace
} // namespace tree_tests
