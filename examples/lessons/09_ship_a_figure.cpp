// 9. Ship a figure with a game: points with normals and tangents, bound and packed in the editor, and
// used in place from the bytes of the file.
#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/runtime.hpp> // the only header of a game

#include <cstdio>

using cageform::Status, cageform::StridedPoints;

/// Runs in the editor, once. HarmonicCoordinates<float, 3> works the same way, with one solve for points and
/// vectors.
int ship(std::FILE* file) {
    std::vector<std::array<float, 3>> box, points, normals; // a ball in a box
    std::vector<std::array<float, 4>> tangents;             // the fourth number is the handedness, as in glTF
    const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                              {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    for (int i = 0; i < 8; ++i) box.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
    for (int i = 0; i < 1000; ++i) {
        const float y = 0.001f * float(2 * i - 999), angle = 2.4f * float(i), r = std::sqrt(1 - y * y);
        const float x = std::cos(angle), z = std::sin(angle);
        points.push_back({0.8f * r * x, 0.8f * y, 0.8f * r * z});
        normals.push_back({r * x, y, r * z});
        tangents.push_back({-z, 0, x, 1});
    }
    const cageform::MeanValueCoordinates coordinates(box, faces);
    auto [figure, bound] = cageform::bind(coordinates, cageform::FigurePoints{points, normals, tangents});
    if (bound.status != Status::ok) return std::puts(to_string(bound.status));
    if (!bound.points.outside.empty()) return std::puts("points lie outside the cage");
    const std::array labels{"", "", "", "", "left foot", "right foot", "left hand", "right hand"};
    if (figure.set_labels(labels) != Status::ok) return std::puts("labels and handles differ in number");

    // The error is at most 0.001 if every handle is within a tenth of the box's size of an affine pose.
    const auto [packed, report] = cageform::pack(figure, {.weights = {.tolerance = 0.001}});
    if (report.status != Status::ok) return std::puts(to_string(report.status));
    const auto bytes = packed.bytes();
    return std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() ? 0 : std::puts("cannot write");
}

struct Vertex {
    float position[3], normal[3], tangent[4];
};

/// Runs in the game. The file must be aligned to 64 bytes, as mapped files are. Invalid files are errors.
int play(std::FILE* file) {
    std::vector<cageform::Lanes<float>> memory(4096); // of 64 bytes each
    std::rewind(file);
    const auto bytes = std::as_bytes(std::span(memory)).first(std::fread(&memory[0], 1, 4096 * 64, file));
    std::puts(to_string(cageform::open<float, 3>(bytes.first(1000)).status()));
    const auto [figure, opened] = cageform::open<float, 3>(bytes);
    if (opened.status != Status::ok) return std::puts(to_string(opened.status));

    std::vector<Vertex> vertices(figure.point_count());
    const StridedPoints<float, 3> positions(vertices[0].position, vertices.size(), sizeof(Vertex));
    const StridedPoints<float, 3> normals(vertices[0].normal, vertices.size(), sizeof(Vertex));
    const StridedPoints<float, 4> tangents(vertices[0].tangent, vertices.size(), sizeof(Vertex));
    const auto rest = figure.rest_handles();
    std::vector<cageform::Vec<float, 3>> pose(rest.begin(), rest.end());
    for (int frame = 0; frame < 3; ++frame) { // moves the cage, and the figure with it
        pose[figure.find_handle("right hand")][1] += 0.5f;
        const Status moved = clone(figure, pose, cageform::FigureOutput{positions, normals, tangents});
        if (moved != Status::ok) return std::puts(to_string(moved));
        const auto& [p, n, t] = vertices[770];
        std::printf("%.2f %.2f %.2f  normal %.2f %.2f %.2f  tangent %.2f %.2f %.2f %+.0f\n", p[0], p[1], p[2],
                    n[0], n[1], n[2], t[0], t[1], t[2], t[3]);
    }
    return 0;
}

int main() {
    std::FILE* file = std::tmpfile();
    return file == nullptr || ship(file) != 0 || play(file) != 0;
}

// The vertex nearest to the hand follows it; its normal and tangent rotate with the surface.
//
//> the packed data is cut off
//> 0.50 0.60 0.46  normal 0.63 0.53 0.57  tangent -0.68 0.02 0.74 +1
//> 0.50 0.76 0.46  normal 0.64 0.52 0.56  tangent -0.68 0.03 0.74 +1
//> 0.50 0.92 0.46  normal 0.65 0.52 0.56  tangent -0.68 0.05 0.74 +1
