// Samples harmonic functions in space by a smooth blend of local harmonic models, which leaf_samples.hpp
// makes.
//
// At a point x inside the cage the function of handle i is
//
//     u_i(x) = Σ_m w_m(x) M_m,i(x) / Σ_m w_m(x) + E_i(x)
//
// over the models m of the leaves near x. A leaf inside has one model, a leaf that faces cut up to four. The
// weight w_m is a twice differentiable function of x. It is 0 from a fifth of a leaf's size beyond the leaf
// on. A face between x and the place of the model makes the weight nearly 0. A model is a fit to data about
// its leaf, corrected for kinks as in near_rows.hpp, with one L_i for the whole model:
//
//     M_i(x) = Σ_d S_d(x) y_i(d) + F(L_i),   F(L) = L(x) − Σ_d S_d(x) L(d),
//     S(x) = b(x)ᵀ (BᵀWB + R)⁻¹ BᵀW.
//
// d runs over nodes about the leaf and places of the boundary, and y are the values there. b are 16 harmonic
// polynomials up to degree three, and two functions for each of the nearest bent edges. The diagonal matrix W
// holds the weights of the data. Weights fall with the distance from the middle of the leaf, and are three
// times as large at the boundary. R is a ridge, next to zero for linear functions: constants and positions
// are kept. E adds what the models miss at the nearest faces, and fades within a fifth of a leaf:
//
//     E_i(x) = Σ_f a_f (φ_i(q_f) − Σ_m w_m(x) M_m,i(q_f) / Σ_m w_m(x)) / (1 + Σ_f a_f).
//
// The place q_f of face f lies near x and is a smooth function of x. So u tends to the data at faces.
#pragma once

#include <cageform/coordinates/harmonic/near_patch.hpp>
#include <cageform/coordinates/harmonic/ridge_fit.hpp>
#include <cageform/coordinates/harmonic/stencil_table.hpp>
#include <cageform/grid/tree/cut_tree.hpp>

#include <map>
#include <string>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Rises from 0 at t ≤ 0 to 1 at t ≥ 1, twice differentiable.
inline double smooth_step(double t) noexcept {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * t * (10 - 15 * t + 6 * t * t);
}

/// A model of the functions in a leaf and about it.
class LeafModel {
    using Point = NearField::Point;
    using Cell = grid::CellTree<3>::Cell;
    using Nodes = grid::TreeNodes<3>;

public:
    static constexpr std::size_t polynomials = 16, most_wedges = 4,
                                 most_functions = polynomials + 2 * most_wedges;
    using Values = std::array<double, most_functions>;

    /// A place where values are known: a node, or a place of the boundary.
    struct Datum {
        Point at;
        double weight;
        std::uint32_t node; ///< none: on the boundary
        BoundaryValue<3> value;
    };

    ///   place  of the leaf, inside: what the model sees is seen from there
    LeafModel(const grid::CutTree<3>& tree, const Nodes& nodes, const NearField& field, const Cell& leaf,
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
        for (std::size_t n = 0; n < 64; ++n) { // the corners of the leaf, and of those across its faces
            Index index = leaf_.low;
            std::size_t outer = 0;
            for (std::size_t k = 0, rest = n; k < 3; ++k, rest /= 4) {
                index[k] += leaf_.size * (std::int32_t(rest % 4) - 1);
                outer += rest % 4 % 3 == 0 ? 1 : 0;
            }
            if (outer <= 1) add_node(index, true);
        }
        for (const Cell& cell : larger_) {
            for (std::size_t n = 0; n < 8; ++n) {
                const Index index = cell.corner(n);
                const auto is_it = [p = node_position<3>(index)](const Datum& datum) {
                    return datum.at == p;
                };
                if (std::none_of(data_.begin(), data_.end(), is_it)) add_node(index, false);
            }
        }
        if (is_valid() && is_near_) find_edges();
    }
    LeafModel(const LeafModel&) = delete;
    LeafModel& operator=(const LeafModel&) = delete;
    ~LeafModel() = default;

    /// Whether there is enough data for a linear function.
    bool is_valid() const noexcept { return data_.size() >= 4; }
    double size() const noexcept { return size_; } ///< of the leaf
    std::span<const Datum> data() const noexcept { return data_; }
    bool is_near() const noexcept { return is_near_; } ///< whether a leaf about it is cut or outside

    /// Returns the visibility of a point from the model's place, in [1e-6, 1]: 1e-6 if a face lies between.
    double visibility(const Point& x) const noexcept {
        constexpr double least = 1e-6; // serves where no model sees the point
        if (!is_near_) return 1;
        if (field_.boundary().first_met(place_, (1 - 1e-3) * (x - place_))) return least;
        double factor = 1;
        for (const auto& [from, to] : reflex_) {
            const double here = distance_to_segment(x, from, to);
            if (here > 0) factor *= smooth_step(segment_distance(place_, x, from, to) / (0.7 * here));
        }
        return least + (1 - least) * factor;
    }

