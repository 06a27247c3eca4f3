// Diffuses the values of strokes: harmonic fields with values given along lines drawn on a canvas. There is
// no flux through the boundary of the canvas.
//
// Strokes are not rasterised but keep their exact position: as for cages, data enters the equations where
// strokes cross lattice lines. A stroke may have different values on its right and left (diffusion curves:
// Orzan et al., ACM Trans. Graph. 27(3) (2008), sec. 3). In 3D the strokes are walls of triangles.
#pragma once

#include <cageform/fields/detail/canvas_boundary.hpp>
#include <cageform/fields/detail/field_solver.hpp>
#include <cageform/grid/lattice/embed.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// A polyline with values, linear between its points. It is closed if the last point equals the first. Left
/// and right are for y pointing up; with y down, as on a screen, they are swapped.
template <Scalar T>
struct Stroke {
    std::vector<Vec<T, 2>> points;
    std::vector<T> left;  ///< value of point i, channel c at [i · channels + c]
    std::vector<T> right; ///< likewise; empty: equal to `left`
    /// Half the width of the stroke: points within it have the value of the line's nearest point. 0: a line.
    /// A single point needs a radius, because a harmonic function ignores the value at a point.
    T radius = 0;
};

/// Triangles in 3D with values at their corners, linear on each.
template <Scalar T>
struct Wall {
    std::vector<Vec<T, 3>> points;
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<T> front; ///< values as in Stroke::left; the side that normals point to
    std::vector<T> back;  ///< likewise; empty: equal to `front`
};

struct DiffusionOptions {
    double tolerance = 1e-6;     ///< error of the discrete solution, relative to a channel's range
    std::size_t max_cycles = 60; ///< if more are needed: not_converged
};

/// The fields of a drawing.
///
///     Diffusion<double> field(canvas, 512, 3);                // three channels
///     field.add({.points = outline, .left = fur, .right = sky});
///     if (field.solve().status != Status::ok) …
///     field.sample(pixels, colours);
///
/// Each value is a weighted mean of given values, so it lies between the smallest and the largest value of
/// its channel. The error is of order h² for the spacing h. At the ends of strokes it is of order h, because
/// the field grows there like the square root of the distance. If two strokes pass between neighbouring
/// nodes, each node uses the nearer one.
template <Scalar T, std::size_t D = 2>
class Diffusion {
    static_assert(D == 2 || D == 3, "strokes in 2D, walls in 3D");

public:
    static constexpr std::size_t dimension = D;
    static constexpr std::size_t least_resolution = 2, most_resolution = D == 2 ? 16384 : 1024;

    /// canvas      the drawing area; an incomplete last row of cells is completed
    /// resolution  cells along its longest side, least_resolution … most_resolution
    /// channels    number of fields solved together, at least 1; sixteen cost as much as one
    Diffusion(const Bounds<T, D>& canvas, std::size_t resolution, std::size_t channels)
        : canvas_(canvas)
        , resolution_(resolution)
        , channels_(channels) {}

    /// Adds a stroke, or nothing on failure. O(#points).
    ///
    ///   fails  too_few_vertices (no point, or all points coincide); radius_not_positive (a single point
    ///          without a radius, or a radius that is negative or not finite); vertex_not_finite;
    ///          interior_cell_outside (a point off the canvas); value_not_finite; input_malformed (not
    ///          #channels values per point, or two sides with a radius); out_of_memory
    Status add(const Stroke<T>& stroke)
        requires(D == 2)
    {
        return detail::guard_memory([&] {
            const auto count = std::uint32_t(stroke.points.size());
            const Status status = check_points(stroke.points, stroke.left, stroke.right);
            if (status != Status::ok) return status;
            if (!(stroke.radius >= 0) || !is_finite(stroke.radius)) return Status::radius_not_positive;
            if (stroke.radius > 0 && !stroke.right.empty()) return Status::input_malformed;
            if (count == 1 && stroke.radius == 0) return Status::radius_not_positive;
            InteriorCells<D> cells;
            for (std::uint32_t i = 0; i + 1 < count; ++i) {
                if (stroke.points[i] == stroke.points[i + 1]) continue;
                if (stroke.radius > 0) cells.bones.push_back({i, i + 1, double(stroke.radius)});
                if (stroke.radius == 0) cells.facets.push_back({i, i + 1});
            }
            if (stroke.radius > 0 && cells.bones.empty())
                cells.bones.push_back({0, 0, double(stroke.radius)});
            if (cells.empty()) return Status::too_few_vertices;
            append(stroke.points, cells, stroke.left, stroke.right);
            return Status::ok;
        });
    }

