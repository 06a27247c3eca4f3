// How large are the errors of harmonic weights in 3D next to the skin and inside, by cage and accuracy?
// References are computed by walk on spheres (tests/support/walk_on_spheres.hpp); --keep stores them in a
// folder, in the format of examples/sources/tables/convergence.cpp.
//
//     bench_skin [--cage NAME] [--obj FILE] [--points COUNT] [--walks COUNT] [--keep FOLDER] [ACCURACY…]
//     bench_skin --obj CAGE --figure FILE --pose CAGE [ACCURACY…]
//     bench_skin --obj CAGE --figure FILE --joints COUNT
//
// The second form prints the distances of a posed figure's points from those at the last accuracy. The third
// twists the cage by 80 degrees about each axis and prints the loss of skins with COUNT joints per vertex.
// The loss is the 99th percentile of the faces' rotation errors, and the maximum distance. Compile with -I of
// another version's headers to measure that version at the same points.
#include "../tests/support/walk_on_spheres.hpp"
#include "named_cages.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/smooth_skin_weights.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/parallel/threads.hpp>

#include <ctime>
#include <fstream>
#include <sstream>
#include <string>

namespace {

using Point = cageform::Vec<double, 3>;
using Mesh = cageform::TriangleMesh<double>;

using cageform_bench::NamedCage;

/// Weights of points by rows.
using Rows = std::vector<double>;

/// Reads rows from lines x,y,z;handle:weight;…; returns nothing if the file has other points or handles.
Rows kept_rows(const std::string& path, const std::vector<Point>& points, std::size_t handles) {
    Rows rows(points.size() * handles);
    std::ifstream file(path);
    std::size_t n = 0;
    for (std::string line; std::getline(file, line); ++n) {
        std::istringstream parts(line);
        char mark = 0;
        Point p{};
        double weight = 0;
        std::size_t handle = 0;
        parts >> p[0] >> mark >> p[1] >> mark >> p[2];
        if (n >= points.size() || p != points[n]) return {};
        while (parts >> mark >> handle >> mark >> weight) {
            if (handle >= handles) return {};
            rows[n * handles + handle] = weight;
        }
    }
    return n == points.size() ? rows : Rows{};
}
Rows references(const NamedCage& cage, const std::vector<Point>& points, std::uint64_t walks,
                const std::string& folder) {
    const std::size_t handles = cage.mesh.size();
    const std::string path =
        folder + "/" + cage.name + "_" + std::to_string(points.size()) + "_" + std::to_string(walks) + ".txt";
    if (auto kept = kept_rows(path, points, handles); !folder.empty() && !kept.empty()) return kept;
    Rows rows(points.size() * handles);
    cageform::ThreadedFor{}(points.size(), 1, [&](std::size_t n, std::size_t) {
        const auto found = cageform_tests::walk_on_spheres(cage.mesh, points[n], walks, n);
        std::copy(found.weight.begin(), found.weight.end(), rows.begin() + std::ptrdiff_t(n * handles));
    });
    if (folder.empty()) return rows;
    std::ofstream file(path);
    for (std::size_t n = 0; n < points.size(); ++n) {
        file.precision(17);
        file << points[n][0] << ',' << points[n][1] << ',' << points[n][2];
        file.precision(6);
        for (std::size_t i = 0; i < handles; ++i) {
            if (rows[n * handles + i] != 0) file << ';' << i << ':' << rows[n * handles + i];
        }
        file << '\n';
    }
    return rows;
}

void print(const char* where, std::vector<double> of_points, double asked) {
    const cageform_bench::Errors errors(std::move(of_points));
    std::printf("  %s: %.1e %.1e %.1e %.1e (%2.0f%%)", where, errors.at(1), errors.at(0.99), errors.at(0.9),
                errors.at(0.5), 100 * errors.share_beyond(asked));
}

/// Poses a figure with the weights of each accuracy.
int print_poses(const NamedCage& cage, const cageform_bench::ObjMesh& figure,
                const cageform_bench::ObjMesh& pose, const std::vector<double>& accuracies) {
    const double size = bounds_of(cage.mesh.vertices()).diagonal();
    std::vector<std::vector<Point>> posed;
    std::vector<double> seconds;
    for (const double accuracy : accuracies) {
        const auto start = std::clock();
        const cageform::HarmonicCoordinates<double, 3> coordinates(cage.mesh, {.accuracy = accuracy});
        const auto bound = cageform::bind(coordinates, figure.vertices);
        seconds.push_back(double(std::clock() - start) / CLOCKS_PER_SEC);
        auto& points = posed.emplace_back(figure.vertices.size());
        const auto status =
            bound ? cageform::clone(bound.value.view(), pose.vertices, points) : bound.status();
        if (status == cageform::Status::ok) continue;
        std::fprintf(stderr, "bench_skin: accuracy %g: %s\n", accuracy, to_string(status));
        return 1;
    }
    for (std::size_t k = 0; k < posed.size(); ++k) {
        std::vector<double> apart;
        for (std::size_t n = 0; n < posed[k].size(); ++n)
            apart.push_back(cageform::detail::length(posed[k][n] - posed.back()[n]) / size);
        std::sort(apart.begin(), apart.end());
        std::printf(
            "%s, accuracy %g: %.2f s, posed points differ by %.1e of the cage at most, 90 %% by %.1e\n",
            cage.name.c_str(), accuracies[k], seconds[k], apart.back(), apart[apart.size() * 9 / 10]);
    }
    return 0;
}

/// A cage twisted about an axis by 80 degrees from end to end.
std::vector<Point> twisted(std::span<const Point> rest, std::size_t axis) {
    const auto bounds = cageform::bounds_of(rest);
    const double length = bounds.upper[axis] - bounds.lower[axis];
    std::vector<Point> pose;
    for (Point p : rest) {
        const double angle = 80 / 57.295779513 * (p[axis] - bounds.lower[axis]) / length;
        double &x = p[(axis + 1) % 3], &y = p[(axis + 2) % 3];
        const double before = x;
        x = std::cos(angle) * before - std::sin(angle) * y;
        y = std::sin(angle) * before + std::cos(angle) * y;
        pose.push_back(p);
    }
    return pose;
}

/// Prints the errors of skins in twists: fitted per vertex, and together.
int print_skins(const NamedCage& cage, const cageform_bench::ObjMesh& figure, std::size_t joints) {
    const auto bound = cageform::bind(cageform::HarmonicCoordinates<double, 3>(cage.mesh), figure.vertices);
    const cageform::SkinWeightsOptions options{.influences = joints};
    for (const bool together : {false, true}) {
        const auto start = std::clock();
        const auto skin = together ? cageform::smooth_skin_weights(bound.value, figure.faces, options)
                                   : cageform::skin_weights(bound.value, options);
        const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
        const auto status = bound ? skin.status() : bound.status();
        if (status != cageform::Status::ok) {
            std::fprintf(stderr, "bench_skin: a skin of %zu joints: %s\n", joints, to_string(status));
            return 1;
        }
        const auto played = cageform::skin_to_binding(bound.value, skin.value);
        std::printf("%2zu joints, %s, %.2f s:", joints, together ? "together" : "alone", seconds);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto pose = twisted(cage.mesh.vertices(), axis);
            std::vector<Point> right(figure.vertices.size()), moved(right);
            if (clone(bound.value, pose, right) != cageform::Status::ok ||
                clone(played.value, pose, moved) != cageform::Status::ok)
                return 1;
            double farthest = 0;
            for (std::size_t i = 0; i < right.size(); ++i)
                farthest = std::fmax(farthest, cageform::detail::length(moved[i] - right[i]));
            std::vector<double> turns;
            for (const auto& face : figure.faces) {
                const auto normal = [&](const std::vector<Point>& places) {
                    const auto corner = [&](std::size_t k) { return places[std::size_t(face[k])]; };
                    return cross(corner(1) - corner(0), corner(2) - corner(0));
                };
                turns.push_back(cageform_bench::degrees_between(normal(right), normal(moved)));
            }
            std::sort(turns.begin(), turns.end());
            const double turn = turns.empty() ? 0 : turns[std::size_t(0.99 * double(turns.size()))];
            std::printf("  %c %.1f degrees, %.3f", "xyz"[axis], turn, farthest);
        }
        std::printf("\n");
    }
    return 0;
}

