// solve_dirichlet: published examples, properties on random masks, errors.
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/larger.hpp"
#include "../support/oracle.hpp"

#include <cageform/fields/dirichlet.hpp>
#include <cageform/parallel/threads.hpp>

#include <numeric>

namespace dirichlet_tests {

using cageform::CellBox;
using cageform::Status;
using cageform_tests::Random;

namespace {

template <std::size_t D>
struct Problem {
    CellBox<D> cells;
    std::vector<std::uint8_t> given;
};

/// Given on the boundary and at some inner cells.
template <std::size_t D>
Problem<D> random_problem(std::uint64_t seed) {
    Random random(seed);
    Problem<D> problem;
    for (auto& n : problem.cells.cells) n = 3 + random.below(D == 1 ? 400 : D == 2 ? 60 : 18);
    const std::size_t rarity = 2 + random.below(60);
    problem.given.resize(problem.cells.size());
    for (std::size_t cell = 0; cell < problem.given.size(); ++cell) {
        const auto index = problem.cells.index(cell);
        bool rim = false;
        for (std::size_t k = 0; k < D; ++k)
            rim = rim || index[k] == 0 || index[k] + 1 == problem.cells.cells[k];
        problem.given[cell] = rim || random.below(rarity) == 0 ? 1 : 0;
    }
    return problem;
}

template <std::size_t D, class T>
void check_laws(int seed) {
    const auto problem = random_problem<D>(std::uint64_t(seed));
    const std::size_t size = problem.cells.size();
    CAPTURE(seed, D, size);
    Random random(std::uint64_t(seed) + 1);
    constexpr std::size_t fields = 19; // more than one group
    const double scale = std::pow(10.0, random.uniform(-20, 20));
    std::vector<T> values(fields * size);
    for (T& value : values)
        value = static_cast<T>(scale * random.uniform(-1, 1)); // unknown values are not read
    std::array<double, D + 1> linear{};
    for (double& x : linear) x = random.uniform(-1, 1);
    const auto linear_at = [&](std::size_t cell) {
        double sum = linear[D];
        for (std::size_t k = 0; k < D; ++k) sum += linear[k] * double(problem.cells.index(cell)[k]);
        return sum;
    };
    for (std::size_t cell = 0; cell < size; ++cell) {
        if (problem.given[cell] != 0) values[cell] = static_cast<T>(linear_at(cell));
    }
    const auto before = values;
    const double tolerance = sizeof(T) == 8 ? 1e-11 : 1e-6;
    const auto solved =
        cageform::solve_dirichlet(problem.cells, problem.given, values, {.tolerance = tolerance});
    REQUIRE(solved.status == Status::ok);
    CHECK(solved.solver.multigrid.error_estimate <= tolerance);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (problem.given[i % size] != 0) CHECK(values[i] == before[i]);
    }
    // A linear field is reproduced; others satisfy the maximum principle and the equation.
    double range = 0;
    for (std::size_t cell = 0; cell < size; ++cell)
        range = cageform_tests::larger(range, std::fabs(linear_at(cell)));
    for (std::size_t cell = 0; cell < size; ++cell)
        CHECK(std::fabs(double(values[cell]) - linear_at(cell)) <= 10 * tolerance * range);
    for (std::size_t f = 1; f < fields; ++f) {
        const T* const u = values.data() + f * size;
        for (std::size_t cell = 0; cell < size; ++cell) {
            if (problem.given[cell] != 0) continue;
            double mean = 0;
            for (std::size_t k = 0; k < D; ++k) {
                const std::size_t step = problem.cells.stride(k);
                mean += (double(u[cell - step]) + double(u[cell + step])) / (2.0 * double(D));
            }
            CHECK(std::fabs(double(u[cell]) - mean) <= 10 * tolerance * scale);
            CHECK(std::fabs(double(u[cell])) <= scale * (1 + tolerance));
        }
    }
    auto threaded = before;
    cageform::Running running;
    running.parallel = cageform::ThreadedFor{2};
    REQUIRE(
        cageform::solve_dirichlet(problem.cells, problem.given, threaded, {.tolerance = tolerance}, running)
            .status == Status::ok);
    CHECK((threaded == values));
}

} // namespace

