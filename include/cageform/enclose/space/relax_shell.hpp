// make_cage in 3D, step 5: moves vertices and flips edges while the energy falls. Tightens the cage, which
// step 4 left loose, and evens out its faces.
#pragma once

#include <cageform/enclose/space/shell.hpp>

#include <numbers>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Energy that relaxation lowers. It has terms for volume, needles, short edges and folds. It is
/// dimensionless; its weights were tuned on sample cages.
class ShellEnergy {
public:
    using Point = Vec<double, 3>;

    ShellEnergy(double six_volumes, std::size_t vertices, double area, double regular)
        : six_volumes_(six_volumes)
        , length_(std::sqrt(area / double(2 * vertices) * (4 / std::numbers::sqrt3))) // equilateral faces
        , regular_(0.02 * regular) {}

    /// Energy of some faces and their edges. The faces around a vertex or at an edge have all terms that
    /// change when the vertex moves or the edge flips.
    CAGEFORM_DETAIL_FLATTEN double of(const Shell& shell,
                                      std::span<const std::uint32_t> faces) const noexcept {
        double volume = 0, shape = 0;
        for (const auto f : faces) {
            const auto& face = shell.faces[f];
            volume += shell.six_volumes(face);
            shape += quality_term(triangle_quality(shell.corners(face)));
            for (std::size_t k = 0; k < 3; ++k) shape += edge(shell, faces, f, face[k], face[(k + 1) % 3]);
        }
        return volume_term(volume) + shape;
    }

    double volume_term(double six_volumes) const noexcept { return six_volumes / six_volumes_; }
    double quality_term(double quality) const noexcept {
        const double poor = (std::max)(0.6 - quality, 0.0);
        return regular_ * poor * poor * (1 + 8 * (std::max)(0.2 - quality, 0.0));
    }
    double length_term(double length) const noexcept {
        const double is_short = (std::max)(0.4 - length / length_, 0.0);
        return 8 * regular_ * is_short * is_short;
    }
    /// Term of the edge between two faces, by the cosine between their normals.
    double fold_term(double cosine) const noexcept {
        const double fold = (std::max)(-0.5 - cosine, 0.0);
        return 4 * regular_ * fold * fold;
    }

private:
    /// Terms of one edge of face f. They count half if the face across the edge is listed too, because the
    /// edge is then visited twice.
    double edge(const Shell& shell, std::span<const std::uint32_t> faces, std::uint32_t f, std::uint32_t v,
                std::uint32_t w) const noexcept {
        const auto g = shell.face_across(f, v, w);
        const double share =
            g != Shell::none && std::find(faces.begin(), faces.end(), g) != faces.end() ? 0.5 : 1;
        const auto e = shell.points[w] - shell.points[v];
        double sum = length_term(length(e));
        if (g != Shell::none) {
            const Point n = area_normal(shell.corners(shell.faces[f])),
                        m = area_normal(shell.corners(shell.faces[g]));
            const double sizes = length(n) * length(m);
            if (sizes > 0) sum += fold_term(dot(n, m) / sizes);
        }
        return share * sum;
    }

    double six_volumes_;
    double length_;
    double regular_;
};

/// Energy of the faces around a vertex as a function of its position, without constant terms.
class StarEnergy {
public:
    using Point = Vec<double, 3>;

    explicit StarEnergy(const ShellEnergy& energy)
        : energy_(energy) {}

