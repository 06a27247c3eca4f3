// Evaluates many piecewise cubics at once. For run time.
#pragma once

#include <cageform/clip/curves/piecewise_cubic.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// A curve of a bank. Its knots are the begins of its pieces, and the end of the last piece.
template <Scalar T>
struct BankCurve {
    std::uint32_t first_knot = 0;
    std::uint32_t knots = 0; ///< #pieces + 1
    T low = 0, step = 0;     ///< for a quantised curve: integer n means low + n · step
    T end_value = 0;         ///< at and after the last knot
};

/// The curve enters its next piece at this knot.
struct KnotEvent {
    std::uint32_t knot, curve;

    friend bool operator==(const KnotEvent&, const KnotEvent&) = default;
};

template <Scalar T>
struct CurveBankView;

/// The current pieces of all curves. Create one cursor per playing instance, once.
template <Scalar T>
class CurveCursor {
public:
    CurveCursor() = default;
    /// Uses the caller's memory, which must outlive the cursor; copies share it.
    explicit CurveCursor(std::span<Lanes<T>> memory) noexcept
        : given_(memory) {}
    /// Allocates its own memory.
    explicit CurveCursor(std::size_t rows)
        : own_(rows) {}

    std::span<Lanes<T>> memory() noexcept { return own_.empty() ? given_ : std::span<Lanes<T>>(own_); }

private:
    friend struct CurveBankView<T>;
    std::vector<Lanes<T>> own_;
    std::span<Lanes<T>> given_;
    std::size_t entered_ = 0; ///< the number of entries up to the current time
};

namespace detail {

template <class Player, class Cursor>
Cursor started(const Player& player, Cursor cursor) noexcept {
    player.start(cursor);
    return cursor;
}

} // namespace detail

/// A non-owning view of a `CurveBank` or of the curves of a packed clip.
template <Scalar T>
struct CurveBankView {
    using scalar = T;
    using Cursor = CurveCursor<T>;

    std::span<const BankCurve<T>> curves;
    /// The knots of the unquantised curves, one curve after the other, then those of the quantised curves.
    std::span<const T> knots;
    std::span<const std::array<T, 4>> pieces; ///< c0 … c3 after each knot of an unquantised curve
    /// Bernstein coefficients after each knot of a quantised curve; unused at the last knot of a curve.
    std::span<const std::array<std::uint16_t, 4>> steps;
    std::span<const KnotEvent> entries; ///< one per knot, sorted by time, then by knot

    std::size_t size() const noexcept { return curves.size(); } ///< curves
    std::size_t bytes() const noexcept {
        return curves.size_bytes() + knots.size_bytes() + pieces.size_bytes() + steps.size_bytes() +
               entries.size_bytes();
    }
    std::size_t piece_count(std::size_t curve) const noexcept { return curves[curve].knots - 1; }
    bool is_quantised(std::size_t curve) const noexcept { return curves[curve].first_knot >= pieces.size(); }
    /// Returns piece n of a curve; n = #pieces is the constant after the last one.
    CubicPiece<T> piece(std::size_t curve, std::size_t n) const noexcept {
        return piece_at(curve, curves[curve].first_knot + n);
    }

    /// The size of a cursor's memory, in Lanes<T>.
    std::size_t cursor_rows() const noexcept { return rows * block_count<T>(size()); }
    Cursor make_cursor() const { return detail::started(*this, Cursor(cursor_rows())); }
    /// Uses the caller's memory, at least `cursor_rows` long; does not allocate.
    Cursor make_cursor(std::span<Lanes<T>> memory) const noexcept {
        return detail::started(*this, Cursor(memory));
    }
    /// Resets a cursor of any bank to this bank, before the first knot.
    void start(Cursor& cursor) const noexcept {
        CAGEFORM_ASSERT(cursor.memory().size() >= cursor_rows(), "cursor memory of cursor_rows()");
        for (std::size_t b = 0; b < block_count<T>(size()); ++b) {
            for (std::size_t lane = 0; lane < lane_count<T>; ++lane) // zero after the last curve
                set(block(cursor, b), lane, constant(T(0)));
        }
        for (std::size_t k = 0; k < size(); ++k) load(cursor, k, constant(piece(k, 0).c0));
        cursor.entered_ = 0;
    }

