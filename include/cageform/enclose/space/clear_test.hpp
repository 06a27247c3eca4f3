// make_cage in 3D: tests whether triangles are clear of the figure.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/enclose/detail/distance_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Tests whether f >= 0 on triangles, up to a twentieth of the spacing at the sampled points. The slope of f
/// is at most 1, so a triangle is clear if it lies in the sphere of radius f around its centroid. A larger
/// sphere also suffices: radius r with r^2 = (0.8 spacings)^2 + 2 margin f. The border of f < 0 has at most
/// the curvature of a ball whose radius is the margin. Between samples at the distance r, the border rises by
/// at most r^2 / (2 margin) - f, an eighth of the spacing. Triangles outside both spheres are bisected.
class ClearTest {
public:
    using Weights = Vec<double, 3>;

    ClearTest(const DistanceLattice<3>& lattice, double margin)
        : f_(&lattice[0])
        , stride_(lattice.stride())
        , low_(lattice.position(0))
        , per_spacing_(1 / lattice.spacing())
        , scale_(static_cast<float>(1 / lattice.spacing()))
        , twice_margin_(static_cast<float>(2 * margin / lattice.spacing()))
        , farthest_(static_cast<float>(lattice.farthest() / lattice.spacing())) {
        for (std::size_t k = 0; k < 3; ++k) last_[k] = static_cast<float>(lattice.count()[k] - 1);
    }

    bool is_clear(const Vec<double, 3>& p) const noexcept { return !(value(to_spacings(p)) < least); }
    bool is_clear(const Corners<3>& corner) const noexcept {
        Weights where;
        return is_clear(corner[0]) && is_clear(corner[1]) && is_clear(corner[2]) &&
               is_clear_between(corner, where);
    }

    /// Tests triangles whose corners are clear. Successive calls test similar triangles, which mostly fail at
    /// the same points, so the points of previous failures are sampled first.
    ///
    ///   triangle  triangle(k): the corners of triangle k, k < count
    template <class Triangle>
    bool are_clear(std::size_t count, const Triangle& triangle) {
        for (const auto& [k, w] : failures_) {
            const Corners<3> corner = triangle(k);
            if (!is_clear(w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2])) return false;
        }
        undecided_.clear();
        for (std::size_t k = 0; k < count; ++k) {
            const Sample middle = sample(places_of(triangle(k)));
            if (middle.f < least) return fail(k, {1.0 / 3, 1.0 / 3, 1.0 / 3});
            if (!middle.proves_clear) undecided_.push_back(k);
        }
        Weights where;
        for (const std::size_t k : undecided_) {
            if (!is_clear_between(triangle(k), where)) return fail(k, where);
        }
        return true;
    }
    /// Forgets previous failures; call it before testing unrelated triangles.
    void reset() noexcept { failures_.clear(); }

