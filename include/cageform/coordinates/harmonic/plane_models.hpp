// The 2D models of leaves, for the blend of leaf_models.hpp.
//
// The functions b of the fit are the real and imaginary parts of 1, z, …, z⁴, and the singular function of
// the nearest vertex. Kinks of the data at vertices need no correction F, because cells are small there. E
// sums over edges instead of faces.
#pragma once

#include <cageform/coordinates/harmonic/model_fit.hpp>
#include <cageform/coordinates/harmonic/wedge.hpp>

#include <numbers>
#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The 2D edges of a cage and of walls, in the units of a tree.
class PlaneField {
public:
    static constexpr std::size_t dimension = 2;
    using Point = Vec<double, 2>;

    explicit PlaneField(const grid::TreeBoundary<2>& boundary)
        : boundary_(boundary) {
        for (std::uint32_t f = 0; f < boundary.size(); ++f) {
            for (std::size_t k = 0; k < 2; ++k) {
                const std::uint32_t v = boundary[f].vertex[k];
                if (v >= stars_.size()) stars_.resize(v + 1);
                stars_[v].at = boundary[f].corner[k];
                stars_[v].ends.push_back(boundary[f].corner[1 - k]);
            }
        }
    }

    const grid::TreeBoundary<2>& boundary() const noexcept { return boundary_; }
    std::size_t bytes() const noexcept {
        return stars_.capacity() * sizeof(Star) + 2 * boundary_.size() * sizeof(Point);
    }
    const Point& at(std::uint32_t vertex) const noexcept { return stars_[vertex].at; }
    /// Always true, unlike in 3D: LeafData::places_of then tests visibility in every cut leaf.
    bool has_reflex_edge(const Point&, double) const noexcept { return true; }
    /// Returns the wedge between two edges of a vertex that contains p.
    Wedge wedge(std::uint32_t vertex, const Point& p) const noexcept {
        constexpr double turn = 2 * std::numbers::pi;
        const auto& star = stars_[vertex];
        const auto angle_of = [&](const Point& q) {
            return std::atan2(q[1] - star.at[1], q[0] - star.at[0]);
        };
        double before = turn, after = turn; // least angles from p to an edge on either side
        for (const Point& end : star.ends) {
            double angle = angle_of(p) - angle_of(end);
            if (angle < 0) angle += turn;
            before = (std::min)(before, angle);
            after = (std::min)(after, turn - angle);
        }
        const double first = angle_of(p) - before, x = std::cos(first), y = std::sin(first);
        return {{star.at[0], star.at[1], 0}, {0, 0, 1}, {x, y, 0}, {-y, x, 0}, 0, before + after};
    }
    /// Returns the polar coordinates of a point in a wedge.
    static Wedge::Place place_in(const Wedge& wedge, const Point& p) noexcept {
        return wedge.place({p[0], p[1], 0});
    }

    std::array<std::uint32_t, 2> vertices(std::uint32_t f) const noexcept { return boundary_[f].vertex; }
    const Corners<2>& corners(std::uint32_t f) const noexcept { return boundary_[f].corner; }
    const Corners<2>& exact_corners(std::uint32_t f) const noexcept { return boundary_.exact(f).corner; }
    /// Returns the outward unit normal of an edge; for a wall, which is inside the domain, the normal away
    /// from x.
    Point outward_normal(std::uint32_t f, const Point& x) const noexcept {
        const Point& normal = boundary_.normal(f);
        const bool turns = !boundary_.separates(f) && dot(normal, exact_corners(f)[0] - x) < 0;
        return turns ? -1.0 * normal : normal;
    }
    /// Returns the boundary point of `value`, not moved, unlike in 3D.
    Point moved_inside(const BoundaryValue<2>& value, const Point&) const noexcept {
        return value.weight[0] * at(value.handle[0]) + value.weight[1] * at(value.handle[1]);
    }
    /// Returns the weights of a point inside an edge, near x. See NearField::place_inside.
    std::array<double, 2> place_inside(std::uint32_t, const Point& x, const Corners<2>& corners,
                                       const std::array<double, 2>& nearest, double width) const noexcept {
        const auto along = corners[1] - corners[0];
        const double stiffness = dot(along, along) / (width * width);
        const double foot = dot(x - corners[0], along) / dot(along, along);
        const double pull = (std::min)(0.5, 1 / std::sqrt(stiffness));
        double s = (1 - pull) * nearest[1] + 0.5 * pull;
        for (int step = 0; step < 60; ++step) {
            const double slope = stiffness * (s - foot) - 1 / s + 1 / (1 - s);
            const double bend = stiffness + 1 / (s * s) + 1 / ((1 - s) * (1 - s));
            const double decrement = std::fabs(slope) / std::sqrt(bend);
            s -= (decrement > 0.25 ? 1 / (1 + decrement) : 1) * slope / bend;
            if (decrement < 1e-9) break;
        }
        return {1 - s, s};
    }

private:
    struct Star {
        Point at{};
        std::vector<Point> ends; ///< the other ends of its edges
    };
    const grid::TreeBoundary<2>& boundary_;
    std::vector<Star> stars_; ///< by vertex
};

