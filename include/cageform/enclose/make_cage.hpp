// A cage for a figure in the plane: a few vertices about all that is drawn. Of the figure nothing is asked but finite
// coordinates: strokes, open paths, outlines that cross themselves and scattered parts will do.
//
// The order of reading: distance_lattice.hpp, join_parts.hpp, contour.hpp, cage_loop.hpp, reduce_loop.hpp,
// relax_loop.hpp, this. In space: make_cage_3d.hpp.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/enclose/detail/cage_frame.hpp>
#include <cageform/enclose/detail/join_parts.hpp>
#include <cageform/enclose/plane/reduce_loop.hpp>
#include <cageform/enclose/plane/relax_loop.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The steps for one figure and one distance to keep from it.
class PlaneCageMaker {
public:
    using Point = Vec<double, 2>;

    PlaneCageMaker(std::span<const DrawnSegment<double>> figure, std::span<const PaintedArea> areas,
                   const MakeCageOptions& options)
        : figure_(figure)
        , areas_(areas)
        , options_(options) {}

    /// Loops of the cage in local coordinates, outer ones counter-clockwise, that keep `level` off the figure as far as
    /// the lattice can tell. `report` gets parts, bridges and the tightest area the first time.
    Status make(double level, const Running& running, MakeCageReport& report, std::vector<Loop>& cage) {
        if (options_.shape == CageShape::box) {
            const auto box = bounds().widened(level);
            cage = {{box.lower, {box.upper[0], box.lower[1]}, box.upper, {box.lower[0], box.upper[1]}}};
            report.tightest_area = signed_area(cage[0]);
            return Status::ok;
        }
        if (const Status status = fill_lattice(level); status != Status::ok) return status;
        if (!running.keep_going(0.2)) return Status::cancelled;
        report.parts = LatticeParts(lattice_, lattice_.outside(0)).count;
        report.bridges = options_.one_cage ? join_parts(lattice_, level, is_mirrored()) : 0;
        close_slits(lattice_, 0.6 * level, options_.holes);
        if (is_mirrored()) lattice_.mirror();
        find_contours(level);
        if (contours_.empty()) return Status::cage_not_found;
        if (report.tightest_area == 0) {
            for (const auto& loop : contours_)
                report.tightest_area += copies_of(loop) * signed_area(loop.points) * (loop.half ? 2 : 1);
        }
        if (!running.keep_going(0.4)) return Status::cancelled;
        const auto shares = share_vertices();
        for (std::size_t k = 0; k < contours_.size(); ++k) {
            contours_[k] = reduced(k, shares[k], level);
            if (!running.keep_going(0.4 + 0.6 * double(k + 1) / double(contours_.size())))
                return Status::cancelled;
        }
        cage.clear();
        for (const auto& loop : contours_) add_whole(loop, cage);
        return Status::ok;
    }

private:
    bool is_mirrored() const noexcept { return options_.mirror.has_value(); }

    /// The bounds of what is drawn, mirrored where the cage is.
    Bounds<double, 2> bounds() const noexcept {
        Bounds<double, 2> all = bounds_of(std::span<const Point>());
        for (const auto& s : figure_) {
            for (std::size_t k = 0; k < 2; ++k) {
                all.lower[k] = (std::min)({all.lower[k], s.a[k] - s.radius, s.b[k] - s.radius});
                all.upper[k] = (std::max)({all.upper[k], s.a[k] + s.radius, s.b[k] + s.radius});
            }
        }
        if (is_mirrored()) {
            all.upper[0] = (std::max)(all.upper[0], -all.lower[0]);
            all.lower[0] = -all.upper[0];
        }
        return all;
    }

    /// f about the figure, to 4 margins or 12 nodes. 256 nodes along the longer side, three to a small margin; the
    /// rim of 8 margins is room for vertices.
    Status fill_lattice(double level) {
        const auto box = bounds();
        const auto size = box.upper - box.lower;
        // Of few digits, so that places of nodes are exact and an axis is met.
        const double h = double(
            static_cast<float>((std::min)(((std::max)(size[0], size[1]) + 2 * level) / 256, level / 3)));
        Point low{};
        std::array<std::size_t, 2> count{};
        double nodes = 1;
        for (std::size_t k = 0; k < 2; ++k) {
            const double from = box.lower[k] - 8 * level, to = box.upper[k] + 8 * level;
            // Symmetric about an axis: a column of nodes lies on it.
            const bool centred = k == 0 && is_mirrored();
            const double side = centred ? 2 * std::ceil(to / h) : std::ceil((to - from) / h);
            low[k] = centred ? -h * std::ceil(to / h) : from;
            nodes *= side + 1;
            if (!(nodes <= double(most_lattice_nodes))) return Status::margin_too_small;
            count[k] = static_cast<std::size_t>(side) + 1;
        }
        const double band = (std::max)(4 * level, 12 * h);
        lattice_ = DistanceLattice<2>(low, h, count, band - level);
        for (const auto& s : figure_) lattice_.stamp(s.a, s.b, s.radius + level, band - level);
        if (options_.holes) {
            for (const auto& area : areas_)
                paint(lattice_, figure_.subspan(area.begin, area.end - area.begin), area.even_odd, level);
        }
        if (options_.shape == CageShape::hull)
            fill_hull(lattice_, [&](const Point& direction) { return reach(direction) + level; });
        if (is_mirrored()) lattice_.mirror();
        return Status::ok;
    }
    /// How far the figure reaches along a direction, mirrored where the cage is.
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

