// Puzzles, graphs and random walks: exact results of tests/data/oracle/puzzles.json, properties, errors.
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/larger.hpp"
#include "../support/oracle.hpp"

#include <cageform/fields/graph.hpp>

#include <algorithm>
#include <limits>
#include <numeric>

namespace puzzle_tests {

using cageform::CellBox;
using cageform::CellNeighbours;
using cageform::Graph;
using cageform::GraphLink;
using cageform::Status;
using cageform_tests::Random;
using Json = nlohmann::json;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();

using Marks = std::vector<std::uint8_t>;

double fraction(const Json& json) {
    const auto text = json.get<std::string>();
    const auto slash = text.find('/');
    return std::stod(text) / (slash == std::string::npos ? 1.0 : std::stod(text.substr(slash + 1)));
}

/// The entries of a table of tables, the first index outermost.
void flatten(const Json& table, std::vector<Json>& entries) {
    if (!table.is_array()) return entries.push_back(table);
    for (const auto& row : table) flatten(row, entries);
}

std::vector<Json> flatten(const Json& table) {
    std::vector<Json> entries;
    flatten(table, entries);
    return entries;
}

/// Returns the links of a table of `shape`, whose last index is the first axis of the grid.
std::vector<GraphLink> links_of(const Json& shape, const Json& stencil) {
    const auto neighbours = stencil == "face" ? CellNeighbours::face : CellNeighbours::all;
    const auto n = [&](std::size_t k) { return shape[k].get<std::size_t>(); };
    if (shape.size() == 1) return cageform::grid_links(CellBox<1>{{n(0)}}, neighbours);
    if (shape.size() == 2) return cageform::grid_links(CellBox<2>{{n(1), n(0)}}, neighbours);
    return cageform::grid_links(CellBox<3>{{n(2), n(1), n(0)}}, neighbours);
}

std::size_t size_of(const Json& shape) {
    std::size_t size = 1;
    for (const auto& n : shape) size *= n.get<std::size_t>();
    return size;
}

std::size_t cell_of(const Json& shape, const Json& index) {
    std::size_t cell = 0;
    for (std::size_t k = 0; k < shape.size(); ++k)
        cell = cell * shape[k].get<std::size_t>() + index[k].get<std::size_t>();
    return cell;
}

/// A tree over all nodes, more links, and at least one given node.
struct RandomGraph {
    std::size_t nodes;
    std::vector<GraphLink> links;
    Marks given;

    explicit RandomGraph(std::uint64_t seed) {
        Random random(seed);
        nodes = 2 + random.below(60);
        given.resize(nodes);
        given[random.below(nodes)] = 1;
        for (auto& mark : given) mark = mark != 0 || random.below(4) == 0 ? 1 : 0;
        const auto link = [&](std::size_t a, std::size_t b) {
            if (a != b)
                links.push_back({std::uint32_t(a), std::uint32_t(b), 0.25 * double(1 + random.below(16))});
        };
        for (std::size_t node = 1; node < nodes; ++node) link(node, random.below(node));
        for (std::size_t more = random.below(2 * nodes); more > 0; --more)
            link(random.below(nodes), random.below(nodes));
    }
    Graph graph() const { return {nodes, links}; }
};

} // namespace

