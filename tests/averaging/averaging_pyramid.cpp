#include "averaging/averaging_pyramid.hpp"
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/oracle.hpp"

#include <algorithm>
#include <cmath>

namespace averaging_pyramid_tests {

using cageform::CellBox;
using cageform::epsilon;
using cageform_sources::averaging::AveragingOptions;
using cageform_sources::averaging::AveragingOutcome;
using cageform_sources::averaging::AveragingPyramid;
using cageform_sources::averaging::CellTag;
using cageform_sources::averaging::Stencil;
using cageform_tests::effort;
using cageform_tests::Random;

namespace {

template <class T, std::size_t D>
struct Problem {
    CellBox<D> box;
    std::vector<CellTag> tags;
    std::vector<T> values; // NaN where no value is given: nothing of it may be read
};

template <class T, std::size_t D>
Problem<T, D> all_interior(const typename CellBox<D>::Index& cells) {
    Problem<T, D> problem{{cells}, {}, {}};
    problem.tags.assign(problem.box.size(), CellTag::interior);
    problem.values.assign(problem.box.size(), std::numeric_limits<T>::quiet_NaN());
    return problem;
}

template <class T, std::size_t D>
void fix(Problem<T, D>& problem, std::size_t cell, double value) {
    problem.tags[cell] = CellTag::boundary;
    problem.values[cell] = T(value);
}

template <std::size_t D>
bool on_border(const CellBox<D>& box, std::size_t cell) {
    const auto index = box.index(cell);
    for (std::size_t k = 0; k < D; ++k) {
        if (index[k] == 0 || index[k] + 1 == box.cells[k]) return true;
    }
    return false;
}

/// The neighbours that count for a cell, by looking at every cell there is.
template <std::size_t D>
std::vector<std::size_t> neighbours(const CellBox<D>& box, const std::vector<CellTag>& tags, std::size_t cell,
                                    Stencil stencil) {
    std::vector<std::size_t> found;
    const auto a = box.index(cell);
    for (std::size_t other = 0; other < box.size(); ++other) {
        if (tags[other] != CellTag::boundary && tags[other] != CellTag::interior) continue;
        const auto b = box.index(other);
        std::size_t sum = 0;
        std::size_t largest = 0;
        for (std::size_t k = 0; k < D; ++k) {
            const std::size_t step = a[k] > b[k] ? a[k] - b[k] : b[k] - a[k];
            sum += step;
            largest = cageform_tests::larger(largest, step);
        }
        if (stencil == Stencil::face_neighbours ? sum == 1 : largest == 1) found.push_back(other);
    }
    return found;
}

/// The interior cells from which a walk over counted neighbours gets to a fixed cell.
template <class T, std::size_t D>
std::vector<bool> reached(const Problem<T, D>& problem, Stencil stencil) {
    std::vector<bool> result(problem.box.size(), false);
    std::vector<std::size_t> front;
    for (std::size_t c = 0; c < result.size(); ++c) {
        if (problem.tags[c] == CellTag::boundary) front.push_back(c);
    }
    while (!front.empty()) {
        const std::size_t cell = front.back();
        front.pop_back();
        for (const std::size_t n : neighbours(problem.box, problem.tags, cell, stencil)) {
            if (problem.tags[n] != CellTag::interior || result[n]) continue;
            result[n] = true;
            front.push_back(n);
        }
    }
    return result;
}

/// Fixed and exterior cells anywhere; the fixed values lie in [low, high].
template <class T, std::size_t D>
Problem<T, D> random_problem(Random& random, const typename CellBox<D>::Index& cells, double low, double high,
                             std::size_t one_fixed_in = 5, std::size_t one_exterior_in = 6) {
    auto problem = all_interior<T, D>(cells);
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        if (random.below(one_fixed_in) == 0) {
            fix(problem, c, random.uniform(low, high));
        } else if (random.below(one_exterior_in) == 0) {
            problem.tags[c] = random.below(2) == 0 ? CellTag::exterior : CellTag::untyped;
        }
    }
    return problem;
}

template <class T, std::size_t D>
AveragingOutcome solve(Problem<T, D>& problem, const AveragingOptions& options) {
    AveragingPyramid<T, D> pyramid(problem.box, problem.tags, options);
    return pyramid.solve(std::span<T>(problem.values));
}

/// Sweeps until less than a rounding is left to be gained in all cells together.
template <class T, std::size_t D>
AveragingOptions to_rounding(const Problem<T, D>& problem, Stencil stencil, std::size_t coarsest = 1000) {
    return {.stencil = stencil,
            .coarsest = coarsest,
            .tolerance = double(epsilon<T>) / double(problem.box.size()),
            .max_sweeps = 1000000};
}

/// How far a value may be off when each cell is the mean of its neighbours within `residual`: by as much
/// as a random walk from the cell picks up before it ends on a fixed cell. In a box of which two
/// opposite borders are fixed, n cells apart, that are n²/4 steps along this axis, which every D-th step
/// takes at least.
double walk(std::size_t n, std::size_t dimension) {
    return double(dimension) * double(n * n) / 4;
}

/// The residual to which a mean of up to 26 values of size 1 is known and at which the sweeps above end.
template <class T>
constexpr double mean_rounding = 8 * double(epsilon<T>);

/// The solution by elimination with pivots, for cells that are reached; others keep their value.
template <class T, std::size_t D>
std::vector<double> eliminate(const Problem<T, D>& problem, Stencil stencil) {
    const auto is_reached = reached(problem, stencil);
    std::vector<std::size_t> unknowns;
    std::vector<std::size_t> row_of(problem.box.size(), 0);
    for (std::size_t c = 0; c < problem.box.size(); ++c) {
        if (!is_reached[c]) continue;
        row_of[c] = unknowns.size();
        unknowns.push_back(c);
    }
    const std::size_t n = unknowns.size();
    std::vector<std::vector<double>> m(n, std::vector<double>(n + 1, 0.0));
    for (std::size_t r = 0; r < n; ++r) {
        for (const std::size_t other : neighbours(problem.box, problem.tags, unknowns[r], stencil)) {
            m[r][r] += 1;
            if (problem.tags[other] == CellTag::boundary) {
                m[r][n] += double(problem.values[other]);
            } else {
                m[r][row_of[other]] -= 1;
            }
        }
    }
    for (std::size_t k = 0; k < n; ++k) {
        std::size_t pivot = k;
        for (std::size_t r = k + 1; r < n; ++r) {
            if (std::fabs(m[r][k]) > std::fabs(m[pivot][k])) pivot = r;
        }
        std::swap(m[k], m[pivot]);
        for (std::size_t r = 0; r < n; ++r) {
            if (r == k || m[r][k] == 0) continue;
            const double factor = m[r][k] / m[k][k];
            for (std::size_t c = k; c <= n; ++c) m[r][c] -= factor * m[k][c];
        }
    }
    std::vector<double> solution(problem.values.begin(), problem.values.end());
    for (std::size_t r = 0; r < n; ++r) solution[unknowns[r]] = m[r][n] / m[r][r];
    return solution;
}

/// The values of all cells that a fixed cell reaches; the others have no solution to compare with.
template <class T, std::size_t D>
void check_solution(const Problem<T, D>& problem, Stencil stencil, const std::vector<double>& expected,
                    double tolerance) {
    const auto is_reached = reached(problem, stencil);
    double worst = 0;
    for (std::size_t c = 0; c < expected.size(); ++c) {
        if (is_reached[c])
            worst = cageform_tests::larger(worst, std::fabs(double(problem.values[c]) - expected[c]));
    }
    CHECK(worst <= tolerance);
}

} // namespace