TEMPLATE_TEST_CASE("given cells keep their values, and others are the mean of their neighbours",
                   "[grid][dirichlet][property]", CAGEFORM_SCALARS) {
    const int seed = GENERATE(seeds(15));
    check_laws<1, TestType>(seed);
    check_laws<2, TestType>(seed);
    check_laws<3, TestType>(seed);
}

TEST_CASE("the published grids are solved", "[grid][dirichlet][oracle]") {
    const auto json = cageform_tests::read_json("discrete_dirichlet_grids");
    REQUIRE(json["grids"].size() >= 11);
    for (const auto& grid : json["grids"]) {
        CAPTURE(grid["name"].get<std::string>());
        const CellBox<2> cells{{grid["columns"].get<std::size_t>(), grid["rows"].get<std::size_t>()}};
        const auto& numbers = grid["solution_4_neighbours_numbers"];
        std::vector<std::uint8_t> given;
        std::vector<double> values, expected;
        for (std::size_t cell = 0; cell < cells.size(); ++cell) {
            const auto [x, y] = cells.index(cell);
            given.push_back(grid["boundary"][y][x].is_null() ? 0 : 1);
            const bool corner = (x == 0 || x + 1 == cells.cells[0]) && (y == 0 || y + 1 == cells.cells[1]);
            expected.push_back(numbers[y][x].is_null() && corner ? 0.0 : numbers[y][x].get<double>());
            values.push_back(given.back() != 0 ? expected.back() : 1e300);
        }
        REQUIRE(cageform::solve_dirichlet(cells, given, values, {.tolerance = 1e-13}).status == Status::ok);
        for (std::size_t cell = 0; cell < cells.size(); ++cell)
            CHECK(std::fabs(values[cell] - expected[cell]) <=
                  1e-12 * std::max(1.0, std::fabs(expected[cell])));
    }
}

namespace {

/// "447/196", or an integer.
double fraction(const nlohmann::json& text) {
    const auto words = text.get<std::string>();
    const std::size_t bar = words.find('/');
    return bar == std::string::npos ? std::stod(words) : std::stod(words) / std::stod(words.substr(bar + 1));
}
/// All entries of nested tables, in order.
template <class F>
void for_each_entry(const nlohmann::json& table, const F& f) {
    if (!table.is_array()) return f(table);
    for (const auto& part : table) for_each_entry(part, f);
}

/// Exact fields: cells neither given nor solved for are outside.
template <std::size_t D>
void check_puzzle(const nlohmann::json& puzzle) {
    CAPTURE(puzzle["name"].get<std::string>());
    CellBox<D> cells; // tables have the first index outermost, a CellBox the first axis innermost
    for (std::size_t k = 0; k < D; ++k) cells.cells[k] = puzzle["shape"][D - 1 - k].get<std::size_t>();
    std::vector<double> values, expected;
    std::vector<cageform::Cell> kinds;
    for_each_entry(puzzle["given"], [&](const auto& entry) {
        kinds.push_back(entry.is_null() ? cageform::Cell::unknown : cageform::Cell::given);
        values.push_back(entry.is_null() ? 1e300 : fraction(entry));
    });
    std::size_t place = 0;
    for_each_entry(puzzle["solution"], [&](const auto& entry) {
        if (entry.is_null()) kinds[place] = cageform::Cell::outside;
        expected.push_back(entry.is_null() ? values[place] : fraction(entry));
        ++place;
    });
    REQUIRE(place == values.size());
    kinds.resize(cells.size()); // equal for all fields
    const auto solved =
        cageform::solve_dirichlet(cells, kinds, values, {.tolerance = 1e-14, .rim = cageform::Rim::mirrored});
    REQUIRE(solved.status == Status::ok);
    for (std::size_t i = 0; i < values.size(); ++i)
        CHECK(std::fabs(values[i] - expected[i]) <= 1e-12 * std::max(1.0, std::fabs(expected[i])));
}

} // namespace

