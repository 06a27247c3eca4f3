// Harmonic functions of a cage on a lattice by the multigrid: solved in groups of sixteen, sampled at points.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/harmonic_options.hpp>
#include <cageform/grid/box_boundary.hpp>
#include <cageform/grid/corner_functions.hpp>
#include <cageform/grid/embed.hpp>
#include <cageform/grid/multigrid_groups.hpp>
#include <cageform/grid/simplex_boundary.hpp>

#include <memory>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class Cage>
class HarmonicOnGrid {
public:
    using T = typename Cage::scalar;
    static constexpr std::size_t D = Cage::dimension;
    static constexpr std::size_t most_resolution = D == 2 ? 16384 : 1024;

    HarmonicOnGrid(Cage cage, const HarmonicOptions& options)
        : cage_(std::move(cage))
        , options_(options)
        , report_(check(cage_))
        , tolerance_(report_.status == Status::ok ? coincidence_tolerance(bounds_of(cage_.vertices()))
                                                  : T(0)) {}

    const Cage& cage() const noexcept { return cage_; }
    const HarmonicOptions& options() const noexcept { return options_; }
    const CageReport& cage_report() const noexcept { return report_; }
    T tolerance() const noexcept { return tolerance_; } ///< coincidence_tolerance of the cage

    /// Solves all functions and keeps them.
    Status solve(const Running& options, SolverReport& report) {
        std::shared_ptr<Grid> grid;
        Status status = make_grid(grid, report);
        if (status != Status::ok) return status;
        grid->kept.resize(grid->groups);
        status = solve_groups(*grid, report, options, [&](std::size_t group, const Block& block) {
            auto& kept = grid->kept[group];
            kept.at_corners = block.at_corners;
            kept.values.reserve(grid->multigrid.unknowns());
            for (std::uint32_t n = 0; n < grid->multigrid.unknowns(); ++n)
                kept.values.push_back(block.value(n));
        });
        if (status != Status::ok) return status;
        kept_grid_ = grid;
        kept_report_ = report;
        return Status::ok;
    }

    Status evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                    const Running& options, SolverReport& report) const {
        return with_grid(
            report, [&](const Grid& grid) { return sample(grid, points, weights, states, options, report); });
    }

    /// Row axis · #handles + handle gets the derivative of the handle's function along the axis.
    Status gradients(BlockView<const T> points, BlockView<T> gradients, std::span<PointState> states,
                     const Running& options, SolverReport& report) const {
        return with_grid(report, [&](const Grid& grid) {
            return sample_gradients(grid, points, gradients, states, options, report);
        });
    }

    /// Bytes of the hierarchy and of one block; zero where the cage or the grid is refused.
    std::pair<std::size_t, std::size_t> memory() const {
        std::shared_ptr<const Grid> grid;
        SolverReport report;
        const Status status = guard_memory([&] { return make_grid(grid, report); });
        if (status != Status::ok) return {};
        return {grid->multigrid.bytes(), grid->multigrid.block_bytes()};
    }

