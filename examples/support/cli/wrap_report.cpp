#include "cli/wrap_report.hpp"

#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cmath>
#include <numbers>

namespace cageform_support {

namespace {

using detail::short_number;

/// The number, from 1, of the file's vertex at a place of a surface.
std::size_t vertex_at(const WeldedMesh& mesh, std::size_t place) {
    return place < mesh.first.size() ? std::size_t{mesh.first[place]} + 1 : 0;
}

std::string describe_size(const char* what, const MeshFile& file, const WeldedMesh& surface) {
    return std::string(what) + ": " + printable(file.name) + ", " + std::to_string(surface.places.size()) +
           " vertices, " + std::to_string(surface.triangles.size()) + " triangles\n";
}

/// "alignment: scale 1.2, turn 12 degrees, shift (0, 1, 0)".
std::string describe_alignment(const cageform::Transform<double, 3>& first) {
    const auto& [a, b, c] = first.columns;
    const double scale = std::cbrt(dot(a, cross(b, c)));
    const double cosine = ((a[0] + b[1] + c[2]) / scale - 1) / 2;
    const double turn = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
    const Point3& shift = first.translation;
    return "alignment: scale " + short_number(scale) +
           (turn > 1e-4 ? ", turn " + short_number(turn) + " degrees" : "") + ", shift (" +
           short_number(shift[0]) + ", " + short_number(shift[1]) + ", " + short_number(shift[2]) + ")\n";
}

std::string table_of_steps(const cageform::WrapReport& report) {
    std::string text = "basis  handles  stiffness  iterations  rms, %  held places  kept\n";
    for (const auto& step : report.steps) {
        const std::string basis = step.cells == 0 ? "cage" : "1/" + std::to_string(step.cells);
        text += formatted("%5s  %7zu  %9.0e  %10zu  %6.3f  %11zu  %.3f\n", basis.c_str(), step.handles,
                          step.stiffness, step.iterations, 100 * step.residual, step.held, step.kept);
    }
    return text;
}

std::string row_of(const char* name, const cageform::SurfaceDistance& distance, double height,
                   std::size_t vertex) {
    return formatted("%-16s  %8.4f  %8.4f  %10.4f  %10.4g  %10.4g  %10.4g%s\n", name, 100 * distance.mean,
                     100 * distance.upper, 100 * distance.largest, height * distance.mean,
                     height * distance.upper, height * distance.largest,
                     vertex == 0 ? "" : (" at v " + std::to_string(vertex)).c_str());
}

std::string table_of_distances(const cageform::WrapReport& report, const WrapFigures& figures) {
    const double height = report.height;
    const auto of_source = [&](const auto& d) { return vertex_at(figures.source_surface, d.farthest); };
    return "distance           mean, %   95 %, %  largest, %        mean        95 %     largest\n" +
           row_of("after alignment", report.start, height, of_source(report.start)) +
           row_of("source to target", report.to_target, height, of_source(report.to_target)) +
           row_of("target to source", report.to_source, height,
                  vertex_at(figures.target_surface, report.to_source.farthest));
}

std::string end_of(cageform::WrapReport::End ended) {
    switch (ended) {
    case cageform::WrapReport::End::stages: return "all steps are done";
    case cageform::WrapReport::End::residual: return "the distance of --residual is reached";
    case cageform::WrapReport::End::noise: return "the distance is that of the target's noise";
    case cageform::WrapReport::End::fold: return "the next step would fold space";
    }
    return {};
}

bool has_miss(const cageform::WrapReport& report, const Landmarks& landmarks) {
    return report.missed < landmarks.names.size();
}

} // namespace

std::string percent_of(double share) {
    return formatted("%.3g %%", 100 * share);
}

std::string describe(const cageform::SurfaceDistance& distance, std::size_t vertex) {
    return percent_of(distance.mean) + " of the target's height in the mean, " + percent_of(distance.upper) +
           " (95 %), at most " + percent_of(distance.largest) + " at v " + std::to_string(vertex);
}

std::string describe(const WrapMap& map, const WrapFigures& figures) {
    const auto& report = map.report;
    const auto folded = [](const char* what, std::size_t count, std::size_t all) {
        return std::to_string(count) + " of " + std::to_string(all) + what;
    };
    std::string text = describe_size("source", figures.source, figures.source_surface) +
                       describe_size("target", figures.target, figures.target_surface) +
                       "height of the target: " + short_number(report.height) + '\n';
    text += describe_alignment(report.alignment) + table_of_steps(report) +
            table_of_distances(report, figures) + "unmatched: " + percent_of(report.unmatched_source) +
            " of the source, " + percent_of(report.unmatched_target) +
            " of the target\nnoise of the target: " +
            (report.noise > 0 ? percent_of(report.noise) : "below 0.1 %") + '\n';
    if (report.skipped_faces > 0)
        text += "faces of the target without area: " + std::to_string(report.skipped_faces) + '\n';
    if (has_miss(report, figures.landmarks))
        text += "landmarks: " + std::to_string(figures.landmarks.marks.size()) + ", largest miss " +
                percent_of(report.miss) + " at " + printable(figures.landmarks.name(report.missed)) + '\n';
    return text +
           "folds: " + folded(" vertices, ", report.folded_vertices, figures.source_surface.places.size()) +
           folded(" points that follow, ", report.folded_followers, figures.follow.size()) +
           folded(" samples", report.folded_samples, report.samples) +
           "\nstretch: " + short_number(report.least_stretch) + " to " +
           short_number(report.largest_stretch) + "\nended: " + end_of(report.ended) + ", after " +
           formatted("%.1f s\n", report.seconds);
}

std::vector<std::string> warnings_of(const WrapMap& map, const WrapFigures& figures) {
    constexpr double many = 0.1, far_off = 0.01;
    const auto& report = map.report;
    std::vector<std::string> warnings;
    std::string unmatched;
    for (const bool of_target : {false, true}) {
        const double share = of_target ? report.unmatched_target : report.unmatched_source;
        if (share > 0)
            unmatched += (unmatched.empty() ? "" : " and ") + percent_of(share) + " of " +
                         (of_target ? figures.target : figures.source).name;
    }
    const std::string remedy =
        map.keeps_place
            ? ": leave out --no-align, or move the source onto the target first"
            : ": do both have the same up and front, and the same pose? Landmarks align them (--landmark)";
    if (report.status == cageform::Status::fit_not_reached)
        warnings.push_back(std::string(cageform::to_string(report.status)) + "; " + unmatched + " have none" +
                           remedy);
    else if (report.to_target.mean > far_off)
        warnings.push_back(figures.source.name + " is " + percent_of(report.to_target.mean) +
                           " of the target's height from the target in the mean" + remedy);
    else if ((report.unmatched_source > many && report.to_target.upper > far_off) ||
             (report.unmatched_target > many && report.to_source.upper > far_off))
        warnings.push_back("no match was found for " + unmatched +
                           ": these parts may be missing in the other figure, or need landmarks");
    if (report.to_target.mean > 0 && report.to_target.mean == report.start.mean)
        warnings.push_back(figures.source.name +
                           (map.keeps_place ? " is unchanged" : " is only scaled and shifted") +
                           ": the search found nothing closer");
    if (report.left_out > 0)
        warnings.push_back("lattices with " + std::to_string(report.left_out) +
                           " or more cells along the height are left out: they need more than " +
                           std::to_string(cageform::WrapOptions{}.handles) + " handles");
    if (report.far_followers > 0)
        warnings.push_back(
            "farther from the source than its height: " + std::to_string(report.far_followers) + " of " +
            std::to_string(figures.follow.size()) + " points that follow; nothing limits how far they move");
    const std::size_t folds = report.folded_vertices + report.folded_followers + report.folded_samples;
    if (folds > 0)
        warnings.push_back("the map folds space at " + std::to_string(report.folded_vertices) +
                           " vertices, " + std::to_string(report.folded_followers) + " points that follow, " +
                           std::to_string(report.folded_samples) + " samples");
    if (has_miss(report, figures.landmarks) && report.miss > far_off)
        warnings.push_back(figures.landmarks.name(report.missed) + " is missed by " +
                           percent_of(report.miss) +
                           " of the target's height: it may contradict other landmarks or the surfaces");
    return warnings;
}

} // namespace cageform_support