    /// Adds a wall, or nothing on failure. Its edges may be open, and walls may meet and cross. O(#points +
    /// #faces).
    ///
    ///   fails  as for strokes, and face_without_vertex, face_without_area
    Status add(const Wall<T>& wall)
        requires(D == 3)
    {
        return detail::guard_memory([&] {
            const Status status = check_points(wall.points, wall.front, wall.back);
            if (status != Status::ok) return status;
            if (wall.faces.empty()) return Status::too_few_vertices;
            InteriorCells<D> cells;
            for (const auto& face : wall.faces) {
                for (const std::uint32_t i : face) {
                    if (i >= wall.points.size()) return Status::face_without_vertex;
                }
                const Facet<3> facet(face, std::span<const Vec<T, 3>>(wall.points));
                if (detail::is_flat(facet.corner, double(coincidence_tolerance(canvas_))))
                    return Status::face_without_area;
                cells.facets.push_back(face);
            }
            append(wall.points, cells, wall.front, wall.back);
            return Status::ok;
        });
    }

    /// Solves all channels, usually in 9 to 13 cycles. The cost is O(#nodes) for sixteen channels. On failure
    /// the fields of the last successful solve remain.
    ///
    ///   fails  resolution_not_supported (also for a canvas that is empty or not finite);
    ///          tolerance_not_positive; cells_unreached (no strokes); grid_too_coarse
    ///          (SolverReport::culprit is the first stroke or wall without a crossing of a lattice line, or
    ///          whose radius is below half a cell); not_converged; cancelled; out_of_memory
    Evaluation solve(const DiffusionOptions& options = {}, const Running& running = {}) {
        return detail::guarded_evaluation([&](SolverReport& report) {
            if (resolution_ < least_resolution || resolution_ > most_resolution)
                return Status::resolution_not_supported;
            for (std::size_t k = 0; k < D; ++k) {
                const double extent = double(canvas_.upper[k]) - double(canvas_.lower[k]);
                if (!(extent > 0) || !is_finite(canvas_.lower[k]) || !is_finite(canvas_.upper[k]))
                    return Status::resolution_not_supported;
            }
            if (!(options.tolerance > 0)) return Status::tolerance_not_positive;
            if (drawing_.cells.empty()) return Status::cells_unreached;
            return solve_drawing(options, report, running);
        });
    }

    /// Returns the lattice of the last solve; the field's values are at the centres of its cells.
    Lattice<double, D> lattice() const noexcept {
        return solution_ ? solution_->cells() : Lattice<double, D>{};
    }
    std::size_t channels() const noexcept { return channels_; }
    /// Returns the values at the nodes, numbered with the first axis fastest. A node on a stroke with two
    /// sides has the value of either side. Empty before the first solve.
    std::span<const T> field(std::size_t channel) const noexcept {
        CAGEFORM_ASSERT(channel < channels_, "channel below the number of channels");
        if (!solution_) return {};
        const std::size_t size = solution_->nodes_at.size();
        return std::span(solution_->fields).subspan(channel * size, size);
    }

    /// Evaluates the fields at any points: multilinear between nodes, and linear between a node and a
    /// stroke. Points off the canvas are moved to its nearest point.
    ///
    ///   values  out: #channels per point, one point after the other
    ///   cost    O(#channels + strokes in the cell) per point
    ///   fails   value_not_finite (a point), cells_unreached (before the first solve), output_too_small;
    ///           nothing is written then
    template <PointRange R>
        requires(range_dimension<R> == D)
    Status sample(const R& points, std::span<T> values) const {
        if (!solution_) return Status::cells_unreached;
        if (values.size() / channels_ < std::size(points)) return Status::output_too_small;
        for (std::size_t i = 0; i < std::size(points); ++i) {
            if (!is_finite(to_vec<T>(points[i]))) return Status::value_not_finite;
        }
        for (std::size_t i = 0; i < std::size(points); ++i) {
            const auto p = solution_->nodes_at.in_cells(vec_cast<double>(to_vec<T>(points[i])));
            write(*solution_, p, values.data() + i * channels_, 1);
        }
        return Status::ok;
    }

private:
    struct Solution {
        Lattice<double, D> nodes_at; ///< the origin is the first node
        detail::CanvasBoundary<D> boundary;
        grid::NodeRuns<D> nodes;
        std::uint32_t points;  ///< number of points of all strokes; the handles of right sides follow
        std::vector<T> values; ///< values of the unknown nodes, channel after channel
        std::vector<T> fields; ///< values of all nodes, channel after channel

        Lattice<double, D> cells() const noexcept {
            auto lattice = nodes_at;
            for (double& x : lattice.origin.v) x -= 0.5 * lattice.spacing;
            return lattice;
        }
    };

