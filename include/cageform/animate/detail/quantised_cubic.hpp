// A piecewise cubic with 16-bit coefficients. For run time.
#pragma once

#include <cageform/clip/curves/piecewise_cubic.hpp>

#include <array>
#include <cmath>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A curve with 16-bit Bernstein coefficients: integers between 0 at the minimum and 65535 at the
/// maximum of all coefficients. At most half the size of float pieces.
///
///   error   at most half a step, `error_bound()`: the coefficients' range / 131070
template <Scalar T>
class QuantisedCubic {
public:
    using scalar = T;

    QuantisedCubic() = default;
    explicit QuantisedCubic(const PiecewiseCubic<T>& curve)
        : end_(curve.empty() ? T(0) : curve.end())
        , end_value_(curve.empty() ? T(0) : curve.end_value()) {
        std::vector<double> coefficients;
        const auto pieces = curve.pieces();
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& p = pieces[i];
            const double h = double(i + 1 < pieces.size() ? pieces[i + 1].begin : end_) - double(p.begin);
            const double c1 = double(p.c1) * h, c2 = double(p.c2) * h * h, c3 = double(p.c3) * h * h * h;
            const double b0 = double(p.c0);
            for (const double b : {b0, b0 + c1 / 3, b0 + 2 * c1 / 3 + c2 / 3, b0 + c1 + c2 + c3})
                coefficients.push_back(b);
            pieces_.push_back({p.begin, {}});
        }
        if (coefficients.empty()) return;
        double low = coefficients[0], high = low;
        for (const double b : coefficients) {
            low = std::fmin(low, b);
            high = std::fmax(high, b);
        }
        low_ = static_cast<T>(low);
        step_ = static_cast<T>((high - low) / 65535);
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
            const double steps = high > low ? (coefficients[i] - low) / (high - low) * 65535 : 0;
            pieces_[i / 4].b[i % 4] = static_cast<std::uint16_t>(std::lround(steps));
        }
    }

    std::size_t size() const noexcept { return pieces_.size(); }
    T error_bound() const noexcept { return step_ / 2; } ///< excluding rounding in T
    std::size_t bytes() const noexcept { return pieces_.size() * sizeof(Piece) + 4 * sizeof(T); }
    /// Returns the coefficients of a piece; integer n means low + n · step.
    const std::array<std::uint16_t, 4>& coefficients(std::size_t piece) const noexcept {
        return pieces_[piece].b;
    }
    T low() const noexcept { return low_; }
    T step() const noexcept { return step_; }

    /// The value at a time; the curve must not be empty.
    T operator()(T x) const noexcept {
        if (x >= end_) return end_value_;
        const T inside = x < pieces_.front().begin ? pieces_.front().begin : x;
        const std::size_t first =
            last_up_to(inside, pieces_.size(), [&](std::size_t i) { return pieces_[i].begin; });
        const Piece& p = pieces_[first];
        const T until = first + 1 < pieces_.size() ? pieces_[first + 1].begin : end_;
        const T u = (inside - p.begin) / (until - p.begin), v = 1 - u;
        const T b0 = T(p.b[0]), b1 = T(p.b[1]), b2 = T(p.b[2]), b3 = T(p.b[3]);
        const T early = multiply_add(v, b0, product(3 * u, b1)),
                late = multiply_add(u, b3, product(3 * v, b2));
        return multiply_add(step_, multiply_add(v * v, early, product(u * u, late)), low_);
    }

private:
    struct Piece {
        T begin;
        std::array<std::uint16_t, 4> b;
    };
    std::vector<Piece> pieces_;
    T end_ = 0, end_value_ = 0, low_ = 0, step_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