private:
    struct Failure {
        std::size_t triangle;
        Weights at;
    };
    using LatticePoint = Vec<float, 3>; ///< in spacings from node 0
    static constexpr float least = -0.05F;

    LatticePoint to_spacings(const Vec<double, 3>& p) const noexcept {
        return vec_cast<float>(per_spacing_ * (p - low_));
    }
    /// f in spacings.
    float value(const LatticePoint& x) const noexcept {
        std::size_t node = 0;
        std::array<float, 3> t{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(x[k] >= 0 && x[k] < last_[k])) return farthest_;
            const auto i = static_cast<std::int32_t>(x[k]);
            t[k] = x[k] - static_cast<float>(i);
            node += static_cast<std::size_t>(i) * stride_[k];
        }
        const float* f = f_ + node;
        const auto along_x = [&](std::size_t at) { return f[at] + t[0] * (f[at + 1] - f[at]); };
        const auto along_y = [&](std::size_t at) {
            const float low = along_x(at);
            return low + t[1] * (along_x(at + stride_[1]) - low);
        };
        const float low = along_y(0);
        return scale_ * (low + t[2] * (along_y(stride_[2]) - low));
    }

    using Triangle = std::array<LatticePoint, 3>;
    Triangle places_of(const Corners<3>& corner) const noexcept {
        return {to_spacings(corner[0]), to_spacings(corner[1]), to_spacings(corner[2])};
    }
    struct Sample {
        LatticePoint middle;
        float f;
        bool proves_clear; ///< true if this sample proves that the triangle is clear
    };
    Sample sample(const Triangle& corner) const noexcept {
        const LatticePoint middle = (1.0F / 3) * (corner[0] + corner[1] + corner[2]);
        const float f = value(middle), off = (std::max)(f, 0.0F);
        float reach2 = 0;
        for (const LatticePoint& p : corner) reach2 = (std::max)(reach2, dot(p - middle, p - middle));
        return {middle, f, reach2 <= (std::max)(off * off, 0.64F + twice_margin_ * off)};
    }

    /// Tests a triangle whose corners are clear; if it fails, sets `where` to the barycentric weights of the
    /// point.
    CAGEFORM_DETAIL_FLATTEN bool is_clear_between(const Corners<3>& whole, Weights& where) const noexcept {
        // One half is pending per bisection. About 30 bisections reduce a side of thousands of spacings to
        // one; triangles that need more than 64 are rejected.
        std::array<Triangle, 64> waiting;
        std::size_t count = 0;
        Triangle corner = places_of(whole);
        for (;;) {
            const Sample at = sample(corner);
            if (at.f < least) {
                where = weights_of(whole, low_ + (1 / per_spacing_) * vec_cast<double>(at.middle));
                return false;
            }
            if (at.proves_clear) {
                if (count == 0) return true;
                corner = waiting[--count];
                continue;
            }
            if (count == waiting.size()) return false;
            std::array<float, 3> side2{}; // side opposite to each corner
            for (std::size_t k = 0; k < 3; ++k) {
                const LatticePoint side = corner[(k + 2) % 3] - corner[(k + 1) % 3];
                side2[k] = dot(side, side);
            }
            const std::size_t k = side2[0] < side2[1]   ? (side2[1] < side2[2] ? 2 : 1)
                                  : side2[0] < side2[2] ? 2
                                                        : 0;
            const LatticePoint a = corner[k], b = corner[(k + 1) % 3], c = corner[(k + 2) % 3];
            const LatticePoint half = 0.5F * (b + c);
            waiting[count++] = {a, half, c};
            corner = {a, b, half};
        }
    }
    bool fail(std::size_t triangle, const Weights& at) {
        auto found = std::find_if(failures_.begin(), failures_.end(),
                                  [&](const Failure& r) { return r.triangle == triangle; });
        if (found == failures_.end()) found = failures_.insert(found, Failure{});
        *found = {triangle, at};
        std::iter_swap(found, failures_.begin());
        return false;
    }
    /// Barycentric weights of a point; those of the centroid if the triangle has no area.
    static Weights weights_of(const Corners<3>& corner, const Vec<double, 3>& p) noexcept {
        const auto u = corner[1] - corner[0], v = corner[2] - corner[0], to = p - corner[0];
        const auto n = cross(u, v);
        const double size2 = dot(n, n);
        if (!(size2 > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
        const double s = dot(n, cross(to, v)) / size2, t = dot(n, cross(u, to)) / size2;
        return {1 - s - t, s, t};
    }

    const float* f_;
    std::array<std::size_t, 3> stride_;
    Vec<double, 3> low_;
    double per_spacing_;
    float scale_;        ///< 1 / spacing
    float twice_margin_; ///< in spacings, like the distances below
    float farthest_;
    std::array<float, 3> last_{};        ///< index of the last node along each axis
    std::vector<Failure> failures_;      ///< latest first
    std::vector<std::size_t> undecided_; ///< triangles of `are_clear` that need more samples
};

} // namespace cageform::inline CAGEFORM_ABI::detail