// ---- reference values --------------------------------------------------------------------------

TEMPLATE_TEST_CASE("the solver gives the exact fractions of small grids", "[grid][averaging_pyramid]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto json = cageform_tests::read_json("discrete_dirichlet_grids");
    REQUIRE(json["grids"].size() >= 11);
    for (const auto& grid : json["grids"]) {
        CAPTURE(grid["name"].get<std::string>());
        const std::size_t rows = grid["rows"];
        const std::size_t columns = grid["columns"];
        double largest = 1;
        for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
            const auto& numbers = grid[stencil == Stencil::face_neighbours ? "solution_4_neighbours_numbers"
                                                                           : "solution_8_neighbours_numbers"];
            auto problem = all_interior<T, 2>({columns, rows});
            for (std::size_t r = 0; r < rows; ++r) {
                for (std::size_t c = 0; c < columns; ++c) {
                    if (grid["boundary"][r][c].is_null()) continue;
                    const double value = numbers[r][c];
                    fix(problem, r * columns + c, value);
                    largest = cageform_tests::larger(largest, std::fabs(value));
                }
            }
            const auto outcome = solve(problem, to_rounding(problem, stencil));
            CHECK(outcome.converged);
            CHECK(!outcome.cancelled);
            const double tolerance = mean_rounding<T> * largest * walk(std::min(rows, columns), 2);
            for (std::size_t r = 0; r < rows; ++r) {
                for (std::size_t c = 0; c < columns; ++c) {
                    CAPTURE(r, c, int(stencil));
                    const double expected = numbers[r][c];
                    CHECK(std::fabs(double(problem.values[r * columns + c]) - expected) <= tolerance);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE("the solver agrees with elimination", "[grid][averaging_pyramid][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(25));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto check = [&](auto problem) {
        // The values are in [−1, 1]; a fixed cell is never farther away than the box is long, but the
        // way may wind, so the walk is taken as long as in a corridor of all cells. Far above what is
        // seen.
        const double tolerance = 4 * mean_rounding<TestType> * double(problem.box.size());
        for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
            const auto expected = eliminate(problem, stencil);
            for (const std::size_t coarsest : {std::size_t(1), std::size_t(3), std::size_t(1000)}) {
                CAPTURE(int(stencil), coarsest);
                auto solved = problem;
                CHECK(solve(solved, to_rounding(problem, stencil, coarsest)).converged);
                check_solution(solved, stencil, expected, tolerance);
            }
        }
    };
    const auto side = [&](std::size_t most) { return 1 + random.below(most); };
    check(random_problem<TestType, 1>(random, {side(30)}, -1, 1));
    check(random_problem<TestType, 2>(random, {side(9), side(9)}, -1, 1));
    check(random_problem<TestType, 3>(random, {side(5), side(5), side(5)}, -1, 1));
}

// ---- laws --------------------------------------------------------------------------------------

TEMPLATE_TEST_CASE("every iterate obeys the maximum principle", "[grid][averaging_pyramid][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(effort(40, 10)));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto check = [&](auto problem) {
        double low = 0; // where the sweeps start
        double high = 0;
        for (std::size_t c = 0; c < problem.tags.size(); ++c) {
            if (problem.tags[c] != CellTag::boundary) continue;
            low = std::min(low, double(problem.values[c]));
            high = cageform_tests::larger(high, double(problem.values[c]));
        }
        for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
            for (const std::size_t sweeps : {1u, 3u, 200u}) {
                for (const std::size_t coarsest : {1u, 1000u}) {
                    auto solved = problem;
                    const AveragingOptions options{
                        .stencil = stencil, .coarsest = coarsest, .tolerance = 1e-12, .max_sweeps = sweeps};
                    (void)solve(solved, options);
                    // A mean of up to 26 values of size 3 may round up, once a sweep and level.
                    const double rounding =
                        3 * 26 * double(epsilon<TestType>) * double(sweeps) * (coarsest == 1 ? 5 : 1);
                    std::size_t outside = 0;
                    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
                        if (problem.tags[c] != CellTag::interior) continue;
                        const double value = solved.values[c];
                        outside += !(value >= low - rounding && value <= high + rounding);
                    }
                    CAPTURE(int(stencil), sweeps, coarsest);
                    CHECK(outside == 0);
                }
            }
        }
    };
    check(random_problem<TestType, 1>(random, {50}, -2, 3));
    check(random_problem<TestType, 2>(random, {13, 10}, -2, 3, 12));
    check(random_problem<TestType, 3>(random, {6, 7, 5}, -2, 3, 20));
}

