// The data of a model of a leaf (leaf_models.hpp): nodes and boundary points visible from a point of the
// leaf.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/cage/detail/primitives.hpp>
#include <cageform/grid/tree/cut_tree.hpp>
#include <cageform/grid/tree/nodes.hpp>
#include <cageform/grid/tree/screening.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A C² function that increases from 0 at t ≤ 0 to 1 at t ≥ 1.
inline double smooth_step(double t) noexcept {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * t * (10 - 15 * t + 6 * t * t);
}

/// Points around a leaf with known function values, and the visibility from the viewpoint, a point of the
/// leaf.
///
///   Field  the faces of the boundary: NearField in 3D, PlaneField in 2D
template <class Field>
class LeafData {
public:
    static constexpr std::size_t D = Field::dimension;
    using Point = Vec<double, D>;
    using Cell = typename grid::CellTree<D>::Cell;
    using Nodes = grid::TreeNodes<D>;

    /// A point with known function values: a node or a boundary point.
    struct Datum {
        Point at;
        double weight;
        std::uint32_t node; ///< `none` for a boundary point, given by `value`
        BoundaryValue<D> value;
    };

    LeafData(const LeafData&) = delete;
    LeafData& operator=(const LeafData&) = delete;
    ~LeafData() = default;

    /// Whether there are enough data for a linear function.
    bool is_valid() const noexcept { return data_.size() > D; }
    double size() const noexcept { return size_; } ///< side of the leaf
    double screening() const noexcept { return tree_.screening(); }
    std::span<const Datum> data() const noexcept { return data_; }
    bool is_near() const noexcept { return is_near_; } ///< whether the leaf or a neighbour is cut or outside

    /// Returns the visibility of a point from the viewpoint, in [1e-6, 1]; 1e-6 behind a face.
    double visibility(const Point& x) const noexcept {
        constexpr double least = 1e-6; // not 0, because a point can be invisible from all viewpoints
        if (!is_near_) return 1;
        // Ignores faces at the end, which are rounded. 2D walls have points on both sides.
        constexpr double end = D == 2 ? 1e-6 : 1e-3;
        if (field_.boundary().first_met(place_, (1 - end) * (x - place_))) return least;
        double factor = 1;
        for (const auto& [from, to] : reflex_) {
            const double here = distance_to_segment(x, from, to);
            if (!(here > 0)) continue;
            const double passes =
                D == 2 ? distance_to_segment(from, place_, x) : segment_distance(place_, x, from, to);
            factor *= smooth_step(passes / (0.7 * here));
        }
        return least + (1 - least) * factor;
    }

    /// Returns the offset of a datum from the middle of the leaf, in half leaf sizes, plus 16. The offset is
    /// an integer if no face is near the leaf, because all data are then nodes.
    std::array<char, D> place_in_leaf(const Datum& datum) const noexcept {
        std::array<char, D> place{};
        for (std::size_t k = 0; k < D; ++k) place[k] = char(16 + 2 * (datum.at[k] - middle_[k]) / size_);
        return place;
    }

    /// Returns the viewpoints of a leaf: its middle if no face cuts the leaf; else a point far from faces,
    /// and up to three more points, each invisible from all earlier viewpoints.
    static std::vector<Point> places_of(const grid::CutTree<D>& tree, const Field& field, const Cell& leaf) {
        constexpr std::size_t most = 4, across = 5;
        constexpr double free = 0.3; // in leaf sizes; larger distances from faces do not raise the score
        const auto middle = leaf.middle();
        const auto facets = tree.facets(leaf.number);
        const auto& boundary = tree.boundary();
        if (tree.state(leaf.number) == grid::CellState::in) return {middle};
        std::vector<std::pair<double, Point>> inside;
        std::array<Point, across> row{};
        for (std::size_t n = 0; n < (D == 2 ? across : across * across); ++n) {
            for (std::size_t x = 0; x < across; ++x) {
                for (std::size_t k = 0, rest = x + n * across; k < D; ++k, rest /= across)
                    row[x][k] = leaf.low[k] + (0.02 + 0.24 * double(rest % across)) * leaf.size;
            }
            const auto is_inside = tree.are_inside(row);
            for (std::size_t x = 0; x < across; ++x) {
                const Point& p = row[x];
                if (!is_inside[x]) continue;
                inside.push_back({(std::min)(boundary.nearest(facets, p).distance, free * leaf.size) -
                                      0.25 * length(p - middle),
                                  p});
            }
        }
        std::sort(inside.begin(), inside.end(),
                  [](const auto& a, const auto& b) { return a.first > b.first; });
        const bool can_occlude = facets.size() > 2 || field.has_reflex_edge(middle, 0.9 * leaf.size);
        std::vector<Point> places;
        for (const auto& [score, p] : inside) {
            if (places.size() == most || (!places.empty() && !can_occlude)) break;
            if (std::all_of(places.begin(), places.end(), [&, to = p](const Point& from) {
                    return boundary.first_met(from, to - from, facets).has_value();
                }))
                places.push_back(p);
        }
        return places;
    }

protected:
    using Index = std::array<std::int32_t, D>;

    LeafData(const grid::CutTree<D>& tree, const Nodes& nodes, const Field& field, const Cell& leaf,
             const Point& place)
        : tree_(tree)
        , nodes_(nodes)
        , field_(field)
        , leaf_(leaf)
        , middle_(leaf.middle())
        , place_(place)
        , size_(leaf.size) {
        find_surroundings();
        data_.reserve(40);
    }

