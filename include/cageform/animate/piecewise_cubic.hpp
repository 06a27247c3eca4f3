// Cubics one after the other: what animation curves are at run time. No Eigen, no exceptions, nothing but the standard
// library; evaluation allocates nothing.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/view.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// c0 + u (c1 + u (c2 + u c3)) with u = x − begin: in its own variable, so that a late time costs no digits of the value.
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

/// The last of `count` ascending times begin(0), begin(1), … that is not later than `x`; 0 where all are later. Without branches
/// on x.
template <Scalar T, class Begin>
std::size_t last_up_to(T x, std::size_t count, const Begin& begin) noexcept {
    std::size_t first = 0;
    while (count > 8) {
        const std::size_t half = count / 2;
        first += begin(first + half) <= x ? half : 0;
        count -= half;
    }
    std::size_t found = first; // the last few at once
    for (std::size_t i = 1; i < count; ++i) found += begin(first + i) <= x ? 1 : 0;
    return found;
}

} // namespace detail

/// A function of time made of cubic pieces, in the units of its keys. Six scalars a piece. Before the first piece and after
/// the end the nearest value is held; see `Track` for other ways to go on.
template <Scalar T>
class PiecewiseCubic {
public:
    using scalar = T;

    PiecewiseCubic() = default;
    /// Pieces ascend by `begin`; `end` is that of the last, not before its begin. From there on the value is held.
    PiecewiseCubic(std::vector<CubicPiece<T>> pieces, T end)
        : PiecewiseCubic(std::move(pieces), end, T(0)) {
        if (!pieces_.empty()) end_value_ = pieces_.back()(end_);
    }
    /// With a jump at the end to `end_value`.
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

    bool empty() const noexcept { return pieces_.empty(); }
    std::span<const CubicPiece<T>> pieces() const noexcept { return pieces_; }
    T begin() const noexcept { return pieces_.front().begin; }
    T end() const noexcept { return end_; }
    T end_value() const noexcept { return end_value_; } ///< from there on

    /// The piece at a time, for a curve that is not empty: the last that begins not later. O(log #pieces).
    std::size_t locate(T x) const noexcept {
        return detail::last_up_to(x, pieces_.size(),
                                  [begin = begins_.data()](std::size_t i) { return begin[i]; });
    }
    /// The same where it is likely to be `hint` or the next piece, as in forward play: O(1) then.
    std::size_t locate(T x, std::size_t hint) const noexcept {
        if (hint < pieces_.size() && pieces_[hint].begin <= x) {
            if (hint + 1 == pieces_.size() || x < pieces_[hint + 1].begin) return hint;
            if (hint + 2 == pieces_.size() || x < pieces_[hint + 2].begin) return hint + 1;
        }
        return locate(x);
    }

    T operator()(T x) const noexcept {
        if (x >= end_) return end_value_;
        const T inside = held(x);
        return pieces_[locate(inside)](inside);
    }
    /// `cursor`: what the last call left there, 0 at first.
    T operator()(T x, std::size_t& cursor) const noexcept {
        if (x >= end_) {
            cursor = pieces_.size() - 1;
            return end_value_;
        }
        const T inside = held(x);
        cursor = locate(inside, cursor);
        return pieces_[cursor](inside);
    }
    /// By time; 0 where the value is held. At the end, that of the last piece.
    T derivative(T x) const noexcept {
        return x >= pieces_.front().begin && x <= end_ ? pieces_[locate(x)].derivative(x) : T(0);
    }
    /// Values at many times; fastest where they ascend.
    void sample(std::span<const T> times, std::span<T> out) const noexcept {
        CAGEFORM_ASSERT(out.size() >= times.size(), "a place for every time");
        std::size_t cursor = 0;
        for (std::size_t i = 0; i < times.size(); ++i) out[i] = (*this)(times[i], cursor);
    }

private:
    T held(T x) const noexcept { return x < begins_.front() ? begins_.front() : x; }

    std::vector<CubicPiece<T>> pieces_;
    std::vector<T> begins_; ///< of the pieces, side by side to be searched
    T end_ = 0, end_value_ = 0;
};

/// A curve in 16 bits a coefficient: Bernstein coefficients of every piece as steps between the least and the largest of
/// them. Half the size of float pieces, and less.
///
///   error   at most half a step more than that of the curve, `error_bound()`: the range over 131070
template <Scalar T>
class QuantisedCubic {
public:
    using scalar = T;

