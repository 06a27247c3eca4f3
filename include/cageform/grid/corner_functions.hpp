// What a grid cannot resolve: the singular functions at the corners of a polygon, known but for
// their coefficients.
//
// Near a corner of interior angle ω, with data linear along its two edges, a harmonic function is
//
//     g + α x + c w + Σ a_k s_k,   s_k = (r/R)^(kπ/ω) sin(kπθ/ω)
//
// (Wasow 1957; Grisvard, Elliptic Problems in Nonsmooth Domains, 1985, ch. 2 and 4), x along the
// one edge, w harmonic with w = 0 on it and w = r on the other. Differences do badly on the s_k
// with small exponents, and on w where ω is close to π (r log r). So what the difference equations
// get wrong about them is given to the equations as a right-hand side, with the a_k fitted to the
// solution around the corner, and interpolation is corrected likewise.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/grid/embed.hpp>
#include <cageform/grid/multigrid.hpp>

#include <Eigen/Cholesky>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// The functions of one corner. Lengths in units of the lattice.
class Corner {
public:
    static constexpr std::size_t most = 8;          ///< functions s_k kept
    static constexpr double smooth_exponent = 2.25; ///< π/ω from which differences need no help

    /// The corner at `vertex` between the edges to `after` and `before`, counter-clockwise from the
    /// one to the other; all about it where they are one.
    Corner(const Vec<double, 2>& vertex, const Vec<double, 2>& before, const Vec<double, 2>& after,
           double radius)
        : vertex_(vertex)
        , radius_(radius) {
        const auto forth = after - vertex, back = before - vertex;
        length_after_ = std::sqrt(dot(forth, forth));
        length_before_ = std::sqrt(dot(back, back));
        x_ = (1 / length_after_) * forth;
        y_ = {-x_[1], x_[0]};
        angle_ = std::atan2(dot(back, y_), dot(back, x_));
        if (before == after) angle_ = 0; // whatever rounding says
        if (angle_ <= 0) angle_ += 2 * std::numbers::pi;
        exponent_ = std::numbers::pi / angle_;
        // As many as the nodes around can tell apart; r⁴ and beyond differences do well enough.
        count_ = std::min(most, std::size_t(std::ceil(std::clamp(radius / 6, 1.5, 4.0) / exponent_)));
    }

    std::size_t count() const noexcept { return count_; } ///< of the s_k; function 0 is w
    bool is_smooth() const noexcept { return exponent_ > smooth_exponent; }
    double radius() const noexcept { return radius_; }
    double distance(const Vec<double, 2>& p) const noexcept {
        return std::sqrt(dot(p - vertex_, p - vertex_));
    }
    /// Whether a place is between the edges, or on one of them up to rounding.
    bool holds(const Vec<double, 2>& p) const noexcept {
        constexpr double rounding = 1e-9;
        const auto d = p - vertex_;
        double theta = std::atan2(dot(d, y_), dot(d, x_));
        if (theta < -rounding) theta += 2 * std::numbers::pi;
        return theta < angle_ + rounding;
    }
    double along(const Vec<double, 2>& p) const noexcept { return dot(p - vertex_, x_); }
    double cosine() const noexcept { return std::cos(angle_); }
    double length_before() const noexcept { return length_before_; }
    double length_after() const noexcept { return length_after_; }

