// make_cage in 3D: the collapse of an edge. The merged vertex has several candidate positions, with costs by
// quadric error metrics (Garland & Heckbert, Surface simplification using quadric error metrics, SIGGRAPH
// 1997).
#pragma once

#include <cageform/enclose/space/shell.hpp>

#include <optional>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Weighted sum of squared distances from planes at a point x: x'Ax + 2 b'x + c.
struct Quadric {
    using Point = Vec<double, 3>;
    std::array<double, 6> a{}; ///< xx, xy, xz, yy, yz, zz
    Point b{};
    double c = 0;

    /// Adds the plane through `p`. The squared length of the normal multiplies the weight.
    void add_plane(const Point& normal, const Point& p, double weight) noexcept {
        const double offset = -dot(normal, p);
        std::size_t n = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = i; j < 3; ++j) a[n++] += weight * normal[i] * normal[j];
            b[i] += weight * offset * normal[i];
        }
        c += weight * offset * offset;
    }
    Quadric& operator+=(const Quadric& other) noexcept {
        for (std::size_t i = 0; i < 6; ++i) a[i] += other.a[i];
        b = b + other.b;
        c += other.c;
        return *this;
    }
    double at(const Point& x) const noexcept {
        const double square = a[0] * x[0] * x[0] + a[3] * x[1] * x[1] + a[5] * x[2] * x[2] +
                              2 * (a[1] * x[0] * x[1] + a[2] * x[0] * x[2] + a[4] * x[1] * x[2]);
        return (std::max)(square + 2 * dot(b, x) + c, 0.0);
    }
    Point times(const Point& x) const noexcept {
        return {a[0] * x[0] + a[1] * x[1] + a[2] * x[2], a[1] * x[0] + a[3] * x[1] + a[4] * x[2],
                a[2] * x[0] + a[4] * x[1] + a[5] * x[2]};
    }
    /// Finds the minimum. Returns false if it is not unique (a line or a plane), up to rounding.
    bool least(Point& x) const noexcept {
        const Point r0{a[0], a[1], a[2]}, r1{a[1], a[3], a[4]}, r2{a[2], a[4], a[5]};
        const double det = dot(r0, cross(r1, r2)), trace = a[0] + a[3] + a[5];
        if (!(det > 1e-6 * trace * trace * trace)) return false;
        x = (-1 / det) * (b[0] * cross(r1, r2) + b[1] * cross(r2, r0) + b[2] * cross(r0, r1));
        return true;
    }
};

/// Evaluates, tests and applies the collapse of one edge at a time.
class EdgeCollapse {
public:
    using Point = Vec<double, 3>;
    /// Set of candidate positions, one bit each.
    using CandidateSet = std::uint32_t;
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    static constexpr double infinite = std::numeric_limits<double>::infinity();

    EdgeCollapse(Shell& shell, const ShellObstacles& obstacles)
        : shell_(shell)
        , spacing_(obstacles.lattice->spacing())
        , gap_(obstacles.gap())
        , clear_(*obstacles.lattice, obstacles.margin)
        , quadric_(shell.points.size())
        , mark_(shell.points.size(), 0) {
        for (const auto& face : shell_.faces) {
            const auto corner = shell_.corners(face);
            const Point n = area_normal(corner);
            const double size = length(n);
            if (!(size > 0)) continue;
            Quadric q;
            q.add_plane(n, corner[0], 0.5 / size); // unit normals, weighted by area
            for (const auto v : face) quadric_[v] += q;
        }
        for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
            if (shell_.on_rim[v]) quadric_[v].add_plane({1, 0, 0}, {0, 0, 0}, 100 * spacing_ * spacing_);
            if (const auto r = shell_.ring_of(v); r != none)
                quadric_[v].add_plane(shell_.rings[r].normal, shell_.points[v], 100 * spacing_ * spacing_);
        }
    }

    /// Makes `fits` test for crossing faces from now on. Further calls adapt the hash to the current face
    /// size.
    void test_crossings() { crossings_.emplace(shell_, gap_); }

    /// Lower bound of the cost of a collapse, in area times squared distance.
    double cost_bound(std::uint32_t u, std::uint32_t v) const noexcept {
        Quadric q = quadric_[u];
        q += quadric_[v];
        Point x{};
        return (q.least(x) ? q.at(x) : 0) + length_penalty(u, v);
    }

    /// Selects the edge u v: collects the faces that remain after its collapse and the candidates. These are
    /// the minimum of the quadric, the midpoint and both ends, each at several offsets outwards along the
    /// normal. Returns false if the faces have no normal.
    CAGEFORM_DETAIL_FLATTEN bool select(std::uint32_t u, std::uint32_t v) {
        u_ = u;
        v_ = v;
        incident_.clear();
        clear_.reset();
        has_costs_ = false;
        normal_ = {};
        for (const auto& [from, other] : {std::pair(u, v), std::pair(v, u)}) {
            const Point& x = shell_.points[from];
            for (const auto f : shell_.star[from]) {
                const auto& face = shell_.faces[f];
                const std::size_t k = face[0] == from ? 0 : face[1] == from ? 1 : 2;
                const std::uint32_t i = face[k == 2 ? 0 : k + 1], j = face[k == 0 ? 2 : k - 1];
                const Point &a = shell_.points[i], &b = shell_.points[j];
                const Point n = cross(a - x, b - x);
                normal_ = normal_ + n;
                if (i == other || j == other) continue;
                incident_.push_back({f, a, b, dot(b - a, b - a), n, 0.01 * dot(n, n)});
            }
        }
        const double size = length(normal_);
        if (!(size > 0)) return false;
        normal_ = (1 / size) * normal_;
        q_ = quadric_[u];
        q_ += quadric_[v];
        const Point &a = shell_.points[u], &b = shell_.points[v];
        const Point e = b - a, middle = 0.5 * (a + b);
        bases_ = {a, middle, a, b};
        Point least{};
        has_least_ = q_.least(least) && dot(least - middle, least - middle) <= 9 * dot(e, e);
        if (has_least_) bases_[0] = least;
        return true;
    }

    /// Returns the cheapest candidate that is not rejected, and sets its cost. Returns `none` if no candidate
    /// is left.
    std::uint32_t cheapest(CandidateSet rejected, double& cost) {
        if (!has_costs_) set_cost_bounds();
        for (;;) {
            std::uint32_t best = none;
            cost = infinite;
            for (std::uint32_t n = 0; n < cost_.size(); ++n) {
                if ((rejected >> n & 1U) != 0 || !(cost_[n] < cost)) continue;
                cost = cost_[n];
                best = n;
            }
            if (best == none || (is_exact_ >> best & 1U) != 0) return best;
            is_exact_ |= CandidateSet{1} << best;
            cost_[best] *= shape_factor(candidate(best));
        }
    }

    /// True if the new faces are clear of the figure and cross no other faces.
    bool fits(std::uint32_t n) {
        const Point p = candidate(n);
        if (!clear_.are_clear(incident_.size(),
                              [&](std::size_t k) { return Corners<3>{p, incident_[k].a, incident_[k].b}; }))
            return false;
        return !crossings_ || !crosses(p, *crossings_);
    }
    /// The link condition: the edge has two faces (one on the rim), and its ends share no neighbours except
    /// the third vertices of these faces. In a half, the collapse must not connect two rim vertices by an
    /// interior edge, because the image would have the same edge.
    bool keeps_topology() {
        if (!keeps_rings()) return false;
        std::size_t at_edge = 0;
        for (const auto f : shell_.star[u_]) at_edge += shell_.has(f, v_) ? 1 : 0;
        if (at_edge != (is_along_rim() ? 1 : 2)) return false;
        const bool swapped = shell_.on_rim[v_] && !shell_.on_rim[u_];
        const std::uint32_t first = swapped ? v_ : u_, second = swapped ? u_ : v_;
        const bool onto_rim = shell_.on_rim[first] && !shell_.on_rim[second];
        const std::uint32_t about_first = ++last_mark_, about_both = ++last_mark_;
        for (const auto f : shell_.star[first]) {
            for (const auto w : shell_.faces[f]) mark_[w] = about_first;
        }
        mark_[first] = about_both;
        std::size_t common = 0;
        for (const auto f : shell_.star[second]) {
            for (const auto w : shell_.faces[f]) {
                if (w == second || mark_[w] == about_both) continue;
                if (mark_[w] == about_first) {
                    mark_[w] = about_both;
                    ++common;
                } else if (onto_rim && shell_.on_rim[w]) {
                    return false;
                }
            }
        }
        return common == at_edge;
    }

    /// Applies the collapse: the first end moves to a candidate, the second is removed.
    void apply(std::uint32_t n) {
        const Point p = candidate(n);
        if (crossings_) {
            for (const IncidentFace& at : incident_) crossings_->remove(at.face);
        }
        const bool is_on_rim = is_onto_rim();
        if (!shell_.ring.empty()) {
            if (shell_.are_of_one_ring(u_, v_)) --shell_.rings[ring()].vertices;
            shell_.ring[u_] = ring();
        }
        const auto both = shell_.star[u_];
        for (const auto f : both) {
            if (!shell_.has(f, v_)) continue;
            if (crossings_) crossings_->remove(f);
            shell_.remove_face(f);
        }
        for (const auto f : shell_.star[v_]) {
            std::replace(shell_.faces[f].begin(), shell_.faces[f].end(), v_, u_);
            shell_.star[u_].push_back(f);
        }
        shell_.star[v_].clear();
        shell_.points[u_] = p;
        shell_.on_rim[u_] = is_on_rim;
        quadric_[u_] += quadric_[v_];
        if (!crossings_) return;
        for (const auto f : shell_.star[u_]) crossings_->add(f);
    }
    bool is_along_rim() const noexcept { return shell_.on_rim[u_] && shell_.on_rim[v_]; }

private:
    /// A face at the selected edge that the collapse changes: its first corner moves.
    struct IncidentFace {
        std::uint32_t face;
        Point a, b;       ///< other corners
        double across2;   ///< squared distance between a and b
        Point normal;     ///< before the collapse
        double hundredth; ///< 0.01 · squared length of the normal
    };
    static constexpr std::size_t base_count = 4;
    static constexpr std::array<double, 6> offsets{0.0, 0.3, 0.8, 1.6, 3.0, 5.0}; ///< in spacings

    /// Penalty that keeps edges short where the quadric is flat.
    double length_penalty(std::uint32_t u, std::uint32_t v) const noexcept {
        const auto e = shell_.points[v] - shell_.points[u];
        return 1e-3 * dot(e, e) * dot(e, e);
    }
    Point candidate(std::uint32_t n) const noexcept {
        const Point p = bases_[n / offsets.size()] + (spacing_ * offsets[n % offsets.size()]) * normal_;
        return shell_.allowed(p, is_onto_rim(), ring(), spacing_);
    }
    bool is_onto_rim() const noexcept { return shell_.on_rim[u_] || shell_.on_rim[v_]; }
    /// Ring of the merged vertex.
    std::uint32_t ring() const noexcept {
        const auto r = shell_.ring_of(u_);
        return r != none ? r : shell_.ring_of(v_);
    }
    /// True if each ring remains a closed path with at least four vertices (including its image), and no
    /// other edge joins two of them.
    bool keeps_rings() const noexcept {
        const auto r = shell_.ring_of(u_), s = shell_.ring_of(v_);
        if (r == none && s == none) return true;
        if (r != none && s != none)
            return r == s && shell_.rings[r].vertices > (shell_.rings[r].is_open ? 3 : 4) && !is_along_rim();
        const std::uint32_t first = r != none ? u_ : v_, second = r != none ? v_ : u_;
        if (shell_.on_rim[second] && !shell_.on_rim[first]) return false; // the ring would touch the rim
        for (const auto f : shell_.star[second]) {
            for (const auto w : shell_.faces[f]) {
                if (w != first && shell_.are_of_one_ring(first, w) &&
                    shell_.face_across(none, first, w) == none)
                    return false;
            }
        }
        return true;
    }

    /// Sets lower bounds of the costs of all candidates.
    void set_cost_bounds() noexcept {
        const Point slopes = q_.times(normal_);
        const double curved = dot(normal_, slopes), extra = length_penalty(u_, v_);
        for (std::uint32_t s = 0, n = 0; s < base_count; ++s) {
            const double start = q_.at(bases_[s]), slope = dot(slopes, bases_[s]) + dot(q_.b, normal_);
            for (const double step : offsets) {
                const double t = spacing_ * step;
                const double error = shell_.half || ring() != none
                                         ? q_.at(candidate(n))
                                         : (std::max)(start + t * (2 * slope + t * curved), 0.0);
                cost_[n++] = s == 0 && !has_least_ ? infinite : error + extra;
            }
        }
        is_exact_ = 0;
        has_costs_ = true;
    }
    /// Cost factor for poor faces: 1 for good faces, larger for needles. It is infinite if a face would flip
    /// or if the position is too close to the figure.
    CAGEFORM_DETAIL_FLATTEN double shape_factor(const Point& p) const noexcept {
        double worst2 = 1; // minimum of (twice the area / squared longest side)^2
        for (const IncidentFace& at : incident_) {
            const Point to_a = at.a - p, to_b = at.b - p, is = cross(to_a, to_b);
            const double size2 = dot(is, is), along = dot(at.normal, is);
            if (!(along > 0 && along * along > at.hundredth * size2)) return infinite;
            const double longest2 = (std::max)({at.across2, dot(to_a, to_a), dot(to_b, to_b)});
            worst2 = (std::min)(worst2, size2 / (longest2 * longest2));
        }
        if (!clear_.is_clear(p) || !shell_.is_right_of_mirror(p, is_onto_rim(), spacing_)) return infinite;
        const double worst = triangle_quality(std::sqrt(worst2), 1);
        return 1 + 12 * (std::max)(0.5 - worst, 0.0) + 40 * (std::max)(0.15 - worst, 0.0);
    }
    /// True if the new faces cross other faces or each other.
    bool crosses(const Point& p, ShellCrossings& crossings) {
        const Point old = shell_.points[u_];
        shell_.points[u_] = p;
        fresh_.clear();
        for (const IncidentFace& at : incident_) {
            auto face = shell_.faces[at.face];
            std::replace(face.begin(), face.end(), v_, u_);
            fresh_.push_back(face);
        }
        const bool found =
            crossings.any(fresh_, [&](std::uint32_t f) { return shell_.has(f, u_) || shell_.has(f, v_); });
        shell_.points[u_] = old;
        return found;
    }

    Shell& shell_;
    double spacing_;
    double gap_;
    ClearTest clear_;
    std::optional<ShellCrossings> crossings_;
    std::vector<Quadric> quadric_;
    std::vector<std::uint32_t> mark_; ///< scratch of `keeps_topology`
    std::uint32_t last_mark_ = 0;
    std::vector<Shell::Face> fresh_; ///< scratch of `crosses`

    std::uint32_t u_ = 0, v_ = 0; ///< selected edge
    std::vector<IncidentFace> incident_;
    Point normal_{};
    Quadric q_;
    std::array<Point, base_count> bases_{};
    bool has_least_ = false; ///< true if the first base position is the minimum of the quadric
    bool has_costs_ = false;
    std::array<double, base_count * offsets.size()> cost_{}; ///< cost of each candidate, or a lower bound
    CandidateSet is_exact_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