TEMPLATE_TEST_CASE("the solution has no maximum in the interior", "[grid][averaging_pyramid][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    // All fixed values are at least 1: what remained of the start at 0 would show.
    auto problem = random_problem<TestType, 2>(random, {12, 11}, 1, 2, 8);
    for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
        auto solved = problem;
        REQUIRE(solve(solved, to_rounding(problem, stencil)).converged);
        const auto is_reached = reached(problem, stencil);
        const double rounding = mean_rounding<TestType> * 4 * double(problem.box.size());
        for (std::size_t c = 0; c < problem.tags.size(); ++c) {
            if (!is_reached[c]) continue;
            CHECK((solved.values[c] >= 1 - rounding && solved.values[c] <= 2 + rounding));
            double low = 9;
            double high = -9;
            double sum = 0;
            const auto around = neighbours(problem.box, problem.tags, c, stencil);
            for (const std::size_t n : around) {
                low = std::min(low, double(solved.values[n]));
                high = cageform_tests::larger(high, double(solved.values[n]));
                sum += double(solved.values[n]);
            }
            CHECK((solved.values[c] >= low - 2 * mean_rounding<TestType> &&
                   solved.values[c] <= high + 2 * mean_rounding<TestType>));
            CHECK(std::fabs(sum / double(around.size()) - double(solved.values[c])) <=
                  2 * mean_rounding<TestType>);
        }
    }
}

