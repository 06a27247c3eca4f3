// make_cage in space, step 1: fills a lattice with the distance of its nodes from the faces of a figure.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/running.hpp>
#include <cageform/enclose/detail/distance_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Fills a lattice with the distance from triangles minus `margin`, at most `farthest`. It is exact
/// next to the faces. Sweeps then carry the nearest triangle from node to node (Bridson, Fluid
/// simulation for computer graphics, 2015, sec. 14.1). Far off, the triangle found need not be the
/// nearest, so the distance may be too large; containment does not depend on it.
class SpaceDistance {
public:
    using Point = Vec<double, 3>;

    SpaceDistance(DistanceLattice<3>& lattice, std::span<const Corners<3>> triangles)
        : lattice_(lattice)
        , triangles_(triangles)
        , nearest_(lattice.size(), none) {
        guards_.reserve(triangles.size());
        for (const auto& corner : triangles) {
            const Point middle = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
            double radius = 0;
            for (const auto& p : corner) radius = (std::max)(radius, length(p - middle));
            Point n = cross(corner[1] - corner[0], corner[2] - corner[0]);
            const double size = length(n);
            n = size > 1e-6 * radius * radius ? (1 / size) * n : Point{};
            guards_.push_back({vec_cast<float>(middle), static_cast<float>(radius), vec_cast<float>(n)});
        }
    }