TEMPLATE_TEST_CASE("solve_graph: the exact puzzles", "[grid][puzzle][oracle]", CAGEFORM_SCALARS) {
    std::size_t unknown = 0;
    const auto cases = cageform_tests::read_json("puzzles");
    for (const auto& puzzle : cases.at("puzzles")) {
        CAPTURE(puzzle.at("name").get<std::string>());
        auto links = links_of(puzzle.at("shape"), puzzle.at("stencil"));
        const std::size_t size = size_of(puzzle.at("shape"));
        const auto given = flatten(puzzle.at("given")), solution = flatten(puzzle.at("solution"));
        REQUIRE(solution.size() % size == 0);
        Marks marks(size);
        std::vector<TestType> values(solution.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            // Cells without a solution are not part of the puzzle.
            if (solution[i].is_null() || given[i].is_string()) marks[i % size] = 1;
            if (given[i].is_string() && !solution[i].is_null()) values[i] = TestType(fraction(given[i]));
            if (marks[i % size] == 0) values[i] = std::numeric_limits<TestType>::quiet_NaN();
        }
        std::erase_if(links, [&](const GraphLink& link) {
            return solution[link.a].is_null() || solution[link.b].is_null();
        });
        REQUIRE(cageform::solve_graph(Graph{size, links}, marks, std::span(values)).status == Status::ok);
        double largest = 1;
        for (const auto& entry : solution)
            if (!entry.is_null()) largest = cageform_tests::larger(largest, std::fabs(fraction(entry)));
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (solution[i].is_null()) continue;
            CAPTURE(i);
            unknown += marks[i % size] == 0 ? 1 : 0;
            CHECK(std::fabs(double(values[i]) - fraction(solution[i])) <=
                  64 * double(std::numeric_limits<TestType>::epsilon()) * largest);
        }
    }
    CHECK(unknown > 200);
}

TEST_CASE("expected_steps and hit_first: the exact walks", "[grid][puzzle][oracle]") {
    std::size_t starts = 0;
    const auto cases = cageform_tests::read_json("puzzles");
    for (const auto& walk : cases.at("walks")) {
        const auto& shape = walk.at("shape");
        CAPTURE(shape.dump(), walk.at("stencil").get<std::string>());
        const auto links = links_of(shape, walk.at("stencil"));
        const Graph graph{size_of(shape), links};
        Marks marks(graph.nodes);
        for (const auto& index : walk.at("given_cells")) marks[cell_of(shape, index)] = 1;
        std::vector<double> steps(graph.nodes), hits(graph.nodes);
        REQUIRE(cageform::expected_steps(graph, marks, std::span(steps)).status == Status::ok);
        for (std::size_t f = 0; f < walk.at("from").size(); ++f, ++starts) {
            const std::size_t from = cell_of(shape, walk.at("from")[f]);
            CHECK(steps[from] == Approx(fraction(walk.at("expected_steps")[f])).epsilon(1e-14));
            REQUIRE(cageform::hit_first(graph, marks, from, std::span(hits)).status == Status::ok);
            for (std::size_t g = 0; g < walk.at("given_cells").size(); ++g)
                CHECK(hits[cell_of(shape, walk.at("given_cells")[g])] ==
                      Approx(fraction(walk.at("hit_first")[f][g])).margin(1e-15).epsilon(1e-14));
        }
        for (std::size_t node = 0; node < graph.nodes; ++node)
            if (marks[node] != 0) CHECK(steps[node] == 0);
    }
    CHECK(starts == 20);
}

// The factorisation stores no diagonal, so there is no cancellation. Eigen's SimplicialLDLT loses half of
// the digits at 1e-8, and finds no pivot at 1e-17.
TEST_CASE("solve_graph: conductances of very different sizes", "[fields][graph]") {
    for (const double far : {1e-8, 1e-14, 1e-17, 1e-100}) {
        CAPTURE(far);
        const std::vector<cageform::GraphLink> links{{0, 1, far}, {1, 2, 1.0}, {2, 3, far}};
        const std::vector<std::uint8_t> given{1, 0, 0, 1};
        std::vector<double> values{0, 0, 0, 1};
        REQUIRE(cageform::solve_graph(cageform::Graph{4, links}, given, std::span(values)).status ==
                Status::ok);
        CHECK(values[1] == Approx(1 / (2 + far)).epsilon(1e-15));
        CHECK(values[2] == Approx((1 + far) / (2 + far)).epsilon(1e-15));
    }
}

