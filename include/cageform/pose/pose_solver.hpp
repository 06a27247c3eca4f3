// Poses a cage by pins on the figure, every frame, as rigidly as possible inside.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/view.hpp>
#include <cageform/pose/detail/anderson.hpp>
#include <cageform/pose/detail/pose_system.hpp>
#include <cageform/pose/detail/rigid_frame.hpp>
#include <cageform/pose/detail/rotation_pass.hpp>
#include <cageform/pose/types/pose_blob.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Finds poses of a cage that keep its inside as rigid as possible while pinned points follow targets. The
/// energy has few local rotations and many samples (Jacobson, Baran, Kavan, Popović, Sorkine, Fast automatic
/// skinning transformations, ACM Trans. Graph. 31 (2012)) of the inside of a cage (Ben-Chen, Weber, Gotsman,
/// Variational harmonic maps for space deformation, ACM Trans. Graph. 28 (2009)).
///
///     PoseSolver<double, 2> solver(pose_samples(coordinates).value);  // once; the samples ship with a game
///     Status status = solver.set_pins({.binding = pins.view()});      // per click: factors a matrix
///     const PoseSolverReport report = solver.solve(targets, pose);    // per frame; then clone(…, pose, out)
///
/// Each frame starts with the best rigid motion of the pins. Each iteration then rotates every cluster of
/// samples to its best fit and solves for the handles. Handles are stored as displacements in the moving
/// frame of the rigid motion, so pins at rest give bitwise the pose at rest. All numbers are double, except
/// sums over the samples' gradients. All coordinate types are supported, including those with vector handles.
template <Scalar T, std::size_t D>
class PoseSolver {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PoseSolver() = default;
    /// Takes ownership of the samples. `status` becomes ok, samples_missing, too_many_handles or
    /// out_of_memory.
    explicit PoseSolver(PoseSamples<T, D> samples, const PoseOptions& options = {});

    Status status() const noexcept { return status_; }
    const PoseSamples<T, D>& samples() const noexcept { return samples_; }
    /// Returns the pin or handle that `set_pins` or `set_held` refused last, or none.
    std::size_t culprit() const noexcept { return culprit_; }

    /// Replaces the pins and keeps the pose. {} removes all pins.
    ///
    ///   cost   O(#handles³ / 3 + #pins #handles²) operations; allocates
    ///   fails  as `status`; bindings_differ (other handles, or axes of other points); pins_do_not_match
    ///          (different numbers of pins, weights and turns, or turns without axes); index_out_of_range (a
    ///          pin); weights_not_positive; pin_without_weights (no pose moves the pin); pose_not_determined
    ///          (a handle without constraint, the culprit); out_of_memory. The previous pins are then kept
    Status set_pins(const PosePins<T, D>& pins);

    /// Sets the handles that `solve` keeps at their positions in the caller's pose; `solve` computes all
    /// others. With held handles, frames do not start with a rigid motion.
    ///
    ///   handles  in any order
    ///   fails    index_out_of_range, and as `set_pins`. The previous handles are then kept
    Status set_held(std::span<const std::uint32_t> handles);

    /// Replaces the pose from which the next frame starts.
    ///
    ///   pose   #handles
    ///   fails  as `status`; pose_size_differs; pose_not_finite. The previous pose is then kept
    template <PointRangeIn<D> Pose>
    Status set_pose(const Pose& pose) noexcept {
        if (status_ != Status::ok) return status_;
        if (std::size(pose) != handle_count()) return Status::pose_size_differs;
        for (std::size_t i = 0; i < handle_count(); ++i) {
            if (!is_finite(displacement_of(to_vec<double>(pose[i]), i))) return Status::pose_not_finite;
        }
        frame_ = {};
        for (std::size_t i = 0; i < handle_count(); ++i)
            displacements_.set(i, displacement_of(to_vec<double>(pose[i]), i));
        pass_.forget();
        is_new_ = true;
        remember_pose();
        return Status::ok;
    }
    /// Makes the next frame start from the pose at rest.
    void reset() noexcept;

    /// Moves the pose towards the targets by PoseOptions::iterations iterations. Call it with the same
    /// targets until the report says `settled`.
    ///
    ///   targets  one per pin, in the units of the cage
    ///   pose     in: positions of held handles; out: #handles, for `clone`
    ///   turns    empty, or one per pin; ignored for pins that do not turn
    ///   returns  the report. Status: as `status`; pins_do_not_match (the number of targets or turns);
    ///            pose_size_differs; pose_not_finite (a target, a turn, a held handle, or the result). `pose`
    ///            and the start of the next frame are then unchanged
    ///   cost     (4 #clusters D² + 2 #handles D) #handles operations per iteration, and as many for the
    ///            report; no allocation
    template <PointRangeIn<D> Targets, MutablePointRangeIn<D> Pose>
    PoseSolverReport solve(const Targets& targets, Pose&& pose,
                           std::span<const PoseTurn<D>> turns = {}) noexcept {
        PoseSolverReport report;
        report.status = check(std::size(targets), std::size(pose), turns.size());
        if (report.status != Status::ok) return report;
        kept_.copy(displacements_);
        const auto kept_frame = frame_;
        for (const std::uint32_t h : system_.held) {
            const auto d = displacement_of(to_vec<double>(pose[h]), h);
            is_new_ = is_new_ || !(d == displacements_.get(h));
            displacements_.set(h, d);
            if (!is_finite(d)) return refused(report, h, kept_frame);
        }
        for (std::size_t r = 0; r < rows().size(); ++r) {
            const auto& row = rows()[r];
            const auto offset = row.is_point()
                                    ? (1 / samples_.size) * (to_vec<double>(targets[row.pin]) - row.rest)
                                    : turned_axis(row.axis, turns[row.pin]);
            if (!is_finite(offset)) return refused(report, row.pin, kept_frame);
            is_new_ = is_new_ || !(offset == offsets_[r]);
            offsets_[r] = offset;
        }
        if (!rows().empty() || !system_.held.empty()) run(report);
        for (std::size_t i = 0; i < handle_count(); ++i) {
            if (!is_finite(vec_cast<T>(handle(i))))
                return refused(report, PoseSolverReport::none, kept_frame);
        }
        finish(report);
        for (std::size_t i = 0; i < handle_count(); ++i) store_point(pose, i, handle(i));
        return report;
    }

private:
    using Row = typename detail::PinRows<T, D>::Row;

