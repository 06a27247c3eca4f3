// Blends the models of leaves by the formula of leaf_models.hpp.
#pragma once

#include <cageform/coordinates/harmonic/leaf_models.hpp>
#include <cageform/coordinates/harmonic/plane_models.hpp>

#include <bit>
#include <memory>
#include <optional>
#include <unordered_map>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Sums shares by node or vertex number.
template <class Share>
class ShareSums {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

public:
    void add(std::uint32_t number, double share) {
        if (2 * sums_.size() >= table_.size()) grow();
        std::uint32_t& slot = slot_of(number);
        if (slot != none) {
            auto& [known, sum] = sums_[slot];
            sum += share;
        } else {
            slot = std::uint32_t(sums_.size());
            sums_.push_back({number, share});
        }
    }
    /// Distributes a share of the value at a boundary point to the vertices of its facet.
    template <std::size_t D>
    void add(const BoundaryValue<D>& value, double share) {
        LinearBoundaryData<D>::for_each_weight(
            value, [&](std::uint32_t vertex, double weight) { add(vertex, share * weight); });
    }
    std::span<const Share> sums() const noexcept { return {sums_.data(), sums_.size()}; }
    void clear() noexcept {
        sums_.clear();
        std::fill(table_.begin(), table_.end(), none);
    }

private:
    std::uint32_t& slot_of(std::uint32_t number) noexcept { // hashed as in TreeNodes
        std::uint32_t at = (number * 0x9e3779b9u) >> (32 - bits_);
        for (;; at = (at + 1) & std::uint32_t(table_.size() - 1)) {
            if (table_[at] == none) return table_[at];
            const auto& [known, sum] = sums_[table_[at]];
            if (known == number) return table_[at];
        }
    }
    void grow() {
        ++bits_;
        table_ = Buffer<std::uint32_t>(std::size_t{1} << bits_, none);
        for (std::uint32_t n = 0; n < sums_.size(); ++n) {
            const auto& [number, sum] = sums_[n];
            slot_of(number) = n;
        }
    }

    unsigned bits_ = 5;
    Buffer<std::uint32_t> table_; ///< a hash table of indices of sums_, at most half full
    Buffer<Share> sums_;
};

/// Makes the stencils of points inside a cage. Points of one leaf share its models. A stencil does not depend
/// on other points.
///
///   Model, Fit  LeafModel and LeafFit in 3D, PlaneModel and ModelFit<PlaneModel> in 2D
template <class Model, class Fit>
class LeafSamples {
    static constexpr std::size_t D = Model::D;
    static constexpr std::uint32_t none = Model::Nodes::none;
    using Point = typename Model::Point;
    using Cell = typename Model::Cell;
    using Field = typename Model::Field;
    using Table = StencilTable<D>;

public:
    ///   degree  the largest degree of the models' polynomials
    LeafSamples(const grid::CutTree<D>& tree, const grid::TreeNodes<D>& nodes, const Field& field,
                unsigned degree = Model::degree)
        : tree_(tree)
        , nodes_(nodes)
        , field_(field)
        , fit_(field, degree) {}

    /// Calls emit(nodes, vertices) for each point in order, with the shares of nodes and vertices in the
    /// functions' values. The points lie inside, in units of the tree.
    template <class Emit>
    void stencils(std::span<const Point> points, const Emit& emit) {
        points_.clear();
        for (const Point& p : points) points_.push_back({p, 1, points_.size()});
        make_sums(points.size(), emit);
    }