/// A 2D model of the functions in and around a leaf.
class PlaneModel : public LeafData<PlaneField> {
public:
    static constexpr unsigned degree = 4;
    static constexpr std::size_t polynomials = 2 * degree + 1, most_functions = polynomials + 1;
    using Field = PlaneField;
    using Values = std::array<double, most_functions>;

    ///   place  the viewpoint: a point of the leaf inside the cage
    PlaneModel(const grid::CutTree<2>& tree, const Nodes& nodes, const PlaneField& field, const Cell& leaf,
               const Point& place)
        : LeafData(tree, nodes, field, leaf, place) {
        add_nodes(2); // all corners of neighbours
        if (leaf.size > 1) add_nodes_between();
        if (is_valid() && is_near_) find_vertices();
    }

    /// Returns the degree of polynomial `k` of the fit, or 0 for the singular function.
    static constexpr unsigned degree_of(std::size_t k) noexcept {
        return k < polynomials ? unsigned(k + 1) / 2 : 0;
    }
    /// Returns the ridge of a non-linear function, relative to the sum of the data's weights.
    static constexpr double ridge(std::size_t) noexcept { return 1e-8; }
    /// Returns the number of functions of the fit.
    std::size_t functions() const noexcept { return polynomials + (wedge_ ? 1 : 0); }
    /// Returns the values of these functions at a point. Values from `functions()` on are 0.
    Values values(const Point& p, bool /*is_screened*/) const noexcept {
        const Point z = (1 / size_) * (p - middle_);
        Values values{1};
        double re = 1, im = 0;
        for (std::size_t k = 1; k < polynomials; k += 2) {
            const double next = re * z[0] - im * z[1];
            im = re * z[1] + im * z[0];
            re = next;
            values[k] = re;
            values[k + 1] = im;
        }
        screen(z, std::span(values).template first<polynomials>(), degree_of);
        if (wedge_) {
            auto at = field_.place_in(*wedge_, p);
            at.r /= size_;
            values[polynomials] = wedge_->singular(at);
        }
        return values;
    }

private:
    /// Adds the nodes of neighbours of half the size, on the leaf's boundary and half a leaf size beyond.
    void add_nodes_between() {
        for (std::int32_t i = -1; i <= 3; ++i) {
            for (std::int32_t j = -1; j <= 3; ++j) {
                if (i % 2 != 0 || j % 2 != 0)
                    add_node({leaf_.low[0] + i * leaf_.size / 2, leaf_.low[1] + j * leaf_.size / 2}, false);
            }
        }
    }
    /// Finds the reflex vertices that can occlude points, and the nearest wedge that contains all data.
    void find_vertices() {
        const auto& boundary = field_.boundary();
        double nearest = 2.5 * size_;
        std::vector<std::uint32_t> known;
        boundary.for_each_within(middle_, nearest, [&](std::uint32_t f) {
            for (const std::uint32_t v : field_.vertices(f)) {
                const Point& at = field_.at(v);
                const double apart = length(at - middle_);
                if (apart >= 2.5 * size_ || std::find(known.begin(), known.end(), v) != known.end()) continue;
                known.push_back(v);
                const Wedge wedge = field_.wedge(v, place_);
                if (wedge.angle > std::numbers::pi && apart < 1.5 * size_) reflex_.push_back({at, at});
                const auto holds = [&](const Datum& datum) {
                    const auto place = field_.place_in(wedge, datum.at);
                    return place.r < 1e-3 * size_ || wedge.has(place);
                };
                if (apart < nearest && wedge.is_singular() &&
                    !boundary.first_met(place_, (1 - 1e-3) * (at - place_)) &&
                    std::all_of(data_.begin(), data_.end(), holds)) {
                    nearest = apart;
                    wedge_ = wedge;
                }
            }
        });
    }

    std::optional<Wedge> wedge_; ///< at the nearest vertex with a singular wedge
};

} // namespace cageform::inline CAGEFORM_ABI::detail
