// find_parts, step 3: minimum cut between the faces of a limb and the rest.
#pragma once

#include <cageform/enclose/space/part_surface.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Cost of cutting each edge of a closed mesh: its length, reduced where the surface is concave.
class EdgeCosts {
public:
    struct Edge {
        std::uint32_t one, other; ///< adjacent faces
        double length;
        std::int64_t cost; ///< integer, so that a smallest minimum cut exists
    };

    ///   images  mirror images of the vertices, or empty; an edge and its image cost the same
    EdgeCosts(std::span<const Vec<double, 3>> points, std::span<const std::array<std::uint32_t, 3>> faces,
              const MirrorImages& images) {
        std::vector<Vec<double, 3>> normals;
        for (const auto& face : faces) normals.push_back(area_normal(points, face));
        const auto sides = edge_sides(faces);
        double longest = 0;
        for (std::size_t e = 0; e + 1 < sides.size(); e += 2) {
            const double size = length(points[sides[e].b] - points[sides[e].a]);
            edges_.push_back({sides[e].face, sides[e + 1].face, size, 0});
            longest = (std::max)(longest, edges_.back().length);
        }
        for (std::size_t e = 0; e < edges_.size(); ++e) {
            const auto &one = normals[edges_[e].one], &other = normals[edges_[e].other];
            const double bend = std::atan2(length(cross(one, other)), dot(one, other));
            const bool is_hollow = dot(one, points[sides[2 * e + 1].third] - points[sides[2 * e].a]) > 0;
            constexpr double units = 1 << 24; // units per longest edge
            edges_[e].cost =
                1 + std::int64_t(units * edges_[e].length / longest / (is_hollow ? 1 + 3 * bend : 1));
            if (images.empty()) continue;
            const std::size_t image = edge_between(sides, images[sides[2 * e].a], images[sides[2 * e].b]);
            if (image < e) edges_[e].cost = edges_[image].cost;
        }
    }

    std::span<const Edge> edges() const noexcept { return edges_; }

private:
    std::vector<Edge> edges_;
};

enum class CutSide : std::uint8_t { limb, rest, undecided };

/// Assigns the undecided faces to limb or rest by a minimum cut (Dinic's maximum flow). Of several minimum
/// cuts, chooses the one whose limb has the fewest faces; this limb is the intersection of the limbs of all
/// minimum cuts.
class CheapestCut {
public:
    CheapestCut(std::span<const EdgeCosts::Edge> edges, std::vector<CutSide> sides)
        : edges_(edges)
        , sides_(std::move(sides))
        , incident_(sides_.size()) {
        for (std::size_t e = 0; e < edges.size(); ++e) {
            if (sides_[edges[e].one] == sides_[edges[e].other] && sides_[edges[e].one] != CutSide::undecided)
                continue;
            incident_[edges[e].one].push_back(e);
            incident_[edges[e].other].push_back(e);
        }
        residual_.resize(2 * edges.size()); // from `one` to `other`, and back
        for (std::size_t e = 0; e < edges.size(); ++e)
            residual_[2 * e] = residual_[2 * e + 1] = edges[e].cost;
        while (find_levels()) {
            next_.assign(sides_.size(), 0);
            for (std::uint32_t f = 0; f < sides_.size(); ++f) {
                if (sides_[f] != CutSide::limb) continue;
                while (augment(f) > 0) {}
            }
        }
    }

    bool is_limb(std::size_t f) const noexcept { return level_[f] != unreached; }

private:
    static constexpr std::uint32_t unreached = ~std::uint32_t{0};

    std::uint32_t across(std::size_t e, std::uint32_t f) const noexcept {
        return edges_[e].one == f ? edges_[e].other : edges_[e].one;
    }
    std::int64_t& residual(std::size_t e, std::uint32_t from) noexcept {
        return residual_[2 * e + (edges_[e].one == from ? 0 : 1)];
    }

    bool find_levels() {
        level_.assign(sides_.size(), unreached);
        std::vector<std::uint32_t> queue;
        for (std::uint32_t f = 0; f < sides_.size(); ++f) {
            if (sides_[f] != CutSide::limb) continue;
            level_[f] = 0;
            queue.push_back(f);
        }
        bool reaches_rest = false;
        for (std::size_t n = 0; n < queue.size(); ++n) {
            const auto f = queue[n];
            if (sides_[f] == CutSide::rest) {
                reaches_rest = true;
                continue;
            }
            for (const auto e : incident_[f]) {
                const auto g = across(e, f);
                if (level_[g] != unreached || residual(e, f) == 0) continue;
                level_[g] = level_[f] + 1;
                queue.push_back(g);
            }
        }
        return reaches_rest;
    }

    /// Augments the flow along one path from a face to the rest; returns the amount. Iterative, because paths
    /// may be long.
    std::int64_t augment(std::uint32_t from) {
        std::vector<std::size_t> path; // edges of the path
        std::vector<std::uint32_t> faces{from};
        while (sides_[faces.back()] != CutSide::rest) {
            const auto f = faces.back();
            auto& n = next_[f];
            while (n < incident_[f].size() &&
                   (residual(incident_[f][n], f) == 0 || level_[across(incident_[f][n], f)] != level_[f] + 1))
                ++n;
            if (n < incident_[f].size()) {
                path.push_back(incident_[f][n]);
                faces.push_back(across(incident_[f][n], f));
                continue;
            }
            if (path.empty()) return 0;
            path.pop_back();
            faces.pop_back();
            ++next_[faces.back()];
        }
        std::int64_t most = (std::numeric_limits<std::int64_t>::max)();
        for (std::size_t k = 0; k < path.size(); ++k) most = (std::min)(most, residual(path[k], faces[k]));
        for (std::size_t k = 0; k < path.size(); ++k) {
            residual(path[k], faces[k]) -= most;
            residual(path[k], faces[k + 1]) += most;
        }
        return most;
    }

    std::span<const EdgeCosts::Edge> edges_;
    std::vector<CutSide> sides_;
    std::vector<std::vector<std::size_t>> incident_; // edges of each face
    std::vector<std::int64_t> residual_;
    std::vector<std::uint32_t> level_;
    std::vector<std::size_t> next_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
