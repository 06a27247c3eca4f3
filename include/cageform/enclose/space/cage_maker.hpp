// make_cage in 3D: runs the steps and measures the exact clearance of the cage.
#pragma once

#include <cageform/cage/detail/shells.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/enclose/detail/cage_frame.hpp>
#include <cageform/enclose/detail/fewest_vertices.hpp>
#include <cageform/enclose/detail/join_components.hpp>
#include <cageform/enclose/detail/make_cage_into.hpp>
#include <cageform/enclose/parts_of_faces.hpp>
#include <cageform/enclose/space/clearance.hpp>
#include <cageform/enclose/space/limb_rings.hpp>
#include <cageform/enclose/space/measure_cage.hpp>
#include <cageform/enclose/space/reduce_shell.hpp>
#include <cageform/enclose/space/relax_shell.hpp>
#include <cageform/enclose/space/space_distance.hpp>
#include <cageform/enclose/space/surface_nets.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

inline Bounds<double, 3> bounds_of_corners(std::span<const Corners<3>> figure) noexcept {
    Bounds<double, 3> box = bounds_of(std::span<const Vec<double, 3>>());
    for (const auto& corner : figure) box.include(box_of(corner));
    return box;
}

/// Steps 1 to 5 for one figure.
class SpaceCageMaker {
public:
    using Point = Vec<double, 3>;

    SpaceCageMaker(std::span<const Corners<3>> figure, const MakeCageOptions& options)
        : figure_(figure)
        , options_(options)
        , box_(bounds_of_corners(figure)) {
        if (is_mirrored()) {
            box_.upper[0] = (std::max)(box_.upper[0], -box_.lower[0]);
            box_.lower[0] = -box_.upper[0];
        }
        const auto size = box_.upper - box_.lower;
        longest_ = (std::max)({size[0], size[1], size[2]});
    }

    /// Makes a shell in local coordinates. It keeps the distance `level` from the figure, up to the lattice
    /// resolution. Reports components, bridges and, on the first call, the tightest volume.
    Status make(double level, const Running& running, MakeCageReport& report, Shell& shell) {
        if (options_.shape == CageShape::box) {
            shell = box_shell(level);
            report.tightest_area = shell.six_volumes() / 6;
            return Status::ok;
        }
        const double lifted = 1.12 * level; // interpolated f is too large near flat faces
        if (const Status status = make_lattice(lifted); status != Status::ok) return status;
        SpaceDistance(lattice_, figure_).fill(lifted, 5 * lifted, running);
        if (options_.shape == CageShape::hull)
            fill_hull(lattice_, [&](const Point& direction) { return reach(direction) + lifted; });
        if (is_mirrored()) lattice_.mirror();
        if (!running.keep_going(0.15)) return Status::cancelled;
        LatticeComponents components(lattice_, lattice_.outside(0));
        report.components = components.count;
        report.bridges =
            options_.one_cage ? join_components(lattice_, std::move(components), lifted, is_mirrored()) : 0;
        close_slits(lattice_, 0.6 * lifted, false);
        if (is_mirrored()) lattice_.mirror();
        shell = contour();
        if (options_.fill_tunnels) fill_tunnels(lifted, running, shell);
        if (shell.faces.empty()) return Status::cage_not_found;
        const double six = shell.six_volumes();
        if (report.tightest_area == 0) report.tightest_area = six / 6 * (shell.half ? 2 : 1);
        if (!running.keep_going(0.3)) return Status::cancelled;
        const ShellObstacles obstacles{&lattice_, lifted};
        double area = 0;
        for (const auto& face : shell.faces) area += 0.5 * length(area_normal(shell.corners(face)));
        const ReductionInput step{obstacles, six, area * (shell.half ? 2 : 1)};
        if (options_.looseness > 0 && options_.rings)
            return make_fewest_with_rings(step, running, report, shell);
        if (options_.looseness > 0) return make_fewest(step, running, report, shell);
        return reduce(shell, options_.vertices, step, running) ? Status::ok : Status::cancelled;
    }

private:
    /// A contour to reduce.
    struct ReductionInput {
        const ShellObstacles& obstacles;
        double six_volumes, area; ///< measures of the contour; the area includes the mirror image
    };

