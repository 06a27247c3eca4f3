// How fine a tree of cells has to be where, in the plane: by the thickness of the domain, by its edges, and
// where functions are singular. Told by samples: a leaf that holds one is at most as large as it says.
#pragma once

#include <cageform/core/solver_report.hpp>
#include <cageform/grid/tree/bone_sizes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

struct SizingOptions {
    double across = 6;    ///< cells across the thickness of the domain
    double per_facet = 1; ///< cells along an edge
    /// Halvings more where functions fall like the distance from a vertex; at one of interior angle ω,
    /// where they fall like its power π/ω, that much more.
    double singular_levels = 0.67;
    /// Cells of each size about what is singular, before those of twice the size; 0: as few as a
    /// balanced tree has, one or two.
    unsigned layers = 0;
    double per_radius = 12;    ///< see BoneSizes
    double largest = 1.0 / 16; ///< cell, of the cage's longest side
};

/// A leaf that holds the place is at most `size` large. In units.
template <std::size_t D>
struct SizeSample {
    Vec<double, D> place;
    double size;
    SizeReason reason = SizeReason::largest;
};

/// Samples; more than the most allowed are only counted.
template <std::size_t D>
struct SizeSamples {
    Buffer<SizeSample<D>> list;
    double count = 0; ///< of all, by an estimate once there are too many
};

} // namespace grid

namespace detail {

/// Makes the samples of a boundary in the plane; in space see grid/tree/refinement.hpp.
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
            if (!boundary_[n].turns) sample_facet(n, false);
        }
        if (options_.singular_levels > 0) sample_singular();
        return std::move(out_);
    }

private:
    static constexpr double touching = 0.01; ///< of units: so near are bodies with a common plane
    static constexpr double facing = 0.7;    ///< cosine between a facet and one it is measured across
    static constexpr double spacing = 1.3;   ///< of samples, in the sizes they tell

    struct Side {
        std::uint32_t facet;
        Vec<double, 2> inwards;
        double by_length;           ///< the size that it asks for by itself
        std::uint32_t faced;        ///< by the facet there, where a ray was sent last
        bool has_thickness = false; ///< the samples across are made
    };

    void add(const Vec<double, 2>& place, double size, SizeReason reason) {
        out_.count += 1;
        if (out_.list.size() < most_) out_.list.push_back({place, (std::max)(size, 1.0), reason});
    }
    static double length_of(const Corners<2>& edge) noexcept { return length(edge[1] - edge[0]); }
    Side side_of(std::uint32_t n, bool front) const noexcept {
        const auto inwards = front ? -1.0 * boundary_.normal(n) : boundary_.normal(n);
        return {n, inwards, length_of(boundary_[n].corner) / options_.per_facet, n};
    }

    /// The distance across the domain from a place of a facet to one that faces it; infinite where
    /// what comes first does not, or has a vertex with it in common: wedges have no thickness.
    double thickness(Side& side, const Vec<double, 2>& from) const {
        const Boundary& boundary = boundary_;
        double nearest = std::ldexp(2.0, int(boundary.depth()));
        std::uint32_t met = side.facet;
        const auto meet = [&](std::uint32_t n) {
            const PlacedFacet<2>& facet = boundary[n];
            const double along = dot(side.inwards, boundary.normal(n));
            if (n == side.facet || !((facet.turns ? along : std::fabs(along)) > 1e-9)) return nearest;
            const double t = dot(boundary.normal(n), facet.corner[0] - from) / along;
            if (!(t > touching && t < nearest)) return nearest;
            for (const double w : weights_in_plane(facet, from + t * side.inwards)) {
                if (w < -1e-9) return nearest;
            }
            nearest = t;
            met = n;
            return nearest;
        };
        (void)meet(side.faced); // most likely that again, and nothing beyond it is looked at
        boundary.boxes().for_each_on_ray(from, side.inwards, nearest, meet);
        side.faced = met;
        if (met == side.facet) return std::numeric_limits<double>::infinity();
        const double along = dot(side.inwards, boundary.normal(met));
        bool counts = (boundary[met].turns ? along : std::fabs(along)) > facing;
        for (const std::uint32_t v : boundary[met].vertex) counts = counts && !boundary[side.facet].has(v);
        return counts ? nearest : std::numeric_limits<double>::infinity();
    }

    void sample_facet(std::uint32_t n, bool front) {
        if (!(dot(boundary_.normal(n), boundary_.normal(n)) > 0)) return;
        sample_piece(boundary_[n].corner, side_of(n, front));
    }
    /// Halves a piece until it is as small as the cells there.
    void sample_piece(const Corners<2>& piece, Side side) {
        const auto middle = 0.5 * (piece[0] + piece[1]);
        const double t = thickness(side, middle), across = t / options_.across;
        const double size = (std::max)((std::min)({across, side.by_length, largest_}), 1.0);
        const auto reason = across < (std::min)(side.by_length, largest_) ? SizeReason::thickness
                            : side.by_length < largest_                   ? SizeReason::facet
                                                                          : SizeReason::largest;
        add(middle + (0.25 * size) * side.inwards, size,
            reason); // where cells meet on a facet, the inner one
        const double piece_length = length_of(piece);
        if (!side.has_thickness && piece_length < 1.5 * across && across < largest_) {
            side.has_thickness = true; // the middle of the domain is as fine as its skin
            for (double d = across; d < 0.55 * t && across >= 1; d += across)
                add(middle + d * side.inwards, across, SizeReason::thickness);
        }
        if (!(piece_length > spacing * size)) return;
        if (out_.count > double(most_)) { // only to tell how many there would be
            out_.count += piece_length / (spacing * size);
            return;
        }
        sample_piece({piece[0], middle}, side);
        sample_piece({middle, piece[1]}, side);
    }

    // ---- singular vertices ----------------------------------------------------------------------

    struct End { ///< of an edge
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
    /// Of the distance, which the steepest functions at a vertex fall like; infinite where the tree
    /// need not be finer.
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
            if (!a.turns && !b.turns) {
                angle = (std::max)(angle, 2 * pi - angle);
            } else if (a.turns && b.turns && !convex) {
                angle = 2 * pi - angle;
            } else if (a.turns != b.turns) {
                angle = pi;
            }
        }
        return angle > obtuse ? pi / angle : std::numeric_limits<double>::infinity();
    }
    /// From a vertex along its edge.
    Vec<double, 2> across(const End& end) const noexcept {
        const auto& corner = boundary_[end.edge].corner;
        return corner[1 - end.corner] - corner[end.corner];
    }
    void sample_vertex(std::span<const End> about, double levels) {
        const auto place = boundary_[about[0].edge].corner[about[0].corner];
        double size = largest_;
        for (const End& end : about) {
            for (const bool front : {true, false}) {
                if (!front && boundary_[end.edge].turns) continue;
                Side side = side_of(end.edge, front);
                const auto inside = place + 0.05 * across(end);
                size = (std::min)({size, side.by_length, thickness(side, inside) / options_.across});
            }
        }
        for (double level = levels; level >= 0; level -= 1) {
            add_about(place, (std::max)(std::ldexp(size, -int(level)), 1.0));
            if (options_.layers == 0) break;
        }
    }
    /// Layers of cells about a vertex; at least those that meet there.
    void add_about(const Vec<double, 2>& place, double size) {
        const auto steps = (std::max)(2 * int(options_.layers), 1);
        const double reach = options_.layers > 0 ? 0.9 * options_.layers * size : 0.25 * size;
        const auto part = [&](int n) { return reach * (2.0 * n / steps - 1); };
        for (int i = 0; i <= steps; ++i) {
            for (int j = 0; j <= steps; ++j)
                add(place + Vec<double, 2>{part(i), part(j)}, size, SizeReason::singular_vertex);
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

/// How fine a boundary in the plane asks a tree to be, down to cells of one unit.
///
///   most  samples kept; where the count is larger there would be more, by an estimate
///   cost  a ray across the domain for each sample
inline SizeSamples<2> size_samples(const TreeBoundary<2>& boundary, const SizingOptions& options,
                                   std::size_t most) {
    return detail::Sizing(boundary, options, most).make();
}

/// Splits the leaves of a tree as the samples ask, then those that neighbours of less than half
/// their size ask.
///
///   most_leaves  false when more would be needed; the tree is then not whole
template <std::size_t D>
bool refine(CutTree<D>& tree, std::span<const SizeSample<D>> samples, const SizingOptions& options,
            std::size_t most_leaves) {
    using Index = typename CellTree<D>::Index;
    const auto& cells = tree.cells();
    const double largest = options.largest * double(cells.size());
    const BoneSizes<D> bones(tree.boundary(), options.per_radius);
    for (std::size_t n = 0; n < cells.cells(); ++n) { // cells are added while they are gone through
        const auto cell = cells.cell(std::uint32_t(n));
        const double most = std::fmin(largest, bones.size_of(cell));
        if (cells.is_leaf(cell.number) && cell.size > 1 && cell.size > most) tree.split(cell);
        if (cells.leaves() > most_leaves) return false;
    }
    for (const auto& sample : samples) {
        Index doubled{};
        for (std::size_t k = 0; k < D; ++k) doubled[k] = std::int32_t(std::floor(2 * sample.place[k]));
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
