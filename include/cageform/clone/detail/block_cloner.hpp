// Clones blocks: computes weighted sums of displacements and passes them to a target.
#pragma once

#include <cageform/clone/detail/row_sums.hpp>
#include <cageform/clone/detail/target.hpp>
#include <cageform/figure/packed_binding.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The best affine fit to displacements of `K` numbers: a_r = Σ_i F_ir d_i.
template <Scalar T, std::size_t D, std::size_t K = D>
struct AffineFit {
    Vec<T, K> rows[D + 1]{};

    template <class Displacement>
    AffineFit(const PackedBindingView<T, D>& binding, const Displacement& displacement) noexcept {
        if (binding.affine_fit == nullptr) return;
        for (std::size_t i = 0; i < binding.handles; ++i) {
            const auto& d = displacement(i);
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t r = 0; r <= D; ++r) {
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k < K; ++k)
                    rows[r][k] = multiply_add<T>(binding.affine_fit[i][r], d[k], rows[r][k]);
            }
        }
    }

    /// Completes the sums Σ q d of a block to s Σ q d + Σ e a, with its scale s and its residuals e.
    void complete(const PackedBindingView<T, D>& binding, std::size_t block, Lanes<T>* sums) const noexcept {
        if (binding.scale == nullptr) return;
        const Lanes<T>* const residual = binding.residual + block * (D + 1);
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < K; ++k) {
            Simd<T> sum = Simd<T>(binding.scale[block]) * Simd<T>::load(sums[k]);
            // Not unrolled, because GCC would then fuse another product with its sum.
            for (std::size_t r = 0; r <= D; ++r)
                sum = multiply_add<T>(Simd<T>::load(residual[r]), Simd<T>(rows[r][k]), sum);
            sum.store(sums[k]);
        }
    }
};

inline constexpr std::size_t clone_grain = 256; ///< blocks per thread, at least

/// Sums the rows of blocks and passes the completed sums to a target, with Target::columns numbers a point.
template <Scalar T, std::size_t D, class Target>
class BlockAccumulator {
public:
    BlockAccumulator(const PackedBindingView<T, D>& binding, const Target& target) noexcept
        : binding_(binding)
        , target_(target) {}

    /// Writes blocks [begin, end). `View` is the type of the caller's binding. A BindingView has one format
    /// and no pruned rows.
    template <class View, class Source>
    void write(const Source& source, std::size_t begin, std::size_t end) const noexcept {
        const Displacements<Source> displacements(source, binding_.handles);
        displacements.with([&](const auto& displacement) {
            const Fit fit(binding_, displacement);
            if constexpr (std::is_same_v<View, BindingView<T, D>>) {
                add_dense<WeightFormat::scalar>(displacement, fit, begin, end);
            } else {
                with_format(binding_.format,
                            [&]<WeightFormat Format>() { add<Format>(displacement, fit, begin, end); });
            }
        });
    }

private:
    static constexpr std::size_t K = Target::columns;
    using Fit = AffineFit<T, D, K>;

    /// Adds blocks with all or some rows.
    template <WeightFormat Format, class Displacement>
    void add(const Displacement& displacement, const Fit& fit, std::size_t begin,
             std::size_t end) const noexcept {
        if (binding_.row_begin == nullptr) return add_dense<Format>(displacement, fit, begin, end);
        using Rows = RowSums<Format, T, K>;
        for (std::size_t b = begin; b < end; ++b) {
            Lanes<T> sums[K];
            const std::size_t first = binding_.row_begin[b];
            const DisplacementsOfRows<Displacement> of_rows{displacement, binding_.row_handle + first};
            Rows::template of_block<WeightsIn::caches>(binding_.weights + first * Rows::row_bytes,
                                                       binding_.row_begin[b + 1] - first, of_rows, sums);
            finish(fit, b, sums);
        }
    }