    bool is_mirrored() const noexcept { return options_.mirror.has_value(); }

    /// Step 5, after a reduction to `vertices`. Returns false if cancelled.
    bool relax(Shell& shell, std::size_t vertices, const ReductionInput& step, const Running& running) const {
        const ShellEnergy energy(step.six_volumes, vertices, step.area, std::fmax(options_.regular, 0.0));
        return ShellRelaxation(shell, step.obstacles, energy).relax(24, running);
    }

    /// Steps 4 and 5. Returns false if cancelled.
    bool reduce(Shell& shell, std::size_t vertices, const ReductionInput& step,
                const Running& running) const {
        const double cut = options_.rings ? 0.6 : 0.3;
        return (!options_.rings || cut_rings(step, vertices, running.subtask(0.3, cut), shell)) &&
               ShellReduction(shell, step.obstacles).reduce_to(vertices, running.subtask(cut, 0.8)) &&
               relax(shell, vertices, step, running.subtask(0.8, 1));
    }

    /// Cuts a contour along a ring around each limb, after the first rounds of collapses. Searches for limbs
    /// on shells of four times, twice and once the requested vertices, and uses the search that finds most
    /// limbs. Returns false if cancelled.
    bool cut_rings(const ReductionInput& step, std::size_t vertices, const Running& running,
                   Shell& shell) const {
        ShellReduction reduction(shell, step.obstacles);
        if (!reduction.begin(vertices, running.subtask(0, 0.4))) return false;
        Shell fine = shell.compacted();
        LimbRings rings(fine, lattice_.spacing());
        double done = 0.4;
        for (const std::size_t times : {4U, 2U, 1U}) {
            if (!reduction.reduce_to(times * vertices, running.subtask(done, done + 0.2))) return false;
            rings.find_limbs(shell.compacted());
            done += 0.2;
        }
        rings.cut(vertices);
        if (!fine.rings.empty()) shell = std::move(fine); // otherwise it is already reduced
        return true;
    }

    /// Searches for the fewest vertices within options.looseness. One reduction visits all counts; only the
    /// counts tried are relaxed.
    Status make_fewest(const ReductionInput& step, const Running& running, MakeCageReport& report,
                       Shell& shell) const {
        const auto wanted = vertex_counts(4, first_tried, options_.vertices);
        std::vector<Shell> reduced;
        std::vector<std::size_t> counts;
        const auto contour = shell.points;
        ShellReduction reduction(shell, step.obstacles);
        double done = 0.3;
        for (std::size_t k = wanted.size(); k-- > 0;) { // the first count takes most of the time
            const double from = std::exchange(done, 0.6 - 0.05 * double(k) / double(wanted.size()));
            if (!reduction.reduce_to(wanted[k], running.subtask(from, done))) return Status::cancelled;
            const std::size_t count = shell.whole_size();
            if (!counts.empty() && count == counts.back())
                continue; // no more vertices in the contour, or no valid collapse
            counts.push_back(count);
            reduced.push_back(shell.compacted());
        }
        std::reverse(counts.begin(), counts.end());
        std::reverse(reduced.begin(), reduced.end());
        VertexCountSearch<Shell> search(counts, first_tried, options_.looseness);
        for (double left = 0.4; const auto index = search.next(); left *= 0.8) {
            const Running subtask = running.subtask(1 - left, 1 - 0.8 * left);
            Shell trial = std::move(reduced[*index]);
            if (!relax(trial, counts[*index], step, subtask)) return Status::cancelled;
            search.add(*index, {attempt_of(trial, contour, report), std::move(trial)});
        }
        report.attempts = search.attempts();
        shell = search.best();
        return Status::ok;
    }

