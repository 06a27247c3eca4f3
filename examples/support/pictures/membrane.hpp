#pragma once

// A smooth function over a region of pixels from its values on the outline, by mean value coordinates: the
// membrane of instant image cloning (Farbman, Hoffer, Lipman, Cohen-Or, Lischinski, Coordinates for instant
// image cloning, ACM Trans. Graph. 28(3) (2009)).

#include "pictures/pixels.hpp"

#include <cageform/figure/binding.hpp>
#include <cageform/parallel/running.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform_support {

struct MembraneOptions {
    /// A stretch of the outline counts as one vertex, at its mean, where its box is at most this part of its
    /// distance; 0: each pixel counts for itself (the paper, sec. 4: hierarchical sampling of the boundary).
    double coarseness = 0.25;
    /// A square of pixels is interpolated from its corners where its side is at most this part of its
    /// distance from the outline; 0: each pixel has a value of its own.
    double square = 0.5;
};

/// Counts of a membrane.
struct MembraneReport {
    std::size_t loops = 0;    ///< of the outline
    std::size_t vertices = 0; ///< of all loops
    std::size_t parts = 0;    ///< of the region, each with an outline of its own
    std::size_t points = 0;   ///< that have weights
    std::size_t weights = 0;  ///< of all points
    std::size_t groups = 0;   ///< of points that see the outline alike, each a binding
};

/// The membrane of a region: bound once, then cheap for any values.
///
/// The outline runs through the centres of its pixels, to a fiftieth of a pixel. Squares of pixels have
/// values at their corners; the farther from the outline, the larger they are. `bind` gives these points
/// weights by mean value coordinates, and `clone` moves three numbers of the outline, colours instead of
/// places, to them. Pixels that touch over a side are one part; parts do not see each other.
///
/// Constants are reproduced to rounding, linear functions to 0.02 pixels as a rule. Other functions differ
/// from the exact mean value interpolant by less than 1 % of the outline's range in the mean, where they vary
/// over tens of pixels.
class Membrane {
public:
    using Values = cageform::Vec<float, 3>;

    /// The cost is about O(#outline · log #outline) weights, and O(#pixels).
    ///
    ///   fails   where the region has no pixel inside
    static Expected<Membrane> bind(const PixelRegion& region, const MembraneOptions& options = {},
                                   const cageform::ParallelFor& parallel = cageform::SerialFor{});

    /// Calls sink(first, count, start, step) for every run of pixels of a row inside: pixel first + i of the
    /// region's box has start + i · step. Calls come in any order, and on several threads.
    ///
    ///   outline   finite values of the region's outline, in its order
    template <class Sink>
    void interpolate(std::span<const Values> outline, const Sink& sink) {
        find_corners(outline);
        parallel_(squares_.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                const Square& square = squares_[n];
                if (square.side == 1) {
                    sink(square.first, std::size_t(1), values_[square.corners[0]], Values{});
                    continue;
                }
                const auto& [a, b, c, d] = square.corners;
                const float part = 1 / float(square.side);
                for (std::uint32_t row = 0; row < square.side; ++row) {
                    const float t = float(row) * part;
                    const Values left = values_[a] + t * (values_[c] - values_[a]),
                                 right = values_[b] + t * (values_[d] - values_[b]);
                    sink(square.first + row * width_, std::size_t(square.side), left, part * (right - left));
                }
            }
        });
    }

    const MembraneReport& report() const { return report_; }

private:
    friend class MembraneBuilder;

    /// A square of pixels: interpolated from the points at its corners, of which three belong to its
    /// neighbours. A single pixel has one point.
    struct Square {
        std::size_t first = 0; // pixel of the box
        std::uint32_t side = 1;
        std::array<std::uint32_t, 4> corners{};
    };
    /// A stretch of a loop: a leaf is one vertex. Its left half follows it.
    struct Stretch {
        std::uint32_t right = 0;    // half; 0 of a leaf
        std::uint32_t vertices = 1; // of a leaf: the number of its pixel on the outline
    };
    struct Group {
        cageform::Binding<float, 3> binding;
        std::vector<std::uint32_t> handles; // stretches
        std::vector<std::uint32_t> points;
    };
    /// A point in the middle of a larger square's side has the mean of that side's ends.
    struct Hanging {
        std::uint32_t point, one, other;
    };

    void find_corners(std::span<const Values> outline);

    std::size_t width_ = 0;
    std::vector<Square> squares_;
    std::vector<Stretch> stretches_;
    std::vector<Values> stretch_values_, values_; // by stretch, by point
    std::vector<Group> groups_;
    std::vector<Hanging> hanging_; // in the order in which they are found
    cageform::ParallelFor parallel_;
    MembraneReport report_;
};

} // namespace cageform_support