    void fill(double margin, double farthest) {
        for (std::size_t node = 0; node < lattice_.size(); ++node)
            lattice_[node] = static_cast<float>(farthest + margin);
        for (std::size_t t = 0; t < triangles_.size(); ++t) measure_beside(t);
        for (int round = 0; round < 2; ++round) {
            for (unsigned directions = 0; directions < 8; ++directions) sweep(directions, farthest + margin);
        }
        for (std::size_t node = 0; node < lattice_.size(); ++node)
            lattice_[node] = static_cast<float>((std::min)(double(lattice_[node]) - margin, farthest));
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// A ball around a triangle and its plane, for lower bounds of the distance.
    struct Guard {
        Vec<float, 3> middle;
        float radius;
        Vec<float, 3> normal; ///< of length 1; 0 for a triangle that is nearly a segment
    };

    CAGEFORM_DETAIL_FLATTEN void offer(std::size_t node, const Point& position, std::uint32_t triangle) {
        const Guard& guard = guards_[triangle];
        const auto off = vec_cast<float>(position) - guard.middle;
        const float now = 1.00001F * lattice_[node] + 3e-6F; // above the rounding, where lengths are about 1
        const float beyond = now + guard.radius;
        if (dot(off, off) > beyond * beyond || std::fabs(dot(off, guard.normal)) > now) return;
        const auto d = static_cast<float>(distance_to_facet(position, triangles_[triangle]));
        if (!(d < lattice_[node])) return;
        lattice_[node] = d;
        nearest_[node] = triangle;
    }

    /// Computes exact distances at the nodes in the box of a triangle, widened by one spacing.
    /// Large triangles skip nodes farther than two spacings from their plane.
    void measure_beside(std::size_t t) {
        const auto& corner = triangles_[t];
        const double h = lattice_.spacing();
        const auto n = cross(corner[1] - corner[0], corner[2] - corner[0]);
        const double size = length(n);
        const auto box = bounds_of(std::span<const Point>(corner)).widened(h);
        lattice_.for_each_row(box, [&](std::size_t row, std::size_t first, std::size_t last) {
            Point p = lattice_.position(row);
            const double low = p[0];
            for (std::size_t i = first; i < last; ++i) {
                p[0] = low + h * double(i);
                if (size > 0 && std::fabs(dot(n, p - corner[0])) > 2 * h * size) continue;
                offer(row + i, p, static_cast<std::uint32_t>(t));
            }
        });
    }

    /// One pass over all nodes, in which each tries the triangles of its predecessors. Bit k of
    /// `directions` means downwards along axis k. A predecessor's triangle can be nearer only if the
    /// predecessor's distance, minus the step between the two nodes, is smaller than the node's.
    void sweep(unsigned directions, double farthest) {
        const auto& count = lattice_.count();
        const auto& stride = lattice_.stride();
        const auto h = static_cast<float>(lattice_.spacing());
        std::array<std::ptrdiff_t, 3> step{};
        for (std::size_t k = 0; k < 3; ++k) {
            const bool down = (directions >> k & 1U) != 0;
            step[k] = down ? std::ptrdiff_t(stride[k]) : -std::ptrdiff_t(stride[k]);
        }
        const auto number = [&](std::size_t k, std::size_t i) {
            return (directions >> k & 1U) != 0 ? count[k] - 2 - i : i + 1;
        };
        for (std::size_t a = 0; a + 1 < count[2]; ++a) {
            for (std::size_t b = 0; b + 1 < count[1]; ++b) {
                const std::size_t row = number(2, a) * stride[2] + number(1, b) * stride[1];
                Point p = lattice_.position(row);
                const double low = p[0];
                for (std::size_t c = 0; c + 1 < count[0]; ++c) {
                    const std::size_t node = row + number(0, c);
                    p[0] = low + lattice_.spacing() * double(number(0, c));
                    for (unsigned about = 1; about < 8; ++about) {
                        std::ptrdiff_t off = 0;
                        for (std::size_t k = 0; k < 3; ++k) off += (about >> k & 1U) != 0 ? step[k] : 0;
                        const auto other = static_cast<std::size_t>(std::ptrdiff_t(node) + off);
                        if (nearest_[other] == nearest_[node] || nearest_[other] == none) continue;
                        const float least = lattice_[other] - 1.75F * h; // the step is at most sqrt(3) h
                        if (least < lattice_[node] && double(lattice_[other]) < farthest)
                            offer(node, p, nearest_[other]);
                    }
                }
            }
        }
    }

    DistanceLattice<3>& lattice_;
    std::span<const Corners<3>> triangles_;
    std::vector<Guard> guards_;          ///< of each triangle
    std::vector<std::uint32_t> nearest_; ///< the triangle at the distance stored, for each node
};

/// Whether f >= 0 on a triangle, up to a twentieth of the spacing. f has slope at most 1, so a triangle is
/// free if it lies in the sphere of radius f around its middle. Larger ones are halved, down to 0.8 spacings.
CAGEFORM_DETAIL_FLATTEN inline bool is_clear(const DistanceLattice<3>& lattice, Corners<3> corner) noexcept {
    // One half waits for each halving above the current triangle. Some 30 halvings take a side of thousands
    // of spacings down to one; a triangle that needs more than 64 does not count as clear.
    std::array<Corners<3>, 64> waiting;
    std::size_t count = 0;
    const double least = -0.05 * lattice.spacing(), shortest = 0.8 * lattice.spacing();
    for (;;) {
        const auto middle = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
        const double f = lattice.value(middle);
        if (f < least) return false;
        double reach2 = 0;
        std::array<double, 3> side2{}; // opposite to each corner
        for (std::size_t k = 0; k < 3; ++k) {
            const auto to = corner[k] - middle, side = corner[(k + 2) % 3] - corner[(k + 1) % 3];
            reach2 = (std::max)(reach2, dot(to, to));
            side2[k] = dot(side, side);
        }
        const double free = (std::max)(f, shortest);
        if (free * free >= reach2) {
            if (count == 0) return true;
            corner = waiting[--count];
            continue;
        }
        if (count == waiting.size()) return false;
        const std::size_t k = side2[0] < side2[1]   ? (side2[1] < side2[2] ? 2 : 1)
                              : side2[0] < side2[2] ? 2
                                                    : 0;
        const Vec<double, 3> a = corner[k], b = corner[(k + 1) % 3], c = corner[(k + 2) % 3];
        const auto half = 0.5 * (b + c);
        waiting[count++] = {a, half, c};
        corner = {a, b, half};
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail
