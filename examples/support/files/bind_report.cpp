#include "files/bind_report.hpp"

#include "io/csv.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <unordered_map>

namespace cageform_support {

int numbers_of(cageform::CageFaultKind kind) {
    using Kind = cageform::CageFaultKind;
    switch (kind) {
    case Kind::degenerate_simplex:
    case Kind::sites_in_a_plane:
    case Kind::falloff_negative:
    case Kind::no_volume: // the index of an axis is used only for boxes, which no program reads
        return 0;
    case Kind::vertex_not_finite:
    case Kind::no_area:
    case Kind::face_without_vertex:
    case Kind::face_without_area:
    case Kind::vertex_not_manifold:
    case Kind::radius_not_positive:
    case Kind::interior_cell_outside:
    case Kind::interior_cells_not_supported:
    case Kind::face_divisions:
    case Kind::face_fanned:
    case Kind::vertex_not_convex:
    case Kind::bone_axes_dependent:
    case Kind::frame_not_finite:
    case Kind::frame_flat:
    case Kind::disk_too_small:
    case Kind::collinear_vertex:
    case Kind::vertex_unused:
    case Kind::loop_orientation_reversed:
    case Kind::shell_orientation_reversed: return 1;
    default: return 2;
    }
}

std::string describe_fault(const cageform::CageFault& fault) {
    const int count = numbers_of(fault.kind);
    std::string text = cageform::to_string(fault.kind);
    if (count > 0) text += " (" + std::to_string(fault.a);
    if (count > 1) text += ", " + std::to_string(fault.b);
    return count > 0 ? text + ")" : text;
}

std::string describe_faults(const std::string& name, const cageform::BindReport& report) {
    std::string text = name + ": " + cageform::to_string(report.status);
    if (report.solver.unseen_handle != report.solver.none) {
        text += " (vertex " + std::to_string(report.solver.unseen_handle) + ")";
        if (report.solver.sufficient_resolution != 0)
            text += "; --resolution " + std::to_string(report.solver.sufficient_resolution) + " resolves it";
    }
    if (report.status == cageform::Status::out_of_memory && report.solver.bytes != 0) {
        text += ": the grid takes " + detail::short_number(double(report.solver.bytes) / (1 << 30)) +
                " GiB, more than is allowed (--memory, by default half of what is free)";
        if (report.solver.sufficient_resolution != 0)
            text += "; --resolution " + std::to_string(report.solver.sufficient_resolution) + " fits";
        if (report.solver.sufficient_accuracy != 0) {
            std::ostringstream fits;
            fits << std::setprecision(2) << "; --accuracy " << report.solver.sufficient_accuracy << " fits";
            text += fits.str();
        }
        text += "; --coordinates mean-value and green need no grid";
    }
    std::size_t listed = 0;
    for (const auto& fault : report.cage.faults) {
        if (cageform::status_of(fault.kind) == cageform::Status::ok || listed == most_listed) continue;
        ++listed;
        text += "\n  " + describe_fault(fault);
        if (fault.kind == cageform::CageFaultKind::interior_cells_not_supported)
            text += ": --coordinates harmonic supports them";
    }
    if (report.cage.fault_count > listed)
        text += "\n  and " + std::to_string(report.cage.fault_count - listed) + " more";
    return text;
}

std::string describe_faults(const std::string& name, const cageform::CageReport& report) {
    cageform::BindReport refused;
    refused.cage = report;
    refused.status = report.status;
    return describe_faults(name, refused);
}

std::string describe_corners(const cageform::SolverReport& solver) {
    const auto worst = solver.worst_corner();
    if (worst.error <= worst.notable) return {};
    const auto more = std::count_if(solver.multigrid.corners.begin(), solver.multigrid.corners.end(),
                                    [](const auto& corner) { return corner.error > corner.notable; }) -
                      1;
    const auto& [i, j] = worst.handles;
    std::ostringstream text;
    text << std::setprecision(2) << "the grid is coarse for ";
    if (i == j) {
        text << "the corner at vertex " << i << " (counted from 0)";
    } else { // of an OBJ file
        text << "the edge between vertices " << i + 1 << " and " << j + 1
             << " (counted from 1, as in the file)";
    }
    if (more > 0) text << " and " << more << " more";
    text << ": weights there may be off by up to " << worst.error << " (an estimate)";
    if (worst.resolution != 0)
        text << "; less than " << worst.notable << " at --resolution " << worst.resolution;
    return text.str();
}

std::string describe_grid(const cageform::SolverReport& solver) {
    const auto& place = solver.tree.finest_position;
    std::ostringstream text;
    text << std::setprecision(2) << "smallest cell " << solver.tree.finest_size << ", caused by "
         << to_string(solver.tree.finest_reason) << " at " << std::setprecision(4) << place[0] << ' '
         << place[1];
    if (place[2] != 0) text << ' ' << place[2];
    if (solver.tree.grid_errors.empty()) return text.str();
    text << std::setprecision(2) << "; weights are off by up to " << solver.grid_error()
         << ", in nine of ten cells by less than " << solver.grid_error(0.9) << " (estimates)";
    return text.str();
}

void warn_of_coarse_grid(const std::string& cage, const cageform::SolverReport& solver) {
    const std::string text = describe_corners(solver);
    if (!text.empty()) warn(cage + ": " + text);
}

void add_batch(cageform::BindReport& total, const cageform::BindReport& part, std::size_t first) {
    const auto append = [first](std::vector<std::size_t>& to, const std::vector<std::size_t>& from) {
        for (const std::size_t i : from) to.push_back(first + i);
    };
    append(total.on_boundary, part.on_boundary);
    append(total.outside, part.outside);
    append(total.faded, part.faded);
    append(total.not_finite, part.not_finite);
    append(total.unreached, part.unreached);
    append(total.not_restored, part.not_restored);
    const auto shifted = [first](cageform::Extreme extreme) {
        if (extreme.point != extreme.none) extreme.point += first;
        return extreme;
    };
    total.partition_error.raise(shifted(part.partition_error));
    total.reproduction_error.raise(shifted(part.reproduction_error));
    total.weight_change.raise(shifted(part.weight_change));
    total.residual_restored.raise(shifted(part.residual_restored));
    total.least_weight.lower(shifted(part.least_weight));
    total.amplification.raise(shifted(part.amplification));
    total.points += part.points;
    total.seconds += part.seconds;
    total.cage = part.cage;
}

/// Formats the report of a solver in up to three lines; empty if there was none.
static std::string describe_solver(const cageform::SolverReport& solver) {
    std::ostringstream text;
    if (solver.multigrid.cycles > 0) {
        text << "solver: " << solver.cells << " unknowns, " << solver.solves << " functions, "
             << solver.multigrid.cycles << " cycles, error " << solver.multigrid.error_estimate;
        if (solver.multigrid.error_bound > 0) text << " (never above " << solver.multigrid.error_bound << ")";
        text << ", convergence factor " << solver.multigrid.convergence_factor << ", "
             << double(solver.bytes) / 1048576 << " MiB, " << solver.seconds << " s\n";
        if (solver.tree.finest_size > 0) text << "grid: " << describe_grid(solver) << '\n';
        if (const std::string coarse = describe_corners(solver); !coarse.empty()) {
            text << "corners and edges: " << coarse << '\n';
        } else if (!solver.multigrid.corners.empty()) {
            text << "corners and edges: weights there are off by up to " << solver.worst_corner().error
                 << " (an estimate)\n";
        }
    }
    return text.str();
}

std::string describe(const cageform::BindReport& report) {
    std::ostringstream text;
    const auto list = [&](const char* what, const std::vector<std::size_t>& indices) {
        text << "  " << what << ": " << indices.size();
        for (std::size_t i = 0; i < std::min<std::size_t>(indices.size(), 8); ++i)
            text << (i == 0 ? " (" : ", ") << indices[i];
        if (!indices.empty()) text << (indices.size() > 8 ? ", …)" : ")");
        text << '\n';
    };
    text << "status: " << cageform::to_string(report.status) << '\n';
    const auto& faults = report.cage.faults;
    const std::size_t listed = std::min(faults.size(), most_listed);
    for (std::size_t i = 0; i < listed; ++i) text << "  cage: " << describe_fault(faults[i]) << '\n';
    const std::size_t warnings =
        faults.size() - std::min(report.cage.fault_count, cageform::CageReport::most_listed);
    const std::size_t count = warnings + report.cage.fault_count;
    if (count > listed) text << "  cage: and " << count - listed << " more\n";
    text << "points: " << report.points << '\n';
    list("on the boundary", report.on_boundary);
    list("outside", report.outside);
    if (!report.faded.empty()) list("outside, within the falloff", report.faded);
    list("not finite", report.not_finite);
    list("not reached by the solver", report.unreached);
    const auto extreme = [&](const char* what, const cageform::Extreme& value) {
        text << what << ": ";
        if (value.point == value.none)
            text << "no point bound\n";
        else
            text << value.value << " at point " << value.point << '\n';
    };
    extreme("largest |sum w - 1|", report.partition_error);
    extreme("largest |sum w c - p|", report.reproduction_error);
    extreme("least weight", report.least_weight);
    extreme("amplification (largest sum |w|)", report.amplification);
    text << "linear precision restored from: " << report.residual_restored.value
         << " (largest change of a weight " << report.weight_change.value << ")\n";
    if (!report.not_restored.empty())
        list("linear precision not fully restored, weights are too large (thin cage)", report.not_restored);
    text << describe_solver(report.solver);
    text << "time: " << report.seconds << " s\n";
    return text.str();
}

std::string describe(const PackingLoss& loss) {
    std::ostringstream text;
    text.precision(3);
    text << "at most " << loss.largest << " (" << 100 * loss.share() << " % of " << loss.size_of << "), at v "
         << loss.vertex + 1;
    if (loss.time) text << " after " << *loss.time << " s";
    text << ", " << loss.mean << " in the mean, in ";
    if (loss.poses > 0) {
        text << loss.poses << " poses of the motion";
    } else {
        text << "poses within " << loss.reach << ", a tenth of the cage's size, of an affine motion"
             << (loss.has_vectors ? ", vectors of its faces too" : "");
    }
    return text.str();
}

void print_warnings(std::span<const std::string> warnings) {
    struct Kind {
        std::string who, text; // label of the first element, may be empty; the message
        std::size_t count = 0;
    };
    std::vector<Kind> kinds;
    std::unordered_map<std::string, std::size_t> places; // in kinds, by text
    for (const std::string& warning : warnings) {
        const std::size_t end = warning.find("): "); // end of a label: rect "wall" (line 12)
        const bool has_label = end != std::string::npos;
        std::string who = has_label ? warning.substr(0, end + 1) : "",
                    text = has_label ? warning.substr(end + 3) : warning;
        const auto [place, is_new] = places.try_emplace(text, kinds.size());
        if (is_new) kinds.push_back({std::move(who), std::move(text), 0});
        ++kinds[place->second].count;
    }
    constexpr std::size_t most_kinds = 100;
    for (std::size_t i = 0; i < std::min(kinds.size(), most_kinds); ++i) {
        const auto& [who, text, count] = kinds[i];
        const std::string more = count > 1 ? " and " + std::to_string(count - 1) + " more" : "";
        warn(who.empty() ? text : who + more + ": " + text);
    }
    if (kinds.size() > most_kinds)
        warn("and " + std::to_string(kinds.size() - most_kinds) + " more kinds of warnings");
}

std::string name_points(std::span<const cageform::Vec<double, 3>> points,
                        const std::vector<std::size_t>& indices) {
    std::ostringstream text;
    for (std::size_t n = 0; n < std::min<std::size_t>(indices.size(), 3); ++n) {
        const auto& p = points[indices[n]];
        text << (n == 0 ? "" : ", ") << "v " << indices[n] + 1 << " (" << p[0] << ", " << p[1] << ", " << p[2]
             << ')';
    }
    if (indices.size() > 3) text << ", …";
    return text.str();
}

} // namespace cageform_support
