// Transposed clones: the gradients of handles from the gradients of points.
//
//     g_i = Σ_blocks s_b Σ_p q_ip m_p g_p + Σ_r F_ir a'_r,   a'_r = Σ_p e_pr m_p g_p
//
// for handle i and points p: stored weights q, scales s, residuals e, affine fit F, mask m. Each thread
// processes a range of handles over all blocks in order. Threads thus need no memory and do not affect the
// result.
#pragma once

#include <cageform/clone/detail/handle_sums.hpp>
#include <cageform/clone/detail/point_rows.hpp>
#include <cageform/core/status.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Checks the arguments of a transposed clone.
template <class View, class Gradients, class Out>
Status check_transposed(const View& binding, const Gradients& gradients, const Out& out,
                        const StridedPoints<const typename View::scalar, 1>& mask = {nullptr, 0}) noexcept {
    if (std::size(out) < binding.handle_count()) return Status::output_too_small;
    if (std::size(gradients) < binding.point_count()) return Status::too_few_gradients;
    if (mask.size() != 0 && mask.size() < binding.point_count()) return Status::mask_too_small;
    return Status::ok;
}

/// The caller's gradients of points, for each of N bindings.
template <Scalar T, std::size_t D, class Source, std::size_t N = 1>
struct GivenGradients {
    static constexpr std::size_t bindings = N;
    static constexpr std::size_t blocks_at_once = blocks_in_lanes;
    static constexpr std::size_t bytes_of_sums = 32768; ///< on the stack

    std::array<PointRows<T, D, Source>, N> rows;

    const GivenGradients& reader() const noexcept { return *this; }
    void load(std::size_t n, std::size_t block, Lanes<T>* to) const noexcept { rows[n].load(block, to); }
};

/// A transposed clone by N bindings with the same points and handles, whose sums are added. `Gradients` has
/// the number N (`bindings`). Each thread reads gradients by its own `gradients.reader()`: load(n, block,
/// rows) is called for `blocks_at_once` blocks of one binding, then for the same blocks of the next.
template <class View, class Gradients>
class TransposedClone {
public:
    using T = typename View::scalar;
    static constexpr std::size_t D = View::dimension, N = Gradients::bindings;

    /// Sums up the gradients for the bindings' residuals. Refers to `gradients`.
    TransposedClone(const std::array<View, N>& bindings, const Gradients& gradients) noexcept
        : gradients_(gradients) {
        bool exact = true;
        for (std::size_t n = 0; n < N; ++n) {
            bindings_[n] = bindings[n];
            exact = exact && bindings_[n].residual == nullptr;
            const std::size_t times = blocks_with_a_row(bindings_[n]);
            blocks_between_ = n == 0 || times * blocks_in_lanes < blocks_between_ ? times * blocks_in_lanes
                                                                                  : blocks_between_;
        }
        if (!exact) sum_residuals();
    }

    /// Returns the least number of handles per thread: with as many rows as `clone_grain` blocks, and at
    /// least 16, so that the gradients are not read for too few handles.
    std::size_t grain() const noexcept {
        const std::size_t blocks = bindings_[0].block_count(), rows = clone_grain * bindings_[0].handles;
        const std::size_t handles = blocks == 0 ? rows : rows / blocks;
        return handles < 16 ? 16 : handles;
    }

    /// Writes the gradients of handles [begin, end).
    template <class Out>
    void run(Out& out, CloneMode mode, std::size_t begin, std::size_t end) const noexcept;

private:
    static constexpr std::size_t handles_at_once = Gradients::bytes_of_sums / (D * sizeof(Lanes<T>));
    using Packed = PackedBindingView<T, D>;

    /// Returns the average number of blocks per row of a handle, at most 8.
    static std::size_t blocks_with_a_row(const Packed& binding) noexcept {
        const std::size_t rows = binding.row_count(), all = binding.block_count() * binding.handles;
        return rows == 0 || all / 8 > rows ? 8 : all / rows;
    }

    /// Calls body(reader, n, from, to) for all blocks and bindings; clear() before and finish() after every
    /// `blocks_between_` blocks.
    template <class Clear, class Body, class Finish>
    void for_blocks(const Clear& clear, const Body& body, const Finish& finish) const noexcept {
        auto&& reader = gradients_.reader();
        const std::size_t blocks = bindings_[0].block_count();
        for (std::size_t b = 0; b < blocks;) {
            const std::size_t end = blocks - b < blocks_between_ ? blocks : b + blocks_between_;
            clear();
            for (; b < end; b += Gradients::blocks_at_once) {
                const std::size_t to =
                    end - b < Gradients::blocks_at_once ? end : b + Gradients::blocks_at_once;
                for (std::size_t n = 0; n < N; ++n) body(reader, n, b, to);
            }
            b = end;
            finish();
        }
    }

