// make_cage, step 1: a lattice of distances from the figure minus the margin. The cage must enclose all nodes
// with a negative value.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>

#include <cstdint>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Samples f = distance from the figure − margin at the nodes of a regular lattice; multilinear in between.
/// Single precision suffices because local coordinates are about 1.
template <std::size_t D>
class DistanceLattice {
public:
    using Point = Vec<double, D>;
    using Count = std::array<std::size_t, D>;

    DistanceLattice() = default;
    /// Places nodes at `low` + `spacing` (i, j, …), all with f = `farthest`.
    DistanceLattice(const Point& low, double spacing, const Count& count, double farthest)
        : low_(low)
        , h_(spacing)
        , count_(count)
        , far_(farthest) {
        std::size_t size = 1;
        for (std::size_t k = 0; k < D; ++k) {
            stride_[k] = size;
            size *= count[k];
        }
        f_.assign(size, static_cast<float>(farthest));
    }

    double spacing() const noexcept { return h_; }
    /// Value of f outside the lattice.
    double farthest() const noexcept { return far_; }
    const Count& count() const noexcept { return count_; }
    const Count& stride() const noexcept { return stride_; }
    std::size_t size() const noexcept { return f_.size(); }
    float& operator[](std::size_t node) noexcept { return f_[node]; }
    const float& operator[](std::size_t node) const noexcept { return f_[node]; }
    /// Returns the index of a node along each axis.
    Count numbers(std::size_t node) const noexcept {
        Count n{};
        auto rest = static_cast<std::uint32_t>(node); // 32 bits suffice, and their division is much faster
        for (std::size_t k = D - 1; k > 0; --k) {
            const auto stride = static_cast<std::uint32_t>(stride_[k]);
            n[k] = rest / stride;
            rest %= stride;
        }
        n[0] = rest;
        return n;
    }
    Point position(std::size_t node) const noexcept {
        const Count n = numbers(node);
        Point p = low_;
        for (std::size_t k = 0; k < D; ++k) p[k] += h_ * double(n[k]);
        return p;
    }
    /// Squared distance between two nodes, in spacings.
    double squared_steps(std::size_t a, std::size_t b) const noexcept {
        const Count na = numbers(a), nb = numbers(b);
        double sum = 0;
        for (std::size_t k = 0; k < D; ++k)
            sum += (double(na[k]) - double(nb[k])) * (double(na[k]) - double(nb[k]));
        return sum;
    }

    /// Interpolates f; returns `farthest` outside the lattice.
    double value(const Point& p) const noexcept {
        std::size_t node = 0;
        std::array<double, D> fraction;
        for (std::size_t k = 0; k < D; ++k) {
            const double x = (p[k] - low_[k]) / h_;
            if (!(x >= 0 && x < double(count_[k] - 1))) return far_;
            const auto i = static_cast<std::size_t>(x);
            fraction[k] = x - double(i);
            node += i * stride_[k];
        }
        const float* f = f_.data() + node;
        const auto along_x = [&](std::size_t at) {
            return (1 - fraction[0]) * double(f[at]) + fraction[0] * double(f[at + 1]);
        };
        const auto along_y = [&](std::size_t at) {
            return (1 - fraction[1]) * along_x(at) + fraction[1] * along_x(at + stride_[1]);
        };
        if constexpr (D == 2) {
            return along_y(0);
        } else {
            return (1 - fraction[2]) * along_y(0) + fraction[2] * along_y(stride_[2]);
        }
    }

    /// Adds a capsule: f = min(f, distance from the segment − `radius`) at nodes up to `reach` beyond the
    /// radius.
    void add_capsule(const Point& a, const Point& b, double radius, double reach) noexcept {
        const double all = radius + reach;
        const auto box = bounds_of(std::span<const Point>(std::array{a, b})).widened(all);
        const auto e = vec_cast<float>(b - a);
        const double length2 = dot(b - a, b - a);
        const float inverse = length2 > 0 ? static_cast<float>(1 / length2) : 0.0F;
        const auto h = static_cast<float>(h_), r = static_cast<float>(radius);
        for_each_row(box, [&](std::size_t row, std::size_t first, std::size_t last) {
            auto d = vec_cast<float>(position(row) - a);
            const float from = d[0];
            for (std::size_t i = first; i < last; ++i) {
                d[0] = from + h * static_cast<float>(i);
                const float s = (std::min)((std::max)(dot(d, e) * inverse, 0.0F), 1.0F);
                const auto off = d - s * e;
                f_[row + i] = (std::min)(f_[row + i], std::sqrt(dot(off, off)) - r);
            }
        });
    }

