#pragma once

// Parts that these programs add to a packed figure (cageform/figure/figure.hpp):
//
//     TRIS  #triangles × 3 × uint32
//     CLIP  the clip, written only by older versions of bind_mesh; new figures have CLPS (figure/figure.hpp).
//           uint32 #curves and float length in seconds; #curves × uint32, the numbers of pieces of the x, y
//           and z curves of every cage vertex; the pieces, curve by curve, 5 × float each
//     ORIG  see figure/figure.hpp: here, the origin in coordinates of the mesh and cage files. Omitted if the
//           figure is near the origin of the files
//     NRM1  a blob: for every point a unit vector perpendicular to TAN1 and TAN2, or zero if no face uses the
//           point. TAN1, TAN2 and NRM1, posed, give the Jacobian by which clone_figure moves an OBJ file's
//           normals
//     PINS  packed PoseSamples (cageform/pose/types/pose_blob.hpp), by which pins pose the cage
//
// This header includes no bind-time code, because the example of an engine uses it.

#include <cageform/pose/types/pose_blob.hpp>
#include <cageform/runtime.hpp>

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// The parts of a figure.
struct FigureParts {
    std::string fault;                                       ///< why they cannot be used; empty if they can
    std::span<const std::array<std::uint32_t, 3>> triangles; ///< point into the figure
    cageform::CageClipView<float, 3> clip;   ///< the first clip, or one without vertices; points into the
                                             ///< figure or `unpacked`
    cageform::CageClip<float, 3> unpacked;   ///< the contents of CLIP
    cageform::PoseSamples<float, 3> samples; ///< the contents of PINS; without handles if there is no PINS
};

/// Returns the number of the cage's vertices, which are the first handles.
inline std::size_t vertices_of(const cageform::PackedFigureView<float, 3>& figure) {
    return figure.handle_count() - figure.handle_view().vector_count();
}

/// Reads the parts, and checks everything that could cause access out of bounds when playing.
inline FigureParts read_parts(const cageform::PackedFigureView<float, 3>& figure) {
    const auto refused = [](const std::string& why) { return FigureParts{why, {}, {}, {}, {}}; };
    FigureParts parts;
    parts.triangles = figure.part_as<std::array<std::uint32_t, 3>>("TRIS");
    for (const auto& triangle : parts.triangles) {
        for (const std::uint32_t corner : triangle) {
            if (corner >= figure.point_count())
                return refused("a triangle refers to a point that does not exist");
        }
    }
    if (const auto packed = figure.part("PINS"); !packed.empty()) {
        auto [samples, report] = cageform::open_pose_samples<float, 3>(packed);
        if (report.status != cageform::Status::ok)
            return refused(std::string("samples for pins: ") + cageform::to_string(report.status));
        if (samples.handle_count() != figure.handle_count())
            return refused("samples for pins: they belong to another cage");
        parts.samples = std::move(samples);
    }
    if (figure.clip_count() > 0) parts.clip = figure.clip(0);
    std::span<const std::byte> data = figure.part("CLIP");
    if (data.empty()) return parts;

    const auto take = [&data](void* to, std::size_t bytes) {
        if (bytes > data.size()) return false;
        if (bytes > 0) std::memcpy(to, data.data(), bytes);
        data = data.subspan(bytes);
        return true;
    };
    std::uint32_t curve_count = 0;
    float length = 0;
    if (!take(&curve_count, sizeof curve_count) || !take(&length, sizeof length) ||
        curve_count != 3 * vertices_of(figure))
        return refused("the clip belongs to another cage");
    std::vector<std::uint32_t> counts(curve_count);
    if (!take(counts.data(), counts.size() * sizeof counts[0])) return refused("the clip is cut short");
    std::vector<cageform::PiecewiseCubic<float>> curves;
    for (const std::uint32_t count : counts) {
        if (count == 0) return refused("a curve of the clip has no pieces");
        if (count > data.size() / sizeof(cageform::CubicPiece<float>))
            return refused("the clip is cut short");
        std::vector<cageform::CubicPiece<float>> pieces(count);
        (void)take(pieces.data(), pieces.size() * sizeof pieces[0]);
        for (std::size_t n = 0; n < pieces.size(); ++n) {
            const float next = n + 1 < pieces.size() ? pieces[n + 1].begin : length;
            if (!(pieces[n].begin < next)) return refused("the pieces of the clip do not ascend");
        }
        curves.emplace_back(std::move(pieces), length);
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    parts.unpacked = cageform::CageClip<float, 3>(curves, cycle, cycle);
    parts.clip = parts.unpacked.view();
    return parts;
}

} // namespace cageform_support
