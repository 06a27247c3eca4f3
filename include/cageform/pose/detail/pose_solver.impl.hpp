// Definitions of PoseSolver. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/pose/pose_solver.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
PoseSolver<T, D>::PoseSolver(PoseSamples<T, D> samples, const PoseOptions& options)
    : samples_(std::move(samples))
    , options_(options) {
    status_ = detail::guard_memory([&] { return begin(); });
}

template <Scalar T, std::size_t D>
template <class Set>
Status PoseSolver<T, D>::change_system(const Set& set) {
    culprit_ = PoseSolverReport::none;
    if (status_ != Status::ok) return status_;
    return detail::guard_memory([&] {
        detail::PoseSystem<T, D> system;
        Status status = set(system);
        if (status == Status::ok) status = system.factor(samples_, options_.hard_pins, culprit_);
        if (status == Status::ok) take(std::move(system));
        return status;
    });
}

template <Scalar T, std::size_t D>
Status PoseSolver<T, D>::set_pins(const PosePins<T, D>& pins) {
    return change_system([&](detail::PoseSystem<T, D>& system) {
        system.held = system_.held;
        return system.pins.read(samples_, pins, options_.pin_weight, culprit_);
    });
}

template <Scalar T, std::size_t D>
Status PoseSolver<T, D>::set_held(std::span<const std::uint32_t> handles) {
    return change_system([&](detail::PoseSystem<T, D>& system) {
        system.pins = system_.pins;
        std::vector<bool> is_held(samples_.handle_count(), false);
        for (const std::uint32_t h : handles) {
            culprit_ = h;
            if (h >= samples_.handle_count()) return Status::index_out_of_range;
            is_held[h] = true;
        }
        culprit_ = PoseSolverReport::none;
        for (std::size_t h = 0; h < is_held.size(); ++h) {
            if (is_held[h]) system.held.push_back(std::uint32_t(h));
        }
        return Status::ok;
    });
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::reset() noexcept {
    frame_ = {};
    displacements_.clear();
    pass_.forget();
    is_new_ = true;
    remember_pose();
}

template <Scalar T, std::size_t D>
Status PoseSolver<T, D>::begin() {
    const std::size_t count = handle_count();
    if (count > samples_.most_handles) return Status::too_many_handles;
    if (count == 0 || samples_.cluster_count == 0) return Status::samples_missing;
    for (auto* vectors : {&displacements_, &kept_, &right_, &last_}) vectors->reset(count);
    sample_displacements_.resize(count);
    pass_.reset(samples_);
    stiffness_begin_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        stiffness_begin_[i] = stiffness_.size();
        stiffness_.resize(stiffness_.size() + block_count<double>(i + 1));
        for (std::size_t j = 0; j < block_count<double>(i + 1) * lane_count<double>; ++j)
            stiffness_[stiffness_begin_[i] + j / lane_count<double>][j % lane_count<double>] =
                j > i ? 0 : (j == i ? 1 : 2) * samples_.stiffness_of(i, j);
    }
    detail::PoseSystem<T, D> system;
    const Status status = system.factor(samples_, false, culprit_);
    if (status == Status::ok) take(std::move(system));
    return status;
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::take(detail::PoseSystem<T, D>&& system) {
    detail::AxisVectors<D> from, to;
    from.reset(system.unknowns.size());
    to.reset(system.unknowns.size());
    std::vector<Vec<double, D>> offsets(system.pins.rows.size()), demands(system.pins.rows.size());
    detail::Anderson anderson;
    anderson.reset(D * from.blocks(), options_.history);
    from_ = std::move(from);
    to_ = std::move(to);
    offsets_ = std::move(offsets);
    demands_ = std::move(demands);
    anderson_ = std::move(anderson);
    system_ = std::move(system);
    is_new_ = true;
    if (!system_.held.empty()) leave_frame();
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::leave_frame() noexcept {
    for (std::size_t i = 0; i < handle_count(); ++i) displacements_.set(i, moved(i));
    frame_ = {};
    pass_.forget();
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::remember_pose() noexcept {
    for (std::size_t i = 0; i < handle_count(); ++i) last_.set(i, moved(i));
}

template <Scalar T, std::size_t D>
Status PoseSolver<T, D>::check(std::size_t targets, std::size_t pose, std::size_t turns) const noexcept {
    if (status_ != Status::ok) return status_;
    if (targets != system_.pins.pins) return Status::pins_do_not_match;
    const bool may_turn = turns == 0 ? !system_.pins.has_turns : turns == targets;
    if (!may_turn) return Status::pins_do_not_match;
    return pose != handle_count() ? Status::pose_size_differs : Status::ok;
}

template <Scalar T, std::size_t D>
PoseSolverReport PoseSolver<T, D>::refused(PoseSolverReport& report, std::size_t culprit,
                                           const detail::RigidFrame<D>& frame) noexcept {
    displacements_.copy(kept_);
    frame_ = frame;
    is_new_ = true;
    report = {};
    report.status = Status::pose_not_finite;
    report.culprit = culprit;
    return report;
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::run(PoseSolverReport& report) noexcept {
    if (is_new_) {
        if (system_.held.empty()) align();
        anderson_.forget();
        is_new_ = false;
    }
    set_demands();
    detail::Stretches stretches;
    double energy = evaluate(options_.iterations == 0 ? &stretches : nullptr, report);
    for (std::size_t n = 0; n < options_.iterations; ++n) {
        detail::Stretches* const measured = n + 1 == options_.iterations ? &stretches : nullptr;
        gather(from_);
        system_.solve(right_, displacements_, demands_.data(), to_);
        ++report.iterations;
        if (anderson_.is_on()) {
            anderson_.step(from_.data(), to_.data());
            scatter(from_);
            stretches = {};
            const double accelerated = evaluate(measured, report);
            if (accelerated <= energy + 1e-15) {
                energy = accelerated;
                continue;
            }
            anderson_.forget();
        }
        scatter(to_);
        stretches = {};
        energy = evaluate(measured, report);
    }
    report.folded = stretches.folded;
    report.least_stretch = std::sqrt(stretches.least);
    report.largest_stretch = std::sqrt(stretches.largest);
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::align() noexcept {
    detail::RigidFit<D> fit;
    for (const bool is_first : {true, false}) {
        for (std::size_t r = 0; r < rows().size(); ++r) {
            const Row& row = rows()[r];
            const auto place = row.place + displacements_.product(weights_of(r));
            const auto target = row.place + offsets_[r];
            if (is_first && row.is_point()) fit.add_centre(place, target, row.weight);
            if (!is_first && row.is_point()) fit.add_point(place, target, row.weight);
            if (!is_first && !row.is_point()) fit.add_vector(place, target, row.weight);
        }
    }
    if (!is_at_rest()) fit.set(frame_);
}

template <Scalar T, std::size_t D>
bool PoseSolver<T, D>::is_at_rest() const noexcept {
    for (const auto& offset : offsets_) {
        if (!(offset == Vec<double, D>{})) return false;
    }
    for (std::size_t i = 0; i < handle_count(); ++i) {
        if (!(moved(i) == Vec<double, D>{})) return false;
    }
    return true;
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::set_demands() noexcept {
    for (std::size_t r = 0; r < rows().size(); ++r) {
        const Row& row = rows()[r];
        demands_[r] =
            frame_.rotate_back(offsets_[r] - row.points * frame_.shift) + frame_.change_back(row.place);
    }
}

template <Scalar T, std::size_t D>
double PoseSolver<T, D>::evaluate(detail::Stretches* stretches, PoseSolverReport& report) noexcept {
    for (std::size_t i = 0; i < handle_count(); ++i)
        sample_displacements_[i] = vec_cast<T>(displacements_.get(i));
    double turned = 0;
    right_.with_axes(
        [&](auto& axes) { turned = pass_.run(samples_, sample_displacements_.data(), axes, stretches); });
    report.rigid_energy = turned + strain();
    report.pin_energy = 0;
    report.miss = 0;
    report.missed = PoseSolverReport::none;
    for (std::size_t r = 0; r < rows().size(); ++r) {
        const Row& row = rows()[r];
        const auto miss = displacements_.product(weights_of(r)) - demands_[r];
        report.pin_energy += row.weight * dot(miss, miss);
        right_.add(weights_of(r), row.weight * demands_[r]);
        const double distance = samples_.size * std::sqrt(dot(miss, miss));
        if (!row.is_point() || (report.missed != PoseSolverReport::none && !(distance > report.miss)))
            continue;
        report.miss = distance;
        report.missed = row.pin;
    }
    for (std::size_t k = 0; k < D; ++k) {
        for (std::size_t b = 0; b < right_.blocks(); ++b) {
            const auto d = detail::Simd<double>::load(displacements_.axis(k)[b]);
            detail::multiply_add(detail::Simd<double>(system_.proximity), d,
                                 detail::Simd<double>::load(right_.axis(k)[b]))
                .store(right_.axis(k)[b]);
        }
    }
    return report.rigid_energy + report.pin_energy;
}

template <Scalar T, std::size_t D>
double PoseSolver<T, D>::strain() const noexcept {
    detail::Simd<double> sum(0);
    for (std::size_t i = 0; i < handle_count(); ++i) {
        const Lanes<double>* const row = &stiffness_[stiffness_begin_[i]];
        const auto d = displacements_.get(i);
        for (std::size_t b = 0; b < block_count<double>(i + 1); ++b) {
            detail::Simd<double> part(0);
            for (std::size_t k = 0; k < D; ++k)
                part = detail::multiply_add(detail::Simd<double>(d[k]),
                                            detail::Simd<double>::load(displacements_.axis(k)[b]), part);
            sum = detail::multiply_add(part, detail::Simd<double>::load(row[b]), sum);
        }
    }
    return detail::ordered_sum(sum);
}

template <Scalar T, std::size_t D>
void PoseSolver<T, D>::finish(PoseSolverReport& report) noexcept {
    double square = 0;
    for (std::size_t i = 0; i < handle_count(); ++i) {
        const auto step = moved(i) - last_.get(i);
        square = dot(step, step) > square ? dot(step, step) : square;
    }
    report.step = samples_.size * std::sqrt(square);
    report.settled = !(report.step > options_.settled_step * samples_.size);
    report.weak_handles = samples_.weak_handles.size();
    remember_pose();
}

} // namespace cageform::inline CAGEFORM_ABI