TEMPLATE_TEST_CASE("in one dimension the solution is linear between fixed cells",
                   "[grid][averaging_pyramid][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const std::size_t length = 8 + random.below(30);
    auto problem = all_interior<T, 1>({length});
    std::vector<std::size_t> fixed;
    for (std::size_t c = 0; c < length; ++c) {
        if (random.below(6) != 0 && !(fixed.empty() && c + 1 == length)) continue;
        fix(problem, c, random.uniform(-1, 1));
        fixed.push_back(c);
    }
    const auto given = problem.values;
    for (const std::size_t coarsest : {2u, 1000u}) {
        auto solved = problem;
        const auto outcome = solve(solved, to_rounding(problem, Stencil::face_neighbours, coarsest));
        REQUIRE(outcome.converged);
        for (std::size_t c = 0; c < length; ++c) {
            const auto after = std::lower_bound(fixed.begin(), fixed.end(), c);
            double expected;
            if (after == fixed.begin()) {
                expected = double(given[fixed.front()]); // beyond the first and the last it stays the same
            } else if (after == fixed.end()) {
                expected = double(given[fixed.back()]);
            } else {
                const double b = double(*after);
                const double a = double(*(after - 1));
                const double s = (double(c) - a) / (b - a);
                expected = (1 - s) * double(given[std::size_t(a)]) + s * double(given[std::size_t(b)]);
            }
            CAPTURE(c, coarsest);
            // A part that ends at the mirror is half of one twice as long.
            CHECK(std::fabs(double(solved.values[c]) - expected) <= mean_rounding<T> * walk(2 * length, 1));
        }
    }
}

TEMPLATE_TEST_CASE("linear data on a border is continued linearly", "[grid][averaging_pyramid][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(15));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto check = [&](auto problem, auto dimension) {
        constexpr std::size_t D = decltype(dimension)::value;
        const auto& cells = problem.box.cells;
        const std::size_t longest = *std::max_element(cells.begin(), cells.end());
        double slope[D];
        for (double& s : slope) s = random.uniform(-1, 1) / double(D * longest); // values in [−1, 1]
        const auto value = [&](std::size_t cell) {
            const auto index = problem.box.index(cell);
            double sum = 0;
            for (std::size_t k = 0; k < D; ++k) sum += slope[k] * double(index[k]);
            return sum;
        };
        for (std::size_t c = 0; c < problem.tags.size(); ++c) {
            // Some cells within are fixed too: they agree with the rest.
            if (on_border(problem.box, c) || random.below(30) == 0) fix(problem, c, value(c));
        }
        for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
            for (const std::size_t coarsest : {2u, 1000u}) {
                CAPTURE(D, int(stencil), coarsest);
                auto solved = problem;
                REQUIRE(solve(solved, to_rounding(problem, stencil, coarsest)).converged);
                double worst = 0;
                for (std::size_t c = 0; c < problem.tags.size(); ++c)
                    worst = cageform_tests::larger(worst, std::fabs(double(solved.values[c]) - value(c)));
                CHECK(worst <= mean_rounding<TestType> * walk(longest, D));
            }
        }
    };
    const auto side = [&](std::size_t most) { return 3 + random.below(most); };
    check(all_interior<TestType, 2>({side(18), side(18)}), std::integral_constant<std::size_t, 2>());
    check(all_interior<TestType, 3>({side(7), side(7), side(7)}), std::integral_constant<std::size_t, 3>());
}