    QuantisedCubic() = default;
    explicit QuantisedCubic(const PiecewiseCubic<T>& curve)
        : end_(curve.empty() ? T(0) : curve.end())
        , end_value_(curve.empty() ? T(0) : curve.end_value()) {
        std::vector<double> coefficients;
        const auto pieces = curve.pieces();
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& p = pieces[i];
            const double h = double(i + 1 < pieces.size() ? pieces[i + 1].begin : end_) - double(p.begin);
            const double c1 = double(p.c1) * h, c2 = double(p.c2) * h * h, c3 = double(p.c3) * h * h * h;
            const double b0 = double(p.c0);
            for (const double b : {b0, b0 + c1 / 3, b0 + 2 * c1 / 3 + c2 / 3, b0 + c1 + c2 + c3})
                coefficients.push_back(b);
            pieces_.push_back({p.begin, {}});
        }
        if (coefficients.empty()) return;
        double low = coefficients[0], high = low;
        for (const double b : coefficients) {
            low = b < low ? b : low;
            high = b > high ? b : high;
        }
        low_ = static_cast<T>(low);
        step_ = static_cast<T>((high - low) / 65535);
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
            const double steps = high > low ? (coefficients[i] - low) / (high - low) * 65535 : 0;
            pieces_[i / 4].b[i % 4] = static_cast<std::uint16_t>(std::lround(steps));
        }
    }

    std::size_t size() const noexcept { return pieces_.size(); }
    T error_bound() const noexcept { return step_ / 2; } ///< but for roundings of T
    std::size_t bytes() const noexcept { return pieces_.size() * sizeof(Piece) + 4 * sizeof(T); }

    /// Of a curve that is not empty.
    T operator()(T x) const noexcept {
        if (x >= end_) return end_value_;
        const T inside = x < pieces_.front().begin ? pieces_.front().begin : x;
        const std::size_t first =
            detail::last_up_to(inside, pieces_.size(), [&](std::size_t i) { return pieces_[i].begin; });
        const Piece& p = pieces_[first];
        const T until = first + 1 < pieces_.size() ? pieces_[first + 1].begin : end_;
        const T u = (inside - p.begin) / (until - p.begin), v = 1 - u;
        const T b0 = T(p.b[0]), b1 = T(p.b[1]), b2 = T(p.b[2]), b3 = T(p.b[3]);
        using detail::multiply_add, detail::product;
        const T early = multiply_add(v, b0, product(3 * u, b1)),
                late = multiply_add(u, b3, product(3 * v, b2));
        return multiply_add(step_, multiply_add(v * v, early, product(u * u, late)), low_);
    }

private:
    struct Piece {
        T begin;
        std::uint16_t b[4];
    };
    std::vector<Piece> pieces_;
    T end_ = 0, end_value_ = 0, low_ = 0, step_ = 0;
};

/// Many curves at one time: all coordinates of all vertices of a cage, say. Curves need not have common knots.
///
/// A cursor holds the current piece of every curve in rows of a cache line. The beginnings of all pieces, in the order of
/// time, tell which curves enter another piece between one time and the next, forwards and backwards.
///
///   cost    of play a few operations and five loads a value, whole vector registers at a time, and a few nanoseconds for
///           each curve that enters another piece; of a jump, a search among the pieces of each curve
///   memory  five scalars, two indices and a time a piece; a cursor, five scalars a curve
template <Scalar T>
class CurveBank {
public:
    using scalar = T;

    CurveBank() = default;
    explicit CurveBank(std::span<const PiecewiseCubic<T>> curves) {
        for (const auto& curve : curves) {
            CAGEFORM_ASSERT(!curve.empty(), "curves with pieces");
            const auto of = std::uint32_t(first_.size());
            first_.push_back(std::uint32_t(pieces_.size()));
            const auto constant = [](T value) { return CubicPiece<T>{T(0), value, T(0), T(0), T(0)}; };
            pieces_.push_back(constant(curve.pieces().front().c0));
            for (const auto& piece : curve.pieces()) {
                entries_.push_back({piece.begin, std::uint32_t(pieces_.size()), of});
                pieces_.push_back(piece);
            }
            // At the end itself still in the last piece, for its slope, unless the value jumps there.
            const bool jumps = curve.end_value() != curve.pieces().back()(curve.end());
            ends_.push_back(jumps ? curve.end()
                                  : std::nextafter(curve.end(), (std::numeric_limits<T>::max)()));
            entries_.push_back({ends_.back(), std::uint32_t(pieces_.size()), of});
            pieces_.push_back(constant(curve.end_value()));
        }
        sort(entries_);
    }

