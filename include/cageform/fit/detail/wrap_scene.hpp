// The figures of a wrap in units of the target's height, and the samples of the space about the source.
#pragma once

#include <cageform/fit/closest_places.hpp>
#include <cageform/fit/types/wrap.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>
#include <cageform/pose/detail/stretches.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Points, and what the stages so far make of them.
struct MovedPoints {
    std::vector<Vec<double, 3>> rest, now;
    std::vector<LinearMap<double, 3>> jacobians; ///< of the stages so far; empty: the identity

    std::size_t size() const noexcept { return rest.size(); }
    void start() {
        now = rest;
        jacobians.clear();
    }
};

/// All lengths are in units of the target's height.
struct WrapScene {
    std::vector<SurfaceMesh::Face> source_faces;
    MovedPoints source, followers, samples, marks;
    double shell = 0; ///< width of the sampled space about source and followers
    std::vector<std::array<std::uint32_t, 2>> neighbours; ///< pairs of samples along the axes of their grid
    std::vector<Vec<double, 3>> mark_targets;
    std::vector<double> mark_weights; ///< their sum is 1

    ClosestPlaces target;
    std::vector<Vec<double, 3>> back_points, back_normals; ///< places of the target that seek the source
    std::size_t back_vertices = 0;                         ///< the first places are vertices of the target

    /// Followers outside the source: the follower, and the vertex of the source whose outside it keeps to.
    struct Guarded {
        std::uint32_t follower, vertex;
    };
    std::vector<Guarded> guarded;
};

/// The order of n items by a fixed pseudo-random permutation (Fisher, Yates; the generator of Knuth, MMIX).
inline std::vector<std::uint32_t> shuffled(std::size_t count) {
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    std::uint64_t state = 1;
    for (std::size_t n = count; n > 1; --n) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        std::swap(order[n - 1], order[(state >> 33) % n]);
    }
    return order;
}

/// Chooses the places of the target that seek the source: vertices with a face, and the centres of all faces
/// if both are few.
inline void choose_back_places(WrapScene& scene, std::span<const SurfaceMesh::Face> faces) {
    constexpr std::size_t most = 8000;
    const auto vertices = scene.target.vertices(), normals = scene.target.normals();
    for (const std::uint32_t i : shuffled(vertices.size())) {
        if (dot(normals[i], normals[i]) == 0 || scene.back_points.size() == most) continue;
        scene.back_points.push_back(vertices[i]);
        scene.back_normals.push_back(normals[i]);
    }
    scene.back_vertices = scene.back_points.size();
    if (scene.back_vertices + faces.size() > most) return;
    for (const auto& [a, b, c] : faces) {
        const auto normal = unit_or_zero(normals[a] + normals[b] + normals[c]);
        if (dot(normal, normal) == 0) continue;
        scene.back_points.push_back((1.0 / 3) * (vertices[a] + vertices[b] + vertices[c]));
        scene.back_normals.push_back(normal);
    }
}

/// Samples on a grid, and pairs of neighbours along its axes.
struct GridSamples {
    std::vector<Vec<double, 3>> places;
    std::vector<std::array<std::uint32_t, 2>> neighbours;
};

/// Samples the places of a grid that a test accepts. The grid is centred in the box, so that mirrored figures
/// have mirrored samples. Throws std::bad_alloc.
///
///   make_test  make_test() returns a function object: test(place) tells whether to keep a place. Each call
///              of the loop's body makes one object
template <class MakeTest>
Status sample_grid(const Bounds<double, 3>& box, double spacing, const MakeTest& make_test,
                   const Running& running, GridSamples& samples) {
    std::array<std::size_t, 3> counts;
    Vec<double, 3> lower;
    for (std::size_t k = 0; k < 3; ++k) {
        const double extent = box.upper[k] - box.lower[k];
        counts[k] = std::size_t(std::floor(extent / spacing)) + 1;
        lower[k] = box.lower[k] + 0.5 * (extent - spacing * double(counts[k] - 1));
    }
    const std::size_t row = counts[0], rows = counts[1] * counts[2];
    const auto place = [&](std::size_t n) {
        return lower + spacing * vec_cast<double>(
                                     Vec<std::size_t, 3>{n % row, n / row % counts[1], n / row / counts[1]});
    };
    std::vector<char> is_sample(row * rows);
    const Status status = for_each_block(rows, running, [&](std::size_t begin, std::size_t end) {
        auto test = make_test();
        for (std::size_t n = begin * row; n < end * row; ++n) is_sample[n] = test(place(n)) ? 1 : 0;
    });
    if (status != Status::ok) return status;
    std::vector<std::uint32_t> number(is_sample.size(), no_vertex);
    const std::array<std::size_t, 3> stride{1, row, row * counts[1]};
    for (std::size_t n = 0; n < is_sample.size(); ++n) {
        if (is_sample[n] == 0) continue;
        number[n] = std::uint32_t(samples.places.size());
        samples.places.push_back(place(n));
        for (std::size_t k = 0; k < 3; ++k) {
            if (n / stride[k] % counts[k] > 0 && is_sample[n - stride[k]] != 0)
                samples.neighbours.push_back({number[n - stride[k]], number[n]});
        }
    }
    return samples.places.empty() ? Status::samples_missing : Status::ok;
}

/// Whether points of a set lie within a distance of given places.
class NearPoints {
public:
    explicit NearPoints(std::span<const Vec<double, 3>> points)
        : points_(points)
        , tree_(points.size(),
                [points](std::uint32_t i) { return Bounds<double, 3>{points[i], points[i]}; }) {}

    bool has(const Vec<double, 3>& p, double distance) const {
        bool found = false;
        tree_.for_each_near(p, distance * distance, [&](std::uint32_t i) {
            found = found || dot(points_[i] - p, points_[i] - p) < distance * distance;
            return found ? -1.0 : distance * distance;
        });
        return found;
    }

private:
    std::span<const Vec<double, 3>> points_;
    BoxTree<3> tree_;
};

/// Samples the inside of the source, and a shell about the source and the followers.
///
///   spacing  of the grid; becomes wider for a grid of more than a million places
inline Status sample_shell(const WrapScene& scene, const ClosestPlaces& source, double& spacing,
                           const Running& running, GridSamples& samples) {
    using Point = Vec<double, 3>;
    constexpr double most = 1e6;
    Bounds<double, 3> box = bounds_of(std::span<const Point>(scene.source.rest));
    if (scene.followers.size() > 0) box.include(bounds_of(std::span<const Point>(scene.followers.rest)));
    const auto extent = box.upper - box.lower;
    const auto places = [&] {
        return (extent[0] / spacing + 5) * (extent[1] / spacing + 5) * (extent[2] / spacing + 5);
    };
    while (places() > most) spacing *= 1.1;
    const NearPoints followers(scene.followers.rest);
    const auto make_test = [&] {
        return [&, guess = no_vertex](const Point& p) mutable {
            const ClosestPlaces::Place at = source.find(p, {}, guess);
            guess = at.face;
            const auto e = p - at.place;
            return dot(e, e) < scene.shell * scene.shell || dot(e, at.normal) < 0 ||
                   followers.has(p, scene.shell);
        };
    };
    return sample_grid(box.widened(scene.shell), spacing, make_test, running, samples);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
