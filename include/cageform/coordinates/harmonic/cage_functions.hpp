// The interface between harmonic coordinates and the solvers of their functions. It hides the solver,
// so that a file that only uses coordinates does not compile one.
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

/// The memory that a solver will need, in bytes.
struct SolverMemory {
    std::size_t hierarchy = 0; ///< once, for all functions
    std::size_t block = 0;     ///< for one group of functions, on each thread
};

/// A cell of a solver's grid, a square or a cube, in the units of the cage.
template <Scalar T, std::size_t D>
struct GridCell {
    Vec<T, D> low; ///< its lower corner
    T size;        ///< along each axis
    bool is_cut;   ///< the cage crosses it or comes very near; else the whole cell lies inside
};

namespace detail {

/// Makes the boundary data of harmonic functions on a cage; returns why there is none.
template <class C>
struct HarmonicData {
    static Status make(const C& /*cage*/, const HarmonicOptions& /*options*/,
                       BoundaryData<C::dimension>& /*data*/) noexcept {
        return Status::ok; // hat functions
    }
};

} // namespace detail

/// A cage with the options and the boundary data of its functions.
template <class C>
struct CageProblem {
    using Cage = C;
    using scalar = typename Cage::scalar;
    static constexpr std::size_t dimension = Cage::dimension;

    CageProblem(Cage its_cage, const HarmonicOptions& its_options)
        : cage(std::move(its_cage))
        , report(check(cage))
        , options(its_options)
        , tolerance(report.status == Status::ok ? coincidence_tolerance(bounds_of(cage.vertices()))
                                                : scalar(0)) {
        if (report.status == Status::ok) data_status = detail::HarmonicData<C>::make(cage, options, data);
    }

    /// An empty problem, refused with a status.
    explicit CageProblem(Status refused)
        : report{refused, {}} {}

    Cage cage;
    CageReport report; ///< status and warnings
    HarmonicOptions options;
    scalar tolerance = 0; ///< coincidence_tolerance of the cage
    detail::BoundaryData<dimension> data{};
    Status data_status = Status::ok; ///< of `data`
};

/// The input of a solver: a cage of any kind and scalar, as facets and cells in double.
template <std::size_t D>
struct PlacedCage {
    using scalar = double;
    static constexpr std::size_t dimension = D;

    CellComplex<double, D> cage;
    std::size_t handles = 0; ///< the first vertices of `cage`; after them it has the points of fans
    CageReport report;       ///< of the given cage; its status is ok
    HarmonicOptions options;
    double tolerance = 0; ///< points this near to the boundary lie on it
    double rounding = 0;  ///< of the given coordinates
    detail::BoundaryData<D> data{};
};

/// Return a cage in double, its faces as triangles.
template <Scalar T>
CellComplex<double, 2> placed(const Polygon<T>& polygon) {
    std::vector<std::size_t> sizes;
    for (const auto& loop : polygon.loops()) sizes.push_back(loop.size());
    return CellComplex<double, 2>(Polygon<double>(polygon.vertices(), sizes));
}
template <Scalar T>
CellComplex<double, 3> placed(const TriangleMesh<T>& mesh) {
    return CellComplex<double, 3>(TriangleMesh<double>(mesh.vertices(), mesh.faces()));
}
template <Scalar T>
CellComplex<double, 3> placed(const PolyhedralMesh<T>& mesh) {
    return placed(mesh.triangles());
}
template <Scalar T, std::size_t D>
CellComplex<double, D> placed(const CellComplex<T, D>& complex) {
    return {placed(complex.boundary()).boundary(), complex.vertices(), complex.cells()};
}

/// Makes the input of a solver and calls use(placed), with a shared pointer. Returns what that returns, or
/// out_of_memory.
template <class C, class Use>
Status on_placed_cage(const CageProblem<C>& problem, const Use& use) {
    using T = typename C::scalar;
    auto made = std::make_shared<const PlacedCage<C::dimension>>(PlacedCage<C::dimension>{
        placed(problem.cage), problem.cage.size(), problem.report, problem.options, double(problem.tolerance),
        double(epsilon<T>) * double(bounds_of(problem.cage.vertices()).magnitude()), problem.data});
    for (const Status status : {made->cage.boundary().status(), made->cage.status()}) {
        if (status != Status::ok) return status;
    }
    return use(std::move(made));
}

/// The functions of a cage's handles, behind which a solver stands. A solver is made once, and used
/// by several threads.
template <Scalar T, std::size_t D>
class CageFunctions {
public:
    virtual ~CageFunctions() = default;

    /// Returns the report of the making or, after `solve`, of the solve.
    virtual const SolverReport& report() const noexcept = 0;
    virtual SolverMemory memory() const noexcept = 0;
    /// Solves all functions and keeps them.
    virtual Status solve(SolverReport& report, const Running& running) = 0;
    /// Computes the weights of a batch of points and sets where they lie.
    virtual Status sample(const detail::Batch<T>& batch, SolverReport& report,
                          const Running& running) const = 0;
    /// Computes the gradients; row axis · #handles + handle.
    virtual Status sample_gradients(const detail::Batch<T>& batch, SolverReport& report,
                                    const Running& running) const = 0;
    /// Calls f(cell) for the cells of the grid; solver_not_supported if the solver does not show them.
    virtual Status for_each_cell(const std::function<void(const GridCell<T, D>&)>& f) const = 0;
    /// Packs the functions that `solve` has kept (solution_blob.hpp); solver_not_supported if the solver's
    /// are not packed.
    virtual Status save(std::vector<std::byte>& bytes) const = 0;
    /// Takes packed functions in place of a solve, without a copy: the bytes have to outlive this object.
    virtual Status load(std::span<const std::byte> bytes, SolverReport& report) = 0;
};

namespace detail {

/// Make the functions of a cage on an adaptive and on a uniform grid. They are defined in
/// adaptive.impl.hpp and uniform.impl.hpp.
template <class T, std::size_t D>
Status make_adaptive(std::shared_ptr<const PlacedCage<D>> cage, SolverReport& report,
                     std::shared_ptr<CageFunctions<T, D>>& made, const Running& running);
template <class T, std::size_t D>
Status make_uniform(std::shared_ptr<const PlacedCage<D>> cage, SolverReport& report,
                    std::shared_ptr<CageFunctions<T, D>>& made, const Running& running);

} // namespace detail

/// The functions of a cage, made by a solver.
template <class C>
using FunctionsOf = CageFunctions<typename C::scalar, C::dimension>;

} // namespace cageform::inline CAGEFORM_ABI
