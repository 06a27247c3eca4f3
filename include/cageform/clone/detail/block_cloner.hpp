// The blocks of a clone: weighted sums of displacements, added to the points at rest.
#pragma once

#include <cageform/binding/packed_binding.hpp>
#include <cageform/clone/detail/row_sums.hpp>
#include <cageform/clone/detail/target.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The best affine fit to the displacements: a_r = Σ_i F_ir d_i.
template <Scalar T, std::size_t D>
struct AffineFit {
    Vec<T, D> part[D + 1]{};

    template <class Displacement>
    AffineFit(const PackedBindingView<T, D>& binding, const Displacement& displacement) noexcept {
        if (binding.affine_fit == nullptr) return;
        for (std::size_t i = 0; i < binding.handles; ++i) {
            const auto& d = displacement(i);
            for (std::size_t r = 0; r <= D; ++r) {
                for (std::size_t k = 0; k < D; ++k)
                    part[r][k] = multiply_add<T>(binding.affine_fit[i][r], d[k], part[r][k]);
            }
        }
    }

    /// s Σ q d + Σ e a for a block.
    void complete(const PackedBindingView<T, D>& binding, std::size_t block, Lanes<T>* sums) const noexcept {
        if (binding.scale == nullptr) return;
        const Lanes<T>* const residual = binding.residual + block * (D + 1);
        for (std::size_t k = 0; k < D; ++k) {
            Simd<T> sum = Simd<T>(binding.scale[block]) * Simd<T>::load(sums[k]);
            for (std::size_t r = 0; r <= D; ++r)
                sum = multiply_add<T>(Simd<T>::load(residual[r]), Simd<T>(part[r][k]), sum);
            sum.store(sums[k]);
        }
    }
};

inline constexpr std::size_t clone_grain = 256; ///< blocks that are worth a thread

/// One clone: `View` by `pose` into `out`, any of its blocks at a time.
template <class View, class Pose, class Out>
class BlockCloner {
public:
    using T = typename View::scalar;
    static constexpr std::size_t D = View::dimension;

    /// Refers to all its arguments but the view.
    BlockCloner(const View& binding, const Pose& pose, Out& out, const CloneOptions<T>& options) noexcept
        : binding_(binding)
        , pose_(pose)
        , target_{binding_.rest, binding_.order, binding_.points, options, out} {}

    /// Writes the points of blocks [begin, end).
    void run(std::size_t begin, std::size_t end) const noexcept {
        const Displacements<T, D, Pose> displacements(binding_.rest_handles, binding_.handles, pose_);
        displacements.with([&](const auto& displacement) {
            if constexpr (std::is_same_v<View,
                                         BindingView<T, D>>) { // has one format, and rows for all handles
                add_dense<WeightFormat::scalar>(
                    displacement, begin, end,
                    [&](std::size_t block, Lanes<T>* sums) { target_.write(block, sums); });
            } else {
                switch (binding_.format) {
                case WeightFormat::scalar: return add<WeightFormat::scalar>(displacement, begin, end);
                case WeightFormat::half: return add<WeightFormat::half>(displacement, begin, end);
                case WeightFormat::int16: return add<WeightFormat::int16>(displacement, begin, end);
                case WeightFormat::int8: return add<WeightFormat::int8>(displacement, begin, end);
                }
            }
        });
    }

private:
    template <WeightFormat Format>
    static constexpr std::size_t row_bytes = lane_count<T>* weight_bytes<T>(Format);

    template <WeightFormat Format, class Displacement>
    void add(const Displacement& displacement, std::size_t begin, std::size_t end) const noexcept {
        const AffineFit<T, D> fit(binding_, displacement);
        const auto finish = [&](std::size_t block, Lanes<T>* sums) {
            fit.complete(binding_, block, sums);
            target_.write(block, sums);
        };
        if (binding_.row_begin == nullptr) return add_dense<Format>(displacement, begin, end, finish);
        for (std::size_t b = begin; b < end; ++b) {
            Lanes<T> sums[D];
            const std::size_t first = binding_.row_begin[b];
            sum_block<Format, T, D>(
                binding_.weights + first * row_bytes<Format>, binding_.row_begin[b + 1] - first,
                [&, handle = binding_.row_handle + first](std::size_t row) -> decltype(auto) {
                    return displacement(handle[row]);
                },
                sums);
            finish(b, sums);
        }
    }

    /// For blocks that have a row for every handle; finish(block, sums) takes what is summed.
    template <WeightFormat Format, class Displacement, class Finish>
    void add_dense(const Displacement& displacement, std::size_t begin, std::size_t end,
                   const Finish& finish) const noexcept {
        // From caches, blocks beside each other take a third less time, for they save loads; from
        // memory a third more, for one stream is fetched ahead better than several that break off
        // at every block.
        constexpr std::size_t cached = std::size_t{16} << 20;
        constexpr std::size_t together = sums_in_registers<D>;
        const std::size_t handles = binding_.handles, block_bytes = handles * row_bytes<Format>;
        std::size_t b = begin;
        if (binding_.block_count() * block_bytes < cached) {
            // One by one at the end, in the same order of additions: ranges may be cut anywhere.
            const auto sum = [&](auto count, std::size_t block) {
                Lanes<T> sums[count][D];
                sum_rows<count, 1, Format, T, D>(binding_.weights + block * block_bytes, handles, handles,
                                                 displacement, sums);
                for (std::size_t n = 0; n < count; ++n) finish(block + n, sums[n]);
            };
            for (; b + together <= end; b += together)
                sum(std::integral_constant<std::size_t, together>{}, b);
            for (; b < end; ++b) sum(std::integral_constant<std::size_t, 1>{}, b);
            return;
        }
        for (; b < end; ++b) {
            Lanes<T> sums[D];
            sum_block<Format, T, D>(binding_.weights + b * block_bytes, handles, displacement, sums);
            finish(b, sums);
        }
    }

    PackedBindingView<T, D> binding_; ///< a dense binding is a packed one from which nothing was dropped
    const Pose& pose_;
    CloneTarget<T, D, Out> target_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
