// The input motion in the layout of the fit.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/types/bounds.hpp>
#include <cageform/core/vec.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <array>
#include <numeric>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the diagonal of a figure; 0 if it is below the rounding of its positions.
inline double figure_size(const std::vector<Vec<double, 3>>& places) noexcept {
    const auto bounds = bounds_of(std::span<const Vec<double, 3>>(places));
    const double size = bounds.diagonal();
    return size > 1e-14 * bounds.magnitude() ? size : 0;
}

/// A motion with welded vertices (equal in all frames). Lengths are relative to `size`; positions are
/// relative to the mean of their frame or of the rest pose.
struct Motion {
    static constexpr std::size_t group = 8; ///< frames per SIMD group

    std::size_t vertices = 0;
    std::size_t frames = 0;
    std::size_t lanes = 0; ///< frames, rounded up to whole groups; padded with zeros
    double size = 1;       ///< diagonal in the rest pose, or in the first frame if that is 0
    Vec<double, 3> centre{};
    std::vector<Vec<double, 3>> centres; ///< mean of each frame
    std::vector<Vec<double, 3>> rest;    ///< #vertices
    std::vector<double> places;          ///< #vertices · 3 · lanes
    std::vector<double> squares;         ///< #vertices: sum of squared positions
    std::vector<std::uint32_t> welded;   ///< welded index of each input vertex
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<std::uint32_t> first_neighbour, neighbours; ///< along edges, per vertex (CSR)

    double* path(std::size_t i) noexcept { return places.data() + i * 3 * lanes; }
    const double* path(std::size_t i) const noexcept { return places.data() + i * 3 * lanes; }

    /// Allocates memory for the input vertices.
    void allocate(std::size_t vertex_count, std::size_t frame_count) {
        vertices = vertex_count;
        frames = frame_count;
        lanes = (frames + group - 1) / group * group;
        rest.resize(vertices);
        places.assign(vertices * 3 * lanes, 0);
        centres.resize(frames);
    }
    /// Computes all other members from `rest`, `places` and `faces`.
    void prepare() {
        weld();
        normalise();
        link();
    }

private:
    void weld() {
        const auto before = [this](std::uint32_t a, std::uint32_t b) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (rest[a][k] != rest[b][k]) return rest[a][k] < rest[b][k];
            }
            return std::lexicographical_compare(path(a), path(a) + 3 * lanes, path(b), path(b) + 3 * lanes);
        };
        auto order = first_indices<std::uint32_t>(vertices);
        std::vector<std::uint32_t> first(vertices);
        std::sort(order.begin(), order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return before(a, b) || (!before(b, a) && a < b); });
        for (std::size_t n = 0; n < vertices; ++n)
            first[order[n]] = n > 0 && !before(order[n - 1], order[n]) ? first[order[n - 1]] : order[n];
        welded.resize(vertices);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < vertices; ++i) {
            welded[i] = first[i] == i ? std::uint32_t(kept) : welded[first[i]];
            if (first[i] != i) continue;
            if (kept != i) {
                rest[kept] = rest[i];
                std::copy(path(i), path(i) + 3 * lanes, path(kept));
            }
            ++kept;
        }
        vertices = kept;
        rest.resize(kept);
        places.resize(kept * 3 * lanes);
        for (auto& face : faces) {
            for (std::uint32_t& corner : face) corner = welded[corner];
        }
    }
    void normalise() {
        size = figure_size(rest);
        if (!(size > 0)) {
            std::vector<Vec<double, 3>> frame(vertices);
            for (std::size_t i = 0; i < vertices; ++i) {
                for (std::size_t k = 0; k < 3; ++k) frame[i][k] = path(i)[k * lanes];
            }
            size = figure_size(frame);
        }
        if (!(size > 0)) size = 1;
        const double share = 1 / double(vertices);
        for (const auto& p : rest) centre = centre + share * p;
        for (auto& p : rest) {
            for (std::size_t k = 0; k < 3; ++k) p[k] = (p[k] - centre[k]) / size;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t t = 0; t < frames; ++t) {
                double& mean = centres[t][k];
                for (std::size_t i = 0; i < vertices; ++i) mean += share * path(i)[k * lanes + t];
            }
            for (std::size_t i = 0; i < vertices; ++i) {
                double* const row = path(i) + k * lanes;
                for (std::size_t t = 0; t < frames; ++t) row[t] = (row[t] - centres[t][k]) / size;
            }
        }
        squares.assign(vertices, 0);
        for (std::size_t i = 0; i < vertices; ++i) {
            for (std::size_t n = 0; n < 3 * lanes; ++n) squares[i] += path(i)[n] * path(i)[n];
        }
    }
    void link() {
        std::vector<std::array<std::uint32_t, 2>> edges;
        edges.reserve(6 * faces.size());
        for (const auto& face : faces) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = face[k], b = face[(k + 1) % 3];
                if (a == b) continue;
                edges.push_back({a, b});
                edges.push_back({b, a});
            }
        }
        sort_unique(edges);
        first_neighbour.assign(vertices + 1, 0);
        for (const auto& edge : edges) {
            ++first_neighbour[edge[0] + 1];
            neighbours.push_back(edge[1]);
        }
        std::partial_sum(first_neighbour.begin(), first_neighbour.end(), first_neighbour.begin());
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
