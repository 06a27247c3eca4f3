// make_cage in 2D: runs the steps and measures the exact clearance of the cage.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/cage/polygon.hpp>
#include <cageform/enclose/detail/cage_frame.hpp>
#include <cageform/enclose/detail/fewest_vertices.hpp>
#include <cageform/enclose/detail/join_components.hpp>
#include <cageform/enclose/detail/make_cage_into.hpp>
#include <cageform/enclose/plane/reduce_loop.hpp>
#include <cageform/enclose/plane/relax_loop.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

template <Scalar T>
Bounds<double, 2> bounds_of_segments(std::span<const DrawnSegment<T>> figure) noexcept {
    auto box = bounds_of(std::span<const Vec<double, 2>>());
    for (const auto& s : figure) {
        const std::array ends{vec_cast<double>(s.a), vec_cast<double>(s.b)};
        box.include(bounds_of(std::span<const Vec<double, 2>>(ends)).widened(double(s.radius)));
    }
    return box;
}

/// Steps 1 to 5 for one figure.
class PlaneCageMaker {
public:
    using Point = Vec<double, 2>;

    PlaneCageMaker(std::span<const DrawnSegment<double>> figure, std::span<const PaintedArea> areas,
                   const MakeCageOptions& options)
        : figure_(figure)
        , areas_(areas)
        , options_(options) {}

    /// Makes the loops in local coordinates, outer ones counter-clockwise. They keep the distance `level`
    /// from the figure, up to the lattice resolution. Reports components, bridges and, on the first call, the
    /// tightest area.
    Status make(double level, const Running& running, MakeCageReport& report, std::vector<Loop>& cage) {
        if (options_.shape == CageShape::box) {
            const auto box = bounds().widened(level);
            cage = {{box.lower, {box.upper[0], box.lower[1]}, box.upper, {box.lower[0], box.upper[1]}}};
            report.tightest_area = signed_area(cage[0]);
            return Status::ok;
        }
        if (const Status status = fill_lattice(level); status != Status::ok) return status;
        if (!running.keep_going(0.2)) return Status::cancelled;
        LatticeComponents components(lattice_, lattice_.outside(0));
        report.components = components.count;
        report.bridges =
            options_.one_cage ? join_components(lattice_, std::move(components), level, is_mirrored()) : 0;
        close_slits(lattice_, 0.6 * level, options_.holes);
        if (is_mirrored()) lattice_.mirror();
        find_contours(level);
        if (contours_.empty()) return Status::cage_not_found;
        if (report.tightest_area == 0) {
            for (const auto& loop : contours_)
                report.tightest_area += copies_of(loop) * signed_area(loop.points) * (loop.half ? 2 : 1);
        }
        if (!running.keep_going(0.4)) return Status::cancelled;
        if (options_.looseness > 0) return make_fewest(level, running, report, cage);
        return reduce_all(options_.vertices, level, running.subtask(0.4, 1), cage) ? Status::ok
                                                                                   : Status::cancelled;
    }

private:
    bool is_mirrored() const noexcept { return options_.mirror.has_value(); }

    /// Reduces the contours to `vertices` in total and completes mirrored loops. Returns false if cancelled.
    bool reduce_all(std::size_t vertices, double level, const Running& running, std::vector<Loop>& cage) {
        const auto shares = share_vertices(vertices);
        for (std::size_t k = 0; k < contours_.size(); ++k) {
            contours_[k] = reduced(k, shares[k], level);
            if (!running.keep_going(double(k + 1) / double(contours_.size()))) return false;
        }
        cage.clear();
        for (const auto& loop : contours_) add_whole(loop, cage);
        return true;
    }
    /// Searches for the fewest vertices within options.looseness.
    Status make_fewest(double level, const Running& running, MakeCageReport& report,
                       std::vector<Loop>& cage) {
        constexpr std::size_t first = 12;
        VertexCountSearch<std::vector<Loop>> search(vertex_counts(3, first, options_.vertices), first,
                                                    options_.looseness);
        const auto contours = contours_;
        std::vector<Point> places;
        for (const auto& loop : contours) places.insert(places.end(), loop.points.begin(), loop.points.end());
        for (double left = 0.6; const auto index = search.next(); left *= 0.8) {
            const Running subtask = running.subtask(1 - left, 1 - 0.8 * left);
            contours_ = contours;
            if (!reduce_all(search.count(*index), level, subtask, cage)) return Status::cancelled;
            std::size_t vertices = 0;
            double area = 0;
            std::vector<Corners<2>> edges;
            for (const auto& loop : cage) {
                vertices += loop.size();
                area += signed_area(loop);
                for (std::size_t i = 0; i < loop.size(); ++i)
                    edges.push_back({loop[i], loop[(i + 1) % loop.size()]});
            }
            const double hollow = deepest_hollow<2>(places, edges);
            search.add(*index, {{vertices, area / report.tightest_area - 1, hollow}, std::move(cage)});
        }
        report.attempts = search.attempts();
        cage = search.best();
        return Status::ok;
    }

