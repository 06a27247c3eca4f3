// Embeds a cage in a uniform lattice: inner nodes and their links to the boundary, location of points, and
// interpolation stencils.
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_solver.hpp>
#include <cageform/grid/lattice/embed.hpp>
#include <cageform/grid/lattice/simplex_boundary.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the lattice with `resolution` spacings along the longest side, centred on the cage's bounding box,
/// so that symmetric cages have symmetric functions. Sides of an axis-aligned cage lie on lattice lines if
/// its extents are multiples of the spacing.
template <std::size_t D>
Lattice<double, D> lattice_on(const Bounds<double, D>& bounds, std::size_t resolution) noexcept {
    const auto lower = bounds.lower, extent = bounds.upper - lower;
    double longest = 0;
    for (std::size_t k = 0; k < D; ++k) longest = std::fmax(longest, extent[k]);
    Lattice<double, D> lattice;
    lattice.spacing = longest / double(resolution);
    for (std::size_t k = 0; k < D; ++k) {
        const double links = std::ceil(extent[k] / lattice.spacing - grid::on_boundary_distance);
        lattice.cells[k] = std::size_t(links) + 1;
        lattice.origin[k] = lower[k] + 0.5 * (extent[k] - links * lattice.spacing);
    }
    return lattice;
}

/// A cage embedded in a uniform lattice. Refers to the cage.
template <std::size_t D>
class EmbeddedCage {
    using Boundary = grid::SimplexBoundary<D>;

public:
    /// Embeds the cage of `input` in a lattice of its options' `resolution`.
    ///
    ///   fails  resolution_not_supported; out_of_memory, with the memory needed and a sufficient
    ///          resolution in `report`; grid_too_coarse, with the handle and a sufficient resolution
    static Status make(const SolverInput<D>& input, SolverReport& report, std::optional<EmbeddedCage>& made) {
        const std::size_t resolution = input.options.resolution;
        if (resolution < least_resolution || resolution > most_resolution<D>)
            return Status::resolution_not_supported;
        const auto bounds = bounds_of(input.cage.vertices());
        const auto lattice = lattice_on(bounds, resolution);
        if (!(lattice.spacing > 4 * input.rounding) ||
            lattice.spacing < 1e-290) // its square must be a normal number
            return Status::resolution_not_supported;
        const GridMemory memory(input.cage, bounds);
        const std::size_t limit = input.options.memory_limit;
        if (memory.bytes(resolution) > double(limit)) return refuse_memory(memory, resolution, limit, report);
        Boundary boundary(input.cage, lattice);
        const auto crossings = boundary.crossings();
        report.unseen_handle = first_unseen(input, boundary, crossings);
        if (report.unseen_handle == SolverReport::none) {
            made.emplace(input, std::move(boundary), crossings);
            return Status::ok;
        }
        for (std::size_t finer = 2 * resolution;
             finer <= most_resolution<D> && memory.bytes(finer) <= double(limit); finer *= 2) {
            const Boundary there(input.cage, lattice_on(bounds, finer));
            if (first_unseen(input, there, there.crossings()) != SolverReport::none) continue;
            report.sufficient_resolution = finer;
            break;
        }
        return Status::grid_too_coarse;
    }

    EmbeddedCage(const SolverInput<D>& input, Boundary boundary, const grid::Crossings<D>& crossings)
        : cage_(&input.cage)
        , handles_(input.handles)
        , data_(&input.data)
        , tolerance_(input.tolerance)
        , boundary_(std::move(boundary))
        , problem_(grid::embed(boundary_, crossings))
        , at_cuts_(*data_, problem_.values) {
        boundary_.index_cells(1e-6 + 2 * tolerance_ / lattice().spacing);
    }

    EmbeddedCage(EmbeddedCage&&) noexcept = default;
    EmbeddedCage& operator=(EmbeddedCage&&) noexcept = default;
    EmbeddedCage(const EmbeddedCage&) = delete; // at_cuts_ refers to problem_.values
    EmbeddedCage& operator=(const EmbeddedCage&) = delete;
    ~EmbeddedCage() = default;

    const CellComplex<double, D>& cage() const noexcept { return *cage_; }
    std::size_t handles() const noexcept { return handles_; }
    const BoundaryData<D>& data() const noexcept { return *data_; }
    const Lattice<double, D>& lattice() const noexcept { return boundary_.lattice(); }
    /// Returns the number of cells along the longest side.
    std::size_t resolution() const noexcept {
        return *std::max_element(lattice().cells.begin(), lattice().cells.end()) - 1;
    }
    const grid::EmbeddedProblem<D>& problem() const noexcept { return problem_; }

    /// Adds the boundary values of functions [first, first + count) to `source`, at slots[node] of each node.
    template <class Values>
    void add_data(std::size_t first, std::size_t count, std::span<const std::uint32_t> slots,
                  std::span<Values> source) const noexcept {
        for (std::size_t c = 0; c < problem_.cuts.size(); ++c) {
            const auto& cut = problem_.cuts[c];
            at_cuts_.for_each_weight(c, [&](std::uint32_t handle, double weight) {
                if (handle < first || handle >= first + count) return;
                source[slots[cut.node]][handle - first] += cut.weight * weight;
            });
        }
    }

