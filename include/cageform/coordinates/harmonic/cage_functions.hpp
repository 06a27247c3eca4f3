// The interface of harmonic coordinates to the solvers of their functions. It hides the solver, so that files
// that only use coordinates do not compile a solver.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/options.hpp>

#include <functional>
#include <memory>

namespace cageform::inline CAGEFORM_ABI {

/// The memory that a solver needs, in bytes.
struct SolverMemory {
    std::size_t hierarchy = 0; ///< shared by all functions
    std::size_t block = 0;     ///< per group of functions that is being solved
};

/// A cell of a solver's grid: a square or a cube, in the units of the cage.
template <Scalar T, std::size_t D>
struct GridCell {
    Vec<T, D> low; ///< lower corner
    T size;        ///< side length
    bool is_cut; ///< whether the cage's boundary crosses or nearly touches the cell; else the cell is inside
};

namespace detail {

/// Makes the boundary values of harmonic functions on a cage.
template <class C>
struct HarmonicData {
    static Status make(const C& /*cage*/, const HarmonicOptions& /*options*/,
                       BoundaryData<C::dimension>& /*data*/) noexcept {
        return Status::ok; // hat functions
    }
};

/// Returns a cage in double, with its faces as triangles.
template <Scalar T>
CellComplex<double, 2> in_double(const Polygon<T>& polygon) {
    std::vector<std::size_t> sizes;
    for (const auto& loop : polygon.loops()) sizes.push_back(loop.size());
    return CellComplex<double, 2>(Polygon<double>(polygon.vertices(), sizes));
}
template <Scalar T>
CellComplex<double, 3> in_double(const TriangleMesh<T>& mesh) {
    return CellComplex<double, 3>(TriangleMesh<double>(mesh.vertices(), mesh.faces()));
}
template <Scalar T>
CellComplex<double, 3> in_double(const PolyhedralMesh<T>& mesh) {
    return in_double(mesh.triangles());
}
template <Scalar T, std::size_t D>
CellComplex<double, D> in_double(const CellComplex<T, D>& complex) {
    return {in_double(complex.boundary()).boundary(), complex.vertices(), complex.cells()};
}

} // namespace detail

/// The input of a solver: any cage, as facets and cells in double.
template <std::size_t D>
struct SolverInput {
    /// Takes a cage that `check` accepts, its report, and its boundary values.
    template <class C>
    SolverInput(const C& given, const CageReport& its_report, const HarmonicOptions& its_options,
                const detail::BoundaryData<D>& its_data = {})
        : cage(detail::in_double(given))
        , handles(given.size())
        , report(its_report)
        , options(its_options)
        , data(its_data) {
        const auto bounds = bounds_of(given.vertices());
        tolerance = double(coincidence_tolerance(bounds));
        screening = options.locality / double(bounds.diagonal());
        screening *= screening;
        rounding = double(epsilon<typename C::scalar>) * double(bounds.magnitude());
    }
    Status status() const noexcept {
        if (!(options.locality >= 0 && options.locality <= HarmonicOptions::most_locality))
            return Status::locality_not_supported;
        return cage.boundary().status() != Status::ok ? cage.boundary().status() : cage.status();
    }

    CellComplex<double, D> cage;
    std::size_t handles; ///< the first vertices of `cage`; means of fans follow
    CageReport report;   ///< of the given cage
    HarmonicOptions options;
    double tolerance; ///< points within this distance of the boundary lie on it
    double rounding;  ///< rounding error of the given coordinates
    double screening; ///< κ² of the equation Δu = κ²u; 0: Laplace
    detail::BoundaryData<D> data;
};

/// The functions of a cage's handles. Made once, and used by several threads.
template <Scalar T, std::size_t D>
class CageFunctions {
public:
    virtual ~CageFunctions() = default;

    /// Returns the report of the construction or, after `solve`, of the solve.
    virtual const SolverReport& report() const noexcept = 0;
    virtual SolverMemory memory() const noexcept = 0;
    /// Solves all functions and keeps them.
    virtual Status solve(SolverReport& report, const Running& running) = 0;
    /// Computes the weights and states of a batch of points.
    virtual Status sample(const Batch<T>& batch, SolverReport& report, const Running& running) const = 0;
    /// Computes the gradients, in row axis · #handles + handle.
    virtual Status sample_gradients(const Batch<T>& batch, SolverReport& report,
                                    const Running& running) const = 0;
    /// Calls f(cell) for the cells of the grid. May return solver_not_supported.
    virtual Status for_each_cell(const std::function<void(const GridCell<T, D>&)>& f) const = 0;
    /// Packs the functions that `solve` kept (solution_blob.hpp). May return solver_not_supported.
    virtual Status save(std::vector<std::byte>& bytes) const = 0;
    /// Takes packed functions in place of a solve. They are not copied: `bytes` must outlive this object.
    virtual Status load(std::span<const std::byte> bytes, SolverReport& report) = 0;
};

/// Makes the functions of a cage: AdaptiveGrid, UniformGrid, or your own solver (harmonic/cage_solver.hpp).
/// `running` applies to making the grid.
template <Scalar T, std::size_t D>
using HarmonicSolver =
    std::function<Status(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                         std::shared_ptr<CageFunctions<T, D>>& made, const Running& running)>;

} // namespace cageform::inline CAGEFORM_ABI