    /// Writes the values of all curves at a finite time to `out` (#curves), and their derivatives by
    /// time to `slopes` (#curves) unless it is empty. Outside its range, a curve has its nearest value.
    /// O(#curves), wherever the cursor was.
    void sample(T x, Cursor& cursor, std::span<T> out, std::span<T> slopes = {}) const noexcept {
        CAGEFORM_ASSERT(out.size() >= size() && (slopes.empty() || slopes.size() >= size()),
                        "an element per curve");
        CAGEFORM_ASSERT(cursor.memory().size() >= cursor_rows(), "a cursor of this bank");
        move_to(x, cursor);
        constexpr std::size_t lanes = lane_count<T>;
        const Lanes<T>* at = block(cursor, 0);
        for (std::size_t first = 0; first < size(); first += lanes, at += rows) {
            const std::size_t count = size() - first < lanes ? size() - first : lanes;
            Lanes<T> value;
            for (std::size_t lane = 0; lane < lanes; ++lane) value[lane] = get(at, lane)(x);
            store(value, count, out.data() + first);
            if (slopes.empty()) continue;
            for (std::size_t lane = 0; lane < lanes; ++lane) value[lane] = get(at, lane).derivative(x);
            store(value, count, slopes.data() + first);
        }
    }

private:
    static constexpr std::size_t rows = 5; ///< per block of a cursor: begin, c0 … c3

    static Lanes<T>* block(Cursor& cursor, std::size_t b) noexcept {
        return cursor.memory().data() + b * rows;
    }
    static CubicPiece<T> get(const Lanes<T>* block, std::size_t lane) noexcept {
        return {block[0][lane], block[1][lane], block[2][lane], block[3][lane], block[4][lane]};
    }
    static void set(Lanes<T>* block, std::size_t lane, const CubicPiece<T>& p) noexcept {
        block[0][lane] = p.begin;
        block[1][lane] = p.c0;
        block[2][lane] = p.c1;
        block[3][lane] = p.c2;
        block[4][lane] = p.c3;
    }
    static void store(const Lanes<T>& value, std::size_t count, T* out) noexcept {
        if (count == lane_count<T>) {
            for (std::size_t lane = 0; lane < lane_count<T>; ++lane) out[lane] = value[lane];
        } else {
            for (std::size_t lane = 0; lane < count; ++lane) out[lane] = value[lane];
        }
    }
    static CubicPiece<T> constant(T value) noexcept { return {T(0), value, T(0), T(0), T(0)}; }
    CubicPiece<T> piece_at(std::size_t curve, std::size_t knot) const noexcept {
        if (knot >= pieces.size()) return decoded(curves[curve], knot);
        const auto& p = pieces[knot];
        return {knots[knot], p[0], p[1], p[2], p[3]};
    }
    /// Decodes a quantised piece. Differences are exact, since they are differences of integers.
    CubicPiece<T> decoded(const BankCurve<T>& c, std::size_t knot) const noexcept {
        if (knot - c.first_knot + 1 == c.knots) return constant(c.end_value);
        const auto& b = steps[knot - pieces.size()];
        const T begin = knots[knot], h = knots[knot + 1] - begin;
        const int b0 = b[0], b1 = b[1], b2 = b[2], b3 = b[3];
        const T d1 = c.step * T(3 * (b1 - b0)), d2 = c.step * T(3 * (b2 - 2 * b1 + b0)),
                d3 = c.step * T(b3 - 3 * (b2 - b1) - b0);
        return {begin, detail::multiply_add(c.step, T(b0), c.low), d1 / h, d2 / h / h, d3 / h / h / h};
    }
    static void load(Cursor& cursor, std::size_t curve, const CubicPiece<T>& piece) noexcept {
        set(block(cursor, curve / lane_count<T>), curve % lane_count<T>, piece);
    }
    /// Returns the piece of a curve before a knot.
    CubicPiece<T> piece_before(std::size_t curve, std::size_t knot) const noexcept {
        return knot > curves[curve].first_knot ? piece_at(curve, knot - 1)
                                               : constant(piece_at(curve, knot).c0);
    }

