#pragma once

// Paths under a deformation: curves and long lines are refined until they follow the deformed shape.

#include "svg_document.hpp"
#include "svg_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace cageform_examples {

namespace detail {

/// What may be written: beyond it sums and products of coordinates overflow.
inline bool in_range(const Point2& p) {
    return std::abs(p.x) <= 1e100 && std::abs(p.y) <= 1e100;
}

inline bool in_range(const Path& path) {
    return std::all_of(path.begin(), path.end(), [](const Subpath& subpath) {
        return in_range(subpath.start) &&
               std::all_of(subpath.segments.begin(), subpath.segments.end(), [](const Segment& s) {
                   return in_range(s.p1) && in_range(s.p2) && in_range(s.p3);
               });
    });
}

/// Deforms paths and covers the result with cubics. Every segment is sampled at equal steps, a multiple of
/// six; a piece takes the cubic through its samples at 0, 1/3, 2/3 and 1 if all other samples are within
/// the tolerance of it at the same parameter, and is halved otherwise. A line that stays straight stays one.
/// All pieces of all paths go to the deformer together, so there are only as many calls as halvings.
class CurveDeformer {
public:
    CurveDeformer(const Deformer& deformer, double tolerance, double diagonal, int max_halvings,
                  DeformReport& report)
        : deformer_(deformer)
        , tolerance_(tolerance)
        , diagonal_(diagonal)
        , max_halvings_(max_halvings)
        , report_(report) {}

    /// In place; false if the deformer stopped or gave a point out of range: see `failure()`.
    bool run(std::vector<Path>& paths) {
        std::vector<Point2> starts;
        std::vector<std::size_t> piece_counts; // of each subpath, before halving
        for (const Path& path : paths) {
            for (const Subpath& subpath : path) {
                starts.push_back(subpath.start);
                piece_counts.push_back(subpath.segments.size());
                Point2 from = subpath.start;
                for (const Segment& s : subpath.segments) {
                    curves_.push_back({from, s});
                    pieces_.push_back(
                        {curves_.size() - 1, 0, 1, 0, std::vector<Point2>(steps(from, s) + 1), {}, false});
                    from = s.p3;
                }
            }
        }
        if (!sample(1, starts)) return false;
        record_motions(paths, starts);
        std::size_t first = 0;
        std::size_t next_subpath = 0;
        for (const Path& path : paths) {
            for (const Subpath& subpath : path) {
                const std::size_t end = first + piece_counts[next_subpath];
                const Point2 start = starts[next_subpath++];
                for (std::size_t i = first; i < end; ++i) {
                    pieces_[i].samples.front() = i == first ? start : pieces_[i - 1].samples.back();
                }
                if (subpath.closed && end > first) pieces_[end - 1].samples.back() = start;
                first = end;
            }
        }

        while (settle_all()) {
            std::vector<Point2> none;
            if (!sample(2, none)) return false;
        }
        report_.segments += pieces_.size();
        std::size_t curve = 0;
        std::size_t piece = 0;
        next_subpath = 0;
        for (Path& path : paths) {
            for (Subpath& subpath : path) {
                subpath.start = starts[next_subpath];
                curve += piece_counts[next_subpath++];
                subpath.segments.clear();
                for (; piece < pieces_.size() && pieces_[piece].curve < curve; ++piece) {
                    subpath.segments.push_back(pieces_[piece].result);
                }
            }
        }
        return true;
    }

    const std::string& failure() const { return failure_; }

    /// Of every path, from its first samples.
    const std::vector<Motion>& motions() const { return motions_; }

private:
    struct Curve {
        Point2 p0;
        Segment rest;
    };

    struct Piece {
        std::size_t curve = 0;
        double from = 0; // the part of the curve
        double to = 1;
        int halvings = 0;
        std::vector<Point2> samples; // deformed, at equal steps from `from` to `to`
        Segment result;              // once settled
        bool settled = false;
    };

    static double distance(const Point2& a, const Point2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

    /// At least six; so many that none is longer than a 64th of the diagonal, lest a narrow bulge be missed.
    std::size_t steps(const Point2& from, const Segment& s) const {
        const double length = distance(from, s.p1) + distance(s.p1, s.p2) + distance(s.p2, s.p3);
        std::size_t n = 6;
        while (n < 1536 && 64 * length > diagonal_ * static_cast<double>(n)) n *= 2;
        return n;
    }

    /// Deforms `extra` in place, and the samples 1, 1 + stride, ... of every piece not settled.
    bool sample(std::size_t stride, std::vector<Point2>& extra) {
        std::vector<Point2> in = extra;
        for (const Piece& piece : pieces_) {
            if (piece.settled) continue;
            const Curve& curve = curves_[piece.curve];
            const auto n = static_cast<double>(piece.samples.size() - 1);
            for (std::size_t i = 1; i < piece.samples.size(); i += stride) {
                const double t = piece.from + (piece.to - piece.from) * (static_cast<double>(i) / n);
                in.push_back(place_on(curve.p0, curve.rest, t));
            }
        }
        if (in.empty()) return true;
        std::vector<Point2> out(in.size());
        report_.points += in.size();
        report_.batches += 1;
        if (!deformer_(in, out)) {
            failure_ = "the deformation was stopped";
            return false;
        }
        if (!std::all_of(out.begin(), out.end(), [](const Point2& p) { return in_range(p); })) {
            failure_ = "the deformation gave a point that is not finite, or out of range";
            return false;
        }
        auto next = out.begin();
        for (Point2& p : extra) p = *next++;
        for (Piece& piece : pieces_) {
            if (piece.settled) continue;
            for (std::size_t i = 1; i < piece.samples.size(); i += stride) piece.samples[i] = *next++;
        }
        return true;
    }

    /// Of all samples but the starts, each of which is a closed path's end again, or of no length.
    void record_motions(const std::vector<Path>& paths, const std::vector<Point2>& starts) {
        std::size_t piece = 0;
        std::size_t next_subpath = 0;
        for (const Path& path : paths) {
            Motion motion;
            for (const Subpath& subpath : path) {
                motion.add(subpath.start, starts[next_subpath++], 0);
                Point2 from = subpath.start;
                for (std::size_t n = subpath.segments.size(); n > 0; --n, ++piece) {
                    const Curve& curve = curves_[pieces_[piece].curve];
                    const std::vector<Point2>& samples = pieces_[piece].samples;
                    for (std::size_t i = 1; i < samples.size(); ++i) {
                        const double t = static_cast<double>(i) / static_cast<double>(samples.size() - 1);
                        const Point2 rest = place_on(curve.p0, curve.rest, t);
                        motion.add(rest, samples[i], distance(from, rest));
                        from = rest;
                    }
                }
            }
            motions_.push_back(motion);
        }
    }

    /// True if some pieces were halved and need more samples.
    bool settle_all() {
        std::vector<Piece> next;
        next.reserve(pieces_.size());
        for (Piece& piece : pieces_) {
            if (piece.settled) {
                next.push_back(std::move(piece));
            } else {
                settle(piece, 0, piece.samples.size() - 1, next);
            }
        }
        pieces_ = std::move(next);
        return std::any_of(pieces_.begin(), pieces_.end(), [](const Piece& p) { return !p.settled; });
    }

    void settle(const Piece& piece, std::size_t first, std::size_t last, std::vector<Piece>& next) {
        const std::size_t n = last - first;
        const std::span<const Point2> samples(piece.samples.data() + first, n + 1);
        const auto steps = static_cast<double>(piece.samples.size() - 1);
        const double size = piece.to - piece.from;
        Piece part{piece.curve,
                   piece.from + size * (static_cast<double>(first) / steps),
                   piece.from + size * (static_cast<double>(last) / steps),
                   piece.halvings,
                   {},
                   {},
                   true};
        const Curve& curve = curves_[piece.curve];
        const bool starts = first == 0 && piece.from == 0;
        const bool ends = last + 1 == piece.samples.size() && piece.to == 1;
        const double short_handle = 10 * tolerance_;
        const bool stops_at_start = starts && distance(curve.p0, curve.rest.p1) <= short_handle;
        const bool stops_at_end = ends && distance(curve.rest.p2, curve.rest.p3) <= short_handle;
        if (fit(samples, curve.rest.is_line, stops_at_start, stops_at_end, part.result)) {
            next.push_back(std::move(part));
        } else if (n > 6) {
            settle(piece, first, first + n / 2, next);
            settle(piece, first + n / 2, last, next);
        } else if (piece.halvings >= max_halvings_ || next.size() >= most_pieces || is_rounded(samples)) {
            ++report_.coarse;
            next.push_back(std::move(part));
        } else {
            part.settled = false;
            part.halvings += 1;
            part.samples.resize(2 * n + 1);
            for (std::size_t i = 0; i <= n; ++i) part.samples[2 * i] = samples[i];
            next.push_back(std::move(part));
        }
    }

    /// Pieces of a document beyond which none is halved.
    static constexpr std::size_t most_pieces = 1u << 20;

    /// Whether coordinates are so large that rounding alone is more than the tolerance.
    bool is_rounded(std::span<const Point2> samples) const {
        return std::any_of(samples.begin(), samples.end(), [&](const Point2& p) {
            return 0x1p-50 * std::max(std::abs(p.x), std::abs(p.y)) > tolerance_;
        });
    }

    /// The line or cubic for these samples, and whether it is within the tolerance of all of them. Where the
    /// curve stops (its control point lies on its end), the cubic does too: its direction there would be that
    /// of rounding, which strokes show.
    bool fit(std::span<const Point2> samples, bool was_line, bool stops_at_start, bool stops_at_end,
             Segment& result) const {
        const std::size_t n = samples.size() - 1;
        const Point2& a = samples[0];
        const Point2& b = samples[n / 3];
        const Point2& c = samples[2 * n / 3];
        const Point2& d = samples[n];
        if (was_line && std::all_of(samples.begin(), samples.end(), [&](const Point2& p) {
                return distance_to_chord(p, a, d) <= tolerance_;
            })) {
            result = {{(2 * a.x + d.x) / 3, (2 * a.y + d.y) / 3},
                      {(a.x + 2 * d.x) / 3, (a.y + 2 * d.y) / 3},
                      d,
                      true};
            return true;
        }
        result = {
            {(-5 * a.x + 18 * b.x - 9 * c.x + 2 * d.x) / 6, (-5 * a.y + 18 * b.y - 9 * c.y + 2 * d.y) / 6},
            {(2 * a.x - 9 * b.x + 18 * c.x - 5 * d.x) / 6, (2 * a.y - 9 * b.y + 18 * c.y - 5 * d.y) / 6},
            d,
            false};
        if (stops_at_start != stops_at_end) {
            const Point2 control = control_of_stopping(samples, stops_at_start);
            result.p1 = stops_at_start ? a : control;
            result.p2 = stops_at_start ? control : d;
        }
        for (std::size_t i = 0; i <= n; ++i) {
            const double t = static_cast<double>(i) / static_cast<double>(n);
            if (!(distance(place_on(a, result, t), samples[i]) <= tolerance_)) return false;
        }
        return true;
    }

    /// The control point that is left of a cubic that stops at one end, by least squares.
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

    const Deformer& deformer_;
    double tolerance_;
    double diagonal_;
    int max_halvings_;
    DeformReport& report_;
    std::vector<Curve> curves_;
    std::vector<Motion> motions_;
    std::vector<Piece> pieces_; // in the order of the curves and along each
    std::string failure_;
};

} // namespace detail

} // namespace cageform_examples