    /// Bounds of the figure, and of its mirror image if the cage is mirrored.
    Bounds<double, 2> bounds() const noexcept {
        auto all = bounds_of_segments(figure_);
        if (is_mirrored()) {
            all.upper[0] = (std::max)(all.upper[0], -all.lower[0]);
            all.lower[0] = -all.upper[0];
        }
        return all;
    }

    /// Samples f up to 4 margins or 12 nodes from the figure. The longer side has at least 256 nodes, a
    /// margin at least three. Leaves 8 margins of free space around the figure.
    Status fill_lattice(double level) {
        const auto box = bounds();
        const auto size = box.upper - box.lower;
        // Single precision makes node positions exact and puts a column on the mirror axis.
        const double h = double(
            static_cast<float>((std::min)(((std::max)(size[0], size[1]) + 2 * level) / 256, level / 3)));
        Point low{};
        std::array<std::size_t, 2> count{};
        double nodes = 1;
        for (std::size_t k = 0; k < 2; ++k) {
            const double from = box.lower[k] - 8 * level, to = box.upper[k] + 8 * level;
            const bool centred = k == 0 && is_mirrored();
            const double side = centred ? 2 * std::ceil(to / h) : std::ceil((to - from) / h);
            low[k] = centred ? -h * std::ceil(to / h) : from;
            nodes *= side + 1;
            if (!(nodes <= double(most_lattice_nodes))) return Status::margin_too_small;
            count[k] = static_cast<std::size_t>(side) + 1;
        }
        const double band = (std::max)(4 * level, 12 * h);
        lattice_ = DistanceLattice<2>(low, h, count, band - level);
        for (const auto& s : figure_) lattice_.add_capsule(s.a, s.b, s.radius + level, band - level);
        if (options_.holes) {
            for (const auto& area : areas_)
                fill_area(lattice_, figure_.subspan(area.begin, area.end - area.begin), area.even_odd, level);
        }
        if (options_.shape == CageShape::hull)
            fill_hull(lattice_, [&](const Point& direction) { return reach(direction) + level; });
        if (is_mirrored()) lattice_.mirror();
        return Status::ok;
    }
    /// Extent of the figure (and of its mirror image, if the cage is mirrored) along a direction.
    double reach(const Point& direction) const noexcept {
        double most = std::numeric_limits<double>::lowest();
        for (const auto& s : figure_) {
            for (const auto& p : {s.a, s.b}) {
                most = (std::max)(most, dot(direction, p) + s.radius);
                if (is_mirrored()) most = (std::max)(most, dot(direction, CageLoop::mirrored(p)) + s.radius);
            }
        }
        return most;
    }

