// The discretisation of the Laplace equation on the tree: one row of a sparse matrix per node.
//
// A node is a corner of a leaf inside the domain (grid/tree/nodes.hpp). Every row has the form diagonal ·
// u(node) − Σ weight · u(neighbour) = Σ weight · (boundary value) with positive weights; a near field adds
// data of both signs. The matrix is not symmetric: if the equation of node a contains node b, the equation of
// b need not contain a. LinkMaker::add_equation selects one of three formulas:
//
// 1. Equal leaves without facets around the node: the mean of the 8 surrounding nodes in 2D, of the 26 in
// 3D (Collatz, The Numerical Treatment of Differential Equations, table VI). The mean is exact for harmonic
// polynomials up to degree seven, so the order for the Laplace equation is six.
//
// 2. Other nodes in 2D, if the weights exist: generalised finite differences. The star of the node consists
// of the corners of the leaves around it. In directions where a facet hides a corner, a point on the boundary
// replaces the corner (grid/tree/star.hpp). Non-negative weights make the mean exact for harmonic polynomials
// up to degree three or four (grid/tree/harmonic_mean.hpp). These equations limit the order of the solution
// in 2D to four.
//
// 3. All other nodes: along each axis the second difference of Shortley and Weller (J. Appl. Phys. 9
// (1938)), which allows two links of different lengths. A link ends on the boundary or at a node. A node on
// a face of a larger leaf that is not one of its corners is a hanging node. Its link through that leaf may
// end inside the opposite face, where there is no node. The end then has a ghost value, interpolated in
// that face by LeafGather (grid/tree/leaf_gather.hpp). A ghost value adds error terms along the other axes.
// The second differences are scaled to cancel them (shares_of_axes below; Min, Gibou, Ceniceros, J. Comput.
// Phys. 218 (2006); here the error terms are second moments of the interpolation, which includes
// interpolation up to the boundary). Linear functions are exact, and the order at these nodes is two.
//
// grid/tree/hierarchy.hpp makes coarser levels from these rows, and grid/tree/multigrid.hpp solves them.
#pragma once

#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/level_rows.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// One entry of the right-hand side: the weight of a handle's boundary value in a node's equation.
struct TreeData {
    std::uint32_t handle, node;
    float weight;
};

/// The equations of all nodes, each multiplied by the volume around its node.
struct TreeLinks {
    detail::TreeEquations equations;
    Buffer<TreeData> data;  ///< sorted by handle, then by node
    Buffer<float> volume;   ///< per node: the product over the axes of the mean link length
    double least_share = 1; ///< the smallest factor of a second difference (shares_of_axes)

    void append(const TreeLinks& other) {
        equations.append(other.equations);
        data.append(other.data.begin(), other.data.end());
        volume.append(other.volume.begin(), other.volume.end());
        least_share = (std::min)(least_share, other.least_share);
    }
};

} // namespace grid

namespace detail {

/// Replaces Star in 3D.
struct NoStar {
    template <class... Any>
    explicit NoStar(const Any&...) noexcept {}
};

/// Replaces the near field if there is none.
struct NoNearField {};

/// Makes the equations of runs of nodes. `Data` converts a point of the boundary into weights of handles:
/// data.for_each_weight(value, f). `Near` corrects equations next to the boundary, or is NoNearField.
template <std::size_t D, class Data, class Near>
class LinkMaker {
public:
    using Nodes = grid::TreeNodes<D>;
    using Index = typename Nodes::Index;
    using Cell = typename grid::CellTree<D>::Cell;
    using AxisRay = grid::AxisRay<D>;

    LinkMaker(const grid::CutTree<D>& tree, const Nodes& nodes, const Data& data, Near near_field)
        : tree_(tree)
        , nodes_(nodes)
        , data_(data)
        , near_(std::move(near_field))
        , star_(tree, nodes) {}

