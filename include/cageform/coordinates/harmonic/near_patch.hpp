// The double layers of the vertices near a viewpoint, for near_rows.hpp.
#pragma once

#include <cageform/coordinates/harmonic/near_field.hpp>
#include <cageform/coordinates/harmonic/near_simplex.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The double layers of the vertices near a viewpoint.
class NearPatch {
    using Point = NearField::Point;
    static constexpr std::uint32_t none = NearField::none;

public:
    explicit NearPatch(const NearField& field)
        : field_(field)
        , local_vertex_(field.vertices(), none)
        , local_edge_(field.edges(), none)
        , local_face_(field.faces(), none)
        , seen_(frame_) {}

    /// Chooses vertices, simplex and mirrors for points around x, a viewpoint inside. Returns false if no
    /// edge of a visible face lies within the radius, or if there are too few vertices. The radius shrinks
    /// until at most a few hundred faces are within it.
    bool set_viewpoint(const Point& x, double radius) {
        constexpr std::size_t most_candidates = 150, most_faces = 300;
        for (;; radius *= 0.7) {
            clear();
            origin_ = x;
            unit_ = radius;
            find_candidates();
            if (candidates_.size() > most_candidates) continue;
            choose_visible();
            if (!find_vertices() || vertices_.size() < 4) return false;
            if (!choose_simplex()) return false;
            add_stars();
            if (frame_.faces.size() <= most_faces) return true;
        }
    }

    /// The vertices V.
    std::span<const std::uint32_t> vertices() const noexcept { return vertices_; }

    /// Whether a point lies within the radius, and no face lies between the viewpoint and the point.
    bool sees(const Point& p) const noexcept {
        return length(p - origin_) < unit_ && std::none_of(
                                                  candidates_.begin(), candidates_.end(),
                                                  [&](const Candidate& c) { return hides(c.face, p); });
    }
    /// Returns the mirrors that a point lies behind, as bits.
    unsigned mirrors_passed(const Point& p) const noexcept {
        unsigned bits = 0;
        for (std::size_t k = 0; k < planes_.size(); ++k)
            bits |= beyond(planes_[k], in_units(p)) <= rounding ? 0u : 1u << k;
        return bits;
    }

    /// Returns the wedge at the bent edge whose ends and apices form the simplex, if there is one.
    const std::optional<Wedge>& wedge() const noexcept { return wedge_; }
    /// Returns the ends of the wedge's edge as indices of vertices().
    std::array<std::uint32_t, 2> wedge_ends() const noexcept { return wedge_ends_; }
    /// Whether another bent edge lies within a distance of a point.
    bool has_other_bend(const Point& p, double distance) const noexcept {
        return std::any_of(bends_.begin(), bends_.end(), [&](const Bend& bend) {
            const auto& edge = field_.edge(bend.edge);
            return bend.edge != wedge_edge_ && field_.is_bent(bend.edge) &&
                   distance_to_segment(p, field_.at(edge.from), field_.at(edge.to)) < distance;
        });
    }

    /// Evaluates the double layers at points.
    ///
    ///   unused  mirrors to leave out, as bits
    void evaluate(std::span<const Point> points, unsigned unused) {
        constexpr std::size_t lanes = lane_count<double>;
        const std::size_t batches = (points.size() + lanes - 1) / lanes;
        values_.resize(batches * vertices_.size());
        for (auto& value : values_) Simd<double>(0.0).store(value);
        local_.clear();
        for (const auto& p : points) local_.push_back(in_units(p));
        assign_mirrors(unused);
        for (std::size_t b = 0; b < batches; ++b) {
            Vec<Lanes<double>, 3> lane;
            Vec<Simd<double>, 3> p;
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t n = 0; n < lanes; ++n)
                    lane[k][n] = local_[(std::min)(b * lanes + n, local_.size() - 1)][k];
                p[k] = Simd<double>::load(lane[k]);
            }
            for (unsigned mirrored = 0; mirrored < (1u << mirrors_.size()); ++mirrored)
                add_layers(p, mirrored, values_.data() + b * vertices_.size());
        }
    }
    double layer(std::size_t vertex, std::size_t point) const noexcept {
        return double(
            values_[point / lane_count<double> * vertices_.size() + vertex][point % lane_count<double>]);
    }

    /// Returns the sum of share · layer of a vertex over the first points.
    ///
    ///   shares  one share per point, in SIMD blocks padded by 0
    double sum(std::size_t vertex, std::span<const Lanes<double>> shares) const noexcept {
        using X = Simd<double>;
        X sum(0.0);
        for (std::size_t b = 0; b < shares.size(); ++b)
            sum = multiply_add(X::load(shares[b]), X::load(values_[b * vertices_.size() + vertex]), sum);
        return ordered_sum(sum);
    }

    /// Turns 2 F(D_v) of all vertices into F(L_v); see NearSimplex.
    void finish(std::span<double> amount, double least, const Point& off) const noexcept {
        simplex_.finish(amount, least, (1 / unit_) * off);
    }