TEST_CASE("solve_graph: the exact graphs, negative conductances only if allowed", "[grid][puzzle][oracle]") {
    std::size_t negative = 0;
    const auto cases = cageform_tests::read_json("puzzles");
    for (const auto& json : cases.at("graphs")) {
        CAPTURE(json.at("name").get<std::string>());
        std::vector<GraphLink> links;
        for (const auto& edge : json.at("edges"))
            links.push_back({edge[0].get<std::uint32_t>(), edge[1].get<std::uint32_t>(), fraction(edge[2])});
        const Graph graph{json.at("nodes").get<std::size_t>(), links};
        Marks marks(graph.nodes);
        std::vector<double> values(graph.nodes);
        for (const auto& [node, value] : json.at("given").items()) {
            marks[std::stoul(node)] = 1;
            values[std::stoul(node)] = fraction(value);
        }
        const auto first =
            std::find_if(links.begin(), links.end(), [](const auto& l) { return l.conductance < 0; });
        if (first != links.end()) {
            ++negative;
            const auto refused = cageform::solve_graph(graph, marks, std::span(values));
            CHECK(refused.status == Status::weights_not_positive);
            CHECK(refused.solver.culprit == std::size_t(first - links.begin()));
        }
        const cageform::GraphOptions options{first != links.end()};
        REQUIRE(cageform::solve_graph(graph, marks, std::span(values), options).status == Status::ok);
        for (std::size_t node = 0; node < graph.nodes; ++node)
            CHECK(values[node] == Approx(fraction(json.at("solution")[node])).margin(1e-15).epsilon(1e-14));
    }
    CHECK(negative == 1);
}

TEST_CASE("hit_first on random graphs: probabilities, whose weighted mean of the values is the solution",
          "[grid][puzzle]") {
    const auto seed = GENERATE(range(0, 50));
    CAPTURE(seed);
    const RandomGraph random_graph{std::uint64_t(seed)};
    const Graph graph = random_graph.graph();
    Random random(std::uint64_t(seed) + 1000);
    std::vector<double> data(graph.nodes), hits(graph.nodes), steps(graph.nodes);
    for (auto& value : data) value = double(random.below(1000)) / 500 - 1;
    auto values = data;
    REQUIRE(cageform::solve_graph(graph, random_graph.given, std::span(values)).status == Status::ok);
    REQUIRE(cageform::expected_steps(graph, random_graph.given, std::span(steps)).status == Status::ok);
    double change = 0, degree = 0; // of the steps along the first unknown node's links
    const auto first = std::size_t(std::find(random_graph.given.begin(), random_graph.given.end(), 0) -
                                   random_graph.given.begin());
    for (const GraphLink& link : random_graph.links) {
        if (link.a != first && link.b != first) continue;
        change += link.conductance * (steps[first] - steps[link.a == first ? link.b : link.a]);
        degree += link.conductance;
    }
    if (first < graph.nodes) CHECK(change == Approx(degree).epsilon(1e-10));
    for (std::size_t from = 0; from < graph.nodes; ++from) {
        REQUIRE(cageform::hit_first(graph, random_graph.given, from, std::span(hits)).status == Status::ok);
        CHECK(std::accumulate(hits.begin(), hits.end(), 0.0) == Approx(1).epsilon(1e-12));
        CHECK(*std::min_element(hits.begin(), hits.end()) >= -1e-15);
        CHECK(std::inner_product(hits.begin(), hits.end(), data.begin(), 0.0) ==
              Approx(values[from]).epsilon(0).margin(1e-12));
    }
}

