// The inner loops of a clone: sums of handles' displacements, weighted by the rows of a block.
#pragma once

#include <cageform/clone/detail/weight_rows.hpp>
#include <cageform/core/view.hpp>

#include <cfloat>
#include <cstdint>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The displacement of a handle, from a table of them.
template <class Displacement>
struct TabledDisplacements {
    const Displacement* table;

    const Displacement& operator()(std::size_t i) const noexcept { return table[i]; }
};

/// The displacement of a handle, taken from the pose.
template <Scalar T, std::size_t D, class Pose>
struct TakenDisplacements {
    const Vec<T, D>* rest;
    const Pose& pose;

    Vec<T, D> operator()(std::size_t i) const noexcept { return to_vec<T>(pose[i]) - rest[i]; }
};

/// The displacement that a row of weights belongs to, where rows name their handles.
template <class Source>
struct DisplacementsOfRows {
    Source source;
    const std::uint16_t* handle;

    decltype(auto) operator()(std::size_t row) const noexcept { return source(handle[row]); }
};

/// The displacements of handles as `taken` has them. Up to 16 kB of them are put into a table on the
/// stack, more are taken again for each use: nothing is allocated whatever their number.
template <class Taken>
class Displacements {
public:
    Displacements(const Taken& taken, std::size_t handles) noexcept
        : taken_(taken)
        , tabled_(handles <= capacity) {
        if (!tabled_) return;
        for (std::size_t i = 0; i < handles; ++i) table_[i] = taken_(i);
    }

    /// f(displacement), where displacement(i) is that of handle i.
    template <class F>
    void with(const F& f) const noexcept {
        if (tabled_) {
            f(TabledDisplacements<Displacement>{table_});
        } else {
            f(taken_);
        }
    }

private:
    using Displacement = decltype(std::declval<const Taken&>()(std::size_t{}));
    static constexpr std::size_t capacity = 16384 / sizeof(Displacement);

    Taken taken_;
    bool tabled_;
    Displacement table_[capacity];
};

/// f(0), f(1), … f(N − 1), each index a constant: arrays indexed by it are kept in registers.
template <std::size_t N, class F>
CAGEFORM_DETAIL_INLINE inline void unroll(const F& f) noexcept {
    [&]<std::size_t... I>(std::index_sequence<I...>) CAGEFORM_DETAIL_INLINE {
        (f(std::integral_constant<std::size_t, I>{}), ...);
    }
    (std::make_index_sequence<N>{});
}

template <Scalar T, std::size_t Blocks, std::size_t D>
using BlockSums = typename Simd<T>::Register[Blocks][D];

/// Adds w d of one row to the sums of blocks `block_bytes` apart.
template <WeightFormat Format, Scalar T, std::size_t Blocks, std::size_t D>
CAGEFORM_DETAIL_INLINE inline void add_row(const std::byte* row, std::size_t block_bytes, const Vec<T, D>& d,
                                           BlockSums<T, Blocks, D>& sum) noexcept {
    using Register = typename Simd<T>::Register;
    Register factor[D];
    unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE { factor[k] = d[k] - Register{}; });
    unroll<Blocks>([&](auto b) CAGEFORM_DETAIL_INLINE {
        Register w = load_weights<Format, T>(row + b * block_bytes);
        conceal(w); // GNU would load it anew for every product
        unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE { sum[b][k] = multiply_add(w, factor[k], sum[b][k]); });
    });
}

template <Scalar T, std::size_t Blocks, std::size_t D>
CAGEFORM_DETAIL_INLINE inline void add_sums(BlockSums<T, Blocks, D>& sum,
                                            const BlockSums<T, Blocks, D>& other) noexcept {
    unroll<Blocks * D>(
        [&](auto n) CAGEFORM_DETAIL_INLINE { sum[n / D][n % D] = sum[n / D][n % D] + other[n / D][n % D]; });
}

#if defined(__GNUC__) && !defined(__OPTIMIZE__)
/// Adds w d of some rows beside each other to the sums of a block. GNU optimises this one function;
/// clang cannot be told to.
template <WeightFormat Format, Scalar T, std::size_t D, std::size_t... R>
#if !defined(__clang__)
__attribute__((optimize("O2")))
#endif
void add_rows_plainly(const std::byte* rows, const Vec<T, D> (&d)[sizeof...(R)],
                      typename Simd<T>::Register* sum, std::index_sequence<R...>) noexcept {
    using Register = typename Simd<T>::Register;
    constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);
    Register factor[D][sizeof...(R)];
    for (std::size_t k = 0; k < D; ++k) ((factor[k][R] = d[R].v[k] - Register{}), ...);
    for (std::size_t part = 0; part < Simd<T>::count; ++part, rows += row_bytes / Simd<T>::count) {
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

/// Σ w_r d_r of a block in builds without optimisation. There each lambda and each function of a row
/// is a call: what `sum_rows` does below would take sixty times as long as with it, this takes ten
/// with clang and a few with GNU.
template <WeightFormat Format, Scalar T, std::size_t D, class Displacement>
void sum_rows_plainly(const std::byte* weights, std::size_t rows, const Displacement& displacement,
                      Lanes<T>* sums) noexcept {
    using Register = typename Simd<T>::Register;
    constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);
    Register sum[Simd<T>::count * D] = {};
    std::size_t row = 0;
    for (; row + 4 <= rows; row += 4) {
        const Vec<T, D> d[] = {displacement(row), displacement(row + 1), displacement(row + 2),
                               displacement(row + 3)};
        add_rows_plainly<Format, T, D>(weights + row * row_bytes, d, sum, std::make_index_sequence<4>{});
    }
    for (; row < rows; ++row) {
        const Vec<T, D> d[] = {displacement(row)};
        add_rows_plainly<Format, T, D>(weights + row * row_bytes, d, sum, std::index_sequence<0>{});
    }
    for (std::size_t part = 0; part < Simd<T>::count; ++part) {
        for (std::size_t k = 0; k < D; ++k)
            store_bytes(sums[k].v + part * (lane_count<T> / Simd<T>::count), sum[part * D + k]);
    }
}
#endif