    std::size_t size() const noexcept { return first_.size(); } ///< curves
    std::size_t bytes() const noexcept {
        return pieces_.size() * sizeof(CubicPiece<T>) + entries_.size() * sizeof(Entry) +
               first_.size() * (sizeof(std::uint32_t) + sizeof(T));
    }

    /// The pieces of all curves at the time last asked for. One for every place that plays a bank; made once, used every frame.
    class Cursor {
    public:
        Cursor() = default;

    private:
        friend class CurveBank;
        struct Block {
            Lanes<T> begin, c0, c1, c2, c3;
        };
        std::vector<Block> blocks_;
        std::size_t entered_ = 0; ///< entries up to the time
    };
    Cursor make_cursor() const {
        Cursor cursor;
        cursor.blocks_.resize(block_count<T>(size()));
        for (auto& block : cursor.blocks_) {
            for (std::size_t lane = 0; lane < lane_count<T>; ++lane) // beyond the last curve there is zero
                block.begin[lane] = block.c0[lane] = block.c1[lane] = block.c2[lane] = block.c3[lane] = T(0);
        }
        for (std::size_t k = 0; k < size(); ++k) load(cursor, k, first_[k]);
        return cursor;
    }

    /// The values of all curves at a finite time, into `out` (#curves), and their derivatives by time where `slopes` is not
    /// empty. Outside a curve its nearest value is held. O(#curves), wherever the cursor was.
    void sample(T x, Cursor& cursor, std::span<T> out, std::span<T> slopes = {}) const noexcept {
        CAGEFORM_ASSERT(out.size() >= size() && (slopes.empty() || slopes.size() >= size()),
                        "a place for every curve");
        CAGEFORM_ASSERT(cursor.blocks_.size() == block_count<T>(size()), "a cursor of this bank");
        move_to(x, cursor);
        constexpr std::size_t lanes = lane_count<T>;
        for (std::size_t b = 0; b < cursor.blocks_.size(); ++b) {
            const auto& block = cursor.blocks_[b];
            const std::size_t first = b * lanes, count = size() - first < lanes ? size() - first : lanes;
            using detail::multiply_add;
            Lanes<T> value;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const T u = x - block.begin[lane];
                const T part =
                    multiply_add(multiply_add(block.c3[lane], u, block.c2[lane]), u, block.c1[lane]);
                value[lane] = multiply_add(part, u, block.c0[lane]);
            }
            store(value, count, out.data() + first);
            if (slopes.empty()) continue;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const T u = x - block.begin[lane];
                value[lane] =
                    multiply_add(multiply_add(3 * block.c3[lane], u, 2 * block.c2[lane]), u, block.c1[lane]);
            }
            store(value, count, slopes.data() + first);
        }
    }

private:
    /// A curve enters a piece. Before its first and after its last there is a constant one.
    struct Entry {
        T time;
        std::uint32_t piece, curve;
    };

    static void store(const Lanes<T>& value, std::size_t count, T* out) noexcept {
        if (count == lane_count<T>) {
            for (std::size_t lane = 0; lane < lane_count<T>; ++lane) out[lane] = value[lane];
        } else {
            for (std::size_t lane = 0; lane < count; ++lane) out[lane] = value[lane];
        }
    }
    /// By time; a heap's, since run time leaves out <algorithm>.
    static void sort(std::vector<Entry>& entries) noexcept {
        const std::size_t count = entries.size();
        const auto before = [](const Entry& a, const Entry& b) {
            return a.time != b.time ? a.time < b.time : a.piece < b.piece;
        };
        const auto sink = [&](std::size_t i, std::size_t end) {
            const Entry moved = entries[i];
            for (std::size_t child = 2 * i + 1; child < end; child = 2 * i + 1) {
                if (child + 1 < end && before(entries[child], entries[child + 1])) ++child;
                if (!before(moved, entries[child])) break;
                entries[i] = entries[child];
                i = child;
            }
            entries[i] = moved;
        };
        for (std::size_t i = count / 2; i-- > 0;) sink(i, count);
        for (std::size_t end = count; end-- > 1;) {
            std::swap(entries[0], entries[end]);
            sink(0, end);
        }
    }

    void load(Cursor& cursor, std::size_t curve, std::size_t piece) const noexcept {
        auto& block = cursor.blocks_[curve / lane_count<T>];
        const std::size_t lane = curve % lane_count<T>;
        const CubicPiece<T>& p = pieces_[piece];
        block.begin[lane] = p.begin;
        block.c0[lane] = p.c0;
        block.c1[lane] = p.c1;
        block.c2[lane] = p.c2;
        block.c3[lane] = p.c3;
    }

    void move_to(T x, Cursor& cursor) const noexcept {
        std::size_t e = cursor.entered_;
        const bool forth = e < entries_.size() && entries_[e].time <= x;
        if (!forth && (e == 0 || entries_[e - 1].time <= x)) return;
        std::size_t goal = 0, left = entries_.size(); // entries up to x
        while (left > 0) {
            const std::size_t half = left / 2;
            const bool up_to = entries_[goal + half].time <= x;
            goal += up_to ? half + 1 : 0;
            left = up_to ? left - half - 1 : half;
        }
        cursor.entered_ = goal;
        const std::size_t steps = forth ? goal - e : e - goal;
        if (steps <= 4 * size()) {
            if (forth) {
                for (; e < goal; ++e) load(cursor, entries_[e].curve, entries_[e].piece);
            } else {
                for (; e > goal; --e) load(cursor, entries_[e - 1].curve, entries_[e - 1].piece - 1);
            }
            return;
        }
        for (std::size_t k = 0; k < size(); ++k) {
            const std::size_t first = first_[k], last = (k + 1 < size() ? first_[k + 1] : pieces_.size()) - 1;
            // Among the pieces between the constant ones, the last that begins up to x; a constant one outside.
            std::size_t found = first + 1 + detail::last_up_to(x, last - first - 1, [&](std::size_t i) {
                                    return pieces_[first + 1 + i].begin;
                                });
            if (x < pieces_[first + 1].begin) found = first;
            if (x >= ends_[k]) found = last;
            load(cursor, k, found);
        }
    }

    std::vector<CubicPiece<T>> pieces_; ///< of all curves, each between two constants
    std::vector<std::uint32_t> first_;  ///< of every curve
    std::vector<T> ends_;               ///< of every curve: from where its value is held
    std::vector<Entry> entries_;        ///< by time
};