    /// What the outside does not reach is inside: pockets, and inner parts; large ones are holes where holes are wanted.
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

    /// Of a loop of the symmetric lattice: a loop that does not meet the axis whole if it lies to the right, else
    /// nothing; of one that meets it the chain on the right. A loop meets the axis twice, and in vertices: a symmetric
    /// area without holes has one piece of the axis, and a line of nodes lies there.
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

    /// 2 for a loop whose mirror image is another one.
    int copies_of(const CageLoop& loop) const noexcept { return is_mirrored() && !loop.half ? 2 : 1; }

    /// Vertices for each loop, by the roots of their areas: points of chains for halves. At least four, of a single loop
    /// three.
    std::vector<std::size_t> share_vertices() const {
        double sum = 0;
        const auto weight = [](const CageLoop& loop) {
            return std::sqrt(std::fabs(signed_area(loop.points)) * (loop.half ? 2 : 1));
        };
        std::vector<std::size_t> order(contours_.size()), shares(contours_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
            return weight(contours_[i]) < weight(contours_[j]);
        });
        for (const auto& loop : contours_) sum += copies_of(loop) * weight(loop);
        const double wanted = double(options_.vertices);
        const double least = contours_.size() == 1 ? 3 : 4;
        double given = 0, share = 0;
        for (const std::size_t k : order) { // what is rounded off or lent goes to the next larger ones
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
        if (copies_of(contours_[k]) > 1) obstacles.add({0, -4}, {0, 4}); // the axis: beyond it is the image
        return obstacles;
    }

    /// A contour with `vertices` points: from four states of the reduction, with some vertices left to be put in where
    /// the energy asks for them, the best one.
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

    /// Adds a loop, completed by the image of its half or followed by its image.
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
    std::vector<CageLoop> contours_; ///< from first to last replaced by what they are reduced to
};

/// The least distance between the edges of a cage and what is drawn; negative where something is not inside.
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

/// The smallest angle between neighbouring edges, in degrees.
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

/// What is wrong with the figure or what is asked for; `report` gets the culprit.
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

/// The frame of a figure, and the figure there.
struct FramedFigure {
    CageFrame<2> frame;
    Bounds<double, 2> box; ///< in the figure's own coordinates
    std::vector<DrawnSegment<double>> segments;
    double diagonal = 0; ///< of its bounds, in local units
};

template <Scalar T>
Status frame_figure(std::span<const DrawnSegment<T>> figure, const std::optional<MirrorPlane>& mirror,
                    FramedFigure& framed) {
    auto& box = framed.box;
    box = bounds_of(std::span<const Vec<double, 2>>());
    for (const auto& s : figure) {
        for (std::size_t k = 0; k < 2; ++k) {
            box.lower[k] = (std::min)(
                {box.lower[k], double(s.a[k]) - double(s.radius), double(s.b[k]) - double(s.radius)});
            box.upper[k] = (std::max)(
                {box.upper[k], double(s.a[k]) + double(s.radius), double(s.b[k]) + double(s.radius)});
        }
    }
    if (!(box.diagonal() > least_figure_diagonal<2>())) return Status::figure_has_no_size;
    auto& frame = framed.frame;
    frame = CageFrame<2>(box, mirror);
    for (const auto& s : figure)
        framed.segments.push_back({frame.to_local(vec_cast<double>(s.a)),
                                   frame.to_local(vec_cast<double>(s.b)), frame.scale * double(s.radius)});
    framed.diagonal = length(frame.scale * (box.upper - box.lower));
    return Status::ok;
}

