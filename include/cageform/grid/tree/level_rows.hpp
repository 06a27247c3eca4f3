// A sparse matrix in compressed row storage, its transpose, and the Galerkin product of multigrid.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

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
    std::span<Entry> of(std::size_t row) noexcept {
        return {entries.data() + begin[row], begin[row + 1] - begin[row]};
    }
    void end_row() { begin.push_back(std::uint32_t(entries.size())); }
    void append(const LevelRows& other) {
        const auto before = std::uint32_t(entries.size());
        for (std::size_t row = 0; row < other.rows(); ++row) begin.push_back(before + other.begin[row + 1]);
        entries.append(other.entries.begin(), other.entries.end());
    }
    void shrink_to_fit() {
        begin.shrink_to_fit();
        entries.shrink_to_fit();
    }
    std::size_t bytes() const noexcept {
        return begin.capacity() * sizeof(std::uint32_t) + entries.capacity() * sizeof(Entry);
    }
};

/// Returns the transpose. The columns of every row are ascending.
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

/// Makes parts like in_runs(), and joins them in order by Part::append.
template <class Part, class WorkOf>
Part joined_runs(const Running& running, std::size_t count, std::size_t least, const WorkOf& work_of) {
    auto parts = in_runs<Part>(running.subtask(0, 0.9), count, least, work_of);
    const Running joining = running.subtask(0.9, 1);
    Part whole;
    for (std::size_t n = 0; n < parts.size(); ++n) {
        if (n == 0) {
            whole = std::move(parts[n]);
        } else {
            whole.append(std::exchange(parts[n], {}));
        }
        report_progress(joining, double(n) / double(parts.size()));
    }
    return whole;
}

/// The equations of one level: diagonal · u − neighbours · u = b.
struct TreeEquations {
    LevelRows neighbours;    ///< the negated off-diagonal entries
    Buffer<double> diagonal; ///< per row

    void append(const TreeEquations& other) {
        neighbours.append(other.neighbours);
        diagonal.append(other.diagonal.begin(), other.diagonal.end());
    }
};

/// Makes rows of the coarse equations (`galerkin`). r is the transpose of p.
class GalerkinRows {
public:
    GalerkinRows(const TreeEquations& fine, const LevelRows& p, const LevelRows& r)
        : fine_(fine)
        , p_(p)
        , r_(r)
        , slot_(r.rows(), none) {}

    void operator()(std::size_t begin, std::size_t end, TreeEquations& out) {
        for (std::size_t i = begin; i < end; ++i) add_row(std::uint32_t(i), out);
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    struct Sum {
        std::uint32_t column;
        double value;
    };

    void add_row(std::uint32_t i, TreeEquations& out) {
        constexpr double least = 1e-6;
        row_.clear();
        for (const auto& [k, w] : r_.of(i)) {
            for (const auto& [j, v] : p_.of(k)) add(j, double(w) * fine_.diagonal[k] * double(v));
            for (const auto& [n, a] : fine_.neighbours.of(k)) {
                for (const auto& [j, v] : p_.of(n)) add(j, -double(w) * double(a) * double(v));
            }
        }
        std::sort(row_.begin(), row_.end(), [](const Sum& a, const Sum& b) { return a.column < b.column; });
        double diagonal = 0;
        for (const auto& [column, value] : row_) {
            slot_[column] = none;
            if (column == i) diagonal = value;
        }
        const double whole = diagonal;
        for (const auto& [column, value] : row_) {
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
    void add(std::uint32_t column, double value) {
        if (slot_[column] == none) {
            slot_[column] = std::uint32_t(row_.size());
            row_.push_back({column, 0});
        }
        row_[slot_[column]].value += value;
    }

    const TreeEquations& fine_;
    const LevelRows &p_, &r_;
    Buffer<std::uint32_t> slot_; ///< per column: its position in row_, or none
    Buffer<Sum> row_;
};

/// Returns the coarse equations Pᵀ A P (Galerkin). Entries below 1e-6 of the diagonal are added to the
/// diagonal, which preserves the row sums.
inline TreeEquations galerkin(const TreeEquations& fine, const LevelRows& p, std::size_t coarse,
                              const Running& running = {}) {
    const LevelRows r = transposed(p, coarse);
    return joined_runs<TreeEquations>(running, coarse, 1024, [&] { return GalerkinRows(fine, p, r); });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
