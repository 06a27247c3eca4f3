#pragma once

// Deforms paths. Curves and long lines are subdivided until they follow the deformed shape in all frames.

#include "io/csv.hpp"
#include "svg/document.hpp"
#include "svg/motion.hpp"
#include "svg/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support::detail {

/// Largest coordinate that is written; beyond it sums and products overflow.
constexpr double most_coordinate = 1e100;

inline bool in_range(const Point2& p, double most = most_coordinate) {
    return std::abs(p.x) <= most && std::abs(p.y) <= most;
}

inline bool in_range(const Path& path, double most = most_coordinate) {
    return std::all_of(path.begin(), path.end(), [most](const Subpath& subpath) {
        return in_range(subpath.start, most) &&
               std::all_of(subpath.segments.begin(), subpath.segments.end(), [most](const Segment& s) {
                   return in_range(s.p1, most) && in_range(s.p2, most) && in_range(s.p3, most);
               });
    });
}

/// The layer of a path's points, and the box in which they are visible.
struct PathRole {
    std::size_t layer = 0;
    Box seen;

    PointRole at(const Point2& p) const { return {layer, seen.contains({p.x, p.y, p.x, p.y})}; }
};

/// Deforms paths in one or more frames and approximates the result by cubics.
///
/// Every segment is sampled at equal steps of the parameter; the number of steps is a multiple of six. A
/// piece becomes the cubic through its samples at 0, 1/3, 2/3 and 1. If in any frame another sample is
/// farther than the tolerance from the cubic at the same parameter, the piece is halved in all frames. A line
/// that stays straight in all frames stays a line. All pieces of all paths are sampled together: the deformer
/// is called once per level of halving.
class CurveDeformer {
public:
    CurveDeformer(const FrameDeformer& deformer, std::size_t frames, double tolerance, double diagonal,
                  int max_halvings, DeformReport& report)
        : deformer_(deformer)
        , frames_(frames)
        , tolerance_(tolerance)
        , diagonal_(diagonal)
        , max_halvings_(max_halvings)
        , report_(report) {}

    /// Deforms all paths; false if the deformer returns false or there are too many points, see failure().
    ///
    ///   roles   #paths, passed to the deformer
    bool run(const std::vector<Path>& paths, std::vector<PathRole> roles) {
        roles_ = std::move(roles);
        lost_.resize(paths.size());
        for (std::size_t i = 0; i < paths.size(); ++i) {
            paths_.push_back({subpaths_.size(), subpaths_.size() + paths[i].size()});
            for (const Subpath& subpath : paths[i]) {
                const std::size_t first = curves_.size();
                Point2 from = subpath.start;
                for (const Segment& s : subpath.segments) {
                    const std::size_t places = frames_ * (steps(from, s) + 1);
                    pieces_.push_back({curves_.size(), 0, 1, 0, std::vector<Point2>(places), {}, false});
                    curves_.push_back({from, s, i});
                    from = s.p3;
                }
                subpaths_.push_back(
                    {subpath.start, i, subpath.closed, subpath.has_closing_line, first, curves_.size()});
            }
        }
        starts_.resize(frames_ * subpaths_.size());
        if (!sample(1)) return false;
        record_motions();
        for (std::size_t f = 0; f < frames_; ++f) {
            for (std::size_t k = 0; k < subpaths_.size(); ++k) {
                const auto& [start, path, closed, has_closing_line, first, end] = subpaths_[k];
                for (std::size_t i = first; i < end; ++i) {
                    samples_of(pieces_[i], f).front() =
                        i == first ? start_of(k, f) : samples_of(pieces_[i - 1], f).back();
                }
                if (closed && end > first) samples_of(pieces_[end - 1], f).back() = start_of(k, f);
            }
        }
        while (settle_all()) {
            if (!sample(2)) return false;
        }
        for (const Piece& piece : pieces_) report_.segments += is_lost(curves_[piece.curve].path) ? 0 : 1;
        return true;
    }

    const std::string& failure() const { return failure_; }

    /// Whether a deformed point of the path is not finite or out of range. Such a path has no pieces and
    /// counts as unmoved.
    bool is_lost(std::size_t index) const { return lost_[index]; }

    /// The deformed path in a frame.
    Path path(std::size_t index, std::size_t frame) const {
        return in_pieces(
            index, [&](std::size_t k) { return start_of(k, frame); },
            [&](const Piece& piece) { return piece.result[frame]; });
    }

    /// The deformed path in a frame with one cubic per original segment, with the tangents of the deformed
    /// segment at its ends. Its vertices are those of the file.
    Path path_of_vertices(std::size_t index, std::size_t frame) const {
        Path path;
        for (std::size_t k = paths_[index].first; k < paths_[index].second; ++k) {
            const PlacedSubpath& subpath = subpaths_[k];
            path.push_back({start_of(k, frame), {}, subpath.closed});
            std::vector<Segment>& segments = path.back().segments;
            each_piece(subpath, [&](const Piece& piece) {
                const Segment& s = piece.result[frame];
                const bool goes_on = piece.from > 0 || curves_[piece.curve].rest.goes_on;
                if (goes_on) {
                    segments.back() = {segments.back().p1, s.p2, s.p3};
                } else {
                    segments.push_back(s);
                }
            });
            // Z replaces only the closing line that it has added.
            if (subpath.closed && !segments.empty())
                segments.back().degree = subpath.has_closing_line ? 1 : 3;
        }
        return path;
    }

    /// The path at rest, subdivided as in all frames.
    Path rest(std::size_t index) const {
        return in_pieces(
            index, [&](std::size_t k) { return subpaths_[k].start; },
            [&](const Piece& piece) {
                const auto& [from, s, path] = curves_[piece.curve];
                return part_of(from, s, piece.from, piece.to);
            });
    }

    /// The motion of a path in a frame, from its initial samples.
    const Motion& motion(std::size_t index, std::size_t frame) const {
        static const Motion none;
        return is_lost(index) ? none : motions_[index * frames_ + frame];
    }

private:
    struct Curve {
        Point2 p0;
        Segment rest;
        std::size_t path = 0;
    };

    struct PlacedSubpath {
        Point2 start; // at rest
        std::size_t path = 0;
        bool closed = false, has_closing_line = false;
        std::size_t first = 0, end = 0; // its curves
    };

    struct Piece {
        std::size_t curve = 0;
        double from = 0; // parameter range on the curve
        double to = 1;
        int halvings = 0;
        std::vector<Point2> samples; // deformed, frame by frame, at equal steps from `from` to `to`
        std::vector<Segment> result; // #frames, once settled
        bool settled = false;
    };

    Path in_pieces(std::size_t index, const auto& start, const auto& segment) const {
        Path path;
        for (std::size_t k = paths_[index].first; k < paths_[index].second && !is_lost(index); ++k) {
            const PlacedSubpath& subpath = subpaths_[k];
            path.push_back({start(k), {}, subpath.closed});
            each_piece(subpath, [&](const Piece& piece) { path.back().segments.push_back(segment(piece)); });
        }
        return path;
    }

    void each_piece(const PlacedSubpath& subpath, const auto& visit) const {
        const auto before = [](const Piece& piece, std::size_t curve) { return piece.curve < curve; };
        for (auto piece = std::lower_bound(pieces_.begin(), pieces_.end(), subpath.first, before);
             piece != pieces_.end() && piece->curve < subpath.end; ++piece)
            visit(*piece);
    }