/// Prints the time, the memory and the errors of harmonic coordinates.
///
///   count   of the points, those below faces; the others are inside
///   known   reference weights, #points · #vertices
void print_errors(const NamedCage& cage, const std::vector<Point>& points, std::size_t count,
                  const std::vector<double>& known, double accuracy) {
    const auto start = std::clock();
    const cageform::HarmonicCoordinates<double, 3> coordinates(cage.mesh, {.accuracy = accuracy});
    const auto bound = cageform::bind(coordinates, points);
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    std::vector<double> skin, inside;
    for (std::size_t n = 0; n < points.size(); ++n) {
        double worst = 0;
        for (std::size_t i = 0; i < cage.mesh.size(); ++i)
            worst = std::fmax(worst, std::fabs(bound.value.weight(n, i) - known[n * cage.mesh.size() + i]));
        (n < count ? skin : inside).push_back(worst);
    }
    const auto& solver = bound.report.solver;
    std::printf("%6g %7zu nodes %5.2f s %4.0f MB", accuracy, solver.cells, seconds,
                double(solver.bytes) / 1e6);
    print("skin", skin, accuracy);
    print("inside", inside, accuracy);
    std::printf("  restored %.1e, estimate %.1e, factor %.2f\n", bound.report.weight_change.value,
                solver.grid_error(), solver.multigrid.convergence_factor);
}

} // namespace

