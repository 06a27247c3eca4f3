#pragma once

// Interpolates values on the outline of a region of pixels by mean value coordinates: the membrane of instant
// image cloning (Farbman, Hoffer, Lipman, Cohen-Or, Lischinski, Coordinates for instant image cloning, ACM
// Trans. Graph. 28(3) (2009)).

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
    /// Hierarchical boundary sampling (the paper, section 4): a section of the outline is replaced by its
    /// mean if the diagonal of its box is at most this fraction of its distance from the point; 0: never.
    double coarseness = 0.25;
    /// A square of pixels is interpolated from its corners if its side is at most this fraction of its
    /// distance from the outline; 0: never.
    double square = 0.5;
};

/// Counts of a membrane.
struct MembraneReport {
    std::size_t loops = 0;    ///< of the outline
    std::size_t vertices = 0; ///< of all loops
    std::size_t parts = 0;    ///< of the region, each with an outline of its own
    std::size_t points = 0;   ///< with weights
    std::size_t weights = 0;  ///< of all points
    std::size_t groups = 0;   ///< of points with the same outline approximation, one binding each
};

/// The membrane of a region: bind once, then interpolate any values cheaply.
///
/// The outline passes through the centres of its pixels, to 1/50 of a pixel. Interior squares, larger far
/// from the outline, have values at their corners. bind() computes mean value weights for these points;
/// interpolate() applies the weights to colours. Pixels that share an edge belong to the same part; parts are
/// independent.
///
/// Constants are reproduced to rounding, linear functions usually to 0.02 pixels. For functions that vary
/// over tens of pixels, the mean difference from exact mean value interpolation is below 1 % of the outline's
/// range.
class Membrane {
public:
    using Values = cageform::Vec<float, 3>;

    /// Computes the weights: about O(#outline · log #outline) weights, and O(#pixels).
    ///
    ///   fails   if the region has no pixel inside
    static Expected<Membrane> bind(const PixelRegion& region, const MembraneOptions& options = {},
                                   const cageform::ParallelFor& parallel = cageform::SerialFor{});

    /// Calls sink(first, count, start, step) for every horizontal run of inner pixels: pixel first + i of the
    /// region's box has the value start + i · step. Calls are in any order, and from several threads.
    ///
    ///   outline   finite values, in the order of the region's outline
    ///   cost      O(#weights + #pixels)
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

    /// A square of pixels, interpolated from points at its corners. A single pixel has one point.
    struct Square {
        std::size_t first = 0; // pixel of the box
        std::uint32_t side = 1;
        std::array<std::uint32_t, 4> corners{};
    };
    /// A node of the tree of sections of a loop; a leaf is one vertex. Its left half follows it.
    struct Section {
        std::uint32_t right = 0;    // index of the right half; 0 for a leaf
        std::uint32_t vertices = 1; // of a leaf: index into the outline
    };
    struct Group {
        cageform::Binding<float, 3> binding;
        std::vector<std::uint32_t> handles; // indices of sections
        std::vector<std::uint32_t> points;
    };
    /// A T-junction: a point in the middle of a larger square's side has the mean of the side's ends.
    struct TJunction {
        std::uint32_t point, one, other;
    };

    void find_corners(std::span<const Values> outline);

    std::size_t width_ = 0;
    std::vector<Square> squares_;
    std::vector<Section> sections_;
    std::vector<Values> section_values_, values_; // by section, by point
    std::vector<Group> groups_;
    std::vector<TJunction> t_junctions_; // larger squares first
    cageform::ParallelFor parallel_;
    MembraneReport report_;
};

} // namespace cageform_support