/// Where weights lie.
enum class WeightsIn : std::uint8_t { caches, memory };

/// How far ahead weights are fetched from memory, in bytes. Server cores of Intel stop fetching ahead by themselves
/// at the end of each page: there a clone takes 5 ms for 8. Zen cores go on, and lose a tenth by being told;
/// all processors with narrow registers lose more.
#if CAGEFORM_REGISTER_BYTES == 64 && !defined(__znver1__) && !defined(__znver2__) && !defined(__znver3__) && \
    !defined(__znver4__) && !defined(__znver5__)
inline constexpr std::size_t weights_ahead = 8192;
#else
inline constexpr std::size_t weights_ahead = 0;
#endif

/// Σ w_r d_r of `Blocks` blocks beside each other, `stride` rows apart, and for each in `Chains`
/// sums that need not wait for each other. `displacement(row)` is d of the rows [0, rows).
template <std::size_t Blocks, std::size_t Chains, WeightsIn Where, WeightFormat Format, Scalar T,
          std::size_t D, class Displacement>
void sum_rows(const std::byte* weights, std::size_t stride, std::size_t rows,
              const Displacement& displacement, Lanes<T> (*sums)[D]) noexcept {
    constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);
#if defined(__GNUC__) && !defined(__OPTIMIZE__)
    for (std::size_t b = 0; b < Blocks; ++b)
        sum_rows_plainly<Format, T, D>(weights + b * stride * row_bytes, rows, displacement, sums[b]);
    return;
#endif
    // A register's width of the block at a time; the rows stay in the first cache level meanwhile.
    for (std::size_t part = 0; part < Simd<T>::count; ++part) {
        const std::byte* const begin = weights + part * (row_bytes / Simd<T>::count);
        BlockSums<T, Blocks, D> sum[Chains] = {};
        const auto add = [&](std::size_t row, std::size_t chain) CAGEFORM_DETAIL_INLINE {
            if constexpr (Where == WeightsIn::memory && weights_ahead != 0)
                fetch_ahead(begin + row * row_bytes, weights_ahead);
            add_row<Format, T, Blocks, D>(begin + row * row_bytes, stride * row_bytes, displacement(row),
                                          sum[chain]);
        };
        std::size_t row = 0;
        for (; row + Chains <= rows; row += Chains)
            unroll<Chains>([&](auto c) CAGEFORM_DETAIL_INLINE { add(row + c, c); });
        unroll<Chains - 1>([&](auto c)
                               CAGEFORM_DETAIL_INLINE { add_sums<T, Blocks, D>(sum[0], sum[c + 1]); });
        for (; row < rows; ++row) add(row, 0);
        unroll<Blocks * D>([&](auto n) CAGEFORM_DETAIL_INLINE {
            std::memcpy(sums[n / D][n % D].v + part * (lane_count<T> / Simd<T>::count), &sum[0][n / D][n % D],
                        sizeof(typename Simd<T>::Register));
        });
    }
}

/// Sums that fit into the registers beside what is multiplied.
template <std::size_t D>
inline constexpr std::size_t sums_in_registers = (CAGEFORM_REGISTER_BYTES >= 32 ? 12 : 9) / D;
#if defined(CAGEFORM_DETERMINISTIC)
inline constexpr std::size_t most_chains = 1; // the same order of additions whatever the registers
#else
inline constexpr std::size_t most_chains = 4;
#endif

/// Blocks summed beside each other. Where results keep more digits than their type has, as x87's do,
/// only the same instructions give the same bits: then all blocks are summed alone, as the last are.
template <std::size_t D>
inline constexpr std::size_t blocks_together = FLT_EVAL_METHOD == 0 ? sums_in_registers<D> : 1;

/// The sums of one block, read as one stream from its first row on.
template <WeightsIn Where, WeightFormat Format, Scalar T, std::size_t D, class Displacement>
void sum_block(const std::byte* weights, std::size_t rows, const Displacement& displacement,
               Lanes<T>* sums) noexcept {
    constexpr std::size_t chains = sums_in_registers<D> < most_chains ? sums_in_registers<D> : most_chains;
    sum_rows<1, chains, Where, Format, T, D>(weights, 0, rows, displacement,
                                             reinterpret_cast<Lanes<T>(*)[D]>(sums));
}

} // namespace cageform::inline CAGEFORM_ABI::detail
