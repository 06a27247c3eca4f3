#pragma once

// What a game ships of a figure, in one file that is used where it lies in memory: blobs of the library, one behind the
// other, then triangles and a clip.
//
//     blob           the points                                          (cageform/binding/blob.hpp)
//     blob, blob     two tangent vectors a point, for normals
//     FigureTail
//     triangles      #triangles × 3 × uint32
//     piece_counts   #curves × uint32: x, y and z of every vertex of the cage
//     pieces         #pieces × 5 × float, curve by curve
//
// Nothing here is known to bind-time code: the engine's client includes it.

#include <cageform/animate/clip.hpp>
#include <cageform/binding/blob.hpp>

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace cageform_examples {

struct FigureTail {
    static constexpr std::uint32_t magic_number = 0x65676143u;

    std::uint32_t magic = magic_number;
    std::uint32_t triangles = 0, curves = 0, pieces = 0;
    float clip_length = 0;
    std::uint32_t reserved[11] = {};
};
static_assert(sizeof(FigureTail) == 64);

/// A file in use. Bindings and triangles point into it.
struct Figure {
    std::string fault; ///< why it cannot be used; empty where it can
    cageform::PackedBindingView<float, 3> points;
    std::array<cageform::PackedBindingView<float, 3>, 2> tangents;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    cageform::CageClip<float, 3> clip; ///< of no vertices where there is none
};

/// Checks everything that could make playing read or write out of bounds. `data` is aligned to 64 bytes, as pages are.
inline Figure open_figure(std::span<const std::byte> data) {
    Figure figure;
    const auto refused = [](const std::string& why) {
        Figure none;
        none.fault = why;
        return none;
    };
    for (auto* binding : {&figure.points, &figure.tangents[0], &figure.tangents[1]}) {
        const auto blob = cageform::open_blob<float, 3>(data);
        if (blob.status != cageform::Status::ok) return refused(cageform::to_string(blob.status));
        *binding = blob.binding;
        data = data.subspan(blob.bytes);
        if (binding->point_count() != figure.points.point_count() ||
            binding->handle_count() != figure.points.handle_count())
            return refused("the tangents are those of another figure");
    }
    FigureTail tail;
    if (data.size() < sizeof tail) return refused("the triangles are missing");
    std::memcpy(&tail, data.data(), sizeof tail);
    data = data.subspan(sizeof tail);
    // All counts have 32 bits, so no sum of products wraps.
    const std::uint64_t triangle_bytes = std::uint64_t(tail.triangles) * 12,
                        count_bytes = std::uint64_t(tail.curves) * 4;
    const std::uint64_t piece_bytes = std::uint64_t(tail.pieces) * sizeof(cageform::CubicPiece<float>);
    if (tail.magic != FigureTail::magic_number || data.size() < triangle_bytes + count_bytes + piece_bytes)
        return refused("the triangles or the clip are cut short");
    figure.triangles = {reinterpret_cast<const std::array<std::uint32_t, 3>*>(data.data()), tail.triangles};
    for (const auto& triangle : figure.triangles) {
        for (const std::uint32_t corner : triangle) {
            if (corner >= figure.points.point_count())
                return refused("a triangle names a point that there is not");
        }
    }
    if (tail.curves == 0) return figure;

    if (tail.curves != 3 * figure.points.handle_count()) return refused("the clip is one of another cage");
    const std::byte* count = data.data() + triangle_bytes;
    const std::byte* piece = count + count_bytes;
    std::vector<cageform::PiecewiseCubic<float>> curves;
    std::uint64_t used = 0;
    for (std::uint32_t c = 0; c < tail.curves; ++c, count += 4) {
        std::uint32_t pieces_of_curve = 0;
        std::memcpy(&pieces_of_curve, count, 4);
        used += pieces_of_curve;
        if (pieces_of_curve == 0 || used > tail.pieces) return refused("a curve of the clip has no pieces");
        std::vector<cageform::CubicPiece<float>> pieces(pieces_of_curve);
        std::memcpy(pieces.data(), piece, pieces.size() * sizeof pieces[0]);
        piece += pieces.size() * sizeof pieces[0];
        for (std::size_t n = 0; n < pieces.size(); ++n) {
            const float next = n + 1 < pieces.size() ? pieces[n + 1].begin : tail.clip_length;
            if (!(pieces[n].begin < next)) return refused("the pieces of the clip do not ascend");
        }
        curves.emplace_back(std::move(pieces), tail.clip_length);
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    figure.clip = cageform::CageClip<float, 3>(curves, cycle, cycle);
    return figure;
}

/// The bytes behind the blobs.
inline std::vector<std::byte> figure_tail(std::span<const std::array<std::uint32_t, 3>> triangles,
                                          std::span<const cageform::PiecewiseCubic<float>> curves) {
    FigureTail tail;
    tail.triangles = std::uint32_t(triangles.size());
    tail.curves = std::uint32_t(curves.size());
    tail.clip_length = curves.empty() ? 0 : curves[0].end();
    std::vector<std::byte> bytes(sizeof tail);
    const auto append = [&bytes](const auto& values) {
        const auto more = std::as_bytes(std::span(values));
        bytes.resize(bytes.size() + more.size());
        if (!more.empty()) std::memcpy(bytes.data() + (bytes.size() - more.size()), more.data(), more.size());
    };
    append(triangles);
    for (const auto& curve : curves) {
        append(std::array{std::uint32_t(curve.pieces().size())});
        tail.pieces += std::uint32_t(curve.pieces().size());
    }
    for (const auto& curve : curves) append(curve.pieces());
    std::memcpy(bytes.data(), &tail, sizeof tail);
    return bytes;
}

} // namespace cageform_examples