TEMPLATE_TEST_CASE("constant data gives a constant", "[grid][averaging_pyramid]", CAGEFORM_SCALARS) {
    const double constant = 0.7;
    const auto seed = GENERATE(seeds(10));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    auto problem = random_problem<TestType, 2>(random, {17, 14}, constant, constant, 20);
    for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
        for (const std::size_t coarsest : {2u, 1000u}) {
            auto solved = problem;
            REQUIRE(solve(solved, to_rounding(problem, stencil, coarsest)).converged);
            check_solution(solved, stencil, std::vector<double>(problem.tags.size(), constant),
                           4 * mean_rounding<TestType> * double(problem.tags.size()));
        }
    }
}

TEMPLATE_TEST_CASE("a pyramid ends where one level ends, sooner", "[grid][averaging_pyramid]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    for (const auto stencil : {Stencil::face_neighbours, Stencil::all_neighbours}) {
        for (const std::size_t n : {32u, 37u}) { // a power of two, and a side that is odd on every level
            CAPTURE(int(stencil), n);
            auto problem = all_interior<T, 2>({n, n});
            Random random(n);
            for (std::size_t c = 0; c < problem.tags.size(); ++c) {
                // Smooth data but for its corners: what coarse levels are good at.
                const auto index = problem.box.index(c);
                if (on_border(problem.box, c)) fix(problem, c, index[0] < index[1] ? 1.0 : 0.0);
            }
            const auto given = problem;
            auto options = to_rounding(problem, stencil);
            const auto flat = solve(problem, options);
            REQUIRE(flat.converged);
            for (const std::size_t coarsest : {1u, 4u, 16u}) {
                CAPTURE(coarsest);
                auto other = given;
                options.coarsest = coarsest;
                REQUIRE(solve(other, options).converged);
                double worst = 0;
                for (std::size_t c = 0; c < problem.tags.size(); ++c)
                    worst =
                        cageform_tests::larger(worst, std::fabs(double(problem.values[c] - other.values[c])));
                CHECK(worst <= 2 * mean_rounding<T> * walk(n, 2));
            }
            // At the published tolerance the finest level has less to do when it starts from coarse values.
            const auto sweeps = [&](std::size_t coarsest) {
                auto p = given;
                return solve(p, {.stencil = stencil, .coarsest = coarsest}).sweeps;
            };
            CHECK(sweeps(8) < sweeps(1000));
        }
    }
}

TEMPLATE_TEST_CASE("from the linear guess on a line the first sweep changes nothing",
                   "[grid][averaging_pyramid]", CAGEFORM_SCALARS) {
    using T = TestType;
    auto problem = all_interior<T, 1>({101});
    for (std::size_t c = 0; c <= 100; ++c) problem.values[c] = T(c) / 100;
    fix(problem, 0, 0);
    fix(problem, 100, 1);
    for (const std::size_t coarsest : {8u, 1000u}) { // one level either way
        auto guessed = problem;
        const auto once = solve(guessed, {.coarsest = coarsest,
                                          .tolerance = double(epsilon<T>),
                                          .max_sweeps = 1,
                                          .use_initial_values = true});
        CHECK(once.converged);
        CHECK(once.sweeps == 1);
        for (std::size_t c = 0; c <= 100; ++c)
            CHECK(std::fabs(double(guessed.values[c]) - double(c) / 100) <= 2 * double(epsilon<T>));
    }
    auto from_zero = problem; // whatever the interior cells hold
    const auto outcome = solve(from_zero, {.coarsest = 1000, .tolerance = 1e-7});
    CHECK(outcome.converged);
    CHECK(outcome.sweeps > 2000);
    // A sweep continues from the sweep before: n sweeps together equal n single sweeps.
    auto together = problem, apart = problem;
    for (std::size_t c = 1; c < 100; ++c) together.values[c] = apart.values[c] = c % 7 == 0 ? T(1) : T(0.25);
    (void)solve(together, {.tolerance = 0, .max_sweeps = 5, .use_initial_values = true});
    for (int n = 0; n < 5; ++n)
        CHECK(solve(apart, {.tolerance = 0, .max_sweeps = 1, .use_initial_values = true}).sweeps == 1);
    CHECK((together.values == apart.values));
}