    /// Calls visit(row, first, last) for each row along the first axis that intersects the box. `row` is the
    /// first node of the row; nodes row + first … row + last − 1 lie in the box.
    template <class Visit>
    void for_each_row(const Bounds<double, D>& box, const Visit& visit) const {
        Count first{}, last{};
        for (std::size_t k = 0; k < D; ++k) {
            const double from = std::ceil((box.lower[k] - low_[k]) / h_);
            const double to = std::floor((box.upper[k] - low_[k]) / h_) + 1;
            first[k] = static_cast<std::size_t>(std::clamp(from, 0.0, double(count_[k])));
            last[k] = static_cast<std::size_t>(std::clamp(to, 0.0, double(count_[k])));
        }
        for (std::size_t j = first[1]; j < last[1]; ++j) {
            if constexpr (D == 2) {
                visit(j * stride_[1], first[0], last[0]);
            } else {
                for (std::size_t k = first[2]; k < last[2]; ++k)
                    visit(j * stride_[1] + k * stride_[2], first[0], last[0]);
            }
        }
    }

    /// Marks the nodes with open(node) that are connected to the lattice boundary along lattice lines. Fills
    /// runs along the first axis.
    template <class Open>
    std::vector<std::uint8_t> flood(const Open& open) const {
        std::vector<std::uint8_t> reached(f_.size(), 0);
        struct Run {
            std::size_t begin, end;
        };
        std::vector<Run> front;
        const auto is_new = [&](std::size_t node) { return reached[node] == 0 && open(node); };
        const auto enter = [&](std::size_t begin, std::size_t end) {
            for (std::size_t node = begin; node < end; ++node) {
                if (!is_new(node)) continue;
                const std::size_t row = node - node % count_[0];
                Run run{node, node + 1};
                while (run.begin > row && is_new(run.begin - 1)) --run.begin;
                while (run.end < row + count_[0] && is_new(run.end)) ++run.end;
                for (std::size_t i = run.begin; i < run.end; ++i) reached[i] = 1;
                front.push_back(run);
                node = run.end;
            }
        };
        for (std::size_t row = 0; row < f_.size(); row += count_[0]) {
            const Count n = numbers(row);
            bool on_rim = false;
            for (std::size_t k = 1; k < D; ++k) on_rim = on_rim || n[k] == 0 || n[k] + 1 == count_[k];
            const std::size_t end = row + count_[0];
            enter(row, on_rim ? end : row + 1);
            enter(end - 1, end);
        }
        while (!front.empty()) {
            const Run run = front.back();
            front.pop_back();
            const Count n = numbers(run.begin);
            for (std::size_t k = 1; k < D; ++k) {
                if (n[k] > 0) enter(run.begin - stride_[k], run.end - stride_[k]);
                if (n[k] + 1 < count_[k]) enter(run.begin + stride_[k], run.end + stride_[k]);
            }
        }
        return reached;
    }
    /// Marks the nodes connected to the lattice boundary through f > `level`.
    std::vector<std::uint8_t> outside(float level) const {
        return flood([&](std::size_t node) { return f_[node] > level; });
    }

    /// Calls visit(neighbour) for the neighbours along lattice lines: up to 4 in 2D, 6 in 3D.
    template <class Visit>
    void for_each_neighbour(std::size_t node, const Visit& visit) const {
        const Count n = numbers(node);
        for (std::size_t k = 0; k < D; ++k) {
            if (n[k] > 0) visit(node - stride_[k]);
            if (n[k] + 1 < count_[k]) visit(node + stride_[k]);
        }
    }
    /// Calls visit(neighbour) for all adjacent nodes, also diagonal ones: up to 8 in 2D, 26 in 3D.
    template <class Visit>
    void for_each_adjacent(std::size_t node, const Visit& visit) const {
        Count from = numbers(node), to = from;
        for (std::size_t k = 0; k < D; ++k) {
            to[k] = (std::min)(from[k] + 1, count_[k] - 1);
            if (from[k] > 0) --from[k];
        }
        const auto visit_row = [&](std::size_t row) {
            for (std::size_t other = row + from[0]; other <= row + to[0]; ++other) {
                if (other != node) visit(other);
            }
        };
        for (std::size_t j = from[1]; j <= to[1]; ++j) {
            if constexpr (D == 2) {
                visit_row(j * stride_[1]);
            } else {
                for (std::size_t k = from[2]; k <= to[2]; ++k) visit_row(j * stride_[1] + k * stride_[2]);
            }
        }
    }