TEST_CASE("random walks agree with hit_first and expected_steps", "[grid][puzzle]") {
    const auto seed = GENERATE(range(0, 4));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const CellBox<2> cells{{5, 6}};
    const auto links =
        cageform::grid_links(cells, seed % 2 == 0 ? CellNeighbours::face : CellNeighbours::all);
    const Graph graph{cells.size(), links};
    Marks given(graph.nodes);
    for (auto& mark : given) mark = random.below(4) == 0 ? 1 : 0;
    given[0] = 1;
    const std::size_t from = 17;
    given[from] = 0;
    std::vector<std::vector<std::size_t>> neighbours(graph.nodes);
    for (const auto& link : links) {
        neighbours[link.a].push_back(link.b);
        neighbours[link.b].push_back(link.a);
    }
    std::vector<double> hits(graph.nodes), steps(graph.nodes), count(graph.nodes);
    REQUIRE(cageform::hit_first(graph, given, from, std::span(hits)).status == Status::ok);
    REQUIRE(cageform::expected_steps(graph, given, std::span(steps)).status == Status::ok);
    const double walks = 20000;
    double sum = 0, squares = 0;
    for (double walk = 0; walk < walks; ++walk) {
        double taken = 0;
        std::size_t at = from;
        for (; given[at] == 0; ++taken) at = neighbours[at][random.below(neighbours[at].size())];
        ++count[at];
        sum += taken;
        squares += taken * taken;
    }
    const double mean = sum / walks;
    CHECK(std::fabs(mean - steps[from]) <= 5 * std::sqrt((squares / walks - mean * mean) / walks));
    for (std::size_t node = 0; node < graph.nodes; ++node) {
        CAPTURE(node);
        const double error = std::sqrt(hits[node] * (1 - hits[node]) / walks);
        CHECK(std::fabs(count[node] / walks - hits[node]) <= 5 * error + 1e-12);
    }
}

TEST_CASE("solve_graph: errors have a status and a culprit and leave the values unchanged",
          "[grid][puzzle][errors]") {
    std::vector<GraphLink> links{{0, 1, 1}, {1, 2, 1}, {2, 3, 1}};
    Marks given{1, 0, 0, 1};
    std::vector<double> values{0, 7, 7, 1};
    cageform::GraphOptions options;
    const auto refuses = [&](Status status, std::size_t culprit) {
        const Graph graph{4, links};
        auto out = values;
        const auto done = cageform::solve_graph(graph, given, std::span(out), options);
        CAPTURE(links[1].conductance);
        CHECK(done.status == status);
        CHECK(done.solver.culprit == culprit);
        CHECK(std::equal(out.begin() + 1, out.begin() + 3, values.begin() + 1));
        if (status == Status::value_not_finite || options.allow_negative) return;
        std::vector<double> steps(4, 7.0), hits(4, 7.0);
        CHECK(cageform::expected_steps(graph, given, std::span(steps)).status == status);
        CHECK(cageform::hit_first(graph, given, 1, std::span(hits)).status == status);
        CHECK(steps == std::vector<double>(4, 7.0));
        CHECK(hits == std::vector<double>(4, 7.0));
    };
    constexpr std::size_t none = cageform::SolverReport::none;
    SECTION("a node that does not exist") {
        links[1].b = 4;
        refuses(Status::index_out_of_range, 1);
    }
    SECTION("a link to itself") {
        links[2].b = 2;
        refuses(Status::input_malformed, 2);
    }
    SECTION("conductances") {
        for (const double bad : {0.0, -1.0, nan, inf}) {
            links[1].conductance = bad;
            refuses(Status::weights_not_positive, 1);
        }
    }
    SECTION("allowed to be negative, but not NaN") {
        options.allow_negative = true;
        for (const double bad : {nan, inf, -inf}) {
            links[1].conductance = bad;
            refuses(Status::weights_not_positive, 1);
        }
    }
    SECTION("values") {
        for (const double bad : {nan, inf}) {
            values[3] = bad;
            refuses(Status::value_not_finite, 3);
        }
    }
    SECTION("a component without data") {
        links = {{0, 1, 1}, {0, 3, 1}};
        refuses(Status::cells_unreached, 2);
    }
    SECTION("a link of conductance zero connects nothing") {
        options.allow_negative = true;
        links = {{0, 1, 1}, {1, 2, 0}, {0, 3, 1}};
        refuses(Status::cells_unreached, 2);
    }
    SECTION("no given node") {
        given[0] = given[3] = 0;
        refuses(Status::cells_unreached, 0);
    }
    SECTION("a singular matrix") {
        options.allow_negative = true;
        links = {{0, 1, 0.1}, {0, 1, 0.2}, {1, 3, -0.3}, {2, 3, 1}}; // 0.1 + 0.2 is not 0.3
        refuses(Status::not_converged, none);
    }
    SECTION("conductances whose sum is infinite") {
        links[0].conductance = links[1].conductance = 1.7e308;
        refuses(Status::not_converged, none);
    }
    SECTION("a value out of the range of float") {
        const std::vector<GraphLink> pair{{0, 1, 1}, {1, 2, -0.5}};
        std::vector<float> large{3e38F, 7, 0}; // the middle one would be 6e38
        const auto done = cageform::solve_graph(Graph{3, pair}, Marks{1, 0, 1}, std::span(large), {true});
        CHECK(done.status == Status::not_converged);
        CHECK(large[1] == 7);
    }
    SECTION("cancelled") {
        cageform::Running running;
        running.progress = [](double) { return false; };
        const Graph graph{4, links};
        CHECK(cageform::solve_graph(graph, given, std::span(values), {}, running).status ==
              Status::cancelled);
        CHECK(values == std::vector<double>{0, 7, 7, 1});
    }
    SECTION("the start of a walk") {
        CHECK(cageform::hit_first(Graph{4, links}, given, 4, std::span(values)).status ==
              Status::index_out_of_range);
    }
}

