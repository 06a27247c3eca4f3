// The discretisation of the Laplace equation at one node of the tree.
//
// A node is a corner of a leaf inside the domain (grid/tree/nodes.hpp). NodeEquationMaker selects one of
// three formulas:
//
// 1. Equal leaves without facets around the node: the mean of the 8 surrounding nodes in 2D, of the 26 in
// 3D (Collatz, The Numerical Treatment of Differential Equations, table VI). The mean is exact for harmonic
// polynomials up to degree seven, so the order for the Laplace equation is six.
//
// 2. Other nodes in 2D, if the weights exist: generalised finite differences. The star of the node consists
// of the corners of the leaves around it. In directions where a facet hides a corner, a point on the boundary
// replaces the corner (grid/tree/star.hpp). With non-negative weights the mean is exact for harmonic
// polynomials up to degree three or four (grid/tree/harmonic_mean.hpp). These equations limit the order of
// the solution in 2D to four.
//
// 3. All other nodes: along each axis the second difference of Shortley and Weller (J. Appl. Phys. 9
// (1938)), which allows two links of different lengths. A link ends on the boundary or at a node. A node is
// *hanging* if it lies on a face of a larger leaf and is not a corner of that leaf. Its link through that
// leaf may end inside the opposite face, where there is no node. The end then has a ghost value, interpolated
// in that face by LeafGather (grid/tree/leaf_gather.hpp). A ghost value adds error terms along the other
// axes. The second differences are scaled to cancel them (shares_of_axes below; Min, Gibou, Ceniceros, J.
// Comput. Phys. 218 (2006)). Here the error terms are computed from second moments of the interpolation,
// which may end on the boundary. Linear functions are exact, and the order at these nodes is two.
//
// For the screened equation Δu = κ²u (CutTree::screening), the mean of formula 1 is exact for the solution
// that depends only on the distance from the node. Formula 2 replaces each harmonic polynomial by the
// solution with the same angular factor (grid/tree/screening.hpp). Formula 3 gains the term κ²u.
#pragma once

#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The equation Σ weight · (u(node) − u(term)) + screening · u(node) = 0 of one node, multiplied by the
/// volume around the node.
template <std::size_t D>
struct NodeEquation {
    /// A node, or a point on the boundary. Each node occurs in at most one term.
    struct Term {
        std::uint32_t node; ///< TreeNodes::none for a point on the boundary
        double weight;
        BoundaryValue<D> value{};
    };

    std::uint32_t node;
    typename grid::TreeNodes<D>::Index index;
    std::int32_t smallest, largest; ///< sizes of leaves around the node
    std::vector<Term> terms;
    double volume;
    double screening = 0;   ///< zero for the Laplace equation
    double least_share = 1; ///< the smallest factor of a second difference (shares_of_axes)
};

/// Replaces Star in 3D.
struct NoStar {
    template <class... Any>
    explicit NoStar(const Any&...) noexcept {}
};

template <std::size_t D>
class NodeEquationMaker {
public:
    using Nodes = grid::TreeNodes<D>;
    using Index = typename Nodes::Index;
    using Cell = typename grid::CellTree<D>::Cell;
    using AxisRay = grid::AxisRay<D>;

    NodeEquationMaker(const grid::CutTree<D>& tree, const Nodes& nodes)
        : tree_(tree)
        , nodes_(nodes)
        , star_(tree, nodes) {}

    /// Returns the equation of a node; the reference is valid until the next call.
    const NodeEquation<D>& operator()(std::uint32_t node) {
        equation_.node = node;
        equation_.index = nodes_.index(node);
        equation_.terms.clear();
        equation_.least_share = 1;
        equation_.screening = 0;
        const auto about = leaves_about(tree_, equation_.index);
        equation_.smallest = equation_.largest = about.smallest()->size;
        for (std::size_t n = 0; n < about.leaf.size(); ++n) {
            if (about.counts[n]) equation_.largest = (std::max)(equation_.largest, about.leaf[n].size);
        }
        if (add_regular(about)) return equation_;
        equation_.volume = 1;
        std::array<std::array<double, 2>, D> c{};
        for (std::size_t n = 0; n < 2 * D; ++n)
            set_side(sides_[n], equation_.index, about, n / 2, n % 2 == 1);
        for (std::size_t k = 0; k < D; ++k) {
            const double both = sides_[2 * k].length + sides_[2 * k + 1].length;
            equation_.volume *= 0.5 * both;
            for (std::size_t s = 0; s < 2; ++s) c[k][s] = 2 / (sides_[2 * k + s].length * both);
        }
        if (!add_star(about)) add_differences(c);
        return equation_;
    }

private:
    /// The link from a node along an axis, in one direction.
    struct Side {
        double length;
        // Whether the end is a ghost value. The node at the start of the link is then a hanging node.
        bool hangs;
        /// Second moments of the interpolation relative to the end, by axis; only set if `hangs`.
        Vec<double, D> moments;
        /// The value at the end as a mean of nodes and boundary values.
        grid::CutStencil<D> end;
    };

    /// Receives a ghost value from LeafGather and sums its second moments.
    struct MomentSink {
        const Nodes& nodes;
        Side& side;
        Vec<double, D> centre;

        void at_node(const Index& index, double share) {
            side.end.add(nodes.find(index), share);
            add(node_position<D>(index), share);
        }
        void at_boundary(const BoundaryValue<D>& value, const Vec<double, D>& position, double share) {
            side.end.add(value, share);
            add(position, share);
        }
        void add(const Vec<double, D>& position, double share) {
            for (std::size_t k = 0; k < D; ++k)
                side.moments[k] += share * (position[k] - centre[k]) * (position[k] - centre[k]);
        }
    };

    /// Computes the link from a node along an axis. Its length is the size of the smallest leaf on that side,
    /// or the distance of the first facet.
    void set_side(Side& side, const Index& index, const LeavesAbout<D>& about, std::size_t axis, bool up) {
        side.hangs = false;
        side.end.node_count = side.end.boundary_count = 0;
        const std::size_t bit = std::size_t{1} << axis;
        const Cell* leaf = about.smallest(bit, up ? bit : 0);
        // Without a leaf on that side, the node lies on the boundary, up to rounding.
        const bool beyond = leaf == nullptr;
        if (beyond) leaf = about.smallest();
        const auto facets = tree_.facets(leaf->number);
        const auto& boundary = tree_.boundary();
        side.length = leaf->size;
        Index there = index;
        there[axis] += up ? leaf->size : -leaf->size;
        const auto position = node_position<D>(there);
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
        // A corner without a node is outside, or too close to a facet to be an unknown.
        if (beyond || is_corner) {
            side.end.add(boundary.nearest(facets, position).value, 1.0);
            return;
        }
        side.hangs = true;
        side.moments = {};
        MomentSink sink{nodes_, side, position};
        LeafGather<D, MomentSink>(boundary, nodes_, sink).gather(*leaf, facets, position);
    }

