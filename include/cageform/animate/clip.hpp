// A cage that moves: the pose of all its vertices at a time. Run time, as piecewise_cubic.hpp.
#pragma once

#include <cageform/animate/curve_bank.hpp>
#include <cageform/animate/rigid_motion.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The motion of a cage: a curve for every coordinate of every vertex, and perhaps a rigid motion
/// on top. Made once, of key frames by `compile_clip` (animate/compile_clip.hpp); `sample`
/// allocates nothing.
template <Scalar T, std::size_t D>
class CageClip {
    static_assert(D == 2 || D == 3);

public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    CageClip() = default;

    /// `curves`: #vertices · D, the coordinates of a vertex side by side, each with pieces. The
    /// clip lasts from the first begin of a curve to the last end. It is extrapolated as a whole.
    CageClip(std::span<const PiecewiseCubic<T>> curves, Extrapolation before = Extrapolation::constant,
             Extrapolation after = Extrapolation::constant)
        : bank_(curves)
        , before_(before)
        , after_(after) {
        CAGEFORM_ASSERT(curves.size() % D == 0, "D curves a vertex");
        if (curves.empty()) return;
        begin_ = curves[0].begin();
        end_ = curves[0].end();
        for (const auto& curve : curves) {
            begin_ = curve.begin() < begin_ ? curve.begin() : begin_;
            end_ = curve.end() > end_ ? curve.end() : end_;
        }
        // What extrapolation takes: values and slopes at the ends.
        Cursor cursor = make_cursor();
        first_.resize(curves.size());
        last_.resize(curves.size());
        first_slope_.resize(curves.size());
        last_slope_.resize(curves.size());
        bank_.sample(end_, cursor.bank_, last_);
        bank_.sample(begin_, cursor.bank_, first_, first_slope_);
        for (std::size_t k = 0; k < curves.size(); ++k) {
            const auto& last = curves[k].pieces().back();
            last_slope_[k] = curves[k].end() == end_ ? last.derivative(end_) : T(0);
        }
    }

    void set_rigid_motion(RigidMotion<T, D> motion) {
        motion_ = std::move(motion);
        moves_ = true;
    }

    std::size_t vertex_count() const noexcept { return bank_.size() / D; }
    T begin() const noexcept { return begin_; }
    T end() const noexcept { return end_; }
    std::size_t bytes() const noexcept { return bank_.bytes(); }

    /// Where a player of the clip is; one for every place that plays it.
    class Cursor {
    public:
        Cursor() = default;

    private:
        friend class CageClip;
        typename CurveBank<T>::Cursor bank_;
        std::vector<T> values_;
    };
    Cursor make_cursor() const {
        Cursor cursor;
        cursor.bank_ = bank_.make_cursor();
        cursor.values_.resize(bank_.size());
        return cursor;
    }

    /// The cage's vertices at a time, into `pose` (#vertices): what `clone` takes.
    void sample(T time, Cursor& cursor, std::span<Vec<T, D>> pose) const noexcept {
        CAGEFORM_ASSERT(pose.size() >= vertex_count(), "a place for every vertex");
        const auto folded = fold_time(time, begin_, end_, before_, after_);
        bank_.sample(folded.time, cursor.bank_, cursor.values_);
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            for (std::size_t k = 0; k < D; ++k) {
                const std::size_t n = i * D + k;
                const T slope = folded.beyond < 0 ? first_slope_[n] : last_slope_[n];
                pose[i][k] = folded.extend(cursor.values_[n], slope, last_[n] - first_[n]);
            }
        }
        if (moves_) motion_.apply(time, pose.first(vertex_count()));
    }

private:
    CurveBank<T> bank_;
    T begin_ = 0, end_ = 0;
    Extrapolation before_ = Extrapolation::constant, after_ = Extrapolation::constant;
    std::vector<T> first_, last_, first_slope_, last_slope_; ///< of every curve at the clip's ends
    RigidMotion<T, D> motion_;
    bool moves_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI
