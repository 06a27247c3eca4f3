// A box around a figure, for a lattice.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/core/types/bounds.hpp>
#include <cageform/core/types/handles.hpp>
#include <cageform/core/view.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI {

/// Returns an axis-aligned box around points, for a lattice.
///
///   margin  added on all sides, relative to the diagonal. A side shorter than a thousandth of the diagonal
///           is widened by that much on both sides
///   status  figure_empty; figure_not_finite; figure_has_no_size if all points coincide
template <PointRange R>
auto box_around(const R& points, double margin = 0.02)
    -> Result<Transform<range_scalar_t<R>, range_dimension<R>>> {
    using T = range_scalar_t<R>;
    constexpr std::size_t D = range_dimension<R>;
    if (std::size(points) == 0) return {{}, Status::figure_empty};
    const auto first = vec_cast<double>(to_vec<T>(points[0]));
    Bounds<double, D> bounds{first, first};
    for (std::size_t i = 0; i < std::size(points); ++i) {
        const auto p = vec_cast<double>(to_vec<T>(points[i]));
        if (!is_finite(p)) return {{}, Status::figure_not_finite};
        bounds.include({p, p});
    }
    if (!is_finite(margin)) return {{}, Status::value_not_finite};
    const auto extent = bounds.upper - bounds.lower;
    double diagonal = 0;
    for (const double x : extent.v) diagonal = std::hypot(diagonal, x);
    if (!(diagonal > 0)) return {{}, Status::figure_has_no_size};
    Transform<T, D> box{};
    for (std::size_t k = 0; k < D; ++k) {
        const double wider = margin * diagonal + (extent[k] < 1e-3 * diagonal ? 1e-3 * diagonal : 0.0);
        box.translation[k] = static_cast<T>(bounds.lower[k] - wider);
        box.columns[k][k] = static_cast<T>(extent[k] + 2 * wider);
        if (!is_finite(box.translation) || !is_finite(box.columns[k])) return {{}, Status::figure_not_finite};
    }
    return {box, Status::ok};
}

} // namespace cageform::inline CAGEFORM_ABI
