// Packs a clip into a block of bytes, with 16-bit coefficients where a tolerance allows. Bind time.
#pragma once

#include <cageform/animate/detail/clip_packer.hpp>
#include <cageform/animate/types/clip_pack_options.hpp>
#include <cageform/clip/clip_blob.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Packs a clip for `open_clip` and for `pack` (FigurePackOptions::clips). With a tolerance, it quantises a
/// curve to 16-bit coefficients if its vertex stays within the tolerance, measured with the coefficients as
/// stored. Slopes and rises for extrapolation, jumps and the rigid motion stay exact.
///
///   returns  the packed clip and its report; fails with value_not_finite, also if a number of the
///            clip is not finite or a rotation is not of length 1; out_of_memory
///   cost     O(#pieces): about 10 ms for 10,000
template <Scalar T, std::size_t D>
Result<PackedClip<T, D>, ClipPackReport> pack_clip(const CageClipView<T, D>& clip,
                                                   const ClipPackOptions& options = {}) {
    Result<PackedClip<T, D>, ClipPackReport> result;
    detail::run_into(result.report, [&] {
        return detail::pack_clip_into<T, D>(clip, options, result.value, result.report);
    });
    return result;
}
template <Scalar T, std::size_t D>
Result<PackedClip<T, D>, ClipPackReport> pack_clip(const CageClip<T, D>& clip,
                                                   const ClipPackOptions& options = {}) {
    return pack_clip(clip.view(), options);
}

} // namespace cageform::inline CAGEFORM_ABI
