// make_cage in 2D, step 5: moves, inserts and removes vertices while the energy falls. Tightens the loop,
// which step 4 only enlarged, and evens out angles and lengths.
#pragma once

#include <cageform/enclose/plane/cage_loop.hpp>

#include <numbers>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

class LoopRelaxation {
public:
    using Point = Vec<double, 2>;

    LoopRelaxation(const LoopEnergy& energy, const Obstacles& obstacles)
        : energy_(energy)
        , obstacles_(obstacles) {}

    /// Moves each vertex in turn to the best position in 16 directions at three step lengths. Steps shrink
    /// from sweep to sweep.
    void relax(CageLoop& loop, int sweeps) const {
        double step = 4 * obstacles_.margin;
        for (int sweep = 0; sweep < sweeps; ++sweep) {
            for (std::size_t i = 0; i < loop.size(); ++i) move_vertex(loop, i, step, 0.1 * sweep);
            if (sweep % 3 == 2) step *= 0.7;
        }
    }

    /// Splits the longest edge until the loop has `vertices` vertices; its shape does not change. If a vertex
    /// lies nearby across the inside, the edge is split opposite to this vertex, so that limbs get vertices
    /// in pairs. Otherwise the edge is split in the middle.
    void insert(CageLoop& loop, std::size_t vertices) const {
        while (loop.size() < vertices) {
            std::size_t longest = 0;
            double most = -1;
            for (std::size_t i = 0; i < loop.edge_count(); ++i) {
                const double size = length(loop.points[loop.next(i)] - loop.points[i]);
                if (size <= most) continue;
                most = size;
                longest = i;
            }
            const Point x = split_position(loop, longest);
            loop.points.insert(loop.points.begin() + std::ptrdiff_t(longest) + 1, x);
        }
    }

    /// Removes the vertex whose removal costs least, inserts one elsewhere and relaxes; up to three times.
    /// This escapes from local minima of moves of single vertices.
    void reinsert(CageLoop& loop) const {
        for (int round = 0; round < 3; ++round) {
            double least = energy_.of(loop) - 1e-4;
            CageLoop best;
            for (std::size_t i = 0; i < loop.size(); ++i) {
                if (loop.is_end(i) || loop.size() <= 3 || !can_remove(loop, i)) continue;
                CageLoop trial = loop;
                trial.points.erase(trial.points.begin() + std::ptrdiff_t(i));
                // In radians. A sharp vertex may belong to a spike, which disappears only if its neighbours
                // move.
                constexpr double sharp = 1.2;
                if (angle_between(loop.before(i) - loop.points[i], loop.after(i) - loop.points[i]) < sharp)
                    relax_near(trial, i);
                insert(trial, loop.size());
                const double energy = energy_.of(trial);
                if (energy >= least) continue;
                least = energy;
                best = std::move(trial);
            }
            if (best.size() == 0) return;
            loop = std::move(best);
            relax(loop, 8);
        }
    }

private:
    struct Move {
        double energy;
        Point x;
    };

    /// Moves two vertices on each side of a removed vertex `i`.
    void relax_near(CageLoop& loop, std::size_t i) const {
        const auto n = std::ptrdiff_t(loop.size());
        double step = 2 * obstacles_.margin;
        for (int sweep = 0; sweep < 8; ++sweep, step *= 0.8) {
            for (const std::ptrdiff_t k : {-1, 0, -2, 1}) {
                const std::ptrdiff_t at = std::ptrdiff_t(i) + k;
                if (!loop.half || (at >= 0 && at < n))
                    move_vertex(loop, std::size_t((at + n) % n), step, 0.1 * sweep);
            }
        }
    }

    void move_vertex(CageLoop& loop, std::size_t i, double step, double rotation) const {
        const Point x = loop.points[i];
        const double now = energy_.about(loop, i);
        std::array<Move, 48> moves;
        std::size_t count = 0;
        for (int k = 0; k < 16; ++k) {
            const double angle = rotation + k * (std::numbers::pi / 8);
            Point u{std::cos(angle), std::sin(angle)};
            if (loop.is_end(i)) {
                if (k > 1) break;
                u = {0, k == 0 ? 1.0 : -1.0};
            }
            for (const double fraction : {1.0, 0.5, 0.25}) {
                loop.points[i] = x + (fraction * step) * u;
                const double energy = energy_.about(loop, i);
                if (energy < now - 1e-9) moves[count++] = {energy, loop.points[i]};
            }
        }
        loop.points[i] = x;
        std::sort(moves.begin(), moves.begin() + std::ptrdiff_t(count), [](const Move& a, const Move& b) {
            return std::tuple(a.energy, a.x[0], a.x[1]) < std::tuple(b.energy, b.x[0], b.x[1]);
        });
        for (std::size_t m = 0; m < count; ++m) {
            if (!can_move(loop, i, moves[m].x)) continue;
            loop.points[i] = moves[m].x;
            return;
        }
    }

    bool can_move(const CageLoop& loop, std::size_t i, const Point& x) const {
        if (!obstacles_.in_bounds(x)) return false;
        const std::size_t p = loop.previous(i), n = loop.next(i);
        const bool first = loop.half && i == 0, last = loop.half && i + 1 == loop.size();
        if (loop.half && !first && !last && x[0] < 0.5 * obstacles_.margin) return false;
        const Point& from = loop.points[p];
        const Point& to = loop.points[n];
        if (!first && obstacles_.any_mark_in(loop.points[i], x, from)) return false;
        if (!last && obstacles_.any_mark_in(loop.points[i], x, to)) return false;
        return (first || edge_is_free(loop, i, x, p)) && (last || edge_is_free(loop, i, x, n));
    }

    /// True if the edge from vertex `i`, moved to `x`, to its neighbour `end` is clear of all obstacles.
    bool edge_is_free(const CageLoop& loop, std::size_t i, const Point& x, std::size_t end) const {
        const Point& to = loop.points[end];
        const double gap = 0.25 * obstacles_.margin;
        for (std::size_t j = 0; j < loop.edge_count(); ++j) {
            const std::size_t k = loop.next(j);
            if (j == i || k == i) continue;
            const Point &a = loop.points[j], &b = loop.points[k];
            if (j == end || k == end) { // adjacent edges must not fold onto each other
                const auto u = x - to, v = (j == end ? b : a) - to;
                if (dot(u, v) > 0 && angle_between(u, v) < 0.05) return false;
            } else if (Obstacles::segments_near(x, to, a, b, gap)) {
                return false;
            }
        }
        const auto u = to - x, v = (end == loop.next(i) ? loop.before(i) : loop.after(i)) - x;
        if (dot(u, v) > 0 && angle_between(u, v) < 0.05) return false;
        return !obstacles_.is_near_other(x, to, gap) && is_clear(*obstacles_.lattice, x, to);
    }

    /// True if vertex `i` can be removed, so that an edge connects its neighbours.
    bool can_remove(const CageLoop& loop, std::size_t i) const {
        const Point &a = loop.points[loop.previous(i)], &b = loop.points[loop.next(i)];
        if (obstacles_.any_mark_in(a, loop.points[i], b)) return false;
        CageLoop without = loop;
        without.points.erase(without.points.begin() + std::ptrdiff_t(i));
        const std::size_t from = i > 0 ? i - 1 : without.size() - 1;
        return edge_is_free(without, from, a, without.next(from));
    }

    Point split_position(const CageLoop& loop, std::size_t edge) const {
        const Point &a = loop.points[edge], &b = loop.points[loop.next(edge)];
        const auto e = b - a;
        double nearest = 0.8 * length(e);
        Point position = 0.5 * (a + b);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point& p = loop.points[i];
            if (i == edge || i == loop.next(edge) || !(cross(e, p - a) > 0)) continue;
            const double t = segment_parameter(p, a, b);
            const Point foot = a + t * e;
            if (t < 0.3 || t > 0.7 || !(length(p - foot) < nearest) || !sees(loop, i, foot, edge)) continue;
            nearest = length(p - foot);
            position = foot;
        }
        return position;
    }
    /// True if no edge separates vertex `i` from `foot`; ignores edges at `i` and the edge that contains
    /// `foot`.
    static bool sees(const CageLoop& loop, std::size_t i, const Point& foot, std::size_t edge) noexcept {
        for (std::size_t j = 0; j < loop.edge_count(); ++j) {
            const std::size_t k = loop.next(j);
            if (j == edge || j == i || k == i) continue;
            if (Obstacles::segments_near(loop.points[i], foot, loop.points[j], loop.points[k], 0))
                return false;
        }
        return true;
    }

    const LoopEnergy& energy_;
    const Obstacles& obstacles_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
