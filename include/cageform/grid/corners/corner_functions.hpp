// Adds the singular functions of a polygon's corners to a solution on a grid that does not resolve them.
//
// Near a corner the solution contains singular functions s_k and w (grid/corners/corner.hpp). Finite
// differences approximate s_k badly if its exponent is small. They approximate w badly if ω is close to π (r
// log r). The functions and their *defects* (the difference equations applied to them) are therefore
// tabulated in a disc around each corner. Between cycles the coefficients a_k are fitted to the solution by
// least squares. Then coefficient · defect is added to the right-hand side, which cancels the error. Sampling
// adds the interpolation error of each function.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/affine/orthonormal_rows.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/corners/cage_corners.hpp>
#include <cageform/grid/corners/corner_errors.hpp>
#include <cageform/grid/lattice/embed.hpp>
#include <cageform/grid/multigrid/multigrid.hpp>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The corners of a polygon on a lattice, and their corrections to the equations and to sampling.
class CornerFunctions {
public:
    static constexpr std::size_t width = Multigrid<2>::width;
    using Row = Multigrid<2>::Values;

    /// Coefficients of sixteen solutions, corner by corner: of w, then of s_1, …, s_count.
    using Coefficients = Buffer<Row>;

    CornerFunctions() = default;

    /// Prepares the corners of a Polygon or a CellComplex. Corners whose free radius is too small for a fit
    /// are not treated. If `treat` is false, no corner is treated.
    template <class Cage>
    CornerFunctions(const Cage& whole, const Lattice<double, 2>& lattice, const EmbeddedProblem<2>& problem,
                    bool treat)
        : vertices_(lattice.in_cells(whole.vertices())) {
        const auto neighbours = detail::neighbours_of_vertices(whole, vertices_);
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const auto& of_i = neighbours[i];
            if (of_i.empty()) continue;
            const double radius = detail::free_radius(i, whole, vertices_, lattice.spacing, most_radius);
            for (std::size_t n = 0; n + 1 < of_i.size(); ++n) {
                const std::size_t after = of_i[n], before = of_i[n + 1];
                const Corner corner(vertices_[i], vertices_[before], vertices_[after], radius);
                const Treated t{corner, {i, before, after}};
                bool treated = corner.is_smooth() && radius >= ample_radius;
                if (treat && !corner.is_smooth() && radius >= least_radius) treated = add(t, problem);
                if (!treated || radius < ample_radius) add_estimate(t, treated, treat, problem.nodes);
            }
        }
    }

    /// Returns the error estimates of corners with a small free radius or without treatment.
    const CornerErrors<2>& errors() const noexcept { return errors_; }
    bool empty() const noexcept { return corners_.empty(); }

    /// Returns the nodes whose equations have a right-hand side, ascending and unique.
    std::vector<std::uint32_t> sources() const {
        std::vector<std::uint32_t> nodes;
        for (const auto& corner : corners_) {
            nodes.insert(nodes.end(), corner.defects.nodes.begin(), corner.defects.nodes.end());
        }
        detail::sort_unique(nodes);
        return nodes;
    }
    /// Replaces the nodes by their indices in Block::source: slots[node].
    void set_slots(std::span<const std::uint32_t> slots) {
        for (auto& corner : corners_) {
            for (auto& node : corner.defects.nodes) node = slots[node];
        }
    }

    /// Returns the coefficients of functions first … first + 15 before a fit: those of w, which the data
    /// determines; the others are zero. Adds the defects of w to `source`.
    Coefficients start(std::size_t first, std::span<Row> source) const {
        Coefficients all(coefficients_, Row{});
        for (const Treated& t : corners_) {
            for (std::size_t lane = 0; lane < width; ++lane) {
                const auto slope = slopes(t, first + lane);
                all[t.first][lane] = slope[1] - slope[0] * t.corner.cosine();
            }
            add_defects(t, 0, all[t.first], source);
        }
        return all;
    }

    /// Returns the coefficients fitted to a solution. Those of w are copied from `known`.
    template <class Solution> // a block of the multigrid
    Coefficients fit(std::size_t first, const Solution& solution, const Coefficients& known) const {
        Coefficients all = known;
        for (const Treated& t : corners_) {
            std::array<std::array<double, 3>, width> data{};
            for (std::size_t lane = 0; lane < width; ++lane) {
                data[lane] = {t.handles[0] == first + lane ? 1.0 : 0.0, slopes(t, first + lane)[0],
                              known[t.first][lane]};
            }
            std::array<std::array<double, width>, Corner::most> sum{};
            for (std::size_t i = 0; i < t.around.size(); ++i) {
                const auto& node = t.around[i];
                Row rest = solution.value(node.node);
                for (std::size_t lane = 0; lane < width; ++lane)
                    rest[lane] -= data[lane][0] + data[lane][1] * node.along + data[lane][2] * node.w;
                for (std::size_t k = 0; k < t.corner.count(); ++k) {
                    const double share = t.fit[i * t.corner.count() + k];
                    for (std::size_t lane = 0; lane < width; ++lane) sum[k][lane] += share * rest[lane];
                }
            }
            for (std::size_t k = 0; k < t.corner.count(); ++k) {
                for (std::size_t lane = 0; lane < width; ++lane) all[t.first + k + 1][lane] = sum[k][lane];
            }
        }
        return all;
    }
    /// Returns the largest difference between two sets of coefficients, a bound of the change of a value.
    double difference(const Coefficients& a, const Coefficients& b) const noexcept {
        double largest = 0;
        for (const Treated& t : corners_) {
            for (std::size_t k = t.first + 1; k <= t.first + t.corner.count(); ++k) {
                for (std::size_t lane = 0; lane < width; ++lane)
                    largest = (std::max)(largest, std::fabs(a[k][lane] - b[k][lane]));
            }
        }
        return largest;
    }
    /// Replaces coefficients and updates `source`. Returns the largest change of the source for each
    /// function.
    Row replace(Coefficients& all, const Coefficients& by, std::span<Row> source) const noexcept {
        Row disturbance;
        disturbance.fill(0.0);
        for (const Treated& t : corners_) {
            for (std::size_t k = 1; k <= t.corner.count(); ++k) {
                Row change;
                for (std::size_t lane = 0; lane < width; ++lane) {
                    change[lane] = by[t.first + k][lane] - all[t.first + k][lane];
                    disturbance[lane] += t.largest_defect[k] * std::fabs(change[lane]);
                }
                add_defects(t, k, change, source);
            }
        }
        all = by;
        return disturbance;
    }

    /// The interpolation error of each singular function of one corner at a point.
    struct Correction {
        static constexpr std::uint32_t none = ~std::uint32_t{0};
        std::uint32_t first = none; ///< the corner's first index in Coefficients
        std::array<double, Corner::most + 1> missed{};
    };
    /// Returns the interpolation error of `stencil` at `p` (in units of the lattice) for the nearest corner
    /// whose disc contains the stencil.
    Correction correction(const Vec<double, 2>& p, const CutStencil<2>& stencil) const {
        Correction result;
        double nearest = (std::numeric_limits<double>::max)();
        for (std::size_t n = 0; n < discs_.size(); ++n) {
            const auto d = p - discs_[n].centre;
            const double square = dot(d, d);
            if (square > discs_[n].reach_squared || square >= nearest) continue;
            if (!corners_[n].corner.contains(p) || !interpolate(corners_[n], stencil, result.missed))
                continue;
            nearest = square;
            result.first = corners_[n].first;
            const auto here = corners_[n].corner.functions(p);
            for (std::size_t k = 0; k <= corners_[n].corner.count(); ++k)
                result.missed[k] = here[k] - result.missed[k];
        }
        return result;
    }
    static void apply(const Correction& correction, const Coefficients& all,
                      std::array<double, width>& value) noexcept {
        if (correction.first == Correction::none) return;
        for (std::size_t k = 0; k < correction.missed.size(); ++k) {
            if (correction.missed[k] == 0) continue;
            for (std::size_t lane = 0; lane < width; ++lane)
                value[lane] += correction.missed[k] * all[correction.first + k][lane];
        }
    }