    /// Adds the mirror image: f = min(f, f reflected about the middle of the first axis).
    void mirror() noexcept {
        for (std::size_t node = 0; node < f_.size(); ++node) {
            const std::size_t column = node % count_[0], image = node - column + (count_[0] - 1 - column);
            f_[node] = f_[image] = (std::min)(f_[node], f_[image]);
        }
    }

private:
    Point low_{};
    double h_ = 1;
    Count count_{};
    Count stride_{};
    double far_ = 0;
    std::vector<float> f_;
};

/// Adds the convex hull: f = min(f, distance function of the hull). 128 half-planes (3D: 512 half-spaces)
/// approximate the hull from outside, looser by about 0.1 %.
///
///   support  support(direction): extent of the figure along a unit vector, margin included
template <std::size_t D, class Support>
void fill_hull(DistanceLattice<D>& lattice, const Support& support) {
    using Point = Vec<double, D>;
    constexpr std::size_t directions = D == 2 ? 128 : 512;
    std::vector<Point> normals;
    std::vector<double> offsets;
    for (std::size_t k = 0; k < directions; ++k) {
        Point n{};
        if constexpr (D == 2) {
            const double angle = 2 * std::numbers::pi * double(k) / directions;
            n = {std::cos(angle), std::sin(angle)};
        } else { // a spherical spiral spreads the directions evenly
            const double z = 1 - (2 * double(k) + 1) / directions,
                         angle = std::numbers::pi * (3 - std::sqrt(5.0)) * double(k);
            const double r = std::sqrt(1 - z * z);
            n = {r * std::cos(angle), r * std::sin(angle), z};
        }
        normals.push_back(n);
        offsets.push_back(support(n));
    }
    for (std::size_t node = 0; node < lattice.size(); ++node) {
        const Point p = lattice.position(node);
        double most = std::numeric_limits<double>::lowest();
        for (std::size_t k = 0; k < directions; ++k) most = (std::max)(most, dot(normals[k], p) - offsets[k]);
        lattice[node] = (std::min)(lattice[node], static_cast<float>(most));
    }
}

/// Largest number of lattice nodes; each takes about 70 bytes.
inline constexpr std::size_t most_lattice_nodes = std::size_t{1} << 24;

/// True if f >= 0 along a segment, up to a quarter of the spacing (the resolution of the lattice). Steps by
/// f, which is safe because its slope is at most 1 (Hart, Sphere tracing, 1996).
inline bool is_clear(const DistanceLattice<2>& lattice, const Vec<double, 2>& a,
                     const Vec<double, 2>& b) noexcept {
    const auto e = b - a;
    const double whole = length(e), least = -0.25 * lattice.spacing();
    for (double t = 0; t < whole;) {
        const double f = lattice.value(a + (t / whole) * e);
        if (f < least) return false;
        t += (std::max)(f, 0.5 * lattice.spacing());
    }
    return lattice.value(b) >= least;
}

/// Sets f to at most -`depth` at nodes inside a painted area, scanning rows for crossings with the outlines.
inline void fill_area(DistanceLattice<2>& lattice, std::span<const DrawnSegment<double>> outlines,
                      bool even_odd, double depth) {
    const Vec<double, 2> low = lattice.position(0);
    const double h = lattice.spacing();
    const std::size_t width = lattice.count()[0];
    struct Crossing {
        double x;
        int winding;
    };
    std::vector<std::vector<Crossing>> rows(lattice.count()[1]);
    for (const auto& edge : outlines) {
        const bool up = edge.b[1] > edge.a[1];
        const auto& lower = up ? edge.a : edge.b;
        const auto& upper = up ? edge.b : edge.a;
        const auto row = [&](double y) { return std::ceil((y - low[1]) / h); };
        for (auto j = static_cast<std::size_t>((std::max)(row(lower[1]), 0.0)); double(j) < row(upper[1]);
             ++j) {
            const double t = (low[1] + h * double(j) - lower[1]) / (upper[1] - lower[1]);
            rows[j].push_back({lower[0] + t * (upper[0] - lower[0]), up ? 1 : -1});
        }
    }
    for (std::size_t j = 0; j < lattice.count()[1]; ++j) {
        auto& crossings = rows[j];
        std::sort(crossings.begin(), crossings.end(),
                  [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
        int winding = 0;
        std::size_t i = 0;
        for (const auto& crossing : crossings) {
            const bool painted = even_odd ? winding % 2 != 0 : winding != 0;
            for (; low[0] + h * double(i) < crossing.x; ++i) {
                float& f = lattice[j * width + i];
                if (painted) f = (std::min)(f, static_cast<float>(-depth));
            }
            winding += crossing.winding;
        }
    }
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
