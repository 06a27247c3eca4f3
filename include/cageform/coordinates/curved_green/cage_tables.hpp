// The edges and handles of a curved cage.
#pragma once

#include <cageform/cage/curved/curved_polygon.hpp>
#include <cageform/coordinates/curved_green/curved_edge.hpp>
#include <cageform/coordinates/curved_green/options.hpp>
#include <cageform/core/detail/face_handles.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The edges with the inside on their left, in units of 1/scale, and the handles: N control points around the
/// loops in the user's order, shared ends once, then the N legs.
template <Scalar T>
struct CurvedTables {
    std::vector<Vec<T, 2>> handles;
    std::vector<HandleKind> kinds;
    std::vector<HandleFace<2>> faces;
    std::vector<CurvedEdge> edges;
    struct Vertex {
        ComplexNumber at;
        std::uint32_t before, after; ///< the edges that end and begin there
        std::uint32_t handle;
    };
    std::vector<Vertex> vertices;
    Vec<double, 2> middle{};
    double scale = 1, tolerance = 0, diagonal = 1, log_diagonal = 0;
    ComplexNumber disk_centre{0, 0};
    double disk_radius = 0; ///< 0: the plane

    CurvedTables() = default;
    CurvedTables(const CurveLoops& loops, const std::vector<std::size_t>& degrees)
        : middle(0.5 * loops.bounds.lower + 0.5 * loops.bounds.upper)
        , scale(loops.scale)
        , tolerance(loops.tolerance)
        , diagonal(loops.bounds.diagonal())
        , log_diagonal(std::log(diagonal)) {
        std::size_t points = 0;
        for (const std::size_t m : degrees) points += m;
        handles.resize(points);
        faces.resize(points);
        std::uint32_t first = 0;
        for (std::size_t k = 0; k < loops.loops.size(); ++k) {
            const auto& loop = loops.loops[k];
            const bool left = loops.inside_is_left(k);
            std::uint32_t in_loop = 0;
            for (std::size_t e = loop.begin; e < loop.end; ++e) in_loop += std::uint32_t(degrees[e]);
            std::uint32_t offset = 0;
            const std::size_t first_edge = edges.size();
            for (std::size_t e = loop.begin; e < loop.end; ++e) {
                const std::size_t m = degrees[e];
                const auto handle = [&](std::size_t i) {
                    return first + std::uint32_t((offset + (left ? i : m - i)) % in_loop);
                };
                CurvedEdge& edge = edges.emplace_back(left ? loops.edges[e] : loops.edges[e].reversed(), m);
                for (std::size_t i = 0; i <= m; ++i) {
                    edge.point[i] = handle(i);
                    handles[handle(i)] = vec_cast<T>((1 / scale) * raised_point(edge.curve, m, i));
                }
                for (std::size_t i = 0; i < m; ++i) {
                    const std::uint32_t leg = left ? handle(i) : handle(i + 1);
                    edge.leg[i] = std::uint32_t(points) + leg;
                    faces[leg] = {edge.point[i], edge.point[i + 1]};
                }
                offset += std::uint32_t(m);
            }
            add_vertices(first_edge, left);
            first += in_loop;
        }
        kinds.assign(points, HandleKind::point);
        kinds.resize(2 * points, HandleKind::vector);
        for (std::size_t i = 0; i < points; ++i)
            handles.push_back(edge_handle(handles[faces[i][0]], handles[faces[i][1]]));
    }

    std::size_t points() const noexcept { return faces.size(); }

private:
    /// Returns control point i of a curve elevated to degree m. End points are exact.
    static Vec<double, 2> raised_point(const PlaneCurve& curve, std::size_t m, std::size_t i) noexcept {
        if (i == 0) return curve.begin();
        if (i == m) return curve.end();
        Vec<double, 2> sum{};
        const std::size_t n = curve.degree;
        for (std::size_t j = 0; j <= n && j <= i; ++j) {
            if (i - j > m - n) continue;
            sum = sum + (binomials[n][j] * binomials[m - n][i - j] / binomials[m][i]) * curve.control[j];
        }
        return sum;
    }
    void add_vertices(std::size_t first_edge, bool left) {
        const std::size_t count = edges.size() - first_edge;
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t e = first_edge + i,
                              before = first_edge + (left ? i + count - 1 : i + 1) % count;
            edges[e].end[0].vertex = edges[before].end[1].vertex = std::uint32_t(vertices.size());
            vertices.push_back(
                {edges[e].end[0].at, std::uint32_t(before), std::uint32_t(e), edges[e].point[0]});
        }
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
