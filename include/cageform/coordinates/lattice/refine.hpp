// Refinement of lattices along one axis, without a change of the deformation.
#pragma once

#include <cageform/coordinates/lattice/spline_axis.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/result.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// An axis with more control points, and the matrix that makes them: control point r is Σ_i row(r)[i] · point
/// i of the coarser axis, at rest and in every pose. Entries are not negative, and rows sum to 1.
struct RefinedAxis {
    LatticeAxis axis;
    std::size_t before = 0;     ///< number of control points of the coarser axis
    std::vector<double> matrix; ///< axis.points rows of `before` numbers

    std::span<const double> row(std::size_t r) const noexcept { return {matrix.data() + r * before, before}; }
};

namespace detail {

inline RefinedAxis unrefined(const LatticeAxis& axis) {
    const SplineAxis<double> spline(axis);
    RefinedAxis same{{spline.points(), spline.degree(), spline.knots()}, spline.points(), {}};
    same.matrix.resize(same.before * same.before);
    for (std::size_t i = 0; i < same.before; ++i) same.matrix[i * same.before + i] = 1;
    return same;
}
/// Adds one control point: point r becomes share(r) · point r + (1 − share(r)) · point r − 1.
template <class Share>
void mix(RefinedAxis& axis, const Share& share) {
    std::vector<double> mixed((axis.axis.points + 1) * axis.before);
    for (std::size_t r = 0; r <= axis.axis.points; ++r) {
        const double own = share(r);
        for (std::size_t i = 0; i < axis.before; ++i) {
            if (own > 0) mixed[r * axis.before + i] += own * axis.matrix[r * axis.before + i];
            if (own < 1) mixed[r * axis.before + i] += (1 - own) * axis.matrix[(r - 1) * axis.before + i];
        }
    }
    axis.matrix = std::move(mixed);
    ++axis.axis.points;
}
/// Inserts a knot (Boehm, Computer-Aided Design 12 (1980)).
inline void insert(RefinedAxis& refined, double knot) {
    auto& knots = refined.axis.knots;
    const std::size_t degree = refined.axis.degree;
    const auto above = std::upper_bound(knots.begin(), knots.end(), knot);
    const auto span = std::size_t(above - knots.begin()) - 1;
    mix(refined, [&](std::size_t i) {
        if (i + degree <= span) return 1.0;
        return i > span ? 0.0 : (knot - knots[i]) / (knots[i + degree] - knots[i]);
    });
    knots.insert(above, knot);
}
/// Refines a valid axis by change(refined), which returns a status.
template <class Change>
Result<RefinedAxis> refine(const LatticeAxis& axis, const Change& change) {
    if (const auto fault = SplineAxis<double>::fault_of(axis, 0)) return {{}, status_of(fault->kind)};
    RefinedAxis refined;
    const Status status = guard_memory([&] {
        refined = unrefined(axis);
        if (const Status changed = change(refined); changed != Status::ok) return changed;
        const auto fault = SplineAxis<double>::fault_of(refined.axis, 0);
        return fault ? status_of(fault->kind) : Status::ok;
    });
    if (status != Status::ok) return {{}, status};
    return {std::move(refined), Status::ok};
}

} // namespace detail

/// Inserts a knot in (0, 1), which adds one control point. O(points²).
///
///   status  lattice_degree_not_supported, lattice_knots_not_supported: of the axis, or if the knot is out of
///           range or has multiplicity `degree` already; splines of degree 4 and more have one span.
///           out_of_memory
inline Result<RefinedAxis> insert_knot(const LatticeAxis& axis, double knot) {
    return detail::refine(axis, [&](RefinedAxis& refined) {
        if (!(knot > 0 && knot < 1)) return Status::lattice_knots_not_supported;
        detail::insert(refined, knot);
        return Status::ok;
    });
}

/// Halves every span. Uniform knots stay uniform. O(points³).
///
///   status  as for `insert_knot`
inline Result<RefinedAxis> halve_spans(const LatticeAxis& axis) {
    return detail::refine(axis, [](RefinedAxis& refined) {
        const auto knots = refined.axis.knots;
        for (std::size_t n = 0; n + 1 < knots.size(); ++n) {
            if (knots[n] < knots[n + 1]) detail::insert(refined, 0.5 * (knots[n] + knots[n + 1]));
        }
        return Status::ok;
    });
}

/// Raises the degree of an axis with a single span by one (Bernstein polynomials). O(points²).
///
///   status  lattice_degree_not_supported: the axis has several spans, or has degree 63; out_of_memory
inline Result<RefinedAxis> raise_degree(const LatticeAxis& axis) {
    return detail::refine(axis, [](RefinedAxis& refined) {
        const std::size_t degree = refined.axis.degree;
        if (refined.axis.points != degree + 1 || degree == detail::SplineAxis<double>::most_degree)
            return Status::lattice_degree_not_supported;
        detail::mix(refined, [&](std::size_t i) { return 1 - double(i) / double(degree + 1); });
        refined.axis.degree = degree + 1;
        refined.axis.knots.insert(refined.axis.knots.begin(), 0.0);
        refined.axis.knots.push_back(1.0);
        return Status::ok;
    });
}

/// Refines control points along one axis, at rest or in a pose. Points after them (frame handles) are copied.
/// Throws std::bad_alloc.
///
///   counts  number of control points along each axis before the refinement
template <Scalar T, std::size_t D>
std::vector<Vec<T, D>> refined_points(std::span<const Vec<T, D>> points,
                                      const std::array<std::size_t, D>& counts, std::size_t axis,
                                      const RefinedAxis& refined) {
    CAGEFORM_ASSERT(counts[axis] == refined.before, "the axis that was refined");
    std::size_t inner = 1, outer = 1;
    for (std::size_t k = 0; k < D; ++k) (k < axis ? inner : outer) *= k == axis ? 1 : counts[k];
    CAGEFORM_ASSERT(points.size() >= inner * outer * refined.before,
                    "a point for every place of the lattice");
    std::vector<Vec<T, D>> finer;
    for (std::size_t o = 0; o < outer; ++o) {
        for (std::size_t r = 0; r < refined.axis.points; ++r) {
            for (std::size_t i = 0; i < inner; ++i) {
                Vec<double, D> sum{};
                for (std::size_t c = 0; c < refined.before; ++c)
                    sum = sum +
                          refined.row(r)[c] * vec_cast<double>(points[(o * refined.before + c) * inner + i]);
                finer.push_back(vec_cast<T>(sum));
            }
        }
    }
    for (std::size_t n = inner * outer * refined.before; n < points.size(); ++n) finer.push_back(points[n]);
    return finer;
}

} // namespace cageform::inline CAGEFORM_ABI