    /// Fills everything that is not outside (pockets, enclosed regions), except holes if requested.
    void find_contours(double level) {
        auto outside = lattice_.outside(0);
        if (options_.holes) add_holes(outside, 16 * level * level);
        for (std::size_t node = 0; node < lattice_.size(); ++node) {
            if (outside[node] == 0 && lattice_[node] > 0)
                lattice_[node] = static_cast<float>(-lattice_.spacing());
        }
        contours_.clear();
        for (auto& loop : Contour(lattice_, outside).loops()) {
            if (!is_mirrored()) {
                contours_.push_back({std::move(loop), false});
            } else if (auto half = right_half(loop); !half.points.empty()) {
                contours_.push_back(std::move(half));
            }
        }
    }
    void add_holes(std::vector<std::uint8_t>& outside, double least_area) const {
        const double cell = lattice_.spacing() * lattice_.spacing();
        std::vector<std::uint8_t> seen = outside;
        for (std::size_t start = 0; start < lattice_.size(); ++start) {
            std::vector<std::size_t> hole;
            const auto enter = [&](std::size_t node) {
                if (seen[node] != 0 || !(lattice_[node] > 0)) return;
                seen[node] = 1;
                hole.push_back(node);
            };
            enter(start);
            for (std::size_t k = 0; k < hole.size(); ++k) lattice_.for_each_neighbour(hole[k], enter);
            if (double(hole.size()) * cell <= least_area) continue;
            for (const std::size_t node : hole) outside[node] = 1;
        }
    }

    /// Returns the part of a loop with x >= 0: the whole loop, nothing, or a chain if the loop crosses the
    /// axis. Such a loop crosses the axis at exactly two vertices: nodes lie on the axis, and a symmetric
    /// region without holes covers one interval of the axis.
    static CageLoop right_half(const Loop& loop) {
        const std::size_t n = loop.size();
        for (std::size_t i = 0; i < n; ++i) {
            if (loop[i][0] != 0 || loop[(i + 1) % n][0] <= 0) continue;
            CageLoop half{{loop[i]}, true};
            for (std::size_t k = 1; k < n && half.points.back()[0] >= 0; ++k) {
                half.points.push_back(loop[(i + k) % n]);
                if (half.points.back()[0] == 0) break;
            }
            return half;
        }
        return loop[0][0] > 0 ? CageLoop{loop, false} : CageLoop{};
    }

    /// Returns 2 if the mirror image of the loop is a separate loop, else 1.
    int copies_of(const CageLoop& loop) const noexcept { return is_mirrored() && !loop.half ? 2 : 1; }

    /// Distributes the vertices over the loops in proportion to the square roots of their areas, at least
    /// four each (three for a single loop). The result for a half is the size of its chain.
    std::vector<std::size_t> share_vertices(std::size_t vertices) const {
        double sum = 0;
        const auto weight = [](const CageLoop& loop) {
            return std::sqrt(std::fabs(signed_area(loop.points)) * (loop.half ? 2 : 1));
        };
        auto order = first_indices<std::size_t>(contours_.size());
        std::vector<std::size_t> shares(contours_.size());
        std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
            return weight(contours_[i]) < weight(contours_[j]);
        });
        for (const auto& loop : contours_) sum += copies_of(loop) * weight(loop);
        const double wanted = double(vertices);
        const double least = contours_.size() == 1 ? 3 : 4;
        double given = 0, share = 0;
        for (const std::size_t k : order) { // rounding errors carry over to larger loops
            const auto& loop = contours_[k];
            share += wanted * copies_of(loop) * weight(loop) / sum;
            const double whole = (std::max)(std::round((share - given) / copies_of(loop)), least);
            given += copies_of(loop) * whole;
            shares[k] =
                static_cast<std::size_t>(loop.half ? (std::max)(std::floor(whole / 2), 2.0) + 1 : whole);
        }
        return shares;
    }

    Obstacles obstacles_of(std::size_t k, double level) const {
        const auto& own = contours_[k].points;
        const auto box = bounds_of(std::span<const Point>(own));
        const bool alone = contours_.size() == 1;
        Obstacles obstacles(lattice_, level,
                            box.widened((std::max)(8 * level, (alone ? 1 : 0.75) * box.diagonal())));
        for (std::size_t other = 0; other < contours_.size(); ++other) {
            if (other != k) obstacles.add(contours_[other]);
        }
        obstacles.add_inside(contours_[k]);
        if (copies_of(contours_[k]) > 1)
            obstacles.add({0, -4}, {0, 4}); // the axis: the image is on the other side
        return obstacles;
    }

    /// Reduces contour k to n = `vertices` points. Tries reductions to n, 7n/8, 6n/8 and 5n/8, inserts the
    /// missing vertices during relaxation, and keeps the result of least energy.
    CageLoop reduced(std::size_t k, std::size_t vertices, double level) const {
        const auto& contour = contours_[k];
        const LoopEnergy energy(contour, vertices, std::fmax(options_.regular, 0.0));
        const Obstacles obstacles = obstacles_of(k, level);
        const LoopRelaxation relaxation(energy, obstacles);
        const auto box = bounds_of(std::span<const Point>(contour.points));
        LoopReduction reduction(contour, obstacles, box.diagonal());
        CageLoop best;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t eighths = 0; eighths < 4; ++eighths) {
            reduction.reduce_to(vertices - vertices * eighths / 8);
            CageLoop trial = reduction.loop();
            relaxation.relax(trial, 6);
            relaxation.insert(trial, vertices);
            relaxation.relax(trial, 8);
            if (!(energy.of(trial) < least) || (eighths > 0 && trial.size() > best.size())) continue;
            least = energy.of(trial);
            best = std::move(trial);
        }
        relaxation.relax(best, 30);
        relaxation.reinsert(best);
        return best;
    }

    /// Adds a loop, completed by its image; adds a separate image as another loop.
    void add_whole(const CageLoop& loop, std::vector<Loop>& cage) const {
        Loop whole = loop.points, image;
        for (auto p = loop.points.rbegin(); p != loop.points.rend(); ++p)
            image.push_back(CageLoop::mirrored(*p));
        if (loop.half) whole.insert(whole.end(), image.begin() + 1, image.end() - 1);
        cage.push_back(std::move(whole));
        if (copies_of(loop) > 1) cage.push_back(std::move(image));
    }

    std::span<const DrawnSegment<double>> figure_;
    std::span<const PaintedArea> areas_;
    const MakeCageOptions& options_;
    DistanceLattice<2> lattice_;
    std::vector<CageLoop> contours_; ///< replaced one by one by reduced loops
};

/// Minimum distance between the cage edges and the figure; negative if a segment is not inside.
template <Scalar T>
double exact_clearance(const Polygon<T>& cage, std::span<const DrawnSegment<double>> figure) {
    Buffer<Facet<2>> edges;
    for_each_facet(cage, [&](const auto& edge) { edges.push_back({edge, cage.vertices()}); });
    double least = std::numeric_limits<double>::infinity();
    bool all_inside = true;
    for (const auto& s : figure) {
        bool inside = false;
        for (const auto& edge : edges) {
            const auto& [p, q] = edge.corner;
            if (crosses_ray(s.a, p, q)) inside = !inside;
            if (Obstacles::segments_near(s.a, s.b, p, q, least + s.radius))
                least = (std::min)(least, segment_distance(s.a, s.b, p, q) - s.radius);
        }
        all_inside = all_inside && inside;
    }
    return all_inside ? least : -std::fabs(least);
}

/// Smallest angle between adjacent edges, in degrees.
template <Scalar T>
double least_angle(const Polygon<T>& cage) {
    double least = std::numbers::pi;
    for (const auto& loop : cage.loops()) {
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const std::size_t n = loop.size(), k = i - loop.begin;
            const auto x = vec_cast<double>(cage[i]);
            const auto u = vec_cast<double>(cage[loop.begin + (k + 1) % n]) - x;
            const auto v = vec_cast<double>(cage[loop.begin + (k + n - 1) % n]) - x;
            least = (std::min)(least, angle_between(u, v));
        }
    }
    return least * 180 / std::numbers::pi;
}

/// Sets `report.culprit` to the index of the first invalid segment or area.
template <Scalar T>
Status check_figure(std::span<const DrawnSegment<T>> figure, std::span<const PaintedArea> areas,
                    const MakeCageOptions& options, MakeCageReport& report) {
    if (figure.empty()) return Status::figure_empty;
    constexpr T limit = largest_figure_coordinate<T, 2>();
    for (std::size_t i = 0; i < figure.size(); ++i) {
        const auto& [a, b, radius] = figure[i];
        report.culprit = i;
        for (const T x : {a[0], a[1], b[0], b[1], radius}) {
            if (!is_finite(x) || std::fabs(x) > limit) return Status::figure_not_finite;
        }
        if (radius < 0) return Status::figure_not_finite;
    }
    report.culprit = 0;
    for (std::size_t k = 0; k < areas.size(); ++k) {
        report.culprit = k;
        if (areas[k].begin > areas[k].end || areas[k].end > figure.size()) return Status::index_out_of_range;
    }
    report.culprit = 0;
    return check_options<2>(options);
}

/// A figure in local coordinates.
struct FramedFigure {
    CageFrame<2> frame;
    Bounds<double, 2> box; ///< in the figure's own coordinates
    std::vector<DrawnSegment<double>> segments;
    double diagonal = 0; ///< diagonal of the bounds, in local units
};

template <Scalar T>
Status frame_figure(std::span<const DrawnSegment<T>> figure, const std::optional<MirrorPlane>& mirror,
                    FramedFigure& framed) {
    auto& box = framed.box;
    box = bounds_of_segments(figure);
    if (!(box.diagonal() > least_figure_diagonal<2>())) return Status::figure_has_no_size;
    auto& frame = framed.frame;
    frame = CageFrame<2>(box, mirror);
    for (const auto& s : figure)
        framed.segments.push_back({frame.to_local(vec_cast<double>(s.a)),
                                   frame.to_local(vec_cast<double>(s.b)), frame.scale * double(s.radius)});
    framed.diagonal = length(frame.scale * (box.upper - box.lower));
    return Status::ok;
}

/// Repeats the steps with a larger distance while the exact clearance is too small.
template <class T>
Status make_cage_into(std::span<const DrawnSegment<T>> figure, std::span<const PaintedArea> areas,
                      const MakeCageOptions& options, const Running& running,
                      Result<Polygon<T>, MakeCageReport>& made) {
    auto& report = made.report;
    Status status = check_figure(figure, areas, options, report);
    if (status != Status::ok) return status;
    FramedFigure framed;
    if (status = frame_figure(figure, options.mirror, framed); status != Status::ok) return status;
    MakeCageOptions wanted = options;
    if (wanted.vertices == 0) wanted.vertices = options.looseness > 0 ? 200 : 24;
    const double margin = (options.margin > 0 ? options.margin : 0.025) * framed.diagonal;
    report.margin = margin / framed.frame.scale;
    if (!resolves_margin<T>(report.margin, framed.box)) return Status::cage_not_found;
    PlaneCageMaker maker(framed.segments, areas, wanted);
    std::vector<DrawnSegment<double>> exact; // in the figure's own coordinates
    for (const auto& s : figure)
        exact.push_back({vec_cast<double>(s.a), vec_cast<double>(s.b), double(s.radius)});
    double level = margin;
    constexpr std::size_t tries = 3;
    for (std::size_t round = 0; round < tries; ++round) {
        std::vector<Loop> loops;
        const std::array<double, 4> done{0, 0.9, 0.95, 1}; // a second try is rare
        const Running subtask = running.subtask(done[round], done[round + 1]);
        if (status = maker.make(level, subtask, report, loops); status != Status::ok) return status;
        std::vector<Vec<T, 2>> vertices;
        std::vector<std::size_t> sizes;
        for (const auto& loop : loops) {
            for (const auto& p : loop) vertices.push_back(vec_cast<T>(framed.frame.from_local(p)));
            if (framed.frame.reverses_orientation())
                std::reverse(vertices.end() - std::ptrdiff_t(loop.size()), vertices.end());
            sizes.push_back(loop.size());
        }
        made.value = Polygon<T>(vertices, sizes);
        report.cage = check(made.value);
        report.clearance = exact_clearance(made.value, std::span<const DrawnSegment<double>>(exact));
        if (meets_guarantees(report)) break;
        level += (std::max)(margin - report.clearance * framed.frame.scale, 0.1 * margin);
    }
    if (!running.keep_going(1)) return Status::cancelled;
    report.vertices = made.value.size();
    report.least_angle = least_angle(made.value);
    report.area = 0;
    for (const auto& loop : made.value.loops()) report.area += signed_area(made.value, loop);
    report.tightest_area /= framed.frame.scale * framed.frame.scale;
    for (auto& attempt : report.attempts) attempt.hollow /= framed.frame.scale;
    return meets_guarantees(report) ? Status::ok : Status::cage_not_found;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