    std::size_t handle_count() const noexcept { return samples_.handle_count(); }
    const std::vector<Row>& rows() const noexcept { return system_.pins.rows; }
    const Lanes<double>* weights_of(std::size_t row) const noexcept {
        return system_.pins.weights.data() + row * displacements_.blocks();
    }
    double is_point(std::size_t i) const noexcept {
        return samples_.handle_kinds[i] == HandleKind::point ? 1 : 0;
    }

    Status begin();

    /// Factors a system made by set(system). Replaces the current system only on success.
    template <class Set>
    Status change_system(const Set& set);
    void take(detail::PoseSystem<T, D>&& system);

    // Frames: h = Q (H + d) + b, in units of the samples.
    /// Returns h − H of a handle.
    Vec<double, D> displacement_of(const Vec<double, D>& h, std::size_t i) const noexcept {
        return (1 / samples_.size) * (h - vec_cast<double>(samples_.rest_handles[i]));
    }
    /// Returns the displacement of a handle from rest, including the frame's motion.
    Vec<double, D> moved(std::size_t i) const noexcept {
        const auto rest = detail::PinRows<T, D>::unit_handle(samples_, i);
        return frame_.rotate(displacements_.get(i)) + frame_.change(rest) + is_point(i) * frame_.shift;
    }
    Vec<double, D> handle(std::size_t i) const noexcept {
        return vec_cast<double>(samples_.rest_handles[i]) + samples_.size * moved(i);
    }
    /// Resets the frame to the identity and keeps the pose.
    void leave_frame() noexcept;
    void remember_pose() noexcept;
    static Vec<double, D> turned_axis(std::size_t axis, const PoseTurn<D>& turn) noexcept {
        const auto change = detail::rotation_of(turn);
        Vec<double, D> offset;
        for (std::size_t k = 0; k < D; ++k) offset[k] = turn_lever * change.at[k][axis];
        return offset;
    }

    Status check(std::size_t targets, std::size_t pose, std::size_t turns) const noexcept;
    PoseSolverReport refused(PoseSolverReport& report, std::size_t culprit,
                             const detail::RigidFrame<D>& frame) noexcept;

    void run(PoseSolverReport& report) noexcept;

    /// Sets the frame to the rigid motion that fits the pins to their targets best.
    void align() noexcept;
    /// Returns whether pose and targets are at rest.
    bool is_at_rest() const noexcept;
    /// Sets the targets of the rows of pins, as displacements in the frame.
    void set_demands() noexcept;

    /// Rotates the clusters, and sets the right-hand side and the energies. Returns the energy of the pose.
    double evaluate(detail::Stretches* stretches, PoseSolverReport& report) noexcept;
    /// Returns tr(d K dᵀ).
    double strain() const noexcept;

    void gather(detail::AxisVectors<D>& to) const noexcept {
        for (std::size_t n = 0; n < system_.unknowns.size(); ++n)
            to.set(n, displacements_.get(system_.unknowns[n]));
    }
    void scatter(const detail::AxisVectors<D>& from) noexcept {
        for (std::size_t n = 0; n < system_.unknowns.size(); ++n)
            displacements_.set(system_.unknowns[n], from.get(n));
    }

    void finish(PoseSolverReport& report) noexcept;

    PoseSamples<T, D> samples_;
    PoseOptions options_;
    Status status_ = Status::samples_missing;
    std::size_t culprit_ = PoseSolverReport::none;

    detail::PoseSystem<T, D> system_;
    detail::RotationPass<T, D> pass_;
    detail::Anderson anderson_;
    std::vector<Lanes<double>> stiffness_; ///< lower triangle of K by rows, doubled off the diagonal
    std::vector<std::size_t> stiffness_begin_;
    detail::RigidFrame<D> frame_;
    detail::AxisVectors<D> displacements_; ///< d of all handles
    detail::AxisVectors<D> kept_;          ///< d at the start of the frame
    detail::AxisVectors<D> last_;          ///< displacements from rest after the previous frame
    detail::AxisVectors<D> right_;         ///< A d of all handles
    detail::AxisVectors<D> from_, to_;     ///< d of unknown handles before and after an iteration
    std::vector<Vec<T, D>> sample_displacements_;
    std::vector<Vec<double, D>> offsets_; ///< of the rows' targets from rest
    std::vector<Vec<double, D>> demands_; ///< the offsets in the frame
    bool is_new_ = true;                  ///< whether pins, targets or the pose changed since the last frame
};

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/pose/detail/pose_solver.impl.hpp>
#endif
