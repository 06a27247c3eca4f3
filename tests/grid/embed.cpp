// A polygon embedded in a lattice: nodes, cut links, data and samples.
#include "../catch.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/weights.hpp"

#include <cageform/coordinates/harmonic/embedded_cage.hpp>
#include <cageform/grid/lattice/embed.hpp>
#include <cageform/grid/lattice/simplex_boundary.hpp>

namespace embed_tests {

using cageform::BoundaryValue;
using cageform::Lattice;
using cageform::PointState;
using cageform::Polygon;
using cageform::grid::NodeRuns;
using cageform::grid::SimplexBoundary;
using cageform_tests::Random;
using cageform_tests::random_inside;
using cageform_tests::random_rings;
using cageform_tests::random_star;
using cageform_tests::Vec;

namespace {

using Index = NodeRuns<2>::Index;

Lattice<double, 2> lattice_over(const Polygon<double>& cage, double cells, double shift) {
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto extent = bounds.upper - bounds.lower;
    Lattice<double, 2> lattice;
    lattice.spacing = std::max(extent[0], extent[1]) / cells;
    for (std::size_t k = 0; k < 2; ++k) {
        lattice.origin[k] = bounds.lower[k] - shift * lattice.spacing;
        lattice.cells[k] = std::size_t(std::ceil(extent[k] / lattice.spacing + shift)) + 1;
    }
    return lattice;
}
Index size_of(const Lattice<double, 2>& lattice) {
    return {std::int32_t(lattice.cells[0]), std::int32_t(lattice.cells[1])};
}
Vec<double, 2> place(const Lattice<double, 2>& lattice, double x, double y) {
    return lattice.origin + lattice.spacing * Vec<double, 2>{x, y};
}
Vec<double, 2> place(const Polygon<double>& cage, const BoundaryValue<2>& value) {
    return value.weight[0] * cage[value.handle[0]] + value.weight[1] * cage[value.handle[1]];
}

/// A polygon's boundary with additional fixed nodes.
struct WithFixedNodes : SimplexBoundary<2> {
    WithFixedNodes(const SimplexBoundary<2>& boundary, std::vector<cageform::grid::FixedNode<2>> nodes)
        : SimplexBoundary<2>(boundary)
        , fixed(std::move(nodes)) {}
    std::vector<cageform::grid::FixedNode<2>> fixed_nodes() const { return fixed; }

    std::vector<cageform::grid::FixedNode<2>> fixed;
};

/// Samples are means that reproduce linear functions at every point inside.
void check_samples(const Polygon<double>& cage, const Lattice<double, 2>& lattice,
                   SimplexBoundary<2>& boundary, const NodeRuns<2>& nodes) {
    boundary.index_cells(1e-6);
    Random random(3);
    double missed = 0, sum_off = 0, least = 1;
    for (int n = 0; n < 300; ++n) {
        const auto p = random_inside(cage, random, 1e-6);
        const auto stencil = boundary.sample(lattice.in_cells(p), nodes);
        Vec<double, 2> q{};
        double sum = 0;
        for (std::uint32_t i = 0; i < stencil.node_count; ++i) {
            const auto at = nodes.index(stencil.nodes[i].node);
            q = q + stencil.nodes[i].share * place(lattice, at[0], at[1]);
            sum += stencil.nodes[i].share;
            least = std::min(least, stencil.nodes[i].share);
        }
        for (std::uint32_t i = 0; i < stencil.boundary_count; ++i) {
            q = q + stencil.boundary_points[i].share * place(cage, stencil.boundary_points[i].value);
            sum += stencil.boundary_points[i].share;
            least = std::min(least, stencil.boundary_points[i].share);
        }
        missed = cageform_tests::larger(missed, std::hypot(q[0] - p[0], q[1] - p[1]) / lattice.spacing);
        sum_off = cageform_tests::larger(sum_off, std::fabs(sum - 1));
    }
    CHECK(missed <= 1e-6);
    CHECK(sum_off <= 1e-12);
    CHECK(least >= 0);
}

void check_embedding(const Polygon<double>& cage, const Lattice<double, 2>& lattice) {
    SimplexBoundary<2> boundary(cage, lattice);
    const auto problem = cageform::grid::embed(boundary, boundary.crossings());
    // Nodes are inside, except some on the boundary.
    std::size_t wrong = 0;
    for (std::int32_t y = 0; y < size_of(lattice)[1]; ++y) {
        for (std::int32_t x = 0; x < size_of(lattice)[0]; ++x) {
            const auto p = place(lattice, x, y);
            const auto state = cageform::locate(cage, p, 1e-7 * lattice.spacing);
            if (state == PointState::on_boundary) continue;
            const bool unknown = problem.nodes.find({x, y}) != NodeRuns<2>::none;
            wrong += unknown == (state == PointState::inside) ? 0 : 1;
        }
    }
    CHECK(wrong == 0);
    // Every link of an unknown ends at an unknown or is cut, and its data is that of its end.
    std::vector<Index> index(problem.nodes.count());
    problem.nodes.for_each([&](const Index& i, std::uint32_t node) { index[node] = i; });
    std::vector<unsigned> cut_mask(problem.nodes.count());
    double off = 0;
    for (std::size_t c = 0; c < problem.cuts.size(); ++c) {
        const auto& cut = problem.cuts[c];
        REQUIRE((cut_mask[cut.node] >> cut.direction & 1u) == 0);
        cut_mask[cut.node] |= 1u << cut.direction;
        CHECK((cut.weight >= 1 && cut.weight <= 1.01e9));
        Vec<double, 2> end{double(index[cut.node][0]), double(index[cut.node][1])};
        end[cut.direction / 2] += ((cut.direction & 1) != 0 ? 1 : -1) / cut.weight;
        const auto d = place(lattice, end[0], end[1]) - place(cage, problem.values[c]);
        off = cageform_tests::larger(off, std::hypot(d[0], d[1]) / lattice.spacing);
    }
    CHECK(off <= 1e-6);
    std::size_t open = 0;
    problem.nodes.for_each([&](const Index& i, std::uint32_t node) {
        for (std::size_t direction = 0; direction < 4; ++direction) {
            auto there = i;
            there[direction / 2] += (direction & 1) != 0 ? 1 : -1;
            if (problem.nodes.find(there) == NodeRuns<2>::none && (cut_mask[node] >> direction & 1u) == 0)
                ++open;
        }
    });
    CHECK(open == 0);
    check_samples(cage, lattice, boundary, problem.nodes);
}

} // namespace

namespace {

/// A boundary without crossings, with the interface for embed and not for sampling.
struct Nowhere {
    static constexpr std::size_t dimension = 2;
    Lattice<double, 2> lattice() const { return {{{4, 4}}, {}, 1}; }
    cageform::grid::Crossings<2> crossings() const { return {}; }
    BoundaryValue<2> nearest(const Index&) const { return {}; }
    std::vector<cageform::grid::FixedNode<2>> fixed_nodes() const { return {}; }
    std::optional<std::uint32_t> too_thin_bone() const { return {}; }
};
struct WithoutFixedNodes : Nowhere {
    void fixed_nodes() const = delete;
};
struct WithoutNearest : SimplexBoundary<2> {
    using SimplexBoundary<2>::SimplexBoundary;
    double nearest(const Index&) const { return 0; } // no data
};
struct WithoutSample : SimplexBoundary<3> {
    using SimplexBoundary<3>::SimplexBoundary;
    void sample() const {}
};

} // namespace

TEST_CASE("the concepts of boundaries", "[grid][embed][concepts]") {
    using cageform::grid::EmbeddableBoundary;
    using cageform::grid::SampledBoundary;
    STATIC_REQUIRE(EmbeddableBoundary<SimplexBoundary<2>> && SampledBoundary<SimplexBoundary<2>>);
    STATIC_REQUIRE(EmbeddableBoundary<SimplexBoundary<3>> && SampledBoundary<SimplexBoundary<3>>);
    STATIC_REQUIRE(EmbeddableBoundary<Nowhere>);
    STATIC_REQUIRE(!SampledBoundary<Nowhere>);
    STATIC_REQUIRE(!EmbeddableBoundary<WithoutFixedNodes>);
    STATIC_REQUIRE(!EmbeddableBoundary<WithoutNearest>);
    STATIC_REQUIRE(SampledBoundary<WithoutNearest>);
    STATIC_REQUIRE(EmbeddableBoundary<WithoutSample>);
    STATIC_REQUIRE(!SampledBoundary<WithoutSample>);
    STATIC_REQUIRE(!EmbeddableBoundary<Polygon<double>>);
}

TEST_CASE("a polygon is embedded without moving it", "[grid][embed][property]") {
    const int seed = GENERATE(seeds(40));
    CAPTURE(seed);
    const double cells = GENERATE(5.0, 23.0, 64.0), shift = GENERATE(0.0, 0.37);
    CAPTURE(cells, shift);
    const Polygon<double> star(random_star<double>(std::uint64_t(seed)));
    check_embedding(star, lattice_over(star, cells, shift));
    const auto rings = random_rings<double>(std::uint64_t(seed));
    check_embedding(rings, lattice_over(rings, cells, shift));
}

TEST_CASE("edges on lattice lines and corners on nodes are on the boundary", "[grid][embed]") {
    const std::vector<Vec<double, 2>> l_shape{{0, 0}, {8, 0}, {8, 4}, {4, 4}, {4, 8}, {0, 8}};
    const Polygon<double> cage(l_shape);
    for (const double spacing : {1.0, 0.5, 2.0}) {
        CAPTURE(spacing);
        check_embedding(cage, lattice_over(cage, 8 / spacing, 0));
        check_embedding(cage, lattice_over(cage, 8 / spacing, 0.5));
        check_embedding(cage, lattice_over(cage, 8 / spacing, 1));
    }
    SimplexBoundary<2> boundary(cage, lattice_over(cage, 8, 0));
    const auto problem = cageform::grid::embed(boundary, boundary.crossings());
    CHECK(problem.nodes.count() == 7 * 3 + 3 * 4);
    for (const auto& cut : problem.cuts) CHECK(cut.weight == 1);
    const std::vector<Vec<double, 2>> diamond{{4, 0}, {8, 4}, {4, 8}, {0, 4}};
    check_embedding(Polygon<double>(diamond), lattice_over(Polygon<double>(diamond), 8, 0));
}

TEST_CASE("a handle without data at a node is unresolved until the grid is finer", "[grid][embed][status]") {
    // A spike as wide as a twentieth of the cage.
    const std::vector<Vec<double, 2>> spiked{{0, 0},    {1, 0}, {1, 0.5}, {1.4, 0.53},
                                             {1, 0.56}, {1, 1}, {0, 1}};
    const Polygon<double> cage(spiked);
    const auto unseen = [&](double cells) {
        const auto seen = cageform::grid::resolved_handles<2>(
            SimplexBoundary<2>(cage, lattice_over(cage, cells, 0.3)).crossings(), cage.size(),
            [](const cageform::BoundaryValue<2>& value, const auto& see) {
                for (std::size_t n = 0; n < 2; ++n) {
                    if (value.weight[n] != 0) see(value.handle[n]);
                }
            });
        return std::count(seen.begin(), seen.end(), false);
    };
    CHECK(unseen(4) > 0);
    CHECK(unseen(256) == 0);
}

TEST_CASE("fixed nodes are not unknowns, and their neighbours are linked to them", "[grid][embed]") {
    const Polygon<double> cage(random_star<double>(6));
    const auto lattice = lattice_over(cage, 40, 0.37);
    const SimplexBoundary<2> boundary(cage, lattice);
    const auto crossings = boundary.crossings();
    const auto plain = cageform::grid::embed(boundary, crossings);
    Random random(2);
    std::vector<cageform::grid::FixedNode<2>> fixed;
    plain.nodes.for_each([&](const Index& index, std::uint32_t) {
        if (random.below(9) == 0) fixed.push_back({index, {{7, 9}, {0.25, 0.75}}});
    });
    REQUIRE(fixed.size() > 20);
    std::reverse(fixed.begin(), fixed.end()); // in any order
    const auto problem = cageform::grid::embed(WithFixedNodes{boundary, fixed}, crossings);
    CHECK(problem.nodes.count() + fixed.size() == plain.nodes.count());
    for (const auto& node : fixed) CHECK(problem.nodes.find(node.index) == NodeRuns<2>::none);
    std::size_t links = 0;
    for (std::size_t c = 0; c < problem.cuts.size(); ++c) {
        auto there = problem.nodes.index(problem.cuts[c].node);
        there[problem.cuts[c].direction / 2] += (problem.cuts[c].direction & 1) != 0 ? 1 : -1;
        const bool to_fixed = plain.nodes.find(there) != NodeRuns<2>::none && problem.cuts[c].weight == 1;
        if (!to_fixed) continue;
        ++links;
        CHECK(problem.values[c].handle == fixed[0].value.handle);
        CHECK(problem.values[c].weight == fixed[0].value.weight);
    }
    CHECK(links > fixed.size());
}

namespace {

/// From random points of the boundary's box, against a search of all facets.
template <std::size_t D, class Cage>
void check_free_distances(const Cage& cage, double cells, std::uint64_t seed) {
    const auto bounds = cageform::bounds_of(cage.vertices());
    Lattice<double, D> lattice;
    for (std::size_t k = 0; k < D; ++k) {
        lattice.spacing = std::max(lattice.spacing * double(k > 0), (bounds.upper - bounds.lower)[k] / cells);
        lattice.origin[k] = bounds.lower[k];
        lattice.cells[k] = std::size_t(cells) + 1;
    }
    SimplexBoundary<D> boundary(cage, lattice);
    boundary.index_cells(1e-6);
    std::vector<cageform::PlacedFacet<D>> facets;
    const auto vertices = lattice.in_cells(cage.vertices());
    cageform::for_each_facet(cage, [&](const auto& facet) {
        facets.emplace_back(facet, std::span<const Vec<double, D>>(vertices), true);
    });
    Random random(seed);
    std::size_t met = 0;
    for (int n = 0; n < 2000; ++n) {
        Vec<double, D> p;
        for (std::size_t k = 0; k < D; ++k) p[k] = (lattice.in_cells(bounds.upper))[k] * random.uniform(0, 1);
        if (n % 4 == 0) p[std::size_t(n / 4) % D] = std::floor(p[std::size_t(n / 4) % D]);
        const std::size_t axis = std::size_t(n) % D;
        const bool up = n / 8 % 2 == 0;
        const double limit = n % 2 == 0 ? 1.0 : random.uniform(0, 2 * cells);
        double least = limit;
        for (const auto& facet : facets) {
            const auto hit = cageform::detail::hit<D>(facet, {p, axis, up, least});
            if (hit) least = std::fabs(hit->position - p[axis]);
        }
        met += least < limit ? 1 : 0;
        CHECK(boundary.free_distance(p, axis, up, limit) == least);
    }
    CHECK(met > 100);
}

} // namespace

namespace {

/// Near the boundary, on it and elsewhere: cells decide where points are, in most cases.
template <std::size_t D, class Cage>
void check_cells_tell(const Cage& cage, std::size_t resolution, std::uint64_t seed) {
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto lattice = cageform::detail::lattice_on(bounds, resolution);
    SimplexBoundary<D> boundary(cage, lattice);
    const auto problem = cageform::grid::embed(boundary, boundary.crossings());
    const double tolerance = cageform::coincidence_tolerance(bounds);
    boundary.index_cells(1e-6 + 2 * tolerance / lattice.spacing);
    Random random(seed);
    std::size_t told = 0;
    constexpr std::size_t count = 1500;
    for (std::size_t n = 0; n < count; ++n) {
        Vec<double, D> p, place;
        for (std::size_t k = 0; k < D; ++k) p[k] = random.uniform(bounds.lower[k], bounds.upper[k]);
        (void)nearest_boundary_value(cage, p, place);
        if (n % 4 == 0) p = place;
        if (n % 4 == 1) p = p + (1 - std::pow(10.0, random.uniform(-7, 0))) * (place - p);
        CAPTURE(n);
        const auto found = boundary.locate(lattice.in_cells(p), tolerance / lattice.spacing, problem.nodes);
        if (!found) continue;
        ++told;
        const auto state = cageform::locate(cage, p, tolerance);
        CHECK(int(found->state) == int(state));
        if (state != PointState::on_boundary) continue;
        Vec<double, D> q{};
        for (std::size_t k = 0; k < found->value.handle.size(); ++k)
            q = q + found->value.weight[k] * cage.vertices()[found->value.handle[k]];
        CHECK(cageform::detail::length(q - p) <= 3 * tolerance);
    }
    CHECK(told > count * 3 / 4); // a cell without a node inside does not decide
}

} // namespace

TEST_CASE("the elements of a cell decide where its points are", "[grid][embed][property]") {
    const int seed = GENERATE(seeds(4));
    const std::size_t resolution = GENERATE(8u, 40u);
    CAPTURE(seed, resolution);
    check_cells_tell<2>(random_rings<double>(std::uint64_t(seed)), resolution, std::uint64_t(seed));
    const auto mesh = cageform_tests::random_mesh(std::uint64_t(seed));
    check_cells_tell<3>(mesh.mesh<double>(), resolution, std::uint64_t(seed));
}

TEST_CASE("free distances end at the nearest facet", "[grid][embed][property]") {
    const int seed = GENERATE(seeds(5));
    const double cells = GENERATE(8.0, 21.0);
    CAPTURE(seed, cells);
    check_free_distances<2>(random_rings<double>(std::uint64_t(seed)), cells, std::uint64_t(seed));
    const auto mesh = cageform_tests::random_mesh(std::uint64_t(seed));
    check_free_distances<3>(mesh.mesh<double>(), cells, std::uint64_t(seed));
}

} // namespace embed_tests
