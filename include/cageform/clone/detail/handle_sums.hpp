// The inner loops of transposed clones: sums over points of gradients times weights of handles.
#pragma once

#include <cageform/clone/detail/block_cloner.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Rows of adjacent blocks of a binding.
struct BlockRows {
    const std::byte* weights;
    std::size_t stride; ///< bytes from a row to the same row of the next block
    std::size_t count;  ///< rows per block
};

/// Adds w g of some rows of adjacent blocks to the sums of their handles, lane by lane. `sums_of(row)`
/// returns D rows of sums. `Last` marks the last block; its lanes without a point may have any weight.
template <std::size_t Blocks, bool Last, WeightFormat Format, Scalar T, std::size_t D, class SumsOf>
void add_transposed(const BlockRows& rows, const Lanes<T> (*gradients)[D], const Lanes<T>& has_point,
                    const SumsOf& sums_of) noexcept {
    using Register = typename Simd<T>::Register;
    constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);
    constexpr std::size_t lanes = lane_count<T> / Simd<T>::count; // of a register
    for (std::size_t group = 0; group < Simd<T>::count; ++group) {
        const std::byte* const begin = rows.weights + group * (row_bytes / Simd<T>::count);
        const auto used = Register{} < load_bytes<Register>(has_point.v + group * lanes);
        Register g[Blocks][D];
        unroll<Blocks * D>([&](auto n) CAGEFORM_DETAIL_INLINE {
            g[n / D][n % D] = load_bytes<Register>(gradients[n / D][n % D].v + group * lanes);
        });
        for (std::size_t row = 0; row < rows.count; ++row) {
            Lanes<T>* const sums = sums_of(row);
            Register sum[D];
            unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE {
                sum[k] = load_bytes<Register>(sums[k].v + group * lanes);
            });
            unroll<Blocks>([&](auto b) CAGEFORM_DETAIL_INLINE {
                Register w = load_weights<Format, T>(begin + row * row_bytes + b * rows.stride);
                if constexpr (Last) w = used ? w : Register{};
                optimizer_barrier(w); // otherwise GCC would reload it for every product
                unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE { sum[k] = multiply_add(w, g[b][k], sum[k]); });
            });
            unroll<D>([&](auto k) CAGEFORM_DETAIL_INLINE { store_bytes(sums[k].v + group * lanes, sum[k]); });
        }
    }
}

/// Returns the sum of the lanes, added in pairs: the same bits for every register width.
template <Scalar T>
T sum_of_lanes(const Lanes<T>& row) noexcept {
    constexpr std::size_t n = 16 / sizeof(T); // a quarter of the lanes, which every register holds
#if CAGEFORM_REGISTER_BYTES != 0
    typedef T Quarter __attribute__((vector_size(16)));
    const auto quarter = [&](std::size_t q) { return load_bytes<Quarter>(row.v + q * n); };
    const Quarter sums = (quarter(0) + quarter(2)) + (quarter(1) + quarter(3));
#else
    T sums[n];
    for (std::size_t lane = 0; lane < n; ++lane)
        sums[lane] = (row[lane] + row[lane + 2 * n]) + (row[lane + n] + row[lane + 3 * n]);
#endif
    if constexpr (n == 2) {
        return sums[0] + sums[1];
    } else {
        return (sums[0] + sums[2]) + (sums[1] + sums[3]);
    }
}

/// Sums move to double after this many blocks of full rows. A multiple of `blocks_together` in 2D and 3D, and
/// of the blocks of a VectorTile.
inline constexpr std::size_t blocks_in_lanes = 192;

/// The sums Σ_p w_hp g_p of up to `Capacity` handles. Each lane adds up some blocks in T; then all lanes are
/// added to totals in double.
template <Scalar T, std::size_t D, std::size_t Capacity>
class HandleSums {
public:
    static constexpr std::size_t capacity = Capacity;