    /// w, s_1, …, s_count at a place in the sector.
    std::array<double, most + 1> functions(const Vec<double, 2>& p) const noexcept {
        std::array<double, most + 1> f{};
        const auto d = p - vertex_;
        const double x = dot(d, x_), y = dot(d, y_), r = std::sqrt(dot(d, d)) / radius_;
        if (!(r > 0)) return f;
        double theta = std::atan2(y, x);
        // The sector's far side may show as a small negative angle, as may its near side by
        // rounding.
        if (theta < 0 && theta < 0.5 * angle_ - std::numbers::pi) theta += 2 * std::numbers::pi;
        // The s_k are the imaginary parts of the powers of z = (r e^{iθ})^(π/ω).
        const double size = std::pow(r, exponent_);
        const double re = size * std::cos(exponent_ * theta), im = size * std::sin(exponent_ * theta);
        const std::size_t m =
            angle_ < 1.5 * std::numbers::pi ? 1 : 2; // of the s_m whose exponent is closest to 1
        double power_re = re, power_im = im, closest = im;
        for (std::size_t k = 1; k <= std::max(count_, m); ++k) {
            if (k <= count_) f[k] = power_im;
            if (k == m) closest = power_im;
            const double next = power_re * re - power_im * im;
            power_im = power_re * im + power_im * re;
            power_re = next;
        }
        // (y − s_m)/sin ω: bounded even where ω is a multiple of π.
        const double e = double(m) * exponent_, sine = std::sin(angle_);
        if (std::fabs(sine) > 1e-5) {
            f[0] = (y - radius_ * closest) / sine;
        } else {
            const double between = 0.5 * (1 + e);
            const double slope = std::pow(r, between) * (std::log(r) * std::sin(between * theta) +
                                                         theta * std::cos(between * theta));
            f[0] = radius_ * (m == 1 ? -1 : 1) * slope / angle_;
        }
        return f;
    }

private:
    Vec<double, 2> vertex_, x_{}, y_{}; ///< x along the edge to the next vertex, y to the inside
    double radius_, length_before_ = 0, length_after_ = 0;
    double angle_ = 0, exponent_ = 1;
    std::size_t count_ = 0;
};

/// The corners of a polygon laid into a lattice, and how they enter equations and sampling.
class CornerFunctions {
public:
    static constexpr std::size_t width = Multigrid<2>::width;
    using Row = Multigrid<2>::Values;

    /// Coefficients of sixteen functions at every corner: entry 0 of w, entry k of s_k.
    using Coefficients = std::vector<std::array<Row, Corner::most + 1>>;

    CornerFunctions() = default;

