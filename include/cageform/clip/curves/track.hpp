// A curve with its extrapolation. For run time.
#pragma once

#include <cageform/clip/curves/piecewise_cubic.hpp>
#include <cageform/clip/types/extrapolation.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A non-owning view of a `Track` or of a track of a packed clip.
template <Scalar T>
struct TrackView {
    PiecewiseCubicView<T> curve;
    Extrapolation before = Extrapolation::constant;
    Extrapolation after = Extrapolation::constant;

    /// Returns the value at a time. The track must have pieces; `cursor` as for PiecewiseCubicView.
    T operator()(T x, std::size_t& cursor) const noexcept {
        const auto folded = fold_time(x, curve.begin(), curve.end, before, after);
        const T value = curve(folded.time, cursor);
        if (folded.cycles == 0 && folded.beyond == 0) return value;
        const auto &first = curve.pieces.front(), &last = curve.pieces.back();
        const T slope = folded.beyond < 0 ? first.derivative(curve.begin()) : last.derivative(curve.end);
        return folded.extend(value, slope, curve.end_value - first.c0);
    }
    T operator()(T x) const noexcept {
        std::size_t cursor = 0;
        return (*this)(x, cursor);
    }
};

/// A curve with its extrapolation. Made by `compile` (animate/compile.hpp).
template <Scalar T>
struct Track {
    PiecewiseCubic<T> curve;
    Extrapolation before = Extrapolation::constant;
    Extrapolation after = Extrapolation::constant;

    TrackView<T> view() const noexcept { return {curve.view(), before, after}; }

    /// Returns the value at a time. The track must have pieces; `cursor` as for PiecewiseCubicView.
    T operator()(T x, std::size_t& cursor) const noexcept { return view()(x, cursor); }
    T operator()(T x) const noexcept { return view()(x); }
};

} // namespace cageform::inline CAGEFORM_ABI