    static double distance(const Point2& a, const Point2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

    Point2& start_of(std::size_t subpath, std::size_t frame) {
        return starts_[frame * subpaths_.size() + subpath];
    }
    const Point2& start_of(std::size_t subpath, std::size_t frame) const {
        return starts_[frame * subpaths_.size() + subpath];
    }

    std::span<Point2> samples_of(Piece& piece, std::size_t frame) const {
        const std::size_t n = piece.samples.size() / frames_;
        return std::span(piece.samples).subspan(frame * n, n);
    }
    std::span<const Point2> samples_of(const Piece& piece, std::size_t frame) const {
        const std::size_t n = piece.samples.size() / frames_;
        return std::span(piece.samples).subspan(frame * n, n);
    }

    /// Number of steps: 6 to 1536, each at most 1/64 of the diagonal if possible, so that narrow bulges are
    /// not missed.
    std::size_t steps(const Point2& from, const Segment& s) const {
        const double length = distance(from, s.p1) + distance(s.p1, s.p2) + distance(s.p2, s.p3);
        std::size_t n = 6;
        while (n < 1536 && 64 * length > diagonal_ * static_cast<double>(n)) n *= 2;
        return n;
    }

    /// Deforms samples 1, 1 + stride, … of every unsettled piece; with stride 1, also the starts.
    bool sample(std::size_t stride) {
        std::vector<Point2> in;
        std::vector<PointRole> roles;
        std::vector<std::size_t> paths; // of the points
        const auto add = [&](const Point2& p, std::size_t path) {
            in.push_back(p);
            roles.push_back(roles_[path].at(p));
            paths.push_back(path);
        };
        if (stride == 1) {
            for (const PlacedSubpath& subpath : subpaths_) add(subpath.start, subpath.path);
        }
        for (const Piece& piece : pieces_) {
            if (piece.settled) continue;
            const Curve& curve = curves_[piece.curve];
            const std::size_t n = piece.samples.size() / frames_;
            for (std::size_t i = 1; i < n; i += stride) {
                const double t = piece.from + (piece.to - piece.from) *
                                                  (static_cast<double>(i) / static_cast<double>(n - 1));
                add(place_on(curve.p0, curve.rest, t), curve.path);
            }
        }
        if (in.empty()) return true;
        if (in.size() > most_places / frames_) {
            failure_ =
                std::to_string(in.size()) + " points in " + counted(frames_, "frame") + " are too many";
            return false;
        }
        std::vector<Point2> out(frames_ * in.size());
        report_.points += in.size();
        report_.batches += 1;
        if (!deformer_(in, roles, out)) {
            failure_ = "the deformation was stopped";
            return false;
        }
        for (std::size_t i = 0; i < out.size(); ++i) {
            if (!in_range(out[i])) lost_[paths[i % in.size()]] = true;
        }
        for (std::size_t f = 0; f < frames_; ++f) {
            const Point2* next = out.data() + f * in.size();
            if (stride == 1) {
                for (std::size_t k = 0; k < subpaths_.size(); ++k) start_of(k, f) = *next++;
            }
            for (Piece& piece : pieces_) {
                if (piece.settled) continue;
                const std::span<Point2> samples = samples_of(piece, f);
                for (std::size_t i = 1; i < samples.size(); i += stride) samples[i] = *next++;
            }
        }
        return true;
    }

    /// Records the motion of all samples. Starts have no weight: they repeat the end of a closed path or have
    /// no length.
    void record_motions() {
        motions_.resize(paths_.size() * frames_);
        for (std::size_t p = 0; p < paths_.size(); ++p) {
            for (std::size_t k = paths_[p].first; k < paths_[p].second; ++k) {
                Motion* const motions = &motions_[p * frames_];
                for (std::size_t f = 0; f < frames_; ++f)
                    motions[f].add(subpaths_[k].start, start_of(k, f), 0);
                for (std::size_t c = subpaths_[k].first; c < subpaths_[k].end; ++c)
                    add_motion(pieces_[c], motions);
            }
        }
    }

    /// Adds the motion of a piece that is a whole curve.
    void add_motion(const Piece& piece, Motion* motions) const {
        const Curve& curve = curves_[piece.curve];
        const std::size_t n = piece.samples.size() / frames_;
        Point2 from = curve.p0;
        for (std::size_t i = 1; i < n; ++i) {
            const Point2 rest =
                place_on(curve.p0, curve.rest, static_cast<double>(i) / static_cast<double>(n - 1));
            for (std::size_t f = 0; f < frames_; ++f)
                motions[f].add(rest, piece.samples[f * n + i], distance(from, rest));
            from = rest;
        }
    }

    /// Settles or halves all pieces; true if some were halved and need more samples.
    bool settle_all() {
        std::vector<Piece> next;
        next.reserve(pieces_.size());
        for (Piece& piece : pieces_) {
            piece.settled = piece.settled || is_lost(curves_[piece.curve].path);
            if (piece.settled) {
                next.push_back(std::move(piece));
            } else {
                settle(piece, 0, piece.samples.size() / frames_ - 1, next);
                piece.samples = {};
            }
        }
        pieces_ = std::move(next);
        return std::any_of(pieces_.begin(), pieces_.end(), [](const Piece& p) { return !p.settled; });
    }

    void settle(const Piece& piece, std::size_t first, std::size_t last, std::vector<Piece>& next) {
        const std::size_t n = last - first;
        const auto samples = [&](std::size_t frame) {
            return samples_of(piece, frame).subspan(first, n + 1);
        };
        const auto in_all_frames = [&](const auto& holds) {
            for (std::size_t f = 0; f < frames_; ++f) {
                if (!holds(samples(f))) return false;
            }
            return true;
        };
        const std::size_t intervals = piece.samples.size() / frames_ - 1;
        const auto steps = static_cast<double>(intervals);
        const double size = piece.to - piece.from;
        Piece part{piece.curve,
                   piece.from + size * (static_cast<double>(first) / steps),
                   piece.from + size * (static_cast<double>(last) / steps),
                   piece.halvings,
                   {},
                   {},
                   true};
        const Curve& curve = curves_[piece.curve];
        const double short_handle = 10 * tolerance_;
        const bool starts = first == 0 && piece.from == 0;
        const bool ends = last + 1 == piece.samples.size() / frames_ && piece.to == 1;
        const Stops stops{starts && distance(curve.p0, curve.rest.p1) <= short_handle,
                          ends && distance(curve.rest.p2, curve.rest.p3) <= short_handle};
        const auto take = [&](const auto& through) {
            for (std::size_t f = 0; f < frames_; ++f) part.result.push_back(through(samples(f)));
            next.push_back(std::move(part));
        };
        const auto cubic = [&](std::span<const Point2> p) { return cubic_through(p, stops); };
        const bool full = next.size() >= most_pieces || next.size() * frames_ >= most_segments;
        if (curve.rest.is_line() && in_all_frames([&](auto p) { return is_straight(p); })) {
            take(line_through);
        } else if (in_all_frames([&](auto p) { return is_near(p, cubic(p)); })) {
            take(cubic);
        } else if (n > 6) {
            settle(piece, first, first + n / 2, next);
            settle(piece, first + n / 2, last, next);
        } else if (piece.halvings >= max_halvings_ || full ||
                   !in_all_frames([&](auto p) { return !is_rounded(p); })) {
            ++report_.coarse;
            take(cubic);
        } else {
            part.settled = false;
            part.halvings += 1;
            part.samples.resize(frames_ * (2 * n + 1));
            for (std::size_t f = 0; f < frames_; ++f) {
                const std::span<Point2> finer = samples_of(part, f);
                for (std::size_t i = 0; i <= n; ++i) finer[2 * i] = samples(f)[i];
            }
            next.push_back(std::move(part));
        }
    }

    /// Limits: above them no piece is halved.
    static constexpr std::size_t most_pieces = 1u << 20, most_segments = 1u << 22;
    static constexpr std::size_t most_places = 1u << 27; // of samples in all frames

    /// Whether rounding errors of the coordinates exceed the tolerance.
    bool is_rounded(std::span<const Point2> samples) const {
        return std::any_of(samples.begin(), samples.end(), [&](const Point2& p) {
            return 0x1p-50 * std::max(std::abs(p.x), std::abs(p.y)) > tolerance_;
        });
    }

    /// Whether a curve's control points coincide with its ends, so that its derivative vanishes there.
    struct Stops {
        bool at_start = false, at_end = false;
    };

    bool is_straight(std::span<const Point2> samples) const {
        return std::all_of(samples.begin(), samples.end(), [&](const Point2& p) {
            return distance_to_chord(p, samples.front(), samples.back()) <= tolerance_;
        });
    }

    static Segment line_through(std::span<const Point2> samples) {
        const Point2 &a = samples.front(), &d = samples.back();
        return {{(2 * a.x + d.x) / 3, (2 * a.y + d.y) / 3}, {(a.x + 2 * d.x) / 3, (a.y + 2 * d.y) / 3}, d, 1};
    }

    /// If the derivative of the curve vanishes at one end, that of the cubic vanishes there too. Otherwise
    /// rounding would determine the tangent, which is visible in strokes.
    static Segment cubic_through(std::span<const Point2> samples, Stops stops) {
        const std::size_t n = samples.size() - 1;
        const Point2& a = samples[0];
        const Point2& b = samples[n / 3];
        const Point2& c = samples[2 * n / 3];
        const Point2& d = samples[n];
        Segment cubic{
            {(-5 * a.x + 18 * b.x - 9 * c.x + 2 * d.x) / 6, (-5 * a.y + 18 * b.y - 9 * c.y + 2 * d.y) / 6},
            {(2 * a.x - 9 * b.x + 18 * c.x - 5 * d.x) / 6, (2 * a.y - 9 * b.y + 18 * c.y - 5 * d.y) / 6},
            d};
        if (stops.at_start != stops.at_end) {
            const Point2 control = control_of_stopping(samples, stops.at_start);
            cubic.p1 = stops.at_start ? a : control;
            cubic.p2 = stops.at_start ? control : d;
        }
        return cubic;
    }

    /// Whether all samples are within the tolerance of the segment.
    bool is_near(std::span<const Point2> samples, const Segment& segment) const {
        const std::size_t n = samples.size() - 1;
        for (std::size_t i = 0; i <= n; ++i) {
            const double t = static_cast<double>(i) / static_cast<double>(n);
            if (!(distance(place_on(samples[0], segment, t), samples[i]) <= tolerance_)) return false;
        }
        return true;
    }

    /// The remaining control point of a cubic whose derivative vanishes at one end, by least squares.
    static Point2 control_of_stopping(std::span<const Point2> samples, bool at_start) {
        const std::size_t n = samples.size() - 1;
        Point2 sum;
        double square = 0;
        for (std::size_t i = 0; i <= n; ++i) {
            const double t = static_cast<double>(i) / static_cast<double>(n);
            const double u = 1 - t;
            const double free = at_start ? 3 * u * t * t : 3 * u * u * t;
            const double first = u * u * u + (at_start ? 3 * u * u * t : 0);
            const double last = t * t * t + (at_start ? 0 : 3 * u * t * t);
            sum.x += free * (samples[i].x - first * samples[0].x - last * samples[n].x);
            sum.y += free * (samples[i].y - first * samples[0].y - last * samples[n].y);
            square += free * free;
        }
        return {sum.x / square, sum.y / square};
    }

    static double distance_to_chord(const Point2& p, const Point2& a, const Point2& b) {
        const double length = distance(a, b);
        if (length == 0) return distance(p, a);
        const Point2 along{(b.x - a.x) / length, (b.y - a.y) / length};
        const double reach = std::clamp((p.x - a.x) * along.x + (p.y - a.y) * along.y, 0.0, length);
        return distance(p, {a.x + reach * along.x, a.y + reach * along.y});
    }

    const FrameDeformer& deformer_;
    std::size_t frames_;
    double tolerance_;
    double diagonal_;
    int max_halvings_;
    DeformReport& report_;
    std::vector<PathRole> roles_;
    std::vector<bool> lost_;
    std::vector<std::pair<std::size_t, std::size_t>> paths_; // the subpaths of each, first and end
    std::vector<PlacedSubpath> subpaths_;
    std::vector<Point2> starts_; // of all subpaths, frame by frame
    std::vector<Curve> curves_;
    std::vector<Motion> motions_; // of all frames, path by path
    std::vector<Piece> pieces_;   // in the order of the curves and along each
    std::string failure_;
};

} // namespace cageform_support::detail
