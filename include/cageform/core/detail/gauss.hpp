// Gauss-Legendre quadrature.
#pragma once

#include <cageform/config.hpp>

#include <array>
#include <cmath>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// N nodes in (0, 1) and their weights, with sum 1. Exact for polynomials up to degree 2N − 1.
template <std::size_t N>
struct Gauss {
    std::array<double, N> node{}, weight{};

    Gauss() noexcept {
        for (std::size_t i = 0; i < N; ++i) {
            // Newton's method on the Legendre polynomial, starting from Tricomi's estimate.
            double x = std::cos(3.141592653589793 * (double(i) + 0.75) / (double(N) + 0.5)), slope = 0;
            for (int step = 0; step < 8; ++step) {
                double p = 1, before = 0;
                for (std::size_t k = 1; k <= N; ++k) {
                    const double next = ((2 * double(k) - 1) * x * p - (double(k) - 1) * before) / double(k);
                    before = p;
                    p = next;
                }
                slope = double(N) * (x * p - before) / (x * x - 1);
                x -= p / slope;
            }
            node[N - 1 - i] = 0.5 * (1 + x);
            weight[N - 1 - i] = 1 / ((1 - x * x) * slope * slope);
        }
    }
    static const Gauss& rule() {
        static const Gauss table;
        return table;
    }
    /// ∫ f over [begin, end].
    template <class F>
    double operator()(double begin, double end, const F& f) const {
        double sum = 0;
        for (std::size_t i = 0; i < N; ++i) sum += weight[i] * f(begin + (end - begin) * node[i]);
        return (end - begin) * sum;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