    /// Returns a point where the functions are differentiable: x unless x lies on the boundary. For such an
    /// x, tries the points a hundredth of a leaf from x along the leaf's diagonals, and returns the inside
    /// point that is farthest from faces. Returns nothing if none is inside.
    std::optional<Point> differentiable_place(const Point& x) const {
        const double size = tree_.leaf_at(x).size;
        double most = least_free;
        if (tree_.is_inside(x) && !(free_distance(x, most) < most)) return x;
        std::optional<Point> place;
        for (unsigned direction = 0; direction < grid::CellTree<D>::children; ++direction) {
            Point q = x;
            for (std::size_t k = 0; k < D; ++k)
                q[k] += (((direction >> k) & 1u) != 0 ? 0.01 : -0.01) * size / std::sqrt(double(D));
            if (!tree_.is_inside(q) || field_.boundary().first_met(q, 0.9 * (x - q))) continue;
            const double free = free_distance(q, size);
            if (!(free > 1.001 * most)) continue; // rounding must not decide ties
            most = free;
            place = q;
        }
        return place;
    }
    /// Calls emit(nodes, vertices) D + 1 times for each result of `differentiable_place`: with the stencil of
    /// the value, then of the derivatives along the axes, per unit of length of the cage. Derivatives are
    /// central differences over two thousandths of a leaf, next to faces over a fiftieth of the distance.
    /// Their relative error is about 1e-6, because shares are C² and not rounded.
    template <class Emit>
    void slopes(std::span<const Point> places, const Emit& emit) {
        points_.clear();
        std::size_t count = 0;
        for (const Point& p : places) {
            const double step = 0.01 * free_distance(p, 0.1 * tree_.leaf_at(p).size);
            points_.push_back({p, 1, count++});
            for (std::size_t axis = 0; axis < D; ++axis, ++count) {
                Point below = p, above = p;
                below[axis] -= step;
                above[axis] += step;
                const double factor = 1 / (field_.boundary().unit() * (above[axis] - below[axis]));
                points_.push_back({below, -factor, count});
                points_.push_back({above, factor, count});
            }
        }
        make_sums(count, emit);
    }

private:
    /// Emits the sums of the stencils of `points_`, multiplied by the points' factors.
    template <class Emit>
    void make_sums(std::size_t count, const Emit& emit) {
        terms_.clear();
        for (std::uint32_t n = 0; n < points_.size(); ++n) {
            visit(tree_.cells().root(), points_[n].at, [&](const Cell& leaf, double weight) {
                terms_.push_back({leaf.number, n, weight, nullptr});
            });
        }
        std::sort(terms_.begin(), terms_.end(), [](const Term& a, const Term& b) {
            return a.leaf != b.leaf ? a.leaf < b.leaf : a.point < b.point;
        });
        const auto leaves = std::exchange(terms_, {});
        for (auto begin = leaves.begin(), end = begin; begin != leaves.end(); begin = end) {
            while (end != leaves.end() && end->leaf == begin->leaf) ++end;
            for (const auto& model : models_of(begin->leaf)) {
                for (auto term = begin; term != end; ++term) {
                    const double weight = term->weight * model->visibility(points_[term->point].at);
                    if (weight > 0) add_term({term->leaf, term->point, weight, model.get()});
                }
            }
        }
        for (std::uint32_t n = 0; n < points_.size(); ++n) {
            if (!(points_[n].total > 0)) add_own_model(n);
            find_feet(points_[n]);
        }
        sums_.assign(count, {});
        runs_.clear();
        shares_.clear();
        vertices_.clear();
        for (auto begin = terms_.begin(), end = begin; begin != terms_.end(); begin = end) {
            while (end != terms_.end() && end->model == begin->model) ++end;
            add_model({begin, end});
        }
        auto point = points_.begin();
        for (std::size_t n = 0; n < count; ++n) {
            add_runs(sums_[n]);
            for (; point != points_.end() && point->sum == n; ++point) {
                for (const Foot& foot : point->feet) of_vertices_.add(foot.value, point->factor * foot.share);
            }
            emit(of_nodes_.sums(), of_vertices_.sums());
        }
        own_models_.clear();
    }

    struct Term {
        std::uint32_t leaf, point;
        double weight;
        const Model* model;
    };
    struct Run { ///< the shares of one model's data in one sum
        const Model* model;
        std::size_t shares, vertices; ///< indices of the first shares
        std::size_t vertices_end = 0;
        std::uint32_t next = none; ///< the next run of the sum
    };
    struct Sum {
        std::uint32_t first = none, last = none; ///< runs of the sum
    };
    struct Foot { ///< a point of a face near a sampled point
        Point at;
        BoundaryValue<D> value;
        double share; ///< a / (1 + Σ a)
    };
    struct Sampled {
        Point at;
        double factor;              ///< of the stencil in the sum
        std::size_t sum;            ///< index of the sum
        double total = 0, size = 0; ///< sum of weights; sum of weights times leaf sizes
        bool is_on_face = false;
        std::vector<Foot> feet{};
    };

    /// Calls f(leaf, weight) for the leaves near a point.
    template <class F>
    void visit(const Cell& cell, const Point& x, const F& f) const {
        constexpr double overlap = 0.2; // reach of models beyond their leaf, in leaf sizes
        if (tree_.state(cell.number) == grid::CellState::out) return;
        const bool is_leaf = tree_.cells().is_leaf(cell.number);
        const double reach = overlap * cell.size * (is_leaf ? 1 : 0.5);
        double weight = 1;
        for (std::size_t k = 0; k < D; ++k) {
            const double beyond = (std::max)(cell.low[k] - x[k], x[k] - cell.low[k] - cell.size);
            if (beyond >= reach) return;
            weight *= smooth_step((reach - beyond) / (2 * reach));
        }
        if (is_leaf) return f(cell, weight);
        // Bit n is child n: masks of the children at the lower and upper end of each axis.
        constexpr std::array<unsigned, 3> lower{0x55, 0x33, 0x0f}, upper{0xaa, 0xcc, 0xf0};
        unsigned children = (1u << grid::CellTree<D>::children) - 1;
        for (std::size_t k = 0; k < D; ++k) {
            const double beyond = x[k] - cell.low[k] - 0.5 * cell.size, most = 0.5 * overlap * cell.size;
            children &= (beyond < most ? lower[k] : 0) | (beyond > -most ? upper[k] : 0);
        }
        for (; children != 0; children &= children - 1)
            visit(tree_.cells().child(cell, std::size_t(std::countr_zero(children))), x, f);
    }
    const std::vector<std::unique_ptr<Model>>& models_of(std::uint32_t number) {
        const auto [known, is_new] = models_.try_emplace(number);
        if (is_new) {
            const Cell leaf = tree_.cells().cell(number);
            for (const Point& place : Model::places_of(tree_, field_, leaf)) {
                auto model = make_model(leaf, place);
                if (model->is_valid()) known->second.push_back(std::move(model));
            }
        }
        return known->second;
    }
    std::unique_ptr<Model> make_model(const Cell& leaf, const Point& place) {
        return std::make_unique<Model>(tree_, nodes_, field_, leaf, place);
    }
    void add_term(const Term& term) {
        terms_.push_back(term);
        points_[term.point].total += term.weight;
        points_[term.point].size += term.weight * term.model->size();
    }
    /// Adds a model with the point itself as viewpoint, for a point that no other model covers.
    void add_own_model(std::uint32_t point) {
        const Cell leaf = tree_.leaf_at(points_[point].at);
        own_models_.push_back(make_model(leaf, points_[point].at));
        if (own_models_.back()->is_valid()) add_term({leaf.number, point, 1, own_models_.back().get()});
    }

    // ---- next to the boundary ------------------------------------------------------------------------

    static constexpr double rounding = 2e-4;           ///< of positions, in units of the tree
    static constexpr double least_free = 5 * rounding; ///< least distance of differences from faces

    /// Returns the distance of a point from the nearest face, at most `limit`.
    double free_distance(const Point& x, double limit) const {
        double least = limit;
        field_.boundary().for_each_within(x, limit, [&](std::uint32_t f) {
            const auto corners = field_.exact_corners(f);
            least = (std::min)(least, length(point_on_facet(nearest_on_facet(x, corners), corners) - x));
        });
        return least;
    }
    /// Finds the points of near faces at which models are corrected, or that the point lies on a face.
    void find_feet(Sampled& point) const {
        if (!(point.total > 0)) return;
        const double layer = 0.2 * point.size / point.total;
        const Point& x = point.at;
        // At smaller distances a point can lie outside the rounded faces.
        const double least = std::ldexp(4.0, -field_.boundary().fraction());
        double sum = 1;
        field_.boundary().for_each_within(x, layer, [&](std::uint32_t f) {
            const auto corners = field_.exact_corners(f);
            const Point normal = field_.outward_normal(f, x);
            const auto nearest = nearest_on_facet(x, corners);
            const auto foot = point_on_facet(nearest, corners);
            const double distance = length(foot - x), depth = dot(normal, corners[0] - x);
            if (!(distance < layer)) return;
            if (distance < (depth > 0 ? least : rounding)) {
                point.is_on_face = true;
                point.feet = {{foot, value_on_facet(field_.vertices(f), nearest), 1}};
            }
            const double cosine = (depth + rounding) / (distance + rounding);
            if (point.is_on_face || !(cosine > 0)) return;
            if (distance > 1e-3 * layer && field_.boundary().first_met(x, 0.99 * (foot - x))) return;
            const double t = distance / layer, fades = (1 - t * t) * (1 - t * t);
            const double amount = smooth_step(cosine / 0.3) * fades * fades / (std::max)(t * t, 1e-16);
            if (!(amount > 0)) return;
            const auto weights = field_.place_inside(f, x, corners, nearest, 0.15 * distance);
            const auto place = point_on_facet(weights, field_.corners(f));
            const double below = std::clamp(0.5 * depth, 1e-9, 1e-5);
            point.feet.push_back(
                {place - below * normal, value_on_facet(field_.vertices(f), weights), amount});
            sum += amount;
        });
        if (point.is_on_face) return;
        for (Foot& foot : point.feet) foot.share /= sum;
    }
    // ---- sums ------------------------------------------------------------------------------------------