TEST_CASE("what a coarser grid pushes is a good first guess", "[grid][averaging_pyramid]") {
    // Data of one side of a square, as a function of a cage's vertex has it.
    const std::size_t n = 256;
    auto problem = all_interior<double, 2>({n, n});
    auto coarse = all_interior<double, 2>({n / 2, n / 2});
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        const auto [x, y] = problem.box.index(c);
        if (on_border(problem.box, c)) fix(problem, c, y == 0 ? double(std::min(x, n - 1 - x)) / n : 0.0);
    }
    std::vector<double> children(coarse.tags.size(), 0.0);
    const auto parent = [&](std::size_t c) {
        const auto [x, y] = problem.box.index(c);
        return coarse.box.number({x / 2, y / 2});
    };
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        if (problem.tags[c] != CellTag::boundary) continue;
        const double sum = children[parent(c)] == 0 ? 0.0 : coarse.values[parent(c)];
        fix(coarse, parent(c), sum + problem.values[c]);
        children[parent(c)] += 1;
    }
    for (std::size_t c = 0; c < children.size(); ++c) {
        if (children[c] > 0) coarse.values[c] /= children[c];
    }
    REQUIRE(solve(coarse, {}).converged); // to the published tolerance
    auto guessed = problem, from_zero = problem, pyramid = problem;
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        if (problem.tags[c] == CellTag::interior) guessed.values[c] = coarse.values[parent(c)];
    }
    const auto with_guess = solve(guessed, {.use_initial_values = true});
    const auto without = solve(from_zero, {.coarsest = 1000});
    CAPTURE(with_guess.sweeps, without.sweeps);
    CHECK(with_guess.converged);
    CHECK(without.converged);
    CHECK(with_guess.sweeps > 1);
    CHECK(3 * with_guess.sweeps <= without.sweeps);
    // By hand it is what the pyramid does.
    CHECK(solve(pyramid, {}).sweeps == with_guess.sweeps);
    CHECK((pyramid.values == guessed.values));
}

TEMPLATE_TEST_CASE("cells beyond the grid are mirrored", "[grid][averaging_pyramid][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(15));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    // Fixed cells anywhere, interior ones at the border; and the same four times, mirrored left and up.
    // With face neighbours a cell's mirror image is the cell itself, which adds nothing to its mean.
    const std::size_t columns = 3 + random.below(6);
    const std::size_t rows = 3 + random.below(6);
    auto quarter = random_problem<T, 2>(random, {columns, rows}, -1, 1, 6);
    if (std::count(quarter.tags.begin(), quarter.tags.end(), CellTag::boundary) == 0) fix(quarter, 0, 1);
    auto whole = all_interior<T, 2>({2 * columns, 2 * rows});
    const auto original = [&](std::size_t cell) {
        const auto [x, y] = whole.box.index(cell);
        return quarter.box.number(
            {x < columns ? columns - 1 - x : x - columns, y < rows ? rows - 1 - y : y - rows});
    };
    for (std::size_t c = 0; c < whole.tags.size(); ++c) {
        whole.tags[c] = quarter.tags[original(c)];
        whole.values[c] = quarter.values[original(c)];
    }
    REQUIRE(solve(quarter, to_rounding(quarter, Stencil::face_neighbours)).converged);
    REQUIRE(solve(whole, to_rounding(whole, Stencil::face_neighbours)).converged);
    const auto is_reached = reached(whole, Stencil::face_neighbours);
    double worst = 0;
    for (std::size_t c = 0; c < whole.tags.size(); ++c) {
        if (is_reached[c])
            worst = cageform_tests::larger(worst,
                                           std::fabs(double(whole.values[c] - quarter.values[original(c)])));
    }
    CHECK(worst <= 4 * mean_rounding<T> * double(whole.tags.size()));
}

