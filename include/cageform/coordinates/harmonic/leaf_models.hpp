// Samples harmonic functions in 3D by a C² blend of local harmonic models. leaf_samples.hpp blends;
// plane_models.hpp has the 2D models.
//
// The function of handle i at a point x inside the cage is
//
//     u_i(x) = Σ_m w_m(x) M_m,i(x) / Σ_m w_m(x) + E_i(x)
//
// over the models m of the leaves near x. An uncut leaf has one model, a cut leaf up to four. The weight w_m
// is a C² function of x. It is 0 farther from the leaf than a fifth of its size, and nearly 0 if a face lies
// between x and the viewpoint of the model. A model is a fit to data around its leaf, corrected for kinks as
// in near_rows.hpp, with one L_i per model:
//
//     M_i(x) = Σ_d S_d(x) y_i(d) + F(L_i),   F(L) = L(x) − Σ_d S_d(x) L(d),
//     S(x) = b(x)ᵀ (BᵀWB + R)⁻¹ BᵀW.
//
// The data d are nodes around the leaf and boundary points with function values y_i(d). The vector b has 16
// harmonic polynomials up to degree 3, and two functions for each of up to four bent edges. Row d of B is
// b(d). The diagonal matrix W holds the weights of the data. They decrease with the distance from the middle
// of the leaf and are tripled at boundary points. The diagonal matrix R is a ridge, nearly zero for linear
// functions, so that constants and positions are reproduced. E_i corrects the errors of the models at the
// nearest faces and is 0 farther from faces than a fifth of a leaf:
//
//     E_i(x) = Σ_f a_f (φ_i(q_f) − Σ_m w_m(x) M_m,i(q_f) / Σ_m w_m(x)) / (1 + Σ_f a_f).
//
// a_f grows as 1/distance² as x tends to face f. The point q_f of face f, near x, is a smooth function of x.
// So u_i(x) tends to the boundary values φ_i at faces.
#pragma once

#include <cageform/coordinates/harmonic/model_fit.hpp>
#include <cageform/coordinates/harmonic/near_patch.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A model of the functions in and around a leaf.
class LeafModel : public LeafData<NearField> {
public:
    static constexpr unsigned degree = 3;
    static constexpr std::size_t polynomials = 16, most_wedges = 4,
                                 most_functions = polynomials + 2 * most_wedges;
    using Field = NearField;
    using Values = std::array<double, most_functions>;

    ///   place  the viewpoint: a point of the leaf inside the cage
    LeafModel(const grid::CutTree<3>& tree, const Nodes& nodes, const NearField& field, const Cell& leaf,
              const Point& place)
        : LeafData(tree, nodes, field, leaf, place) {
        add_nodes(1); // across faces
        if (is_valid() && is_near_) find_edges();
    }

    /// Returns the degree of polynomial `k` of the fit, or 0 if function `k` is not a polynomial.
    static constexpr unsigned degree_of(std::size_t k) noexcept {
        return k >= polynomials || k == 0 ? 0 : k < 4 ? 1 : k < 9 ? 2 : 3;
    }
    /// Returns the ridge of a non-linear function, relative to the sum of the data's weights.
    static constexpr double ridge(std::size_t k) noexcept { return degree_of(k) == degree ? 1e-4 : 1e-6; }
    /// Returns the number of functions of the fit.
    std::size_t functions() const noexcept { return polynomials + 2 * wedges_.size(); }
    /// Returns the values of these functions at a point. Values from `functions()` on are 0.
    ///
    ///   is_screened  whether polynomials are turned into solutions of the screened equation
    Values values(const Point& p, bool is_screened) const noexcept {
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
        if (is_screened) screen(q, std::span(values).template first<polynomials>(), degree_of);
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
    bool choose_vertices(NearPatch& patch) const {
        return patch.set_viewpoint(place_, (is_near_ ? radius_near : radius_inside) * size_);
    }

private:
    static constexpr double radius_near = 3.5, radius_inside = 2; ///< of the near field, in leaf sizes

    /// Finds the reflex edges that can occlude points, and the nearest wedges that contain all data.
    void find_edges() {
        std::vector<std::pair<double, Wedge>> found;
        field_.for_each_near_bent_edge(middle_, 2.5 * size_, [&](std::uint32_t e, double apart) {
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

    std::vector<Wedge> wedges_;
};

/// Fits models, corrects them by double layers, and evaluates them.
class LeafFit : ModelFit<LeafModel> {
    using Point = NearField::Point;

public:
    using Handle = StencilTable<3>::Handle;

    /// See ModelFit.
    LeafFit(const NearField& field, unsigned degree)
        : ModelFit(field, degree)
        , patch_(field) {}

    /// See ModelFit.
    void set(const LeafModel& model, std::span<const Point> points) {
        has_layers_ = model.choose_vertices(patch_);
        // The layers are harmonic: their share in the data needs harmonic polynomials.
        ModelFit::set(model, points, !has_layers_);
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
    /// See ModelFit.
    void add(std::span<const Point> points, std::span<const double> factors, std::size_t first,
             Buffer<double>& shares, Buffer<Handle>& vertices) {
        ModelFit::add(points, factors, first, shares, vertices);
        if (!has_layers_) return;
        const auto data = model().data();
        amount_.assign(patch_.vertices().size(), 0.0);
        for (std::size_t v = 0; v < amount_.size(); ++v) {
            for (std::size_t n = 0; n < points.size(); ++n)
                amount_[v] += factors[n] * patch_.layer(v, data.size() + first + n);
            amount_[v] = 2 * (amount_[v] - patch_.sum(v, row()));
        }
        patch_.finish(amount_, -1, {}); // no threshold, which would make the functions discontinuous
        if (!std::all_of(amount_.begin(), amount_.end(), [](double x) { return is_finite(x); })) return;
        for (std::size_t v = 0; v < amount_.size(); ++v)
            vertices.push_back({patch_.vertices()[v], amount_[v]});
    }

private:
    NearPatch patch_;
    bool has_layers_ = false;   ///< whether double layers correct the model
    std::vector<Point> places_; ///< of data, then points
    std::vector<double> amount_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
