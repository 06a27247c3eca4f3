// Pushes points that lie inside a surface to its outside, such as clothes after a wrap.
#pragma once

#include <cageform/binding/detail/least_squares.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/fit/closest_places.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct PushOutOptions {
    double distance = 0; ///< from the surface at least, in the units of the mesh; not negative
    unsigned rounds = 8; ///< the first rounds spread the moves over the mesh, the last two do not
};

struct PushOutReport {
    Status status = Status::ok;
    std::size_t culprit = none; ///< index of the vertex or face that was refused
    std::size_t inside = 0;     ///< number of vertices inside the surface at the start
    std::size_t left = 0;       ///< number of vertices inside the surface at the end
    std::size_t moved = 0;      ///< number of vertices that moved by more than 1 % of the largest move
    double largest = 0;         ///< the largest move
    double mean = 0;            ///< the mean of the moves counted in `moved`
    std::size_t turned = 0;     ///< faces that the moves turned by more than 90°; their vertices went back
    std::size_t held = 0;       ///< vertices that went back, by halves, until no face was turned
    double seconds = 0;

    static constexpr std::size_t none = ~std::size_t{0};
};

namespace detail {

/// Moves the vertices of a mesh to the outside of a surface.
class OutwardPusher {
    using Point = Vec<double, 3>;
    using Term = LeastSquares::Term;

public:
    OutwardPusher(const ClosestPlaces& surface, const SurfaceMesh& mesh, std::span<const char> may_move,
                  const PushOutOptions& options, PushOutReport& report)
        : surface_(surface)
        , mesh_(mesh)
        , may_move_(may_move)
        , options_(options)
        , report_(report)
        , places_(mesh.vertices().begin(), mesh.vertices().end())
        , guesses_(places_.size(), no_vertex) {
        for (const auto& face : mesh.faces()) {
            for (std::size_t k = 0; k < 3; ++k)
                edges_.push_back(
                    {(std::min)(face[k], face[(k + 1) % 3]), (std::max)(face[k], face[(k + 1) % 3])});
        }
        std::sort(edges_.begin(), edges_.end());
        edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
        degree_.assign(places_.size(), 0);
        for (const auto& edge : edges_) {
            for (const std::uint32_t i : edge) degree_[i] += 1;
        }
    }

    Status run(const Running& running) {
        for (unsigned round = 0; round < options_.rounds; ++round) {
            std::size_t inside = 0;
            const auto needs = needed_moves(inside);
            if (round == 0) report_.inside = inside;
            if (std::none_of(needs.begin(), needs.end(), [](const Need& need) { return need.has_value(); }))
                break;
            std::vector<Point> moves(needs.size());
            for (std::size_t i = 0; i < needs.size(); ++i) moves[i] = needs[i].value_or(Point{});
            if (round + 2 < options_.rounds) spread(needs, moves);
            for (std::size_t i = 0; i < moves.size(); ++i) places_[i] = places_[i] + moves[i];
            if (!running.keep_going(double(round + 1) / double(options_.rounds + 1)))
                return Status::cancelled;
        }
        unturn_faces();
        (void)needed_moves(report_.left);
        std::vector<double> lengths;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            const auto d = places_[i] - mesh_.vertices()[i];
            lengths.push_back(std::sqrt(dot(d, d)));
            report_.largest = (std::max)(report_.largest, lengths.back());
        }
        for (const double length : lengths) {
            if (!(length > 0.01 * report_.largest)) continue;
            ++report_.moved;
            report_.mean += length;
        }
        report_.mean /= double((std::max)(report_.moved, std::size_t{1}));
        return Status::ok;
    }
    const std::vector<Point>& places() const noexcept { return places_; }

private:
    using Need = std::optional<Point>;

    /// Returns the moves to the surface plus the distance, of the vertices that need one.
    ///
    ///   inside  out: the number of these vertices that are inside
    std::vector<Need> needed_moves(std::size_t& inside) {
        std::vector<Need> needs(places_.size());
        for (std::size_t i = 0; i < places_.size(); ++i) {
            if (!may_move_.empty() && may_move_[i] == 0) continue;
            const ClosestPlace at = surface_.find(places_[i], {}, guesses_[i]);
            guesses_[i] = at.face;
            const auto d = places_[i] - at.place;
            const double height = std::copysign(std::sqrt(dot(d, d)), dot(d, at.normal));
            if (!(height < options_.distance * (1 - 1e-6)) || surface_.is_on_rim(at.face)) continue;
            inside += height < 0 ? 1 : 0;
            needs[i] = at.place + options_.distance * at.normal - places_[i];
        }
        return needs;
    }
    /// Spreads moves over the mesh: the field x with the least Σ d (p |x − u|² + q |x|²) + Σ_edges |x − x'|²,
    /// with the degree d of a vertex, p = 20 where a move u is needed, and q = 0.02.
    void spread(const std::vector<Need>& needs, std::vector<Point>& moves) const {
        constexpr double pull = 20, rest = 0.02;
        LeastSquares equations(moves.size(), 3, 0);
        constexpr Point zero{};
        for (std::uint32_t i = 0; i < moves.size(); ++i) {
            const double degree = (std::max)(degree_[i], 1.0);
            const Term term[] = {{i, 1}};
            equations.add(term, zero.v, rest * degree);
            if (needs[i]) equations.add(term, needs[i]->v, pull * degree);
        }
        for (const auto& [a, b] : edges_) {
            const Term terms[] = {{a, 1}, {b, -1}};
            equations.add(terms, zero.v, 1);
        }
        const auto solution = equations.solve();
        if (solution.status != Status::ok) return; // keeps the moves as they are
        for (std::size_t i = 0; i < moves.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) moves[i][k] = solution.values[3 * i + k];
        }
    }
    Point area_vector(const SurfaceMesh::Face& f, const auto& of) const noexcept {
        return cross(of[f[1]] - of[f[0]], of[f[2]] - of[f[0]]);
    }
    bool is_turned(const SurfaceMesh::Face& face) const noexcept {
        const Point before = area_vector(face, mesh_.vertices());
        return dot(before, before) > 0 && !(dot(area_vector(face, places_), before) > 0);
    }
    /// Moves the vertices of turned faces back by halves.
    void unturn_faces() {
        constexpr int halvings = 8;
        std::vector<char> is_held(places_.size());
        for (int n = 0; n < halvings; ++n) {
            std::vector<char> is_back(places_.size());
            std::size_t turned = 0;
            for (const auto& face : mesh_.faces()) {
                if (!is_turned(face)) continue;
                ++turned;
                for (const std::uint32_t i : face) is_back[i] = is_held[i] = 1;
            }
            if (n == 0) report_.turned = turned;
            if (turned == 0) break;
            for (std::size_t i = 0; i < places_.size(); ++i) {
                const Point& from = mesh_.vertices()[i];
                if (is_back[i] != 0) places_[i] = n + 1 < halvings ? from + 0.5 * (places_[i] - from) : from;
            }
        }
        report_.held = std::size_t(std::count(is_held.begin(), is_held.end(), char{1}));
    }

    const ClosestPlaces& surface_;
    const SurfaceMesh& mesh_;
    std::span<const char> may_move_;
    const PushOutOptions& options_;
    PushOutReport& report_;
    std::vector<Point> places_;
    std::vector<std::uint32_t> guesses_;
    std::vector<std::array<std::uint32_t, 2>> edges_;
    std::vector<double> degree_;
};

} // namespace detail

/// Returns which points lie outside a surface: on the side of the normal at their nearest place. O(#points
/// log #faces). Throws std::bad_alloc.
inline std::vector<char> are_outside(const ClosestPlaces& surface, std::span<const Vec<double, 3>> points) {
    std::vector<char> result;
    std::uint32_t guess = no_vertex;
    for (const auto& p : points) {
        const ClosestPlace at = surface.find(p, {}, guess);
        guess = at.face;
        result.push_back(guess == no_vertex || dot(p - at.place, at.normal) > 0 ? 1 : 0);
    }
    return result;
}

/// Moves the vertices of a figure that lie inside a surface to its outside, and spreads the moves over the
/// figure. No face of the figure turns by more than 90°. Faces may still cross the surface between vertices.
///
///   surface   triangles; points near its rim are not moved
///   figure    its vertices and faces; without faces, each vertex moves by itself
///   may_move  #vertices: 0 for vertices that need not be outside, but may move along; empty: all
///             must be outside. For clothes: `are_outside(source, vertices)` before the wrap
///   out       at least #vertices
///   cost      O(#vertices log #faces) and a sparse factorisation per round
///   fails     figure_empty; figure_not_finite, index_out_of_range, figure_has_no_size (the surface);
///             input_malformed (#may_move); value_not_finite (the distance); output_too_small; cancelled;
///             out_of_memory. `out` is then unchanged
template <MutablePointRangeIn<3> Out>
PushOutReport push_out(const SurfaceMesh& surface, const SurfaceMesh& figure, std::span<const char> may_move,
                       Out&& out, const PushOutOptions& options = {}, const Running& running = {}) {
    PushOutReport report;
    detail::run_into(report, [&] {
        Status status = detail::check_surface(surface, report.culprit);
        if (status == Status::ok) status = detail::check_vertices(figure, report.culprit);
        if (status != Status::ok) return status;
        if (!may_move.empty() && may_move.size() != figure.vertices().size()) return Status::input_malformed;
        if (!(options.distance >= 0) || !is_finite(options.distance)) return Status::value_not_finite;
        if (std::size(out) < figure.vertices().size()) return Status::output_too_small;
        const ClosestPlaces places(surface.vertices(), surface.faces());
        detail::OutwardPusher pusher(places, figure, may_move, options, report);
        status = pusher.run(running);
        if (status == Status::ok) status = running.end(status);
        if (status != Status::ok) return status;
        for (std::size_t i = 0; i < pusher.places().size(); ++i)
            store_point(out, i, vec_cast<range_scalar_t<Out>>(pusher.places()[i]));
        return Status::ok;
    });
    return report;
}

} // namespace cageform::inline CAGEFORM_ABI