    /// Adds blocks with a row for every handle.
    template <WeightFormat Format, class Displacement>
    void add_dense(const Displacement& displacement, const Fit& fit, std::size_t begin,
                   std::size_t end) const noexcept {
        // For cached weights, blocks are processed together, which saves loads and a third of the time. From
        // memory the time would grow by a third, because prefetching works better for a single stream.
        constexpr std::size_t cached = std::size_t{16} << 20;
        constexpr std::size_t together = blocks_together<K>;
        using Rows = RowSums<Format, T, K>;
        const std::size_t handles = binding_.handles, block_bytes = handles * Rows::row_bytes;
        std::size_t b = begin;
        if (binding_.block_count() * block_bytes < cached) {
            // The last blocks are processed singly in the same order of additions, so any range gives the
            // same bits.
            const auto sum = [&](auto count, std::size_t block) {
                Lanes<T> sums[count][K];
                Rows::template of_blocks<count>(binding_.weights + block * block_bytes, handles, displacement,
                                                sums);
                for (std::size_t n = 0; n < count; ++n) finish(fit, block + n, sums[n]);
            };
            for (; b + together <= end; b += together)
                sum(std::integral_constant<std::size_t, together>{}, b);
            for (; b < end; ++b) sum(std::integral_constant<std::size_t, 1>{}, b);
            return;
        }
        for (; b < end; ++b) {
            Lanes<T> sums[K];
            Rows::template of_block<WeightsIn::memory>(binding_.weights + b * block_bytes, handles,
                                                       displacement, sums);
            finish(fit, b, sums);
        }
    }

    void finish(const Fit& fit, std::size_t block, Lanes<T>* sums) const noexcept {
        fit.complete(binding_, block, sums);
        target_.write(block, sums);
    }

    PackedBindingView<T, D> binding_;
    Target target_;
};

/// One clone of `View` by `pose` into `out`.
template <class View, class Pose, class Out>
class BlockCloner {
public:
    using T = typename View::scalar;
    static constexpr std::size_t D = View::dimension;

    /// Refers to its arguments, except to the view.
    BlockCloner(const View& binding, const Pose& pose, Out& out, const CloneOptions<T>& options) noexcept
        : blocks_(binding, {binding, options, out})
        , displacements_{binding.rest_handles, pose} {}

    /// Writes the points of blocks [begin, end).
    void run(std::size_t begin, std::size_t end) const noexcept;

private:
    BlockAccumulator<T, D, CloneTarget<T, D, Out>> blocks_;
    PoseDisplacements<T, D, Pose> displacements_;
};

// Defined outside the class, so not inline: compilers instantiate inline functions in spite of the `extern
// template` declarations below.
template <class View, class Pose, class Out>
void BlockCloner<View, Pose, Out>::run(std::size_t begin, std::size_t end) const noexcept {
    blocks_.template write<View>(displacements_, begin, end);
}

/// The cloner of poses and outputs with strided numbers.
template <class View>
using StridedCloner = BlockCloner<View, StridedPoints<const typename View::scalar, View::dimension>,
                                  StridedPoints<typename View::scalar, View::dimension>>;

#if defined(CAGEFORM_COMPILED) // optimised in the library, even if the program is not
// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define CAGEFORM_DETAIL_CLONER(T, D)                                                                         \
    extern template void StridedCloner<BindingView<T, D>>::run(std::size_t, std::size_t) const noexcept;     \
    extern template void StridedCloner<PackedBindingView<T, D>>::run(std::size_t, std::size_t) const noexcept;
// NOLINTEND(bugprone-macro-parentheses)
CAGEFORM_DETAIL_CLONER(float, 2)
CAGEFORM_DETAIL_CLONER(float, 3)
CAGEFORM_DETAIL_CLONER(double, 2)
CAGEFORM_DETAIL_CLONER(double, 3)
#undef CAGEFORM_DETAIL_CLONER
#endif

} // namespace cageform::inline CAGEFORM_ABI::detail
