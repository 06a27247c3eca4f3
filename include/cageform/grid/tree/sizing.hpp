// How fine a tree of cells has to be where: by the thickness of the domain, by its facets, and where
// functions are singular. Told by samples: a leaf that holds one is at most as large as it says.
#pragma once

#include <cageform/grid/evaluation.hpp>
#include <cageform/grid/tree/bone_sizes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

struct SizingOptions {
    double across = 6;    ///< cells across the thickness of the domain
    double per_facet = 1; ///< cells along the least altitude of a facet, in the plane its length
    /// Halvings more where functions fall like the distance from an edge (in the plane a vertex); at
    /// one of interior angle ω, where they fall like its power π/ω, that much more. In space at reflex
    /// edges and rims of walls alone.
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

/// Makes the samples of a boundary.
template <std::size_t D>
class Sizing {
public:
    using Boundary = grid::TreeBoundary<D>;

    Sizing(const Boundary& boundary, const grid::SizingOptions& options, std::size_t most)
        : boundary_(boundary)
        , options_(options)
        , most_(most)
        , largest_(options.largest * std::ldexp(1.0, int(boundary.depth()))) {}

    grid::SizeSamples<D> make() {
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
    static constexpr std::size_t pieces = 8; ///< of a singular edge, each sized by itself

    struct Side {
        std::uint32_t facet;
        Vec<double, D> inwards;
        double by_altitude;         ///< the size that it asks for by itself
        std::uint32_t faced;        ///< by the facet there, where a ray was sent last
        bool has_thickness = false; ///< the samples across are made
    };

    void add(const Vec<double, D>& place, double size, SizeReason reason) {
        out_.count += 1;
        if (out_.list.size() < most_) out_.list.push_back({place, std::max(size, 1.0), reason});
    }
    double altitude(const PlacedFacet<D>& facet) const noexcept {
        double longest = 0;
        for (std::size_t k = 0; k < D; ++k)
            longest = std::max(longest, length(facet.corner[(k + 1) % D] - facet.corner[k]));
        if constexpr (D == 2) {
            return longest;
        } else {
            return longest > 0 ? length(normal_of(facet)) / longest : 0;
        }
    }
    Side side_of(std::uint32_t n, bool front) const noexcept {
        const auto inwards = front ? -1.0 * boundary_.normal(n) : boundary_.normal(n);
        return {n, inwards, altitude(boundary_[n]) / options_.per_facet, n};
    }

    /// The distance across the domain from a place of a facet to one that faces it; infinite where
    /// what comes first does not, or has a vertex with it in common: wedges have no thickness.
    double thickness(Side& side, const Vec<double, D>& from) const {
        const Boundary& boundary = boundary_;
        double nearest = std::ldexp(2.0, int(boundary.depth()));
        std::uint32_t met = side.facet;
        const auto meet = [&](std::uint32_t n) {
            const PlacedFacet<D>& facet = boundary[n];
            double along = dot(side.inwards, boundary.normal(n));
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
    /// Halves a piece along its longest edge until it is as small as the cells there.
    void sample_piece(const Corners<D>& piece, Side side) {
        Vec<double, D> middle{};
        for (const auto& corner : piece) middle = middle + (1 / double(D)) * corner;
        const double t = thickness(side, middle), across = t / options_.across;
        const double size = std::max(std::min({across, side.by_altitude, largest_}), 1.0);
        const auto reason = across < std::min(side.by_altitude, largest_) ? SizeReason::thickness
                            : side.by_altitude < largest_                 ? SizeReason::facet
                                                                          : SizeReason::largest;
        add(middle + (0.25 * size) * side.inwards, size,
            reason); // where cells meet on a facet, the inner one
        std::size_t first = 0;
        double longest = 0;
        for (std::size_t k = 0; k < (D == 2 ? 1 : D); ++k) {
            const double l = length(piece[(k + 1) % D] - piece[k]);
            if (l > longest) {
                longest = l;
                first = k;
            }
        }
        if (!side.has_thickness && longest < 1.5 * across && across < largest_) {
            side.has_thickness = true; // the middle of the domain is as fine as its skin
            for (double d = across; d < 0.55 * t && across >= 1; d += across)
                add(middle + d * side.inwards, across, SizeReason::thickness);
        }
        if (!(longest > spacing * size)) return;
        if (out_.count > double(most_)) { // only to tell how many there would be
            out_.count += std::pow(longest / (spacing * size), double(D - 1));
            return;
        }
        const std::size_t second = (first + 1) % D;
        const auto half = 0.5 * (piece[first] + piece[second]);
        for (const std::size_t moved : {first, second}) {
            auto part = piece;
            part[moved] = half;
            sample_piece(part, side);
        }
    }

    // ---- singular edges, in the plane vertices ------------------------------------------------------

    struct Ridge { ///< of a facet: what is left of it without one corner
        std::array<std::uint32_t, D - 1> vertex;
        std::uint32_t facet;
        std::uint32_t apex; ///< the corner left out
    };
    void sample_singular() {
        std::vector<Ridge> ridges;
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
            for (std::uint32_t apex = 0; apex < D; ++apex) {
                Ridge ridge{{}, n, apex};
                for (std::size_t k = 0; k + 1 < D; ++k)
                    ridge.vertex[k] = boundary_[n].vertex[(apex + 1 + k) % D];
                std::sort(ridge.vertex.begin(), ridge.vertex.end());
                ridges.push_back(ridge);
            }
        }
        std::sort(ridges.begin(), ridges.end(), [](const Ridge& a, const Ridge& b) {
            return a.vertex != b.vertex ? a.vertex < b.vertex : a.facet < b.facet;
        });
        for (std::size_t begin = 0, end = 0; begin < ridges.size(); begin = end) {
            while (end < ridges.size() && ridges[end].vertex == ridges[begin].vertex) ++end;
            const std::span<const Ridge> about(ridges.data() + begin, end - begin);
            const double levels = std::round(options_.singular_levels / exponent(about));
            if (levels > 0) sample_ridge(about, levels);
        }
    }
    /// Of the distance, which the steepest functions at a ridge fall like; infinite where the tree
    /// need not be finer.
    double exponent(std::span<const Ridge> about) const noexcept {
        constexpr double pi = std::numbers::pi, reflex = 1.05 * pi, obtuse = 0.55 * pi;
        double angle = about.size() == 1 ? 2 * pi : pi;
        if (about.size() == 2) {
            const auto &a = boundary_[about[0].facet], &b = boundary_[about[1].facet];
            const auto u = across(about[0]), v = across(about[1]);
            const double size = length(u) * length(v);
            if (!(size > 0)) return std::numeric_limits<double>::infinity();
            angle = std::acos(std::clamp(dot(u, v) / size, -1.0, 1.0));
            const bool convex = dot(boundary_.normal(about[0].facet), v) < 0;
            if (!a.turns && !b.turns) {
                angle = std::max(angle, 2 * pi - angle);
            } else if (a.turns && b.turns && !convex) {
                angle = 2 * pi - angle;
            } else if (a.turns != b.turns) {
                angle = pi;
            }
        }
        return angle > (D == 2 ? obtuse : reflex) ? pi / angle : std::numeric_limits<double>::infinity();
    }
    /// From a ridge to the rest of its facet, at a right angle.
    Vec<double, D> across(const Ridge& ridge) const noexcept {
        const auto& corner = boundary_[ridge.facet].corner;
        const auto &a = corner[(ridge.apex + 1) % D], &b = corner[(ridge.apex + D - 1) % D];
        auto to_apex = corner[ridge.apex] - a;
        const auto along = b - a;
        if (D > 2 && dot(along, along) > 0)
            to_apex = to_apex - (dot(to_apex, along) / dot(along, along)) * along;
        return to_apex;
    }
    void sample_ridge(std::span<const Ridge> about, double levels) {
        const auto& facet = boundary_[about[0].facet];
        const auto a = facet.corner[(about[0].apex + 1) % D], b = facet.corner[(about[0].apex + D - 1) % D];
        const std::size_t parts = D == 2 ? 1 : pieces;
        for (std::size_t n = 0; n < parts; ++n) {
            const auto at = [&](double part) { return a + ((double(n) + part) / double(parts)) * (b - a); };
            double size = largest_;
            for (const Ridge& ridge : about) {
                for (const bool front : {true, false}) {
                    if (!front && boundary_[ridge.facet].turns) continue;
                    Side side = side_of(ridge.facet, front);
                    const auto place = at(0.5);
                    const auto inside = place + 0.05 * (boundary_[ridge.facet].corner[ridge.apex] - place);
                    size = std::min({size, side.by_altitude, thickness(side, inside) / options_.across});
                }
            }
            for (double level = levels; level >= 0; level -= 1) {
                const double here = std::max(std::ldexp(size, -int(level)), 1.0);
                const double steps = D == 2 ? 1 : std::ceil(length(b - a) / double(parts) / here);
                if (out_.count > double(most_)) {
                    out_.count += 4 * steps;
                    continue;
                }
                for (double step = 0; step < steps; ++step) add_about(at((step + 0.5) / steps), b - a, here);
                if (options_.layers == 0) break;
            }
        }
    }
    /// Layers of cells about a place of a ridge; at least those that meet there.
    void add_about(const Vec<double, D>& place, const Vec<double, D>& along, double size) {
        const auto steps = std::max(2 * int(options_.layers), 1);
        const double reach = options_.layers > 0 ? 0.9 * options_.layers * size : 0.25 * size;
        std::array<Vec<double, D>, 2> axes{};
        axes[0][0] = axes[1][1] = 1;
        if constexpr (D == 3) {
            const std::size_t flat = std::fabs(along[0]) < std::fabs(along[1])   ? 0
                                     : std::fabs(along[1]) < std::fabs(along[2]) ? 1
                                                                                 : 2;
            axes[0] = {};
            axes[0][flat] = 1;
            axes[0] = cross(along, axes[0]);
            axes[1] = cross(along, axes[0]);
            for (auto& axis : axes) axis = (1 / std::max(length(axis), 1e-300)) * axis;
        }
        for (int i = 0; i <= steps; ++i) {
            for (int j = 0; j <= steps; ++j) {
                const auto part = [&](int n) { return reach * (2.0 * n / steps - 1); };
                add(place + part(i) * axes[0] + part(j) * axes[1], size, SizeReason::singular_vertex);
            }
        }
    }

    const Boundary& boundary_;
    grid::SizingOptions options_;
    std::size_t most_;
    double largest_;
    grid::SizeSamples<D> out_;
};

} // namespace detail
namespace grid {

/// How fine a boundary asks a tree to be, down to cells of one unit.
///
///   most  samples kept; where the count is larger there would be more, by an estimate
///   cost  a ray across the domain for each sample
template <std::size_t D>
SizeSamples<D> size_samples(const TreeBoundary<D>& boundary, const SizingOptions& options, std::size_t most) {
    return detail::Sizing<D>(boundary, options, most).make();
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
