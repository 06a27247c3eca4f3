// A piecewise cubic function of time: an animation curve at run time. Evaluation neither throws nor
// allocates.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/view.hpp>

#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The cubic c0 + u (c1 + u (c2 + u c3)) with u = x − begin. Relative times keep late pieces accurate.
template <Scalar T>
struct CubicPiece {
    T begin, c0, c1, c2, c3;

    T operator()(T x) const noexcept {
        const T u = x - begin;
        return detail::multiply_add(detail::multiply_add(detail::multiply_add(c3, u, c2), u, c1), u, c0);
    }
    T derivative(T x) const noexcept {
        const T u = x - begin;
        return detail::multiply_add(detail::multiply_add(3 * c3, u, 2 * c2), u, c1);
    }
};

namespace detail {

/// Branchless binary search: returns the index of the last of `count` ascending times begin(0),
/// begin(1), … that is not later than `x`; 0 if all are later.
template <Scalar T, class Begin>
std::size_t last_up_to(T x, std::size_t count, const Begin& begin) noexcept {
    std::size_t first = 0;
    while (count > 8) {
        const std::size_t half = count / 2;
        first += begin(first + half) <= x ? half : 0;
        count -= half;
    }
    std::size_t found = first; // linear search among the last times
    for (std::size_t i = 1; i < count; ++i) found += begin(first + i) <= x ? 1 : 0;
    return found;
}

} // namespace detail

/// A non-owning view of a `PiecewiseCubic` or of a piecewise cubic of a packed clip.
template <Scalar T>
struct PiecewiseCubicView {
    using scalar = T;

    std::span<const CubicPiece<T>> pieces;
    const T* begins = nullptr; ///< the begins of the pieces, contiguous for the search
    T end = 0, end_value = 0;

    bool empty() const noexcept { return pieces.empty(); }
    T begin() const noexcept { return pieces.front().begin; }

    /// Returns the index of the last piece that begins at or before a time, or 0. The curve must not be
    /// empty. O(log #pieces).
    std::size_t locate(T x) const noexcept {
        return detail::last_up_to(x, pieces.size(), [begin = begins](std::size_t i) { return begin[i]; });
    }
    /// As above; O(1) if the piece is `hint` or the next one, as in forward play.
    std::size_t locate(T x, std::size_t hint) const noexcept {
        if (hint < pieces.size() && pieces[hint].begin <= x) {
            if (hint + 1 == pieces.size() || x < pieces[hint + 1].begin) return hint;
            if (hint + 2 == pieces.size() || x < pieces[hint + 2].begin) return hint + 1;
        }
        return locate(x);
    }

    T operator()(T x) const noexcept {
        if (x >= end) return end_value;
        const T inside = clamped(x);
        return pieces[locate(inside)](inside);
    }
    /// `cursor` is the index of the piece of the last call, initially 0.
    T operator()(T x, std::size_t& cursor) const noexcept {
        if (x >= end) {
            cursor = pieces.size() - 1;
            return end_value;
        }
        const T inside = clamped(x);
        cursor = locate(inside, cursor);
        return pieces[cursor](inside);
    }
    /// Returns the derivative by time; 0 outside the range. At the end: the derivative of the last piece.
    T derivative(T x) const noexcept {
        return x >= pieces.front().begin && x <= end ? pieces[locate(x)].derivative(x) : T(0);
    }

private:
    T clamped(T x) const noexcept { return x < begins[0] ? begins[0] : x; }
};

/// Consecutive cubic pieces in the units of their keys; six scalars per piece. Outside its range, a
/// curve has its nearest value; `Track` (clip/curves/track.hpp) extrapolates.
template <Scalar T>
class PiecewiseCubic {
public:
    using scalar = T;

    PiecewiseCubic() = default;
    /// Pieces ascend by `begin`. `end` is the end of the last piece, not before its begin; from there
    /// the value is constant.
    PiecewiseCubic(std::vector<CubicPiece<T>> pieces, T end)
        : PiecewiseCubic(std::move(pieces), end, T(0)) {
        if (!pieces_.empty()) end_value_ = pieces_.back()(end_);
    }
    /// The value jumps to `end_value` at the end.
    PiecewiseCubic(std::vector<CubicPiece<T>> pieces, T end, T end_value)
        : pieces_(std::move(pieces))
        , end_(end)
        , end_value_(end_value) {
        begins_.reserve(pieces_.size());
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            begins_.push_back(pieces_[i].begin);
            CAGEFORM_ASSERT(i + 1 < pieces_.size() ? pieces_[i].begin < pieces_[i + 1].begin
                                                   : pieces_[i].begin <= end_,
                            "pieces ascend");
        }
    }

    PiecewiseCubicView<T> view() const noexcept { return {pieces_, begins_.data(), end_, end_value_}; }

    bool empty() const noexcept { return pieces_.empty(); }
    std::span<const CubicPiece<T>> pieces() const noexcept { return pieces_; }
    T begin() const noexcept { return pieces_.front().begin; }
    T end() const noexcept { return end_; }
    T end_value() const noexcept { return end_value_; } ///< at and after the end

    std::size_t locate(T x) const noexcept { return view().locate(x); }
    std::size_t locate(T x, std::size_t hint) const noexcept { return view().locate(x, hint); }
    T operator()(T x) const noexcept { return view()(x); }
    T operator()(T x, std::size_t& cursor) const noexcept { return view()(x, cursor); }
    T derivative(T x) const noexcept { return view().derivative(x); }
    /// Evaluates at many times; this is fastest if they ascend.
    void sample(std::span<const T> times, std::span<T> out) const noexcept {
        CAGEFORM_ASSERT(out.size() >= times.size(), "an element of out per time");
        std::size_t cursor = 0;
        for (std::size_t i = 0; i < times.size(); ++i) out[i] = (*this)(times[i], cursor);
    }

private:
    std::vector<CubicPiece<T>> pieces_;
    std::vector<T> begins_; ///< the begins of the pieces, contiguous for the search
    T end_ = 0, end_value_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
