// Exact solutions of puzzles: cells are means of their neighbours, and answers those of the reference.
#include "puzzles/exact_puzzle.hpp"

#include "catch.hpp"
#include "support/cages.hpp"
#include "support/oracle.hpp"

namespace exact_puzzle_tests {

using namespace cageform_tests;
using namespace cageform_sources;

TEST_CASE("puzzles of the reference file are solved to the fraction", "[examples][puzzle][oracle]") {
    const auto reference = read_json("puzzles");
    std::size_t solved = 0;
    for (const auto& entry : reference["puzzles"]) {
        if (entry["shape"].size() > 2) continue; // in space: solve_graph's test
        const bool is_line = entry["shape"].size() == 1;
        CAPTURE(entry["name"].get<std::string>());
        for (std::size_t field = 0; field < entry["given"].size(); ++field) {
            const auto rows_of = [&](const char* key) {
                const auto& table = entry[key][field];
                return is_line ? nlohmann::json::array({table}) : table;
            };
            const auto given = rows_of("given"), wanted = rows_of("solution");
            Puzzle puzzle{"", given.size(), given[0].size(), {}, {}, entry["stencil"] == "all" ? 8 : 4};
            std::vector<mpq_class> answers;
            bool has_outside = false; // cells outside the problem
            for (std::size_t cell = 0; cell < puzzle.rows * puzzle.columns; ++cell) {
                const auto& number = given[cell / puzzle.columns][cell % puzzle.columns];
                const auto& answer = wanted[cell / puzzle.columns][cell % puzzle.columns];
                has_outside = has_outside || answer.is_null();
                puzzle.given.push_back(number.is_null() ? 0 : 1);
                REQUIRE(parse_fraction(number.is_null() ? "0" : number.get<std::string>(),
                                       puzzle.values.emplace_back()));
                if (!answer.is_null())
                    REQUIRE(parse_fraction(answer.get<std::string>(), answers.emplace_back()));
            }
            if (has_outside) continue;
            REQUIRE(ExactSolver(puzzle).solve().empty());
            CHECK(puzzle.values == answers);
            ++solved;
        }
    }
    CHECK(solved >= 21);
}

TEST_CASE("each cell is the mean of its neighbours, to the fraction", "[examples][puzzle][property]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 77);
    Puzzle puzzle{"", 1 + random.below(9), 1 + random.below(9), {}, {}, random.below(2) == 0 ? 4 : 8};
    const std::size_t share = 2 + random.below(8); // on average one in this many cells is given
    for (std::size_t cell = 0; cell < puzzle.rows * puzzle.columns; ++cell) {
        puzzle.given.push_back(
            cell == 0 || random.below(share) == 0 ? 1 : 0); // all regions meet: there is no outside
        puzzle.values.emplace_back(long(random.below(2000)) - 1000, long(1 + random.below(60)));
        puzzle.values.back().canonicalize();
    }
    const auto before = puzzle;
    REQUIRE(ExactSolver(puzzle).solve().empty());
    for (std::size_t cell = 0; cell < puzzle.values.size(); ++cell) {
        CAPTURE(cell);
        if (puzzle.given[cell] != 0) {
            CHECK(puzzle.values[cell] == before.values[cell]);
            continue;
        }
        mpq_class sum = 0;
        long count = 0;
        puzzle.for_each_neighbour(cell, [&](std::size_t other) {
            sum += puzzle.values[other];
            ++count;
        });
        CHECK(puzzle.values[cell] * count == sum);
    }
}

TEST_CASE("a table too large for fractions is refused", "[examples][puzzle]") {
    Puzzle puzzle{"table.csv", 40, 30, std::vector<std::uint8_t>(1200, 0), std::vector<mpq_class>(1200), 4};
    puzzle.given[0] = 1;
    CHECK(ExactSolver(puzzle).solve() ==
          "table.csv: 1199 unknown cells are too many for --exact, which takes 1000");
    puzzle = {"", 1, 2, {1, 1}, {mpq_class(1, 2), 3}, 4};
    CHECK(ExactSolver(puzzle).solve().empty());
    CHECK(puzzle.values[0] == mpq_class(1, 2));
}

} // namespace exact_puzzle_tests