/// Makes the cage, verifies it against the figure itself, and tries again from farther off where it is too
/// near.
template <Scalar T>
Status make_cage_into(std::span<const DrawnSegment<T>> figure, std::span<const PaintedArea> areas,
                      const MakeCageOptions& options, const Running& running,
                      Result<Polygon<T>, MakeCageReport>& made) {
    auto& report = made.report;
    Status status = check_figure(figure, areas, options, report);
    if (status != Status::ok) return status;
    FramedFigure framed;
    status = frame_figure(figure, options.mirror, framed);
    if (status != Status::ok) return status;
    MakeCageOptions wanted = options;
    if (wanted.vertices == 0) wanted.vertices = 24;
    const double margin = (options.margin > 0 ? options.margin : 0.025) * framed.diagonal;
    report.margin = margin / framed.frame.scale;
    if (!can_tell<T>(report.margin, framed.box)) return Status::cage_not_found;
    PlaneCageMaker maker(framed.segments, areas, wanted);
    std::vector<DrawnSegment<double>> exact; // in the figure's own coordinates
    for (const auto& s : figure)
        exact.push_back({vec_cast<double>(s.a), vec_cast<double>(s.b), double(s.radius)});
    double level = margin;
    constexpr std::size_t tries = 3;
    for (std::size_t round = 0; round < tries; ++round) {
        std::vector<Loop> loops;
        const std::array<double, 4> done{0, 0.9, 0.95, 1}; // few figures need a second try
        const Running part = running.part(done[round], done[round + 1]);
        status = maker.make(level, part, report, loops);
        if (status != Status::ok) return status;
        std::vector<Vec<T, 2>> vertices;
        std::vector<std::size_t> sizes;
        for (const auto& loop : loops) {
            for (const auto& p : loop) vertices.push_back(vec_cast<T>(framed.frame.from_local(p)));
            if (framed.frame.turns_over())
                std::reverse(vertices.end() - std::ptrdiff_t(loop.size()), vertices.end());
            sizes.push_back(loop.size());
        }
        made.value = Polygon<T>(vertices, sizes);
        report.cage = check(made.value);
        report.clearance = exact_clearance(made.value, std::span<const DrawnSegment<double>>(exact));
        if (holds_figure(report)) break;
        level += (std::max)(margin - report.clearance * framed.frame.scale, 0.1 * margin);
    }
    if (!running.keep_going(1)) return Status::cancelled;
    report.vertices = made.value.size();
    report.least_angle = least_angle(made.value);
    report.area = 0;
    for (const auto& loop : made.value.loops()) report.area += signed_area(made.value, loop);
    report.tightest_area /= framed.frame.scale * framed.frame.scale;
    return holds_figure(report) ? Status::ok : Status::cage_not_found;
}

} // namespace detail

/// A cage of few vertices about all that is drawn.
///
///   figure   a range of DrawnSegment, with radii not negative
///   drawing  the segments, and which of them are outlines of painted areas: options.holes needs these
///   returns  a loop of options.vertices vertices, counter-clockwise; with several loops each gets a share by the
///            root of its area, but four at least: report.vertices tells. It passes `check`, contains the figure exactly, and
///            report.clearance is at least 0.9 of the margin
///   parts    are joined by bridges 2.6 margins wide, along a shortest tree; slits narrower than 1.2 margins are closed
///   mirror   vertices of a cage come in pairs, but for those on the axis; the figure need not be symmetric
///   cost     some 50 ms for a drawing of a thousand segments; up to 70 bytes for each of at most 2^24 nodes of
///            a lattice, whose spacing is a 256th of the figure's longer side, and at most a third of the margin
///   errors   figure_empty; figure_not_finite, by segment; figure_has_no_size; margin_not_positive; margin_too_small;
///            too_few_cage_vertices; mirror_not_supported; index_out_of_range, by area; cancelled; out_of_memory;
///            cage_not_found, with the clearance of the last one tried
///
/// The same input gives the same cage; moved, or scaled by a power of two, it gives the cage moved and scaled, as
/// far as coordinates are not rounded.
template <Scalar T>
Result<Polygon<T>, MakeCageReport> make_cage(const Drawing<T>& drawing, const MakeCageOptions& options = {},
                                             const Running& running = {}) {
    Result<Polygon<T>, MakeCageReport> made;
    detail::run_into(made.report, [&] {
        return detail::make_cage_into(drawing.segments, drawing.areas, options, running, made);
    });
    if (!made) made.value = {};
    return made;
}

/// Encloses a range of DrawnSegment without painted areas.
template <std::ranges::contiguous_range R>
auto make_cage(const R& figure, const MakeCageOptions& options = {}, const Running& running = {})
    -> decltype(make_cage(Drawing(figure), options, running)) {
    return make_cage(Drawing(figure), options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
