// Vectors of points in blocks, one axis after the other.
#pragma once

#include <cageform/pose/detail/cholesky.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// D vectors of numbers in whole blocks, padded by zeros.
template <std::size_t D>
class AxisVectors {
public:
    /// Allocates zeros. May throw std::bad_alloc.
    void reset(std::size_t count) {
        blocks_ = block_count<double>(count);
        values_.resize(D * blocks_);
        clear();
    }
    void clear() noexcept {
        for (auto& block : values_) Simd<double>(0).store(block);
    }
    std::size_t blocks() const noexcept { return blocks_; }
    Lanes<double>* axis(std::size_t k) noexcept { return values_.data() + k * blocks_; }
    const Lanes<double>* axis(std::size_t k) const noexcept { return values_.data() + k * blocks_; }
    Lanes<double>* data() noexcept { return values_.data(); }
    const Lanes<double>* data() const noexcept { return values_.data(); }
    void copy(const AxisVectors& from) noexcept {
        for (std::size_t b = 0; b < values_.size(); ++b) values_[b] = from.values_[b];
    }
    Vec<double, D> get(std::size_t i) const noexcept {
        Vec<double, D> v{};
        for (std::size_t k = 0; k < D; ++k) v[k] = axis(k)[i / lane_count<double>][i % lane_count<double>];
        return v;
    }
    void set(std::size_t i, const Vec<double, D>& v) noexcept {
        for (std::size_t k = 0; k < D; ++k) axis(k)[i / lane_count<double>][i % lane_count<double>] = v[k];
    }
    /// Returns the dot products of all axes with a row.
    Vec<double, D> product(const Lanes<double>* row) const noexcept {
        Vec<double, D> sums{};
        for (std::size_t k = 0; k < D; ++k) {
            Simd<double> sum(0);
            for (std::size_t b = 0; b < blocks_; ++b)
                sum = multiply_add(Simd<double>::load(row[b]), Simd<double>::load(axis(k)[b]), sum);
            sums[k] = ordered_sum(sum);
        }
        return sums;
    }
    /// Adds a row times one factor per axis.
    void add(const Lanes<double>* row, const Vec<double, D>& factors) noexcept {
        with_axes([&](auto& axes) { subtract_row<D>(row, 0, blocks_, -1.0 * factors, axes); });
    }
    /// Calls f(axes) with an array of pointers to the axes.
    template <class F>
    void with_axes(const F& f) noexcept {
        Lanes<double>* axes[D];
        for (std::size_t k = 0; k < D; ++k) axes[k] = axis(k);
        Lanes<double>* const(&constant)[D] = axes;
        f(constant);
    }

private:
    std::size_t blocks_ = 0;
    std::vector<Lanes<double>> values_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
