// How far off are harmonic weights in space next to the skin, and inside, by cage and accuracy?
// References are walks on spheres (tests/support/walk_on_spheres.hpp), which --keep stores in a folder.
//
//     bench_skin [--cage NAME] [--points COUNT] [--walks COUNT] [--keep FOLDER] [ACCURACY…]
#include "../tests/support/fingers.hpp"
#include "../tests/support/walk_on_spheres.hpp"
#include "workloads.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/core/threads.hpp>

#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>

namespace {

using Point = cageform::Vec<double, 3>;
using Mesh = cageform::TriangleMesh<double>;

struct NamedCage {
    std::string name;
    Mesh mesh;
};

/// A prism over a polygon cut into triangles.
Mesh prism(const std::vector<std::array<double, 2>>& loop, const std::vector<std::array<int, 3>>& floor,
           double height) {
    std::vector<Point> vertices;
    std::vector<std::array<int, 3>> faces;
    const int n = int(loop.size());
    for (const double z : {0.0, height}) {
        for (const auto& [x, y] : loop) vertices.push_back(cageform_tests::turned_about_123({x, y, z}, 1));
    }
    for (const auto& [a, b, c] : floor) {
        faces.push_back({a, c, b});
        faces.push_back({n + a, n + b, n + c});
    }
    for (int k = 0; k < n; ++k) {
        const int l = (k + 1) % n;
        faces.push_back({k, l, n + l});
        faces.push_back({k, n + l, n + k});
    }
    return {vertices, faces};
}

std::vector<NamedCage> cages() {
    std::vector<NamedCage> list;
    list.push_back({"cube", prism({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2}, {0, 2, 3}}, 1)});
    list.push_back({"L", prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                               {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}, 1)});
    list.push_back({"U", prism({{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                               {{0, 1, 4}, {0, 4, 5}, {1, 2, 4}, {2, 3, 4}, {0, 5, 7}, {5, 6, 7}}, 1)});
    list.push_back({"bumpy112", cageform_bench::bumpy112<double>()});
    list.push_back({"fingers", cageform_tests::Fingers(CAGEFORM_BENCH_FINGERS).cage()});
    return list;
}

/// The weights at the points, row after row; kept in a file.
std::vector<float> references(const NamedCage& cage, const std::vector<Point>& points, std::uint64_t walks,
                              const std::string& folder, double& error) {
    const std::size_t handles = cage.mesh.size();
    std::vector<float> rows(points.size() * handles + 1);
    const std::string path =
        folder + "/" + cage.name + "_" + std::to_string(points.size()) + "_" + std::to_string(walks) + ".raw";
    const auto bytes = std::streamsize(rows.size() * sizeof(float));
    if (std::ifstream kept(path, std::ios::binary);
        !folder.empty() && kept.read(reinterpret_cast<char*>(rows.data()), bytes)) {
        error = double(rows.back());
        return rows;
    }
    std::vector<double> errors(points.size());
    cageform::ThreadedFor{}(points.size(), 1, [&](std::size_t n, std::size_t) {
        const auto found = cageform_tests::walk_on_spheres(cage.mesh, points[n], walks, n);
        for (std::size_t i = 0; i < handles; ++i) rows[n * handles + i] = float(found.weight[i]);
        errors[n] = *std::max_element(found.error.begin(), found.error.end());
    });
    error = *std::max_element(errors.begin(), errors.end());
    rows.back() = float(error);
    if (!folder.empty())
        std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(rows.data()), bytes);
    return rows;
}

void print(const char* where, std::vector<double> errors, double asked) {
    std::sort(errors.begin(), errors.end());
    const auto at = [&](double share) { return errors[std::size_t(share * double(errors.size() - 1))]; };
    const auto beyond = errors.end() - std::upper_bound(errors.begin(), errors.end(), asked);
    std::printf("  %s: %.1e %.1e %.1e %.1e (%2.0f%%)", where, errors.back(), at(0.99), at(0.9), at(0.5),
                100 * double(beyond) / double(errors.size()));
}

} // namespace

int main(int argc, char** argv) {
    std::string only, folder;
    std::size_t count = 200;
    std::uint64_t walks = 100000;
    std::vector<double> accuracies;
    for (int n = 1; n < argc; ++n) {
        const std::string word = argv[n];
        if (word == "--cage" && n + 1 < argc)
            only = argv[++n];
        else if (word == "--points" && n + 1 < argc)
            count = std::stoul(argv[++n]);
        else if (word == "--walks" && n + 1 < argc)
            walks = std::stoul(argv[++n]);
        else if (word == "--keep" && n + 1 < argc)
            folder = argv[++n];
        else
            accuracies.push_back(std::stod(word));
    }
    if (accuracies.empty()) accuracies = {1e-2, 5e-3, 2e-3, 1e-3};
    for (const NamedCage& cage : cages()) {
        if (!only.empty() && only != cage.name) continue;
        auto points = cageform_tests::points_below_faces(cage.mesh, count, 17);
        const auto deep = cageform_tests::points_anywhere(cage.mesh, count, 18);
        points.insert(points.end(), deep.begin(), deep.end());
        double noise = 0;
        const auto known = references(cage, points, walks, folder, noise);
        std::printf("%s: %zu handles; walks, standard error at most %.1e; max, 99 %%, 90 %%, median (beyond "
                    "what was asked)\n",
                    cage.name.c_str(), cage.mesh.size(), noise);
        for (const double accuracy : accuracies) {
            const auto start = std::clock();
            const cageform::HarmonicCoordinates<double, 3> coordinates(cage.mesh, {.accuracy = accuracy});
            const auto made = std::clock();
            const auto bound = cageform::bind(coordinates, points);
            const auto end = std::clock();
            std::vector<double> skin, inside;
            for (std::size_t n = 0; n < points.size(); ++n) {
                double worst = 0;
                for (std::size_t i = 0; i < cage.mesh.size(); ++i)
                    worst = std::fmax(
                        worst, std::fabs(bound.value.weight(n, i) - double(known[n * cage.mesh.size() + i])));
                (n < count ? skin : inside).push_back(worst);
            }
            std::printf("%6g %7zu nodes %5.2f + %5.2f s", accuracy, bound.report.solver.cells,
                        double(made - start) / CLOCKS_PER_SEC, double(end - made) / CLOCKS_PER_SEC);
            print("skin", skin, accuracy);
            print("inside", inside, accuracy);
            std::printf("  restored %.1e\n", bound.report.weight_change.value);
        }
    }
}