    Status check_points(const std::vector<Vec<T, D>>& points, const std::vector<T>& front,
                        const std::vector<T>& back) const {
        if (points.empty()) return Status::too_few_vertices;
        for (const auto& p : points) {
            if (!is_finite(p)) return Status::vertex_not_finite;
            if (!canvas_.covers({p, p})) return Status::interior_cell_outside;
        }
        const std::size_t values = points.size() * channels_;
        if (front.size() != values || (!back.empty() && back.size() != values))
            return Status::input_malformed;
        for (const auto* side : {&front, &back}) {
            for (const T value : *side) {
                if (!is_finite(value)) return Status::value_not_finite;
            }
        }
        return Status::ok;
    }

    /// Appends a stroke. Reserves all memory before any change.
    void append(const std::vector<Vec<T, D>>& points, const InteriorCells<D>& cells,
                const std::vector<T>& front, const std::vector<T>& back) {
        const auto make_room = [](auto& list, std::size_t more) {
            const std::size_t needed = list.size() + more;
            if (needed > list.capacity()) list.reserve((std::max)(needed, 2 * list.capacity()));
        };
        make_room(drawing_.points, points.size());
        make_room(drawing_.cells.facets, cells.facets.size());
        make_room(drawing_.cells.bones, cells.bones.size());
        make_room(front_, front.size());
        make_room(back_, front.size());
        make_room(strokes_, 1);
        const auto first = std::uint32_t(drawing_.points.size());
        for (const auto& p : points) drawing_.points.push_back(vec_cast<double>(p));
        for (auto facet : cells.facets) {
            for (std::uint32_t& i : facet) i += first;
            drawing_.cells.facets.push_back(facet);
        }
        for (const Bone& bone : cells.bones)
            drawing_.cells.bones.push_back({bone.i + first, bone.j + first, bone.radius});
        const auto& at_back = back.empty() ? front : back;
        front_.insert(front_.end(), front.begin(), front.end());
        back_.insert(back_.end(), at_back.begin(), at_back.end());
        strokes_.push_back(first);
    }

    Lattice<double, D> nodes_of_canvas() const noexcept {
        Lattice<double, D> lattice;
        const auto lower = vec_cast<double>(canvas_.lower), extent = vec_cast<double>(canvas_.upper) - lower;
        double longest = 0;
        for (std::size_t k = 0; k < D; ++k) longest = std::fmax(longest, extent[k]);
        lattice.spacing = longest / double(resolution_);
        for (std::size_t k = 0; k < D; ++k) {
            const double cells = std::ceil(extent[k] / lattice.spacing - grid::on_boundary_distance);
            lattice.cells[k] = (std::max)(std::size_t(cells), std::size_t{1});
            lattice.origin[k] = lower[k] + 0.5 * lattice.spacing;
        }
        return lattice;
    }

    /// Returns the value at a boundary point. Handles below `points` belong to left sides, the others to
    /// right sides.
    double value(const BoundaryValue<D>& at, std::size_t points, std::size_t channel) const noexcept {
        double sum = 0;
        for (std::size_t n = 0; n < BoundaryValue<D>::most; ++n) {
            const std::size_t handle = at.handle[n];
            const auto& side = handle < points ? front_ : back_;
            if (at.weight[n] != 0)
                sum += at.weight[n] *
                       double(side[(handle < points ? handle : handle - points) * channels_ + channel]);
        }
        return sum;
    }
    static bool is_rim(const BoundaryValue<D>& at) noexcept {
        return std::all_of(at.weight.begin(), at.weight.end(), [](double w) { return w == 0; });
    }
    std::size_t stroke_of(std::uint32_t handle) const noexcept {
        const auto point = std::uint32_t(handle % drawing_.points.size());
        return std::size_t(std::upper_bound(strokes_.begin(), strokes_.end(), point) - strokes_.begin()) - 1;
    }

    /// Returns the first stroke that is too thin or that crosses no lattice line, if any.
    std::optional<std::size_t> first_unresolved(const grid::Crossings<D>& crossings,
                                                const detail::CanvasBoundary<D>& boundary) const {
        if (const auto thin = boundary.too_thin_bone()) return stroke_of(*thin);
        std::vector<bool> resolved(strokes_.size());
        for (const auto& along : crossings) {
            for (const auto& crossing : along) {
                if (!is_rim(crossing.value)) resolved[stroke_of(crossing.value.handle[0])] = true;
            }
        }
        const auto first = std::find(resolved.begin(), resolved.end(), false);
        if (first == resolved.end()) return std::nullopt;
        return std::size_t(first - resolved.begin());
    }

    /// Counts the links that more than one stroke cuts.
    std::size_t crowded_links(const grid::Crossings<D>& crossings) const noexcept {
        std::size_t crowded = 0;
        for (const auto& along : crossings) {
            for (std::size_t c = 1; c < along.size(); ++c) {
                const auto &a = along[c - 1], &b = along[c];
                if (a.line != b.line || std::floor(a.position) != std::floor(b.position)) continue;
                if (is_rim(a.value) || is_rim(b.value)) continue;
                if (stroke_of(a.value.handle[0]) != stroke_of(b.value.handle[0])) ++crowded;
            }
        }
        return crowded;
    }