    /// Formula 1. Returns false if leaves differ in size or a facet cuts one of them.
    bool add_regular(const LeavesAbout<D>& about) {
        const std::int32_t size = about.leaf[0].size;
        for (const Cell& leaf : about.leaf) {
            if (leaf.size != size || tree_.state(leaf.number) != grid::CellState::in) return false;
        }
        // weights[n] is for a node that differs from the centre along n axes; each leaf of the node adds it.
        constexpr std::array weights =
            D == 2 ? std::array{0.0, 1.0 / 3, 1.0 / 6, 0.0} : std::array{0.0, 3.5 / 30, 1.5 / 30, 1.0 / 30};
        for (const Cell& leaf : about.leaf) {
            for (std::size_t n = 0; n < about.leaf.size(); ++n) {
                auto there = leaf.low;
                std::size_t apart = 0;
                for (std::size_t k = 0; k < D; ++k) {
                    there[k] += ((n >> k) & 1u) != 0 ? size : 0;
                    apart += there[k] != equation_.index[k] ? 1 : 0;
                }
                if (apart == 0) continue;
                const double weight = weights[apart] * (D == 2 ? 1 : size);
                add_node(nodes_.find(there), weight);
                if (tree_.screening() > 0) {
                    const double square = tree_.screening() * double(apart) * size * size;
                    equation_.screening += weight * (screened_factor<D>(0, square) - 1);
                }
            }
        }
        equation_.volume = std::pow(double(size), double(D));
        return true;
    }
    /// Adds a weight to the term of a node.
    void add_node(std::uint32_t node, double weight) {
        for (auto& term : equation_.terms) {
            if (term.node != node) continue;
            term.weight += weight;
            return;
        }
        equation_.terms.push_back({node, weight});
    }
    /// Formula 2, in 2D. Returns false if there are no non-negative weights, or next to a bone.
    bool add_star([[maybe_unused]] const LeavesAbout<D>& about) {
        if constexpr (D == 2) {
            if (!star_.collect(equation_.index, about)) return false;
            mean_.clear();
            const double screening = tree_.screening() * star_.size() * star_.size();
            for (const auto& point : star_.points()) mean_.add((1 / star_.size()) * point.offset, screening);
            if (mean_.solve(HarmonicMean::most_degree, 3) == 0) return false;
            double moment = 0, sum = 0;
            for (std::size_t n = 0; n < mean_.count(); ++n) {
                moment += mean_.weight(n) * dot(star_.points()[n].offset, star_.points()[n].offset);
                sum += mean_.weight(n);
            }
            // The mean over the star is u + (moment/4) Δu + …, since Δr² = 4.
            for (std::size_t n = 0; n < mean_.count(); ++n) {
                const auto& point = star_.points()[n];
                const double weight = mean_.weight(n) * 4 * equation_.volume / moment;
                if (weight > 0) equation_.terms.push_back({point.node, weight, point.value});
            }
            if (tree_.screening() > 0) equation_.screening = (1 - sum) * 4 * equation_.volume / moment;
            return true;
        }
        return false;
    }
    /// Formula 3.
    void add_differences(const std::array<std::array<double, 2>, D>& c) {
        const auto shares = shares_of_axes(c);
        equation_.screening = tree_.screening() * equation_.volume;
        for (std::size_t n = 0; n < 2 * D; ++n) {
            const double weight = equation_.volume * shares[n / 2] * c[n / 2][n % 2];
            const auto& end = sides_[n].end;
            for (std::uint32_t k = 0; k < end.node_count; ++k)
                add_node(end.nodes[k].node, weight * end.nodes[k].share);
            for (std::uint32_t k = 0; k < end.boundary_count; ++k) {
                const auto& [value, share] = end.boundary_points[k];
                equation_.terms.push_back({Nodes::none, weight * share, value});
            }
        }
    }

    /// Returns the factors of the second differences along the axes. The ghost values at the ends of axis a
    /// add σ(a, k) ∂²u/∂x_k² to the second difference along a, for each axis k ≠ a. Here σ(a, k) =
    /// Σ c · m / 2, summed over the ghost values at the ends of axis a. The factor c is the weight of the
    /// end in the second difference (`c` below), and m is its second moment along k (Side::moments). With the
    /// factors share_k = 1 − Σ share_a σ(a, k), a ≠ k, every second derivative has the coefficient 1, so all
    /// squares are exact.
    std::array<double, D> shares_of_axes(const std::array<std::array<double, 2>, D>& c) {
        std::array<double, D> shares{};
        shares.fill(1);
        bool hangs = false;
        for (const Side& side : sides_) hangs = hangs || side.hangs;
        // A fixed-point iteration with the contraction factor (D − 1)/4.
        for (int step = 0; hangs && step < 30; ++step) {
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
        equation_.least_share = *std::min_element(shares.begin(), shares.end());
        return shares;
    }

    const grid::CutTree<D>& tree_;
    const Nodes& nodes_;
    NodeEquation<D> equation_;
    std::array<Side, 2 * D> sides_;
    std::conditional_t<D == 2, Star, NoStar> star_;
    HarmonicMean mean_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
