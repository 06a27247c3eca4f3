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

PaintedCage painted(const MeshFile& cage) {
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

Picture draw_cage_parts(const MeshFile& figure, const MeshFile& cage, std::size_t width, std::size_t height,
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

Picture draw_pose(const MeshFile& cage, const std::vector<Point3>& pose) {
    constexpr std::size_t width = 900, height = 1000;
    constexpr Colour paper{0.98f, 0.93f, 0.9f}, at_rest{0.7f, 0.7f, 0.7f}, ink{0.76f, 0.22f, 0.48f};
    SpacePlot plot;
    const std::vector<Colour> colours(pose.size(), paper);
    plot.surface = {pose, cage.triangles, colours};
    for (const MeshFace& face : cage.faces) {
        for (std::size_t k = 0; k < face.corners.size(); ++k) {
            const auto i = face.corners[k].vertex, j = face.corners[(k + 1) % face.corners.size()].vertex;
            if (cage.vertices != pose)
                plot.lines.push_back({{cage.vertices[i], cage.vertices[j]}, 1, at_rest});
            plot.lines.push_back({{pose[i], pose[j]}, 1.2, ink});
        }
    }
    std::stable_sort(plot.lines.begin(), plot.lines.end(),
                     [](const SpaceLine& a, const SpaceLine& b) { return a.thickness < b.thickness; });
    Picture picture(2 * width, height);
    for (const std::size_t side : {0, 1}) { // y is up, the front faces z
        const ViewDirections flat = view_from(side == 0 ? -25 : 155, 12);
        const auto y_up = [](const Point3& v) { return Point3{v[0], v[2], -v[1]}; };
        const ViewDirections view{y_up(flat.right), y_up(flat.up), y_up(flat.towards)};
        std::vector<bool> is_seen(pose.size()); // vertex of a face towards the viewer
        for (const MeshFace& face : cage.faces) {
            if (dot(detail::area_vector(face, pose), view.towards) <= 0) continue;
            for (const MeshCorner& corner : face.corners) is_seen[corner.vertex] = true;
        }
        plot.texts.clear();
        for (std::size_t i = 0; i < pose.size(); ++i) {
            if (is_seen[i]) plot.texts.push_back({pose[i], std::to_string(i)});
        }
        picture.place(draw_plot(plot, view, width, height), side * width);
    }
    return picture;
}

} // namespace cageform_support