/// How a curve goes on beyond its keys.
enum class Extrapolation : std::uint8_t {
    constant,          ///< the nearest value
    linear,            ///< on at the slope there
    cycle,             ///< from the beginning
    cycle_with_offset, ///< from the beginning, but where it ended
    ping_pong,         ///< back and forth
};

/// A time taken into the range of a curve by its extrapolation.
template <Scalar T>
struct FoldedTime {
    T time = 0;   ///< in the range
    T turns = 0;  ///< of cycle_with_offset: how often the curve has been gone through before
    T beyond = 0; ///< of linear: how far beyond the range
};

/// O(1).
template <Scalar T>
FoldedTime<T> fold_time(T x, T begin, T end, Extrapolation before, Extrapolation after) noexcept {
    if (x >= begin && x <= end) return {x, 0, 0};
    const bool early = x < begin;
    const auto mode = early ? before : after;
    const T edge = early ? begin : end, length = end - begin;
    if (mode == Extrapolation::constant || !(length > 0) || !is_finite(x)) return {edge, 0, 0};
    if (mode == Extrapolation::linear) return {edge, 0, x - edge};
    const double turns = std::floor((double(x) - double(begin)) / double(length));
    double part = detail::multiply_add(-turns, double(length), double(x) - double(begin));
    part = part < 0 ? 0 : part > double(length) ? double(length) : part;
    if (mode == Extrapolation::ping_pong && turns - 2 * std::floor(turns / 2) == 1)
        part = double(length) - part;
    return {static_cast<T>(double(begin) + part),
            mode == Extrapolation::cycle_with_offset ? static_cast<T>(turns) : T(0), 0};
}

/// A curve and how it goes on. Made by `compile_track` (animate/track.hpp).
template <Scalar T>
struct Track {
    PiecewiseCubic<T> curve;
    Extrapolation before = Extrapolation::constant;
    Extrapolation after = Extrapolation::constant;

    /// Of a track with pieces.
    T operator()(T x, std::size_t& cursor) const noexcept {
        const auto folded = fold_time(x, curve.begin(), curve.end(), before, after);
        T value = curve(folded.time, cursor);
        using detail::multiply_add;
        if (folded.beyond < 0)
            value = multiply_add(folded.beyond, curve.pieces().front().derivative(curve.begin()), value);
        if (folded.beyond > 0)
            value = multiply_add(folded.beyond, curve.pieces().back().derivative(curve.end()), value);
        if (folded.turns != 0)
            value = multiply_add(folded.turns, curve.end_value() - curve.pieces().front().c0, value);
        return value;
    }
    T operator()(T x) const noexcept {
        std::size_t cursor = 0;
        return (*this)(x, cursor);
    }
};

} // namespace cageform::inline CAGEFORM_ABI
