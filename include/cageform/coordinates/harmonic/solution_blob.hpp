// The binary layout of the solved functions of a cage, for files that other processes map and sample without
// a solve or a copy.
//
// The byte order is that of the writing machine, marked by a tag. Each array is given by an offset and begins
// at a multiple of 64 bytes.
//
//     SolutionHeader
//     groups        #groups × SolutionGroup: sixteen functions each
//     grid_errors   SolverReport::Tree::grid_errors, float
//     words         for each group ⌈#nodes / 64⌉ × SolutionWord: the nodes with values
//     rows          for each group, after its words: the sixteen values of each of these nodes, float
//
// The grid is not stored. The reader makes it from its cage, in a tenth of the time of a solve, and refuses
// functions that were solved on another grid.
#pragma once

#include <cageform/coordinates/harmonic/cage_functions.hpp>
#include <cageform/core/detail/packed_memory.hpp>
#include <cageform/core/types/buffer.hpp>

#include <bit>
#include <cmath>
#include <cstring>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The first 256 bytes of packed functions. Offsets are in bytes from the beginning.
struct SolutionHeader {
    static constexpr std::uint64_t magic_number = 0x766C6F7365676163u; // "cagesolv" in little endian
    static constexpr std::uint32_t current_version = 1;

    std::uint64_t magic = magic_number;
    std::uint32_t version = current_version;
    std::uint32_t endian = 0x01020304u;
    std::uint64_t bytes = 0;                       ///< total size, a multiple of 64
    std::uint64_t checksum = 0;                    ///< `hash_memory` of all bytes after this field
    std::uint32_t dimension = 0, scalar_bytes = 0; ///< scalar_bytes is always 0
    std::uint64_t cage_hash = 0;                   ///< of vertices and faces, in double
    std::uint64_t grid_hash = 0;                   ///< of the grid's cells, boundary values and locality
    double accuracy = 0;                           ///< HarmonicOptions::accuracy
    std::uint64_t group_count = 0, nodes = 0, groups = 0;
    std::uint64_t grid_errors = 0, grid_error_count = 0;
    // The report of the solve.
    std::uint64_t cells = 0, solves = 0, solver_bytes = 0, cycles = 0;
    double convergence_factor = 0, error_estimate = 0, error_bound = 0;
    double finest_size = 0, finest_position[3] = {};
    std::uint64_t finest_reason = 0;
    std::uint64_t padding[7] = {};
};
static_assert(sizeof(SolutionHeader) == 256);

struct SolutionGroup {
    std::uint64_t words = 0, rows = 0, row_count = 0;
};

/// A bit mask of 64 nodes: those with values.
struct SolutionWord {
    std::uint64_t nodes = 0;
    std::uint32_t before = 0; ///< number of rows of earlier words
    std::uint32_t reserved = 0;
};

using SolutionRow = Lanes<float>;

/// The kept functions of a group: the values of sixteen functions at some of the nodes. Stored in its own
/// memory, or in packed functions, which must outlive this object.
class KeptFunctions {
public:
    KeptFunctions() = default;
    KeptFunctions(KeptFunctions&&) noexcept = default; // does not move the memory
    KeptFunctions& operator=(KeptFunctions&&) noexcept = default;
    KeptFunctions(const KeptFunctions&) = delete;
    KeptFunctions& operator=(const KeptFunctions&) = delete;
    ~KeptFunctions() = default;

    /// Refers to packed functions.
    KeptFunctions(std::span<const SolutionWord> words, std::span<const SolutionRow> rows) noexcept
        : words_(words.data())
        , rows_(rows.data())
        , word_count_(words.size())
        , row_count_(rows.size()) {}

    /// Keeps the values of a solved block at nodes where any of them exceeds `least`, as float, the scalar of
    /// the cycles.
    template <class Block>
    KeptFunctions(const Block& block, std::uint32_t nodes, double least)
        : own_words_((nodes + 63) / 64, SolutionWord{}) {
        const auto is_kept = [&](std::uint32_t node) {
            bool any = false;
            for (const double x : block.value(node)) any = any || std::fabs(x) > least;
            return any;
        };
        for (const std::uint32_t node : block.valued()) {
            if (is_kept(node)) own_words_[node / 64].nodes |= std::uint64_t{1} << (node % 64);
        }
        std::uint32_t count = 0;
        for (auto& word : own_words_) {
            word.before = count;
            count += std::uint32_t(std::popcount(word.nodes));
        }
        own_rows_.resize(count);
        words_ = own_words_.data();
        rows_ = own_rows_.data();
        word_count_ = own_words_.size();
        row_count_ = count;
        for (const std::uint32_t node : block.valued()) {
            if (!has(node)) continue;
            const auto values = block.value(node);
            for (std::size_t k = 0; k < values.size(); ++k) own_rows_[row(node)][k] = float(values[k]);
        }
    }