TEST_CASE("mirrored boundaries and outside cells: the exact fields", "[grid][dirichlet][oracle]") {
    std::size_t solved = 0;
    const auto file = cageform_tests::read_json("puzzles");
    for (const auto& puzzle : file["puzzles"]) {
        if (puzzle["stencil"] != "face") continue;
        ++solved;
        switch (puzzle["shape"].size()) {
        case 1: check_puzzle<1>(puzzle); break;
        case 2: check_puzzle<2>(puzzle); break;
        default: check_puzzle<3>(puzzle);
        }
    }
    CHECK(solved >= 17);
}

TEMPLATE_TEST_CASE("components of unknown cells depend only on their own data, one without data is reported",
                   "[grid][dirichlet][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    using cageform::Cell;
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const CellBox<2> cells{{5 + random.below(40), 5 + random.below(40)}};
    const std::size_t size = cells.size(), rarity = 3 + random.below(20);
    std::vector<Cell> kinds(size, Cell::unknown);
    std::vector<T> values(size, T(-5));
    for (std::size_t i = 0; i < size; ++i) {
        if (random.below(3) == 0) kinds[i] = Cell::outside;
        if (random.below(rarity) == 0) kinds[i] = Cell::given;
        if (kinds[i] == Cell::given) values[i] = T(random.uniform(-1, 1));
    }
    // Components by a flood fill, and the range of the data of each.
    std::vector<std::size_t> part(size, size);
    std::vector<std::array<double, 2>> ranges;
    std::size_t unreached = 0, first = size;
    const auto for_each_neighbour = [&](std::size_t i, const auto& f) {
        const auto [x, y] = cells.index(i);
        if (x > 0) f(i - 1);
        if (x + 1 < cells.cells[0]) f(i + 1);
        if (y > 0) f(i - cells.cells[0]);
        if (y + 1 < cells.cells[1]) f(i + cells.cells[0]);
    };
    for (std::size_t start = 0; start < size; ++start) {
        if (kinds[start] != Cell::unknown || part[start] != size) continue;
        std::vector<std::size_t> members{start};
        part[start] = ranges.size();
        std::array<double, 2> range{2, -2};
        for (std::size_t n = 0; n < members.size(); ++n) {
            for_each_neighbour(members[n], [&](std::size_t other) {
                if (kinds[other] == Cell::given)
                    range = {std::min(range[0], double(values[other])),
                             std::max(range[1], double(values[other]))};
                if (kinds[other] != Cell::unknown || part[other] != size) return;
                part[other] = ranges.size();
                members.push_back(other);
            });
        }
        if (range[0] > range[1]) {
            unreached += members.size();
            first = std::min(first, start);
        }
        ranges.push_back(range);
    }
    // A third of the cells are walls: a maze, in which a cycle reduces the error by at least 1.4.
    const cageform::DirichletOptions options{
        .tolerance = sizeof(T) == 8 ? 1e-11 : 1e-6, .max_cycles = 300, .rim = cageform::Rim::mirrored};
    auto solved = cageform::solve_dirichlet(cells, kinds, values, options);
    if (unreached > 0) {
        CHECK(solved.status == Status::cells_unreached);
        CHECK(solved.solver.culprit == first);
        CHECK(solved.solver.unreached_cells == unreached);
        for (std::size_t i = 0; i < size; ++i) { // the same without those components
            if (kinds[i] != Cell::unknown) continue;
            CHECK(values[i] == T(-5));
            if (ranges[part[i]][0] > ranges[part[i]][1]) kinds[i] = Cell::outside;
        }
        solved = cageform::solve_dirichlet(cells, kinds, values, options);
    }
    CAPTURE(to_string(solved.status));
    REQUIRE(solved.status == Status::ok);
    for (std::size_t i = 0; i < size; ++i) {
        if (kinds[i] == Cell::outside) CHECK(values[i] == T(-5));
        if (kinds[i] != Cell::unknown) continue;
        CHECK(double(values[i]) >= ranges[part[i]][0] - 20 * options.tolerance);
        CHECK(double(values[i]) <= ranges[part[i]][1] + 20 * options.tolerance);
        double flow = 0;
        for_each_neighbour(i, [&](std::size_t other) {
            if (kinds[other] != Cell::outside) flow += double(values[i]) - double(values[other]);
        });
        CHECK(std::fabs(flow) <= 100 * options.tolerance);
    }
}

