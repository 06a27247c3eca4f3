// Moves the vertices of a mesh to the outside of a surface.
#pragma once

#include <cageform/binding/detail/least_squares.hpp>
#include <cageform/fit/closest_places.hpp>
#include <cageform/fit/types/push_out.hpp>
#include <cageform/parallel/running.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Moves the vertices of a mesh to the outside of a surface.
class OutwardPusher {
    using Point = Vec<double, 3>;
    using Term = LeastSquares::Term;
    static constexpr unsigned rounds = 8; ///< the last two do not spread the moves over the mesh

public:
    OutwardPusher(const ClosestPlaces& surface, const SurfaceMesh& mesh, std::span<const char> may_move,
                  double distance, PushOutReport& report)
        : surface_(surface)
        , mesh_(mesh)
        , may_move_(may_move)
        , distance_(distance)
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
        for (unsigned round = 0; round < rounds; ++round) {
            std::size_t inside = 0;
            const auto needs = needed_moves(inside);
            if (round == 0) report_.inside = inside;
            if (std::none_of(needs.begin(), needs.end(), [](const Need& need) { return need.has_value(); }))
                break;
            std::vector<Point> moves(needs.size());
            for (std::size_t i = 0; i < needs.size(); ++i) moves[i] = needs[i].value_or(Point{});
            if (round + 2 < rounds) spread(needs, moves);
            for (std::size_t i = 0; i < moves.size(); ++i) places_[i] = places_[i] + moves[i];
            if (!running.keep_going(double(round + 1) / double(rounds + 1))) return Status::cancelled;
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
            const ClosestPlaces::Place at = surface_.find(places_[i], {}, guesses_[i]);
            guesses_[i] = at.face;
            const auto d = places_[i] - at.place;
            const double height = std::copysign(std::sqrt(dot(d, d)), dot(d, at.normal));
            if (!(height < distance_ * (1 - 1e-6)) || surface_.is_on_rim(at.face)) continue;
            inside += height < 0 ? 1 : 0;
            needs[i] = at.place + distance_ * at.normal - places_[i];
        }
        return needs;
    }
    /// Spreads moves u over the mesh: the field x with the least Σ d (p |x − u|² + q |x|²) + Σ |x − y|². The
    /// last sum is over edges, whose other ends have y; d is the degree of a vertex; p = 20 where a move is
    /// needed, else 0.
    void spread(const std::vector<Need>& needs, std::vector<Point>& moves) const {
        constexpr double pull = 20, rest = 0.02;
        LeastSquares equations(moves.size(), 3, 0);
        constexpr Point zero{};
        for (std::uint32_t i = 0; i < moves.size(); ++i) {
            const double degree = (std::max)(degree_[i], 1.0);
            const Term term[] = {{i, 1}};
            equations.add(term, zero.v, rest * degree);
            if (const Need& need = needs[i]; need) equations.add(term, need->v, pull * degree);
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
    double distance_;
    PushOutReport& report_;
    std::vector<Point> places_;
    std::vector<std::uint32_t> guesses_;
    std::vector<std::array<std::uint32_t, 2>> edges_;
    std::vector<double> degree_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
