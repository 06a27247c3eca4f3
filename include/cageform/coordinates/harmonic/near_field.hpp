// The faces of a cage, prepared for the double layers of near_patch.hpp.
#pragma once

#include <cageform/coordinates/green/space.hpp>
#include <cageform/coordinates/harmonic/wedge.hpp>
#include <cageform/grid/tree/nodes.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The faces of a cage in the units of a tree. NearPatch uses them.
class NearField {
public:
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    static constexpr std::size_t dimension = 3;
    using Point = Vec<double, 3>;
    using Frame = GreenFrame<double, 3>;

    /// Refers to `boundary`, which has the same mesh. Corners are rounded as in the tree, so that all nodes
    /// lie inside.
    NearField(const grid::TreeBoundary<3>& boundary, const TriangleMesh<double>& mesh)
        : boundary_(boundary)
        , at_(mesh.size())
        , star_ends_(mesh.size(), 0) {
        const MeanValueTopology<3> topology(mesh); // faces are oriented outwards
        faces_of_edge_ = {topology.edges.size(), {none, none}};
        for (std::size_t f = 0; f < topology.facets.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) at_[boundary[f].vertex[k]] = boundary[f].corner[k];
            for (const std::uint32_t v : topology.facets[f]) ++star_ends_[v];
            for (const std::uint32_t e : topology.edges_of_facet[f]) {
                auto& faces = faces_of_edge_[e];
                faces[faces[0] == none ? 0 : 1] = std::uint32_t(f);
            }
        }
        std::uint32_t begin = 0;
        for (auto& end : star_ends_) end = std::exchange(begin, begin + end);
        star_.resize(begin);
        for (std::size_t f = 0; f < topology.facets.size(); ++f) {
            for (const std::uint32_t v : topology.facets[f]) star_[star_ends_[v]++] = std::uint32_t(f);
        }
        frame_ = Frame(topology, at_, 0);
    }

    const grid::TreeBoundary<3>& boundary() const noexcept { return boundary_; }
    std::size_t vertices() const noexcept { return at_.size(); }
    std::size_t edges() const noexcept { return faces_of_edge_.size(); }
    std::size_t faces() const noexcept { return frame_.faces.size(); }
    std::size_t bytes() const noexcept {
        return at_.capacity() * 2 * sizeof(Point) + // here and in the frame
               (star_ends_.capacity() + star_.capacity()) * sizeof(std::uint32_t) +
               edges() * (sizeof(faces_of_edge_[0]) + sizeof(Frame::Edge)) +
               faces() * (sizeof(Frame::Face) + sizeof(double));
    }
    const Point& at(std::uint32_t vertex) const noexcept { return at_[vertex]; }
    const Frame::Face& face(std::uint32_t f) const noexcept { return frame_.faces[f]; }
    const Frame::Edge& edge(std::uint32_t e) const noexcept { return frame_.edges[e]; }
    const std::array<std::uint32_t, 2>& faces_of_edge(std::uint32_t e) const noexcept {
        return faces_of_edge_[e];
    }
    std::span<const std::uint32_t> star(std::uint32_t vertex) const noexcept {
        const std::size_t begin = vertex == 0 ? 0 : star_ends_[vertex - 1];
        return {star_.data() + begin, star_ends_[vertex] - begin};
    }
    Corners<3> corners(std::uint32_t f) const noexcept {
        const auto& c = face(f).corner;
        return {at_[c[0]], at_[c[1]], at_[c[2]]};
    }
    /// Whether the two faces of an edge are not coplanar.
    bool is_bent(std::uint32_t e) const noexcept {
        constexpr double flat = 1e-3; // the sine of the angle
        const auto& [f, g] = faces_of_edge(e);
        return g != none && length(cross(face(f).normal, face(g).normal)) > flat;
    }
    /// Returns the corner of a face opposite to an edge.
    std::uint32_t apex(std::uint32_t f, std::uint32_t e) const noexcept {
        const auto& corner = face(f).corner;
        return *std::find_if(corner.begin(), corner.end(),
                             [&](std::uint32_t v) { return v != edge(e).from && v != edge(e).to; });
    }
    /// Returns the wedge at an edge of two faces.
    Wedge wedge(std::uint32_t e) const noexcept {
        const auto& [f, g] = faces_of_edge(e);
        const auto& [from, to, along, length_in_units] = edge(e);
        const Point normal = -1.0 * face(f).normal;
        auto plane = cross(normal, along);
        if (dot(plane, at(apex(f, e)) - at(from)) < 0) plane = -1.0 * plane;
        // The first half-plane is at angle 0. Angles wrap at the opposite side.
        Wedge wedge{at(from), along, plane, normal, length_in_units, 2 * std::numbers::pi};
        wedge.angle = wedge.place(at(apex(g, e))).theta;
        return wedge;
    }
    /// Calls f(edge, distance) once for each bent edge within `distance` of a point.
    template <class F>
    void for_each_near_bent_edge(const Point& p, double distance, const F& f) const {
        std::vector<std::uint32_t> known;
        boundary_.for_each_within(p, distance, [&](std::uint32_t face) {
            for (const std::uint32_t e : this->face(face).edge) {
                const auto& [from, to, along, length_of_edge] = edge(e);
                if (!is_bent(e) || std::find(known.begin(), known.end(), e) != known.end()) continue;
                known.push_back(e);
                const double apart = distance_to_segment(p, at(from), at(to));
                if (apart < distance) f(e, apart);
            }
        });
    }
    bool has_reflex_edge(const Point& p, double distance) const {
        bool any = false;
        for_each_near_bent_edge(
            p, distance, [&](std::uint32_t e, double) { any = any || wedge(e).angle > std::numbers::pi; });
        return any;
    }
    /// Returns the position of a boundary value.
    Point position(const BoundaryValue<3>& value) const noexcept {
        Point p{};
        for (std::size_t k = 0; k < value.handle.size(); ++k) p = p + value.weight[k] * at_[value.handle[k]];
        return p;
    }
    std::array<std::uint32_t, 3> vertices(std::uint32_t f) const noexcept { return face(f).corner; }
    /// Returns the outward unit normal of a face. Only PlaneField uses the point.
    const Point& outward_normal(std::uint32_t f, const Point&) const noexcept { return face(f).normal; }
    /// Returns the corners of a face without rounding to the tree, in the order of vertices(f).
    Corners<3> exact_corners(std::uint32_t f) const noexcept {
        const auto& exact = boundary_.exact(f);
        Corners<3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t l = 0; l < 3; ++l) {
                if (exact.vertex[l] == face(f).corner[k]) corners[k] = exact.corner[l];
            }
        }
        return corners;
    }
    /// Returns the barycentric weights of a point q inside face f and near x. q is a smooth function of x:
    /// the minimum of |q − x|² / (2 width²) − Σ_k log(distance of q from edge k), by a damped Newton method.
    /// The method starts from `nearest`, the weights of the point of the face nearest to x.
    std::array<double, 3> place_inside(std::uint32_t f, const Point& x, const Corners<3>& corners,
                                       const std::array<double, 3>& nearest, double width) const {
        const auto& face = this->face(f);
        const Point u = (1 / length(corners[1] - corners[0])) * (corners[1] - corners[0]),
                    v = cross(face.normal, u);
        double altitude = 0;
        for (const double inverse : face.inverse_altitude) altitude = (std::max)(altitude, 1 / inverse);
        const double pull = (std::min)(0.5, width / altitude), stiffness = 1 / (width * width);
        std::array<double, 3> weights = nearest;
        for (double& w : weights) w = (1 - pull) * w + pull / 3;
        Point q = point_on_facet(weights, corners);
        const auto distance_from = [&](std::size_t k) {
            return dot(face.across[k], corners[(k + 1) % 3] - q);
        };
        for (int step = 0; step < 60; ++step) {
            double gu = stiffness * dot(u, q - x), gv = stiffness * dot(v, q - x);
            double huu = stiffness, huv = 0, hvv = stiffness;
            for (std::size_t k = 0; k < 3; ++k) {
                const double inverse = 1 / distance_from(k);
                const double au = inverse * dot(face.across[k], u), av = inverse * dot(face.across[k], v);
                gu += au;
                gv += av;
                huu += au * au;
                huv += au * av;
                hvv += av * av;
            }
            const double determinant = huu * hvv - huv * huv;
            const double du = (huv * gv - hvv * gu) / determinant, dv = (huv * gu - huu * gv) / determinant;
            const double decrement = std::sqrt((std::max)(0.0, -(gu * du + gv * dv)));
            const double damping = decrement > 0.25 ? 1 / (1 + decrement) : 1;
            q = q + (damping * du) * u + (damping * dv) * v;
            if (decrement < 1e-9) break;
        }
        return nearest_on_facet(q, corners);
    }

    /// Moves a boundary point inside: towards x if x lies behind all faces at the point, else against the
    /// normals of these faces.
    Point moved_inside(const BoundaryValue<3>& value, const Point& x) const noexcept {
        const auto place = position(value);
        const auto way = x - place;
        const double distance = length(way);
        Point normals{};
        bool is_free = distance > 0;
        const auto k =
            std::size_t(std::max_element(value.weight.begin(), value.weight.end()) - value.weight.begin());
        for (const std::uint32_t f : star(value.handle[k])) {
            bool is_at = true;
            for (std::size_t l = 0; l < 3; ++l) {
                const auto& corner = face(f).corner;
                is_at = is_at && (!(value.weight[l] > 1e-9) ||
                                  std::find(corner.begin(), corner.end(), value.handle[l]) != corner.end());
            }
            if (!is_at) continue;
            is_free = is_free && dot(face(f).normal, way) < -1e-3 * distance;
            normals = normals + face(f).normal;
        }
        const double step = (std::max)(1e-6 * distance, 1e-5);
        is_free = is_free || !(length(normals) > 0);
        return is_free ? place + (std::min)(step / (std::max)(distance, 1e-9), 0.5) * way
                       : place - (step / length(normals)) * normals;
    }

private:
    const grid::TreeBoundary<3>& boundary_;
    Buffer<Point> at_;
    Buffer<std::uint32_t> star_ends_, star_; ///< the faces of each vertex
    Buffer<std::array<std::uint32_t, 2>> faces_of_edge_;
    Frame frame_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