TEST_CASE("larger mirrored fields agree with the reference file", "[grid][dirichlet][oracle]") {
    const auto file = cageform_tests::read_json("fields");
    for (const char* name : {"height_map", "colours"}) {
        const auto& field = file[name];
        CAPTURE(name);
        const CellBox<2> cells{{field["columns"].get<std::size_t>(), field["rows"].get<std::size_t>()}};
        const std::size_t size = cells.size();
        const auto number = [&](const nlohmann::json& place) {
            return cells.number({place[0].get<std::size_t>(), place[1].get<std::size_t>()});
        };
        const auto numbers = [](const nlohmann::json& value) {
            return value.is_array() ? value.get<std::vector<double>>() : std::vector{value.get<double>()};
        };
        std::vector<cageform::Cell> kinds(size, cageform::Cell::unknown);
        const std::size_t fields = numbers(field["given"][0][1]).size();
        std::vector<double> values(fields * size);
        for (const auto& entry : field["given"]) {
            kinds[number(entry[0])] = cageform::Cell::given;
            for (std::size_t f = 0; f < fields; ++f)
                values[f * size + number(entry[0])] = numbers(entry[1])[f];
        }
        if (field.contains("exterior")) {
            for (const auto& place : field["exterior"]) kinds[number(place)] = cageform::Cell::outside;
        }
        REQUIRE(cageform::solve_dirichlet(cells, kinds, values,
                                          {.tolerance = 1e-14, .rim = cageform::Rim::mirrored})
                    .status == Status::ok);
        REQUIRE(field["samples"].size() >= 8);
        for (const auto& sample : field["samples"]) {
            for (std::size_t f = 0; f < fields; ++f)
                CHECK(std::fabs(values[f * size + number(sample[0])] - numbers(sample[1])[f]) < 1e-12);
        }
        if (!field.contains("mean")) continue;
        const double mean = std::accumulate(values.begin(), values.end(), 0.0) / double(size);
        CHECK(std::fabs(mean - field["mean"].get<double>()) < 1e-12);
    }
    // 0 on the boundary, 1 at (5, 5, 5), 1/2 along a line.
    const CellBox<3> cells{{12, 12, 12}};
    std::vector<cageform::Cell> kinds(cells.size(), cageform::Cell::unknown);
    std::vector<double> values(cells.size(), 0.0);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const auto index = cells.index(cell);
        const auto at_end = [](std::size_t i) { return i == 0 || i == 11; };
        const bool on_line = index[0] == 3 && index[1] == 3 && index[2] >= 2 && index[2] <= 8;
        const bool peak = index == CellBox<3>::Index{5, 5, 5};
        if (std::any_of(index.begin(), index.end(), at_end) || on_line || peak)
            kinds[cell] = cageform::Cell::given;
        values[cell] = peak ? 1 : on_line ? 0.5 : 0;
    }
    REQUIRE(cageform::solve_dirichlet(cells, kinds, values, {.tolerance = 1e-14}).status == Status::ok);
    for (const auto& sample : file["volume"]["samples"]) {
        const auto at = sample[0].get<std::vector<std::size_t>>();
        CHECK(std::fabs(values[cells.number({at[0], at[1], at[2]})] - sample[1].get<double>()) < 1e-12);
    }
}