    /// Adds the corners of the leaf, of its neighbours of the same size, and of larger neighbours.
    ///
    ///   most_outer  maximum number of axes along which a corner lies beyond the leaf
    void add_nodes(std::size_t most_outer) {
        for (std::size_t n = 0; n < (D == 2 ? 16 : 64); ++n) {
            Index index = leaf_.low;
            std::size_t outer = 0;
            for (std::size_t k = 0, rest = n; k < D; ++k, rest /= 4) {
                index[k] += leaf_.size * (std::int32_t(rest % 4) - 1);
                outer += rest % 4 % 3 == 0 ? 1 : 0;
            }
            if (outer <= most_outer) add_node(index, true);
        }
        for (const Cell& cell : larger_) {
            for (std::size_t n = 0; n < grid::CellTree<D>::children; ++n) {
                const Index index = cell.corner(n);
                const auto is_known = [p = node_position<D>(index)](const Datum& datum) {
                    return datum.at == p;
                };
                if (std::none_of(data_.begin(), data_.end(), is_known)) add_node(index, false);
            }
        }
    }
    /// Adds a node unless the boundary occludes it.
    ///
    ///   adds_occluder  whether the occluding boundary point is added instead
    void add_node(const Index& index, bool adds_occluder) {
        const auto p = node_position<D>(index);
        bool is_in_tree = true;
        for (const std::int32_t x : index) is_in_tree = is_in_tree && x >= 0 && x <= tree_.cells().size();
        // An empirical formula. In 3D an occluding point has the weight of the occluded node.
        const auto weight = [&](const Point& at) {
            const double apart = length(at - middle_) / size_, square = apart * apart;
            return 1 / (0.3 + square * square * (D == 2 ? square : 1));
        };
        if (is_near_ && p != place_) {
            const auto& boundary = tree_.boundary();
            if (const auto met = boundary.first_met(place_, p - place_, facets_)) {
                if (!adds_occluder) return;
                auto value = met->value;
                if (met->fraction < 0.1) { // thin domain: otherwise all data would be next to the viewpoint
                    const auto nearest = boundary.nearest(facets_, p);
                    if (!boundary.first_met(place_, (1 - 1e-3) * (nearest.position - place_), facets_))
                        value = nearest.value;
                }
                const Point place = field_.moved_inside(value, place_);
                data_.push_back({place, 3 * weight(D == 2 ? place : p), Nodes::none, value});
                return;
            }
        }
        const std::uint32_t node = is_in_tree ? nodes_.find(index) : Nodes::none;
        if (node == Nodes::none) return;
        data_.push_back({p, weight(p), node, {}});
    }

    /// Turns harmonic polynomials into solutions of the screened equation (grid/tree/screening.hpp).
    ///
    ///   q          their argument, relative to the middle of the leaf, in leaf sizes
    ///   degree_of  degree_of(k): the degree of polynomial k, ascending
    template <class DegreeOf>
    void screen(const Point& q, std::span<double> polynomials, const DegreeOf& degree_of) const noexcept {
        if (!(screening() > 0)) return;
        const double square = screening() * size_ * size_ * dot(q, q);
        double factor = screened_factor<D>(0, square);
        for (std::size_t k = 0; k < polynomials.size(); ++k) {
            if (k > 0 && degree_of(k) != degree_of(k - 1)) factor = screened_factor<D>(degree_of(k), square);
            polynomials[k] *= factor;
        }
    }

    const grid::CutTree<D>& tree_;
    const Nodes& nodes_;
    const Field& field_;
    Cell leaf_;
    Point middle_, place_;
    double size_;
    bool is_near_ = false;
    std::vector<Datum> data_;
    std::vector<std::pair<Point, Point>> reflex_; ///< edges (2D: vertices) that can occlude points

private:
    /// Finds the larger neighbours of the leaf, and the facets that cut the leaf or a neighbour.
    void find_surroundings() {
        is_near_ = tree_.state(leaf_.number) != grid::CellState::in;
        Cell around = leaf_; // contains all neighbours of the leaf
        const auto is_around = [&] {
            for (std::size_t k = 0; k < D; ++k) {
                if (leaf_.low[k] == around.low[k] || leaf_.low[k] + leaf_.size == around.low[k] + around.size)
                    return false;
            }
            return true;
        };
        while (around.number != 0 && !is_around()) around = tree_.cells().parent_of(around.number);
        for (std::int32_t n = 0; n < (D == 2 ? 9 : 27); ++n) {
            Index doubled{};
            for (std::size_t k = 0, rest = std::size_t(n); k < D; ++k, rest /= 3)
                doubled[k] = 2 * leaf_.low[k] + (2 * std::int32_t(rest % 3) - 1) * leaf_.size;
            const Cell cell = tree_.cells().leaf_at(doubled, around);
            const auto state = tree_.state(cell.number);
            is_near_ = is_near_ || state != grid::CellState::in;
            if (state == grid::CellState::cut) {
                const auto facets = tree_.facets(cell.number);
                facets_.insert(facets_.end(), facets.begin(), facets.end());
            }
            if (cell.size > leaf_.size && state != grid::CellState::out) larger_.push_back(cell);
        }
        sort_unique(facets_);
    }

    std::vector<Cell> larger_;
    std::vector<std::uint32_t> facets_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
