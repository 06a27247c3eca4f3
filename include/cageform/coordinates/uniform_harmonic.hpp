// Harmonic coordinates solved on a uniform grid of a given resolution.
#pragma once

#include <cageform/coordinates/harmonic.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The choice of a uniform grid (harmonic/multigrid_solver.hpp), for HarmonicCoordinates.
struct UniformGrid {
    template <class C>
    static Status make(const std::shared_ptr<const CageProblem<C>>& problem, SolverReport& report,
                       std::shared_ptr<FunctionsOf<C>>& made, const Running& running) {
        if (problem->options.solver != HarmonicSolver::multigrid) return Status::solver_not_supported;
        return on_placed_cage(*problem, [&](auto cage) {
            return detail::make_uniform<typename C::scalar, C::dimension>(std::move(cage), report, made,
                                                                          running);
        });
    }
};

/// Harmonic coordinates on a uniform grid with HarmonicOptions::resolution cells along the cage's
/// longest side. HarmonicCoordinates, whose grid is adaptive, need less time for the same accuracy;
/// this type has errors that fall regularly with the resolution.
///
///   accuracy  of order h² away from the boundary and around corners with one cell of room (two if
///             that holds too few nodes for a fit; grid/corners/corner_functions.hpp); of order
///             h^(π/ω) next to an untreated corner of interior angle ω, or such an edge in 3D
///   smooth    not continuous: weights jump between cells, by about the error at most
///   cost      as HarmonicCoordinates; #V numbers more for a point next to treated corners
///   fails     as HarmonicCoordinates, but not accuracy_not_supported; tolerance_not_positive;
///             resolution_not_supported, if the resolution is not set or out of range
template <Scalar T, std::size_t D, class C = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
class UniformHarmonicCoordinates : public HarmonicCoordinates<T, D, C, UniformGrid> {
public:
    using HarmonicCoordinates<T, D, C, UniformGrid>::HarmonicCoordinates;
};

/// Deduces the type from the cage: `UniformHarmonicCoordinates coordinates(cage, {.resolution = 128})`.
template <Scalar T>
UniformHarmonicCoordinates(TriangleMesh<T>, const HarmonicOptions& = {}) -> UniformHarmonicCoordinates<T, 3>;
template <Scalar T>
UniformHarmonicCoordinates(PolyhedralMesh<T>, const HarmonicOptions& = {})
    -> UniformHarmonicCoordinates<T, 3, PolyhedralMesh<T>>;
template <Scalar T>
UniformHarmonicCoordinates(Polygon<T>, const HarmonicOptions& = {}) -> UniformHarmonicCoordinates<T, 2>;
template <Scalar T, std::size_t D>
UniformHarmonicCoordinates(CellComplex<T, D>, const HarmonicOptions& = {})
    -> UniformHarmonicCoordinates<T, D, CellComplex<T, D>>;
template <PointRangeIn<2> R>
UniformHarmonicCoordinates(const R&, const HarmonicOptions& = {})
    -> UniformHarmonicCoordinates<range_scalar_t<R>, 2>;
template <PointRangeIn<3> R, FaceRange F>
UniformHarmonicCoordinates(const R&, const F&, const HarmonicOptions& = {})
    -> UniformHarmonicCoordinates<range_scalar_t<R>, 3>;

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/harmonic/uniform.impl.hpp>
#endif
