// The half-edges of a triangle mesh, and the faces that close its small gaps.
#pragma once

#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/detail/primitives.hpp>

#include <optional>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

/// An edge in the direction of one of its faces.
struct HalfEdge {
    std::uint32_t from, to, face;

    auto edge() const noexcept { return std::pair((std::min)(from, to), (std::max)(from, to)); }
};

/// Returns the half-edges of all faces, grouped by edge and sorted by the edges' lower vertices. O(#F + #V)
/// if vertices have few faces.
inline std::vector<HalfEdge> half_edges_of(std::span<const std::array<std::uint32_t, 3>> faces) {
    std::size_t size = 0;
    for (const auto& [a, b, c] : faces) size = std::max<std::size_t>(size, (std::max)({a, b, c}));
    std::vector<std::size_t> end(size + 2); // end of the half-edges of each lower vertex, after placement
    const auto for_each = [&](const auto& f) {
        for (std::size_t n = 0; n < 3 * faces.size(); ++n) {
            const auto& face = faces[n / 3];
            f(HalfEdge{face[n % 3], face[(n + 1) % 3], std::uint32_t(n / 3)});
        }
    };
    for_each([&](const HalfEdge& half_edge) { ++end[half_edge.edge().first + 1]; });
    for (std::size_t i = 0; i < size; ++i) end[i + 1] += end[i];
    std::vector<HalfEdge> all(3 * faces.size());
    for_each([&](const HalfEdge& half_edge) { all[end[half_edge.edge().first]++] = half_edge; });
    for (std::size_t i = 0, begin = 0; i <= size; begin = end[i++]) {
        std::sort(all.begin() + std::ptrdiff_t(begin), all.begin() + std::ptrdiff_t(end[i]),
                  [](const HalfEdge& a, const HalfEdge& b) {
                      return std::tuple(a.edge(), a.from, a.face) < std::tuple(b.edge(), b.from, b.face);
                  });
    }
    return all;
}

/// Calls f(half-edges) for every edge. In a closed manifold an edge has two half-edges, of opposite
/// directions.
template <class F>
void for_each_edge(std::span<const HalfEdge> half_edges, F&& f) {
    for (std::size_t begin = 0, end = 0; begin < half_edges.size(); begin = end) {
        while (end < half_edges.size() && half_edges[end].edge() == half_edges[begin].edge()) ++end;
        f(half_edges.subspan(begin, end - begin));
    }
}

using MeshLoop = std::vector<std::uint32_t>; ///< consecutive vertices; the first follows the last

/// Splits directed edges into loops that use each edge once. Returns nullopt if the edges do not form closed
/// loops.
inline std::optional<std::vector<MeshLoop>>
loops_of(std::vector<std::pair<std::uint32_t, std::uint32_t>> edges) {
    std::sort(edges.begin(), edges.end());
    std::vector<MeshLoop> loops;
    MeshLoop walk;
    while (!edges.empty()) {
        if (walk.empty()) walk.push_back(edges.front().first);
        const auto step =
            std::lower_bound(edges.begin(), edges.end(), std::pair(walk.back(), std::uint32_t{0}));
        if (step == edges.end() || step->first != walk.back()) return std::nullopt;
        const auto next = step->second;
        edges.erase(step);
        const auto met = std::find(walk.begin(), walk.end(), next);
        if (met == walk.end()) {
            walk.push_back(next);
            continue;
        }
        loops.emplace_back(met, walk.end());
        // If another loop touches this one, continue from their common vertex.
        walk.erase(met == walk.begin() ? met : met + 1, walk.end());
    }
    return loops;
}

/// Makes the faces that close the gaps of a mesh.
template <Scalar T>
class GapCloser {
public:
    GapCloser(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces)
        : vertices_(vertices)
        , faces_(faces)
        , half_edges_(half_edges_of(faces)) {}

    /// Returns no faces if a gap cannot be closed, or if the gaps exceed a quarter of the area of the faces.
    std::vector<MeshFace> closing_faces() const {
        const auto gaps = loops_of(open_edges());
        if (!gaps) return {};
        std::vector<MeshFace> closing;
        for (const MeshLoop& gap : *gaps) {
            if (gap.size() < 3 || is_stray(gap)) return {};
            const auto fan = smallest_fan(gap);
            if (fan.empty()) return {};
            closing.insert(closing.end(), fan.begin(), fan.end());
        }
        if (!(area(closing) <= 0.25 * area(faces_))) return {};
        return closing;
    }

private:
    /// Returns the edges with only one face, in the direction of the missing face.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> open_edges() const {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
        for_each_edge(half_edges_, [&](std::span<const HalfEdge> edge) {
            if (edge.size() == 1) open.push_back({edge[0].to, edge[0].from});
        });
        return open;
    }
    bool has_edge(std::uint32_t i, std::uint32_t j) const noexcept {
        const std::pair edge((std::min)(i, j), (std::max)(i, j));
        const auto at = std::lower_bound(half_edges_.begin(), half_edges_.end(), edge,
                                         [](const HalfEdge& a, const auto& b) { return a.edge() < b; });
        return at != half_edges_.end() && at->edge() == edge;
    }
    /// Whether a gap of three edges is the boundary of a single isolated face. A second face over this gap
    /// would not make a cage.
    bool is_stray(const MeshLoop& gap) const noexcept {
        return gap.size() == 3 && std::any_of(faces_.begin(), faces_.end(), [&](const MeshFace& face) {
                   return std::is_permutation(face.begin(), face.end(), gap.begin());
               });
    }
    /// Returns the fan of least area from one vertex to all others, among fans whose inner edges are not
    /// edges of the mesh. For a long gap only some apexes are tried.
    std::vector<MeshFace> smallest_fan(const MeshLoop& gap) const {
        std::vector<MeshFace> best;
        double least = std::numeric_limits<double>::infinity();
        constexpr std::size_t most_tried = 256;
        const std::size_t step = (gap.size() + most_tried - 1) / most_tried;
        for (std::size_t apex = 0; apex < gap.size(); apex += step) {
            const auto at = [&](std::size_t k) { return gap[(apex + k) % gap.size()]; };
            std::vector<MeshFace> fan;
            bool possible = true;
            for (std::size_t k = 1; k + 1 < gap.size(); ++k) {
                fan.push_back({at(0), at(k), at(k + 1)});
                possible = possible && (k == 1 || !has_edge(at(0), at(k)));
            }
            const double sum = area(fan);
            if (!possible || sum >= least) continue;
            least = sum;
            best = std::move(fan);
        }
        return best;
    }
    double area(std::span<const MeshFace> faces) const noexcept {
        double sum = 0;
        for (const MeshFace& face : faces) {
            const auto [a, b, c] = Facet<3>(face, vertices_).corner;
            sum += 0.5 * length(cross(b - a, c - a));
        }
        return sum;
    }

    std::span<const Vec<T, 3>> vertices_;
    std::span<const MeshFace> faces_;
    std::vector<HalfEdge> half_edges_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