// ---- what is given and what is told ------------------------------------------------------------

TEMPLATE_TEST_CASE("only interior cells are written, and only boundary cells read",
                   "[grid][averaging_pyramid][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(15));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    auto problem = random_problem<T, 2>(random, {11, 7}, -1, 1);
    std::size_t interior = 0;
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        interior += problem.tags[c] == CellTag::interior;
        // Interior cells start as NaN; the others that are not read get a number to be found again.
        if (problem.tags[c] == CellTag::exterior || problem.tags[c] == CellTag::untyped)
            problem.values[c] = T(100 + c);
    }
    const auto before = problem.values;
    AveragingPyramid<T, 2> pyramid(problem.box, problem.tags, {.coarsest = 2});
    CHECK(pyramid.unknowns() == interior);
    CHECK(pyramid.solve(std::span<T>(problem.values)).converged);
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        if (problem.tags[c] == CellTag::interior) {
            CHECK(std::fabs(problem.values[c]) <= T(1.001));
        } else {
            CHECK(problem.values[c] == before[c]);
        }
    }
}

TEMPLATE_TEST_CASE("a pyramid solves again as if it were new", "[grid][averaging_pyramid]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    Random random(3);
    const auto problem = random_problem<T, 2>(random, {20, 15}, -1, 1, 10);
    AveragingPyramid<T, 2> pyramid(problem.box, problem.tags, {.coarsest = 3, .tolerance = 1e-4});
    for (int n = 0; n < 3; ++n) {
        auto data = problem;
        for (std::size_t c = 0; c < data.tags.size(); ++c) {
            if (data.tags[c] == CellTag::boundary) data.values[c] = T(random.uniform(-1, 1));
        }
        auto fresh = data;
        const auto again = pyramid.solve(std::span<T>(data.values));
        const auto first = solve(fresh, {.coarsest = 3, .tolerance = 1e-4});
        CHECK(again.sweeps == first.sweeps);
        CHECK(again.mean_change == first.mean_change);
        std::size_t different = 0;
        for (std::size_t c = 0; c < data.tags.size(); ++c) {
            if (data.tags[c] == CellTag::interior) different += data.values[c] != fresh.values[c];
        }
        CHECK(different == 0);
    }
}

TEMPLATE_TEST_CASE("sweeps end at max_sweeps and say so", "[grid][averaging_pyramid]", CAGEFORM_SCALARS) {
    using T = TestType;
    auto problem = all_interior<T, 2>({30, 30});
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        if (on_border(problem.box, c)) fix(problem, c, problem.box.index(c)[0] == 0 ? 1 : 0);
    }
    for (const std::size_t coarsest : {4u, 1000u}) {
        for (const std::size_t most : {1u, 7u}) {
            auto solved = problem;
            const auto outcome =
                solve(solved, {.coarsest = coarsest, .tolerance = 1e-12, .max_sweeps = most});
            CHECK(!outcome.converged);
            CHECK(!outcome.cancelled);
            CHECK(outcome.sweeps == most);
            CHECK(outcome.mean_change >= 1e-12);
        }
    }
    auto solved = problem;
    const auto outcome = solve(solved, {.tolerance = 1e-3});
    CHECK(outcome.converged);
    CHECK(outcome.mean_change < 1e-3);
    CHECK(outcome.sweeps > 1);
}

TEST_CASE("tolerance 0 makes max_sweeps sweeps", "[grid][averaging_pyramid]") {
    auto problem = all_interior<double, 1>({3}); // at rest after one sweep
    fix(problem, 0, 1);
    fix(problem, 2, 1);
    const auto outcome = solve(problem, {.tolerance = 0, .max_sweeps = 12});
    CHECK(outcome.sweeps == 12);
    CHECK(outcome.mean_change == 0);
    CHECK(!outcome.converged);
    CHECK(problem.values[1] == 1);
}

