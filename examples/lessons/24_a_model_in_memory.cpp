// 24. A model in memory: arrays of a glTF primitive, moved by a cage and returned to the space of the node.
// The program `deform_mesh model.glb --cage auto:60 -o moved.glb` does this for a file.
#include <cageform/binding/bind.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <cstdio>

using Vector = cageform::Vec<double, 3>;
using Map = cageform::Transform<double, 3>; // an affine map x ↦ A x + b

struct Primitive {
    std::vector<std::array<float, 3>> positions, normals;
    std::vector<std::array<float, 4>> tangents; // the fourth number is the handedness
    std::vector<std::array<float, 3>> target;   // displacements of a morph target
};

Map inverse(const Map& map) {
    const auto& [x, y, z] = map.columns;
    const double factor = 1 / dot(x, cross(y, z));
    const Vector a = factor * cross(y, z), b = factor * cross(z, x), c = factor * cross(x, y); // rows
    Map result{{{{a[0], b[0], c[0]}, {a[1], b[1], c[1]}, {a[2], b[2], c[2]}}}, {}};
    result.translation = -1 * result.map_vector(map.translation);
    return result;
}
Vector transposed(const Map& map, const Vector& v) { // Aᵀ v
    return {dot(map.columns[0], v), dot(map.columns[1], v), dot(map.columns[2], v)};
}
void store(auto& out, const Vector& v) { // the first three numbers
    for (std::size_t k = 0; k < 3; ++k) out[k] = float(v[k]);
}

int main() {
    // A roof in centimetres, z up. Each slope has its own vertex at (0, 0, 80), with its own normal.
    Primitive roof{{{0, -60, 0}, {0, 0, 80}, {0, 0, 80}, {0, 60, 0}},
                   {{0, -0.8f, 0.6f}, {0, -0.8f, 0.6f}, {0, 0.8f, 0.6f}, {0, 0.8f, 0.6f}},
                   {{0, 0.6f, 0.8f, 1}, {0, 0.6f, 0.8f, 1}, {0, -0.6f, 0.8f, -1}, {0, -0.6f, 0.8f, -1}},
                   {{0, 0, 0}, {0, 0, 20}, {0, 0, 20}, {0, 0, 0}}};
    // The global transform of the primitive's node: to metres, y up. Normals need the inverse transpose.
    const Map node{{{{0.01, 0, 0}, {0, 0, -0.01}, {0, 0.01, 0}}}, {5, 0, 0}}, back = inverse(node);
    const std::size_t count = roof.positions.size();
    std::vector<Vector> points(count), normals(count), steps(count);
    auto tangents = roof.tangents;
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = [&](const auto& array) { return Vector{array[i][0], array[i][1], array[i][2]}; };
        points[i] = node.map_vector(at(roof.positions)) + node.translation;
        normals[i] = transposed(back, at(roof.normals));
        store(tangents[i], node.map_vector(at(roof.tangents)));
        steps[i] = node.map_vector(at(roof.target));
    }
    const auto cage = cageform::box_mesh<double>({4, -1, -1}, {6, 1, 1}, {2, 2, 2}); // in world space
    const cageform::MeanValueCoordinates coordinates(cage);
    const auto figure = cageform::bind(coordinates, cageform::FigurePoints{points, normals, tangents});
    const auto axes = cageform::bind_jacobians(coordinates, points);
    if (!figure || !axes) return 1;
    std::vector<Vector> pose; // 1.5 times as high, and moved to the side
    for (const auto& v : cage.vertices()) pose.push_back({v[0] + 0.25, 1.5 * v[1], v[2]});
    std::vector<Map> maps(count);
    const cageform::StridedMatrices<double, 3> jacobians(&maps[0].columns[0][0], count, sizeof(Map));
    const cageform::FigureOutput out{points, normals, tangents};
    if (clone(figure.value, pose, out) != cageform::Status::ok) return 1;
    if (clone_jacobians(axes.value, pose, jacobians) != cageform::Status::ok) return 1;
    const auto unit = [](const Vector& v) { return 1 / std::sqrt(dot(v, v)) * v; };
    for (std::size_t i = 0; i < count; ++i) {
        auto &p = roof.positions[i], &n = roof.normals[i], &d = roof.target[i];
        auto& t = roof.tangents[i]; // its handedness stays
        store(p, back.map_vector(points[i]) + back.translation);
        store(n, unit(transposed(node, normals[i])));
        store(t, unit(back.map_vector({tangents[i][0], tangents[i][1], tangents[i][2]})));
        store(d, back.map_vector(maps[i].map_vector(steps[i]))); // exact if the pose is affine
        if (i == 1 || i == 2) std::printf("%.0f %.0f  normal %.3f %.3f", p[0], p[2], n[1], n[2]);
        if (i == 1 || i == 2) std::printf("  tangent %.3f %.3f %+.0f  target %.0f\n", t[1], t[2], t[3], d[2]);
    }
}

// The slopes still meet. The height 80 and the displacement 20 are multiplied by 1.5.
//> 25 120  normal -0.894 0.447  tangent 0.447 0.894 +1  target 30
//> 25 120  normal 0.894 0.447  tangent -0.447 0.894 -1  target 30