    /// Returns the number of functions of the fit.
    std::size_t functions() const noexcept { return polynomials + 2 * wedges_.size(); }
    /// Returns their values at a point.
    Values values(const Point& p) const noexcept {
        const Point q = (1 / size_) * (p - middle_);
        const double x = q[0], y = q[1], z = q[2];
        const double xx = x * x, yy = y * y, zz = z * z;
        Values values{1,
                      x,
                      y,
                      z,
                      x * y,
                      y * z,
                      z * x,
                      (xx - yy) / 2,
                      (2 * zz - xx - yy) / 2,
                      x * y * z,
                      z * (xx - yy) / 2,
                      x * (xx - 3 * yy) / 3,
                      y * (3 * xx - yy) / 3,
                      z * (2 * zz - 3 * xx - 3 * yy) / 6,
                      x * (4 * zz - xx - yy) / 6,
                      y * (4 * zz - xx - yy) / 6};
        for (std::size_t n = 0; n < wedges_.size(); ++n) {
            auto at = wedges_[n].place(p);
            at.r /= size_;
            const double power = std::numbers::pi / wedges_[n].angle;
            double* const to = values.data() + polynomials + 2 * n;
            to[0] = wedges_[n].singular(at);
            to[1] = power < 1 ? 0.5 * std::pow(at.r, 2 * power) * std::sin(2 * power * at.theta)
                              : to[0] * dot(wedges_[n].along, p - middle_) / size_;
        }
        return values;
    }
    /// Chooses the vertices whose double layers correct the model. Returns false if there are none.
    bool look(NearPatch& patch) const {
        return patch.look(place_, (is_near_ ? radius_near : radius_inside) * size_);
    }
    /// Returns a datum's place in a leaf that no face is near, in halves of the leaf, plus 16.
    std::array<char, 3> place_in_leaf(const Datum& datum) const noexcept {
        std::array<char, 3> place{};
        for (std::size_t k = 0; k < 3; ++k) place[k] = char(16 + 2 * (datum.at[k] - middle_[k]) / size_);
        return place;
    }

    /// Returns viewpoints of a leaf. A leaf that no face cuts has its middle. Others have a point far from
    /// faces, then points that are hidden from the earlier ones.
    static std::vector<Point> places_of(const grid::CutTree<3>& tree, const NearField& field,
                                        const Cell& leaf) {
        constexpr std::size_t most = 4, across = 5;
        constexpr double free = 0.3; // in sizes of the leaf; greater distances from faces score no more
        const auto middle = leaf.middle();
        const auto facets = tree.facets(leaf.number);
        const auto& boundary = tree.boundary();
        if (tree.state(leaf.number) == grid::CellState::in) return {middle};
        // A single facet divides the leaf.
        const bool is_halved = facets.size() == 1 && boundary.separates(facets[0]);
        std::vector<std::pair<double, Point>> inside;
        for (std::size_t n = 0; n < across * across * across; ++n) {
            Point p{};
            for (std::size_t k = 0, rest = n; k < 3; ++k, rest /= across)
                p[k] = leaf.low[k] + (0.02 + 0.24 * double(rest % across)) * leaf.size;
            if (is_halved ? !(dot(boundary.normal(facets[0]), boundary[facets[0]].corner[0] - p) > 0)
                          : !tree.is_inside(p))
                continue;
            inside.push_back({(std::min)(boundary.nearest(facets, p).distance, free * leaf.size) -
                                  0.25 * length(p - middle),
                              p});
        }
        std::sort(inside.begin(), inside.end(),
                  [](const auto& a, const auto& b) { return a.first > b.first; });
        const bool hides = facets.size() > 2 || has_reflex_edge(field, middle, 0.9 * leaf.size);
        std::vector<Point> places;
        for (const auto& [score, p] : inside) {
            if (places.size() == most || (!places.empty() && !hides)) break;
            if (std::all_of(places.begin(), places.end(), [&, to = p](const Point& from) {
                    return boundary.first_met(from, to - from, facets).has_value();
                }))
                places.push_back(p);
        }
        return places;
    }

private:
    using Index = std::array<std::int32_t, 3>;
    static constexpr double radius_near = 3.5, radius_inside = 2; ///< of the near field, in sizes of the leaf

