#pragma once

// Number puzzles solved in exact fractions, by GMP.

#include "svg/path.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// A table of numbers: some cells are given, each of the others is the mean of its neighbours.
struct Puzzle {
    std::string name;
    std::size_t rows = 0, columns = 0;
    std::vector<std::uint8_t> given;
    std::vector<mpq_class> values; // row by row; unknown cells: by ExactSolver
    int neighbours = 4;

    std::string place(std::size_t cell) const {
        return name + ":" + std::to_string(cell / columns + 1) + ": column " +
               std::to_string(cell % columns + 1);
    }
    /// Calls f(neighbour) for each neighbour of a cell.
    template <class F>
    void for_each_neighbour(std::size_t cell, const F& f) const {
        const std::size_t row = cell / columns, column = cell % columns;
        for (std::size_t r = row == 0 ? 0 : row - 1; r <= std::min(row + 1, rows - 1); ++r) {
            for (std::size_t c = column == 0 ? 0 : column - 1; c <= std::min(column + 1, columns - 1); ++c) {
                const bool beside = r == row || c == column;
                if ((r != row || c != column) && (beside || neighbours == 8)) f(r * columns + c);
            }
        }
    }
};

/// Parses a whole number or a/b; false if the text is neither, or b is 0.
inline bool parse_fraction(std::string_view text, mpq_class& value) {
    const std::size_t bar = std::min(text.find('/'), text.size());
    const auto is_whole = [](std::string_view digits) {
        if (!digits.empty() && (digits.front() == '-' || digits.front() == '+')) digits.remove_prefix(1);
        return !digits.empty() && digits.size() < 1000 &&
               std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
    };
    const std::string_view above = text.substr(0, bar),
                           below = bar < text.size() ? text.substr(bar + 1) : "1";
    if (!is_whole(above) || !is_whole(below)) return false;
    const auto number = [](std::string_view digits) {
        if (digits.front() == '+') digits.remove_prefix(1);
        return mpz_class(std::string(digits), 10);
    };
    if (number(below) == 0) return false;
    value = mpq_class(number(above), number(below));
    value.canonicalize();
    return true;
}

/// Solves a puzzle whose unknown cells are all connected to given ones, by elimination in whole numbers
/// (Bareiss 1968) along the narrower side. Each division is exact. Each pivot is the determinant of the
/// equations so far. solve() returns empty, or why it did not try.
///
///   cost   O(#unknown · band²) operations on numbers of about two bits per unknown. The band is the
///          number of cells of the narrower side plus two. 30 x 30 cells take less than a second
class ExactSolver {
public:
    static constexpr std::size_t most_unknowns = 1000;

    explicit ExactSolver(Puzzle& puzzle)
        : puzzle_(puzzle) {
        const bool by_columns = puzzle.rows < puzzle.columns;
        const std::size_t inner = by_columns ? puzzle.rows : puzzle.columns;
        band_ = inner + 2;
        for (std::size_t n = 0; n < puzzle.values.size(); ++n) {
            const std::size_t cell = by_columns ? n % inner * puzzle.columns + n / inner : n;
            if (puzzle.given[cell] == 0) order_.push_back(cell);
        }
    }

    std::string solve() {
        if (order_.size() > most_unknowns) {
            return puzzle_.name + ": " + std::to_string(order_.size()) +
                   " unknown cells are too many for --exact, which takes " + std::to_string(most_unknowns);
        }
        if (order_.empty()) return {};
        set_up();
        eliminate();
        substitute();
        return {};
    }

private:
    void set_up() {
        const std::size_t n = order_.size();
        for (const mpq_class& value : puzzle_.values)
            mpz_lcm(unit_.get_mpz_t(), unit_.get_mpz_t(), value.get_den_mpz_t());
        rows_.assign(n, std::vector<mpz_class>(band_));
        right_.assign(n, 0);
        std::vector<std::size_t> number(puzzle_.values.size());
        for (std::size_t i = 0; i < n; ++i) number[order_[i]] = i;
        for (std::size_t i = 0; i < n; ++i) {
            puzzle_.for_each_neighbour(order_[i], [&](std::size_t other) {
                rows_[i][0] += 1;
                if (puzzle_.given[other] != 0) right_[i] += mpz_class(puzzle_.values[other] * unit_);
                if (puzzle_.given[other] == 0 && number[other] > i) rows_[i][number[other] - i] -= 1;
            });
        }
    }
    /// The matrix is symmetric; only the part right of the diagonal is stored. A column beyond the pivot's
    /// row is only scaled, by the ratio of successive pivots. These ratios multiply to the last pivot, which
    /// scales the column when a row reaches it.
    void eliminate() {
        const std::size_t n = rows_.size();
        mpz_class before = 1, factor;
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t end = std::min(i + band_, n);
            const std::size_t reached = i == 0 ? end : std::min(i + band_ - 1, n);
            for (std::size_t l = reached; l < end; ++l) {
                for (std::size_t j = i; j <= l; ++j) rows_[j][l - j] *= before;
                right_[l] *= before;
            }
            const mpz_class& pivot = rows_[i][0];
            const auto update = [&](mpz_class& x, const mpz_class& in_pivot_row) {
                if (x != 0) x *= pivot;
                mpz_submul(x.get_mpz_t(), factor.get_mpz_t(), in_pivot_row.get_mpz_t());
                mpz_divexact(x.get_mpz_t(), x.get_mpz_t(), before.get_mpz_t());
            };
            for (std::size_t j = i + 1; j < end; ++j) {
                factor = rows_[i][j - i];
                for (std::size_t l = j; l < end; ++l) update(rows_[j][l - j], rows_[i][l - i]);
                update(right_[j], right_[i]);
            }
            before = pivot;
        }
    }
    void substitute() {
        const std::size_t n = rows_.size();
        const mpz_class determinant = rows_.back()[0];
        std::vector<mpz_class> scaled(n); // the solution times the determinant
        for (std::size_t i = n; i-- > 0;) {
            scaled[i] = right_[i] * determinant;
            for (std::size_t k = 1; k < band_ && i + k < n; ++k) scaled[i] -= rows_[i][k] * scaled[i + k];
            mpz_divexact(scaled[i].get_mpz_t(), scaled[i].get_mpz_t(), rows_[i][0].get_mpz_t());
            puzzle_.values[order_[i]] = mpq_class(scaled[i], determinant * unit_);
            puzzle_.values[order_[i]].canonicalize();
        }
    }

    Puzzle& puzzle_;
    std::vector<std::size_t> order_; // of the unknown cells
    std::size_t band_ = 0;
    mpz_class unit_ = 1;                       // the common denominator of the given values
    std::vector<std::vector<mpz_class>> rows_; // [i][k]: of unknowns i and i + k
    std::vector<mpz_class> right_;
};

} // namespace cageform_sources
