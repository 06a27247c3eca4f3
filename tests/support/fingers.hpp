// A production cage with thin parts and reference weights in it (tests/data/fingers).
#pragma once

#include <cageform/cage/triangle_mesh.hpp>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace cageform_tests {

/// Rodrigues' rotation about (1, 2, 3).
inline cageform::Vec<double, 3> turned_about_123(const cageform::Vec<double, 3>& p, double angle) {
    const auto axis = (1 / std::sqrt(14.0)) * cageform::Vec<double, 3>{1, 2, 3};
    return std::cos(angle) * p + std::sin(angle) * cross(axis, p) +
           ((1 - std::cos(angle)) * dot(axis, p)) * axis;
}

/// A body of 180 units with fingers 1.7 thick and gaps of 0.4, and weights of all 762 handles at
/// points inside, by walks on spheres: reference.txt to 2.5e-4, skin.txt to 1.1e-3 at 40 points below faces
/// (bench_skin). Turned, so that no face lies along the grid.
struct Fingers {
    std::vector<cageform::Vec<double, 3>> vertices, points;
    std::vector<std::array<int, 3>> faces;
    std::vector<std::vector<double>> weights; ///< [point][handle]

    explicit Fingers(const std::string& folder, double angle = 1, const char* points_file = "reference.txt") {
        std::ifstream cage(folder + "/cage.obj");
        for (std::string word; cage >> word;) {
            double x = 0, y = 0, z = 0;
            cage >> x >> y >> z;
            if (word == "v")
                vertices.push_back(turned_about_123({x, y, z}, angle));
            else
                faces.push_back({int(x) - 1, int(y) - 1, int(z) - 1});
        }
        std::ifstream reference(folder + "/" + points_file);
        for (std::string line; std::getline(reference, line);) {
            std::istringstream parts(line);
            char mark = 0;
            cageform::Vec<double, 3> p;
            parts >> p[0] >> mark >> p[1] >> mark >> p[2];
            points.push_back(turned_about_123(p, angle));
            auto& row = weights.emplace_back(vertices.size());
            std::size_t handle = 0;
            double weight = 0;
            while (parts >> mark >> handle >> mark >> weight) row[handle] = weight;
        }
    }
    cageform::TriangleMesh<double> cage() const { return {vertices, faces}; }
};

} // namespace cageform_tests