    template <class Reader>
    void add(HandleSums<T, D, handles_at_once>& sums, Reader& reader, std::size_t n, std::size_t begin,
             std::size_t end) const noexcept {
        const Packed& binding = bindings_[n];
        const auto load = [&](std::size_t block, Lanes<T>* rows) {
            reader.load(n, block, rows);
            if (binding.scale == nullptr) return;
            const Simd<T> scale(binding.scale[block]);
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) (scale * Simd<T>::load(rows[k])).store(rows[k]);
        };
        if constexpr (std::is_same_v<View, BindingView<T, D>>) {
            sums.template add<WeightFormat::scalar>(binding, begin, end, load);
        } else {
            with_format(binding.format,
                        [&]<WeightFormat Format>() { sums.template add<Format>(binding, begin, end, load); });
        }
    }

    /// Treats the residuals as rows of a binding with D + 1 handles.
    void sum_residuals() noexcept {
        HandleSums<T, D, D + 1> sums[N];
        for (auto& s : sums) s.start(0, D + 1);
        for_blocks(
            [&] {
                for (auto& s : sums) s.clear_lanes();
            },
            [&](auto& reader, std::size_t n, std::size_t from, std::size_t to) {
                if (bindings_[n].residual == nullptr) return;
                Packed rows;
                rows.handles = D + 1;
                rows.points = bindings_[n].points;
                rows.weights = reinterpret_cast<const std::byte*>(bindings_[n].residual);
                sums[n].template add<WeightFormat::scalar>(
                    rows, from, to,
                    [&](std::size_t block, Lanes<T>* gradients) { reader.load(n, block, gradients); });
            },
            [&] {
                for (auto& s : sums) s.add_lanes_to_totals();
            });
        for (std::size_t n = 0; n < N; ++n) {
            for (std::size_t r = 0; r <= D; ++r) affine_[n][r] = sums[n].total(r);
        }
    }

    template <class Out>
    void write(Out& out, CloneMode mode, std::size_t handle, Vec<double, D> sum) const noexcept {
        for (std::size_t n = 0; n < N; ++n) {
            if (bindings_[n].affine_fit == nullptr) continue;
            for (std::size_t r = 0; r <= D; ++r) {
                for (std::size_t k = 0; k < D; ++k)
                    sum[k] = multiply_add<double>(double(bindings_[n].affine_fit[handle][r]),
                                                  affine_[n][r][k], sum[k]);
            }
        }
        if (mode == CloneMode::add) sum = to_vec<double>(out[handle]) + sum;
        store_point(out, handle, sum);
    }

    std::array<Packed, N> bindings_;
    const Gradients& gradients_;
    std::size_t blocks_between_ = blocks_in_lanes; ///< number of blocks until sums move to double
    Vec<double, D> affine_[N][D + 1]{};            ///< a'_r by binding
};

// Not inline, see BlockCloner::run.
template <class View, class Gradients>
template <class Out>
void TransposedClone<View, Gradients>::run(Out& out, CloneMode mode, std::size_t begin,
                                           std::size_t end) const noexcept {
    HandleSums<T, D, handles_at_once> sums;
    const std::size_t parts = (end - begin + handles_at_once - 1) / handles_at_once;
    for (std::size_t part = 0; part < parts; ++part) {
        const std::size_t first = begin + (end - begin) * part / parts,
                          last = begin + (end - begin) * (part + 1) / parts;
        sums.start(first, last - first);
        for_blocks([&] { sums.clear_lanes(); },
                   [&](auto& reader, std::size_t n, std::size_t from, std::size_t to) {
                       add(sums, reader, n, from, to);
                   },
                   [&] { sums.add_lanes_to_totals(); });
        for (std::size_t h = first; h < last; ++h) write(out, mode, h, sums.total(h));
    }
}

/// The transposed clone of strided gradients.
template <class View>
using StridedTransposed =
    TransposedClone<View, GivenGradients<typename View::scalar, View::dimension,
                                         StridedPoints<const typename View::scalar, View::dimension>>>;

#if defined(CAGEFORM_COMPILED) // optimised in the library, even if the program is not
#define CAGEFORM_DETAIL_TRANSPOSED(T, D)                                                                     \
    extern template void StridedTransposed<BindingView<T, D>>::run(StridedPoints<T, D>&, CloneMode,          \
                                                                   std::size_t, std::size_t) const noexcept; \
    extern template void StridedTransposed<PackedBindingView<T, D>>::run(                                    \
        StridedPoints<T, D>&, CloneMode, std::size_t, std::size_t) const noexcept;
CAGEFORM_DETAIL_TRANSPOSED(float, 2)
CAGEFORM_DETAIL_TRANSPOSED(float, 3)
CAGEFORM_DETAIL_TRANSPOSED(double, 2)
CAGEFORM_DETAIL_TRANSPOSED(double, 3)
#undef CAGEFORM_DETAIL_TRANSPOSED
#endif

/// Runs a transposed clone on the caller's threads.
template <class View, class Gradients, class Out, class Parallel>
void transpose(const std::array<View, Gradients::bindings>& bindings, const Gradients& gradients,
               Out& handle_gradients, CloneMode mode, const Parallel& parallel_for) noexcept {
    auto&& out = as_strided<typename View::scalar, View::dimension>(handle_gradients);
    const TransposedClone<View, Gradients> clone(bindings, gradients);
    parallel_for(bindings[0].handle_count(), clone.grain(),
                 [&](std::size_t begin, std::size_t end) { clone.run(out, mode, begin, end); });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