TEMPLATE_TEST_CASE("mean_change is the mean over the unknowns of the last sweep", "[grid][averaging_pyramid]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    Random random(5);
    const auto problem = random_problem<T, 2>(random, {12, 9}, 1, 2);
    const auto unknowns = double(std::count(problem.tags.begin(), problem.tags.end(), CellTag::interior));
    std::vector<T> before(problem.values.size(), T(0)); // where the sweeps start
    for (std::size_t sweeps = 1; sweeps <= 3; ++sweeps) {
        auto solved = problem;
        const auto outcome = solve(solved, {.coarsest = 1000, .tolerance = 1e-12, .max_sweeps = sweeps});
        double change = 0;
        for (std::size_t c = 0; c < before.size(); ++c) {
            if (problem.tags[c] == CellTag::interior)
                change += std::fabs(double(solved.values[c] - before[c]));
        }
        CAPTURE(sweeps);
        CHECK(std::fabs(outcome.mean_change - change / unknowns) <= 8 * epsilon<double> * unknowns);
        before = solved.values;
    }
}

TEMPLATE_TEST_CASE("a solve can be cancelled and leaves no trace", "[grid][averaging_pyramid]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    auto problem = all_interior<T, 2>({200, 200});
    for (std::size_t c = 0; c < problem.tags.size(); ++c) {
        problem.values[c] = T(-5);
        if (on_border(problem.box, c)) fix(problem, c, problem.box.index(c)[0] == 0 ? 1 : 0);
    }
    const auto before = problem.values;
    for (const int asked_before : {0, 2}) {
        for (const std::size_t coarsest : {100u, 1000u}) {
            CAPTURE(asked_before, coarsest);
            AveragingPyramid<T, 2> pyramid(problem.box, problem.tags,
                                           {.coarsest = coarsest, .tolerance = 1e-30});
            int asked = 0;
            const auto outcome =
                pyramid.solve(std::span<T>(problem.values), [&] { return ++asked <= asked_before; });
            CHECK(outcome.cancelled);
            CHECK(!outcome.converged);
            CHECK(asked == asked_before + 1); // no is no
            CHECK(problem.values == before);
        }
    }
}

TEMPLATE_TEST_CASE("problems without fixed or without unknown cells", "[grid][averaging_pyramid]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    SECTION("no fixed cell: the value the sweeps start from") {
        for (const std::size_t coarsest : {1u, 1000u}) {
            auto problem = all_interior<T, 3>({5, 4, 3});
            CHECK(solve(problem, {.coarsest = coarsest}).converged);
            CHECK(problem.values == std::vector<T>(60, T(0)));
        }
    }
    SECTION("all fixed") {
        auto problem = all_interior<T, 2>({5, 4});
        for (std::size_t c = 0; c < 20; ++c) fix(problem, c, double(c));
        const auto before = problem.values;
        const auto outcome = solve(problem, {.coarsest = 1});
        CHECK((outcome.converged && outcome.sweeps == 0 && outcome.mean_change == 0));
        CHECK(problem.values == before);
    }
    SECTION("all exterior") {
        auto problem = all_interior<T, 2>({5, 4});
        problem.tags.assign(20, CellTag::exterior);
        CHECK(solve(problem, {.coarsest = 1}).converged);
    }
    SECTION("one cell") {
        auto problem = all_interior<T, 2>({1, 1});
        CHECK(solve(problem, {.coarsest = 0}).converged);
        CHECK(problem.values[0] == 0);
    }
    SECTION("a cell that only the exterior surrounds") {
        auto problem = all_interior<T, 2>({5, 5});
        for (std::size_t c = 0; c < 25; ++c) {
            if (c != 12) problem.tags[c] = CellTag::exterior;
        }
        CHECK(solve(problem, {.coarsest = 1}).converged);
        CHECK(problem.values[12] == 0);
    }
}

} // namespace averaging_pyramid_tests
