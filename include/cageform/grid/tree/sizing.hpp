// Chooses the largest allowed cell size at each point, in the plane.
//
// The size depends on the thickness of the domain, on the lengths of its edges, and on vertices
// where functions are singular. The result is a list of samples: the leaf that holds a sample must
// not be larger than the sample's size. grid/tree/cell_sizes.hpp does the work in space.
#pragma once

#include <cageform/core/types/solver_report.hpp>
#include <cageform/grid/tree/bone_sizes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

struct SizingOptions {
    double across = 6;    ///< cells across the thickness of the domain
    double per_facet = 1; ///< cells along an edge
    /// Extra halvings at a vertex where functions decrease like the distance from it. At a vertex
    /// of interior angle ω they decrease like the power π/ω of the distance, and the number of
    /// halvings is divided by π/ω.
    double singular_levels = 0.67;
    /// Layers of cells of each size about a singular vertex before those of twice the size. With 0
    /// there are as few as a balanced tree has, one or two.
    unsigned layers = 0;
    double per_radius = 12;    ///< see BoneSizes
    double largest = 1.0 / 16; ///< the largest cell, as a fraction of the cage's longest side
};

/// A size limit at a point: the leaf that holds it is at most `size` large. In units.
template <std::size_t D>
struct SizeSample {
    Vec<double, D> position;
    double size;
    SizeReason reason = SizeReason::largest;
};

/// A list of samples. Samples beyond the allowed number are only counted.
template <std::size_t D>
struct SizeSamples {
    Buffer<SizeSample<D>> list;
    double count = 0; ///< the number of all samples, an estimate once there are too many
};

} // namespace grid

namespace detail {

/// Makes the samples of a boundary in the plane.
class Sizing {
public:
    using Boundary = grid::TreeBoundary<2>;

    Sizing(const Boundary& boundary, const grid::SizingOptions& options, std::size_t most)
        : boundary_(boundary)
        , options_(options)
        , most_(most)
        , largest_(options.largest * std::ldexp(1.0, int(boundary.depth()))) {}

    grid::SizeSamples<2> make() {
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
            sample_facet(n, true);
            if (!boundary_[n].separates) sample_facet(n, false);
        }
        if (options_.singular_levels > 0) sample_singular();
        return std::move(out_);
    }

private:
    /// In units; bodies nearer than this are taken as sharing a plane.
    static constexpr double touching = 0.01;
    /// Least cosine between the normals of two edges for a thickness to be measured between them.
    static constexpr double facing = 0.7;
    static constexpr double spacing = 1.3; ///< between samples on an edge, in multiples of their size

    struct Side {
        std::uint32_t facet;
        Vec<double, 2> inwards;
        double by_length;           ///< the size limit from the edge's own length
        std::uint32_t faced;        ///< the edge that the last ray from here met
        bool has_thickness = false; ///< whether the samples across the domain are made
    };

    void add(const Vec<double, 2>& position, double size, SizeReason reason) {
        out_.count += 1;
        if (out_.list.size() < most_) out_.list.push_back({position, (std::max)(size, 1.0), reason});
    }
    static double length_of(const Corners<2>& edge) noexcept { return length(edge[1] - edge[0]); }
    Side side_of(std::uint32_t n, bool front) const noexcept {
        const auto inwards = front ? -1.0 * boundary_.normal(n) : boundary_.normal(n);
        return {n, inwards, length_of(boundary_[n].corner) / options_.per_facet, n};
    }

