// The singular functions at a corner of a polygon.
//
// Near a corner of interior angle ω, with data linear along its two edges, a harmonic function is
//
//     g + α x + c w + Σ a_k s_k,   s_k = (r/R)^(kπ/ω) sin(kπθ/ω)
//
// (Wasow 1957; Grisvard, Elliptic Problems in Nonsmooth Domains, 1985, ch. 2 and 4). Here x is the coordinate
// along one edge. The function w is harmonic, with w = 0 on that edge and w = r on the other. The data gives
// g, α and c; only the coefficients a_k are unknown.
#pragma once

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The singular functions of one corner. Lengths are in units of the lattice.
class Corner {
public:
    static constexpr std::size_t most = 8; ///< maximum number of functions s_k
    /// From this exponent π/ω on, finite differences are accurate without singular functions.
    static constexpr double smooth_exponent = 2.25;

    /// The corner at `vertex`, whose inside extends counter-clockwise from the edge to `after` to the edge
    /// to `before`. If both are the same edge, the inside is all around it.
    ///
    ///   radius  R, the radius of the disc around the corner
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
        if (before == after) angle_ = 0; // regardless of rounding
        if (angle_ <= 0) angle_ += 2 * std::numbers::pi;
        sine_ = std::sin(angle_);
        exponent_ = std::numbers::pi / angle_;
        // The last s_k is the first whose exponent kπ/ω reaches R/6, or 1.5 if that is larger, or 4 if that
        // is smaller. A small disc has too few nodes to fit more coefficients. Finite differences are
        // accurate from exponent 4 on.
        count_ = (std::min)(most, std::size_t(std::ceil(std::clamp(radius / 6, 1.5, 4.0) / exponent_)));
    }

    std::size_t count() const noexcept { return count_; } ///< the number of s_k; function 0 is w
    /// Returns the m for which w is computed from s_m (`functions`): the exponent of s_m is the closest to 1.
    /// With fewer than m functions, the fit would depend on which edge is first.
    std::size_t least_count() const noexcept { return angle_ < 1.5 * std::numbers::pi ? 1 : 2; }
    void limit(std::size_t count) noexcept { count_ = (std::min)(count_, count); }
    /// Whether finite differences are accurate at this corner without singular functions.
    bool is_smooth() const noexcept { return exponent_ > smooth_exponent; }
    double radius() const noexcept { return radius_; }
    const Vec<double, 2>& vertex() const noexcept { return vertex_; }
    double distance(const Vec<double, 2>& p) const noexcept {
        return std::sqrt(dot(p - vertex_, p - vertex_));
    }
    /// The radius, enlarged for rounding.
    double reach() const noexcept { return (1 + 1e-9) * radius_; }
    bool reaches(const Vec<double, 2>& p) const noexcept { return distance(p) <= reach(); }
    /// Whether a point lies between the edges, or on one of them up to rounding.
    bool contains(const Vec<double, 2>& p) const noexcept {
        constexpr double rounding = 1e-9;
        const auto d = p - vertex_;
        double theta = std::atan2(dot(d, y_), dot(d, x_));
        if (theta < -rounding) theta += 2 * std::numbers::pi;
        return theta < angle_ + rounding;
    }
    /// Returns the coordinate x of a point, along the edge to `after`.
    double along(const Vec<double, 2>& p) const noexcept { return dot(p - vertex_, x_); }
    double exponent() const noexcept { return exponent_; } ///< π/ω
    double cosine() const noexcept { return std::cos(angle_); }
    double length_before() const noexcept { return length_before_; }
    double length_after() const noexcept { return length_after_; }

    /// Returns w, s_1, …, s_count at a point of the sector.
    std::array<double, most + 1> functions(const Vec<double, 2>& p) const noexcept {
        std::array<double, most + 1> f{};
        const auto d = p - vertex_;
        const double x = dot(d, x_), y = dot(d, y_), r = std::sqrt(dot(d, d)) / radius_;
        if (!(r > 0)) return f;
        double theta = std::atan2(y, x);
        // Rounding can give both edges a small negative angle.
        if (theta < 0 && theta < 0.5 * angle_ - std::numbers::pi) theta += 2 * std::numbers::pi;
        // The s_k are the imaginary parts of the powers of z = (r e^{iθ})^(π/ω).
        const double size = std::pow(r, exponent_);
        const double re = size * std::cos(exponent_ * theta), im = size * std::sin(exponent_ * theta);
        const std::size_t m = least_count();
        double power_re = re, power_im = im, closest = im;
        for (std::size_t k = 1; k <= (std::max)(count_, m); ++k) {
            if (k <= count_) f[k] = power_im;
            if (k == m) closest = power_im;
            const double next = power_re * re - power_im * im;
            power_im = power_re * im + power_im * re;
            power_re = next;
        }
        // w = (y − s_m)/sin ω, in a form that stays bounded if ω is a multiple of π.
        const double e = double(m) * exponent_;
        if (std::fabs(sine_) > 1e-5) {
            f[0] = (y - radius_ * closest) / sine_;
        } else {
            const double between = 0.5 * (1 + e);
            const double slope = std::pow(r, between) * (std::log(r) * std::sin(between * theta) +
                                                         theta * std::cos(between * theta));
            f[0] = radius_ * (m == 1 ? -1 : 1) * slope / angle_;
        }
        return f;
    }

private:
    Vec<double, 2> vertex_, x_{}, y_{}; ///< x along the edge to the next vertex, y towards the inside
    double radius_, length_before_ = 0, length_after_ = 0;
    double angle_ = 0, sine_ = 0, exponent_ = 1;
    std::size_t count_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::grid
