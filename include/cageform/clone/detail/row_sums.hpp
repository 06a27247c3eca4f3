// The inner loops of a clone: sums of displacements, weighted by the rows of a block.
#pragma once

#include <cageform/clone/detail/weight_rows.hpp>
#include <cageform/core/view.hpp>

#include <cfloat>
#include <cstdint>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns displacements from a table.
template <class Displacement>
struct TabledDisplacements {
    const Displacement* table;

    const Displacement& operator()(std::size_t i) const noexcept { return table[i]; }
};

/// Computes displacements from the pose.
template <Scalar T, std::size_t D, class Pose>
struct PoseDisplacements {
    const Vec<T, D>* rest;
    const Pose& pose;

    Vec<T, D> operator()(std::size_t i) const noexcept { return to_vec<T>(pose[i]) - rest[i]; }
};

/// Returns the displacements of rows that store their handles.
template <class Source>
struct DisplacementsOfRows {
    Source source;
    const std::uint16_t* handle;

    decltype(auto) operator()(std::size_t row) const noexcept { return source(handle[row]); }
};

/// The displacements of the handles, without allocation: up to 16 kB are tabulated on the stack; more are
/// recomputed at each use.
template <class Source>
class Displacements {
public:
    Displacements(const Source& source, std::size_t handles) noexcept
        : source_(source)
        , tabled_(handles <= capacity) {
        if (!tabled_) return;
        for (std::size_t i = 0; i < handles; ++i) table_[i] = source_(i);
    }

    /// Calls f(displacement), where displacement(i) is the displacement of handle i.
    template <class F>
    void with(const F& f) const noexcept {
        if (tabled_) {
            f(TabledDisplacements<Displacement>{table_});
        } else {
            f(source_);
        }
    }

private:
    using Displacement = decltype(std::declval<const Source&>()(std::size_t{}));
    static constexpr std::size_t capacity = 16384 / sizeof(Displacement);

    Source source_;
    bool tabled_;
    Displacement table_[capacity];
};

/// Calls f(0) … f(N − 1) with constant indices, so that arrays indexed by them stay in registers.
template <std::size_t N, class F>
CAGEFORM_DETAIL_INLINE inline void unroll(const F& f) noexcept {
    [&]<std::size_t... I>(std::index_sequence<I...>) CAGEFORM_DETAIL_INLINE {
        (f(std::integral_constant<std::size_t, I>{}), ...);
    }(std::make_index_sequence<N>{});
}

/// Where weights are read from.
enum class WeightsIn : std::uint8_t { caches, memory };

/// Prefetch distance of weights in memory, in bytes. The hardware prefetcher of Intel's server cores stops at
/// page boundaries: with software prefetching a clone takes 5 ms instead of 8. The prefetcher of Zen cores
/// does not stop; there software prefetching costs a tenth. With narrow registers it costs more.
#if CAGEFORM_REGISTER_BYTES == 64 && !defined(__znver1__) && !defined(__znver2__) && !defined(__znver3__) && \
    !defined(__znver4__) && !defined(__znver5__)
inline constexpr std::size_t weights_ahead = 8192;
#else
inline constexpr std::size_t weights_ahead = 0;
#endif

/// The number of sums that fit into registers besides the operands.
template <std::size_t D>
inline constexpr std::size_t sums_in_registers = (CAGEFORM_REGISTER_BYTES >= 32 ? 12 : 9) / D;
#if defined(CAGEFORM_DETERMINISTIC)
inline constexpr std::size_t most_chains = 1; // one order of additions for all register widths
#else
inline constexpr std::size_t most_chains = 4;
#endif

/// The number of blocks summed together. It is 1 if intermediate results have excess precision (x87): then
/// only identical instructions give identical bits, and the last blocks are always summed singly.
template <std::size_t D>
inline constexpr std::size_t blocks_together = FLT_EVAL_METHOD == 0 ? sums_in_registers<D> : 1;

#if !defined(__GNUC__) || defined(__OPTIMIZE__)
/// Computes Σ w_r d_r over the rows of blocks, for weights of a format and displacements of `D` numbers. One
/// register's width of a block is processed at a time, so rows stay in the first-level cache.
template <WeightFormat Format, Scalar T, std::size_t D>
class RowSums {
public:
    static constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);

    /// Sums one block, read as one stream, in independent chains. `displacement(row)` returns d for rows
    /// [0, rows).
    template <WeightsIn Where, class Displacement>
    static void of_block(const std::byte* weights, std::size_t rows, const Displacement& displacement,
                         Lanes<T>* sums) noexcept {
        constexpr std::size_t chains =
            sums_in_registers<D> < most_chains ? sums_in_registers<D> : most_chains;
        for (std::size_t group = 0; group < groups; ++group) {
            const std::byte* const begin = weights + group * (row_bytes / groups);
            Register sum[chains][D] = {};
            const auto add_to = [&](std::size_t chain, std::size_t row) CAGEFORM_DETAIL_INLINE {
                const std::byte* const w = begin + row * row_bytes;
                if constexpr (Where == WeightsIn::memory && weights_ahead != 0) prefetch(w, weights_ahead);
                add_row<1>(w, 0, displacement(row), sum + chain);
            };
            std::size_t row = 0;
            for (; row + chains <= rows; row += chains)
                unroll<chains>([&](auto c) CAGEFORM_DETAIL_INLINE { add_to(c, row + c); });
            unroll<(chains - 1) * D>([&](auto n) CAGEFORM_DETAIL_INLINE {
                sum[0][n % D] = sum[0][n % D] + sum[n / D + 1][n % D];
            });
            for (; row < rows; ++row) add_to(0, row);
            store(sum[0], group, sums);
        }
    }

    /// Sums `Blocks` adjacent blocks together, with common displacements.
    template <std::size_t Blocks, class Displacement>
    static void of_blocks(const std::byte* weights, std::size_t rows, const Displacement& displacement,
                          Lanes<T> (*sums)[D]) noexcept {
        for (std::size_t group = 0; group < groups; ++group) {
            const std::byte* const begin = weights + group * (row_bytes / groups);
            Register sum[Blocks][D] = {};
            for (std::size_t row = 0; row < rows; ++row)
                add_row<Blocks>(begin + row * row_bytes, rows * row_bytes, displacement(row), sum);
            unroll<Blocks>([&](auto b) CAGEFORM_DETAIL_INLINE { store(sum[b], group, sums[b]); });
        }
    }