    /// Returns whether a node has stored values. Others are zero.
    bool has(std::uint32_t node) const noexcept {
        return ((words_[node / 64].nodes >> (node % 64)) & 1u) != 0;
    }
    std::array<double, lane_count<float>> value(std::uint32_t node) const noexcept {
        std::array<double, lane_count<float>> values{};
        if (!has(node)) return values;
        const SolutionRow& stored = rows_[row(node)];
        for (std::size_t k = 0; k < values.size(); ++k) values[k] = double(stored[k]);
        return values;
    }

    std::span<const SolutionWord> words() const noexcept { return {words_, word_count_}; }
    std::span<const SolutionRow> rows() const noexcept { return {rows_, row_count_}; }

private:
    std::size_t row(std::uint32_t node) const noexcept {
        const SolutionWord& word = words_[node / 64];
        return word.before + std::size_t(std::popcount(word.nodes & ((std::uint64_t{1} << (node % 64)) - 1)));
    }

    Buffer<SolutionWord> own_words_;
    Buffer<SolutionRow> own_rows_;
    const SolutionWord* words_ = nullptr;
    const SolutionRow* rows_ = nullptr;
    std::size_t word_count_ = 0, row_count_ = 0;
};

/// Hashes the vertices and the faces (2D: edges) of a cage.
template <std::size_t D>
std::uint64_t hash_of_cage(const SolverInput<D>& input) noexcept {
    std::uint64_t hash = hash_memory(input.cage.vertices(), input.handles);
    if constexpr (D == 2) {
        for (const auto& loop : input.cage.boundary().loops()) hash = hash_memory({}, hash + loop.size());
    } else {
        hash = hash_memory(input.cage.boundary().faces(), hash);
    }
    return hash;
}

/// Packs kept functions. Throws std::bad_alloc.
///
///   header  all fields that do not depend on the arrays
inline std::vector<std::byte> pack_solution(SolutionHeader header, std::span<const KeptFunctions> functions,
                                            const SolverReport& report) {
    const auto& errors = report.tree.grid_errors;
    header.group_count = functions.size();
    header.groups = sizeof(header);
    header.grid_errors = header.groups + whole_lines(functions.size() * sizeof(SolutionGroup));
    header.grid_error_count = errors.size();
    header.cells = report.cells;
    header.solves = report.solves;
    header.solver_bytes = report.bytes;
    header.cycles = report.multigrid.cycles;
    header.convergence_factor = report.multigrid.convergence_factor;
    header.error_estimate = report.multigrid.error_estimate;
    header.error_bound = report.multigrid.error_bound;
    header.finest_size = report.tree.finest_size;
    for (std::size_t k = 0; k < 3; ++k) header.finest_position[k] = report.tree.finest_position[k];
    header.finest_reason = std::uint64_t(report.tree.finest_reason);
    std::uint64_t end = header.grid_errors + whole_lines(errors.size() * sizeof(float));
    std::vector<SolutionGroup> groups;
    for (const KeptFunctions& group : functions) {
        const std::uint64_t rows = end + whole_lines(group.words().size_bytes());
        groups.push_back({end, rows, group.rows().size()});
        end = rows + group.rows().size_bytes();
    }
    header.bytes = whole_lines(end);
    std::vector<std::byte> bytes(std::size_t(header.bytes));
    const auto put = [&](std::uint64_t offset, const void* from, std::size_t size) {
        if (size > 0) std::memcpy(bytes.data() + offset, from, size);
    };
    put(header.groups, groups.data(), groups.size() * sizeof(SolutionGroup));
    put(header.grid_errors, errors.data(), errors.size() * sizeof(float));
    for (std::size_t n = 0; n < groups.size(); ++n) {
        put(groups[n].words, functions[n].words().data(), functions[n].words().size_bytes());
        put(groups[n].rows, functions[n].rows().data(), functions[n].rows().size_bytes());
    }
    put(0, &header, sizeof(header));
    header.checksum = hash_memory(std::span<const std::byte>(bytes).subspan(sizeof(PackedPrefix)));
    put(0, &header, sizeof(header));
    return bytes;
}