private:
    struct Candidate {
        std::uint32_t face;
        double distance;
        Point foot;
    };
    struct Bend { ///< an edge within the radius
        double distance;
        std::uint32_t edge;
    };
    struct Mirror { ///< in local units
        Point normal;
        double offset;
    };

    Point in_units(const Point& p) const noexcept { return (1 / unit_) * (p - origin_); }
    void clear() noexcept {
        for (const std::uint32_t v : all_vertices_) local_vertex_[v] = none;
        for (const std::uint32_t e : all_edges_) local_edge_[e] = none;
        for (const std::uint32_t f : all_faces_) local_face_[f] = none;
        all_vertices_.clear();
        all_edges_.clear();
        all_faces_.clear();
        frame_.vertices.clear();
        frame_.edges.clear();
        frame_.faces.clear();
        vertices_.clear();
        bends_.clear();
        candidates_.clear();
        planes_.clear();
        mirrors_.clear();
    }

    // ---- visible faces -------------------------------------------------------------------------------

    /// Finds the front-facing faces within the radius.
    void find_candidates() {
        field_.boundary().for_each_within(origin_, unit_, [&](std::uint32_t f) {
            if (!(height(f, origin_) < 0)) return;
            const auto foot = foot_on(f);
            const double distance = length(foot - origin_);
            if (distance < unit_) candidates_.push_back({f, distance, foot});
        });
    }
    /// Returns the point of a face nearest to the viewpoint.
    Point foot_on(std::uint32_t f) const noexcept {
        const auto corner = field_.corners(f);
        return point_on_facet(nearest_on_facet(origin_, corner), corner);
    }
    /// Lists the candidates that no other candidate hides.
    void choose_visible() {
        std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
            return a.distance != b.distance ? a.distance < b.distance : a.face < b.face;
        });
        visible_faces_.clear();
        for (std::size_t n = 0; n < candidates_.size(); ++n) {
            bool hidden = false;
            for (std::size_t m = 0; m < n && !hidden; ++m)
                hidden = hides(candidates_[m].face, origin_ + (1 - 1e-6) * (candidates_[n].foot - origin_));
            if (!hidden) visible_faces_.push_back(candidates_[n].face);
        }
    }
    /// Returns the height of a point above a face's plane, positive outside.
    double height(std::uint32_t f, const Point& p) const noexcept {
        const auto& face = field_.face(f);
        return dot(face.normal, p - field_.at(face.corner[0]));
    }
    /// Whether a front-facing face lies between the viewpoint and a point.
    bool hides(std::uint32_t f, const Point& to) const noexcept {
        const double from_height = height(f, origin_), to_height = height(f, to);
        if (!(to_height > 0)) return false;
        const auto q = origin_ + (from_height / (from_height - to_height)) * (to - origin_);
        const auto& face = field_.face(f);
        for (std::size_t k = 0; k < 3; ++k) {
            if (dot(face.across[k], q - field_.at(face.corner[(k + 1) % 3])) > 0) return false;
        }
        return true;
    }

    std::uint32_t add_vertex(std::uint32_t v) {
        auto& local = local_vertex_[v];
        if (local != none) return local;
        local = std::uint32_t(all_vertices_.size());
        all_vertices_.push_back(v);
        frame_.vertices.push_back(in_units(field_.at(v)));
        return local;
    }
    /// Lists the vertices of the visible faces, and of the faces across their edges within the radius.
    /// Returns whether there is such an edge.
    bool find_vertices() {
        bool any = false;
        for (const std::uint32_t f : visible_faces_) {
            const auto& face = field_.face(f);
            for (const std::uint32_t v : face.corner) add_vertex(v);
            for (std::size_t k = 0; k < 3; ++k) {
                const double distance = distance_to_segment(origin_, field_.at(face.corner[(k + 1) % 3]),
                                                            field_.at(face.corner[(k + 2) % 3]));
                if (!(distance < unit_)) continue;
                any = true;
                bends_.push_back({distance, face.edge[k]});
            }
        }
        std::sort(bends_.begin(), bends_.end(), [](const Bend& a, const Bend& b) {
            return a.distance != b.distance ? a.distance < b.distance : a.edge < b.edge;
        });
        for (const Bend& bend : bends_) {
            for (const std::uint32_t f : field_.faces_of_edge(bend.edge)) {
                if (f == none) continue;
                for (const std::uint32_t v : field_.face(f).corner) add_vertex(v);
            }
        }
        vertices_.assign(all_vertices_.begin(), all_vertices_.end());
        return any;
    }

    // ---- linear functions ----------------------------------------------------------------------------

    /// Chooses the ends and apices of the nearest bend, or a large simplex if their linear functions are
    /// large.
    bool choose_simplex() {
        constexpr double most = 2.5;
        wedge_.reset();
        wedge_edge_ = none;
        const std::span<const Point> vertices(frame_.vertices.data(), vertices_.size());
        const auto bend = std::find_if(bends_.begin(), bends_.end(),
                                       [this](const Bend& b) { return field_.is_bent(b.edge); });
        if (bend != bends_.end()) {
            const auto& [f, g] = field_.faces_of_edge(bend->edge);
            const auto& [from, to] = std::pair(field_.edge(bend->edge).from, field_.edge(bend->edge).to);
            const double largest = simplex_.set(vertices, {local_vertex_[from], local_vertex_[to],
                                                           local_vertex_[field_.apex(f, bend->edge)],
                                                           local_vertex_[field_.apex(g, bend->edge)]});
            if (largest < most) {
                set_wedge(bend->edge);
                return true;
            }
        }
        return simplex_.set_largest(vertices);
    }
    void set_wedge(std::uint32_t edge) {
        wedge_ = field_.wedge(edge);
        wedge_edge_ = edge;
        wedge_ends_ = {local_vertex_[field_.edge(edge).from], local_vertex_[field_.edge(edge).to]};
    }

    // ---- double layers -------------------------------------------------------------------------------

    /// Adds the faces around the vertices, except those whose layers are smooth within the radius.
    void add_stars() {
        constexpr double reach = 1.5; // in radii
        for (const std::uint32_t v : vertices_) {
            const bool is_near = length(field_.at(v) - origin_) < reach * unit_;
            for (const std::uint32_t f : field_.star(v)) {
                if (local_face_[f] != none) continue;
                if (!is_near && !(length(foot_on(f) - origin_) < reach * unit_)) continue;
                local_face_[f] = std::uint32_t(all_faces_.size());
                all_faces_.push_back(f);
                const auto& from = field_.face(f);
                auto& face = frame_.faces.push_back();
                for (std::size_t k = 0; k < 3; ++k) {
                    face.corner[k] = add_vertex(from.corner[k]);
                    face.edge[k] = add_edge(from.edge[k]);
                    face.across[k] = from.across[k];
                    face.inverse_altitude[k] = unit_ * from.inverse_altitude[k];
                    face.cosine[k] = from.cosine[k];
                }
                face.normal = from.normal;
            }
        }
        seen_.corners.resize((std::max)(seen_.corners.size(), frame_.vertices.size()));
        seen_.edges.resize((std::max)(seen_.edges.size(), frame_.edges.size()));
        is_edge_used_.resize(frame_.edges.size());
        find_planes();
    }
    std::uint32_t add_edge(std::uint32_t e) {
        auto& local = local_edge_[e];
        if (local != none) return local;
        local = std::uint32_t(all_edges_.size());
        all_edges_.push_back(e);
        const auto& from = field_.edge(e);
        frame_.edges.push_back(
            {add_vertex(from.from), add_vertex(from.to), from.direction, from.length / unit_});
        return local;
    }

    static constexpr double most_cosine = 0.2; ///< of nearly perpendicular faces: 78 to 102 degrees
    /// Finds the mirror planes: those of the faces at the nearest convex bends of about 90 degrees.
    void find_planes() {
        for (const Bend& bend : bends_) {
            const auto& [f, g] = field_.faces_of_edge(bend.edge);
            if (g == none) continue;
            const auto &a = field_.face(f), &b = field_.face(g);
            if (!(std::fabs(dot(a.normal, b.normal)) < most_cosine)) continue;
            if (!(height(f, field_.at(field_.apex(g, bend.edge))) < 0)) continue; // reflex
            for (const std::uint32_t n : {f, g}) {
                if (planes_.size() == 3) return;
                const Point normal = field_.face(n).normal;
                const double offset = dot(normal, in_units(field_.at(field_.face(n).corner[0])));
                if (std::all_of(planes_.begin(), planes_.end(), [&](const Mirror& other) {
                        return std::fabs(dot(normal, other.normal)) < most_cosine;
                    }))
                    planes_.push_back({normal, offset});
            }
        }
    }
    static constexpr double rounding = 1e-5; ///< in local units
    double beyond(const Mirror& mirror, const Point& p) const noexcept {
        return dot(mirror.normal, p) - mirror.offset;
    }
    /// Whether a face lies in the plane of a mirror.
    bool is_in(const Mirror& mirror, std::uint32_t f) const noexcept {
        const auto& face = field_.face(f);
        if (!(dot(face.normal, mirror.normal) > 0.99)) return false;
        for (const std::uint32_t v : face.corner) {
            if (std::fabs(beyond(mirror, in_units(field_.at(v)))) > rounding) return false;
        }
        return true;
    }
    /// Takes the mirrors whose bits are not set, and finds the faces in them.
    void assign_mirrors(unsigned unused) {
        mirrors_.clear();
        for (std::size_t k = 0; k < planes_.size(); ++k) {
            if (((unused >> k) & 1u) == 0) mirrors_.push_back(planes_[k]);
        }
        mirror_of_.assign(all_faces_.size(), none);
        if (mirrors_.size() < 2) mirrors_.clear();
        for (std::size_t n = 0; n < all_faces_.size() && !mirrors_.empty(); ++n) {
            for (std::uint32_t k = 0; k < mirrors_.size(); ++k) {
                if (is_in(mirrors_[k], all_faces_[n])) mirror_of_[n] = k;
            }
            if (mirror_of_[n] == none) continue;
            for (std::uint32_t k = 0; k < mirrors_.size(); ++k) {
                for (const std::uint32_t v : field_.face(all_faces_[n]).corner) {
                    if (k != mirror_of_[n] && beyond(mirrors_[k], in_units(field_.at(v))) > rounding) {
                        mirror_of_[n] = none;
                        break;
                    }
                }
                if (mirror_of_[n] == none) break;
            }
        }
    }
    /// Adds layers at the images of points in the mirrors whose bits are set. If no bit is set, these are the
    /// layers of all faces, else those of the faces that lie in the other mirrors.
    CAGEFORM_DETAIL_FLATTEN void add_layers(Vec<Simd<double>, 3> p, unsigned mirrored,
                                            Lanes<double>* to) noexcept {
        using X = Simd<double>;
        double sign = 1;
        for (std::size_t k = 0; k < mirrors_.size(); ++k) {
            if (((mirrored >> k) & 1u) == 0) continue;
            const auto normal = mirrors_[k].normal;
            const X twice = X(2.0) * (product(p, normal) - X(mirrors_[k].offset));
            for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = p[axis] - twice * X(normal[axis]);
            sign = -sign;
        }
        const auto counts = [&](std::size_t f) {
            return mirrored == 0 || (mirror_of_[f] != none && ((mirrored >> mirror_of_[f]) & 1u) == 0);
        };
        std::fill(is_edge_used_.begin(), is_edge_used_.end(), std::uint8_t{0});
        bool any = false;
        for (std::size_t f = 0; f < frame_.faces.size(); ++f) {
            if (!counts(f)) continue;
            any = true;
            for (const std::uint32_t e : frame_.faces[f].edge) is_edge_used_[e] = 1;
        }
        if (!any) return;
        find_corners(frame_, p, seen_);
        for (std::size_t e = 0; e < frame_.edges.size(); ++e) {
            if (is_edge_used_[e] != 0) find_edge<false>(frame_.edges[e], 0.0, seen_, seen_.edges[e]);
        }
        constexpr double full = 4 * std::numbers::pi;
        for (std::size_t f = 0; f < frame_.faces.size(); ++f) {
            if (!counts(f)) continue;
            const auto& face = frame_.faces[f];
            const FaceIntegrals<double, true> of(face, frame_, seen_, 0.0);
            for (std::size_t k = 0; k < 3; ++k) {
                if (face.corner[k] >= vertices_.size()) continue;
                const X share(sign * face.inverse_altitude[k] / full);
                add(share * (of.rho[k] * of.angle + of.height * of.across(face, k)), to[face.corner[k]]);
            }
        }
    }

    const NearField& field_;
    Point origin_{};
    double unit_ = 1;
    Buffer<std::uint32_t> local_vertex_, local_edge_, local_face_;    ///< by number in the cage; or none
    std::vector<std::uint32_t> all_vertices_, all_edges_, all_faces_; ///< numbers in the cage
    std::vector<std::uint32_t> vertices_, visible_faces_;
    NearSimplex simplex_;
    std::vector<Candidate> candidates_;
    std::vector<Bend> bends_;
    std::optional<Wedge> wedge_;
    std::uint32_t wedge_edge_ = none;
    std::array<std::uint32_t, 2> wedge_ends_{};
    std::vector<Mirror> planes_, mirrors_;
    std::vector<std::uint32_t> mirror_of_;
    std::vector<std::uint8_t> is_edge_used_;
    NearField::Frame frame_; ///< relative to the viewpoint, in units of the radius; the vertices V come first
    GreenRows<double, 3> seen_;
    Buffer<Point> local_; ///< the points in local units
    Buffer<Lanes<double>> values_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