    /// Measures a shell that was reduced from a contour with these points.
    static MakeCageReport::Attempt attempt_of(const Shell& shell, const std::vector<Point>& contour,
                                              const MakeCageReport& report) {
        const double volume = shell.six_volumes() / 6 * (shell.half ? 2 : 1);
        std::vector<Corners<3>> facets;
        facets.reserve(shell.faces.size());
        for (std::size_t f = 0; f < shell.faces.size(); ++f) {
            if (shell.is_face(f)) facets.push_back(shell.corners(shell.faces[f]));
        }
        return {shell.whole_size(), volume / report.tightest_area - 1, deepest_hollow<3>(contour, facets)};
    }

    /// Searches for the fewest vertices without rings. Then makes a cage with rings and as many vertices, and
    /// adds vertices while this cage is too loose. Attempts with rings replace those with the same number of
    /// vertices.
    Status make_fewest_with_rings(const ReductionInput& step, const Running& running, MakeCageReport& report,
                                  Shell& shell) const {
        const Shell contour = shell;
        const Status status = make_fewest(step, running.subtask(0, 0.6), report, shell);
        if (status != Status::ok) return status;
        std::size_t vertices = shell.whole_size();
        for (double left = 0.4;; left *= 0.6) {
            shell = contour;
            if (!reduce(shell, vertices, step, running.subtask(1 - left, 1 - 0.6 * left)))
                return Status::cancelled;
            const auto attempt = attempt_of(shell, contour.points, report);
            auto& all = report.attempts;
            const auto at =
                std::lower_bound(all.begin(), all.end(), attempt,
                                 [](const auto& a, const auto& b) { return a.vertices < b.vertices; });
            if (at != all.end() && at->vertices == attempt.vertices)
                *at = attempt;
            else
                all.insert(at, attempt);
            if (attempt.excess <= options_.looseness || vertices >= options_.vertices || left < 0.04)
                return Status::ok;
            vertices = (std::min)(options_.vertices, vertices + vertices / 20 + 1);
        }
    }
    static constexpr std::size_t first_tried = 30;

    Shell box_shell(double level) const {
        const auto box = box_.widened(level);
        Shell shell;
        for (unsigned corner = 0; corner < 8; ++corner) {
            Point p = box.lower;
            for (std::size_t k = 0; k < 3; ++k) p[k] = (corner >> k & 1U) != 0 ? box.upper[k] : p[k];
            shell.points.push_back(p);
            shell.on_rim.push_back(false);
        }
        // A corner of each side, and its two neighbours. The fourth corner of the side is the sum of the
        // neighbours minus the first corner.
        for (const Shell::Face& quad :
             {Shell::Face{0, 2, 1}, {4, 5, 6}, {0, 1, 4}, {2, 6, 3}, {0, 4, 2}, {1, 3, 5}}) {
            shell.faces.push_back(quad);
            shell.faces.push_back({quad[1], quad[1] + quad[2] - quad[0], quad[2]});
        }
        shell.link();
        return shell;
    }

    /// Extent of the figure (and of its mirror image, if the cage is mirrored) along a direction.
    double reach(const Point& direction) const noexcept {
        double most = std::numeric_limits<double>::lowest();
        for (const auto& corner : figure_) {
            for (const auto& p : corner) {
                most = (std::max)(most, dot(direction, p));
                if (is_mirrored()) most = (std::max)(most, dot(direction, Point{-p[0], p[1], p[2]}));
            }
        }
        return most;
    }

    /// A margin has 2.2 spacings, or fewer if the longest side would need more than 220.
    Status make_lattice(double level) {
        const double wanted = (std::max)(level / 2.2, (longest_ + 2 * level) / 220);
        const double h = double(static_cast<float>(wanted)); // exact node positions
        if (h > 0.8 * level) return Status::margin_too_small;
        lattice_ = lattice_about(h, 5 * level + 4 * h, 5 * level);
        return Status::ok;
    }
    /// Makes a lattice around the figure. The mirror plane, if any, is midway between nodes.
    DistanceLattice<3> lattice_about(double h, double padding, double farthest) const {
        Point low{};
        DistanceLattice<3>::Count count{};
        for (std::size_t k = 0; k < 3; ++k) {
            const bool centred = k == 0 && is_mirrored();
            const double to = box_.upper[k] + padding, from = box_.lower[k] - padding;
            const double half = std::ceil(to / h);
            low[k] = centred ? (0.5 - half) * h : from;
            count[k] = static_cast<std::size_t>(centred ? 2 * half : std::ceil((to - from) / h) + 1);
        }
        return {low, h, count, farthest};
    }

    /// Border of the outside as a manifold mesh. Enclosed pockets become inside.
    Shell contour() {
        auto outside = lattice_.outside(0);
        for (std::size_t node = 0; node < lattice_.size(); ++node) {
            if (outside[node] == 0 && lattice_[node] > 0)
                lattice_[node] = static_cast<float>(-lattice_.spacing());
        }
        for (bool changed = true; changed;) {
            make_well_composed(lattice_, outside);
            changed = false;
            if (!is_mirrored()) break;
            const std::size_t width = lattice_.count()[0];
            for (std::size_t node = 0; node < lattice_.size(); ++node) {
                const std::size_t column = node % width, image = node - column + (width - 1 - column);
                if (outside[node] == outside[image]) continue;
                outside[node] = outside[image] = 0;
                changed = true;
            }
        }
        return SurfaceNets(lattice_, outside, is_mirrored()).shell();
    }

    /// Closes the figure by balls of increasing radius until no tunnel is left. Each round uses its own
    /// lattice with enough space around the figure.
    void fill_tunnels(double level, const Running& running, Shell& shell) {
        for (double radius = 2 * level; radius < longest_ && euler_number(shell) < 2 * shell_count(shell);
             radius *= 2) {
            const double h = (std::max)(lattice_.spacing(), (longest_ + 4 * radius) / 120);
            auto coarse = lattice_about(h, radius + 4 * h, radius + 3 * h);
            SpaceDistance(coarse, figure_).fill(level, radius + 3 * h, running);
            if (is_mirrored()) coarse.mirror();
            const auto open = coarse.outside(static_cast<float>(radius));
            const auto nearest = nearest_sources(coarse, [&](std::size_t node) { return open[node] != 0; });
            for (std::size_t node = 0; node < coarse.size(); ++node) {
                if (nearest[node] == coarse.size()) continue;
                coarse[node] =
                    static_cast<float>(radius - h * std::sqrt(coarse.squared_steps(node, nearest[node])));
            }
            for (std::size_t node = 0; node < lattice_.size(); ++node)
                lattice_[node] =
                    (std::min)(lattice_[node], static_cast<float>(coarse.value(lattice_.position(node))));
            if (is_mirrored()) lattice_.mirror();
            shell = contour();
        }
    }

    std::span<const Corners<3>> figure_;
    const MakeCageOptions& options_;
    Bounds<double, 3> box_;
    double longest_ = 0;
    DistanceLattice<3> lattice_;
};

/// Returns the cage in the figure's coordinates; a half is completed by its image.
template <Scalar T>
TriangleMesh<T> cage_of(const Shell& shell, const CageFrame<3>& frame) {
    const WholeShell whole(shell);
    std::vector<Vec<T, 3>> vertices;
    std::vector<std::uint32_t> number(whole.points.size());
    const auto add = [&](std::uint32_t v) {
        number[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(vec_cast<T>(frame.from_local(whole.points[v])));
    };
    enum Pass { rim, own, image };
    for (const Pass pass : {rim, own, image}) {
        for (std::uint32_t v = 0; v < shell.points.size(); ++v) {
            const bool is_on_rim = shell.half && shell.on_rim[v];
            if (shell.star[v].empty() || is_on_rim != (pass == rim)) continue;
            if (pass != image)
                add(v);
            else if (shell.half)
                add(whole.image[v]);
        }
    }
    std::vector<MeshFace> faces;
    for (const auto& [a, b, c] : whole.faces) {
        faces.push_back({number[a], number[b], number[c]});
        if (frame.reverses_orientation()) std::swap(faces.back()[1], faces.back()[2]);
    }
    return {vertices, faces};
}

/// Reads the corners of the faces; reports the first invalid face or vertex.
template <Scalar T>
Status read_figure(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces,
                   std::vector<Corners<3>>& figure, MakeCageReport& report) {
    if (std::size(faces) == 0) return Status::figure_empty;
    constexpr T limit = largest_figure_coordinate<T, 3>();
    figure.reserve(std::size(faces));
    for (std::size_t f = 0; f < std::size(faces); ++f) {
        const MeshFace& face = faces[f];
        report.culprit = f;
        if (has_missing_vertex(face)) return Status::index_out_of_range;
        Corners<3> corner;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec<T, 3>& p = vertices[face[k]];
            report.culprit = face[k];
            for (const T x : p.v) {
                if (!is_finite(x) || std::fabs(x) > limit) return Status::figure_not_finite;
            }
            corner[k] = vec_cast<double>(p);
        }
        figure.push_back(corner);
    }
    report.culprit = 0;
    return Status::ok;
}