private:
    using Register = typename Simd<T>::Register;
    static constexpr std::size_t groups = Simd<T>::count;

    /// Adds w d of one row to the sums of blocks at a distance of `block_bytes`.
    template <std::size_t Blocks>
    CAGEFORM_DETAIL_INLINE static void add_row(const std::byte* row, std::size_t block_bytes,
                                               const Vec<T, D>& d, Register (*sum)[D]) noexcept {
        Register factor[D];
        unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE { factor[k] = d[k] - Register{}; });
        unroll<Blocks>([&](auto b) CAGEFORM_DETAIL_INLINE {
            Register w = load_weights<Format, T>(row + b * block_bytes);
            optimizer_barrier(w); // otherwise GCC would reload it for every product
            unroll<D>([&](auto k)
                          CAGEFORM_DETAIL_INLINE { sum[b][k] = multiply_add(w, factor[k], sum[b][k]); });
        });
    }
    CAGEFORM_DETAIL_INLINE static void store(const Register (&sum)[D], std::size_t group,
                                             Lanes<T>* sums) noexcept {
        unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE {
            std::memcpy(sums[k].v + group * (lane_count<T> / groups), &sum[k], sizeof(Register));
        });
    }
};
#else
/// A variant for builds without optimisation, where each lambda and function is a call. There the class above
/// is sixty times slower than with optimisation; this class is ten times slower with clang and a few times
/// with GCC.
template <WeightFormat Format, Scalar T, std::size_t D>
class RowSums {
public:
    static constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);

    template <WeightsIn, class Displacement>
    static void of_block(const std::byte* weights, std::size_t rows, const Displacement& displacement,
                         Lanes<T>* sums) noexcept {
        Register sum[Simd<T>::count * D] = {};
        std::size_t row = 0;
        for (; row + 4 <= rows; row += 4) {
            const Vec<T, D> d[] = {displacement(row), displacement(row + 1), displacement(row + 2),
                                   displacement(row + 3)};
            add_rows(weights + row * row_bytes, d, sum, std::make_index_sequence<4>{});
        }
        for (; row < rows; ++row) {
            const Vec<T, D> d[] = {displacement(row)};
            add_rows(weights + row * row_bytes, d, sum, std::index_sequence<0>{});
        }
        for (std::size_t group = 0; group < Simd<T>::count; ++group) {
            for (std::size_t k = 0; k < D; ++k)
                store_bytes(sums[k].v + group * (lane_count<T> / Simd<T>::count), sum[group * D + k]);
        }
    }
    template <std::size_t Blocks, class Displacement>
    static void of_blocks(const std::byte* weights, std::size_t rows, const Displacement& displacement,
                          Lanes<T> (*sums)[D]) noexcept {
        for (std::size_t b = 0; b < Blocks; ++b)
            of_block<WeightsIn::caches>(weights + b * rows * row_bytes, rows, displacement, sums[b]);
    }

private:
    using Register = typename Simd<T>::Register;

    /// Adds w d of some adjacent rows to the sums of a block. GCC optimises this function in every build;
    /// clang has no such attribute.
    template <std::size_t... R>
#if !defined(__clang__)
    __attribute__((optimize("O2")))
#endif
    static void
    add_rows(const std::byte* rows, const Vec<T, D> (&d)[sizeof...(R)], Register* sum,
             std::index_sequence<R...>) noexcept {
        Register factor[D][sizeof...(R)];
        for (std::size_t k = 0; k < D; ++k) ((factor[k][R] = d[R].v[k] - Register{}), ...);
        for (std::size_t group = 0; group < Simd<T>::count; ++group, rows += row_bytes / Simd<T>::count) {
            const Register w[] = {load_weights<Format, T>(rows + R * row_bytes)...};
            for (const auto& f : factor) {
#if defined(CAGEFORM_DETERMINISTIC)
                *sum = (*sum + ... + product(w[R], f[R]));
#else
                *sum = (*sum + ... + (w[R] * f[R])); // without a call
#endif
                ++sum;
            }
        }
    }
};
#endif

} // namespace cageform::inline CAGEFORM_ABI::detail
