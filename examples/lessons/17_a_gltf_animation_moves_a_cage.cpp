// 17. A glTF animation moves a cage: arrays of samplers become a clip, packed in one file with the figure.
#include <cageform/animate/compile.hpp>
#include <cageform/animate/pack_clip.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/exchange/gltf.hpp>
#include <cageform/runtime.hpp> // the only header of a game

#include <cstdio>

using cageform::GltfInterpolation, cageform::Status;

/// Runs in the editor. Each vertex of the cage is a node of the glTF file; one of them has a sampler.
Status ship(cageform::PackedFigure<float, 3>& file) {
    std::vector<std::array<float, 3>> box, points;
    const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                              {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    for (int i = 0; i < 8; ++i) box.push_back({i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f});
    for (float z = 0; z < 1; z += 0.001f) points.push_back({0.8f, 0.8f, z}); // a rod towards node 7
    const auto [figure, bound] =
        cageform::bind(cageform::MeanValueCoordinates(box, faces), cageform::FigurePoints{points});
    if (bound.status != Status::ok) return bound.status;
    // The glTF file contains times, and for each key an in-tangent, a value and an out-tangent.
    const float times[] = {0, 1, 2};
    const float swing[] = {0, 0, 0, 1, 1, 1, 0, 2.5f, 0, // node 7 swings up and comes back
                           0, 0, 0, 1, 2, 1, 0, 0,    0, //
                           0, 0, 0, 1, 1, 1, 0, 0,    0};
    std::vector<std::vector<cageform::Key>> keys;
    for (std::size_t node = 0; node < box.size(); ++node) {
        const auto imported =
            node == 7 ? keys_from_gltf(times, swing, 3, GltfInterpolation::cubicspline)
                      : keys_from_gltf(std::span(times).first(1), box[node], 3, GltfInterpolation::step);
        if (!imported) return imported.status();
        keys.insert(keys.end(), imported.value.begin(), imported.value.end()); // x, y and z of the vertex
    }
    const cageform::TrackOptions options{.after = cageform::Extrapolation::cycle};
    const auto compiled = cageform::compile<float, 3>(keys, options);
    if (!compiled) return compiled.status();
    // The error of a vertex is at most 0.0001; curves use 16 bits per coefficient if this permits.
    const auto [clip, report] = pack_clip(compiled.value, {.tolerance = 0.0001});
    std::printf("%zu of %zu curves in 16 bits: %zu bytes instead of %zu\n", report.quantised, report.curves,
                report.bytes, report.unquantised_bytes);
    const cageform::FigureClipData clips[] = {{"swing", clip.bytes()}};
    auto packed = cageform::pack(figure, {.weights = {.tolerance = 0.001}, .clips = clips});
    file = std::move(packed.value); // write its bytes to a file
    return packed.status();
}

/// Runs in the game: needs only runtime.hpp, reads the file in place, and allocates the arrays of a frame
/// once.
Status play(std::span<const std::byte> file) {
    const auto opened = cageform::open<float, 3>(file);
    if (!opened) return opened.status();
    const auto& figure = opened.value;
    const std::size_t found = figure.find_clip("swing");
    if (found == figure.clip_count()) return Status::not_a_clip;
    const auto swing = figure.clip(found);
    auto cursor = swing.make_cursor();
    std::vector<cageform::Vec<float, 3>> pose(figure.handle_count()), out(figure.point_count());
    for (const float time : {0.0f, 1.0f, 2.5f}) {
        swing.sample(time, cursor, pose);
        if (const Status moved = clone(figure, pose, out); moved != Status::ok) return moved;
        std::printf("%.1f s: vertex 7 at height %.2f, the rod's ends at %.2f and %.2f\n", time, pose[7][1],
                    out.front()[1], out.back()[1]);
    }
    return Status::ok;
}

int main() {
    cageform::PackedFigure<float, 3> file;
    Status status = ship(file);
    if (status == Status::ok) status = play(file.bytes());
    return status == Status::ok ? 0 : std::puts(to_string(status));
}

// The rod follows vertex 7; the end near the vertex moves most. The clip repeats after two seconds.
//> 24 of 24 curves in 16 bits: 1856 bytes instead of 2240
//> 0.0 s: vertex 7 at height 1.00, the rod's ends at 0.80 and 0.80
//> 1.0 s: vertex 7 at height 2.00, the rod's ends at 1.15 and 1.60
//> 2.5 s: vertex 7 at height 1.81, the rod's ends at 1.08 and 1.45
