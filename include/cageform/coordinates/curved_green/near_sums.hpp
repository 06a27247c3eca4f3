// The integrals of an edge at near points, by the roots of e(s) = z.
#pragma once

#include <cageform/coordinates/curved_green/far_sums.hpp>

#include <algorithm>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The place on an edge where a point lies.
struct EdgeTouch {
    std::size_t edge = 0;
    ComplexNumber s{0, 0}; ///< the nearest root, in the direction of the edge
    double distance = (std::numeric_limits<double>::max)();
};

/// Computes the integrals of an edge at any point.
class NearSums {
public:
    /// `at_end`: whether the point lies on each end. The sums then leave out the logarithm of the distance.
    NearSums(const CurvedEdge& edge, const ComplexNumber& z, const std::array<bool, 2>& at_end) noexcept
        : edge_(edge)
        , reversed_(at_end[0] || at_end[1] ? !at_end[0] : norm(edge.end[1].at - z) < norm(edge.end[0].at - z))
        , seen_(edge.end[reversed_ ? 1 : 0].away) {
        const auto &here = edge.end[reversed_ ? 1 : 0], &there = edge.end[reversed_ ? 0 : 1];
        beyond_ = there.away;
        beyond_.c[0] = there.at - z;
        Polynomial p = seen_;
        if (at_end[0] || at_end[1]) {
            ends_[0] = here.vanishing;
            for (std::size_t r = 0; r < here.vanishing; ++r) p = p.divided_by_s();
            if (at_end[0] && at_end[1]) {
                ends_[1] = there.vanishing;
                for (std::size_t r = 0; r < there.vanishing && p.degree > 0; ++r)
                    p = p.divided_by_s_minus_one();
            }
        } else {
            seen_.c[0] = p.c[0] = here.at - z;
        }
        leading_ = p.c[p.degree];
        const PolynomialRoots found = roots_of(p);
        count_ = found.count;
        for (std::size_t k = 0; k < count_; ++k) root_[k] = separated(found, k);
    }