    /// Starts handles [first, first + count) with totals 0.
    void start(std::size_t first, std::size_t count) noexcept {
        first_ = first;
        count_ = count;
        for (std::size_t h = 0; h < count; ++h) totals_[h] = {};
    }
    void clear_lanes() noexcept {
        for (std::size_t h = 0; h < count_; ++h) {
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) Simd<T>(T(0)).store(lanes_[h][k]);
        }
    }

    /// Adds blocks [begin, end) to the lanes. `load(block, rows)` reads a block's gradients into D rows.
    template <WeightFormat Format, class Load>
    void add(const PackedBindingView<T, D>& binding, std::size_t begin, std::size_t end,
             const Load& load) noexcept {
        if (binding.row_begin == nullptr) {
            add_dense<Format>(binding, begin, end, load);
        } else {
            add_sparse<Format>(binding, begin, end, load);
        }
    }
    /// Adds the lanes to the totals. Called often enough to bound rounding errors of floats.
    void add_lanes_to_totals() noexcept {
        for (std::size_t h = 0; h < count_; ++h) {
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) totals_[h][k] += double(sum_of_lanes(lanes_[h][k]));
        }
    }

    const Vec<double, D>& total(std::size_t handle) const noexcept { return totals_[handle - first_]; }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    template <WeightFormat Format>
    static constexpr std::size_t row_bytes = lanes * weight_bytes<T>(Format);

    /// Returns 1 for lanes with a point, else 0.
    static Lanes<T> points_of(const PackedBindingView<T, D>& binding, std::size_t block) noexcept {
        Lanes<T> has_point;
        for (std::size_t lane = 0; lane < lanes; ++lane)
            has_point[lane] = block * lanes + lane < binding.points ? T(1) : T(0);
        return has_point;
    }

    template <WeightFormat Format, class Load>
    void add_dense(const PackedBindingView<T, D>& binding, std::size_t begin, std::size_t end,
                   const Load& load) noexcept {
        const std::size_t stride = binding.handles * row_bytes<Format>;
        const auto sums_of = [this](std::size_t row) { return lanes_[row]; };
        const auto add = [&](auto count, auto last, std::size_t block) {
            Lanes<T> gradients[count][D];
            for (std::size_t n = 0; n < count; ++n) load(block + n, gradients[n]);
            const BlockRows rows{binding.weights + block * stride + first_ * row_bytes<Format>, stride,
                                 count_};
            add_transposed<count, last, Format, T, D>(rows, gradients, points_of(binding, block), sums_of);
        };
        // The order of additions in a lane does not depend on the number of blocks read together.
        constexpr std::size_t together = blocks_together<D>;
        const std::size_t full = binding.points / lanes;
        std::size_t b = begin;
        const auto add_all = [&](auto count) {
            for (; b + count <= (end < full ? end : full); b += count) add(count, std::false_type{}, b);
        };
        add_all(std::integral_constant<std::size_t, together>{});
        if constexpr (together > 3) add_all(std::integral_constant<std::size_t, together / 2>{});
        for (; b < end; ++b) {
            if (b < full) {
                add(std::integral_constant<std::size_t, 1>{}, std::false_type{}, b);
            } else {
                add(std::integral_constant<std::size_t, 1>{}, std::true_type{}, b);
            }
        }
    }

    template <WeightFormat Format, class Load>
    void add_sparse(const PackedBindingView<T, D>& binding, std::size_t begin, std::size_t end,
                    const Load& load) noexcept {
        const std::size_t full = binding.points / lanes;
        for (std::size_t b = begin; b < end; ++b) {
            const std::uint16_t* const handles = binding.row_handle;
            std::size_t from = binding.row_begin[b], to = binding.row_begin[b + 1];
            from = first_row(handles, from, to, first_);
            to = first_row(handles, from, to, first_ + count_);
            if (from == to) continue;
            Lanes<T> gradients[1][D];
            load(b, gradients[0]);
            const auto sums_of = [&](std::size_t row) { return lanes_[handles[from + row] - first_]; };
            const BlockRows rows{binding.weights + from * row_bytes<Format>, 0, to - from};
            const auto add = [&](auto last) {
                add_transposed<1, last, Format, T, D>(rows, gradients, points_of(binding, b), sums_of);
            };
            if (b < full) {
                add(std::false_type{});
            } else {
                add(std::true_type{});
            }
        }
    }

    /// Returns the first of the ascending rows [from, to) whose handle is not below `handle`.
    static std::size_t first_row(const std::uint16_t* handles, std::size_t from, std::size_t to,
                                 std::size_t handle) noexcept {
        if (from == to || handles[from] >= handle) return from;
        if (handles[to - 1] < handle) return to;
        std::size_t left = to - from;
        while (left > 1) { // branch-free, because branches would be mispredicted
            const std::size_t half = left / 2;
            from += half * std::size_t(handles[from + half - 1] < handle);
            left -= half;
        }
        return from + std::size_t(handles[from] < handle);
    }

    Lanes<T> lanes_[Capacity][D];
    Vec<double, D> totals_[Capacity];
    std::size_t first_ = 0, count_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
