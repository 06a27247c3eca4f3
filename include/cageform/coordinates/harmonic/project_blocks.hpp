// Projects sampled functions to weights that reproduce their points.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/entropy/project.hpp>
#include <cageform/core/types/bounds.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Projects the rows of inside points (entropy/project.hpp): the weights of local harmonic coordinates.
template <Scalar T, std::size_t D>
class BlockProjection {
public:
    explicit BlockProjection(std::span<const Vec<double, D>> handles)
        : scale_(double(unit_scale(bounds_of(handles))))
        , origin_(handles[0])
        , handles_(seen_from_origin<T>(handles))
        , exact_handles_(seen_from_origin<double>(handles)) {}

    /// Replaces the rows of the batch. An inside point without a positive value becomes unreached.
    Status run(const Batch<T>& batch, const Running& running) const {
        return for_each_block(batch.points.blocks(), running, [&](std::size_t begin, std::size_t end) {
            std::vector<Simd<T>> prior(handles_.size()), weights(handles_.size());
            std::vector<double> one_prior(handles_.size()), one_row(handles_.size());
            for (std::size_t b = begin; b < end; ++b) {
                const Lanes<T> is_left = project(batch, b, prior, weights);
                for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
                    if (is_left[lane] != 0) project_one(batch, b * lane_count<T> + lane, one_prior, one_row);
                }
            }
        });
    }

private:
    template <class S>
    Buffer<Vec<S, D>> seen_from_origin(std::span<const Vec<double, D>> handles) const {
        Buffer<Vec<S, D>> seen;
        seen.reserve(handles.size());
        for (const auto& handle : handles) seen.push_back(vec_cast<S>(scale_ * (handle - origin_)));
        return seen;
    }

    /// Projects a block. Returns 1 in lanes that did not converge, else 0.
    Lanes<T> project(const Batch<T>& batch, std::size_t b, std::span<Simd<T>> prior,
                     std::span<Simd<T>> weights) const {
        using X = Simd<T>;
        const X zero(T(0)), one(T(1));
        Lanes<T> outside, left;
        Lanes<T> position[D];
        for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
            const std::size_t i = b * lane_count<T> + lane;
            outside[lane] = T(i >= batch.points.points || batch.states[i] != PointState::inside ? 1 : 0);
            const auto p = vec_cast<double>(block_point<D>(batch.points, i));
            for (std::size_t c = 0; c < D; ++c) position[c][lane] = T(scale_ * (p[c] - origin_[c]));
        }
        Vec<X, D> p;
        for (std::size_t c = 0; c < D; ++c) p[c] = X::load(position[c]);
        Lanes<T>* const row = batch.rows.block(b);
        X largest = zero;
        for (std::size_t h = 0; h < prior.size(); ++h) {
            prior[h] = X::load(row[h]);
            largest = (max)(largest, prior[h]);
        }
        const X skipped = select(zero < largest, X::load(outside), one);
        const X inverse = one / select(skipped < one, largest, one);
        for (X& q : prior) q = q * inverse;
        const auto u = [&](std::size_t h) {
            Vec<X, D> to;
            for (std::size_t c = 0; c < D; ++c) to[c] = X(handles_[h][c]) - p[c];
            return to;
        };
        const X converged = project_rows<X, D>(prior, u, {}, weights, skipped);
        const auto is_done = both(zero < converged, skipped < one);
        for (std::size_t h = 0; h < prior.size(); ++h)
            select(is_done, weights[h], X::load(row[h])).store(row[h]);
        (one - select(is_done, one, X::load(outside))).store(left);
        return left;
    }

    /// Projects the row of a point that the handles with weight do not surround, as next to the boundary.
    void project_one(const Batch<T>& batch, std::size_t i, std::span<double> prior,
                     std::span<double> weights) const {
        double largest = 0;
        for (std::size_t h = 0; h < prior.size(); ++h)
            largest = (std::max)(largest, prior[h] = double(batch.rows(i, h)));
        if (!(largest > 0)) {
            batch.states[i] = PointState::unreached;
            return;
        }
        for (double& q : prior) q = q / largest + least_prior;
        const auto p = scale_ * (vec_cast<double>(block_point<D>(batch.points, i)) - origin_);
        const auto u = [&](std::size_t h) { return exact_handles_[h] - p; };
        if (project_rows<double, D>(prior, u, {}, weights, 0.0) == 0) {
            batch.states[i] = PointState::unreached;
            return;
        }
        for (std::size_t h = 0; h < prior.size(); ++h) batch.rows(i, h) = static_cast<T>(weights[h]);
    }

    double scale_;
    Vec<double, D> origin_;
    Buffer<Vec<T, D>> handles_; ///< relative to the first, in units of about the cage's size
    Buffer<Vec<double, D>> exact_handles_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
