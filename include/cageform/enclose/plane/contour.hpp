// make_cage in 2D, step 3: traces the border of the outside, with a vertex at each crossing of a lattice
// line.
#pragma once

#include <cageform/enclose/detail/distance_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

using Loop = std::vector<Vec<double, 2>>;

inline double signed_area(const Loop& loop) noexcept {
    double twice = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) twice += cross(loop[i], loop[(i + 1) % loop.size()]);
    return twice / 2;
}

/// Border of the outside by marching squares (Lorensen & Cline 1987, in 2D), as loops with the inside to
/// their left; outer loops are counter-clockwise. The border follows `outside`, not the sign of f, so filled
/// pockets get no loops. If two outside corners of a square are opposite, the border separates them: loops
/// never touch.
class Contour {
public:
    Contour(const DistanceLattice<2>& lattice, const std::vector<std::uint8_t>& outside)
        : lattice_(lattice)
        , outside_(outside)
        , next_(2 * lattice.size(), none) {
        const std::size_t width = lattice.count()[0];
        for (std::size_t node = 0; node + width + 1 < lattice.size(); ++node) {
            if (node % width + 1 < width) link_square(node);
        }
    }

    std::vector<Loop> loops() const {
        std::vector<Loop> loops;
        std::vector<bool> done(next_.size(), false);
        for (std::size_t start = 0; start < next_.size(); ++start) {
            if (next_[start] == none || done[start]) continue;
            Loop loop;
            for (std::size_t edge = start; !done[edge]; edge = next_[edge]) {
                done[edge] = true;
                loop.push_back(crossing(edge));
            }
            loops.push_back(std::move(loop));
        }
        return loops;
    }

private:
    static constexpr std::size_t none = ~std::size_t{0};

    /// Lattice edges are numbered 2 node + axis. Each counter-clockwise run of outside corners is cut off by
    /// one segment, from the edge where the run begins to the edge where it ends.
    void link_square(std::size_t node) {
        const std::size_t width = lattice_.count()[0];
        const std::array<std::size_t, 4> corner{node, node + 1, node + width + 1, node + width};
        const std::array<std::size_t, 4> edge{2 * node, 2 * (node + 1) + 1, 2 * (node + width), 2 * node + 1};
        const auto is_out = [&](std::size_t k) { return outside_[corner[k % 4]] != 0; };
        for (std::size_t k = 0; k < 4; ++k) {
            if (is_out(k) || !is_out(k + 1)) continue;
            std::size_t end = k + 1;
            while (is_out(end + 1)) ++end;
            next_[edge[k]] = edge[end % 4];
        }
    }

    /// Crossing of the border and a lattice edge by linear interpolation of f. The crossing is kept away from
    /// the nodes, so that all segments have a positive length.
    Vec<double, 2> crossing(std::size_t edge) const {
        const std::size_t from = edge / 2, to = from + (edge % 2 == 0 ? 1 : lattice_.count()[0]);
        const double f = double(lattice_[from]), g = double(lattice_[to]);
        const double t = f != g ? std::clamp(f / (f - g), 0.02, 0.98) : 0.5;
        return (1 - t) * lattice_.position(from) + t * lattice_.position(to);
    }

    const DistanceLattice<2>& lattice_;
    const std::vector<std::uint8_t>& outside_;
    std::vector<std::size_t> next_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
