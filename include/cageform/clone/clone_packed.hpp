// The clone operator for packed bindings: sparse, quantised, reordered.
#pragma once

#include <cageform/clone/clone.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

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

template <WeightFormat Format, Scalar T, std::size_t D, class Pose, class Out>
void clone_blocks_of(const PackedBindingView<T, D>& binding, const Pose& pose, Out& out,
                     const CloneOptions<T>& options, std::size_t begin, std::size_t end) noexcept {
    const CloneTarget<T, D, Out> target{binding.rest, binding.order, binding.points, options, out};
    const Displacements<T, D, Pose> displacements(binding.rest_handles, binding.handles, pose);
    displacements.with([&](const auto& displacement) {
        const AffineFit<T, D> fit(binding, displacement);
        const auto finish = [&](std::size_t block, Lanes<T>* sums) {
            fit.complete(binding, block, sums);
            target.write(block, sums);
        };
        if (binding.row_begin == nullptr) {
            sum_dense<Format, T, D>(binding.weights, binding.handles, binding.block_count(), displacement,
                                    begin, end, finish);
            return;
        }
        for (std::size_t b = begin; b < end; ++b) {
            Lanes<T> sums[D];
            const std::size_t first = binding.row_begin[b];
            sum_block<Format, T, D>(
                binding.weights, first, binding.row_begin[b + 1] - first,
                [&, handle = binding.row_handle + first](std::size_t row) -> decltype(auto) {
                    return displacement(handle[row]);
                },
                sums);
            finish(b, sums);
        }
    });
}

template <Scalar T, std::size_t D, class Pose, class Out>
void clone_blocks(const PackedBindingView<T, D>& binding, const Pose& pose, Out& out,
                  const CloneOptions<T>& options, std::size_t begin, std::size_t end) noexcept {
    switch (binding.format) {
    case WeightFormat::scalar:
        return clone_blocks_of<WeightFormat::scalar>(binding, pose, out, options, begin, end);
    case WeightFormat::half:
        return clone_blocks_of<WeightFormat::half>(binding, pose, out, options, begin, end);
    case WeightFormat::int16:
        return clone_blocks_of<WeightFormat::int16>(binding, pose, out, options, begin, end);
    case WeightFormat::int8:
        return clone_blocks_of<WeightFormat::int8>(binding, pose, out, options, begin, end);
    }
}

} // namespace detail

/// `clone` of a packed binding, with the same contract. `out` and the mask are indexed as the points were when bound, whatever
/// their order in the binding. Reads less: what of it, and the errors made, are in the report of `pack`.
template <Scalar T, std::size_t D, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == D &&
             range_dimension<std::remove_reference_t<Out>> == D)
Status clone(const PackedBindingView<T, D>& binding, const Pose& pose, Out&& out,
             const Parallel& parallel_for = {}, const CloneOptions<T>& options = {})
noexcept {
    const Status status = detail::check_clone(binding, pose, out, options);
    if (status != Status::ok) return status;
    parallel_for(binding.block_count(), detail::clone_grain, [&](std::size_t begin, std::size_t end) {
        detail::clone_blocks(binding, pose, out, options, begin, end);
    });
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
