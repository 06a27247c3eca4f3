#include "pictures/parts_picture.hpp"

#include "cli/mesh_cage.hpp"

#include <cmath>
#include <cstdlib>

namespace cageform_support {

namespace {

/// Clay for the trunk; other hues are spaced by the golden ratio.
Colour colour_of_part(int number) {
    if (number == 1) return {0.80f, 0.74f, 0.66f};
    const double hue = 6 * std::fmod(0.58 + 0.381966 * (std::abs(number) - 2), 1.0);
    const auto channel = [&](double peak) {
        const double off = std::fabs(std::remainder(hue - peak, 6));
        const double value = 0.42 + 0.53 * std::clamp(2 - off, 0.0, 1.0);
        return float(number < 0 ? 0.72 * value : value);
    };
    return {channel(0), channel(2), channel(4)};
}

/// A cage whose faces share no vertices, so that each has one colour.
struct PaintedCage {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Colour> colours;
    std::vector<SpaceText> numbers;
};

PaintedCage painted(const ObjFile& cage) {
    PaintedCage made;
    const auto parts = cage_parts(cage);
    std::vector<Point3> moments(parts.parts.size());
    std::vector<double> areas(parts.parts.size());
    for (std::size_t t = 0; t < cage.triangles.size(); ++t) {
        const auto first = std::uint32_t(made.vertices.size());
        made.triangles.push_back({first, first + 1, first + 2});
        const auto& [a, b, c] = cage.triangles[t];
        for (const auto v : {a, b, c}) made.vertices.push_back(cage.vertices[v]);
        const int number = parts.of_face[cage.triangle_faces[t]];
        made.colours.insert(made.colours.end(), 3, colour_of_part(number));
        const auto n = std::size_t(parts.find(number) - parts.parts.data());
        const Point3 across = cross(cage.vertices[b] - cage.vertices[a], cage.vertices[c] - cage.vertices[a]);
        const double area = std::sqrt(dot(across, across));
        areas[n] += area;
        moments[n] = moments[n] + (area / 3) * (cage.vertices[a] + cage.vertices[b] + cage.vertices[c]);
    }
    for (std::size_t n = 0; n < areas.size(); ++n)
        made.numbers.push_back({(1 / areas[n]) * moments[n], std::to_string(parts.parts[n].number)});
    return made;
}

} // namespace

Picture draw_cage_parts(const ObjFile& figure, const ObjFile& cage, std::size_t width, std::size_t height,
                        const ViewAngles& sight) {
    const MeshView lines = cage_view(cage, cage.vertices);
    const MeshScene caged{{figure.vertices, figure.triangles}, lines};
    if (cage.face_parts.empty())
        return draw_meshes(std::array{caged, MeshScene{{cage.vertices, cage.triangles}, {}}}, width, height,
                           sight);
    const PaintedCage paint = painted(cage);
    const MeshScene parts{{paint.vertices, paint.triangles, paint.colours}, lines, {}, paint.numbers};
    return draw_meshes(std::array{caged, parts}, width, height, sight);
}

} // namespace cageform_support
