// One axis of a lattice: B-splines on clamped knots over [0, 1], or Bernstein polynomials for a single span.
#pragma once

#include <cageform/cage/types/report.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// One axis of a lattice.
struct LatticeAxis {
    std::size_t points = 4; ///< number of control points, at least 2
    /// Degree, clamped to points − 1: 1 … 3, or up to 63 if it is points − 1 (Bernstein polynomials).
    std::size_t degree = 3;
    /// points + degree + 1 ascending knots: degree + 1 zeros, inner knots of multiplicity at most `degree`,
    /// degree + 1 ones. Different knots are at least 1e-9 apart. Empty: uniform spans.
    std::vector<double> knots{};
};

namespace detail {

/// The functions N_i of an axis. Σ N_i = 1 and Σ g_i N_i(u) = u, where the Greville abscissa g_i is the mean
/// of the inner knots of N_i.
template <Scalar T>
class SplineAxis {
public:
    static constexpr std::size_t most_degree = 63;
    static constexpr double least_span = 1e-9;
    using Values = std::array<T, most_degree + 1>;

    SplineAxis() = default;
    explicit SplineAxis(const LatticeAxis& axis)
        : points_(axis.points)
        , degree_((std::min)(axis.degree, axis.points - 1))
        , knots_(knots_of(axis)) {
        for (std::size_t i = 0; i < points_; ++i) {
            double sum = 0;
            for (std::size_t k = 1; k <= degree_; ++k) sum += knots_[i + k];
            greville_.push_back(sum / double(degree_));
        }
        for (std::size_t span = degree_; span < points_; ++span) {
            for (std::size_t p = 1; p <= degree_; ++p) {
                for (std::size_t r = 0; r < p; ++r)
                    over_.push_back(static_cast<T>(1 / (knots_[span + 1 + r] - knots_[span + 1 - p + r])));
            }
        }
    }

    /// Returns the first fault of an axis. `number` becomes `a` of the fault.
    static std::optional<CageFault> fault_of(const LatticeAxis& axis, std::size_t number) {
        const std::size_t degree = axis.points == 0 ? 0 : (std::min)(axis.degree, axis.points - 1);
        const std::size_t most = axis.points == degree + 1 ? most_degree : 3;
        if (degree < 1 || degree > most) return CageFault{CageFaultKind::lattice_degree, number, degree};
        if (axis.knots.empty()) return std::nullopt;
        if (axis.knots.size() != axis.points + degree + 1)
            return CageFault{CageFaultKind::lattice_knots, number, axis.knots.size()};
        for (std::size_t n = 0; n < axis.knots.size(); ++n) {
            const double knot = axis.knots[n];
            const bool is_inner = n > degree && n < axis.points;
            const double end = n <= degree ? 0 : 1, step = n == 0 ? 0 : knot - axis.knots[n - 1];
            const bool is_sound =
                is_inner ? knot > 0 && knot < 1 && knot > axis.knots[n - degree] : knot == end;
            if (!is_sound || !(step == 0 || step >= least_span))
                return CageFault{CageFaultKind::lattice_knots, number, n};
        }
        return std::nullopt;
    }

    std::size_t points() const noexcept { return points_; }
    std::size_t degree() const noexcept { return degree_; }
    double greville(std::size_t i) const noexcept { return greville_[i]; }
    const std::vector<double>& knots() const noexcept { return knots_; }

    /// Evaluates the degree + 1 non-zero functions at u in [0, 1], and their slopes, by the recurrence of de
    /// Boor, J. Approx. Theory 6 (1972), without negative terms. A knot belongs to the span above it.
    ///
    ///   returns  the index of the first non-zero function
    std::size_t evaluate(T u, Values& value, Values& slope) const noexcept {
        const auto above = std::upper_bound(knots_.begin() + std::ptrdiff_t(degree_) + 1,
                                            knots_.begin() + std::ptrdiff_t(points_), double(u));
        const auto span = std::size_t(above - knots_.begin()) - 1;
        const T* over = over_.data() + (span - degree_) * (degree_ * (degree_ + 1) / 2);
        value[0] = 1;
        Values share{}; // functions of one degree less, divided by the length of their support
        for (std::size_t p = 1; p <= degree_; ++p) {
            T carried = 0;
            for (std::size_t r = 0; r < p; ++r) {
                const T left = static_cast<T>(double(u) - knots_[span + 1 - p + r]),
                        right = static_cast<T>(knots_[span + 1 + r] - double(u));
                share[r] = value[r] * *over++;
                value[r] = carried + right * share[r];
                carried = left * share[r];
            }
            value[p] = carried;
        }
        for (std::size_t r = 0; r <= degree_; ++r)
            slope[r] = T(degree_) * ((r > 0 ? share[r - 1] : T(0)) - (r < degree_ ? share[r] : T(0)));
        return span - degree_;
    }

    /// Evaluates all functions at a register of positions, extended linearly outside [0, 1].
    ///
    ///   value, slope   out, one row per control point
    ///   sloped         whether slopes are wanted or a position is outside; else `slope` may be unset
    void evaluate(const Lanes<T>& u, bool sloped, Lanes<T>* value, Lanes<T>* slope) const noexcept {
        if (points_ == degree_ + 1) return evaluate_bernstein(Simd<T>::load(u), sloped, value, slope);
        for (std::size_t i = 0; i < points_; ++i) {
            Simd<T>(T(0)).store(value[i]);
            if (sloped) Simd<T>(T(0)).store(slope[i]);
        }
        Values at, along;
        for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
            const T c = std::clamp(u[lane], T(0), T(1)), beyond = u[lane] - c;
            const std::size_t first = evaluate(c, at, along);
            for (std::size_t r = 0; r <= degree_; ++r) {
                value[first + r][lane] = at[r] + beyond * along[r];
                if (sloped) slope[first + r][lane] = along[r];
            }
        }
    }

private:
    void evaluate_bernstein(const Simd<T>& u, bool sloped, Lanes<T>* value, Lanes<T>* slope) const noexcept {
        using X = Simd<T>;
        const X c = (max)(X(T(0)), (min)(X(T(1)), u)), rest = X(T(1)) - c, beyond = u - c;
        std::array<X, most_degree + 1> at;
        at[0] = X(T(1));
        for (std::size_t p = 1; p <= degree_; ++p) {
            if (sloped && p == degree_) { // differences of functions of one degree less
                const X size{T(degree_)};
                for (std::size_t r = 0; r <= degree_; ++r) {
                    const X before = r > 0 ? at[r - 1] : X(T(0)), after = r < degree_ ? at[r] : X(T(0));
                    (size * (before - after)).store(slope[r]);
                }
            }
            X carried(T(0));
            for (std::size_t r = 0; r < p; ++r) {
                const X share = at[r];
                at[r] = carried + rest * share;
                carried = c * share;
            }
            at[p] = carried;
        }
        for (std::size_t r = 0; r <= degree_; ++r)
            (sloped ? at[r] + beyond * X::load(slope[r]) : at[r]).store(value[r]);
    }
    std::vector<double> knots_of(const LatticeAxis& axis) const {
        if (!axis.knots.empty()) return axis.knots;
        std::vector<double> knots(degree_ + 1, 0.0);
        const std::size_t spans = points_ - degree_;
        for (std::size_t n = 1; n < spans; ++n) knots.push_back(double(n) / double(spans));
        knots.insert(knots.end(), degree_ + 1, 1.0);
        return knots;
    }

    std::size_t points_ = 0, degree_ = 0;
    std::vector<double> knots_, greville_;
    std::vector<T> over_; ///< reciprocals of knot differences, by span, in the order of the recurrence
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
