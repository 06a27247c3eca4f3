// make_cage in 3D, step 1: fills a lattice with distances from the faces of a figure.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/enclose/detail/distance_lattice.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Measures squared distances from a triangle in a local frame, in single precision. x is along the longest
/// side, y in the plane of the triangle, z along its normal.
class TriangleFrame {
public:
    explicit TriangleFrame(const Corners<3>& corner) noexcept {
        std::size_t first = 0; // start of the longest side
        double longest2 = -1;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto e = corner[(k + 1) % 3] - corner[k];
            if (dot(e, e) <= longest2) continue;
            longest2 = dot(e, e);
            first = k;
        }
        const Vec<double, 3>&a = corner[first], &b = corner[(first + 1) % 3], &c = corner[(first + 2) % 3];
        const double along = std::sqrt(longest2);
        const auto x = along > 0 ? (1 / along) * (b - a) : Vec<double, 3>{1, 0, 0};
        const double foot = dot(c - a, x);
        auto y = (c - a) - foot * x;
        double height = length(y);
        if (height > 1e-9 * along) {
            y = (1 / height) * y;
        } else { // a segment or a point: any perpendicular direction
            Vec<double, 3> axis{};
            axis[std::fabs(x[0]) < 0.6 ? 0 : 1] = 1;
            y = cross(x, axis);
            y = (1 / length(y)) * y;
            height = 0;
        }
        origin_ = vec_cast<float>(a);
        x_ = vec_cast<float>(x);
        y_ = vec_cast<float>(y);
        z_ = vec_cast<float>(cross(x, y));
        along_ = static_cast<float>(along);
        foot_ = static_cast<float>(foot);
        height_ = static_cast<float>(height);
        const float left2 = foot_ * foot_ + height_ * height_;
        const float rest = along_ - foot_, right2 = rest * rest + height_ * height_;
        per_left2_ = left2 > 0 ? 1 / left2 : 0;
        per_right2_ = right2 > 0 ? 1 / right2 : 0;
    }

    /// Returns the squared distance of a point. If it is larger than `limit2`, returns any number above
    /// `limit2`.
    float distance2(const Vec<float, 3>& p, float limit2) const noexcept {
        const auto off = p - origin_;
        const float z = dot(off, z_);
        if (z * z > limit2) return beyond;
        const float x = dot(off, x_), y = dot(off, y_);
        // For points below the longest side (y <= 0), that side is nearest, because both of its angles are at
        // most 90 degrees.
        float least = 0;
        if (y <= 0 || height_ == 0) {
            const float to_x = x - clamped(x, along_);
            least = to_x * to_x + y * y;
        } else {
            const float rest = along_ - foot_, from_end = along_ - x;
            const bool left = x * height_ < y * foot_, right = from_end * height_ < y * rest;
            if (left || right) least = beyond;
            if (left) least = (std::min)(least, to_side2(x, y, foot_, per_left2_));
            if (right) least = (std::min)(least, to_side2(from_end, y, rest, per_right2_));
        }
        return least + z * z;
    }

private:
    static constexpr float beyond = (std::numeric_limits<float>::max)();

    static float clamped(float x, float most) noexcept { return (std::min)((std::max)(x, 0.0F), most); }
    /// Squared distance from the side between 0 and (foot, height).
    float to_side2(float x, float y, float foot, float per_length2) const noexcept {
        const float s = clamped((x * foot + y * height_) * per_length2, 1.0F);
        const float to_x = x - s * foot, to_y = y - s * height_;
        return to_x * to_x + to_y * to_y;
    }

    Vec<float, 3> origin_, x_, y_, z_;
    float along_;      ///< length of the longest side
    float foot_;       ///< x of the opposite corner
    float height_;     ///< y of the opposite corner
    float per_left2_;  ///< 1 / squared length of the side from 0 to that corner
    float per_right2_; ///< 1 / squared length of the side from the other end
};

/// Fills a lattice with the distance from triangles minus `margin`, at most `farthest`. Exact near the faces.
/// Sweeps over every second node along each axis propagate the nearest triangle (Bridson, Fluid simulation
/// for computer graphics, 2015, sec. 14.1). Each remaining node tests the triangles found for the adjacent
/// nodes of the sweeps. If these nodes are all farther than two margins plus two spacings, it takes the mean
/// of their distances instead. Far from the figure, the triangle found may not be the nearest, so the
/// distance may be too large; the cage encloses the figure nevertheless.
class SpaceDistance {
public:
    using Point = Vec<double, 3>;

    SpaceDistance(DistanceLattice<3>& lattice, std::span<const Corners<3>> triangles)
        : lattice_(lattice)
        , triangles_(triangles)
        , nearest_(lattice.size(), none) {
        frames_.reserve(triangles.size());
        for (const auto& corner : triangles) frames_.emplace_back(corner);
    }

