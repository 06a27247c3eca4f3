// make_cage in space, step 4: reduces the mesh to few vertices by edge collapses with quadric error
// metrics (Garland & Heckbert, Surface simplification using quadric error metrics, SIGGRAPH 1997).
// A collapse is only allowed if the new faces stay clear of the figure and of each other (as in
// Calderon & Boubekeur, Bounding proxies for shape approximation, SIGGRAPH 2017).
#pragma once

#include <cageform/enclose/space/shell.hpp>

#include <queue>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A weighted sum of squared distances from planes, as a function of the point x: x'Ax + 2 b'x + c.
struct Quadric {
    using Point = Vec<double, 3>;
    std::array<double, 6> a{}; ///< xx, xy, xz, yy, yz, zz
    Point b{};
    double c = 0;

    /// Adds the plane through `p`. The normal may have any length; its square multiplies the weight.
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
    /// Finds the minimum. Returns false if it is a line or a plane, up to rounding.
    bool least(Point& x) const noexcept {
        const Point r0{a[0], a[1], a[2]}, r1{a[1], a[3], a[4]}, r2{a[2], a[4], a[5]};
        const double det = dot(r0, cross(r1, r2)), trace = a[0] + a[3] + a[5];
        if (!(det > 1e-6 * trace * trace * trace)) return false;
        x = (-1 / det) * (b[0] * cross(r1, r2) + b[1] * cross(r2, r0) + b[2] * cross(r0, r1));
        return true;
    }
};

/// Collapses edges, the cheapest first.
class ShellReduction {
public:
    using Point = Vec<double, 3>;

    ShellReduction(Shell& shell, const ShellObstacles& obstacles)
        : shell_(shell)
        , obstacles_(obstacles)
        , clear_(*obstacles.lattice, obstacles.margin)
        , crossings_(shell, obstacles.gap())
        , quadric_(shell.points.size())
        , version_(shell.points.size(), 0)
        , changes_(shell.points.size(), 0)
        , mark_(shell.points.size(), 0)
        , count_(shell.whole_size()) {
        for (std::uint32_t f = 0; f < shell_.faces.size(); ++f) {
            const auto corner = shell_.corners(shell_.faces[f]);
            const Point n = area_normal(corner);
            const double size = length(n);
            if (!(size > 0)) continue;
            Quadric q;
            q.add_plane(n, corner[0], 0.5 / size); // unit normals, weighted by area
            for (const auto v : shell_.faces[f]) quadric_[v] += q;
        }
        const double h = obstacles.lattice->spacing();
        for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
            if (shell_.on_rim[v]) quadric_[v].add_plane({1, 0, 0}, {0, 0, 0}, 100 * h * h);
        }
        for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
            for (const auto w : shell_.neighbours(v)) {
                if (v < w) propose(v, w);
            }
        }
    }

    /// Reduces the whole cage to this many vertices, or as few as possible. Returns false if cancelled.
    bool reduce_to(std::size_t vertices, const Running& running) {
        const double first = double(count_);
        for (std::size_t step = 0; count_ > vertices; ++step) {
            if (step % 256 == 0 && !running.keep_going(std::clamp(
                                       (first - double(count_)) / (first - double(vertices)), 0.0, 1.0)))
                return false;
            if (queue_.empty() && !retry()) break;
            if (3 * count_ < hashed_) { // the faces have become larger than the cells of the hash
                crossings_.add_all_again();
                hashed_ = count_;
            }
            Collapse next = queue_.top();
            queue_.pop();
            if (is_current(next)) attempt(next);
        }
        return true;
    }

