#pragma once

// How the points of a shape have moved, in short: the affine map that is nearest to it.

#include "svg/path.hpp"

#include <optional>

namespace cageform_support::detail {

/// Sums over the points of a shape at rest and moved, weighted by the length they stand for.
class Motion {
public:
    void add(const Point2& rest, const Point2& moved, double weight);
    void add(const Motion& other);

    /// Whether any point moved at all.
    bool moved() const { return moved_; }

    /// The affine map from the points at rest to the moved points that misses them by the least sum of
    /// squares. Where the points lie along one line, the map across it is taken from the best turn and
    /// scale; so it is the more, the less the points spread across it compared with what the map misses
    /// them by. Nothing where all have come to one place or the map would flatten the plane.
    std::optional<Affine2> best_map() const;

private:
    void merge(const Point2& rest, const Point2& moved, double weight);

    double weight_ = 0;
    Point2 rest_mean_, moved_mean_;
    double xx_ = 0, xy_ = 0, yy_ = 0; // second moments at rest, about the mean
    double mixed_xx_ = 0, mixed_xy_ = 0, mixed_yx_ = 0, mixed_yy_ = 0; // of moved by rest
    double square_ = 0;                                                // of moved
    bool moved_ = false;
};

} // namespace cageform_support::detail