private:
    using Boundary = typename GridBoundaryOf<Cage>::type;

    /// Sixteen functions: at the nodes, and what they have of each corner's.
    struct Functions {
        std::vector<typename Multigrid<D>::Values> values;
        CornerFunctions::Coefficients at_corners;

        const typename Multigrid<D>::Values& value(std::uint32_t node) const noexcept { return values[node]; }
    };

    /// The problem on the grid and its solver; after `solve` the functions too.
    struct Grid {
        Grid(const Cage& from, const Lattice<double, D>& with_lattice, const Crossings<D>& crossings,
             Boundary with, bool with_corners, double tolerance)
            : lattice(with_lattice)
            , boundary(std::move(with))
            , problem(embed(boundary, crossings))
            , corners(with_corners ? corners_of(from, lattice, problem) : CornerFunctions())
            , multigrid(problem.nodes, problem.cuts, corners.sources())
            , groups((from.size() + Multigrid<D>::width - 1) / Multigrid<D>::width) {
            boundary.index_cells(1e-6 + 2 * tolerance / lattice.spacing);
            const auto slots = multigrid.source_slots();
            for (const CutLink& cut : problem.cuts) cut_slots.push_back(slots[cut.node]);
            corners.set_slots(slots);
        }
        Lattice<double, D> lattice;
        Boundary boundary;
        EmbeddedProblem<D> problem;
        CornerFunctions corners;
        Multigrid<D> multigrid;
        std::vector<std::uint32_t> cut_slots; ///< of each cut link in Block::source
        std::size_t groups;                   ///< of sixteen functions
        std::vector<Functions> kept;          ///< by group
    };

    /// Of polygons alone.
    static CornerFunctions corners_of([[maybe_unused]] const Cage& cage,
                                      [[maybe_unused]] const Lattice<double, D>& lattice,
                                      [[maybe_unused]] const EmbeddedProblem<D>& problem) {
        if constexpr (D == 2) {
            return CornerFunctions(cage, lattice, problem);
        } else {
            return {};
        }
    }

    /// Centred on the cage's box, so that a symmetric cage has symmetric functions; sides of an axis-aligned cage
    /// whose extents divide evenly lie on lattice lines.
    Lattice<double, D> lattice_of(std::size_t resolution) const noexcept {
        const auto bounds = bounds_of(cage_.vertices());
        const auto lower = vec_cast<double>(bounds.lower), extent = vec_cast<double>(bounds.upper) - lower;
        double longest = 0;
        for (std::size_t k = 0; k < D; ++k) longest = std::fmax(longest, extent[k]);
        Lattice<double, D> lattice;
        lattice.spacing = longest / double(resolution);
        for (std::size_t k = 0; k < D; ++k) {
            const double links = std::ceil(extent[k] / lattice.spacing - on_boundary_distance);
            lattice.cells[k] = std::size_t(links) + 1;
            lattice.origin[k] = lower[k] + 0.5 * (extent[k] - links * lattice.spacing);
        }
        return lattice;
    }

    template <class GridPointer>
    Status make_grid(GridPointer& grid, SolverReport& report) const {
        constexpr std::size_t most = most_resolution;
        if (report_.status != Status::ok) return report_.status;
        if (options_.resolution < 8 || options_.resolution > most) return Status::resolution_not_supported;
        if (!(options_.multigrid.tolerance > 0)) return Status::tolerance_not_positive;
        const auto lattice = lattice_of(options_.resolution);
        const double rounding = double(epsilon<T>) * double(bounds_of(cage_.vertices()).magnitude());
        if (!(lattice.spacing > 4 * rounding) || lattice.spacing < 1e-290)
            return Status::resolution_not_supported;
        Boundary boundary(cage_, lattice);
        const auto crossings = boundary.crossings();
        const auto first_unseen = [&](const Boundary& of, const Crossings<D>& its) {
            auto seen = seen_handles<D>(its, cage_.size());
            if (const auto thin = of.too_thin_bone()) seen[*thin] = false;
            for (const CageFault& fault : report_.faults) { // warnings
                if (fault.kind == CageFaultKind::vertex_unused) seen[fault.a] = true;
            }
            return std::size_t(std::find(seen.begin(), seen.end(), false) - seen.begin());
        };
        if (const std::size_t unseen = first_unseen(boundary, crossings); unseen < cage_.size()) {
            report.unseen_handle = unseen;
            for (std::size_t finer = 2 * options_.resolution; finer <= most; finer *= 2) {
                const Boundary there(cage_, lattice_of(finer));
                if (first_unseen(there, there.crossings()) < cage_.size()) continue;
                report.sufficient_resolution = finer;
                break;
            }
            return Status::grid_too_coarse;
        }
        grid = std::make_shared<Grid>(cage_, lattice, crossings, std::move(boundary),
                                      options_.multigrid.corner_functions, double(tolerance_));
        report.cells = grid->multigrid.unknowns();
        report.bytes = grid->multigrid.bytes() + grid->multigrid.block_bytes();
        return Status::ok;
    }

    /// The memory of one group of functions.
    struct Block {
        typename Multigrid<D>::Block functions;
        CornerFunctions::Coefficients at_corners;

        typename Multigrid<D>::Values value(std::uint32_t node) const noexcept {
            return functions.value(node);
        }
    };
    /// The functions as solve_groups takes them.
    struct Groups {
        using Block = HarmonicOnGrid::Block;
        const HarmonicOnGrid& cage;
        const Grid& grid;

        std::size_t groups() const noexcept { return grid.groups; }
        Block make_block() const { return {grid.multigrid.make_block(), {}}; }
        Status solve(std::size_t group, Block& block, GroupWork& work) const {
            return cage.solve_group(grid, group, block, work);
        }
    };
    template <class Take>
    Status solve_groups(const Grid& grid, SolverReport& report, const Running& running,
                        const Take& take) const {
        return cageform::solve_groups(Groups{*this, grid}, report, take, running);
    }

    /// Functions 16·group ….
    Status solve_group(const Grid& grid, std::size_t group, Block& block, GroupWork& work) const {
        constexpr std::size_t width = Multigrid<D>::width;
        const std::size_t first = group * width, count = std::min(width, cage_.size() - first);
        auto& source = block.functions.source;
        for (auto& values : source) values.fill(0.0);
        for (std::size_t c = 0; c < grid.problem.cuts.size(); ++c) {
            const auto& value = grid.problem.values[c];
            for (std::size_t n = 0; n < BoundaryValue<D>::most; ++n) {
                if (value.handle[n] < first || value.handle[n] >= first + count) continue;
                source[grid.cut_slots[c]][value.handle[n] - first] +=
                    grid.problem.cuts[c].weight * value.weight[n];
            }
        }
        block.at_corners = grid.corners.start(first, source);
        const CycleGoal goal{count, options_.multigrid.tolerance, options_.multigrid.max_cycles};
        return run_cycles(grid.multigrid, block.functions, goal, work, [&] {
            // The corners' coefficients follow the solution and the solution them.
            const auto fitted = grid.corners.fit(first, block, block.at_corners);
            const double change = grid.corners.difference(fitted, block.at_corners);
            Multigrid<D>::disturb(block.functions, grid.corners.replace(block.at_corners, fitted, source));
            return change;
        });
    }

    /// use(grid) with the functions kept, or to be solved now.
    template <class Use>
    Status with_grid(SolverReport& report, const Use& use) const {
        if (kept_grid_) {
            report = kept_report_;
            return use(*kept_grid_);
        }
        std::shared_ptr<Grid> grid;
        const Status status = make_grid(grid, report);
        return status == Status::ok ? use(*grid) : status;
    }

    /// What the weights of some points are made of, one point's after the other's.
    struct Stencils {
        struct Corrected {
            std::size_t point;
            CornerFunctions::Correction correction;
        };
        std::vector<typename CutStencil<D>::Node> nodes;
        std::vector<typename CutStencil<D>::Place> places;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> ends; ///< of each point's nodes and places
        std::vector<Corrected> corrected;
        std::vector<T> added; ///< to the weights of those, #handles each, once all are known

        void add(const CutStencil<D>& stencil) {
            nodes.insert(nodes.end(), stencil.nodes.begin(), stencil.nodes.begin() + stencil.node_count);
            places.insert(places.end(), stencil.places.begin(), stencil.places.begin() + stencil.place_count);
            ends.push_back({std::uint32_t(nodes.size()), std::uint32_t(places.size())});
        }
    };
    static constexpr std::size_t points_together = 1024; ///< whose stencils are kept in one place
    static constexpr std::size_t pieces_together = 64;   ///< of those, between two questions to the progress

    /// The weights of points from a grid's functions, kept or solved now.
    Status sample(const Grid& grid, BlockView<const T> points, BlockView<T> weights,
                  std::span<PointState> states, const Running& options, SolverReport& report) const {
        const std::size_t lanes = points.blocks() * lane_count<T>; // every lane of the last block is written
        std::vector<Stencils> stencils((lanes + points_together - 1) / points_together);
        in_parallel(options, stencils.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                const std::size_t last = std::min(lanes, (n + 1) * points_together);
                for (std::size_t i = n * points_together; i < last; ++i)
                    add_point(grid, i, points, states, stencils[n]);
                stencils[n].added.resize(stencils[n].corrected.size() * cage_.size());
            }
        });
        const auto sample_piece = [&](std::size_t n, std::size_t group, const auto& solution,
                                      const CornerFunctions::Coefficients& at_corners) {
            sample_group(stencils[n], n * points_together, solution, at_corners, group * Multigrid<D>::width,
                         weights);
        };
        Status status = Status::ok;
        if (!grid.kept.empty()) {
            for (std::size_t begin = 0; begin < stencils.size(); begin += pieces_together) {
                const std::size_t count = std::min(pieces_together, stencils.size() - begin);
                in_parallel(options, count, 1, [&](std::size_t first, std::size_t last) {
                    for (std::size_t n = begin + first; n < begin + last; ++n) {
                        for (std::size_t group = 0; group < grid.groups; ++group)
                            sample_piece(n, group, grid.kept[group], grid.kept[group].at_corners);
                    }
                });
                if (options.progress && !options.progress(double(begin + count) / double(stencils.size())))
                    return Status::cancelled;
            }
        } else if (!stencils.empty()) {
            status = solve_groups(grid, report, options, [&](std::size_t group, const Block& block) {
                for (std::size_t n = 0; n < stencils.size(); ++n)
                    sample_piece(n, group, block, block.at_corners);
            });
        }
        if (status != Status::ok) return status;
        for (const Stencils& some : stencils) {
            for (std::size_t n = 0; n < some.corrected.size(); ++n)
                add_corner(std::span(some.added).subspan(n * cage_.size(), cage_.size()),
                           some.corrected[n].point, weights);
        }
        return Status::ok;
    }

    /// `locate`; but where no boundary passes a point's cell, the cell's nodes tell.
    PointState state_of(const Grid& grid, const Vec<T, D>& p) const noexcept {
        const auto cells_of_p = grid.lattice.in_cells(vec_cast<double>(p));
        typename NodeRuns<D>::Index low;
        for (std::size_t k = 0; k < D; ++k) {
            if (!(cells_of_p[k] >= 0 && cells_of_p[k] < double(grid.lattice.cells[k])))
                return locate(cage_, p, tolerance_);
            low[k] = std::int32_t(cells_of_p[k]);
        }
        if (grid.boundary.is_cut(low)) return locate(cage_, p, tolerance_);
        return grid.problem.nodes.find(low) != NodeRuns<D>::none ? PointState::inside : PointState::outside;
    }
    /// Where point `i` lies and its stencil; lanes beyond the points have empty ones.
    void add_point(const Grid& grid, std::size_t i, BlockView<const T> points, std::span<PointState> states,
                   Stencils& to) const {
        CutStencil<D> stencil;
        if (i < points.points && states[i] != PointState::not_finite) {
            const auto p = block_point<D>(points, i);
            states[i] = state_of(grid, p);
            if (states[i] == PointState::inside) {
                const auto cells_of_p = grid.lattice.in_cells(vec_cast<double>(p));
                stencil = grid.boundary.sample(cells_of_p, grid.problem.nodes);
                if constexpr (D == 2) {
                    const auto correction =
                        grid.corners.correction(cells_of_p, stencil, [&](std::uint32_t node) {
                            const auto index = grid.problem.nodes.index(node);
                            return Vec<double, 2>{double(index[0]), double(index[1])};
                        });
                    if (correction.corner != CornerFunctions::Correction::none)
                        to.corrected.push_back({i, correction});
                }
            }
            if (states[i] == PointState::on_boundary) {
                Vec<T, D> place;
                stencil.add(nearest_boundary_value(cage_, p, place), 1.0);
            }
        }
        to.add(stencil);
    }
    template <class Solution> // a block of the multigrid, or functions that were kept
    void sample_group(Stencils& stencils, std::size_t first_point, const Solution& solution,
                      const CornerFunctions::Coefficients& at_corners, std::size_t first,
                      BlockView<T> weights) const noexcept {
        constexpr std::size_t width = Multigrid<D>::width;
        const std::size_t count = std::min(width, cage_.size() - first);
        std::uint32_t node = 0, place = 0;
        for (std::size_t n = 0; n < stencils.ends.size(); ++n) {
            typename Multigrid<D>::Values value{};
            for (; node < stencils.ends[n].first; ++node) {
                const auto& at_node = solution.value(stencils.nodes[node].node);
                for (std::size_t k = 0; k < width; ++k) value[k] += stencils.nodes[node].share * at_node[k];
            }
            for (; place < stencils.ends[n].second; ++place) {
                const auto& at_place = stencils.places[place];
                for (std::size_t h = 0; h < BoundaryValue<D>::most; ++h) {
                    const std::size_t k = at_place.value.handle[h] - first;
                    if (k < count) value[k] += at_place.share * at_place.value.weight[h];
                }
            }
            // A mean of boundary data is in [0, 1]; the solver's error may not leave it.
            const std::size_t i = first_point + n;
            auto* const row = weights.block(i / lane_count<T>) + first;
            for (std::size_t k = 0; k < count; ++k)
                row[k][i % lane_count<T>] = static_cast<T>(std::clamp(value[k], 0.0, 1.0));
        }
        for (std::size_t n = 0; n < stencils.corrected.size(); ++n) {
            std::array<double, width> more{};
            CornerFunctions::apply(stencils.corrected[n].correction, at_corners, more);
            for (std::size_t k = 0; k < count; ++k)
                stencils.added[n * cage_.size() + first + k] = static_cast<T>(more[k]);
        }
    }
    /// Adds as much of a corner's part as keeps all weights of the point in [0, 1]: all of it, unless the grid is
    /// too coarse for the corner. The part sums to 0 and moves no point, so any share of it may be taken.
    void add_corner(std::span<const T> part, std::size_t i, BlockView<T> weights) const noexcept {
        auto* const row = weights.block(i / lane_count<T>);
        const std::size_t lane = i % lane_count<T>;
        const T allowed = static_cast<T>(options_.multigrid.tolerance); // what the clamp may take away
        T share = 1;
        for (std::size_t k = 0; k < part.size(); ++k) {
            const T w = row[k][lane], room = allowed + (part[k] < 0 ? w : T(1) - w);
            if (room < share * std::fabs(part[k])) share = room / std::fabs(part[k]);
        }
        for (std::size_t k = 0; k < part.size(); ++k)
            row[k][lane] = std::clamp(row[k][lane] + share * part[k], T(0), T(1));
    }

    /// Differences of values a cell apart, which have the same part of their cells' error, so that it drops out; up to
    /// the boundary only where that is nearer.
    Status sample_gradients(const Grid& grid, BlockView<const T> points, BlockView<T> gradients,
                            std::span<PointState> states, const Running& options,
                            SolverReport& report) const {
        struct Difference { // Σ factor · sample
            std::size_t point, axis;
            std::array<std::size_t, 3> sample;
            std::array<double, 3> factor;
        };
        std::vector<Difference> differences;
        std::vector<Vec<T, D>> at;
        for (std::size_t i = 0; i < points.points; ++i) {
            if (states[i] == PointState::not_finite) continue;
            auto p = block_point<D>(points, i);
            states[i] = state_of(grid, p);
            if (states[i] == PointState::on_boundary && !step_inside(grid, p))
                states[i] = PointState::unreached;
            if (states[i] == PointState::outside || states[i] == PointState::unreached) continue;
            const std::size_t middle = at.size();
            at.push_back(p);
            const auto cells_of_p = grid.lattice.in_cells(vec_cast<double>(p));
            for (std::size_t axis = 0; axis < D; ++axis) {
                std::array<double, 2> way{};
                for (const bool up : {false, true}) {
                    const double cells = grid.boundary.free_distance(cells_of_p, axis, up, 1.0);
                    auto q = p;
                    q[axis] = static_cast<T>(double(p[axis]) + (up ? cells : -cells) * grid.lattice.spacing);
                    way[up ? 1 : 0] = std::fabs(double(q[axis]) - double(p[axis])); // as rounded
                    at.push_back(q);
                }
                const auto [down, up] = way;
                if (!(down + up > 0)) { // no way along this axis
                    states[i] = PointState::unreached;
                    break;
                }
                Difference d{i, axis, {at.size() - 2, middle, at.size() - 1}, {}};
                if (down < 0.1 * up) {
                    d.factor = {0, -1 / up, 1 / up};
                } else if (up < 0.1 * down) {
                    d.factor = {-1 / down, 1 / down, 0};
                } else {
                    d.factor = {-up / (down * (down + up)), (up - down) / (down * up),
                                down / (up * (down + up))};
                }
                differences.push_back(d);
            }
        }
        std::vector<Lanes<T>> positions(block_count<T>(at.size()) * D);
        const BlockView<T> samples{positions.data(), D, at.size()};
        for (std::size_t i = 0; i < at.size(); ++i) {
            for (std::size_t k = 0; k < D; ++k) samples(i, k) = at[i][k];
        }
        std::vector<Lanes<T>> rows(block_count<T>(at.size()) * cage_.size());
        const BlockView<T> weights{rows.data(), cage_.size(), at.size()};
        std::vector<PointState> sample_states(at.size(), PointState::inside);
        const Status status = sample(grid, samples, weights, sample_states, options, report);
        if (status != Status::ok) return status;
        for (const Difference& d : differences) {
            for (std::size_t k = 0; k < cage_.size(); ++k) {
                double sum = 0;
                for (std::size_t n = 0; n < 3; ++n) {
                    if (d.factor[n] != 0) sum += d.factor[n] * double(weights(d.sample[n], k));
                }
                gradients(d.point, d.axis * cage_.size() + k) = static_cast<T>(sum);
            }
        }
        return Status::ok;
    }
    /// From the boundary half a cell inwards, along the diagonal with the most room; false where there is none.
    bool step_inside(const Grid& grid, Vec<T, D>& p) const noexcept {
        const double step = 0.5 * grid.lattice.spacing / std::sqrt(double(D));
        double most = 0;
        auto best = p;
        for (std::size_t direction = 0; direction < power(2, D); ++direction) {
            auto q = p;
            for (std::size_t k = 0; k < D; ++k)
                q[k] = static_cast<T>(double(p[k]) + (((direction >> k) & 1u) != 0 ? step : -step));
            if (state_of(grid, q) != PointState::inside) continue;
            const auto cells_of_q = grid.lattice.in_cells(vec_cast<double>(q));
            double least = 1;
            for (std::size_t k = 0; k < D; ++k) {
                for (const bool up : {false, true})
                    least = grid.boundary.free_distance(cells_of_q, k, up, least);
            }
            if (least <= most) continue;
            most = least;
            best = q;
        }
        p = best;
        return most > 0;
    }

    Cage cage_;
    HarmonicOptions options_;
    CageReport report_;
    T tolerance_;
    std::shared_ptr<const Grid> kept_grid_;
    SolverReport kept_report_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