/// Checks the words and rows of a group: all values are present and finite.
inline bool is_sound_group(std::span<const SolutionWord> words, std::span<const SolutionRow> rows,
                           std::uint64_t nodes) noexcept {
    std::uint64_t count = 0;
    for (const SolutionWord& word : words) {
        if (word.before != count) return false;
        count += std::uint64_t(std::popcount(word.nodes));
    }
    if (count != rows.size()) return false;
    if (nodes % 64 != 0 && (words.back().nodes >> (nodes % 64)) != 0) return false;
    for (const SolutionRow& row : rows) {
        for (std::size_t k = 0; k < lane_count<float>; ++k) {
            if (!std::isfinite(row[k])) return false;
        }
    }
    return true;
}

/// Opens packed functions without a copy.
///
///   known    the required dimension, hashes, accuracy, groups and nodes
///   returns  not_a_solution, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
///            blob_malformed, blob_of_another_cage, blob_of_another_grid, or ok
inline Status open_solution(std::span<const std::byte> data, const SolutionHeader& known,
                            std::vector<KeptFunctions>& functions, SolverReport& report) {
    SolutionHeader header;
    const Status begins =
        read_header(data, BlobCheck::all, {Status::not_a_solution, 0, known.dimension}, header);
    if (begins != Status::ok) return begins;
    if (header.cage_hash != known.cage_hash) return Status::blob_of_another_cage;
    if (header.grid_hash != known.grid_hash || header.accuracy != known.accuracy ||
        header.group_count != known.group_count || header.nodes != known.nodes)
        return Status::blob_of_another_grid;
    const auto holds = [&](std::uint64_t offset, std::uint64_t count, std::uint64_t size) {
        return offset % 64 == 0 && offset >= sizeof(header) && offset <= header.bytes &&
               count <= (header.bytes - offset) / size;
    };
    if (!holds(header.groups, header.group_count, sizeof(SolutionGroup)) ||
        !holds(header.grid_errors, header.grid_error_count, sizeof(float)) ||
        header.finest_reason > std::uint64_t(SizeReason::bone))
        return Status::blob_malformed;
    const auto word_count = std::size_t((header.nodes + 63) / 64);
    std::vector<KeptFunctions> opened;
    for (std::size_t n = 0; n < header.group_count; ++n) {
        SolutionGroup group;
        std::memcpy(&group, data.data() + header.groups + n * sizeof(group), sizeof(group));
        if (!holds(group.words, word_count, sizeof(SolutionWord)) ||
            !holds(group.rows, group.row_count, sizeof(SolutionRow)))
            return Status::blob_malformed;
        const std::span words{reinterpret_cast<const SolutionWord*>(data.data() + group.words), word_count};
        const std::span rows{reinterpret_cast<const SolutionRow*>(data.data() + group.rows),
                             std::size_t(group.row_count)};
        if (!is_sound_group(words, rows, header.nodes)) return Status::blob_malformed;
        opened.emplace_back(words, rows);
    }
    functions = std::move(opened);
    report.cells = std::size_t(header.cells);
    report.solves = std::size_t(header.solves);
    report.bytes = std::size_t(header.solver_bytes);
    report.multigrid.cycles = std::size_t(header.cycles);
    report.multigrid.convergence_factor = header.convergence_factor;
    report.multigrid.error_estimate = header.error_estimate;
    report.multigrid.error_bound = header.error_bound;
    report.tree.finest_size = header.finest_size;
    for (std::size_t k = 0; k < 3; ++k) report.tree.finest_position[k] = header.finest_position[k];
    report.tree.finest_reason = SizeReason(header.finest_reason);
    report.tree.grid_errors.resize(std::size_t(header.grid_error_count));
    if (header.grid_error_count > 0)
        std::memcpy(report.tree.grid_errors.data(), data.data() + header.grid_errors,
                    report.tree.grid_errors.size() * sizeof(float));
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