    void move_to(T x, Cursor& cursor) const noexcept {
        std::size_t& e = cursor.entered_;
        const auto time = [&](std::size_t i) { return knots[entries[i].knot]; };
        const std::size_t count = entries.size(), most = 4 * size();
        // For jumps over more than four entries per curve, a binary search in each curve is faster.
        const bool far_forward = e + most < count && time(e + most) <= x;
        if (far_forward || (e > most && time(e - most - 1) > x)) {
            e = time(0) <= x ? detail::last_up_to(x, count, time) + 1 : 0;
            for (std::size_t k = 0; k < size(); ++k) load(cursor, k, locate(k, x));
            return;
        }
        for (; e < count && time(e) <= x; ++e) {
            const auto [knot, curve] = entries[e];
            load(cursor, curve, piece_at(curve, knot));
        }
        for (; e > 0 && time(e - 1) > x; --e) {
            const auto [knot, curve] = entries[e - 1];
            load(cursor, curve, piece_before(curve, knot));
        }
    }
    /// Finds the piece of a curve at a time.
    CubicPiece<T> locate(std::size_t curve, T x) const noexcept {
        const BankCurve<T>& c = curves[curve];
        const T* const of_curve = knots.data() + c.first_knot;
        if (x < of_curve[0]) return piece_before(curve, c.first_knot);
        return piece(curve,
                     detail::last_up_to(x, c.knots, [of_curve](std::size_t i) { return of_curve[i]; }));
    }
};

/// Many curves that are evaluated at once, such as the coordinates of a cage's vertices. Their knots
/// may differ.
///
/// A cursor holds the current piece of each curve, in rows of one cache line. The knots of all curves are
/// sorted by time. Playing from one time to another, in either direction, visits the knots in between:
/// at each of them, one curve enters another piece.
///
///   cost    playing: a few vector operations and five loads per value, and a few nanoseconds for each
///           curve that enters another piece; a jump: a binary search in each curve
///   memory  five scalars and two indices per piece; a cursor: five scalars per curve
template <Scalar T>
class CurveBank {
public:
    using scalar = T;
    using Cursor = CurveCursor<T>;

    CurveBank() = default;
    explicit CurveBank(std::span<const PiecewiseCubic<T>> curves) {
        std::vector<Entry> entries;
        for (const auto& curve : curves) {
            CAGEFORM_ASSERT(!curve.empty(), "curves with pieces");
            const auto add_knot = [&, of = std::uint32_t(curves_.size())](T time) {
                entries.push_back({time, {std::uint32_t(knots_.size()), of}});
                knots_.push_back(time);
            };
            BankCurve<T> made;
            made.first_knot = std::uint32_t(knots_.size());
            made.knots = std::uint32_t(curve.pieces().size() + 1);
            made.end_value = curve.end_value();
            for (const auto& piece : curve.pieces()) {
                add_knot(piece.begin);
                pieces_.push_back({piece.c0, piece.c1, piece.c2, piece.c3});
            }
            // The last piece includes the end time, so that its slope applies there, unless the value jumps.
            const bool jumps = curve.end_value() != curve.pieces().back()(curve.end());
            add_knot(jumps ? curve.end() : std::nextafter(curve.end(), (std::numeric_limits<T>::max)()));
            pieces_.push_back({curve.end_value(), T(0), T(0), T(0)});
            curves_.push_back(made);
        }
        if (entries.empty()) return;
        // Pairs of a time and a knot are unique, so the order does not depend on the library's qsort.
        std::qsort(entries.data(), entries.size(), sizeof(Entry), [](const void* a, const void* b) {
            const auto &first = *static_cast<const Entry*>(a), &second = *static_cast<const Entry*>(b);
            if (first.time != second.time) return first.time < second.time ? -1 : 1;
            return first.entry.knot < second.entry.knot ? -1 : 1;
        });
        for (const Entry& entry : entries) entries_.push_back(entry.entry);
    }

    CurveBankView<T> view() const noexcept { return {curves_, knots_, pieces_, {}, entries_}; }

    std::size_t size() const noexcept { return curves_.size(); }  ///< curves
    std::size_t bytes() const noexcept { return view().bytes(); } ///< of memory
    Cursor make_cursor() const { return view().make_cursor(); }
    void sample(T x, Cursor& cursor, std::span<T> out, std::span<T> slopes = {}) const noexcept {
        view().sample(x, cursor, out, slopes);
    }

private:
    struct Entry {
        T time;
        KnotEvent entry;
    };

    std::vector<BankCurve<T>> curves_;
    std::vector<T> knots_;
    std::vector<std::array<T, 4>> pieces_;
    std::vector<KnotEvent> entries_;
};

} // namespace cageform::inline CAGEFORM_ABI
