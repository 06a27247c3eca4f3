// How a bind went: which points are bound how, and the largest errors with the points they are at.
#pragma once

#include <cageform/cage/report.hpp>
#include <cageform/core/solver_report.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// What happens to points outside the cage.
enum class OutsidePoints : std::uint8_t {
    extend,           ///< the coordinate type's own extension; kept in place where it has none
    keep_in_place,    ///< no pose moves them
    nearest_boundary, ///< they follow the nearest point of the cage's boundary, at the same offset
};

/// Whether weights that miss Σw = 1 and Σwc = p (solvers leave a residual) are moved by the least
/// change, in the sense of least squares over the handles, that restores both. Affine poses are
/// then exact; a weight near zero may turn negative, by about BindReport::weight_change. No change
/// is made where it would not lower what is missed (BindReport::not_restored).
enum class LinearPrecision : std::uint8_t { restore, leave };

struct BindOptions {
    OutsidePoints outside = OutsidePoints::extend;
    LinearPrecision linear_precision = LinearPrecision::restore;
};

/// The largest (or least) value met, and at which point.
struct Extreme {
    static constexpr std::size_t none = ~std::size_t{0};

    double value = 0;
    std::size_t point = none; ///< none while there was no value

    void raise(const Extreme& other) noexcept {
        if (other.point != none && (point == none || other.value > value)) *this = other;
    }
    void lower(const Extreme& other) noexcept {
        if (other.point != none && (point == none || other.value < value)) *this = other;
    }
};

/// How a bind went. Lists hold indices of points in ascending order.
struct BindReport {
    Status status = Status::ok;
    CageReport cage;
    SolverReport solver;
    std::size_t points = 0; ///< given
    std::vector<std::size_t> on_boundary;
    std::vector<std::size_t> outside;    ///< treated as BindOptions::outside says
    std::vector<std::size_t> not_finite; ///< kept as they are in every pose
    std::vector<std::size_t> unreached;  ///< weights cannot be had or represented; kept in place
    std::vector<std::size_t>
        not_restored;           ///< LinearPrecision::restore has left more than rounding: the weights
                                ///< are so large (thin cages) that changes would not lower it
    Extreme partition_error;    ///< largest |Σw − 1| of the finished weights
    Extreme reproduction_error; ///< largest |Σwc − p| of the finished weights, in the units of the cage; p is
                                ///< the boundary point for OutsidePoints::nearest_boundary
    Extreme weight_change;      ///< largest change of a weight by a round of LinearPrecision::restore
    Extreme residual_restored; ///< largest |Σwc − p| before it
    Extreme least_weight;      ///< negative weights are no fault of closed forms
    Extreme amplification;     ///< largest Σ|w|: so far handles moved by 1 may move a point; 1 where no
                               ///< weight is negative
    double seconds = 0;        ///< wall-clock time, the solver's included
};

} // namespace cageform::inline CAGEFORM_ABI