int main(int argc, char** argv) {
    std::string folder;
    std::size_t count = 200, joints = 0;
    std::uint64_t walks = 100000;
    std::vector<double> accuracies;
    cageform_bench::ObjMesh figure, pose;
    cageform_bench::CommandLine line("bench_skin", argc, argv);
    while (line.next()) {
        if (line.word() == "--figure")
            figure = line.mesh();
        else if (line.word() == "--pose")
            pose = line.mesh();
        else if (line.word() == "--joints")
            joints = line.number<std::size_t>();
        else if (line.word() == "--points")
            count = line.number<std::size_t>();
        else if (line.word() == "--walks")
            walks = line.number<std::uint64_t>();
        else if (line.word() == "--keep")
            folder = line.value();
        else
            accuracies.push_back(line.accuracy());
    }
    if (accuracies.empty()) accuracies = {1e-2, 5e-3, 2e-3, 1e-3};
    const auto list = line.cages();
    const bool one = list.size() == 1 && !figure.vertices.empty();
    if (joints > 0) {
        if (one) return print_skins(list[0], figure, joints);
        line.refuse("--joints needs one cage and --figure");
    }
    if (!figure.vertices.empty() || !pose.vertices.empty()) {
        if (one && pose.vertices.size() == list[0].mesh.size())
            return print_poses(list[0], figure, pose, accuracies);
        line.refuse("--figure and --pose need one cage, and a pose with the same number of vertices");
    }
    for (const NamedCage& cage : list) {
        auto points = cageform_tests::points_below_faces(cage.mesh, count, 17);
        const auto deep = cageform_tests::points_anywhere(cage.mesh, count, 18);
        points.insert(points.end(), deep.begin(), deep.end());
        const auto known = references(cage, points, walks, folder);
        std::printf("%s: %zu handles; standard error of a reference at most %.1e; max, 99 %%, 90 %%, median "
                    "(share of points over the accuracy)\n",
                    cage.name.c_str(), cage.mesh.size(), 0.5 / std::sqrt(double(walks)));
        for (const double accuracy : accuracies) print_errors(cage, points, count, known, accuracy);
    }
}