    void select(const Shell& shell, std::uint32_t v) {
        sides_.clear();
        volume_ = {};
        const auto& star = shell.star[v];
        for (const auto f : star) {
            const auto& face = shell.faces[f];
            const std::size_t k = face[0] == v ? 0 : face[1] == v ? 1 : 2;
            Side side;
            side.from = face[(k + 1) % 3];
            side.to = face[(k + 2) % 3];
            side.a = shell.points[side.from];
            side.b = shell.points[side.to];
            const auto e = side.b - side.a;
            side.length2 = dot(e, e);
            volume_ = volume_ + cross(side.a, side.b);
            const auto across = shell.face_across(f, side.from, side.to);
            if (across != Shell::none) {
                const Point n = area_normal(shell.corners(shell.faces[across]));
                const double size = length(n);
                if (size > 0) side.across = (1 / size) * n;
            }
            sides_.push_back(side);
        }
        normals_.resize(sides_.size());
        ends_at_rim_.clear();
        for (auto& side : sides_) {
            side.next = sides_.size();
            bool is_first = true;
            for (std::size_t j = 0; j < sides_.size(); ++j) {
                if (sides_[j].from == side.to) side.next = j;
                is_first = is_first && sides_[j].to != side.from;
            }
            if (is_first) ends_at_rim_.push_back(side.a);
        }
    }
    CAGEFORM_DETAIL_FLATTEN double at(const Point& p) noexcept {
        double sum = energy_.volume_term(dot(p, volume_));
        for (std::size_t k = 0; k < sides_.size(); ++k) {
            const Side& side = sides_[k];
            const Point to_a = side.a - p, to_b = side.b - p, n = cross(to_a, to_b);
            const double size = length(n), to_b2 = dot(to_b, to_b);
            sum += energy_.quality_term(
                triangle_quality(size, (std::max)({side.length2, dot(to_a, to_a), to_b2})));
            sum += energy_.length_term(std::sqrt(to_b2));
            normals_[k] = size > 0 ? (1 / size) * n : Point{};
            sum += energy_.fold_term(dot(normals_[k], side.across));
        }
        for (std::size_t k = 0; k < sides_.size(); ++k) {
            if (sides_[k].next < sides_.size())
                sum += energy_.fold_term(dot(normals_[k], normals_[sides_[k].next]));
        }
        for (const Point& a : ends_at_rim_) sum += energy_.length_term(length(a - p));
        return sum;
    }

private:
    /// A face at the vertex, described by the edge opposite to the vertex.
    struct Side {
        std::uint32_t from, to;
        Point a, b; ///< positions of `from` and `to`
        double length2;
        Point across{};   ///< unit normal of the face across the edge, or 0
        std::size_t next; ///< the side that begins at `to`; #sides at a rim
    };

    const ShellEnergy& energy_;
    std::vector<Side> sides_;
    Point volume_{};                 ///< its dot product with the position is six times the volume
    std::vector<Point> ends_at_rim_; ///< ends of edges not covered by `Side::b`
    std::vector<Point> normals_;     ///< scratch of `at`
};

/// Directions of trial steps: along the normal both ways, tangential, towards the neighbours' mean (at the
/// offset `to_middle`), and inwards at an angle. Their lengths are about 1.
inline std::array<Vec<double, 3>, 10> step_directions(const Vec<double, 3>& normal,
                                                      const Vec<double, 3>& to_middle) noexcept {
    using Point = Vec<double, 3>;
    const std::size_t smallest = std::fabs(normal[0]) < std::fabs(normal[1])
                                     ? (std::fabs(normal[0]) < std::fabs(normal[2]) ? 0 : 2)
                                     : (std::fabs(normal[1]) < std::fabs(normal[2]) ? 1 : 2);
    Point along{};
    along[smallest] = 1;
    Point across = cross(normal, along);
    across = (1 / length(across)) * across;
    along = cross(across, normal);
    const double away = length(to_middle);
    const Point inwards = Point{} - normal;
    return {normal,
            inwards,
            along,
            Point{} - along,
            across,
            Point{} - across,
            away > 0 ? (1 / away) * to_middle : along,
            0.7 * (along + inwards),
            0.7 * (across + inwards),
            0.7 * (inwards - along) - 0.3 * across};
}

class ShellRelaxation {
public:
    using Point = Vec<double, 3>;