TEST_CASE("grids that cannot be solved are refused and not changed", "[grid][dirichlet][status]") {
    const CellBox<2> cells{{5, 4}};
    std::vector<std::uint8_t> given(20, 1);
    std::vector<double> values(40, 2.0);
    const auto solve = [&](const cageform::DirichletOptions& options = {},
                           const cageform::Running& running = {}) {
        return cageform::solve_dirichlet(cells, given, values, options, running);
    };
    CHECK(solve().status == Status::ok); // no unknown cells
    given[4] = 0;
    CHECK(solve().status == Status::rim_not_given);
    CHECK(solve().solver.culprit == 4);
    given[4] = 1;
    given[7] = given[12] = 0;
    values[7] = values[27] = std::numeric_limits<double>::quiet_NaN(); // unknown: not read
    values[31] = std::numeric_limits<double>::infinity();
    CHECK(solve().status == Status::value_not_finite);
    CHECK(solve().solver.culprit == 31);
    values[31] = 3;
    // No data behind the wall.
    const CellBox<3> box{{4, 4, 4}};
    std::vector<cageform::Cell> walled(64, cageform::Cell::unknown);
    std::fill(walled.begin() + 16, walled.begin() + 32, cageform::Cell::outside);
    walled[5] = cageform::Cell::given;
    std::vector<double> heat(64, 1.0);
    const cageform::DirichletOptions open{.rim = cageform::Rim::mirrored};
    const auto cold = cageform::solve_dirichlet(box, walled, heat, open);
    CHECK(cold.status == Status::cells_unreached);
    CHECK(cold.solver.culprit == 32);
    CHECK(cold.solver.unreached_cells == 32);
    walled[16] = cageform::Cell::unknown; // a gap
    CHECK(cageform::solve_dirichlet(box, walled, heat, open).status == Status::ok);
    const CellBox<1> line{{6}};
    const std::vector<cageform::Cell> ends{{}, cageform::Cell::given, cageform::Cell::outside, {}, {}, {}};
    std::vector<double> along(6, 1.0);
    CHECK(cageform::solve_dirichlet(line, ends, along, open).solver.unreached_cells == 3);
    const std::vector<cageform::Cell> odd(20, cageform::Cell(3));
    const auto malformed = cageform::solve_dirichlet(cells, odd, values);
    CHECK(malformed.status == Status::input_malformed);
    CHECK(malformed.solver.culprit == 0);
    CHECK(solve({.tolerance = 0}).status == Status::tolerance_not_positive);
    CHECK(solve({.tolerance = std::numeric_limits<double>::quiet_NaN()}).status ==
          Status::tolerance_not_positive);
    cageform::Running stop;
    stop.progress = [](double) { return false; };
    CHECK(solve({}, stop).status == Status::cancelled);
    CHECK(solve({.tolerance = 1e-9, .max_cycles = 0}).status == Status::not_converged);
    CHECK(std::isnan(values[7]));
    CHECK(solve().status == Status::ok);
    CHECK(values[7] == 2);
}

TEST_CASE("a long line is as accurate as its ends", "[grid][dirichlet]") {
    for (const std::size_t n : {std::size_t{3}, std::size_t{170}, std::size_t{1001}, std::size_t{100001}}) {
        CAPTURE(n);
        const CellBox<1> cells{{n}};
        std::vector<std::uint8_t> given(n, 0);
        given[0] = given[n - 1] = 1;
        std::vector<double> values(n);
        values[0] = 0.3;
        values[n - 1] = 0.7;
        REQUIRE(cageform::solve_dirichlet(cells, given, values).status == Status::ok);
        double error = 0;
        for (std::size_t i = 0; i < n; ++i)
            error =
                cageform_tests::larger(error, std::fabs(values[i] - (0.3 + 0.4 * double(i) / double(n - 1))));
        CHECK(error <= 1e-9);
    }
}

TEST_CASE("solve_dirichlet calls its progress after every cycle", "[grid][dirichlet][progress]") {
    const auto problem = random_problem<2>(4);
    std::vector<double> values(3 * problem.cells.size(), 1.0);
    for (std::size_t i = 0; i < values.size(); i += 3) values[i] = 2;
    const auto before = values;
    int asked = 0;
    double last = 0;
    cageform::Running running;
    running.progress = [&](double done) {
        CHECK(done >= last);
        last = done;
        return ++asked < 2;
    };
    CHECK(cageform::solve_dirichlet(problem.cells, problem.given, values, {.tolerance = 1e-9}, running)
              .status == Status::cancelled);
    CHECK(asked == 2);
    CHECK((values == before));
}

} // namespace dirichlet_tests