    void fill(double margin, double farthest, const Running& running = {}) {
        const auto band = static_cast<float>(2 * margin);
        for (std::size_t node = 0; node < lattice_.size(); ++node)
            lattice_[node] = static_cast<float>(farthest + margin);
        measure_beside(running);
        for (unsigned directions = 0; directions < 8; ++directions) sweep(directions, farthest + margin);
        fill_between(band);
        for (const bool down : {false, true}) exchange(down, band);
        for (std::size_t node = 0; node < lattice_.size(); ++node)
            lattice_[node] = static_cast<float>((std::min)(double(lattice_[node]) - margin, farthest));
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    CAGEFORM_DETAIL_FLATTEN void offer(std::size_t node, const Point& position, std::uint32_t triangle) {
        const float now2 = lattice_[node] * lattice_[node];
        const float d2 = frames_[triangle].distance2(vec_cast<float>(position), now2);
        if (!(d2 < now2)) return;
        lattice_[node] = std::sqrt(d2);
        nearest_[node] = triangle;
    }

    /// Computes exact distances at the nodes in the bounds of each triangle, widened by one spacing. Slabs of
    /// eight planes across the last axis run in parallel; each processes its triangles in order.
    void measure_beside(const Running& running) {
        constexpr std::size_t thick = 8;
        const double h = lattice_.spacing(), low = lattice_.position(0)[2];
        const std::size_t slabs = (lattice_.count()[2] + thick - 1) / thick;
        std::vector<std::size_t> ends(slabs + 1, 0); // end of each slab's list
        std::vector<std::uint32_t> listed;
        const auto for_each_slab = [&](const auto& visit) {
            for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
                const auto& [a, b, c] = triangles_[t];
                const auto slab_at = [&](double z) {
                    return std::size_t(std::clamp((z - low) / (h * thick), 0.0, double(slabs - 1)));
                };
                const std::size_t last = slab_at((std::max)({a[2], b[2], c[2]}) + h);
                for (std::size_t s = slab_at((std::min)({a[2], b[2], c[2]}) - h); s <= last; ++s) visit(s, t);
            }
        };
        for_each_slab([&](std::size_t s, std::uint32_t) { ++ends[s + 1]; });
        for (std::size_t s = 0; s < slabs; ++s) ends[s + 1] += ends[s];
        listed.resize(ends[slabs]);
        for_each_slab([&](std::size_t s, std::uint32_t t) { listed[ends[s]++] = t; });
        in_parallel(running, slabs, 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t s = first; s < last; ++s) {
                const double from = low + h * (double(s * thick) - 0.5); // midway between planes
                for (std::size_t k = s > 0 ? ends[s - 1] : 0; k < ends[s]; ++k)
                    measure_beside(listed[k], from, from + h * thick);
            }
        });
    }
    /// Measures distances from one triangle in the planes from `from` to `to`. Skips nodes farther than two
    /// spacings from the plane of the triangle.
    void measure_beside(std::uint32_t t, double from, double to) {
        const auto& corner = triangles_[t];
        const double h = lattice_.spacing();
        const auto n = cross(corner[1] - corner[0], corner[2] - corner[0]);
        const double size = length(n);
        auto box = bounds_of(std::span<const Point>(corner)).widened(h);
        box.lower[2] = (std::max)(box.lower[2], from);
        box.upper[2] = (std::min)(box.upper[2], to);
        lattice_.for_each_row(box, [&](std::size_t row, std::size_t first, std::size_t last) {
            Point p = lattice_.position(row);
            const double low = p[0];
            for (std::size_t i = first; i < last; ++i) {
                p[0] = low + h * double(i);
                if (size > 0 && std::fabs(dot(n, p - corner[0])) > 2 * h * size) continue;
                offer(row + i, p, t);
            }
        });
    }

    /// One pass over the nodes with even indices; each tests the triangles of its predecessors. Bit k of
    /// `directions` reverses axis k. A predecessor's triangle can be nearer only if the predecessor's
    /// distance minus the distance between the two nodes is smaller.
    void sweep(unsigned directions, double farthest) {
        const auto& stride = lattice_.stride();
        const auto h = static_cast<float>(lattice_.spacing());
        std::array<std::ptrdiff_t, 3> step{};
        std::array<std::size_t, 3> last{}; // even indices, halved
        for (std::size_t k = 0; k < 3; ++k) {
            const bool down = (directions >> k & 1U) != 0;
            step[k] = 2 * (down ? std::ptrdiff_t(stride[k]) : -std::ptrdiff_t(stride[k]));
            last[k] = (lattice_.count()[k] - 1) / 2;
        }
        std::array<std::ptrdiff_t, 7> to_other{};
        for (unsigned about = 1; about < 8; ++about) {
            for (std::size_t k = 0; k < 3; ++k) to_other[about - 1] += (about >> k & 1U) != 0 ? step[k] : 0;
        }
        const auto number = [&](std::size_t k, std::size_t i) {
            return 2 * ((directions >> k & 1U) != 0 ? last[k] - 1 - i : i + 1);
        };
        for (std::size_t a = 0; a < last[2]; ++a) {
            for (std::size_t b = 0; b < last[1]; ++b) {
                const std::size_t row = number(2, a) * stride[2] + number(1, b) * stride[1];
                Point p = lattice_.position(row);
                const double low = p[0];
                for (std::size_t c = 0; c < last[0]; ++c) {
                    const std::size_t node = row + number(0, c);
                    p[0] = low + lattice_.spacing() * double(number(0, c));
                    for (const auto off : to_other) {
                        const auto other = static_cast<std::size_t>(std::ptrdiff_t(node) + off);
                        if (nearest_[other] == nearest_[node] || nearest_[other] == none) continue;
                        const float least = lattice_[other] - 3.5F * h; // the step is at most 2 sqrt(3) h
                        if (least < lattice_[node] && double(lattice_[other]) < farthest)
                            offer(node, p, nearest_[other]);
                    }
                }
            }
        }
    }

    /// At each node with an odd index, tests the triangles of the two, four or eight adjacent even nodes.
    void fill_between(float band) {
        const auto& count = lattice_.count();
        const auto& stride = lattice_.stride();
        const float wide = band + 2 * static_cast<float>(lattice_.spacing()); // covers all nodes in the band
        std::array<std::size_t, 3> n{};
        for (n[2] = 0; n[2] < count[2]; ++n[2]) {
            for (n[1] = 0; n[1] < count[1]; ++n[1]) {
                const std::size_t row = n[2] * stride[2] + n[1] * stride[1];
                Point p = lattice_.position(row);
                const double low = p[0];
                for (n[0] = 0; n[0] < count[0]; ++n[0]) {
                    if (((n[0] | n[1] | n[2]) & 1U) == 0) continue;
                    const std::size_t node = row + n[0];
                    p[0] = low + lattice_.spacing() * double(n[0]);
                    std::array<std::size_t, 8> others{node};
                    std::size_t others_count = 1;
                    for (std::size_t k = 0; k < 3; ++k) {
                        if ((n[k] & 1U) == 0) continue;
                        const bool has_next = n[k] + 1 < count[k];
                        for (std::size_t i = 0; i < others_count; ++i) {
                            if (has_next) others[others_count + i] = others[i] + stride[k];
                            others[i] -= stride[k];
                        }
                        others_count *= has_next ? 2 : 1;
                    }
                    float sum = 0, least = lattice_[node];
                    for (std::size_t i = 0; i < others_count; ++i) {
                        sum += lattice_[others[i]];
                        least = (std::min)(least, lattice_[others[i]]);
                    }
                    if (least > wide) {
                        lattice_[node] = sum / static_cast<float>(others_count);
                        continue;
                    }
                    std::uint32_t last = nearest_[node];
                    for (std::size_t i = 0; i < others_count; ++i) {
                        const std::uint32_t triangle = nearest_[others[i]];
                        if (triangle == last || triangle == none) continue;
                        offer(node, p, triangle);
                        last = triangle;
                    }
                }
            }
        }
    }

    /// One pass over all nodes closer than `band`; each tests the triangles of its neighbours.
    void exchange(bool down, float band) {
        const auto& count = lattice_.count();
        const auto& stride = lattice_.stride();
        for (std::size_t a = 1; a + 1 < count[2]; ++a) {
            for (std::size_t b = 1; b + 1 < count[1]; ++b) {
                const std::size_t row =
                    (down ? count[2] - 1 - a : a) * stride[2] + (down ? count[1] - 1 - b : b) * stride[1];
                Point p = lattice_.position(row);
                const double low = p[0];
                for (std::size_t c = 1; c + 1 < count[0]; ++c) {
                    const std::size_t i = down ? count[0] - 1 - c : c, node = row + i;
                    if (!(lattice_[node] < band)) continue;
                    p[0] = low + lattice_.spacing() * double(i);
                    std::uint32_t last = nearest_[node];
                    for (std::size_t k = 0; k < 3; ++k) {
                        for (const auto other : {node - stride[k], node + stride[k]}) {
                            const std::uint32_t triangle = nearest_[other];
                            if (triangle == last || triangle == none) continue;
                            offer(node, p, triangle);
                            last = triangle;
                        }
                    }
                }
            }
        }
    }

    DistanceLattice<3>& lattice_;
    std::span<const Corners<3>> triangles_;
    std::vector<TriangleFrame> frames_;
    std::vector<std::uint32_t> nearest_; ///< nearest triangle found, per node
};

} // namespace cageform::inline CAGEFORM_ABI::detail