private:
    static constexpr double least_radius = 1, most_radius = 24;
    static constexpr double ample_radius = 10; ///< cells; from this radius on errors are at most a few 1e-4

    using Functions = std::array<double, Corner::most + 1>;
    struct Disc {
        Vec<double, 2> centre;
        double reach_squared;
    };
    struct Around {
        std::uint32_t node;
        double along, w;
    };
    /// A table of the functions w, s_1, … or their defects, with one row per node.
    struct NodeRows {
        std::vector<std::uint32_t> nodes{}; ///< ascending
        std::vector<double> numbers{};      ///< the concatenated rows

        void add(std::uint32_t node, const Functions& row, std::size_t count) {
            nodes.push_back(node);
            numbers.insert(numbers.end(), row.begin(), row.begin() + std::ptrdiff_t(count));
        }
        void shrink() { // the tables exist as long as the solver
            nodes.shrink_to_fit();
            numbers.shrink_to_fit();
        }
    };
    struct Treated {
        Corner corner;
        std::array<std::size_t, 3> handles; ///< the vertices at the corner, before it and after it
        std::uint32_t first = 0;            ///< index of its first coefficient
        std::size_t columns = 0;            ///< columns of each table; functions may be dropped later
        NodeRows functions{};               ///< the functions at the nodes of the disc
        NodeRows defects{};                 ///< their defects; `nodes` become indices in Block::source
        Buffer<Around> around{};            ///< the nodes of the fit
        std::vector<double> fit{};          ///< the factor of each of these nodes in each coefficient
        Functions largest_defect{};

        /// Returns the functions at a node of the disc, or null elsewhere.
        const double* find(std::uint32_t node) const noexcept {
            const auto& nodes = functions.nodes;
            const auto found = std::lower_bound(nodes.begin(), nodes.end(), node);
            if (found == nodes.end() || *found != node) return nullptr;
            return functions.numbers.data() + std::size_t(found - nodes.begin()) * columns;
        }
    };

    /// Returns the slopes of a handle's hat function along the edges after and before the corner, outwards.
    static std::array<double, 2> slopes(const Treated& t, std::size_t handle) noexcept {
        std::array<double, 2> slope{};
        if (handle == t.handles[0]) slope = {-1 / t.corner.length_after(), -1 / t.corner.length_before()};
        if (handle == t.handles[1]) slope[1] += 1 / t.corner.length_before();
        if (handle == t.handles[2]) slope[0] += 1 / t.corner.length_after();
        return slope;
    }
    static void add_defects(const Treated& t, std::size_t k, const Row& coefficients,
                            std::span<Row> source) noexcept {
        for (std::size_t i = 0; i < t.defects.nodes.size(); ++i) {
            const double defect = t.defects.numbers[i * t.columns + k];
            for (std::size_t lane = 0; lane < width; ++lane)
                source[t.defects.nodes[i]][lane] += defect * coefficients[lane];
        }
    }

    /// Treats a corner with enough nodes: the fit needs two per function. Returns whether it is treated.
    bool add(Treated t, const EmbeddedProblem<2>& problem) {
        const double radius = t.corner.radius();
        t.columns = t.corner.count() + 1;
        std::vector<Vec<double, 2>> positions;
        for_each_node_within(t.corner.reach(), t.corner.vertex(), problem.nodes,
                             [&](std::uint32_t node, const auto& p) {
                                 if (!t.corner.reaches(p) || !t.corner.contains(p)) return;
                                 t.functions.add(node, t.corner.functions(p), t.columns);
                                 positions.push_back(p);
                             });
        t.functions.shrink();
        std::vector<const double*> fitted;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const double r = t.corner.distance(positions[i]);
            if (r < radius) add_defect(t, t.functions.nodes[i], positions[i], problem);
            if (!(r > 0.3 * radius && r < (std::max)(0.8 * radius, (std::min)(radius, 8.0)))) continue;
            fitted.push_back(t.functions.numbers.data() + i * t.columns);
            t.around.push_back({t.functions.nodes[i], t.corner.along(positions[i]), fitted.back()[0]});
        }
        t.defects.shrink();
        t.corner.limit(t.around.size() / 2);
        if (t.corner.count() < t.corner.least_count()) return false;
        fit_to_nodes(t, fitted);
        t.first = coefficients_;
        coefficients_ += std::uint32_t(t.corner.count() + 1);
        for (std::size_t n = 0; n < t.defects.numbers.size(); ++n) {
            double& largest = t.largest_defect[n % t.columns];
            largest = (std::max)(largest, std::fabs(t.defects.numbers[n]));
        }
        discs_.push_back({t.corner.vertex(), t.corner.reach() * t.corner.reach()});
        corners_.push_back(std::move(t));
        return true;
    }

    /// Adds the error estimate of a corner. `treated`: whether the corner is treated; `treat`: whether
    /// corners are treated at all. At treated and at smooth corners the error decreases with the free
    /// radius in cells, which a finer grid increases.
    void add_estimate(const Treated& t, bool treated, bool treat, const NodeRuns<2>& nodes) {
        double slope_of_w = 0;
        std::array<double, 3> along{}, w{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto slope = slopes(t, t.handles[k]);
            along[k] = slope[0];
            w[k] = slope[1] - slope[0] * t.corner.cosine();
            slope_of_w = (std::max)(slope_of_w, std::fabs(w[k]));
        }
        const double room = t.corner.radius();
        const bool resolved = treated || t.corner.is_smooth();
        auto estimate = CornerErrors<2>::treated(t.handles, room);
        if (!resolved) estimate = CornerErrors<2>::untreated(t.handles, t.corner, slope_of_w);
        if (treat) estimate.order = CornerErrors<2>::treated_order;
        estimate.room = room;
        Buffer<CornerErrors<2>::Node> around;
        const double reach = std::clamp(room, 1.5, resolved ? 2.5 : 1.5);
        for_each_node_within(reach, vertices_[t.handles[0]], nodes, [&](std::uint32_t node, const auto& p) {
            if (t.corner.distance(p) > reach || !t.corner.contains(p)) return;
            const double x = t.corner.along(p), f = t.corner.functions(p)[0];
            around.push_back(
                {node, {1 + along[0] * x + w[0] * f, along[1] * x + w[1] * f, along[2] * x + w[2] * f}});
        });
        errors_.add(estimate, around);
    }

    /// Calls f(node, position) for the nodes of a square around a point.
    template <class F>
    static void for_each_node_within(double reach, const Vec<double, 2>& centre, const NodeRuns<2>& nodes,
                                     F&& f) {
        NodeRuns<2>::Index low, high;
        for (std::size_t k = 0; k < 2; ++k) {
            low[k] = std::int32_t((std::max)(std::ceil(centre[k] - reach), 0.0));
            high[k] = std::int32_t((std::min)(std::floor(centre[k] + reach), double(nodes.size()[k]) - 1));
        }
        for (auto index = low; index[1] <= high[1]; ++index[1]) {
            for (index[0] = low[0]; index[0] <= high[0]; ++index[0]) {
                const auto node = nodes.find(index);
                if (node != NodeRuns<2>::none) f(node, node_position<2>(index));
            }
        }
    }

    /// Least-squares fit: the factors of the nodes in the coefficients are (SᵀS)⁻¹ Sᵀ. S has a row of
    /// function values per node.
    static void fit_to_nodes(Treated& t, std::span<const double* const> functions) {
        const std::size_t count = t.corner.count();
        Buffer<Vec<double, Corner::most>> s(functions.size());
        for (std::size_t i = 0; i < s.size(); ++i) std::copy_n(functions[i] + 1, count, s[i].v);
        const detail::OrthonormalRows<Corner::most> rows(std::move(s));
        t.fit.reserve(t.around.size() * count);
        for (std::size_t i = 0; i < t.around.size(); ++i) {
            const auto shares = detail::coefficients(rows.triangle(), rows[i]);
            t.fit.insert(t.fit.end(), shares.v, shares.v + count);
        }
    }

    /// Adds the defects at a node; zero for functions that satisfy the difference equation. Adds nothing if
    /// the equation extends beyond the disc.
    static void add_defect(Treated& t, std::uint32_t node, const Vec<double, 2>& p,
                           const EmbeddedProblem<2>& problem) {
        auto cut = std::lower_bound(problem.cuts.begin(), problem.cuts.end(), node,
                                    [](const CutLink& a, std::uint32_t n) { return a.node < n; });
        std::array<double, 4> weight{}; // of cut links
        for (; cut != problem.cuts.end() && cut->node == node; ++cut) weight[cut->direction] = cut->weight;
        Functions defect{}, there{};
        const double* const here = t.find(node);
        for (std::size_t direction = 0; direction < 4; ++direction) {
            const bool is_cut = weight[direction] != 0;
            const double w = is_cut ? weight[direction] : 1;
            auto q = p;
            q[direction / 2] += ((direction & 1) != 0 ? 1 : -1) / w;
            if (!t.corner.reaches(q)) return;
            const double* const at_node =
                is_cut ? nullptr : t.find(problem.nodes.find({std::int32_t(q[0]), std::int32_t(q[1])}));
            if (at_node == nullptr) there = t.corner.functions(q);
            const double* const f = at_node == nullptr ? there.data() : at_node;
            for (std::size_t k = 0; k < t.columns; ++k) defect[k] += w * (here[k] - f[k]);
        }
        t.defects.add(node, defect, t.columns);
    }

    /// Interpolates each function by a stencil; returns false if the stencil extends beyond the disc.
    bool interpolate(const Treated& t, const CutStencil<2>& stencil, Functions& mean) const noexcept {
        Functions sum{};
        const auto add = [&](const double* f, double share) {
            for (std::size_t k = 0; k <= t.corner.count(); ++k) sum[k] += share * f[k];
        };
        for (std::uint32_t i = 0; i < stencil.node_count; ++i) {
            const double* const f = t.find(stencil.nodes[i].node);
            if (f == nullptr) return false;
            add(f, stencil.nodes[i].share);
        }
        for (std::uint32_t i = 0; i < stencil.boundary_count; ++i) {
            const auto& [handle, weight] = stencil.boundary_points[i].value;
            const auto q = weight[0] * vertices_[handle[0]] + weight[1] * vertices_[handle[1]];
            if (!t.corner.reaches(q)) return false;
            add(t.corner.functions(q).data(), stencil.boundary_points[i].share);
        }
        mean = sum;
        return true;
    }

    std::vector<Vec<double, 2>> vertices_;
    std::vector<Treated> corners_;
    std::vector<Disc> discs_; ///< the discs of corners_, for a fast search
    CornerErrors<2> errors_;
    std::uint32_t coefficients_ = 0; ///< number of coefficients of all corners per function
};

} // namespace cageform::inline CAGEFORM_ABI::grid