    /// Returns the state of a point as `locate` does, but from the contents of the point's cell where
    /// possible.
    PointState state_of(const Vec<double, D>& p) const noexcept { return located(p).state; }
    double free_distance(const Vec<double, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        return boundary_.free_distance(in_cells(p), axis, up, limit);
    }
    Vec<double, D> in_cells(const Vec<double, D>& p) const noexcept { return lattice().in_cells(p); }

    /// Returns the interpolation stencil of point `i` of a batch and sets its state. The stencil of outside
    /// points, and of indices beyond the batch, is empty.
    template <Scalar T>
    grid::CutStencil<D> stencil(const Batch<T>& batch, std::size_t i) const noexcept {
        grid::CutStencil<D> stencil;
        if (i >= batch.points.points || batch.states[i] == PointState::not_finite) return stencil;
        const auto p = vec_cast<double>(block_point<D>(batch.points, i));
        const auto [state, value] = located(p);
        batch.states[i] = state;
        if (state == PointState::inside) return boundary_.sample(in_cells(p), problem_.nodes);
        if (state == PointState::on_boundary) stencil.add(value, 1.0);
        return stencil;
    }

private:
    grid::Located<D> located(const Vec<double, D>& p) const noexcept {
        const auto at = in_cells(p);
        bool in_lattice = true;
        for (std::size_t k = 0; k < D; ++k)
            in_lattice = in_lattice && at[k] >= 0 && at[k] < double(lattice().cells[k]);
        if (in_lattice) {
            const double tolerance = tolerance_ / lattice().spacing;
            if (const auto found = boundary_.locate(at, tolerance, problem_.nodes)) return *found;
        }
        grid::Located<D> found{locate(*cage_, p, tolerance_), {}};
        Vec<double, D> position;
        if (found.state == PointState::on_boundary) found.value = nearest_boundary_value(*cage_, p, position);
        return found;
    }

    /// Estimates the memory of hierarchy and block at any resolution from the cage's volume and surface.
    class GridMemory {
    public:
        GridMemory(const CellComplex<double, D>& cage, const Bounds<double, D>& bounds)
            : vertices_(cage.size()) {
            const auto crossings = Boundary(cage, lattice_on(bounds, counted_at)).crossings();
            for (const auto& along : crossings) crossings_ += double(along.size());
            for_each_inner_interval<D>(
                crossings[0], [this](const auto& a, const auto& b) { volume_ += b.position - a.position; });
        }
        double bytes(std::size_t resolution) const noexcept {
            // Bytes per unknown, per crossing and per treated corner, measured (GCC 12, 64 bits).
            constexpr double of_unknown = 300, of_crossing = D == 2 ? 1500 : 800, of_corner = 130e3;
            const double finer = double(resolution) / double(counted_at);
            const double surface = D == 2 ? finer : finer * finer, unknowns = volume_ * surface * finer;
            const double corners = D == 2 ? (std::min)(of_corner * double(vertices_), 256 * unknowns) : 0;
            return of_unknown * unknowns + of_crossing * crossings_ * surface + corners;
        }

    private:
        static constexpr std::size_t counted_at = 64;
        std::size_t vertices_;
        /// At resolution `counted_at`.
        double volume_ = 0, crossings_ = 0;
    };
    static Status refuse_memory(const GridMemory& memory, std::size_t resolution, std::size_t limit,
                                SolverReport& report) noexcept {
        constexpr auto most = double((std::numeric_limits<std::ptrdiff_t>::max)());
        report.bytes = std::size_t((std::min)(memory.bytes(resolution), most));
        std::size_t fits = resolution;
        while (fits >= least_resolution && memory.bytes(fits) > double(limit)) fits -= 1 + fits / 64;
        report.sufficient_resolution = fits >= least_resolution ? fits : 0;
        return Status::out_of_memory;
    }

    /// Returns the first handle whose boundary values reach no node.
    static std::size_t first_unseen(const SolverInput<D>& input, const Boundary& boundary,
                                    const grid::Crossings<D>& crossings) {
        const auto handles = [&](const BoundaryValue<D>& value, const auto& f) {
            input.data.for_each_handle(value, f);
        };
        auto seen = grid::resolved_handles<D>(crossings, input.handles, handles);
        if (const auto thin = boundary.too_thin_bone()) seen[*thin] = false;
        for (const CageFault& fault : input.report.faults) { // warnings
            if (fault.kind == CageFaultKind::vertex_unused) seen[fault.a] = true;
        }
        const auto first = std::find(seen.begin(), seen.end(), false);
        return first == seen.end() ? SolverReport::none : std::size_t(first - seen.begin());
    }

    const CellComplex<double, D>* cage_;
    std::size_t handles_;
    const BoundaryData<D>* data_;
    double tolerance_;
    Boundary boundary_;
    grid::EmbeddedProblem<D> problem_;
    typename BoundaryData<D>::Table at_cuts_; ///< of problem_.values
};

} // namespace cageform::inline CAGEFORM_ABI::detail