    /// Sets `touch` to the place nearest to the point if it is nearer than `touch`.
    void find_touch(std::size_t edge, EdgeTouch& touch) const noexcept {
        for (std::size_t k = 0; k < count_; ++k) {
            const double t = std::fmin(std::fmax(root_[k].s.re, 0.0), 1.0);
            const double distance = size(seen_.at({t, 0}));
            if (!(distance < touch.distance)) continue;
            touch = {edge, reversed_ ? -root_[k].beyond : root_[k].s, distance};
        }
    }
    bool all_far() const noexcept {
        return count_ > 0 && ends_[0] == 0 && std::all_of(root_.begin(), root_.begin() + count_, is_far);
    }
    /// Returns the sums of the moments over all roots.
    EdgeSums<double> sums() const noexcept {
        EdgeSums<double> all{};
        const std::size_t m = edge_.posed_degree;
        const auto add = [&](std::size_t k, const ComplexNumber& x) {
            all.turning += reversed_ ? -x.im : x.im;
            all.value[reversed_ ? m - k : k] += reversed_ ? -x : x;
        };
        for (std::size_t n = 0; n < count_; ++n) {
            EdgeMoments<double> j;
            moments_of(root_[n], {0, 0}, m, j);
            for (std::size_t k = 0; k <= m; ++k) add(k, j[k]);
        }
        double harmonic = 0; // H_m
        for (std::size_t k = 1; k <= m; ++k) harmonic += 1 / double(k);
        for (std::size_t k = 0; k <= m; ++k) {
            add(k, {double(ends_[0]) * (k == 0 ? -harmonic : 1 / double(k)), 0});
            add(k, {double(ends_[1]) * (k == m ? harmonic : -1 / double(m - k)), 0});
        }
        return all;
    }
    /// Returns ∫ b_k/(e − z) dt for the Bernstein polynomials b of degree m − 1: divided differences of the
    /// moments over all roots.
    EdgeSums<double> slope_sums() const noexcept {
        EdgeSums<double> all{};
        const std::size_t degree = edge_.posed_degree - 1;
        for (std::size_t n = 0; n < count_; ++n) {
            EdgeMoments<double> j;
            moments_of(root_[n], {0, 0}, 0, j);
            all.turning += reversed_ ? -j[0].im : j[0].im;
        }
        EdgeMoments<double> difference;
        if (count_ == 1) moments_of(root_[0], {0, 0}, degree, difference);
        if (count_ == 2) difference = divided_difference(root_[0], root_[1], degree);
        if (count_ == 3) {
            // a and b are the two roots nearest to each other; a is farther from the third.
            std::size_t lone = 0;
            double least = (std::numeric_limits<double>::max)();
            for (std::size_t k = 0; k < 3; ++k) {
                const double apart = norm(root_[(k + 1) % 3].s - root_[(k + 2) % 3].s);
                if (!(apart < least)) continue;
                least = apart;
                lone = k;
            }
            const CurveRoot<double>* a = &root_[(lone + 1) % 3];
            const CurveRoot<double>* b = &root_[(lone + 2) % 3];
            if (norm(a->s - root_[lone].s) < norm(b->s - root_[lone].s)) std::swap(a, b);
            difference = divided_difference(*a, *b, degree);
            const auto other = divided_difference(*b, root_[lone], degree);
            const ComplexNumber share = inverse(a->s - root_[lone].s);
            for (std::size_t k = 0; k <= degree; ++k) difference[k] = share * (difference[k] - other[k]);
        }
        const ComplexNumber share = inverse(leading_);
        for (std::size_t k = 0; k <= degree; ++k)
            all.value[reversed_ ? degree - k : k] = share * difference[k];
        return all;
    }

private:
    /// Returns a root and s − 1. Next to 1, s − 1 is computed from the other end of the edge.
    CurveRoot<double> separated(const PolynomialRoots& found, std::size_t k) const noexcept {
        const ComplexNumber s = found.s[k];
        ComplexNumber from_end = ComplexNumber{1, 0} - s;
        const double off = norm(from_end);
        if (!(off < 1.0 / 16) || ends_[1] > 0) return {s, -from_end};
        for (std::size_t l = 0; l < found.count; ++l) {
            if (l != k && norm(found.s[l] - s) < 16 * off) return {s, -from_end};
        }
        for (int step = 0; step < 2; ++step) {
            const ComplexNumber slope = beyond_.slope(from_end);
            if (norm(slope) > 0) from_end = from_end - beyond_.at(from_end) / slope;
        }
        return {ComplexNumber{1, 0} - from_end, -from_end};
    }
    static double distance_from_unit(const ComplexNumber& s) noexcept {
        return size(s - ComplexNumber{std::fmin(std::fmax(s.re, 0.0), 1.0), 0});
    }
    static EdgeMoments<double> divided_difference(const CurveRoot<double>& a, const CurveRoot<double>& b,
                                                  std::size_t degree) noexcept {
        EdgeMoments<double> difference{}, j;
        const ComplexNumber apart = b.s - a.s;
        if (size(apart) < 0.05 * (std::min)(distance_from_unit(a.s), distance_from_unit(b.s))) {
            const auto& rule = Gauss<5>::rule(); // integrates the derivative from a to b
            for (std::size_t g = 0; g < 5; ++g) {
                EdgeMoments<double> slope;
                const double u = rule.node[g];
                moments_of({a.s + u * apart, a.beyond + u * (b.beyond - a.beyond)}, {0, 0}, degree, j,
                           &slope);
                for (std::size_t k = 0; k <= degree; ++k) difference[k] += rule.weight[g] * slope[k];
            }
            return difference;
        }
        const ComplexNumber share = inverse(apart);
        moments_of(b, {0, 0}, degree, difference);
        moments_of(a, {0, 0}, degree, j);
        for (std::size_t k = 0; k <= degree; ++k) difference[k] = share * (difference[k] - j[k]);
        return difference;
    }

    const CurvedEdge& edge_;
    bool reversed_;
    Polynomial seen_, beyond_; ///< e(t) − z from the nearer end and from the other end
    ComplexNumber leading_{0, 0};
    std::array<std::size_t, 2> ends_{}; ///< number of roots at the nearer end and at the other end
    std::size_t count_ = 0;
    std::array<CurveRoot<double>, 3> root_{};
};

} // namespace cageform::inline CAGEFORM_ABI::detail
