// Many piecewise cubics at one time. Run time, as piecewise_cubic.hpp.
#pragma once

#include <cageform/animate/piecewise_cubic.hpp>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// Many curves at one time, as the coordinates of a cage's vertices. They need no common knots.
///
/// A cursor holds the current piece of every curve in rows of a cache line. The beginnings of all
/// pieces in the order of time tell which curves enter another piece between two times, forwards
/// and backwards.
///
///   cost    of play, a few operations and five loads a value, whole vector registers at a time,
///           and a few nanoseconds for each curve that enters another piece; of a jump, a search
///           among the pieces of each curve
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
            // At the end itself still in the last piece, for its slope, unless the value jumps.
            const bool jumps = curve.end_value() != curve.pieces().back()(curve.end());
            ends_.push_back(jumps ? curve.end()
                                  : std::nextafter(curve.end(), (std::numeric_limits<T>::max)()));
            entries_.push_back({ends_.back(), std::uint32_t(pieces_.size()), of});
            pieces_.push_back(constant(curve.end_value()));
        }
        // A time and a piece occur together once, so that the order is the same with every library.
        if (entries_.empty()) return;
        std::qsort(entries_.data(), entries_.size(), sizeof(Entry), [](const void* a, const void* b) {
            const auto &first = *static_cast<const Entry*>(a), &second = *static_cast<const Entry*>(b);
            if (first.time != second.time) return first.time < second.time ? -1 : 1;
            return first.piece < second.piece ? -1 : 1;
        });
    }

    std::size_t size() const noexcept { return first_.size(); } ///< curves
    std::size_t bytes() const noexcept {
        return pieces_.size() * sizeof(CubicPiece<T>) + entries_.size() * sizeof(Entry) +
               first_.size() * (sizeof(std::uint32_t) + sizeof(T));
    }

    /// The pieces of all curves at the time last asked for. One for every place that plays a bank;
    /// made once, used every frame.
    class Cursor {
    public:
        Cursor() = default;

    private:
        friend class CurveBank;
        struct Block {
            Lanes<T> begin, c0, c1, c2, c3;

            CubicPiece<T> piece(std::size_t lane) const noexcept {
                return {begin[lane], c0[lane], c1[lane], c2[lane], c3[lane]};
            }
            void set(std::size_t lane, const CubicPiece<T>& p) noexcept {
                begin[lane] = p.begin;
                c0[lane] = p.c0;
                c1[lane] = p.c1;
                c2[lane] = p.c2;
                c3[lane] = p.c3;
            }
        };
        std::vector<Block> blocks_;
        std::size_t entered_ = 0; ///< entries up to the time
    };
    Cursor make_cursor() const {
        Cursor cursor;
        cursor.blocks_.resize(block_count<T>(size()));
        for (auto& block : cursor.blocks_) {
            for (std::size_t lane = 0; lane < lane_count<T>; ++lane) // zero beyond the last curve
                block.set(lane, {T(0), T(0), T(0), T(0), T(0)});
        }
        for (std::size_t k = 0; k < size(); ++k) load(cursor, k, first_[k]);
        return cursor;
    }

    /// The values of all curves at a finite time, into `out` (#curves), and their derivatives by
    /// time where `slopes` is not empty. Outside a curve its nearest value is held. O(#curves),
    /// wherever the cursor was.
    void sample(T x, Cursor& cursor, std::span<T> out, std::span<T> slopes = {}) const noexcept {
        CAGEFORM_ASSERT(out.size() >= size() && (slopes.empty() || slopes.size() >= size()),
                        "a place for every curve");
        CAGEFORM_ASSERT(cursor.blocks_.size() == block_count<T>(size()), "a cursor of this bank");
        move_to(x, cursor);
        constexpr std::size_t lanes = lane_count<T>;
        for (std::size_t b = 0; b < cursor.blocks_.size(); ++b) {
            const auto& block = cursor.blocks_[b];
            const std::size_t first = b * lanes, count = size() - first < lanes ? size() - first : lanes;
            Lanes<T> value;
            for (std::size_t lane = 0; lane < lanes; ++lane) value[lane] = block.piece(lane)(x);
            store(value, count, out.data() + first);
            if (slopes.empty()) continue;
            for (std::size_t lane = 0; lane < lanes; ++lane) value[lane] = block.piece(lane).derivative(x);
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
    void load(Cursor& cursor, std::size_t curve, std::size_t piece) const noexcept {
        cursor.blocks_[curve / lane_count<T>].set(curve % lane_count<T>, pieces_[piece]);
    }

    void move_to(T x, Cursor& cursor) const noexcept {
        std::size_t& e = cursor.entered_;
        const auto time = [&](std::size_t i) { return entries_[i].time; };
        const std::size_t count = entries_.size(), most = 4 * size();
        // Of a far jump a search a curve, in place of more than four entries a curve.
        const bool far_forward = e + most < count && time(e + most) <= x;
        if (far_forward || (e > most && time(e - most - 1) > x)) {
            e = time(0) <= x ? detail::last_up_to(x, count, time) + 1 : 0;
            for (std::size_t k = 0; k < size(); ++k) load(cursor, k, locate(k, x));
            return;
        }
        for (; e < count && time(e) <= x; ++e) load(cursor, entries_[e].curve, entries_[e].piece);
        for (; e > 0 && time(e - 1) > x; --e) load(cursor, entries_[e - 1].curve, entries_[e - 1].piece - 1);
    }
    /// The piece of a curve at a time, which may be one of the two constants.
    std::size_t locate(std::size_t curve, T x) const noexcept {
        const std::size_t before = first_[curve], first = before + 1;
        const std::size_t after = (curve + 1 < size() ? first_[curve + 1] : pieces_.size()) - 1;
        const auto begin = [&](std::size_t i) { return pieces_[first + i].begin; };
        if (x >= ends_[curve]) return after;
        return x < begin(0) ? before : first + detail::last_up_to(x, after - first, begin);
    }

    std::vector<CubicPiece<T>> pieces_; ///< of all curves, each between two constants
    std::vector<std::uint32_t> first_;  ///< of every curve
    std::vector<T> ends_;               ///< of every curve: from where its value is held
    std::vector<Entry> entries_;        ///< by time
};

} // namespace cageform::inline CAGEFORM_ABI
