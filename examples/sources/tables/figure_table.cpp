// Binds figures to their cages and prints a table of time, memory and accuracy.
//
//     figure_table FIGURE.svg CAGE.svg POSE.svg COORDINATES[,COORDINATES…] …

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/messages.hpp"
#include "svg/document.hpp"

#include <cageform/clone/clone.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <sstream>

namespace {

using namespace cageform_support;

/// Median seconds of a call, over `repeats` samples of `calls` calls each.
template <class F>
double median_seconds(int repeats, int calls, F&& f) {
    std::vector<double> samples;
    for (int r = 0; r < repeats; ++r) {
        const auto start = std::chrono::steady_clock::now();
        for (int c = 0; c < calls; ++c) f();
        samples.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
                          calls);
    }
    std::nth_element(samples.begin(), samples.begin() + repeats / 2, samples.end());
    return samples[std::size_t(repeats / 2)];
}

/// Prints one row; returns an error message, or empty.
std::string print_row(const std::string& figure_path, const std::string& cage_path,
                      const std::string& pose_path, const std::string& coordinates_name) {
    const auto document = load_svg(figure_path);
    if (!document) return to_string(document.error());
    const auto figure = figure_vertices(*document);
    if (!figure) return to_string(figure.error());
    CoordinatesChoice choice;
    choice.name = coordinates_name;
    const auto cage = load_cage(cage_path, choice.edges());
    if (!cage) return to_string(cage.error());
    const auto pose = load_pose(pose_path, *cage);
    if (!pose) return to_string(pose.error());
    const auto coordinates = make_coordinates<double>(choice, *cage);
    const auto [binding, report] = coordinates.bind(*figure);
    if (report.status != cageform::Status::ok) return describe_faults(cage_path, report);
    if (!report.outside.empty()) {
        return figure_path + ": " + std::to_string(report.outside.size()) + " points lie outside the cage " +
               cage_path;
    }
    std::string warning;
    const auto handles = pose_of_handles(binding, pose->vertices, pose_path, warning);
    if (!handles) return to_string(handles.error());
    const auto at_rest = pose_of_handles(binding, cage->vertices, cage_path, warning);
    if (!at_rest) return to_string(at_rest.error());
    warn(warning);
    const double bind_seconds = median_seconds(5, 1, [&] { (void)coordinates.bind(*figure); });
    std::vector<Point2> out(figure->size());
    cageform::Status status = cageform::Status::ok;
    const double clone_seconds =
        median_seconds(21, 100, [&] { status = cageform::clone(binding, *handles, out); });
    if (status != cageform::Status::ok) return cageform::to_string(status);
    if (cageform::clone(binding, *at_rest, out) != cageform::Status::ok || !(out == *figure)) {
        return figure_path + ": the rest pose is not exact";
    }
    std::printf("%-8s %-17s %6zu %8zu %9.3f %9.2f %15.1e %13.4f\n",
                printable(std::filesystem::path(figure_path).stem().string()).c_str(),
                coordinates_name.c_str(), binding.point_count(), binding.handle_count(), bind_seconds * 1e3,
                clone_seconds * 1e6, report.reproduction_error.value, report.least_weight.value);
    return {};
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Prints how long figures take to bind and clone, and how exact they are.");
    line.set_examples(
        {"cat.svg cat_cage.svg cat_pose.svg mean-value,harmonic",
         "cat.svg cat_cage.svg cat_pose.svg harmonic biped.svg biped_cage.svg biped_pose.svg mean-value"});
    std::vector<std::string> words;
    line.add("rows", words, "FIGURE.svg CAGE.svg POSE.svg COORDINATES[,COORDINATES…], repeatedly").required();
    CoordinatesChoice choice;
    choice.in_plane = choice.with_normals = true;
    const std::vector<std::string> names = choice.names();
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    line.set_footer("COORDINATES: " + known + "\n\n" + cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (words.size() % 4 != 0)
        return fail("arguments are FIGURE.svg CAGE.svg POSE.svg COORDINATES[,COORDINATES…], repeatedly");
    std::printf("%-8s %-17s %6s %8s %9s %9s %15s %13s\n", "figure", "coordinates", "points", "handles",
                "bind ms", "clone us", "max |Swc - p|", "least weight");
    for (std::size_t i = 0; i < words.size(); i += 4) {
        std::istringstream wanted(words[i + 3]);
        for (std::string name; std::getline(wanted, name, ',');) {
            std::string error;
            if (std::find(names.begin(), names.end(), name) == names.end())
                error = "\"" + name + "\" is not one of " + known;
            else
                error = print_row(words[i], words[i + 1], words[i + 2], name);
            fail_if(error);
        }
    }
    return 0;
}
