// Fills the reports of the C interface from those of the library.
#pragma once

#include <cageform/animate/types/track_options.hpp>
#include <cageform/binding/types/figure_binding.hpp>
#include <cageform/binding/types/pack_options.hpp>
#include <cageform/binding/types/pose_sample_options.hpp>
#include <cageform/c/detail/messages.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>
#include <cageform/fit/types/wrap.hpp>
#include <cageform/parallel/running.hpp>
#include <cageform/skeleton/types/skeleton_options.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// The kinds of the elements that the indices of a fault refer to.
struct FaultElements {
    std::uint32_t a, b;
};
constexpr FaultElements elements_of(CageFaultKind kind) noexcept {
    using Kind = CageFaultKind;
    switch (kind) {
    case Kind::vertex_not_finite:
    case Kind::radius_not_positive:
    case Kind::interior_cell_outside:
    case Kind::vertex_not_convex:
    case Kind::disk_too_small:
    case Kind::collinear_vertex:
    case Kind::vertex_unused:
    case Kind::vertex_not_manifold: return {CAGEFORM_VERTEX, CAGEFORM_NO_ELEMENT};
    case Kind::duplicate_vertices:
    case Kind::interior_cells_touch:
    case Kind::open_edge:
    case Kind::edge_not_manifold:
    case Kind::gap_closed: return {CAGEFORM_VERTEX, CAGEFORM_VERTEX};
    case Kind::edges_cross: return {CAGEFORM_EDGE, CAGEFORM_EDGE};
    case Kind::curve_degree:
    case Kind::edge_has_cusp: return {CAGEFORM_EDGE, CAGEFORM_NO_ELEMENT};
    case Kind::no_area:
    case Kind::loop_orientation_reversed: return {CAGEFORM_LOOP, CAGEFORM_NO_ELEMENT};
    case Kind::loop_not_closed: return {CAGEFORM_LOOP, CAGEFORM_EDGE};
    case Kind::face_not_planar:
    case Kind::face_crosses_itself:
    case Kind::face_fan_folds: return {CAGEFORM_FACE, CAGEFORM_VERTEX};
    case Kind::face_flipped:
    case Kind::faces_cross: return {CAGEFORM_FACE, CAGEFORM_FACE};
    case Kind::no_volume:
    case Kind::face_without_vertex:
    case Kind::face_without_area:
    case Kind::face_fanned:
    case Kind::shell_orientation_reversed: return {CAGEFORM_FACE, CAGEFORM_NO_ELEMENT};
    default: return {CAGEFORM_NO_ELEMENT, CAGEFORM_NO_ELEMENT};
    }
}
inline cageform_fault fault_of(const CageFault& fault) noexcept {
    const auto [a, b] = elements_of(fault.kind);
    return {code_of(status_of(fault.kind)), a, b, 0, fault.a, fault.b, to_string(fault.kind)};
}

inline void fill(cageform_report& report, const CageReport& cage) noexcept {
    report.faults = static_cast<std::uint32_t>(cage.fault_count);
    report.warnings = 0;
    const CageFault* first = nullptr;
    for (const auto& fault : cage.faults) {
        const bool is_warning = status_of(fault.kind) == Status::ok;
        report.warnings += is_warning ? 1 : 0;
        const bool is_first_fault = !is_warning && (first == nullptr || status_of(first->kind) == Status::ok);
        if (first == nullptr || is_first_fault) first = &fault;
    }
    if (first != nullptr) report.fault = fault_of(*first);
}
inline void fill(cageform_report& report, const SolverReport& solver) {
    report.unknowns = solver.cells;
    report.memory = solver.bytes;
    report.grid_error = solver.grid_error();
    report.sufficient_accuracy = solver.sufficient_accuracy;
    if (solver.culprit != SolverReport::none) report.culprit = solver.culprit;
    if (solver.unseen_handle != SolverReport::none) report.culprit = solver.unseen_handle;
}
inline void fill(cageform_report& report, const BindReport& bound) {
    fill(report, bound.cage);
    fill(report, bound.solver);
    report.points = bound.points;
    report.on_boundary = bound.on_boundary.size();
    report.outside = bound.outside.size();
    report.faded = bound.faded.size();
    report.not_finite = bound.not_finite.size();
    report.unreached = bound.unreached.size();
    report.not_restored = bound.not_restored.size();
    report.partition_error = bound.partition_error.value;
    report.reproduction_error = bound.reproduction_error.value;
    report.least_weight = bound.least_weight.value;
    report.amplification = bound.amplification.value;
}
inline void fill(cageform_report& report, const FigurePackReport& packed) noexcept {
    report.bytes = packed.bytes;
    report.dense_bytes = packed.points.dense_bytes;
    report.points = packed.points.points;
    report.distance = packed.points.distance.value;
    report.mean_distance = packed.points.mean_distance;
    if (packed.culprit == FigureTags::clips)
        report.culprit = packed.culprit_clip;
    else if (packed.points.culprit != Extreme::none)
        report.culprit = packed.points.culprit;
}
inline void fill(cageform_report& report, const MakeCageReport& made) noexcept {
    fill(report, made.cage);
    if (made.status != Status::ok) report.culprit = made.culprit;
    report.vertices = made.vertices;
    report.components = made.components;
    report.tunnels = made.tunnels;
    report.margin = made.margin;
    report.clearance = made.clearance;
    report.volume = made.area;
    report.tightest_volume = made.tightest_area;
    report.least_angle = made.least_angle;
}
/// `frames` is the number of frames; a larger frame index means the rest pose.
inline void fill(cageform_report& report, const SkeletonReport& fitted, std::size_t frames) noexcept {
    if (fitted.status == Status::ok || fitted.status == Status::frame_not_finite) {
        report.culprit = fitted.vertex;
        report.frame = fitted.frame < frames ? fitted.frame : CAGEFORM_NONE;
    }
    report.bones = fitted.bones;
    report.beyond = fitted.beyond;
    report.rms = fitted.rms;
    report.max_distance = fitted.max_distance;
    report.turn = fitted.turn;
    report.mean_influences = fitted.mean_influences;
    report.seconds = fitted.seconds;
}
inline void fill(cageform_report& report, const WrapReport& fitted) noexcept {
    report.culprit = fitted.culprit != WrapReport::none ? fitted.culprit : fitted.missed;
    report.of_target = fitted.of_target ? 1 : 0;
    report.miss = fitted.miss;
    report.samples = fitted.samples;
    for (const auto& step : fitted.steps) report.iterations += step.iterations;
    report.folded = fitted.folded_vertices + fitted.folded_followers + fitted.folded_samples;
    report.least_stretch = fitted.least_stretch;
    report.largest_stretch = fitted.largest_stretch;
    report.height = fitted.height;
    report.start = fitted.start.mean;
    report.to_target_mean = fitted.to_target.mean;
    report.to_target_upper = fitted.to_target.upper;
    report.to_target_largest = fitted.to_target.largest;
    report.to_source_mean = fitted.to_source.mean;
    report.to_source_upper = fitted.to_source.upper;
    report.to_source_largest = fitted.to_source.largest;
    report.unmatched_source = fitted.unmatched_source;
    report.unmatched_target = fitted.unmatched_target;
    report.noise = fitted.noise;
    report.skipped_faces = fitted.skipped_faces;
    report.left_out = fitted.left_out;
    report.far_followers = fitted.far_followers;
    report.ended = static_cast<std::uint32_t>(fitted.ended);
    report.seconds = fitted.seconds;
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
