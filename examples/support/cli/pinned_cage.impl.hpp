// Implementation of PinnedCage, for the files that instantiate it.
#pragma once

#include "cli/pinned_cage.hpp"
#include "cli/progress_bar.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/binding/pose_samples.hpp>

#include <chrono>
#include <sstream>

namespace cageform_support {

namespace detail {

using Clock = std::chrono::steady_clock;

inline double ms_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

inline constexpr std::size_t most_frames = 2000; // per pose; figures in space take a few hundred

template <std::size_t D>
bool pin_turns(const Pin<D>& pin) {
    return pin.turn.has_value();
}

template <class Coordinates>
FileError cage_refused(const Coordinates& coordinates, const PinnedCageNames& names,
                       cageform::BindReport report, cageform::Status status) {
    report.status = status;
    report.cage = coordinates.cage_report();
    return FileError{names.describe_faults(report)};
}

/// Samples the inside of a cage, with a progress bar.
template <cageform::Scalar T, std::size_t D>
Expected<cageform::PoseSamples<T, D>> sample(const ChosenCoordinates<T, D>& coordinates,
                                             const PinnedCageNames& names,
                                             const cageform::PoseSampleOptions& options) {
    using cageform::Status;
    if (!coordinates.has_gradients())
        return FileError{"--pin: " + names.coordinates + " coordinates have no gradients, which pins need"};
    ProgressBar bar("sampling");
    auto [samples, report] = pose_samples(coordinates, options, {.progress = bar.callback()});
    if (report.status == Status::samples_missing)
        return FileError{names.cage + ": " + cageform::to_string(report.status)};
    if (report.status != Status::ok) return cage_refused(coordinates, names, report.bind, report.status);
    return std::move(samples);
}

/// Warns of targets outside the box of the handles, enlarged by a factor of two.
template <cageform::Scalar T, std::size_t D>
void warn_of_far_targets(const cageform::HandleView<T, D>& handles, const std::vector<Pin<D>>& pins) {
    const auto bounds = point_bounds(handles);
    for (std::size_t n = 0; n < pins.size(); ++n) {
        bool is_far = false;
        for (std::size_t k = 0; k < D; ++k) {
            const double low = double(bounds.lower[k]), high = double(bounds.upper[k]);
            is_far = is_far || std::fabs(pins[n].target[k] - 0.5 * (low + high)) > high - low;
        }
        if (!is_far) continue;
        warn(name_of(pins, n) + ": " + describe_target(pins[n]) +
             ", outside twice the box of the cage; numbers with signs are displacements, after = positions");
    }
}

/// Weights of pins, and of axes at pins that turn.
template <cageform::Scalar T, std::size_t D>
struct BoundPins {
    cageform::Binding<T, D> places;
    std::array<cageform::Binding<T, D>, D> axes;
};

/// Binds pins; fails if no vertex moves a pin.
template <cageform::Scalar T, std::size_t D>
Expected<BoundPins<T, D>> bind_pins(const ChosenCoordinates<T, D>& coordinates, const PinnedCageNames& names,
                                    const std::vector<Pin<D>>& pins, const OutsideChoice& outside) {
    std::vector<cageform::Vec<double, D>> places;
    for (const Pin<D>& pin : pins) places.push_back(pin.place);
    cageform::BindOptions options = outside.bind_options(coordinates);
    // A pin outside is probably a mistake if the coordinates do not extend outside, unless --outside is
    // given.
    if (outside.word == "auto" && outside.falloff == 0 && !coordinates.has_extension())
        options.outside = cageform::OutsidePoints::keep_in_place;
    auto [bound, report] = coordinates.bind(places, options);
    if (report.status != cageform::Status::ok) return cage_refused(coordinates, names, report, report.status);
    const std::string where = coordinates.takes_sites                  ? "the convex hull of "
                              : names.cage.starts_with("the cage of ") ? "" // made for the figure
                                                                       : "the cage ";
    if (const auto& out = report.outside; !out.empty()) {
        const std::string which = name_of(pins, out.front()) + " lies outside " + where + names.cage;
        if (options.outside == cageform::OutsidePoints::keep_in_place)
            return FileError{which + (coordinates.has_extension() ? ": use --outside extend"
                                                                  : ": no vertex moves that point")};
        if (outside.word == "auto") warn(which + "; it follows the extension of the coordinates (--outside)");
    }
    if (const auto& lost = report.unreached; !lost.empty())
        return FileError{name_of(pins, lost.front()) + ": no weights can be computed there"};
    BoundPins<T, D> made{std::move(bound), {}};
    if (std::any_of(pins.begin(), pins.end(), pin_turns<D>)) {
        auto axes = coordinates.bind_jacobians(places, options);
        if (!axes) return cage_refused(coordinates, names, axes.report, axes.report.status);
        made.axes = std::move(axes.value);
    }
    return made;
}

} // namespace detail

template <cageform::Scalar T, std::size_t D>
Expected<PinnedCage<T, D>> PinnedCage<T, D>::make(const ChosenCoordinates<T, D>& coordinates,
                                                  const PinnedCageNames& names, Handles handles,
                                                  const PinChoice& choice, const OutsideChoice& outside) {
    using cageform::Status;
    auto& [pins, held] = handles;
    PinnedCage made;
    detail::warn_of_far_targets(coordinates.handles(), pins);
    const auto begin = detail::Clock::now();
    auto samples = detail::sample(coordinates, names, choice.sampling);
    if (!samples) return samples.error();
    made.solver_ = cageform::PoseSolver<T, D>(std::move(*samples), choice.solving);
    made.sampling_ms_ = detail::ms_since(begin);
    const auto bound = detail::bind_pins(coordinates, names, pins, outside);
    if (!bound) return bound.error();

    std::vector<double> weights;
    std::vector<std::uint8_t> turned;
    for (const Pin<D>& pin : pins) {
        weights.push_back(pin.weight);
        turned.push_back(detail::pin_turns(pin) ? 1 : 0);
    }
    cageform::PosePins<T, D> of_solver{
        .binding = bound->places.view(), .axes = {}, .points = {}, .weights = weights, .turned = {}};
    if (std::any_of(pins.begin(), pins.end(), detail::pin_turns<D>)) {
        for (std::size_t k = 0; k < D; ++k) of_solver.axes[k] = bound->axes[k].view();
        of_solver.turned = turned;
    }
    const auto click = detail::Clock::now();
    Status status = made.solver_.set_held(held);
    if (status == Status::ok) status = made.solver_.set_pins(of_solver);
    made.click_ms_ = detail::ms_since(click);
    if (status == Status::pin_without_weights)
        return FileError{name_of(pins, made.solver_.culprit()) + ": " + cageform::to_string(status)};
    if (status != Status::ok) return FileError{names.cage + ": pins: " + cageform::to_string(status)};
    made.pins_ = std::move(pins);
    made.held_ = held.size();
    return made;
}

template <cageform::Scalar T, std::size_t D>
typename PinnedCage<T, D>::Targets PinnedCage<T, D>::targets() const {
    Targets targets;
    for (const Pin<D>& pin : pins_) targets.push_back(pin.target);
    return targets;
}

template <cageform::Scalar T, std::size_t D>
typename PinnedCage<T, D>::Turns PinnedCage<T, D>::turns() const {
    Turns turns;
    if (std::none_of(pins_.begin(), pins_.end(), detail::pin_turns<D>)) return turns;
    for (const Pin<D>& pin : pins_) turns.push_back(pin.turn.value_or(cageform::PoseTurn<D>{}));
    return turns;
}

template <cageform::Scalar T, std::size_t D>
Expected<bool> PinnedCage<T, D>::start(const Pose& pose) {
    const auto status = solver_.set_pose(pose);
    if (status != cageform::Status::ok) return FileError{cageform::to_string(status)};
    return true;
}

template <cageform::Scalar T, std::size_t D>
Expected<bool> PinnedCage<T, D>::settle(const Targets& targets, const Turns& turns, Pose& pose) {
    const auto begin = detail::Clock::now();
    for (std::size_t n = 0; n < detail::most_frames && (n == 0 || !last_.settled); ++n) {
        last_ = solver_.solve(targets, pose, turns);
        if (last_.status != cageform::Status::ok) {
            const bool is_named = last_.culprit < pins_.size();
            return FileError{(is_named ? name_of(pins_, last_.culprit) : std::string("pins")) + ": " +
                             cageform::to_string(last_.status)};
        }
        if (frames_ == 0) first_ms_ = click_ms_ + detail::ms_since(begin);
        ++frames_;
        iterations_ += last_.iterations;
    }
    solving_ms_ += detail::ms_since(begin);
    ++poses_;
    folded_ = std::max(folded_, last_.folded);
    if (last_.settled) return true;
    ++unsettled_;
    largest_step_ = std::max(largest_step_, last_.step);
    return true;
}

template <cageform::Scalar T, std::size_t D>
std::string PinnedCage<T, D>::report() const {
    const auto& samples = solver_.samples();
    using detail::counted;
    std::ostringstream text;
    text.precision(3);
    text << "pins: " << pins_.size() << ", held: " << held_ << " of "
         << counted(samples.handle_count(), "handle") << "\nsamples: " << samples.points.size() << " in "
         << counted(samples.cluster_count, "cluster") << ", " << double(samples.bytes()) / 1000 << " kB, "
         << sampling_ms_ << " ms\nposes: " << poses_ << ", " << counted(frames_, "frame") << " of "
         << counted(iterations_, "iteration") << ", " << solving_ms_ << " ms, the first frame " << first_ms_
         << " ms after the pins\n";
    constexpr std::size_t most_listed_pins = 20;
    for (std::size_t n = 0; n < std::min(pins_.size(), most_listed_pins); ++n)
        text << name_of(pins_, n) << ": " << describe_target(pins_[n]) << '\n';
    if (last_.missed < pins_.size())
        text << "largest miss: " << last_.miss << ", " << name_of(pins_, last_.missed) << '\n';
    text << "stretch: " << last_.least_stretch << " to " << last_.largest_stretch
         << " in the mean of a cluster, " << last_.folded << " folded\n";
    if (last_.weak_handles > 0) text << "handles with negligible stiffness: " << last_.weak_handles << '\n';
    return text.str();
}

template <cageform::Scalar T, std::size_t D>
std::string PinnedCage<T, D>::warning() const {
    std::string text;
    if (folded_ > 0)
        text = "pins fold the figure, in " + std::to_string(folded_) + " of " +
               std::to_string(solver_.samples().cluster_count) +
               " parts: move them less, or lower --pin-weight if there are many";
    if (unsettled_ == 0) return text;
    return text + (text.empty() ? "" : "; ") +
           (poses_ == 1
                ? "the pose by pins has"
                : std::to_string(unsettled_) + " of " + std::to_string(poses_) + " poses by pins have") +
           " not converged after " + std::to_string(detail::most_frames) +
           " iterations: a vertex still moves by " + detail::short_number(largest_step_) + " per iteration";
}

} // namespace cageform_support