    Status solve_drawing(const DiffusionOptions& options, SolverReport& report, const Running& running) {
        const auto nodes_at = nodes_of_canvas();
        Solution solution{nodes_at, {drawing_, nodes_at}, {}, std::uint32_t(drawing_.points.size()), {}, {}};
        const auto crossings = solution.boundary.crossings();
        if (const auto unresolved = first_unresolved(crossings, solution.boundary)) {
            report.culprit = *unresolved;
            return Status::grid_too_coarse;
        }
        report.unresolved_cells = crowded_links(crossings);
        auto problem = grid::embed(solution.boundary, crossings);
        for (std::size_t c = 0; c < problem.cuts.size(); ++c) {
            if (is_rim(problem.values[c])) problem.cuts[c].weight = 0; // no flux through the rim
        }
        report.cells = problem.nodes.count();
        solution.boundary.index_cells(1e-6);
        solution.values.resize(channels_ * problem.nodes.count());
        const Status status = solve_nodes(problem, options, solution.values, report, running);
        if (status != Status::ok) return status;
        solution.nodes = std::move(problem.nodes);
        solution.fields.resize(channels_ * nodes_at.size());
        fill_fields(solution);
        solution_ = std::move(solution);
        return Status::ok;
    }

    Status solve_nodes(const grid::EmbeddedProblem<D>& problem, const DiffusionOptions& options,
                       std::vector<T>& solved, SolverReport& report, const Running& running) const {
        const std::uint32_t count = problem.nodes.count();
        if (count == 0) return Status::ok;
        std::vector<detail::FieldRange> ranges(channels_);
        for (const auto* side : {&front_, &back_}) {
            for (std::size_t i = 0; i < side->size(); ++i) ranges[i % channels_].add(double((*side)[i]));
        }
        const auto given = [&](std::size_t cut, std::size_t channel) {
            return value(problem.values[cut], drawing_.points.size(), channel);
        };
        const Status status =
            detail::solve_fields<D, T>(detail::FieldProblem{problem.nodes, problem.cuts, ranges, given},
                                       options, solved, report, running);
        for (std::size_t n = 0; n < solved.size(); ++n) {
            const auto& range = ranges[n / count];
            solved[n] = std::clamp(solved[n], static_cast<T>(range.middle() - range.half()),
                                   static_cast<T>(range.middle() + range.half()));
        }
        return status;
    }

    void fill_fields(Solution& solution) const noexcept {
        const std::size_t size = solution.nodes_at.size(), count = solution.nodes.count();
        for (std::size_t cell = 0; cell < size; ++cell) {
            typename grid::NodeRuns<D>::Index index;
            for (std::size_t k = 0; k < D; ++k) index[k] = std::int32_t(solution.nodes_at.index(cell)[k]);
            const std::uint32_t node = solution.nodes.find(index);
            if (node == grid::NodeRuns<D>::none) {
                write(solution, node_position<D>(index), solution.fields.data() + cell, size);
                continue;
            }
            for (std::size_t channel = 0; channel < channels_; ++channel)
                solution.fields[channel * size + cell] = solution.values[channel * count + node];
        }
    }

    /// Writes the channels at a point, which is given in units of nodes. Channel c has the index c · stride.
    void write(const Solution& solution, Vec<double, D> p, T* values, std::size_t stride) const noexcept {
        for (std::size_t k = 0; k < D; ++k)
            p[k] = std::clamp(p[k], -0.5, double(solution.nodes_at.cells[k]) - 0.5);
        const auto stencil = solution.boundary.sample(p, solution.nodes);
        for (std::size_t channel = 0; channel < channels_; ++channel) {
            const T* const nodes = solution.values.data() + channel * solution.nodes.count();
            double sum = 0;
            for (std::uint32_t n = 0; n < stencil.node_count; ++n)
                sum += stencil.nodes[n].share * double(nodes[stencil.nodes[n].node]);
            for (std::uint32_t n = 0; n < stencil.boundary_count; ++n)
                sum += stencil.boundary_points[n].share *
                       value(stencil.boundary_points[n].value, solution.points, channel);
            values[channel * stride] = static_cast<T>(sum);
        }
    }

    Bounds<T, D> canvas_;
    std::size_t resolution_, channels_;
    detail::OpenCells<D> drawing_;
    std::vector<std::uint32_t> strokes_; ///< first point of each stroke
    std::vector<T> front_, back_;        ///< values of the points, on either side
    std::optional<Solution> solution_;   ///< solution of the last successful solve
};

} // namespace cageform::inline CAGEFORM_ABI