    /// Of a Polygon or a CellComplex. Corners without room for a fit are left as they are: the grid
    /// is too coarse for them anyway.
    template <class Cage>
    CornerFunctions(const Cage& whole, const Lattice<double, 2>& lattice, const EmbeddedProblem<2>& problem)
        : vertices_(lattice.in_cells(whole.vertices())) {
        const auto neighbours = neighbours_of_vertices(whole);
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            const auto& of_i = neighbours[i];
            if (of_i.empty()) continue;
            const double radius = room_about(i, whole, lattice.spacing);
            if (radius < least_radius) continue;
            for (std::size_t n = 0; n + 1 < of_i.size(); ++n) {
                const std::size_t after = of_i[n], before = of_i[n + 1];
                const Corner corner(vertices_[i], vertices_[before], vertices_[after], radius);
                if (!corner.is_smooth()) add({corner, {i, before, after}}, problem);
            }
        }
    }

    /// Nodes whose equations get a right-hand side; ascending, without repeats.
    std::vector<std::uint32_t> sources() const {
        std::vector<std::uint32_t> nodes;
        for (const auto& corner : corners_) {
            for (const auto& defect : corner.defects) nodes.push_back(defect.node);
        }
        std::sort(nodes.begin(), nodes.end());
        nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
        return nodes;
    }
    /// slots[node]: the place of a source node in Block::source.
    void set_slots(std::span<const std::uint32_t> slots) {
        for (auto& corner : corners_) {
            for (auto& defect : corner.defects) defect.node = slots[defect.node];
        }
    }

    /// The known coefficients (of w) of functions first … first + 15; the others zero. Adds what
    /// they do to `source`.
    Coefficients start(std::size_t first, std::span<Row> source) const {
        Coefficients all(corners_.size());
        for (std::size_t n = 0; n < corners_.size(); ++n) {
            for (auto& row : all[n]) row.fill(0.0);
            for (std::size_t lane = 0; lane < width; ++lane) {
                const auto slope = slopes(corners_[n], first + lane);
                all[n][0][lane] = slope[1] - slope[0] * corners_[n].corner.cosine();
            }
            add_defects(corners_[n], 0, all[n][0], source);
        }
        return all;
    }

    /// The coefficients that fit a solution, those of w as in `known`.
    template <class Solution> // a block of the multigrid
    Coefficients fit(std::size_t first, const Solution& solution, const Coefficients& known) const {
        Coefficients all = known;
        for (std::size_t n = 0; n < corners_.size(); ++n) {
            const Treated& t = corners_[n];
            std::array<std::array<double, 3>, width> data{};
            for (std::size_t lane = 0; lane < width; ++lane) {
                data[lane] = {t.handles[0] == first + lane ? 1.0 : 0.0, slopes(t, first + lane)[0],
                              known[n][0][lane]};
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
                for (std::size_t lane = 0; lane < width; ++lane) all[n][k + 1][lane] = sum[k][lane];
            }
        }
        return all;
    }
    /// The largest difference of two sets of coefficients, which is how far they move a value.
    double difference(const Coefficients& a, const Coefficients& b) const noexcept {
        double largest = 0;
        for (std::size_t n = 0; n < corners_.size(); ++n) {
            for (std::size_t k = 1; k <= corners_[n].corner.count(); ++k) {
                for (std::size_t lane = 0; lane < width; ++lane)
                    largest = std::max(largest, std::fabs(a[n][k][lane] - b[n][k][lane]));
            }
        }
        return largest;
    }
    /// Replaces coefficients by others and changes `source` accordingly; returns by how much at
    /// most, per function.
    Row replace(Coefficients& all, const Coefficients& by, std::span<Row> source) const noexcept {
        Row disturbance;
        disturbance.fill(0.0);
        for (std::size_t n = 0; n < corners_.size(); ++n) {
            const Treated& t = corners_[n];
            for (std::size_t k = 1; k <= t.corner.count(); ++k) {
                Row change;
                for (std::size_t lane = 0; lane < width; ++lane) {
                    change[lane] = by[n][k][lane] - all[n][k][lane];
                    disturbance[lane] += t.largest_defect[k] * std::fabs(change[lane]);
                }
                add_defects(t, k, change, source);
            }
        }
        all = by;
        return disturbance;
    }

    /// What interpolation by `stencil` at `p` (in units of the lattice) misses of each function of
    /// the corner whose disc the stencil lies in.
    struct Correction {
        static constexpr std::uint32_t none = ~std::uint32_t{0};
        std::uint32_t corner = none;
        std::array<double, Corner::most + 1> missed{};
    };
    template <class NodePlace>
    Correction correction(const Vec<double, 2>& p, const CutStencil<2>& stencil,
                          const NodePlace& place) const {
        Correction result;
        double nearest = std::numeric_limits<double>::max();
        for (std::size_t n = 0; n < corners_.size(); ++n) {
            const double d = corners_[n].corner.distance(p);
            if (d + 1.5 > corners_[n].corner.radius() || d >= nearest || !corners_[n].corner.holds(p))
                continue;
            nearest = d;
            result.corner = std::uint32_t(n);
        }
        if (result.corner == Correction::none) return result;
        const Corner& corner = corners_[result.corner].corner;
        result.missed = corner.functions(p);
        const auto take = [&](const Vec<double, 2>& q, double share) {
            const auto f = corner.functions(q);
            for (std::size_t k = 0; k < f.size(); ++k) result.missed[k] -= share * f[k];
        };
        for (std::uint32_t i = 0; i < stencil.node_count; ++i)
            take(place(stencil.nodes[i].node), stencil.nodes[i].share);
        for (std::uint32_t i = 0; i < stencil.place_count; ++i) {
            const auto& value = stencil.places[i].value;
            take(value.weight[0] * vertices_[value.handle[0]] + value.weight[1] * vertices_[value.handle[1]],
                 stencil.places[i].share);
        }
        return result;
    }
    static void apply(const Correction& correction, const Coefficients& all,
                      std::array<double, width>& value) noexcept {
        if (correction.corner == Correction::none) return;
        for (std::size_t k = 0; k < correction.missed.size(); ++k) {
            if (correction.missed[k] == 0) continue;
            for (std::size_t lane = 0; lane < width; ++lane)
                value[lane] += correction.missed[k] * all[correction.corner][k][lane];
        }
    }

