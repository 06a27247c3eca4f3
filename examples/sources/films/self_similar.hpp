#pragma once

// Curves that consist of smaller copies of themselves, and zooms into these curves: the snowflake of H. von
// Koch (1904), the square-filling curves of G. Peano (1890) and W. Sierpiński (1912). The next level replaces
// each side by several shorter sides. While these grow out of the old side, the magnification increases by
// the ratio of the lengths.

#include "svg/path.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

class SelfSimilarCurve {
public:
    using Complex = std::complex<double>;
    enum class Kind { koch, peano, sierpinski };

    explicit SelfSimilarCurve(Kind kind)
        : kind_(kind) {}

    /// Side length of a level divided by that of the next level.
    double ratio() const { return kind_ == Kind::sierpinski ? 2 : 3; }
    /// The number of sides that replace one side.
    std::size_t parts() const { return generator(1).size() - 1; }
    double dimension() const { return std::log(double(parts())) / std::log(ratio()); }
    bool is_closed() const { return kind_ != Kind::peano; }

    /// The corners of a level, in order; closed curves repeat the first corner at the end. The next level
    /// contains all corners bit for bit.
    ///
    ///   grown   progress of the growth of the next level, in [0, 1]
    std::vector<Complex> corners(int level, double grown = 0) const {
        const double s = std::sqrt(0.75);
        std::vector<Complex> all{0, 1};
        if (kind_ == Kind::koch) all = {0, {s, 0.5}, {s, -0.5}, 0};
        if (kind_ == Kind::sierpinski) all = {0, 1, {1, 1}, {0, 1}, 0};
        for (int n = 0; n < level; ++n) all = divided(all, 1);
        return grown > 0 ? divided(all, grown) : all;
    }

    /// The curve as drawn, which does not touch itself. Peano's curve has its corners cut off. Sierpiński's
    /// curve connects the incentres of right isosceles triangles on its sides, which are the hypotenuses.
    std::vector<Complex> drawn(int level, double grown = 0) const {
        if (kind_ == Kind::koch) return corners(level, grown);
        const auto all = corners(level);
        if (kind_ == Kind::peano) {
            const double cut = 0.13 * std::pow(ratio(), -level - grown); // constant in the magnified view
            return cut_corners(grown > 0 ? divided(all, grown) : all, cut);
        }
        std::vector<Complex> middles;
        const auto middle = [](const Complex& a, const Complex& b) {
            return 0.5 * (a + b) + Complex(0, (std::numbers::sqrt2 - 1) / 2) * (b - a);
        };
        for (std::size_t k = 1; k < all.size(); ++k) {
            const Complex old = middle(all[k - 1], all[k]);
            if (grown <= 0) {
                middles.push_back(old);
                continue;
            }
            const auto sides =
                divided({all[k - 1], all[k]}, 1); // incentres move from the old side to the new ones
            for (std::size_t n = 1; n < sides.size(); ++n)
                middles.push_back((1 - grown) * old + grown * middle(sides[n - 1], sides[n]));
        }
        middles.push_back(middles.front());
        return middles;
    }

    /// The square that is visible at the beginning of a zoom. The zoom magnifies about 0. One level later the
    /// magnified view shows the same picture.
    struct Window {
        Complex low;
        double side;
    };
    Window window() const {
        if (kind_ == Kind::koch) return {{-0.14, -0.36}, 0.72};
        if (kind_ == Kind::peano) return {{-0.03, -0.24}, 0.48};
        return {{-0.05, -0.05}, 0.95};
    }

    /// A zoom's frame: the curve in units of the picture, from 0 to 1, y upwards.
    std::vector<Complex> frame(int level, double time) const {
        const Window seen = window();
        auto all = drawn(level, time);
        const double magnified = std::pow(ratio(), time);
        for (Complex& p : all) p = (magnified * p - seen.low) / seen.side;
        return all;
    }

private:
    /// The sides that replace the side from 0 to 1; `grown` as in corners().
    std::vector<Complex> generator(double grown) const {
        constexpr double third = 1.0 / 3;
        if (kind_ == Kind::koch) return {0, third, {0.5, grown * std::sqrt(3.0) / 6}, 2 * third, 1};
        if (kind_ == Kind::sierpinski) return {0, 0.5, {0.5, grown / 2}, 0.5, 1};
        const double up = grown * third;
        return {0,     third,        {third, up},      {2 * third, up}, 2 * third,
                third, {third, -up}, {2 * third, -up}, 2 * third,       1};
    }

    std::vector<Complex> divided(const std::vector<Complex>& all, double grown) const {
        const auto parts = generator(grown);
        std::vector<Complex> finer{all.front()};
        for (std::size_t k = 1; k < all.size(); ++k) {
            for (std::size_t n = 1; n + 1 < parts.size(); ++n)
                finer.push_back(all[k - 1] + parts[n] * (all[k] - all[k - 1]));
            finer.push_back(all[k]);
        }
        return finer;
    }

    /// Cuts off each corner at the distance `length`, but at most at half of its shorter side.
    static std::vector<Complex> cut_corners(const std::vector<Complex>& all, double length) {
        std::vector<Complex> cut{all.front()};
        for (std::size_t k = 1; k + 1 < all.size(); ++k) {
            const Complex before = all[k - 1] - all[k], after = all[k + 1] - all[k];
            const double from = std::abs(before), to = std::abs(after),
                         off = std::min({length, from / 2, to / 2});
            cut.push_back(all[k] + (from > 0 ? off / from : 0) * before);
            cut.push_back(all[k] + (to > 0 ? off / to : 0) * after);
        }
        cut.push_back(all.back());
        return cut;
    }

    Kind kind_;
};

inline double length_of(const std::vector<std::complex<double>>& line) {
    double length = 0;
    for (std::size_t k = 1; k < line.size(); ++k) length += std::abs(line[k] - line[k - 1]);
    return length;
}

/// The area inside a closed line of any orientation.
inline double area_of(const std::vector<std::complex<double>>& line) {
    double twice = 0;
    for (std::size_t k = 1; k < line.size(); ++k) twice += std::imag(std::conj(line[k - 1]) * line[k]);
    return std::fabs(twice) / 2;
}

} // namespace cageform_sources