/// Repeats the steps with a larger distance while the exact clearance is too small.
template <class T>
Status make_cage_into(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces,
                      const MakeCageOptions& options, const Running& running,
                      Result<TriangleMesh<T>, MakeCageReport>& made) {
    auto& report = made.report;
    std::vector<Corners<3>> figure;
    if (const Status status = read_figure(vertices, faces, figure, report); status != Status::ok)
        return status;
    if (const Status status = check_options<3>(options); status != Status::ok) return status;
    const Bounds<double, 3> box = bounds_of_corners(figure);
    if (!(box.diagonal() > least_figure_diagonal<3>())) return Status::figure_has_no_size;
    const CageFrame<3> frame(box, options.mirror);
    std::vector<Corners<3>> local = figure;
    for (auto& corner : local) {
        for (auto& p : corner) p = frame.to_local(p);
    }
    MakeCageOptions wanted = options;
    if (wanted.vertices == 0) wanted.vertices = options.looseness > 0 ? 1000 : 112;
    report.margin = (options.margin > 0 ? options.margin : 0.02) * box.diagonal();
    if (!resolves_margin<T>(report.margin, box)) return Status::cage_not_found;
    SpaceCageMaker maker(local, wanted);
    const auto starts = component_corners(faces, std::size(vertices));
    double level = report.margin * frame.scale;
    Shell shell;
    constexpr std::size_t tries = 3;
    for (std::size_t round = 0; round < tries; ++round) {
        const std::array<double, 4> done{0, 0.9, 0.95, 1}; // a second try is rare
        const Running subtask = running.subtask(done[round], done[round + 1]);
        shell = {};
        if (const Status status = maker.make(level, subtask, report, shell); status != Status::ok)
            return status;
        made.value = cage_of<T>(shell, frame);
        report.cage = check(made.value);
        report.clearance = exact_clearance(made.value, std::span<const Corners<3>>(figure), 2 * report.margin,
                                           Running{.parallel = running.parallel});
        const bool all_inside = std::all_of(starts.begin(), starts.end(), [&](std::size_t v) {
            return locate(made.value, vertices[v], T(0)) == PointState::inside;
        });
        if (!all_inside) report.clearance = -report.clearance;
        if (meets_guarantees(report)) break;
        level += (std::max)((report.margin - report.clearance) * frame.scale, 0.1 * level);
    }
    if (!running.keep_going(1)) return Status::cancelled;
    const auto shells = shells_of(made.value);
    report.vertices = made.value.size();
    report.triangles = made.value.faces().size();
    report.least_angle = least_angle(made.value);
    if (options.rings)
        report.parts = parts_of_faces(made.value.faces(), made.value.size(), RingRegions(shell).numbers());
    report.area = 0;
    for (const double six : shells.volume) report.area += std::fabs(six) / 6;
    report.tightest_area /= frame.scale * frame.scale * frame.scale;
    for (auto& attempt : report.attempts) attempt.hollow /= frame.scale;
    // Euler's formula: V - E + F = 2 (shells - tunnels), and 2 E = 3 F.
    report.tunnels = (2 * shells.first_face.size() + made.value.faces().size() / 2 - made.value.size()) / 2;
    return meets_guarantees(report) ? Status::ok : Status::cage_not_found;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