    /// Calls f(edge) for the bent edges that are nearer to a point than a distance.
    template <class F>
    static void for_each_near_bent_edge(const NearField& field, const Point& p, double distance, const F& f) {
        std::vector<std::uint32_t> known;
        field.boundary().for_each_within(p, distance, [&](std::uint32_t face) {
            for (const std::uint32_t e : field.face(face).edge) {
                const auto& edge = field.edge(e);
                if (!field.is_bent(e) || std::find(known.begin(), known.end(), e) != known.end()) continue;
                known.push_back(e);
                const double apart = distance_to_segment(p, field.at(edge.from), field.at(edge.to));
                if (apart < distance) f(e, apart);
            }
        });
    }
    static bool has_reflex_edge(const NearField& field, const Point& p, double distance) {
        bool any = false;
        for_each_near_bent_edge(field, p, distance, [&](std::uint32_t e, double) {
            any = any || field.wedge(e).angle > std::numbers::pi;
        });
        return any;
    }
    /// Finds the larger leaves about the leaf, and the facets that pass the leaves about it.
    void find_surroundings() {
        is_near_ = tree_.state(leaf_.number) != grid::CellState::in;
        Cell around = leaf_; // holds all leaves about it
        const auto is_around = [&] {
            for (std::size_t k = 0; k < 3; ++k) {
                if (leaf_.low[k] == around.low[k] || leaf_.low[k] + leaf_.size == around.low[k] + around.size)
                    return false;
            }
            return true;
        };
        while (around.number != 0 && !is_around()) around = tree_.cells().parent_of(around.number);
        for (std::int32_t n = 0; n < 27; ++n) {
            Index doubled{};
            for (std::size_t k = 0, rest = std::size_t(n); k < 3; ++k, rest /= 3)
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
        std::sort(facets_.begin(), facets_.end());
        facets_.erase(std::unique(facets_.begin(), facets_.end()), facets_.end());
    }
    /// Adds a node, unless the boundary hides it.
    ///
    ///   adds_hiding_place  whether a place of the boundary that hides the node is added in its stead
    void add_node(const Index& index, bool adds_hiding_place) {
        const auto p = node_position<3>(index);
        bool is_in_tree = true;
        for (const std::int32_t x : index) is_in_tree = is_in_tree && x >= 0 && x <= tree_.cells().size();
        const double apart = length(p - middle_) / size_, weight = 1 / (0.3 + apart * apart * apart * apart);
        if (is_near_ && p != place_) {
            const auto& boundary = tree_.boundary();
            if (const auto met = boundary.first_met(place_, p - place_, facets_)) {
                if (!adds_hiding_place) return;
                auto value = met->value;
                if (met->fraction < 0.1) { // a thin place: data next to the viewpoint alone do not suffice
                    const auto nearest = boundary.nearest(facets_, p);
                    if (!boundary.first_met(place_, (1 - 1e-3) * (nearest.position - place_), facets_))
                        value = nearest.value;
                }
                data_.push_back({field_.moved_inside(value, place_), 3 * weight, Nodes::none, value});
                return;
            }
        }
        const std::uint32_t node = is_in_tree ? nodes_.find(index) : Nodes::none;
        if (node == Nodes::none) return;
        data_.push_back({p, weight, node, {}});
    }
    /// Finds the reflex edges that can hide points, and the wedges that hold all data.
    void find_edges() {
        std::vector<std::pair<double, Wedge>> found;
        for_each_near_bent_edge(field_, middle_, 2.5 * size_, [&](std::uint32_t e, double apart) {
            const Wedge wedge = field_.wedge(e);
            const auto& edge = field_.edge(e);
            if (wedge.angle > std::numbers::pi && apart < 1.5 * size_)
                reflex_.push_back({field_.at(edge.from), field_.at(edge.to)});
            if (wedge.is_singular() && std::all_of(data_.begin(), data_.end(), [&](const Datum& datum) {
                    return wedge.has(wedge.place(datum.at));
                }))
                found.push_back({apart, wedge});
        });
        std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        for (std::size_t n = 0; n < (std::min)(found.size(), most_wedges); ++n)
            wedges_.push_back(found[n].second);
    }

    const grid::CutTree<3>& tree_;
    const Nodes& nodes_;
    const NearField& field_;
    Cell leaf_;
    Point middle_, place_;
    double size_;
    bool is_near_ = false;
    std::vector<Cell> larger_;
    std::vector<std::uint32_t> facets_;
    std::vector<Datum> data_;
    std::vector<Wedge> wedges_;
    std::vector<std::pair<Point, Point>> reflex_;
};

/// Fits models, one at a time, and evaluates them.
class LeafFit {
    using Point = NearField::Point;
    using Values = LeafModel::Values;
    using Handle = StencilTable<3>::Handle;

public:
    ///   degree  of the polynomials, 2 or 3
    LeafFit(const NearField& field, unsigned degree)
        : patch_(field)
        , ridge_of_cubic_(degree == 3 ? 1e-4 : 1e8) {}

