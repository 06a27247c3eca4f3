// The Dirichlet problem on grids as its callers see it: the printed examples, laws on random masks, refusals.
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/oracle.hpp"

#include <cageform/core/threads.hpp>
#include <cageform/grid/dirichlet.hpp>

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

/// Given on the rim and at some cells in the middle.
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
    constexpr std::size_t fields = 19; // more than go together
    const double scale = std::pow(10.0, random.uniform(-20, 20));
    std::vector<T> values(fields * size);
    for (T& value : values)
        value = static_cast<T>(scale * random.uniform(-1, 1)); // unknown ones are not read
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
        cageform::solve_dirichlet<D, T>(problem.cells, problem.given, values, {.tolerance = tolerance});
    REQUIRE(solved.status == Status::ok);
    CHECK(solved.solver.error_estimate <= tolerance);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (problem.given[i % size] != 0) CHECK(values[i] == before[i]);
    }
    // A linear field is found again; every other obeys the maximum principle and the equation.
    double range = 0;
    for (std::size_t cell = 0; cell < size; ++cell) range = std::max(range, std::fabs(linear_at(cell)));
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
    REQUIRE(cageform::solve_dirichlet<D, T>(problem.cells, problem.given, threaded, {.tolerance = tolerance},
                                            running)
                .status == Status::ok);
    CHECK((threaded == values));
}

} // namespace

TEMPLATE_TEST_CASE("given cells stay, the others are the mean of their neighbours",
                   "[grid][dirichlet][property]", CAGEFORM_SCALARS) {
    const int seed = GENERATE(seeds(15));
    check_laws<1, TestType>(seed);
    check_laws<2, TestType>(seed);
    check_laws<3, TestType>(seed);
}

TEST_CASE("the printed grids are solved", "[grid][dirichlet][oracle]") {
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
        REQUIRE(cageform::solve_dirichlet<2, double>(cells, given, values, {.tolerance = 1e-13}).status ==
                Status::ok);
        for (std::size_t cell = 0; cell < cells.size(); ++cell)
            CHECK(std::fabs(values[cell] - expected[cell]) <=
                  1e-12 * std::max(1.0, std::fabs(expected[cell])));
    }
}

TEST_CASE("grids that cannot be solved are refused and left as they are", "[grid][dirichlet][status]") {
    const CellBox<2> cells{{5, 4}};
    std::vector<std::uint8_t> given(20, 1);
    std::vector<double> values(40, 2.0);
    const auto solve = [&](const cageform::DirichletOptions& options = {},
                           const cageform::Running& running = {}) {
        return cageform::solve_dirichlet<2, double>(cells, given, values, options, running);
    };
    CHECK(solve().status == Status::ok); // nothing to do
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

TEST_CASE("a long line is as right as its ends", "[grid][dirichlet]") {
    for (const std::size_t n : {std::size_t{3}, std::size_t{170}, std::size_t{1001}, std::size_t{100001}}) {
        CAPTURE(n);
        const CellBox<1> cells{{n}};
        std::vector<std::uint8_t> given(n, 0);
        given[0] = given[n - 1] = 1;
        std::vector<double> values(n);
        values[0] = 0.3;
        values[n - 1] = 0.7;
        REQUIRE(cageform::solve_dirichlet<1, double>(cells, given, values).status == Status::ok);
        double error = 0;
        for (std::size_t i = 0; i < n; ++i)
            error = std::max(error, std::fabs(values[i] - (0.3 + 0.4 * double(i) / double(n - 1))));
        CHECK(error <= 1e-9);
    }
}

TEST_CASE("the Dirichlet solver asks its progress after every cycle", "[grid][dirichlet][progress]") {
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
    CHECK(cageform::solve_dirichlet<2, double>(problem.cells, problem.given, values, {.tolerance = 1e-9},
                                               running)
              .status == Status::cancelled);
    CHECK(asked == 2);
    CHECK((values == before));
}

} // namespace dirichlet_tests