    /// Computes the shares of a model in sums: its values at points minus its values at their feet.
    void add_model(std::span<const Term> terms) {
        places_.clear();
        factors_.clear();
        for (const Term& term : terms) {
            const Sampled& point = points_[term.point];
            if (point.is_on_face) continue;
            const double factor = point.factor * term.weight / point.total;
            places_.push_back(point.at);
            factors_.push_back(factor);
            for (const Foot& foot : point.feet) {
                places_.push_back(foot.at);
                factors_.push_back(-factor * foot.share);
            }
        }
        fit_.set(*terms.front().model, places_);
        std::size_t first = 0;
        for (auto term = terms.begin(); term != terms.end();) {
            const std::size_t sum = points_[term->point].sum;
            std::size_t places = 0;
            for (; term != terms.end() && points_[term->point].sum == sum; ++term) {
                const Sampled& point = points_[term->point];
                if (!point.is_on_face) places += 1 + point.feet.size();
            }
            if (places == 0) continue;
            Run run{terms.front().model, shares_.size(), vertices_.size()};
            fit_.add(std::span(places_).subspan(first, places), std::span(factors_).subspan(first, places),
                     first, shares_, vertices_);
            run.vertices_end = vertices_.size();
            const auto number = std::uint32_t(runs_.size());
            (sums_[sum].last == none ? sums_[sum].first : runs_[sums_[sum].last].next) = number;
            sums_[sum].last = number;
            runs_.push_back(run);
            first += places;
        }
    }
    /// Adds the runs of a sum to of_nodes_ and of_vertices_.
    void add_runs(const Sum& sum) {
        of_nodes_.clear();
        of_vertices_.clear();
        for (std::uint32_t n = sum.first; n != none; n = runs_[n].next) {
            const Run& run = runs_[n];
            const double* share = shares_.data() + run.shares;
            for (const auto& datum : run.model->data()) {
                if (datum.node != none) {
                    of_nodes_.add(datum.node, *share++);
                } else {
                    of_vertices_.add(datum.value, *share++);
                }
            }
            for (std::size_t v = run.vertices; v < run.vertices_end; ++v)
                of_vertices_.add(vertices_[v].handle, vertices_[v].share);
        }
    }

    const grid::CutTree<D>& tree_;
    const grid::TreeNodes<D>& nodes_;
    const Field& field_;
    Fit fit_;
    std::unordered_map<std::uint32_t, std::vector<std::unique_ptr<Model>>> models_; ///< by leaf
    std::vector<std::unique_ptr<Model>> own_models_;
    std::vector<Sampled> points_;
    std::vector<Term> terms_; ///< grouped by model
    std::vector<Point> places_;
    std::vector<double> factors_;
    std::vector<Sum> sums_;
    std::vector<Run> runs_;
    Buffer<double> shares_; ///< by run: the shares of the data on nodes and on the boundary
    Buffer<typename Table::Handle> vertices_;
    ShareSums<typename Table::Node> of_nodes_;
    ShareSums<typename Table::Handle> of_vertices_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
