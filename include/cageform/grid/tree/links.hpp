// The Laplace equation at the corners of a tree's leaves.
//
// In the plane harmonic means of what a node sees (grid/tree/harmonic_mean.hpp), of order four. In space,
// and in the plane where there are none:
//
// along each axis the second difference of Shortley and Weller (J. Appl. Phys. 9 (1938)) between the
// ends of two links. A link ends on the boundary, on a node, or, at a hanging node, on a place of the
// opposite face of the large leaf beside it, whose value is interpolated there. What that adds to the
// second differences along the other axes is taken off again (Min, Gibou, Ceniceros, J. Comput. Phys.
// 218 (2006); here by second moments, which covers interpolation that ends on the boundary). All
// weights are positive, linear functions exact, the order is two.
#pragma once

#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/level_rows.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A part of the right-hand side: the weight of a handle's value at a node.
struct TreeData {
    std::uint32_t handle, node;
    float weight;
};

/// The equations of the nodes, times the volume about each.
struct TreeLinks {
    detail::TreeEquations equations;
    Buffer<TreeData> data;  ///< sorted by handle, then by node
    Buffer<float> volume;   ///< by node
    double least_share = 1; ///< of all factors that the corrections put before second differences
};

} // namespace grid

namespace detail {

struct NoStar {
    template <class... Any>
    explicit NoStar(const Any&...) noexcept {}
};

/// Makes the equations node by node. Data is what cages call it: data.for_each_weight(value, f).
template <std::size_t D, class Data>
class LinkMaker {
public:
    using Nodes = grid::TreeNodes<D>;
    using Index = typename Nodes::Index;
    using Cell = typename grid::CellTree<D>::Cell;
    using AxisRay = grid::AxisRay<D>;

    LinkMaker(const grid::CutTree<D>& tree, const Nodes& nodes, const Data& data)
        : tree_(tree)
        , nodes_(nodes)
        , data_(data)
        , star_(tree, nodes) {}

    grid::TreeLinks make() {
        for (std::uint32_t node = 0; node < nodes_.count(); ++node) add_equation(node);
        std::sort(out_.data.begin(), out_.data.end(), [](const grid::TreeData& a, const grid::TreeData& b) {
            return a.handle != b.handle ? a.handle < b.handle : a.node < b.node;
        });
        out_.equations.neighbours.shrink_to_fit();
        return std::move(out_);
    }

private:
    struct Side {
        double length;
        bool hangs;
        Vec<double, D> moments; ///< of an interpolated end, about it
        grid::CutStencil<D> end;
    };

    struct MomentSink {
        const Nodes& nodes;
        Side& side;
        Vec<double, D> centre;

        void at_node(const Index& index, double share) {
            side.end.add(nodes.find(index), share);
            add(node_position<D>(index), share);
        }
        void at_place(const BoundaryValue<D>& value, const Vec<double, D>& place, double share) {
            side.end.add(value, share);
            add(place, share);
        }
        void add(const Vec<double, D>& place, double share) {
            for (std::size_t k = 0; k < D; ++k)
                side.moments[k] += share * (place[k] - centre[k]) * (place[k] - centre[k]);
        }
    };

    void set_side(Side& side, const Index& index, const LeavesAbout<D>& about, std::size_t axis, bool up) {
        side.hangs = false;
        side.end.node_count = side.end.place_count = 0;
        const std::size_t bit = std::size_t{1} << axis;
        const Cell* leaf = about.smallest(bit, up ? bit : 0);
        const bool beyond = leaf == nullptr; // on the boundary, up to rounding
        if (beyond) leaf = about.smallest();
        const auto facets = tree_.facets(leaf->number);
        const auto& boundary = tree_.boundary();
        side.length = leaf->size;
        Index there = index;
        there[axis] += up ? leaf->size : -leaf->size;
        const auto place = node_position<D>(there);
        const auto end_on = [&](const grid::Hit<D>& hit, const AxisRay& ray) {
            side.length = std::clamp(ray.distance(hit.position), grid::on_facet_distance, side.length);
            side.end.add(hit.value, 1.0);
        };
        const AxisRay ray{node_position<D>(index), axis, up, side.length};
        if (const auto hit = boundary.first_hit(facets, ray)) return end_on(*hit, ray);
        const std::uint32_t node = beyond ? Nodes::none : nodes_.find(there);
        if (node != Nodes::none) {
            side.end.add(node, 1.0);
            return;
        }
        bool is_corner = true;
        for (std::size_t k = 0; k < D; ++k)
            is_corner = is_corner && (there[k] == leaf->low[k] || there[k] == leaf->low[k] + leaf->size);
        if (beyond || is_corner) { // no node, so next to a facet
            side.end.add(boundary.nearest(facets, place).value, 1.0);
            return;
        }
        side.hangs = true;
        side.moments = {};
        MomentSink sink{nodes_, side, place};
        LeafGather<D, MomentSink>(boundary, nodes_, sink).gather(*leaf, facets, place);
    }

    void add_equation(std::uint32_t node) {
        const Index index = nodes_.index(node);
        const auto about = leaves_about(tree_, index);
        row_.clear();
        diagonal_ = 0;
        if (add_nine_points(index, about)) {
            end_row(double(about.leaf[0].size) * about.leaf[0].size);
            return;
        }
        for (std::size_t n = 0; n < 2 * D; ++n) set_side(sides_[n], index, about, n / 2, n % 2 == 1);
        double volume = 1;
        std::array<std::array<double, 2>, D> c{};
        for (std::size_t k = 0; k < D; ++k) {
            const double both = sides_[2 * k].length + sides_[2 * k + 1].length;
            volume *= 0.5 * both;
            for (std::size_t s = 0; s < 2; ++s) c[k][s] = 2 / (sides_[2 * k + s].length * both);
        }
        if (!add_star(node, index, about, volume)) {
            const auto shares = shares_of_axes(c);
            for (std::size_t n = 0; n < 2 * D; ++n) {
                const double weight = volume * shares[n / 2] * c[n / 2][n % 2];
                const auto& end = sides_[n].end;
                for (std::uint32_t k = 0; k < end.node_count; ++k)
                    add_to_row(end.nodes[k].node, weight * end.nodes[k].share);
                for (std::uint32_t k = 0; k < end.place_count; ++k)
                    add_data(node, end.places[k].value, weight * end.places[k].share);
            }
        }
        end_row(volume);
    }
    /// In the plane, between equal cells that no facet passes: Collatz' equation.
    bool add_nine_points([[maybe_unused]] const Index& index, const LeavesAbout<D>& about) {
        const std::int32_t size = about.leaf[0].size;
        for (const Cell& leaf : about.leaf) {
            if (D != 2 || leaf.size != size || tree_.state(leaf.number) != grid::CellState::in) return false;
        }
        for (const Cell& leaf : about.leaf) {
            for (std::size_t n = 0; n < about.leaf.size(); ++n) {
                auto there = leaf.low;
                std::size_t apart = 0;
                for (std::size_t k = 0; k < D; ++k) {
                    there[k] += ((n >> k) & 1u) != 0 ? size : 0;
                    apart += there[k] != index[k] ? 1 : 0;
                }
                // Those beside the node belong to two of the cells.
                if (apart > 0) add_to_row(nodes_.find(there), apart == 1 ? 1.0 / 3 : 1.0 / 6);
            }
        }
        return true;
    }
    void end_row(double volume) {
        std::sort(row_.begin(), row_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        for (const auto& [column, weight] : row_) {
            out_.equations.neighbours.entries.push_back({column, float(weight)});
            diagonal_ += double(float(weight));
        }
        out_.equations.neighbours.end_row();
        out_.equations.diagonal.push_back(diagonal_);
        out_.volume.push_back(float(volume));
    }
    /// In the plane, where what the node sees allows it: an equation of higher order.
    bool add_star([[maybe_unused]] std::uint32_t node, [[maybe_unused]] const Index& index,
                  [[maybe_unused]] const LeavesAbout<D>& about, [[maybe_unused]] double volume) {
        if constexpr (D == 2) {
            if (!star_.look(index, about)) return false;
            mean_.clear();
            for (const auto& place : star_.places()) mean_.add((1 / star_.size()) * place.offset);
            if (mean_.solve(HarmonicMean::most_degree, 3) == 0) return false;
            double moment = 0;
            for (std::size_t n = 0; n < mean_.count(); ++n)
                moment += mean_.weight(n) * dot(star_.places()[n].offset, star_.places()[n].offset);
            for (std::size_t n = 0; n < mean_.count(); ++n) { // the mean of r² is that of a Laplacian of 4
                const auto& place = star_.places()[n];
                const double weight = mean_.weight(n) * 4 * volume / moment;
                if (!(weight > 0)) continue;
                if (place.node != Nodes::none) {
                    add_to_row(place.node, weight);
                } else {
                    add_data(node, place.value, weight);
                }
            }
            return true;
        }
        return false;
    }
    void add_data(std::uint32_t node, const BoundaryValue<D>& value, double weight) {
        data_.for_each_weight(value, [&](std::uint32_t handle, double of_handle) {
            const auto part = float(weight * of_handle);
            if (!(part > 0)) return;
            out_.data.push_back({handle, node, part});
            diagonal_ += double(part);
        });
    }
    void add_to_row(std::uint32_t column, double weight) {
        for (auto& [known, sum] : row_) {
            if (known != column) continue;
            sum += weight;
            return;
        }
        row_.push_back({column, weight});
    }

    /// What remains of the second difference along each axis, so that all are exact for squares:
    /// share_k = 1 − Σ share_a σ(a, k), a ≠ k.
    std::array<double, D> shares_of_axes(const std::array<std::array<double, 2>, D>& c) {
        std::array<double, D> shares{};
        shares.fill(1);
        bool hangs = false;
        for (const Side& side : sides_) hangs = hangs || side.hangs;
        for (int step = 0; hangs && step < 30; ++step) { // contracts by (D − 1)/4
            auto next = shares;
            for (std::size_t k = 0; k < D; ++k) {
                next[k] = 1;
                for (std::size_t n = 0; n < 2 * D; ++n) {
                    if (sides_[n].hangs && n / 2 != k)
                        next[k] -= shares[n / 2] * c[n / 2][n % 2] * sides_[n].moments[k] / 2;
                }
            }
            shares = next;
        }
        for (const double share : shares) out_.least_share = (std::min)(out_.least_share, share);
        return shares;
    }

    const grid::CutTree<D>& tree_;
    const Nodes& nodes_;
    const Data& data_;
    std::array<Side, 2 * D> sides_;
    std::vector<std::pair<std::uint32_t, double>> row_;
    double diagonal_ = 0;
    std::conditional_t<D == 2, Star, NoStar> star_;
    HarmonicMean mean_;
    grid::TreeLinks out_;
};

} // namespace detail
namespace grid {

///   data  data.for_each_weight(value, f): f(handle, weight) for the handles whose value at a place of
///         the boundary is not zero; none negative
template <std::size_t D, class Data = detail::HatData<D>>
TreeLinks links_of(const CutTree<D>& tree, const TreeNodes<D>& nodes, const Data& data = {}) {
    return detail::LinkMaker<D, Data>(tree, nodes, data).make();
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