private:
    struct Collapse {
        double cost; ///< a lower bound
        std::uint32_t u, v;
        std::uint32_t versions; ///< the sum of both ends; if it has changed, the collapse is out of date
        std::uint32_t changes;  ///< of the faces about both ends, up to when the position was chosen
        std::uint32_t refused;  ///< a bit for each candidate that was refused
        std::uint32_t chosen;   ///< the cheapest candidate that is left, if the cost is that of a candidate

        bool operator<(const Collapse& other) const noexcept { // the queue has its largest on top
            return std::tie(other.cost, other.u, other.v) < std::tie(cost, u, v);
        }
    };
    static constexpr std::uint32_t unknown = ~std::uint32_t{0};

    bool is_current(const Collapse& c) const noexcept {
        return !shell_.star[c.u].empty() && !shell_.star[c.v].empty() &&
               c.versions == version_[c.u] + version_[c.v];
    }

    /// A penalty that keeps edges short where the quadric is flat, in units of area times squared distance.
    double stretch(std::uint32_t u, std::uint32_t v) const noexcept {
        const auto e = shell_.points[v] - shell_.points[u];
        return 1e-3 * dot(e, e) * dot(e, e);
    }
    void propose(std::uint32_t u, std::uint32_t v) {
        Quadric q = quadric_[u];
        q += quadric_[v];
        Point x{};
        const double least = q.least(x) ? q.at(x) : 0;
        queue_.push({least + stretch(u, v), (std::min)(u, v), (std::max)(u, v), version_[u] + version_[v], 0,
                     0, unknown});
    }
    /// Chooses a position for the merged vertex, tests it and makes the collapse. If the collapse becomes
    /// dearer than another one, it goes back into the queue. Costs need few operations and tests many, so
    /// only the cheapest collapse of all is tested.
    void attempt(Collapse c) {
        if (!links(c.u, c.v) || !collect(c.u, c.v)) {
            waiting_.push_back(c);
            return;
        }
        const std::uint32_t changes = changes_[c.u] + changes_[c.v];
        const bool is_known = c.chosen != unknown && c.changes == changes;
        if (!is_known) c.refused = 0;
        c.changes = changes;
        for (bool has_choice = is_known;; c.refused |= 1U << c.chosen, has_choice = false) {
            if (!has_choice) {
                if (!choose(c)) {
                    waiting_.push_back(c);
                    return;
                }
                if (!queue_.empty() && c.cost > queue_.top().cost) {
                    queue_.push(c);
                    return;
                }
            }
            const Point p = candidates_[c.chosen].position;
            if (is_clear_at(p) && !crosses(c, p)) {
                take(c, p);
                return;
            }
        }
    }
    /// Puts refused collapses back into the queue, since the mesh has changed around them.
    bool retry() {
        if (!changed_) return false;
        changed_ = false;
        for (const Collapse& c : waiting_) {
            if (is_current(c)) queue_.push(c);
        }
        waiting_.clear();
        return !queue_.empty();
    }

    /// The link condition: the edge has two faces (one on the rim), and its ends have no other common
    /// neighbours than the third vertices of these faces. The collapse then keeps the topology.
    bool links(std::uint32_t u, std::uint32_t v) {
        std::size_t at_edge = 0;
        for (const auto f : shell_.star[u]) at_edge += shell_.has(f, v) ? 1 : 0;
        const bool along_rim = shell_.on_rim[u] && shell_.on_rim[v];
        if (at_edge != (along_rim ? 1 : 2)) return false;
        const std::uint32_t near_u = ++last_mark_, near_both = ++last_mark_;
        mark_neighbours(u, near_u);
        std::size_t common = 0;
        for (const auto f : shell_.star[v]) {
            for (const auto w : shell_.faces[f]) {
                if (w == v || mark_[w] != near_u) continue;
                mark_[w] = near_both;
                ++common;
            }
        }
        return common == at_edge;
    }
    void mark_neighbours(std::uint32_t u, std::uint32_t mark) {
        for (const auto f : shell_.star[u]) {
            for (const auto w : shell_.faces[f]) {
                if (w != u) mark_[w] = mark;
            }
        }
    }

    /// Collects the faces that remain after a collapse of the edge, and the candidates for the position of
    /// the merged vertex: the minimum of the quadric, the midpoint and both ends, each at several places
    /// outwards along the normal. Returns false if the faces have no normal.
    bool collect(std::uint32_t u, std::uint32_t v) {
        about_.clear();
        clear_.forget();
        Point normal{};
        for (const auto& [from, other] : {std::pair(u, v), std::pair(v, u)}) {
            for (const auto f : shell_.star[from]) {
                auto face = shell_.faces[f];
                const Point n = area_normal(shell_.corners(face));
                normal = normal + n;
                if (shell_.has(f, other)) continue;
                while (face[0] != from) std::rotate(face.begin(), face.begin() + 1, face.end());
                const Point &a = shell_.points[face[1]], &b = shell_.points[face[2]];
                about_.push_back({f, a, b, dot(b - a, b - a), n, 0.1 * length(n)});
            }
        }
        const double size = length(normal);
        if (!(size > 0)) return false;
        normal = (1 / size) * normal;
        Quadric q = quadric_[u];
        q += quadric_[v];
        const Point &a = shell_.points[u], &b = shell_.points[v];
        const double h = obstacles_.lattice->spacing(), extra = stretch(u, v);
        std::array<Point, 4> starts{a, 0.5 * (a + b), a, b};
        const bool has_least = q.least(starts[0]) && is_near(starts[0], a, b);
        for (std::size_t n = 0; n < candidates_.size(); ++n) {
            auto& candidate = candidates_[n];
            candidate.position = constrained(
                u, v, starts[n / steps_out.size()] + (h * steps_out[n % steps_out.size()]) * normal);
            candidate.least = q.at(candidate.position) + extra;
            candidate.cost = n < steps_out.size() && !has_least ? beyond : 0;
        }
        return true;
    }
    /// Chooses the cheapest candidate that was not refused. Returns false if there is none.
    bool choose(Collapse& c) {
        c.cost = beyond;
        for (std::uint32_t n = 0; n < candidates_.size(); ++n) {
            auto& candidate = candidates_[n];
            if ((c.refused >> n & 1U) != 0 || !(candidate.least < c.cost)) continue;
            if (candidate.cost == 0) candidate.cost = candidate.least * shape_factor(candidate.position);
            if (!(candidate.cost < c.cost)) continue;
            c.cost = candidate.cost;
            c.chosen = n;
        }
        return c.cost < beyond;
    }
    static bool is_near(const Point& p, const Point& a, const Point& b) noexcept {
        const auto e = b - a, d = p - 0.5 * (a + b);
        return dot(d, d) <= 9 * dot(e, e);
    }
    /// Keeps a vertex of a half on the mirror plane, or clearly to its right.
    Point constrained(std::uint32_t u, std::uint32_t v, Point p) const noexcept {
        if (!shell_.half) return p;
        const double least = 0.4 * obstacles_.lattice->spacing();
        p[0] = shell_.on_rim[u] || shell_.on_rim[v] ? 0 : (std::max)(p[0], least);
        return p;
    }

    /// The factor on the cost for badly shaped faces: 1 for good ones, more for needles. It is infinite where
    /// a face would turn over, and at places too near to the figure.
    CAGEFORM_DETAIL_FLATTEN double shape_factor(const Point& p) const noexcept {
        double worst = 1;
        for (const About& at : about_) {
            const Point to_a = at.a - p, to_b = at.b - p, is = cross(to_a, to_b);
            const double size = length(is);
            if (!(dot(at.normal, is) > at.tenth * size)) return beyond;
            const double longest2 = (std::max)({at.across2, dot(to_a, to_a), dot(to_b, to_b)});
            worst = (std::min)(worst, triangle_quality(size, longest2));
        }
        if (!clear_.is_clear(p)) return beyond;
        return 1 + 12 * (std::max)(0.5 - worst, 0.0) + 40 * (std::max)(0.15 - worst, 0.0);
    }
    /// Whether the new faces, those collected, are clear of the figure.
    bool is_clear_at(const Point& p) {
        return clear_.are_clear(about_.size(), [&](std::size_t k) {
            return Corners<3>{p, about_[k].a, about_[k].b};
        });
    }
    /// Whether the new faces, those collected, cross other faces or each other.
    bool crosses(const Collapse& c, const Point& p) {
        const Point old = shell_.points[c.u];
        shell_.points[c.u] = p;
        fresh_.clear();
        for (const About& at : about_) {
            auto face = shell_.faces[at.face];
            std::replace(face.begin(), face.end(), c.v, c.u);
            fresh_.push_back(face);
        }
        const bool found =
            crossings_.any(fresh_, [&](std::uint32_t f) { return shell_.has(f, c.u) || shell_.has(f, c.v); });
        shell_.points[c.u] = old;
        return found;
    }

    void take(const Collapse& c, const Point& p) {
        for (const auto w : {c.u, c.v}) {
            const auto star = shell_.star[w];
            for (const auto f : star) {
                if (w == c.v && shell_.has(f, c.u)) continue; // a face at both ends is removed once
                crossings_.remove(f);
            }
        }
        const bool rim_u = shell_.on_rim[c.u], rim_v = shell_.on_rim[c.v];
        const auto both = shell_.star[c.u];
        for (const auto f : both) {
            if (shell_.has(f, c.v)) shell_.remove_face(f);
        }
        for (const auto f : shell_.star[c.v]) {
            std::replace(shell_.faces[f].begin(), shell_.faces[f].end(), c.v, c.u);
            shell_.star[c.u].push_back(f);
        }
        shell_.star[c.v].clear();
        shell_.points[c.u] = p;
        shell_.on_rim[c.u] = rim_u || rim_v;
        quadric_[c.u] += quadric_[c.v];
        for (const auto f : shell_.star[c.u]) crossings_.add(f);
        count_ -= shell_.half && !(rim_u && rim_v) ? 2 : 1;
        ++version_[c.u];
        ++changes_[c.u];
        changed_ = true;
        const std::uint32_t mark = ++last_mark_;
        for (const auto f : shell_.star[c.u]) {
            for (const auto w : shell_.faces[f]) {
                if (w == c.u || mark_[w] == mark) continue;
                mark_[w] = mark;
                ++changes_[w];
                propose(c.u, w);
            }
        }
    }

    /// A face about the edge that a collapse would change: its first corner moves.
    struct About {
        std::uint32_t face;
        Point a, b;     ///< the other corners
        double across2; ///< the squared distance of these
        Point normal;   ///< before the collapse
        double tenth;   ///< of the normal's length
    };
    /// A place for the merged vertex.
    struct Candidate {
        Point position;
        double least; ///< a lower bound of the cost
        double cost;  ///< 0 until it is computed
    };
    static constexpr double beyond = std::numeric_limits<double>::infinity();
    static constexpr std::array<double, 6> steps_out{0.0, 0.3, 0.8, 1.6, 3.0, 5.0}; ///< in spacings

    Shell& shell_;
    const ShellObstacles& obstacles_;
    ClearTest clear_;
    ShellCrossings crossings_;
    std::vector<Quadric> quadric_;
    std::vector<std::uint32_t> version_;
    std::vector<std::uint32_t> changes_; ///< how often a face about a vertex has changed
    std::vector<std::uint32_t> mark_;    ///< scratch of `links` and `take`
    std::uint32_t last_mark_ = 0;
    std::vector<About> about_; ///< the faces collected
    std::array<Candidate, 4 * steps_out.size()> candidates_;
    std::vector<Shell::Face> fresh_; ///< scratch of `crosses`
    std::size_t count_;
    std::size_t hashed_ = count_; ///< the number of vertices when the hash was made
    std::priority_queue<Collapse> queue_;
    std::vector<Collapse> waiting_;
    bool changed_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
