// Gradients of many functions at many points, by stencils of derivatives.
#pragma once

#include <cageform/coordinates/entropy/project.hpp>
#include <cageform/coordinates/harmonic/cut_samples.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The stencils of values at some points, and of derivatives along the axes.
template <std::size_t D>
class GradientSamples {
public:
    explicit GradientSamples(std::size_t handles = 0)
        : handles_(handles) {}

    /// Adds the next stencil of point `i`: first that of the value, then D of derivatives.
    template <class HandleOf>
    void add(std::size_t i, std::span<const typename StencilTable<D>::Node> nodes,
             std::span<const typename StencilTable<D>::Handle> vertices, const HandleOf& handle_of) {
        if (stencils_.size() % per_point == 0) points_.push_back(i);
        stencils_.add(nodes, vertices, handle_of);
    }
    /// Allocates the values of all functions.
    ///
    ///   places  of the points in order, in units of the cage
    ///   states  of all points of the batch
    void reserve(std::vector<Vec<double, D>> places, std::span<PointState> states) {
        places_ = std::move(places);
        states_ = states;
        values_.resize(places_.size() * handles_);
    }
    /// See StencilTable.
    void scale_nodes(std::span<const float> factors) noexcept { stencils_.scale_nodes(factors); }

    /// Computes values and derivatives of handles [first_handle, first_handle + count); see
    /// CutSamples::sample. Derivatives are written to row axis · #handles + handle.
    template <class Functions, Scalar T, class RowOf>
    void sample(const Functions& functions, std::size_t first_handle, std::size_t count, BlockView<T> rows,
                const RowOf& row_of) noexcept {
        for (std::size_t n = 0; n < stencils_.size(); ++n) {
            const std::size_t i = points_[n / per_point], axis = n % per_point - 1;
            const auto value = values_at(stencils_, n, functions, first_handle, count);
            for (std::size_t k = 0; k < count; ++k) {
                const std::size_t handle = row_of(first_handle + k);
                if (n % per_point == 0) {
                    values_[n / per_point * handles_ + handle] = value[k];
                } else {
                    rows(i, axis * handles_ + handle) = static_cast<T>(value[k]);
                }
            }
        }
    }

    /// Replaces the derivatives by those of the values divided by their sum. The new derivatives sum to zero
    /// along each axis.
    template <Scalar T>
    void finish(BlockView<T> rows) const noexcept {
        for (std::size_t n = 0; n < points_.size(); ++n) {
            const std::span value(values_.data() + n * handles_, handles_);
            double sum = 0;
            for (const double v : value) sum += v;
            if (!(sum > 0)) continue; // no stencil
            for (std::size_t axis = 0; axis < D; ++axis) {
                double slope = 0;
                for (std::size_t h = 0; h < handles_; ++h)
                    slope += double(rows(points_[n], axis * handles_ + h));
                for (std::size_t h = 0; h < handles_; ++h) {
                    T& row = rows(points_[n], axis * handles_ + h);
                    row = static_cast<T>((double(row) - value[h] / sum * slope) / sum);
                }
            }
        }
    }

    /// Replaces the derivatives by those of the projected values (entropy/project.hpp). Sets the state of a
    /// point without a result to unreached.
    ///
    ///   handles  #handles
    template <Scalar T>
    void project(BlockView<T> rows, std::span<const Vec<double, D>> handles) const {
        using N = Dual<double, D>;
        std::vector<N> row(handles_);
        std::vector<double> prior(handles_), weights(handles_);
        const double scale = unit_scale(bounds_of(handles));
        for (std::size_t n = 0; n < points_.size(); ++n) {
            double largest = 0;
            for (std::size_t h = 0; h < handles_; ++h) {
                N& value = row[h] = N(0.0);
                if (!(values_[n * handles_ + h] > 0)) continue; // clamped
                value.value = values_[n * handles_ + h];
                largest = (std::max)(largest, value.value);
                for (std::size_t axis = 0; axis < D; ++axis)
                    value.gradient[axis] = double(rows(points_[n], axis * handles_ + h)) / scale;
            }
            if (!(largest > 0)) continue; // no stencil
            for (N& value : row) value = N(1 / largest) * value + N(least_prior);
            const auto u = [&](std::size_t h) { return scale * (handles[h] - places_[n]); };
            if (project_rows<N, D>(std::span(row), u, prior, weights, 0) == 0) {
                states_[points_[n]] = PointState::unreached;
                continue;
            }
            for (std::size_t h = 0; h < handles_; ++h) {
                for (std::size_t axis = 0; axis < D; ++axis)
                    rows(points_[n], axis * handles_ + h) = static_cast<T>(scale * row[h].gradient[axis]);
            }
        }
    }

private:
    static constexpr std::size_t per_point = D + 1; ///< stencils per point

    std::size_t handles_;
    std::vector<std::size_t> points_;
    std::vector<Vec<double, D>> places_; ///< parallel to points_
    std::span<PointState> states_;
    StencilTable<D> stencils_;
    std::vector<double> values_; ///< #handles per point
};

} // namespace cageform::inline CAGEFORM_ABI::detail