    /// Returns the distance across the domain from a point on an edge to the edge that faces it.
    /// Returns infinity if the first edge met does not face it or shares a vertex with it, because
    /// a wedge has no thickness.
    double thickness(Side& side, const Vec<double, 2>& from) const {
        const Boundary& boundary = boundary_;
        double nearest = std::ldexp(2.0, int(boundary.depth()));
        std::uint32_t met = side.facet;
        const auto meet = [&](std::uint32_t n) {
            const PlacedFacet<2>& facet = boundary[n];
            const double along = dot(side.inwards, boundary.normal(n));
            if (n == side.facet || !((facet.separates ? along : std::fabs(along)) > 1e-9)) return nearest;
            const double t = dot(boundary.normal(n), facet.corner[0] - from) / along;
            if (!(t > touching && t < nearest)) return nearest;
            for (const double w : weights_in_plane(facet, from + t * side.inwards)) {
                if (w < -1e-9) return nearest;
            }
            nearest = t;
            met = n;
            return nearest;
        };
        (void)meet(side.faced); // it is likely met again, and then limits the search
        boundary.for_each_on_ray(from, side.inwards, nearest, meet);
        side.faced = met;
        if (met == side.facet) return std::numeric_limits<double>::infinity();
        const double along = dot(side.inwards, boundary.normal(met));
        bool counts = (boundary[met].separates ? along : std::fabs(along)) > facing;
        for (const std::uint32_t v : boundary[met].vertex) counts = counts && !boundary[side.facet].has(v);
        return counts ? nearest : std::numeric_limits<double>::infinity();
    }

    void sample_facet(std::uint32_t n, bool front) {
        if (!(dot(boundary_.normal(n), boundary_.normal(n)) > 0)) return;
        sample_piece(boundary_[n].corner, side_of(n, front));
    }
    /// Adds samples to a piece of an edge. Halves the piece until it is as short as the cells
    /// there.
    void sample_piece(const Corners<2>& piece, Side side) {
        const auto middle = 0.5 * (piece[0] + piece[1]);
        const double t = thickness(side, middle), across = t / options_.across;
        const double size = (std::max)((std::min)({across, side.by_length, largest_}), 1.0);
        const auto reason = across < (std::min)(side.by_length, largest_) ? SizeReason::thickness
                            : side.by_length < largest_                   ? SizeReason::facet
                                                                          : SizeReason::largest;
        add(middle + (0.25 * size) * side.inwards, size,
            reason); // a little inside, to pick the inner one of two cells that meet on the edge
        const double piece_length = length_of(piece);
        if (!side.has_thickness && piece_length < 1.5 * across && across < largest_) {
            side.has_thickness = true; // cells in the middle are as small as at the surface
            for (double d = across; d < 0.55 * t && across >= 1; d += across)
                add(middle + d * side.inwards, across, SizeReason::thickness);
        }
        if (!(piece_length > spacing * size)) return;
        if (out_.count > double(most_)) { // count the remaining samples without making them
            out_.count += piece_length / (spacing * size);
            return;
        }
        sample_piece({piece[0], middle}, side);
        sample_piece({middle, piece[1]}, side);
    }

    // ---- singular vertices ----------------------------------------------------------------------

    struct End { ///< the end of an edge
        std::uint32_t vertex, edge;
        std::size_t corner;
    };
    void sample_singular() {
        std::vector<End> ends;
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
            for (std::size_t k = 0; k < 2; ++k) ends.push_back({boundary_[n].vertex[k], n, k});
        }
        std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
            return a.vertex != b.vertex ? a.vertex < b.vertex : a.edge < b.edge;
        });
        for (auto begin = ends.begin(), end = begin; begin != ends.end(); begin = end) {
            while (end != ends.end() && end->vertex == begin->vertex) ++end;
            const double levels = std::round(options_.singular_levels / exponent({begin, end}));
            if (levels > 0) sample_vertex({begin, end}, levels);
        }
    }
    /// Returns the exponent α for which the steepest functions at a vertex decrease like
    /// distance^α: π over the interior angle. Returns infinity if the tree need not be finer there.
    double exponent(std::span<const End> about) const noexcept {
        constexpr double pi = std::numbers::pi, obtuse = 0.55 * pi;
        double angle = about.size() == 1 ? 2 * pi : pi;
        if (about.size() == 2) {
            const auto &a = boundary_[about[0].edge], &b = boundary_[about[1].edge];
            const auto u = across(about[0]), v = across(about[1]);
            const double size = length(u) * length(v);
            if (!(size > 0)) return std::numeric_limits<double>::infinity();
            angle = std::acos(std::clamp(dot(u, v) / size, -1.0, 1.0));
            const bool convex = dot(boundary_.normal(about[0].edge), v) < 0;
            if (!a.separates && !b.separates) {
                angle = (std::max)(angle, 2 * pi - angle);
            } else if (a.separates && b.separates && !convex) {
                angle = 2 * pi - angle;
            } else if (a.separates != b.separates) {
                angle = pi;
            }
        }
        return angle > obtuse ? pi / angle : std::numeric_limits<double>::infinity();
    }
    /// Returns the vector from a vertex along its edge to the other end.
    Vec<double, 2> across(const End& end) const noexcept {
        const auto& corner = boundary_[end.edge].corner;
        return corner[1 - end.corner] - corner[end.corner];
    }
    /// Adds the samples about a singular vertex: `levels` halvings of the size that its edges
    /// allow.
    void sample_vertex(std::span<const End> about, double levels) {
        const auto position = boundary_[about[0].edge].corner[about[0].corner];
        double size = largest_;
        for (const End& end : about) {
            for (const bool front : {true, false}) {
                if (!front && boundary_[end.edge].separates) continue;
                Side side = side_of(end.edge, front);
                const auto inside = position + 0.05 * across(end);
                size = (std::min)({size, side.by_length, thickness(side, inside) / options_.across});
            }
        }
        for (double level = levels; level >= 0; level -= 1) {
            add_about(position, (std::max)(std::ldexp(size, -int(level)), 1.0));
            if (options_.layers == 0) break;
        }
    }
    /// Adds samples about a vertex for layers of cells, or at least for the cells that meet there.
    void add_about(const Vec<double, 2>& position, double size) {
        const auto steps = (std::max)(2 * int(options_.layers), 1);
        const double reach = options_.layers > 0 ? 0.9 * options_.layers * size : 0.25 * size;
        const auto offset = [&](int n) { return reach * (2.0 * n / steps - 1); };
        for (int i = 0; i <= steps; ++i) {
            for (int j = 0; j <= steps; ++j)
                add(position + Vec<double, 2>{offset(i), offset(j)}, size, SizeReason::singular_vertex);
        }
    }

    const Boundary& boundary_;
    grid::SizingOptions options_;
    std::size_t most_;
    double largest_;
    grid::SizeSamples<2> out_;
};

} // namespace detail
namespace grid {

/// Returns the size limits of a boundary in the plane, down to cells of one unit.
///
///   most  samples kept; if count is larger, it estimates how many there would be
///   cost  a ray across the domain for each sample
inline SizeSamples<2> size_samples(const TreeBoundary<2>& boundary, const SizingOptions& options,
                                   std::size_t most) {
    return detail::Sizing(boundary, options, most).make();
}

/// Splits leaves until none is larger than the samples and bones allow, then balances the tree.
///
///   most_leaves  returns false if more would be needed; the tree is then incomplete
template <std::size_t D>
bool refine(CutTree<D>& tree, std::span<const SizeSample<D>> samples, const SizingOptions& options,
            std::size_t most_leaves) {
    using Index = typename CellTree<D>::Index;
    const auto& cells = tree.cells();
    const double largest = options.largest * double(cells.size());
    const BoneSizes<D> bones(tree.boundary(), options.per_radius);
    for (std::size_t n = 0; n < cells.cells(); ++n) { // the loop reaches cells that it adds
        const auto cell = cells.cell(std::uint32_t(n));
        const double most = std::fmin(largest, bones.size_of(cell));
        if (cells.is_leaf(cell.number) && cell.size > 1 && cell.size > most) tree.split(cell);
        if (cells.leaves() > most_leaves) return false;
    }
    for (const auto& sample : samples) {
        Index doubled{};
        for (std::size_t k = 0; k < D; ++k) doubled[k] = std::int32_t(std::floor(2 * sample.position[k]));
        auto leaf = cells.leaf_at(doubled);
        while (leaf.size > 1 && leaf.size > sample.size) {
            tree.split(leaf);
            leaf = cells.leaf_at(doubled);
        }
        if (cells.leaves() > most_leaves) return false;
    }
    tree.find_states();
    balance(tree);
    return cells.leaves() <= most_leaves;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
