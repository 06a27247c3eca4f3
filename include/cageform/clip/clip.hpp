// The motion of a cage: returns the pose of all vertices at a time. For run time.
#pragma once

#include <cageform/clip/curves/curve_bank.hpp>
#include <cageform/clip/curves/rigid_motion.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A non-owning view of a `CageClip` or of a packed clip (clip/clip_blob.hpp).
template <Scalar T, std::size_t D>
struct CageClipView {
    static_assert(D == 2 || D == 3);
    using scalar = T;
    static constexpr std::size_t dimension = D;
    using Cursor = CurveCursor<T>;

    CurveBankView<T> bank; ///< #vertices · D curves, the coordinates of a vertex adjacent
    T first_time = 0, last_time = 0;
    /// Added to all times of the bank, first_time and last_time, since T is inexact far from zero.
    double origin = 0;
    Extrapolation before = Extrapolation::constant, after = Extrapolation::constant;
    /// 3 · #curves: the slopes at the first time, the slopes at the last time, the differences of the
    /// end values; empty if no extrapolation uses them.
    std::span<const T> ends;
    RigidMotionView<T, D> motion;
    bool moves = false; ///< whether `motion` applies

    std::size_t vertex_count() const noexcept { return bank.size() / D; }
    double begin() const noexcept { return origin + double(first_time); }
    double end() const noexcept { return origin + double(last_time); }

    /// The size of a cursor's memory, in Lanes<T> of 64 bytes each.
    std::size_t cursor_rows() const noexcept { return bank.cursor_rows() + block_count<T>(bank.size()); }
    /// Makes the state of one playing instance of the clip. May throw std::bad_alloc.
    Cursor make_cursor() const { return detail::started(*this, Cursor(cursor_rows())); }
    /// Makes a cursor in the caller's memory, at least `cursor_rows` long; does not allocate.
    Cursor make_cursor(std::span<Lanes<T>> memory) const noexcept {
        return detail::started(*this, Cursor(memory));
    }
    /// Resets a cursor of any clip to this clip. The cursor's memory must be at least `cursor_rows` long.
    void start(Cursor& cursor) const noexcept {
        CAGEFORM_ASSERT(cursor.memory().size() >= cursor_rows(), "cursor memory of cursor_rows()");
        bank.start(cursor);
    }

    /// Writes the cage's vertices at a time to `pose` (#vertices), the input of `clone`.
    void sample(double time, Cursor& cursor, std::span<Vec<T, D>> pose) const noexcept {
        CAGEFORM_ASSERT(pose.size() >= vertex_count(), "an element of pose per vertex");
        CAGEFORM_ASSERT(cursor.memory().size() >= cursor_rows(), "a cursor of this clip");
        if (bank.size() == 0) return;
        const auto folded = fold_time(static_cast<T>(time - origin), first_time, last_time, before, after);
        const std::span<T> values(cursor.memory()[bank.cursor_rows()].v, bank.size());
        bank.sample(folded.time, cursor, values);
        if (folded.cycles != 0 || folded.beyond != 0) {
            const T* const slopes = ends.data() + (folded.beyond < 0 ? 0 : bank.size());
            const T* const rises = ends.data() + 2 * bank.size();
            for (std::size_t n = 0; n < bank.size(); ++n)
                values[n] = folded.extend(values[n], slopes[n], rises[n]);
        }
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            for (std::size_t k = 0; k < D; ++k) pose[i][k] = values[i * D + k];
        }
        if (moves) motion.apply(static_cast<T>(time), pose.first(vertex_count()));
    }
};

/// The motion of a cage: a curve per coordinate of each vertex, and optionally a rigid motion applied
/// afterwards. Made by `compile` (animate/compile.hpp); `sample` does not allocate. `pack_clip`
/// (animate/pack_clip.hpp) converts it to a block of bytes.
template <Scalar T, std::size_t D>
class CageClip {
    static_assert(D == 2 || D == 3);

public:
    using scalar = T;
    static constexpr std::size_t dimension = D;
    /// The state of one playing instance of the clip.
    using Cursor = CurveCursor<T>;

    CageClip() = default;

    /// `curves`: #vertices · D, none empty, the coordinates of a vertex adjacent. The clip lasts from
    /// the earliest begin of a curve to the latest end, and is extrapolated as a whole. Times of the
    /// curves are relative to `origin`; times of a rigid motion are absolute.
    CageClip(std::span<const PiecewiseCubic<T>> curves, Extrapolation before = Extrapolation::constant,
             Extrapolation after = Extrapolation::constant, double origin = 0)
        : bank_(curves)
        , origin_(origin)
        , before_(before)
        , after_(after) {
        CAGEFORM_ASSERT(curves.size() % D == 0, "D curves per vertex");
        if (curves.empty()) return;
        begin_ = curves[0].begin();
        end_ = curves[0].end();
        for (const auto& curve : curves) {
            begin_ = curve.begin() < begin_ ? curve.begin() : begin_;
            end_ = curve.end() > end_ ? curve.end() : end_;
        }
        for (const auto& curve : curves)
            ends_.push_back(curve.begin() == begin_ ? curve.derivative(begin_) : T(0));
        for (const auto& curve : curves)
            ends_.push_back(curve.end() == end_ ? curve.pieces().back().derivative(end_) : T(0));
        for (const auto& curve : curves) ends_.push_back(curve.end_value() - curve.pieces().front().c0);
    }

    void set_rigid_motion(RigidMotion<T, D> motion) {
        motion_ = std::move(motion);
        moves_ = true;
    }

    CageClipView<T, D> view() const noexcept {
        return {bank_.view(), begin_, end_, origin_, before_, after_, ends_, motion_.view(), moves_};
    }

    std::size_t vertex_count() const noexcept { return bank_.size() / D; }
    double begin() const noexcept { return view().begin(); }
    double end() const noexcept { return view().end(); }
    std::size_t bytes() const noexcept { return bank_.bytes(); } ///< of memory
    Cursor make_cursor() const { return view().make_cursor(); }

    /// Writes the cage's vertices at a time to `pose` (#vertices), the input of `clone`.
    void sample(double time, Cursor& cursor, std::span<Vec<T, D>> pose) const noexcept {
        view().sample(time, cursor, pose);
    }

private:
    CurveBank<T> bank_;
    T begin_ = 0, end_ = 0; // count from origin_
    double origin_ = 0;
    Extrapolation before_ = Extrapolation::constant, after_ = Extrapolation::constant;
    std::vector<T> ends_;
    RigidMotion<T, D> motion_;
    bool moves_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI
