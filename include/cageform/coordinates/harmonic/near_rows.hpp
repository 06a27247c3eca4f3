// Corrects the equations of a 3D tree for the kinks of the hat functions.
//
// A harmonic function of a handle is not smooth next to the boundary, because its boundary values, a hat
// function, have kinks at edges. An equation is a mean
//
//     u(x) = Σ_p s_p u(p) + Σ_n s_n u(n),   Σ s = 1,   Σ s · place = x,
//
// over boundary points p and nodes n, exact for linear functions only. A harmonic function L_i with the same
// kinks is therefore subtracted from u_i before the mean, and added again after it:
//
//     u_i(x) = Σ_p s_p φ_i(p) + Σ_n s_n u_i(n) + F(L_i),   F(L) = L(x) − Σ_p s_p L(p) − Σ_n s_n L(n).
//
// NearRows returns the numbers F(L_i). L_i is twice the double layer of the near hats,
//
//     D_v(x) = ∫ φ_v ∂G/∂n over the faces around v,   Σ_v D_v = 1 inside,
//
// which is the vertex part of Green coordinates (coordinates/green/space.hpp). On a plane, the double layer
// of its own faces is half of the hat. Let V be the set of vertices near x, and β the linear functions of a
// simplex of vertices of V: β_i is 1 at vertex i of the simplex and 0 at the others. Then
//
//     L_i = β_i + 2 Σ_{v∈V} (δ_iv − β_i(v)) D_v,
//
// so Σ_i F(L_i) = 0 and Σ_i c_i F(L_i) = 0 for the positions c_i and any V: partition of unity and linear
// precision are kept. At a convex bend of about 90 degrees, the double layer of each face is wrong on the
// other face. There the layer is reflected at the plane of the other face with the opposite sign (mirrors).
//
// Next to a bent edge, u_i − L_i is nearly k + c S, with S of coordinates/harmonic/wedge.hpp, the value k on
// the edge, and an unknown c. There the s_n are multiplied by a factor ρ that makes the mean exact for S. φ_i
// at the edge gets the share (1 − ρ) Σ s_n, which makes the mean exact for k.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/coordinates/harmonic/near_patch.hpp>
#include <cageform/grid/tree/links.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Computes F(L_i) for rows, in groups around common viewpoints.
class NearRows {
    using Point = NearField::Point;

public:
    ///   least  drops double layers below this share of a row's weight
    NearRows(const NearField& field, double least)
        : field_(field)
        , least_(least)
        , patch_(field) {}

    /// Begins a row at a point inside.
    ///
    ///   number  passed on by `flush`
    ///   size    size of the largest leaf around the point
    void begin(std::uint32_t number, const Point& x, double size) {
        rows_.push_back({number, std::uint32_t(terms_.size()), x, size, {}});
        terms_.push_back({std::uint32_t(points_.size()), false, 0});
        terms_.push_back(terms_.back()); // may become a point of an edge
        points_.push_back(x);
    }
    void at_node(std::uint32_t node, const Point& position, double weight) {
        auto known =
            std::find_if(nodes_.begin(), nodes_.end(), [&](const Node& n) { return n.node == node; });
        if (known == nodes_.end()) {
            nodes_.push_back({node, std::uint32_t(points_.size())});
            points_.push_back(position);
            known = nodes_.end() - 1;
        }
        add(known->point, true, weight);
    }
    void at_boundary(const BoundaryValue<3>& value, double weight) {
        add(std::uint32_t(points_.size()), false, weight);
        points_.push_back(field_.moved_inside(value, rows_.back().position));
    }

    /// Calls emit(number, vertex, amount) for the corrections of all rows, row by row, and removes the rows.
    /// Rows with a common viewpoint are corrected together. Calls scale(number, factor) where the weights of
    /// a row's nodes change.
    template <class Emit, class Scale>
    void flush(const Emit& emit, const Scale& scale) {
        pending_.resize(rows_.size());
        std::iota(pending_.begin(), pending_.end(), std::uint32_t{0});
        while (!pending_.empty()) {
            Point middle{};
            for (const std::uint32_t r : pending_)
                middle = middle + (1 / double(pending_.size())) * rows_[r].position;
            const auto nearest =
                std::min_element(pending_.begin(), pending_.end(), [&](std::uint32_t a, std::uint32_t b) {
                    return length(rows_[a].position - middle) < length(rows_[b].position - middle);
                });
            const auto from = rows_[*nearest].position;
            double reach = 0, size = 0;
            for (const std::uint32_t r : pending_) {
                reach = (std::max)(reach, length(rows_[r].position - from));
                size = (std::max)(size, rows_[r].size);
            }
            correct_from(from, radius_of_rows * size + reach, emit, scale);
        }
        clear();
    }

private:
    struct Row {
        /// The first term is the row's position. The second is a point of an edge, or the position again.
        std::uint32_t number, first;
        Point position;
        double size;
        Point off{}; ///< F of the position; not zero if the row is exact for a wedge
    };
    struct Term {
        std::uint32_t point;
        bool at_node;
        double weight;
    };
    struct Node {
        std::uint32_t node, point;
    };
    /// The radius of a row's near field, in sizes of the largest leaf around the row's node.
    static constexpr double radius_of_rows = 3;
    static constexpr std::uint32_t none = NearField::none;

    void add(std::uint32_t point, bool at_node, double weight) {
        terms_.push_back({point, at_node, -weight});
        terms_[rows_.back().first].weight += weight;
    }
    void clear() noexcept {
        rows_.clear();
        terms_.clear();
        points_.clear();
        nodes_.clear();
    }
    std::span<Term> terms_of(std::uint32_t row) noexcept {
        const std::size_t end = row + 1 < rows_.size() ? rows_[row + 1].first : terms_.size();
        return {terms_.data() + rows_[row].first, end - rows_[row].first};
    }
    /// Corrects the pending rows visible from a point; the rest stay queued.
    template <class Emit, class Scale>
    void correct_from(const Point& from, double radius, const Emit& emit, const Scale& scale) {
        const bool any = patch_.set_viewpoint(from, radius);
        seen_.clear();
        std::size_t hidden = 0;
        for (const std::uint32_t row : pending_) {
            if (rows_[row].position != from && !patch_.sees(rows_[row].position)) {
                pending_[hidden++] = row;
            } else if (any) {
                unsigned unused = 0;
                if (patch_.wedge()) fit_to_wedge(row, *patch_.wedge(), scale);
                for (const Term& term : terms_of(row)) unused |= patch_.mirrors_passed(points_[term.point]);
                seen_.push_back({unused, row});
            }
        }
        pending_.resize(hidden);
        std::sort(seen_.begin(), seen_.end());
        for (auto begin = seen_.begin(), end = begin; begin != seen_.end(); begin = end) {
            while (end != seen_.end() && end->first == begin->first) ++end;
            evaluate({begin, end});
            for (auto row = begin; row != end; ++row) correct(row->second, emit);
        }
    }
    /// Makes a row exact for the singular function S of a wedge too, if no other edge is near. Multiplies the
    /// weights of the row's nodes by a factor. The nearest point of the edge gets the missing sum of weights,
    /// so that constants stay exact.
    template <class Scale>
    void fit_to_wedge(std::uint32_t row, const Wedge& wedge, const Scale& scale) {
        const auto at = wedge.place(rows_[row].position);
        if (!is_alone(wedge, at, rows_[row])) return;
        const auto terms = terms_of(row), others = terms.subspan(2);
        const double here = wedge.singular(at);
        double nodes = 0, of_nodes = 0, of_row = terms[0].weight * here; // sum of weights; sums of S
        for (const Term& term : others) {
            const auto there = wedge.place(points_[term.point]);
            const double singular = wedge.singular(there);
            if (!wedge.has(there) || (!term.at_node && singular > 0.01 * here)) return;
            nodes -= term.at_node ? term.weight : 0;
            (term.at_node ? of_nodes : of_row) += (term.at_node ? -1 : 1) * term.weight * singular;
        }
        if (!(of_nodes > 0)) return;
        const double factor = std::clamp(of_row / of_nodes, 0.5, 2.0);
        auto& off = rows_[row].off;
        const auto foot = wedge.from + at.along * wedge.along;
        for (Term& term : others) {
            if (!term.at_node) continue;
            off = off + (factor - 1) * term.weight * (points_[term.point] - foot);
            term.weight *= factor;
        }
        terms[1] = {std::uint32_t(points_.size()), false, (factor - 1) * nodes};
        points_.push_back(foot + (std::min)(1e-5 / at.r, 0.5) * (rows_[row].position - foot)); // inside
        scale(rows_[row].number, factor);
    }
    /// Whether the edge of a wedge is the only edge near a row, so that S matters.
    bool is_alone(const Wedge& wedge, const Wedge::Place& at, const Row& row) const noexcept {
        constexpr double most_sizes = 3, free = 2; // unit: leaf size; distance from the edge
        return wedge.is_singular() && at.r < most_sizes * row.size && wedge.has(at) && at.along > at.r &&
               wedge.length - at.along > at.r && !patch_.has_other_bend(row.position, free * at.r);
    }
    /// Evaluates the layers at all points of rows with the same mirrors.
    void evaluate(std::span<const std::pair<unsigned, std::uint32_t>> rows) {
        place_of_.assign(points_.size(), none);
        places_.clear();
        for (const auto& row : rows) {
            for (const Term& term : terms_of(row.second)) {
                if (place_of_[term.point] != none) continue;
                place_of_[term.point] = std::uint32_t(places_.size());
                places_.push_back(points_[term.point]);
            }
        }
        patch_.evaluate(places_, rows.front().first);
    }
    template <class Emit>
    void correct(std::uint32_t row, const Emit& emit) {
        const auto terms = terms_of(row);
        amount_.resize(patch_.vertices().size());
        for (std::size_t v = 0; v < amount_.size(); ++v) {
            double sum = 0;
            for (const Term& term : terms) sum += term.weight * patch_.layer(v, place_of_[term.point]);
            amount_[v] = 2 * sum;
        }
        const double at_edge = -terms[1].weight;
        patch_.finish(amount_, least_ * terms.front().weight, rows_[row].off);
        if (at_edge != 0) {
            const auto& wedge = *patch_.wedge();
            const auto [from, to] = patch_.wedge_ends();
            const double share = wedge.place(points_[terms[1].point]).along / wedge.length;
            amount_[from] += (1 - share) * at_edge;
            amount_[to] += share * at_edge;
        }
        if (!std::all_of(amount_.begin(), amount_.end(), [](double x) { return is_finite(x); })) return;
        for (std::size_t v = 0; v < amount_.size(); ++v) {
            if (amount_[v] != 0) emit(rows_[row].number, patch_.vertices()[v], amount_[v]);
        }
    }

    const NearField& field_;
    double least_;
    NearPatch patch_;
    std::vector<Row> rows_;
    std::vector<Term> terms_;
    std::vector<Point> points_;
    std::vector<Node> nodes_;
    std::vector<double> amount_;
    std::vector<std::uint32_t> pending_;                   ///< rows not corrected yet
    std::vector<std::pair<unsigned, std::uint32_t>> seen_; ///< rows by the mirrors that they cannot use
    std::vector<std::uint32_t> place_of_;                  ///< by point: its index in places_, or none
    std::vector<Point> places_;
};

/// Adds F(L_i) to the data of equations next to the boundary (`corrections` of grid::links_of). Rows in one
/// cube, of twice the size of the node's smallest leaf, are corrected together.
template <class Data>
class NearCorrections {
public:
    NearCorrections(const grid::TreeNodes<3>& nodes, const Data& data, NearRows rows)
        : nodes_(nodes)
        , data_(data)
        , rows_(std::move(rows)) {}

    void add(const NodeEquation<3>& equation, grid::TreeLinks& out) {
        if (out.equations.diagonal.empty()) first_ = equation.node;
        std::array<std::int32_t, 4> cube{equation.smallest};
        for (std::size_t k = 0; k < 3; ++k) cube[k + 1] = equation.index[k] / (2 * equation.smallest);
        if (cube != cube_) finish(out);
        cube_ = cube;
        rows_.begin(equation.node, node_position<3>(equation.index), equation.largest);
        for (const auto& term : equation.terms) {
            if (term.node == grid::TreeNodes<3>::none) {
                rows_.at_boundary(term.value, term.weight);
            } else {
                rows_.at_node(term.node, node_position<3>(nodes_.index(term.node)), term.weight);
            }
        }
    }
    void finish(grid::TreeLinks& out) {
        auto& diagonal = out.equations.diagonal;
        rows_.flush(
            [&](std::uint32_t node, std::uint32_t vertex, double amount) {
                data_.for_each_weight({{vertex}, {1}}, [&](std::uint32_t handle, double) {
                    out.data.push_back({handle, node, float(amount)});
                    diagonal[node - first_] += double(float(amount));
                });
            },
            [&](std::uint32_t node, double factor) {
                for (auto& [column, weight] : out.equations.neighbours.of(node - first_)) {
                    const auto scaled = float(factor * double(weight));
                    diagonal[node - first_] += double(scaled) - double(weight);
                    weight = scaled;
                }
            });
    }

private:
    const grid::TreeNodes<3>& nodes_;
    Data data_;
    NearRows rows_;
    std::uint32_t first_ = 0;            ///< the first node of the run
    std::array<std::int32_t, 4> cube_{}; ///< of the pending rows
};

} // namespace cageform::inline CAGEFORM_ABI::detail