    /// Makes the equations of nodes begin … end − 1. The data is not sorted.
    void operator()(std::size_t begin, std::size_t end, grid::TreeLinks& out) {
        first_ = std::uint32_t(begin);
        for (std::size_t node = begin; node < end; ++node) add_equation(std::uint32_t(node));
        if constexpr (has_near_field) correct_rows();
        out = std::exchange(out_, {});
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

    /// Computes the link from a node along an axis. Its length is the size of the smallest leaf on that side.
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

    /// Selects one of the three formulas above and appends the node's row.
    void add_equation(std::uint32_t node) {
        const Index index = nodes_.index(node);
        const auto about = leaves_about(tree_, index);
        row_.clear();
        diagonal_ = 0;
        if (add_regular(node, index, about)) return end_row(std::pow(double(about.leaf[0].size), double(D)));
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
            if constexpr (has_near_field) begin_near_row(node, index, about);
            for (std::size_t n = 0; n < 2 * D; ++n) {
                const double weight = volume * shares[n / 2] * c[n / 2][n % 2];
                const auto& end = sides_[n].end;
                for (std::uint32_t k = 0; k < end.node_count; ++k) {
                    const auto& [neighbour, share] = end.nodes[k];
                    add_to_row(neighbour, weight * share);
                    if constexpr (has_near_field)
                        near_.at_node(neighbour, node_position<D>(nodes_.index(neighbour)), weight * share);
                }
                for (std::uint32_t k = 0; k < end.boundary_count; ++k) {
                    const auto& [value, share] = end.boundary_points[k];
                    add_data(node, value, weight * share);
                    if constexpr (has_near_field) near_.at_boundary(value, weight * share);
                }
            }
        }
        end_row(volume);
    }
    /// Formula 1. Adds nothing and returns false if leaves differ in size or a facet cuts one of them.
    bool add_regular(std::uint32_t node, const Index& index, const LeavesAbout<D>& about) {
        const std::int32_t size = about.leaf[0].size;
        for (const Cell& leaf : about.leaf) {
            if (leaf.size != size || tree_.state(leaf.number) != grid::CellState::in) return false;
        }
        // The index is the number of axes along which a node differs from the centre. A node of several
        // leaves gets this weight once per leaf.
        constexpr std::array weights =
            D == 2 ? std::array{0.0, 1.0 / 3, 1.0 / 6, 0.0} : std::array{0.0, 3.5 / 30, 1.5 / 30, 1.0 / 30};
        for (const Cell& leaf : about.leaf) {
            for (std::size_t n = 0; n < about.leaf.size(); ++n) {
                auto there = leaf.low;
                std::size_t apart = 0;
                for (std::size_t k = 0; k < D; ++k) {
                    there[k] += ((n >> k) & 1u) != 0 ? size : 0;
                    apart += there[k] != index[k] ? 1 : 0;
                }
                if (apart > 0) add_to_row(nodes_.find(there), weights[apart] * (D == 2 ? 1 : size));
            }
        }
        if constexpr (has_near_field) {
            begin_near_row(node, index, about);
            for (const auto& [neighbour, weight] : row_)
                near_.at_node(neighbour, node_position<D>(nodes_.index(neighbour)), weight);
        }
        return true;
    }
    /// Begins a row of the near field. Rows in one cube, of twice the size of the node's smallest leaf, are
    /// corrected together.
    void begin_near_row(std::uint32_t node, const Index& index, const LeavesAbout<D>& about) {
        const std::int32_t size = about.smallest()->size;
        std::int32_t largest = size;
        for (std::size_t n = 0; n < about.leaf.size(); ++n)
            largest = about.counts[n] ? (std::max)(largest, about.leaf[n].size) : largest;
        std::array<std::int32_t, D + 1> cube{size};
        for (std::size_t k = 0; k < D; ++k) cube[k + 1] = index[k] / (2 * size);
        if (cube != cube_) correct_rows();
        cube_ = cube;
        near_.begin(node, node_position<D>(index), largest);
    }
    void correct_rows() {
        near_.flush(
            [&](std::uint32_t node, std::uint32_t vertex, double amount) {
                BoundaryValue<D> value{};
                value.handle[0] = vertex;
                value.weight[0] = 1;
                data_.for_each_weight(value, [&](std::uint32_t handle, double) {
                    out_.data.push_back({handle, node, float(amount)});
                    out_.equations.diagonal[node - first_] += double(float(amount));
                });
            },
            [&](std::uint32_t node, double factor) {
                for (auto& [column, weight] : out_.equations.neighbours.of(node - first_)) {
                    const auto scaled = float(factor * double(weight));
                    out_.equations.diagonal[node - first_] += double(scaled) - double(weight);
                    weight = scaled;
                }
            });
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
    /// Generalised finite differences in 2D. Returns false if there are no non-negative weights, or next to
    /// a bone.
    bool add_star([[maybe_unused]] std::uint32_t node, [[maybe_unused]] const Index& index,
                  [[maybe_unused]] const LeavesAbout<D>& about, [[maybe_unused]] double volume) {
        if constexpr (D == 2) {
            if (!star_.collect(index, about)) return false;
            mean_.clear();
            for (const auto& point : star_.points()) mean_.add((1 / star_.size()) * point.offset);
            if (mean_.solve(HarmonicMean::most_degree, 3) == 0) return false;
            double moment = 0;
            for (std::size_t n = 0; n < mean_.count(); ++n)
                moment += mean_.weight(n) * dot(star_.points()[n].offset, star_.points()[n].offset);
            // The mean over the star is u + (moment/4) Δu + …, since Δr² = 4.
            for (std::size_t n = 0; n < mean_.count(); ++n) {
                const auto& point = star_.points()[n];
                const double weight = mean_.weight(n) * 4 * volume / moment;
                if (!(weight > 0)) continue;
                if (point.node != Nodes::none) {
                    add_to_row(point.node, weight);
                } else {
                    add_data(node, point.value, weight);
                }
            }
            return true;
        }
        return false;
    }
    void add_data(std::uint32_t node, const BoundaryValue<D>& value, double weight) {
        data_.for_each_weight(value, [&](std::uint32_t handle, double of_handle) {
            const auto amount = float(weight * of_handle);
            if (!(amount > 0)) return;
            out_.data.push_back({handle, node, amount});
            diagonal_ += double(amount);
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

    /// Returns the factors of the second differences along the axes. The ghost values of axis a add σ(a, k)
    /// times the second derivative along axis k ≠ a to its second difference. Here σ(a, k) = Σ c · m / 2,
    /// summed over the ghost values at the ends of axis a. The factor c is the weight of the end in the
    /// second difference (`c` below), and m is its second moment along k (Side::moments). With the factors
    /// share_k = 1 − Σ share_a σ(a, k), a ≠ k, every second derivative has the coefficient 1, so all squares
    /// are exact.
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
        for (const double share : shares) out_.least_share = (std::min)(out_.least_share, share);
        return shares;
    }

    const grid::CutTree<D>& tree_;
    const Nodes& nodes_;
    const Data& data_;
    static constexpr bool has_near_field = !std::is_same_v<Near, NoNearField>;
    Near near_;
    std::uint32_t first_ = 0;                ///< the first node of the run
    std::array<std::int32_t, D + 1> cube_{}; ///< of the pending rows of near_
    std::array<Side, 2 * D> sides_;
    std::vector<std::pair<std::uint32_t, double>> row_;
    double diagonal_ = 0;
    std::conditional_t<D == 2, Star, NoStar> star_;
    HarmonicMean mean_;
    grid::TreeLinks out_;
};

/// Sorts data by handle, then by node.
inline void sort_data(Buffer<grid::TreeData>& data) {
    std::uint32_t handles = 0;
    for (const auto& entry : data) handles = (std::max)(handles, entry.handle + 1);
    Buffer<std::size_t> ends(std::size_t{handles} + 1, 0);
    for (const auto& entry : data) ++ends[entry.handle + 1];
    for (std::size_t h = 0; h < handles; ++h) ends[h + 1] += ends[h];
    Buffer<grid::TreeData> sorted;
    sorted.resize(data.size());
    for (const auto& entry : data) sorted[ends[entry.handle]++] = entry;
    for (std::size_t h = 0; h < handles; ++h) {
        std::sort(sorted.data() + (h == 0 ? 0 : ends[h - 1]), sorted.data() + ends[h],
                  [](const auto& a, const auto& b) { return a.node < b.node; });
    }
    data = std::move(sorted);
}

} // namespace detail
namespace grid {

/// Returns the equations of all nodes.
///
///   data        data.for_each_weight(value, f) calls f(handle, weight) for every handle with non-zero
///               weight at a point of the boundary; weights must not be negative
///   near_field  corrects equations next to the boundary (coordinates/harmonic/near_rows.hpp), or
///               NoNearField; each run of nodes has a copy
template <std::size_t D, class Data = detail::LinearBoundaryData<D>, class Near = detail::NoNearField>
TreeLinks links_of(const CutTree<D>& tree, const TreeNodes<D>& nodes, const Data& data = {},
                   const Near& near_field = {}, const Running& running = {}) {
    TreeLinks links = detail::joined_runs<TreeLinks>(running, nodes.count(), 2048, [&] {
        return detail::LinkMaker<D, Data, Near>(tree, nodes, data, near_field);
    });
    detail::sort_data(links.data);
    links.equations.neighbours.shrink_to_fit();
    return links;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