private:
    static constexpr double least_radius = 10, most_radius = 24;

    struct Defect {
        std::uint32_t node;                        ///< then the slot
        std::array<double, Corner::most + 1> of{}; ///< A applied to each function
    };
    struct Around {
        std::uint32_t node;
        double along, w;
    };
    struct Treated {
        Corner corner;
        std::array<std::size_t, 3> handles; ///< at the corner, before it, after it
        std::vector<Defect> defects{};
        std::vector<Around> around{}; ///< nodes of the fit
        std::vector<double> fit{};    ///< of each of them, its share in each coefficient
        std::array<double, Corner::most + 1> largest_defect{};
    };

    /// Slopes of a handle's hat along the edge after the corner and the one before it, away from
    /// the corner.
    static std::array<double, 2> slopes(const Treated& t, std::size_t handle) noexcept {
        std::array<double, 2> slope{};
        if (handle == t.handles[0]) slope = {-1 / t.corner.length_after(), -1 / t.corner.length_before()};
        if (handle == t.handles[1]) slope[1] += 1 / t.corner.length_before();
        if (handle == t.handles[2]) slope[0] += 1 / t.corner.length_after();
        return slope;
    }
    static void add_defects(const Treated& t, std::size_t k, const Row& coefficients,
                            std::span<Row> source) noexcept {
        for (const Defect& defect : t.defects) {
            for (std::size_t lane = 0; lane < width; ++lane)
                source[defect.node][lane] += defect.of[k] * coefficients[lane];
        }
    }

    /// The vertices that edges lead to from every vertex, counter-clockwise: between neighbours
    /// lies a corner of the inside. None of a vertex without edges.
    template <class Cage>
    std::vector<std::vector<std::size_t>> neighbours_of_vertices(const Cage& cage) const {
        std::vector<std::vector<std::size_t>> all(vertices_.size());
        const auto& polygon = boundary_of(cage);
        for (std::size_t n = 0; n < polygon.loops().size(); ++n) {
            const bool left = inside_is_left(polygon, n);
            polygon.loops()[n].for_each_edge([&](std::size_t i, std::size_t j) {
                all[i].insert(left ? all[i].begin() : all[i].end(), j);
                all[j].insert(left ? all[j].end() : all[j].begin(), i);
            });
        }
        const auto& cells = interior_cells(cage);
        for (const auto& [i, j] : cells.facets) {
            add_neighbour(all[i], i, j);
            add_neighbour(all[j], j, i);
        }
        return all;
    }
    void add_neighbour(std::vector<std::size_t>& of_i, std::size_t i, std::size_t j) const {
        if (of_i.empty()) { // the end of a chain, so far: from this edge all about to itself
            of_i = {j, j};
            return;
        }
        const auto turn_to = [&](std::size_t k) { // counter-clockwise from the first, in (0, 2π]
            const auto a = vertices_[of_i.front()] - vertices_[i], b = vertices_[k] - vertices_[i];
            const double angle = std::atan2(cross(a, b), dot(a, b));
            return of_i.front() == k || angle <= 0 ? angle + 2 * std::numbers::pi : angle;
        };
        of_i.insert(std::find_if(of_i.begin() + 1, of_i.end(),
                                 [&](std::size_t k) { return turn_to(k) > turn_to(j); }),
                    j);
    }

    /// How far the disc about a vertex reaches in which no other part of the boundary lies.
    template <class Cage>
    double room_about(std::size_t i, const Cage& cage, double spacing) const {
        double radius = most_radius;
        const auto keep_off = [&](std::size_t j, std::size_t k, double margin) {
            const auto &p = vertices_[i], &a = vertices_[j], &b = vertices_[k];
            radius = std::min(radius, j == i || k == i ? detail::length(a - b)
                                                       : detail::distance_to_segment(p, a, b) - margin);
        };
        boundary_of(cage).for_each_edge([&](std::size_t j, std::size_t k) { keep_off(j, k, 0); });
        const auto& cells = interior_cells(cage);
        for (const auto& [j, k] : cells.facets) keep_off(j, k, 0);
        for (const auto& bone : cells.bones) keep_off(bone.i, bone.j, bone.radius / spacing);
        return radius;
    }

    /// Treats a corner, if there are nodes enough for a fit.
    void add(Treated t, const EmbeddedProblem<2>& problem) {
        const double radius = t.corner.radius();
        const auto& nodes = problem.nodes;
        for_each_node_within(radius, vertices_[t.handles[0]], nodes, [&](std::uint32_t node, const auto& p) {
            if (!t.corner.holds(p)) return;
            const double r = t.corner.distance(p);
            if (r + 1 < radius) t.defects.push_back(defect_of(t.corner, node, p, problem));
            if (r > 0.3 * radius && r < 0.8 * radius)
                t.around.push_back({node, t.corner.along(p), t.corner.functions(p)[0]});
        });
        if (t.around.size() < 3 * t.corner.count()) return;
        fit_to_nodes(t, nodes);
        for (const Defect& defect : t.defects) {
            for (std::size_t k = 0; k < defect.of.size(); ++k)
                t.largest_defect[k] = std::max(t.largest_defect[k], std::fabs(defect.of[k]));
        }
        corners_.push_back(std::move(t));
    }

    /// f(node, position) for the nodes of a square about a place.
    template <class F>
    static void for_each_node_within(double reach, const Vec<double, 2>& centre, const NodeRuns<2>& nodes,
                                     F&& f) {
        NodeRuns<2>::Index low, high;
        for (std::size_t k = 0; k < 2; ++k) {
            low[k] = std::int32_t(std::max(std::ceil(centre[k] - reach), 0.0));
            high[k] = std::int32_t(std::min(std::floor(centre[k] + reach), double(nodes.size()[k]) - 1));
        }
        for (auto index = low; index[1] <= high[1]; ++index[1]) {
            for (index[0] = low[0]; index[0] <= high[0]; ++index[0]) {
                const auto node = nodes.find(index);
                if (node != NodeRuns<2>::none) f(node, node_position<2>(index));
            }
        }
    }

    /// Least squares: the share of each node around in every coefficient, (SᵀS)⁻¹ Sᵀ, S the
    /// functions at the nodes.
    static void fit_to_nodes(Treated& t, const NodeRuns<2>& nodes) {
        const auto count = long(t.corner.count());
        Eigen::MatrixXd s(long(t.around.size()), count);
        for (long i = 0; i < s.rows(); ++i) {
            const auto node = t.around[std::size_t(i)].node;
            const auto f = t.corner.functions(node_position<2>(nodes.index(node)));
            for (long k = 0; k < count; ++k) s(i, k) = f[std::size_t(k) + 1];
        }
        const Eigen::MatrixXd shares = (s.transpose() * s).ldlt().solve(s.transpose());
        for (long i = 0; i < s.rows(); ++i) {
            for (long k = 0; k < count; ++k) t.fit.push_back(shares(k, i));
        }
    }

    /// What the difference equation of a node makes of the functions, which is zero for those that
    /// it knows exactly.
    static Defect defect_of(const Corner& corner, std::uint32_t node, const Vec<double, 2>& p,
                            const EmbeddedProblem<2>& problem) {
        Defect defect{node};
        const auto here = corner.functions(p);
        auto cut = std::lower_bound(problem.cuts.begin(), problem.cuts.end(), node,
                                    [](const CutLink& a, std::uint32_t n) { return a.node < n; });
        std::array<double, 4> weight{1, 1, 1, 1};
        for (; cut != problem.cuts.end() && cut->node == node; ++cut) weight[cut->direction] = cut->weight;
        for (std::size_t direction = 0; direction < 4; ++direction) {
            auto q = p;
            q[direction / 2] += ((direction & 1) != 0 ? 1 : -1) / weight[direction];
            const auto there = corner.functions(q);
            for (std::size_t k = 0; k < here.size(); ++k)
                defect.of[k] += weight[direction] * (here[k] - there[k]);
        }
        return defect;
    }

    std::vector<Vec<double, 2>> vertices_;
    std::vector<Treated> corners_;
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
