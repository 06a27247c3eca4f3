// Fits a pose of a lattice to given displacements of a figure.
#pragma once

#include <cageform/binding/detail/lattice_fitter.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Finds the pose of a lattice whose displacements x of the handles minimise
///
///     (1/Σμ) Σ_j μ_j |Σ_i w_ji x_i − d_j|²  +  λ E(x)
///
/// where E is the mean square of the second differences of x along the axes of the lattice, divided by
/// the Greville abscissae. E is zero exactly for affine displacements; so λ does not affect these.
///
///   binding        the figure, bound to the lattice. Points that are not finite, and points without
///                  weights, are ignored; the report counts the latter
///   displacements  d, one per point
///   returns        the pose of all handles, for `clone`, with frozen and frame handles at rest, and a report
///   cost           O(#points · #handles) to read weights, O(Σ non-zeros²) to add them, then a Cholesky
///                  decomposition: dense to 1,000 free handles, sparse beyond. All in double
///   fails          as the lattice; coordinates_empty (it has no handles); targets_do_not_match (the
///                  numbers of handles, displacements or weights differ); value_not_finite (also a negative
///                  smoothness); weights_not_positive (one is negative, or none is positive);
///                  index_out_of_range (a frozen handle); fit_not_determined (too few points for λ, or none);
///                  out_of_memory
template <Scalar T, std::size_t D, PointRangeIn<D> R>
Result<std::vector<Vec<T, D>>, LatticeFitReport>
fit_lattice(const LatticeCoordinates<T, D>& lattice, const BindingView<T, D>& binding, const R& displacements,
            const LatticeFitOptions& options = {}) {
    Result<std::vector<Vec<T, D>>, LatticeFitReport> result;
    const Status status = detail::guard_memory([&] {
        std::vector<Vec<double, D>> targets;
        targets.reserve(std::size(displacements));
        for (std::size_t j = 0; j < std::size(displacements); ++j)
            targets.push_back(to_vec<double>(displacements[j]));
        return detail::LatticeFitter<T, D>(lattice, binding, targets, options)
            .run(result.report, result.value);
    });
    result.report.status = status;
    if (status != Status::ok) result.value.clear();
    return result;
}
template <Scalar T, std::size_t D, PointRangeIn<D> R>
Result<std::vector<Vec<T, D>>, LatticeFitReport>
fit_lattice(const LatticeCoordinates<T, D>& lattice, const Binding<T, D>& binding, const R& displacements,
            const LatticeFitOptions& options = {}) {
    return fit_lattice(lattice, binding.view(), displacements, options);
}

} // namespace cageform::inline CAGEFORM_ABI
