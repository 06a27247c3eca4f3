#pragma once

// Best affine map of a motion, from accumulated moments.

#include "svg/path.hpp"

#include <optional>

namespace cageform_support::detail {

/// Moments of the points of a shape at rest and moved, weighted by length.
class Motion {
public:
    void add(const Point2& rest, const Point2& moved, double weight);
    void add(const Motion& other);

    /// Whether any point has moved.
    bool moved() const { return moved_; }

    /// The least-squares affine map from the points at rest to the moved points, regularised towards the best
    /// similarity. If the points at rest are on a line, or their spread across a line is small compared with
    /// the residual, the similarity determines the map across that line. If the map is nearly singular, the
    /// similarity is returned; nothing if all points coincide after the motion.
    std::optional<Affine2> best_map() const;

private:
    void merge(const Point2& rest, const Point2& moved, double weight);

    double weight_ = 0;
    Point2 rest_mean_, moved_mean_;
    double xx_ = 0, xy_ = 0, yy_ = 0; // second moments at rest, about the mean
    double mixed_xx_ = 0, mixed_xy_ = 0, mixed_yx_ = 0, mixed_yy_ = 0; // moved times rest
    double square_ = 0;                                                // of moved
    bool moved_ = false;
};

} // namespace cageform_support::detail
