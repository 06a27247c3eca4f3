#include "cli/mesh_folds.hpp"

#include <cageform/clone/folds.hpp>

#include <algorithm>
#include <sstream>

namespace cageform_support {

namespace {

/// Merges the report of a batch of vertices into the total.
void add_report(cageform::FoldReport& total, const cageform::FoldReport& part, std::size_t first) {
    if (total.status == cageform::Status::ok) total.status = part.status;
    const std::size_t listed = std::min(part.count, part.folded.size());
    for (std::size_t n = 0; n < listed && total.count + n < total.folded.size(); ++n)
        total.folded[total.count + n] = first + part.folded[n];
    total.count += part.count;
    total.skipped += part.skipped;
    const auto keep = [first](double& kept, std::size_t& at, double value, std::size_t place, bool is_least) {
        if (place == cageform::FoldReport::nowhere) return;
        if (at != cageform::FoldReport::nowhere && !(is_least ? value < kept : value > kept)) return;
        kept = value;
        at = first + place;
    };
    keep(total.least_determinant, total.least_determinant_at, part.least_determinant,
         part.least_determinant_at, true);
    keep(total.least_stretch, total.least_stretch_at, part.least_stretch, part.least_stretch_at, true);
    keep(total.largest_stretch, total.largest_stretch_at, part.largest_stretch, part.largest_stretch_at,
         false);
}

} // namespace

void MeshFolds::add(const std::array<cageform::Binding<double, 3>, 3>& columns, std::span<const Point3> rest,
                    std::span<const Point3> pose, std::size_t first, const cageform::FoldOptions& options) {
    add_report(report, cageform::report_folds(columns, pose, options), first);
    const auto part = cageform::largest_step(columns, rest, pose, options);
    if (step.status == cageform::Status::ok) step.status = part.status;
    if (part.step < step.step) step = {step.status, part.step, first + part.culprit};
    places += columns[0].point_count();
}

MeshFolds folds_of_cells(const MeshFile& mesh, std::span<const Point3> moved,
                         const cageform::FoldOptions& options) {
    MeshFolds folds;
    folds.of_cells = true;
    folds.places = mesh.tetrahedra.size();
    folds.report = cageform::report_folds(mesh.vertices, moved, mesh.tetrahedra, options);
    folds.step = cageform::largest_step(mesh.vertices, mesh.vertices, moved, mesh.tetrahedra, options);
    return folds;
}

std::string MeshFolds::fault() const {
    if (!unknown.empty()) return unknown;
    for (const auto& [status, culprit] :
         {std::pair{report.status, report.culprit}, {step.status, step.culprit}}) {
        if (status == cageform::Status::ok) continue;
        return (culprit < places ? name_of(culprit) + ": " : "") + cageform::to_string(status);
    }
    return {};
}

std::string MeshFolds::name_of(std::size_t place) const {
    return (of_cells ? "tetrahedron " : "v ") + std::to_string(place + 1);
}

std::string describe(const MeshFolds& folds, bool stops) {
    if (const std::string why = folds.fault(); !why.empty()) return "folds: not known: " + why + '\n';
    const auto& report = folds.report;
    std::ostringstream text;
    text.precision(4);
    text << "folds: " << report.count << " of " << folds.places
         << (folds.of_cells ? " tetrahedra" : " vertices");
    const std::size_t listed = std::min<std::size_t>(report.count, 5);
    for (std::size_t n = 0; n < listed; ++n)
        text << (n == 0 ? ", first " : ", ") << folds.name_of(report.folded[n]);
    if (report.skipped > 0) text << "; " << report.skipped << " skipped, not finite";
    text << '\n';
    if (report.least_determinant_at == report.nowhere) return text.str();
    text << "least V'/V: " << report.least_determinant << ", " << folds.name_of(report.least_determinant_at)
         << "\nstretch: " << report.least_stretch << " (" << folds.name_of(report.least_stretch_at) << ") to "
         << report.largest_stretch << " (" << folds.name_of(report.largest_stretch_at)
         << ")\nlargest step without a fold: " << folds.step.step;
    if (folds.step.step < 1) text << ", then " << folds.name_of(folds.step.culprit) << " folds";
    return text.str() + (stops ? ": the figure stops there\n" : "\n");
}

Point3 on_the_way(const Point3& rest, const Point3& moved, double step) {
    return rest + step * (moved - rest);
}

} // namespace cageform_support