TEST_CASE("solve_graph: the factors stay small near hubs", "[grid][puzzle]") {
    // A ring with two hubs linked to all of it: one level of a breadth-first search from a hub is the whole
    // ring. Then each hub linked to half of the ring, a chain that begins at the hubs, and a star.
    constexpr std::uint32_t count = 2000;
    const auto ring = [](std::uint32_t i) { return 2 + i % count; };
    for (const int kind : {0, 1, 2, 3}) {
        CAPTURE(kind);
        std::vector<GraphLink> links;
        for (std::uint32_t i = 0; i < count; ++i) {
            if (kind < 2 || (kind == 2 && i > 0)) links.push_back({ring(i), ring(i + 1), 1});
            if (kind == 0) links.push_back({1, ring(i), 2});
            if (kind == 0 || kind == 3) links.push_back({0, ring(i), 1});
            if (kind == 1) links.push_back({i < count / 2 ? 0U : 1U, ring(i), 1});
        }
        if (kind > 1) links.insert(links.end(), {{0, 1, 1}, {1, ring(0), 1}});
        Marks given(count + 2);
        given[ring(0)] = given[ring(count / 2)] = 1;
        std::vector<double> values(count + 2), flow(count + 2);
        values[ring(0)] = 1;
        const auto done = cageform::solve_graph(Graph{count + 2, links}, given, std::span(values));
        REQUIRE(done.status == Status::ok);
        CHECK(done.solver.bytes < 100 * sizeof(double) * count);
        for (const auto& [a, b, k] : links) { // the flow into a node equals the flow out of it
            flow[a] += k * (values[b] - values[a]);
            flow[b] += k * (values[a] - values[b]);
        }
        for (std::size_t i = 0; i < flow.size(); ++i) {
            REQUIRE((values[i] >= 0 && values[i] <= 1));
            if (given[i] == 0) REQUIRE(std::fabs(flow[i]) < 1e-11);
        }
    }
}

TEST_CASE("solve_graph without unknown nodes", "[grid][puzzle]") {
    std::vector<double> none, values{3, 4};
    CHECK(cageform::solve_graph(Graph{0, {}}, {}, std::span(none)).status == Status::ok);
    CHECK(cageform::solve_graph(Graph{2, {}}, Marks{1, 1}, std::span(values)).status == Status::ok);
    CHECK(values == std::vector<double>{3, 4});
    CHECK(cageform::expected_steps(Graph{2, {}}, Marks{1, 1}, std::span(values)).status == Status::ok);
    CHECK(values == std::vector<double>{0, 0});
    CHECK(cageform::grid_links(CellBox<2>{{0, 3}}, CellNeighbours::all).empty());
    CHECK(cageform::grid_links(CellBox<3>{{3, 3, 3}}, CellNeighbours::all).size() == 158);
}

} // namespace puzzle_tests