    /// Fits a model, for points.
    void set(const LeafModel& model, std::span<const Point> points) {
        model_ = &model;
        blocks_ = block_count<double>(model.data().size());
        shares_ = model.is_near() ? &fitted(own_shares_) : &fitted_by_pattern();
        has_layers_ = model.look(patch_);
        if (!has_layers_) return;
        unsigned unused_mirrors = 0;
        places_.clear();
        for (const auto& datum : model.data()) {
            places_.push_back(datum.at);
            unused_mirrors |= patch_.mirrors_passed(datum.at);
        }
        places_.insert(places_.end(), points.begin(), points.end());
        patch_.evaluate(places_, unused_mirrors);
    }
    /// Appends the shares of the model in a sum of values at points, each multiplied by its factor.
    ///
    ///   first     the number of points[0] among those of `set`
    ///   shares    of all data
    ///   vertices  the shares of vertices, without those by data
    void add(std::span<const Point> points, std::span<const double> factors, std::size_t first,
             Buffer<double>& shares, Buffer<Handle>& vertices) {
        using X = Simd<double>;
        const auto data = model_->data();
        Values sum{};
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Values values = model_->values(points[n]);
            for (std::size_t k = 0; k < values.size(); ++k) sum[k] += factors[n] * values[k];
        }
        row_.resize(blocks_);
        for (std::size_t b = 0; b < blocks_; ++b) {
            X row(0.0);
            for (std::size_t k = 0; k < model_->functions(); ++k)
                row = multiply_add(X(sum[k]), X::load((*shares_)[k * blocks_ + b]), row);
            row.store(row_[b]);
        }
        for (std::size_t d = 0; d < data.size(); ++d)
            shares.push_back(row_[d / lane_count<double>][d % lane_count<double>]);
        if (!has_layers_) return;
        amount_.assign(patch_.vertices().size(), 0.0);
        for (std::size_t v = 0; v < amount_.size(); ++v) {
            for (std::size_t n = 0; n < points.size(); ++n)
                amount_[v] += factors[n] * patch_.layer(v, data.size() + first + n);
            amount_[v] = 2 * (amount_[v] - patch_.sum(v, row_));
        }
        patch_.finish(amount_, -1, {}); // drops nothing: what is dropped at a threshold jumps
        for (std::size_t v = 0; v < amount_.size(); ++v)
            vertices.push_back({patch_.vertices()[v], amount_[v]});
    }

private:
    /// The shares of data in functions; see ridge_fit.
    using Shares = Buffer<Lanes<double>>;

    /// Returns the shares of the model's data, which depend on their pattern only.
    const Shares& fitted_by_pattern() {
        pattern_.clear();
        for (const auto& datum : model_->data()) {
            const auto place = model_->place_in_leaf(datum);
            pattern_.append(place.begin(), place.end());
        }
        auto known = patterns_.find(pattern_);
        if (known == patterns_.end()) {
            known = patterns_.emplace(pattern_, Shares()).first;
            (void)fitted(known->second);
        }
        return known->second;
    }
    const Shares& fitted(Shares& shares) {
        const auto data = model_->data();
        basis_.resize(data.size());
        weight_.resize(data.size());
        double trace = 0;
        for (std::size_t d = 0; d < data.size(); ++d) {
            basis_[d] = model_->values(data[d].at);
            weight_[d] = data[d].weight;
            trace += data[d].weight;
        }
        const double damping = model_->is_near() ? trace : 1e-4 * trace;
        Values ridges{};
        for (std::size_t k = 0; k < ridges.size(); ++k) {
            const bool is_linear = k < 4, is_cubic = k >= 9 && k < LeafModel::polynomials;
            ridges[k] = is_linear ? 1e-13 * trace : is_cubic ? ridge_of_cubic_ * damping : 1e-6 * damping;
        }
        const std::span<const Values> basis(basis_);
        const auto ridge = std::span<const double>(ridges).first(model_->functions());
        if (ridge.size() == LeafModel::polynomials) {
            ridge_fit<LeafModel::polynomials>(basis, weight_, ridge, shares);
        } else {
            ridge_fit<LeafModel::most_functions>(basis, weight_, ridge, shares);
        }
        return shares;
    }

    const LeafModel* model_ = nullptr;
    std::size_t blocks_ = 0; ///< of data
    const Shares* shares_ = nullptr;
    Shares own_shares_;
    std::map<std::string, Shares> patterns_; ///< of data about leaves that no face is near
    std::string pattern_;
    std::vector<Values> basis_;
    std::vector<double> weight_;
    NearPatch patch_;
    double ridge_of_cubic_;     ///< a large one leaves cubic polynomials out
    bool has_layers_ = false;   ///< whether the patch corrects the model
    std::vector<Point> places_; ///< of data, then points
    Shares row_;
    std::vector<double> amount_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