    ShellRelaxation(Shell& shell, const ShellObstacles& obstacles, const ShellEnergy& energy)
        : shell_(shell)
        , obstacles_(obstacles)
        , clear_(*obstacles.lattice, obstacles.margin)
        , energy_(energy)
        , star_energy_(energy)
        , crossings_(shell, obstacles.gap()) {}

    /// Sweeps over the mesh: flips edges, then moves vertices by steps that shrink. Returns false if
    /// cancelled.
    bool relax(int sweeps, const Running& running) {
        double step = 2 * obstacles_.margin;
        idle_.assign(shell_.points.size(), false);
        for (int sweep = 0; sweep < sweeps; ++sweep) {
            if (!running.keep_going(double(sweep) / sweeps)) return false;
            for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
                for (const auto w : shell_.neighbours(v)) {
                    if (v < w) flip(v, w);
                }
            }
            for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
                if (!shell_.star[v].empty() && !idle_[v]) move_vertex(v, step);
            }
            if (sweep % 3 != 2) continue;
            step *= 0.85;
            idle_.assign(shell_.points.size(), false);
        }
        return true;
    }

private:
    struct Move {
        double energy;
        Point x;
    };

    /// Moves a vertex to the best valid position in ten directions at four step lengths.
    void move_vertex(std::uint32_t v, double step) {
        const auto& star = shell_.star[v];
        const Point x = shell_.points[v];
        Point normal{}, middle{};
        for (const auto f : star) normal = normal + area_normal(shell_.corners(shell_.faces[f]));
        const auto ring = shell_.neighbours(v);
        for (const auto w : ring) middle = middle + (1.0 / double(ring.size())) * (shell_.points[w] - x);
        if (!(length(normal) > 0)) return;
        const auto directions = step_directions((1 / length(normal)) * normal, middle);
        star_energy_.select(shell_, v);
        const double now = star_energy_.at(x);
        std::array<Move, 40> moves;
        std::size_t count = 0;
        for (const auto& u : directions) {
            for (const double fraction : {1.0, 0.5, 0.25, 0.125}) {
                const Point p = constrained(v, x + (fraction * step) * u);
                const double energy = star_energy_.at(p);
                if (energy < now - 1e-9) moves[count++] = {energy, p};
            }
        }
        std::sort(moves.begin(), moves.begin() + std::ptrdiff_t(count), [](const Move& a, const Move& b) {
            return std::tuple(a.energy, a.x[0], a.x[1], a.x[2]) <
                   std::tuple(b.energy, b.x[0], b.x[1], b.x[2]);
        });
        clear_.reset();
        for (std::size_t m = 0; m < count; ++m) {
            if (try_move(v, moves[m].x)) return;
        }
        idle_[v] = true;
    }
    Point constrained(std::uint32_t v, const Point& p) const noexcept {
        return shell_.allowed(p, shell_.on_rim[v], shell_.ring_of(v), obstacles_.lattice->spacing());
    }

    bool try_move(std::uint32_t v, const Point& p) {
        const auto& star = shell_.star[v];
        const Point x = shell_.points[v];
        bool good = clear_.is_clear(p) &&
                    shell_.is_right_of_mirror(p, shell_.on_rim[v], obstacles_.lattice->spacing());
        for (std::size_t k = 0; k < star.size() && good; ++k) { // no face may flip
            auto corner = shell_.corners(shell_.faces[star[k]]);
            const Point was = area_normal(corner);
            for (std::size_t i = 0; i < 3; ++i) corner[i] = shell_.faces[star[k]][i] == v ? p : corner[i];
            good = dot(was, area_normal(corner)) > 0;
        }
        if (!good) return false;
        shell_.points[v] = p;
        good = are_clear(star);
        good = good && are_apart_from_all(star); // the most expensive test comes last
        if (good) {
            rehash(star);
            reactivate_around(v);
        } else {
            shell_.points[v] = x;
        }
        return good;
    }
    /// Reactivates vertices whose energy depends on vertex v.
    void reactivate_around(std::uint32_t v) {
        for (const auto w : shell_.neighbours(v)) {
            for (const auto x : shell_.neighbours(w)) idle_[x] = false;
        }
    }
    bool are_clear(std::span<const std::uint32_t> faces) {
        return clear_.are_clear(faces.size(),
                                [&](std::size_t k) { return shell_.corners(shell_.faces[faces[k]]); });
    }
    /// True if the changed faces touch neither other faces nor each other.
    bool are_apart_from_all(std::span<const std::uint32_t> faces) {
        fresh_.clear();
        for (const auto f : faces) fresh_.push_back(shell_.faces[f]);
        return !crossings_.any(
            fresh_, [&](std::uint32_t f) { return std::find(faces.begin(), faces.end(), f) != faces.end(); });
    }
    void rehash(std::span<const std::uint32_t> faces) {
        for (const auto f : faces) {
            crossings_.remove(f);
            crossings_.add(f);
        }
    }

    /// Flips the edge v w (replaces it by the other diagonal of its two faces) if the energy falls.
    void flip(std::uint32_t v, std::uint32_t w) {
        std::array<std::uint32_t, 2> pair{};
        std::size_t count = 0;
        for (const auto f : shell_.star[v]) {
            if (shell_.has(f, w) && count < 2) pair[count++] = f;
        }
        if (count != 2) return;
        const auto a = shell_.third(pair[0], v, w), b = shell_.third(pair[1], v, w);
        const auto ring = shell_.neighbours(a);
        if (a == b || std::binary_search(ring.begin(), ring.end(), b)) return;
        if (shell_.are_of_one_ring(v, w) || shell_.are_of_one_ring(a, b)) return;
        if (shell_.on_rim[a] && shell_.on_rim[b]) return; // the image would have the same edge
        if (shell_.star[v].size() <= 3 || shell_.star[w].size() <= 3) return;
        const double before = energy_.of(shell_, pair);
        const std::array<Shell::Face, 2> old{shell_.faces[pair[0]], shell_.faces[pair[1]]};
        std::array<Point, 2> normals{};
        for (std::size_t k = 0; k < 2; ++k) normals[k] = area_normal(shell_.corners(old[k]));
        // The first face exchanges w for b, the second v for a; both keep their orientation.
        auto fresh = old;
        std::replace(fresh[0].begin(), fresh[0].end(), w, b);
        std::replace(fresh[1].begin(), fresh[1].end(), v, a);
        set_faces(pair, old, fresh);
        bool good = energy_.of(shell_, pair) < before - 1e-9;
        for (const auto& face : fresh) {
            const Point n = area_normal(shell_.corners(face));
            good = good && dot(n, normals[0]) > 0 && dot(n, normals[1]) > 0;
        }
        clear_.reset();
        if (good && are_clear(pair) && are_apart_from_all(pair)) { // the most expensive test comes last
            rehash(pair);
            reactivate_around(a);
            reactivate_around(b);
        } else {
            set_faces(pair, fresh, old);
        }
    }
    void set_faces(const std::array<std::uint32_t, 2>& pair, const std::array<Shell::Face, 2>& from,
                   const std::array<Shell::Face, 2>& to) {
        for (std::size_t k = 0; k < 2; ++k) {
            for (const auto v : from[k]) std::erase(shell_.star[v], pair[k]);
            for (const auto v : to[k]) shell_.star[v].push_back(pair[k]);
            shell_.faces[pair[k]] = to[k];
        }
    }

    Shell& shell_;
    const ShellObstacles& obstacles_;
    ClearTest clear_;
    const ShellEnergy& energy_;
    StarEnergy star_energy_;
    ShellCrossings crossings_;
    std::vector<Shell::Face> fresh_; ///< scratch of `are_apart_from_all`
    std::vector<bool> idle_; ///< per vertex: found no move, and its neighbourhood has not changed since
};

} // namespace cageform::inline CAGEFORM_ABI::detail
