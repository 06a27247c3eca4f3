// A sparse matrix stored by rows, its transpose, and the Galerkin product of multigrid.
#pragma once

#include <cageform/core/detail/buffer.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A sparse matrix in compressed row storage.
struct LevelRows {
    struct Entry {
        std::uint32_t column;
        float weight;
    };
    Buffer<std::uint32_t> begin{1, 0}; ///< #rows + 1
    Buffer<Entry> entries;

    std::size_t rows() const noexcept { return begin.size() - 1; }
    std::span<const Entry> of(std::size_t row) const noexcept {
        return {entries.data() + begin[row], begin[row + 1] - begin[row]};
    }
    void end_row() { begin.push_back(std::uint32_t(entries.size())); }
    void shrink_to_fit() {
        begin.shrink_to_fit();
        entries.shrink_to_fit();
    }
    std::size_t bytes() const noexcept {
        return begin.capacity() * sizeof(std::uint32_t) + entries.capacity() * sizeof(Entry);
    }
};

/// Returns the transpose. The columns of every row are in ascending order.
inline LevelRows transposed(const LevelRows& matrix, std::size_t columns) {
    LevelRows t;
    t.begin = Buffer<std::uint32_t>(columns + 1, 0);
    for (const auto& entry : matrix.entries) ++t.begin[entry.column + 1];
    for (std::size_t c = 0; c < columns; ++c) t.begin[c + 1] += t.begin[c];
    t.entries.resize(matrix.entries.size());
    Buffer<std::uint32_t> next(t.begin.begin(), t.begin.end());
    for (std::uint32_t row = 0; row < matrix.rows(); ++row) {
        for (const auto& entry : matrix.of(row)) t.entries[next[entry.column]++] = {row, entry.weight};
    }
    return t;
}

/// The equations of one level: diagonal · u − neighbours · u = b.
struct TreeEquations {
    LevelRows neighbours;    ///< the negated off-diagonal entries
    Buffer<double> diagonal; ///< by row
};

/// Returns the coarse equations Pᵀ A P (Galerkin). Entries below 1e-6 of the diagonal are added to
/// the diagonal instead, which keeps the row sums.
inline TreeEquations galerkin(const TreeEquations& fine, const LevelRows& p, std::size_t coarse) {
    constexpr double least = 1e-6;
    constexpr std::uint32_t none = ~std::uint32_t{0};
    TreeEquations out;
    const LevelRows r = transposed(p, coarse);
    Buffer<std::uint32_t> slot(coarse, none); // by column: its position in `row`, or none
    struct Sum {
        std::uint32_t column;
        double value;
    };
    Buffer<Sum> row;
    for (std::uint32_t i = 0; i < coarse; ++i) {
        row.clear();
        const auto add = [&](std::uint32_t column, double value) {
            if (slot[column] == none) {
                slot[column] = std::uint32_t(row.size());
                row.push_back({column, 0});
            }
            row[slot[column]].value += value;
        };
        for (const auto& [k, w] : r.of(i)) {
            for (const auto& [j, v] : p.of(k)) add(j, double(w) * fine.diagonal[k] * double(v));
            for (const auto& [n, a] : fine.neighbours.of(k)) {
                for (const auto& [j, v] : p.of(n)) add(j, -double(w) * double(a) * double(v));
            }
        }
        std::sort(row.begin(), row.end(), [](const Sum& a, const Sum& b) { return a.column < b.column; });
        double diagonal = 0;
        for (const auto& [column, value] : row) {
            slot[column] = none;
            if (column == i) diagonal = value;
        }
        const double whole = diagonal;
        for (const auto& [column, value] : row) {
            if (column == i) continue;
            if (std::abs(value) < least * whole) {
                diagonal += value;
            } else {
                out.neighbours.entries.push_back({column, float(-value)});
            }
        }
        out.diagonal.push_back(diagonal);
        out.neighbours.end_row();
    }
    return out;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
