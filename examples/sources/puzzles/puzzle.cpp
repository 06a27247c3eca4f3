// Number puzzles: some cells of a table are given, each other cell is the mean of its neighbours.
//
//     puzzle grid.csv --exact -o solved.svg
//
// The solution exists and is unique if every unknown cell is connected to a given one. --exact computes
// fractions (GMP) by elimination with non-zero pivots, which proves uniqueness for the table. The value of a
// cell is also the expected value that random walks from the cell find at the first given cell.

#include "cli/command_line.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "puzzles/exact_puzzle.hpp"
#include "svg/xml.hpp"

#include <cageform/fields/graph.hpp>

#include <iostream>
#include <random>

namespace {

using namespace cageform_sources;

Expected<Puzzle> read_puzzle(const std::string& path, int neighbours) {
    Puzzle puzzle{path, 0, 0, {}, {}, neighbours};
    const auto size = read_table(path, [&](std::string_view cell) -> std::string {
        const bool unknown = cell.empty() || cell == ".";
        puzzle.given.push_back(unknown ? 0 : 1);
        if (parse_fraction(unknown ? "0" : cell, puzzle.values.emplace_back())) return {};
        return "\"" + std::string(cell.substr(0, 40)) + "\" is not a whole number or a fraction a/b";
    });
    if (!size) return size.error();
    puzzle.rows = size->rows;
    puzzle.columns = size->columns;
    return puzzle;
}

/// Solves with the library, in double.
std::string solve(const Puzzle& puzzle, std::vector<double>& solution) {
    const cageform::CellBox<2> cells{{puzzle.columns, puzzle.rows}};
    const auto links = cageform::grid_links(cells, puzzle.neighbours == 8 ? cageform::CellNeighbours::all
                                                                          : cageform::CellNeighbours::face);
    solution.clear();
    for (const mpq_class& value : puzzle.values) solution.push_back(value.get_d());
    const auto solved = cageform::solve_graph({cells.size(), links}, puzzle.given, solution);
    if (solved.status == cageform::Status::ok) return {};
    const bool at_cell = solved.solver.culprit < cells.size();
    return (at_cell ? puzzle.place(solved.solver.culprit) : puzzle.name) + ": " + to_string(solved.status);
}

/// The mean value of random walks, and its standard error.
std::array<double, 2> walk(const Puzzle& puzzle, std::size_t from, std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    double sum = 0, squares = 0;
    for (std::size_t n = 0; n < count; ++n) {
        std::size_t cell = from;
        while (puzzle.given[cell] == 0) {
            std::array<std::size_t, 8> around{};
            std::size_t ways = 0;
            puzzle.for_each_neighbour(cell, [&](std::size_t other) { around[ways++] = other; });
            cell = around[std::uniform_int_distribution<std::size_t>(0, ways - 1)(random)];
        }
        const double value = puzzle.values[cell].get_d();
        sum += value;
        squares += value * value;
    }
    const double mean = sum / double(count);
    return {mean, std::sqrt(std::max(0.0, squares / double(count) - mean * mean) / double(count))};
}

/// A table with given border and integer solution: a + bx + cy + dxy + e (x² − y²), which four and eight
/// neighbours reproduce.
Puzzle make_puzzle(std::size_t rows, std::size_t columns, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::array<int, 5> part{};
    for (int& x : part) x = std::uniform_int_distribution<int>(-3, 3)(random);
    Puzzle puzzle{"", rows, columns, {}, {}, 4};
    for (std::size_t cell = 0; cell < rows * columns; ++cell) {
        const auto x = long(cell % columns), y = long(cell / columns);
        const bool rim = x == 0 || y == 0 || x + 1 == long(columns) || y + 1 == long(rows);
        puzzle.given.push_back(rim ? 1 : 0);
        puzzle.values.emplace_back(part[0] + part[1] * x + part[2] * y + part[3] * x * y +
                                   part[4] * (x * x - y * y));
    }
    return puzzle;
}

std::string table_text(const Puzzle& puzzle, bool unknown_too) {
    std::string text;
    for (std::size_t cell = 0; cell < puzzle.values.size(); ++cell) {
        text += puzzle.given[cell] != 0 || unknown_too ? puzzle.values[cell].get_str() : ".";
        text += (cell + 1) % puzzle.columns == 0 ? '\n' : ',';
    }
    return text;
}
std::string short_decimal(double value) {
    return text_of("%.6g", value);
}

/// Draws as in figures 23 to 25 of the course text: given cells in grey, the others with their answers.
std::string picture(const Puzzle& puzzle, const std::vector<std::string>& words) {
    constexpr double side = 80;
    const auto number = [](double x) { return format_number(x, 2); };
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-4 -4 " +
                      number(side * double(puzzle.columns) + 8) + " " +
                      number(side * double(puzzle.rows) + 8) +
                      "\" font-family=\"DejaVu Sans, sans-serif\" text-anchor=\"middle\">\n";
    for (std::size_t cell = 0; cell < words.size(); ++cell) {
        const double x = side * double(cell % puzzle.columns), y = side * double(cell / puzzle.columns);
        const double letters =
            std::min(26.0, 1.5 * side / double(std::max<std::size_t>(words[cell].size(), 1)));
        svg += "<rect x=\"" + number(x) + "\" y=\"" + number(y) +
               "\" width=\"80\" height=\"80\" stroke=\"#333\" fill=\"" +
               (puzzle.given[cell] != 0 ? "#dcdcdc" : "white") + "\"/><text x=\"" + number(x + 40) +
               "\" y=\"" + number(y + 40 + 0.35 * letters) + "\" font-size=\"" + number(letters) + "\">" +
               words[cell] + "</text>\n";
    }
    return svg + "</svg>\n";
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Solves a table of numbers in which each unknown cell is the mean of its neighbours.");
    line.set_examples({"grid.csv -o solved.svg", "grid.csv --exact -o solved.svg"});
    std::string path, csv, svg;
    int neighbours = 4;
    bool exact = false;
    std::vector<std::string> size, from;
    std::size_t walks = 0, seed = 1;
    line.add("table", path, "a CSV file: whole numbers, fractions a/b, and . or nothing for unknown cells");
    line.add("--neighbours", neighbours, "the number of neighbours of a cell: 4, or 8 with the diagonal ones")
        .range(4, 8)
        .show_default();
    line.add_flag("--exact", exact, "solve in exact fractions");
    line.add("--csv", csv, "a CSV file to write the solved (with --make the unsolved) table to")
        .ends_with({".csv"});
    line.add("-o,--output", svg, "an SVG file to draw it to").ends_with({".svg"});
    line.add("--walks", walks,
             "the number of random walks from a cell; their mean is printed beside its value")
        .range(1, 1'000'000'000);
    line.add("--from", from, "the line and column of the cell, counted from 1").count(2, 2);
    line.add("--make", size,
             "make a puzzle with this many lines and columns, whose answers are whole numbers")
        .count(2, 2);
    line.add("--seed", seed, "the seed of --walks and --make").show_default();
    if (const auto code = line.parse(argc, argv)) return *code;
    if (neighbours != 4 && neighbours != 8) return fail("--neighbours is 4 or 8");
    const auto count_of = [](const std::string& word, std::size_t least, std::size_t most) {
        std::size_t number = 0;
        const bool digits =
            !word.empty() && word.size() < 7 && std::all_of(word.begin(), word.end(), detail::is_digit);
        if (digits) number = std::stoul(word);
        return number >= least && number <= most ? number : 0;
    };
    OutputFiles outputs;
    if (!size.empty()) {
        const std::size_t rows = count_of(size[0], 3, 1000), columns = count_of(size[1], 3, 1000);
        if (rows == 0 || columns == 0) return fail("--make takes two numbers from 3 to 1000");
        const std::string text = table_text(make_puzzle(rows, columns, seed), false);
        if (csv.empty()) {
            std::cout << text;
            return 0;
        }
        outputs.add(csv).write(text);
        return commit(outputs);
    }
    if (path.empty()) return fail("a table, or --make, is required");
    auto puzzle = read_puzzle(path, neighbours).value();
    std::size_t start = 0;
    if (walks > 0) {
        const std::size_t row = from.empty() ? 0 : count_of(from[0], 1, puzzle.rows);
        const std::size_t column = from.empty() ? 0 : count_of(from[1], 1, puzzle.columns);
        if (row == 0 || column == 0) return fail("--walks needs --from LINE COLUMN, a cell of the table");
        start = (row - 1) * puzzle.columns + column - 1;
    }
    std::vector<double> solution;
    std::string why = solve(puzzle, solution);
    if (why.empty() && exact) why = ExactSolver(puzzle).solve();
    if (!why.empty()) return fail(why);

    std::vector<std::string> words;
    for (std::size_t cell = 0; cell < solution.size(); ++cell) {
        const bool as_fraction = exact || puzzle.given[cell] != 0;
        words.push_back(as_fraction ? puzzle.values[cell].get_str() : short_decimal(solution[cell]));
        std::cout << words.back();
        if (exact && puzzle.given[cell] == 0 && puzzle.values[cell].get_den() != 1)
            std::cout << " = " << short_decimal(puzzle.values[cell].get_d());
        std::cout << ((cell + 1) % puzzle.columns == 0 ? "\n" : "\t");
    }
    if (walks > 0) {
        const auto [mean, error] = walk(puzzle, start, walks, seed);
        std::cout << walks << " walks from there, seed " << seed << ": " << short_decimal(mean)
                  << " with a standard error of " << short_decimal(error) << "; its value is "
                  << short_decimal(solution[start]) << '\n';
    }
    if (!csv.empty()) {
        std::string text;
        for (std::size_t cell = 0; cell < words.size(); ++cell)
            text += words[cell] + ((cell + 1) % puzzle.columns == 0 ? "\n" : ",");
        outputs.add(csv).write(text);
    }
    if (!svg.empty()) outputs.add(svg).write(picture(puzzle, words));
    return commit(outputs);
}
