#include "svg/affine_parts.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support::detail {

namespace {

constexpr std::size_t few_numbers = 40; // shorter paths take less than an animated transform, 600 bytes

/// Calls `visit` with corresponding control points of two paths with the same segments.
void visit_pairs(const Path& a, const Path& b, const auto& visit) {
    for (std::size_t k = 0; k < a.size(); ++k) {
        visit(a[k].start, b[k].start);
        for (std::size_t i = 0; i < a[k].segments.size(); ++i) {
            const Segment &s = a[k].segments[i], &t = b[k].segments[i];
            visit(s.p1, t.p1);
            visit(s.p2, t.p2);
            visit(s.p3, t.p3);
        }
    }
}

class PartFinder {
public:
    PartFinder(const Drawing& rest, const CurveDeformer& curves, std::size_t frames, double tolerance)
        : rest_(rest)
        , curves_(curves)
        , frames_(frames)
        , tolerance_(tolerance)
        , taken_(rest.shapes.size()) {
        for (std::size_t i = 0; i < rest.shapes.size(); ++i) paths_.push_back(curves.rest(i));
    }

    std::vector<AffinePart> run() {
        for (auto group = rest_.groups.rbegin(); group != rest_.groups.rend(); ++group) // outer groups first
            add({group->node, group->to_root, group->first, group->end});
        for (std::size_t i = 0; i < rest_.shapes.size(); ++i) {
            const DrawnShape& shape = rest_.shapes[i];
            if (!shape.is_box) add({shape.node, shape.to_root, i, i + 1}); // boxes always move affinely
        }
        return std::move(parts_);
    }

private:
    void add(AffinePart part) {
        if (part.first == part.end || taken_[part.first] || !can_be(part)) return;
        part.maps.resize(frames_);
        bool moves = false;
        for (std::size_t n = 0; n < frames_; ++n) {
            const std::size_t f = (n + frames_ / 2) % frames_; // middle first: motions often start at rest
            Motion motion;
            for (std::size_t i = part.first; i < part.end; ++i) motion.add(curves_.motion(i, f));
            const auto best = motion.best_map();
            if (!best || !is_within_tolerance(part, *best, f)) return;
            part.maps[f] = *best;
            moves = moves || motion.moved();
        }
        if (!moves) return;
        const auto from_root = inverse(part.to_root);
        for (std::size_t i = part.first; i < part.end; ++i) {
            part.box.add(bounds(paths_[i], *from_root));
            taken_[i] = true;
        }
        parts_.push_back(std::move(part));
    }

    bool can_be(const AffinePart& part) const {
        std::size_t numbers = 0;
        for (std::size_t i = part.first; i < part.end; ++i) {
            const DrawnShape& shape = rest_.shapes[i];
            if (taken_[i] || shape.level != 0 || shape.is_extent || has_markers(shape) ||
                (shape.has_dashes && shape.has_stroke) || !is_in(shape.node, part.node))
                return false;
            for (const Subpath& subpath : paths_[i]) {
                for (const Segment& s : subpath.segments) numbers += s.is_line() ? 2 : 6;
            }
        }
        return (numbers >= few_numbers || part.end - part.first > 1) && inverse(part.to_root) &&
               std::none_of(rest_.references.begin(), rest_.references.end(),
                            [&](const Reference& r) { return is_in(r.node, part.node); });
    }

    bool is_within_tolerance(const AffinePart& part, const Affine2& map, std::size_t frame) const {
        const double most = largest_scale(map), least = std::abs(map.a * map.d - map.b * map.c) / most;
        for (std::size_t i = part.first; i < part.end; ++i) {
            const DrawnShape& shape = rest_.shapes[i];
            const double half_width =
                shape.has_stroke ? shape.stroke_width / 2 * largest_scale(shape.to_root) : 0;
            const double left = tolerance_ - half_width * std::max(most - 1, 1 - least);
            bool good = left >= 0;
            if (!good) return false;
            visit_pairs(paths_[i], curves_.path(i, frame), [&](const Point2& p, const Point2& moved) {
                const Point2 q = apply(map, p);
                good = good && std::hypot(q.x - moved.x, q.y - moved.y) <= left;
            });
            if (!good) return false;
        }
        return true;
    }

    const Drawing& rest_; // its paths are not used
    const CurveDeformer& curves_;
    std::size_t frames_;
    double tolerance_;
    std::vector<Path> paths_; // at rest
    std::vector<bool> taken_;
    std::vector<AffinePart> parts_;
};

} // namespace

std::vector<AffinePart> affine_parts(const Drawing& rest, const CurveDeformer& curves, std::size_t frames,
                                     double tolerance) {
    return PartFinder(rest, curves, frames, tolerance).run();
}

} // namespace cageform_support::detail
