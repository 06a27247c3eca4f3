// Options and reports of binding.
#pragma once

#include <cageform/cage/types/report.hpp>
#include <cageform/grid/types/solver_report.hpp>

namespace cageform::inline CAGEFORM_ABI {

// X(name, NAME, "description"). In C the enumerators are CAGEFORM_NAME. Append new ones at the end.
// clang-format off
#define CAGEFORM_OUTSIDE_POINTS(X)                                                                           \
    X(extend, EXTEND, "by the extension of the coordinate type; without one, no pose moves the points")      \
    X(keep_in_place, KEEP_IN_PLACE, "no pose moves the points")                                              \
    X(nearest_boundary, NEAREST_BOUNDARY,                                                                    \
      "points follow the nearest point of the cage's boundary, at the same offset")
// clang-format on

/// How points outside the cage are bound.
enum class OutsidePoints : std::uint8_t {
#define CAGEFORM_DETAIL_OUTSIDE(name, ...) name,
    CAGEFORM_OUTSIDE_POINTS(CAGEFORM_DETAIL_OUTSIDE)
#undef CAGEFORM_DETAIL_OUTSIDE
};

/// Whether to correct weights that violate Σw = 1 or Σwc = p (solvers leave a residual), by the
/// smallest change in the least-squares sense. Affine poses are then exact. Where this change would make
/// a non-negative row negative, `project` (coordinates/project.hpp) finds weights that are not negative.
/// They do not exist if the handles with positive weights do not surround the point; the smallest change is
/// then made. A change that would not lower the residual is not made (BindReport::not_restored).
enum class LinearPrecision : std::uint8_t { restore, leave };

struct BindOptions {
    OutsidePoints outside = OutsidePoints::extend;
    LinearPrecision linear_precision = LinearPrecision::restore;
    /// The distance from the cage at which displacements of points outside reach zero, in the units of
    /// the cage; 0: no falloff. The weights of a point outside, at distance d, are multiplied by
    ///
    ///     f = (1 − x)² (1 + 2x),   x = d / falloff
    ///
    /// and are exactly 0 for x ≥ 1. Rest stays exact; affine poses are not exact outside. The falloff
    /// preserves continuity at the boundary up to C¹. The slope of f is up to 1.5 / falloff: the figure may
    /// fold if points move by more than two thirds of the falloff. With nearest_boundary, the motion is
    /// discontinuous where two parts of the cage are equally near and nearer than the falloff.
    ///
    /// Fails with falloff_not_supported if it is negative or not finite, or if points outside have no
    /// weights: with keep_in_place, and with extend if the coordinates have no extension.
    double falloff = 0;
};

/// The largest (or least) value, and its point.
struct Extreme {
    static constexpr std::size_t none = ~std::size_t{0};

    double value = 0;
    std::size_t point = none; ///< none before the first value

    void raise(const Extreme& other) noexcept {
        if (other.point != none && (point == none || other.value > value)) *this = other;
    }
    void lower(const Extreme& other) noexcept {
        if (other.point != none && (point == none || other.value < value)) *this = other;
    }
};

/// The result of a bind. Lists contain point indices in ascending order.
struct BindReport {
    Status status = Status::ok;
    CageReport cage;
    SolverReport solver;
    std::size_t points = 0; ///< number of points
    std::vector<std::size_t> on_boundary;
    std::vector<std::size_t> outside; ///< treated according to BindOptions::outside
    /// The points outside within BindOptions::falloff; the other points outside do not move.
    std::vector<std::size_t> faded;
    std::vector<std::size_t> not_finite; ///< not moved by any pose
    std::vector<std::size_t> unreached;  ///< without weights, or with overflow; kept in place
    /// Points with residuals above rounding errors after LinearPrecision::restore: the weights are so large
    /// (thin cages) that changes would not lower the residual.
    std::vector<std::size_t> not_restored;
    /// Largest |Σw − 1| of the final weights, before a falloff.
    Extreme partition_error;
    /// Largest |Σwc − p| of the same weights, in the units of the cage; with
    /// OutsidePoints::nearest_boundary, p is the boundary point.
    Extreme reproduction_error;
    Extreme weight_change;     ///< largest change of a weight in a round of LinearPrecision::restore
    Extreme residual_restored; ///< largest |Σwc − p| before restoring
    Extreme least_weight;      ///< negative for some closed forms
    /// Largest Σ|w| of a point: an upper bound of its displacement if no handle moves by more than 1.
    /// It is 1 if no weight is negative.
    Extreme amplification;
    double seconds = 0; ///< wall-clock time, including the solver's
};

} // namespace cageform::inline CAGEFORM_ABI
