// Matches between a moved source and the target, in both directions, and the pulls that follow from them.
#pragma once

#include <cageform/fit/detail/wrap_scene.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Robust weight of a match at a distance (Geman, McClure: ρ = (σ²/(σ² + d²))²).
inline double robust_weight(double distance2, double sigma) noexcept {
    const double share = sigma * sigma / (sigma * sigma + distance2);
    return share * share;
}

/// The pull of a match: along the target's normal, and a tenth of the tangential part.
inline Vec<double, 3> pull_of(const Vec<double, 3>& d, const Vec<double, 3>& normal) noexcept {
    constexpr double tangential = 0.1;
    const auto along = dot(d, normal) * normal;
    return along + tangential * (d - along);
}

/// Matches of some vertices of the source, of places of the target, and of guarded followers.
class WrapMatches {
    using Point = Vec<double, 3>;

public:
    static constexpr double least_cosine = 0.3; ///< of the normals of a match

    ///   returning  whether matches that come back to the same part of the source keep their full weight
    WrapMatches(WrapScene& scene, const std::vector<std::uint32_t>& vertices, double normal_length,
                bool returning, const Running& running)
        : scene_(scene)
        , vertices_(vertices)
        , kappa_(normal_length)
        , returning_(returning)
        , running_(running)
        , guard_faces_(scene.guarded.size(), no_vertex) {
        scene.target.set_normal_length(normal_length);
        restart();
    }
    /// Forgets the matches, after a change of the given vertices.
    void restart() {
        forward_.assign(vertices_.size(), {});
        back_.assign(scene_.back_points.size(), no_vertex);
    }

    /// Sets the pulls of the vertices.
    ///
    ///   places, normals  of all vertices of the moved source
    ///   renew            whether to renew the scale of the robust weights
    void find(const std::vector<Point>& places, const std::vector<Point>& normals, bool renew) {
        const auto six = [&](std::size_t n) {
            return with_normal(places[vertices_[n]], normals[vertices_[n]], kappa_);
        };
        const BoxTree<6> tree(vertices_.size(),
                              [&](std::uint32_t n) { return Bounds<double, 6>{six(n), six(n)}; });
        const auto nearest_vertex = [&](const Vec<double, 6>& q, std::uint32_t guess) {
            std::uint32_t best = guess;
            double least = std::numeric_limits<double>::infinity();
            const auto visit = [&](std::uint32_t n) {
                const auto e = six(n) - q;
                const double square = dot(e, e);
                if (square < least || (square == least && n < best)) {
                    least = square;
                    best = n;
                }
                return with_ties(least);
            };
            if (guess != no_vertex) (void)visit(guess);
            tree.for_each_near(q, least, visit);
            return best;
        };
        in_parallel(running_, vertices_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                Match& match = forward_[n];
                const Point &y = places[vertices_[n]], &normal = normals[vertices_[n]];
                match.at = scene_.target.find(y, normal, match.at.face);
                match.is_match = match.at.face != no_vertex && dot(normal, match.at.normal) > least_cosine &&
                                 !scene_.target.is_on_rim(match.at.face);
                match.returns = false;
                if (!returning_ || !match.is_match) continue;
                const auto q = with_normal(match.at.place, match.at.normal, kappa_);
                match.back = nearest_vertex(q, match.back);
                match.returns = is_close(rest(match.back), rest(n), match_radius) &&
                                is_close(match.at.place, y, 3 * match_radius);
            }
        });
        in_parallel(running_, back_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const auto q = with_normal(scene_.back_points[k], scene_.back_normals[k], kappa_);
                back_[k] = nearest_vertex(q, back_[k]);
            }
        });
        if (renew) renew_scale(places);
        sum_pulls(places, normals);
    }

    /// The mean pull of vertex n of the given ones.
    const std::vector<Point>& pulls() const noexcept { return pulls_; }
    /// The RMS of all pulls.
    double rms() const noexcept {
        double sum = 0;
        for (const Point& u : pulls_) sum += dot(u, u);
        return std::sqrt(sum / double((std::max)(pulls_.size(), std::size_t{1})));
    }
    /// Returns the move of a guarded follower to the target's surface; zero outside the target.
    Point guard_pull(std::size_t n, const Point& x, const Point& normal) {
        const ClosestPlaces::Place at = scene_.target.find(x, normal, guard_faces_[n]);
        guard_faces_[n] = at.face;
        const double depth = at.face == no_vertex ? 0 : dot(at.place - x, at.normal);
        const bool counts =
            depth > 0 && dot(normal, at.normal) > least_cosine && !scene_.target.is_on_rim(at.face);
        return counts ? depth * at.normal : Point{};
    }
    /// Returns the 95th percentile of the distances of matched vertices.
    double upper_residual(const std::vector<Point>& places) const {
        std::vector<double> distances;
        for (std::size_t n = 0; n < forward_.size(); ++n) {
            const auto d = forward_[n].at.place - places[vertices_[n]];
            if (forward_[n].is_match) distances.push_back(std::sqrt(dot(d, d)));
        }
        return quantile(distances, 0.95);
    }
    /// Returns 1.4826 times the median distance of the target's vertices from the planes of the source: the
    /// standard deviation if the distances are normally distributed.
    double back_residual(const std::vector<Point>& places, const std::vector<Point>& normals) const {
        constexpr double reach = 0.02;
        std::vector<double> distances;
        for (std::size_t k = 0; k < scene_.back_vertices; ++k) {
            if (back_[k] == no_vertex) continue;
            const std::uint32_t i = vertices_[back_[k]];
            const auto e = scene_.back_points[k] - places[i];
            if (dot(e, e) < reach * reach && dot(normals[i], scene_.back_normals[k]) > least_cosine)
                distances.push_back(std::fabs(dot(e, normals[i])));
        }
        return 1.4826 * quantile(distances, 0.5);
    }
    double unmatched_source() const noexcept { return unmatched_source_; }
    double unmatched_target() const noexcept { return unmatched_target_; }

private:
    static constexpr double match_radius = 0.03; ///< of matches that return, at rest

    struct Match {
        ClosestPlaces::Place at;
        std::uint32_t back = no_vertex; ///< the vertex nearest to `at`, among the given ones
        bool is_match = false, returns = false;
    };

    static bool is_close(const Point& a, const Point& b, double distance) noexcept {
        return dot(a - b, a - b) < distance * distance;
    }
    const Point& rest(std::size_t n) const noexcept { return scene_.source.rest[vertices_[n]]; }

    void renew_scale(const std::vector<Point>& places) {
        constexpr double least_scale = 0.004;
        double sum = 0;
        for (std::size_t n = 0; n < forward_.size(); ++n) {
            if (forward_[n].at.face == no_vertex) continue;
            const auto d = forward_[n].at.place - places[vertices_[n]];
            sum += dot(d, d);
        }
        const double rms = std::sqrt(sum / double((std::max)(forward_.size(), std::size_t{1})));
        sigma_ = (std::max)(3 * rms, least_scale);
    }
    void sum_pulls(const std::vector<Point>& places, const std::vector<Point>& normals) {
        pulls_.assign(vertices_.size(), {});
        std::vector<double> weights(vertices_.size());
        std::size_t matched = 0;
        for (std::size_t n = 0; n < vertices_.size(); ++n) {
            const Match& match = forward_[n];
            if (!match.is_match) continue;
            ++matched;
            const auto d = match.at.place - places[vertices_[n]];
            weights[n] = match.returns ? 1 : robust_weight(dot(d, d), sigma_);
            pulls_[n] = weights[n] * pull_of(d, match.at.normal);
        }
        unmatched_source_ = 1 - double(matched) / double((std::max)(vertices_.size(), std::size_t{1}));
        matched = 0;
        for (std::size_t k = 0; k < back_.size(); ++k) {
            const std::uint32_t n = back_[k];
            if (n == no_vertex || !(dot(normals[vertices_[n]], scene_.back_normals[k]) > least_cosine))
                continue;
            ++matched;
            const auto d = scene_.back_points[k] - places[vertices_[n]];
            const bool returns = returning_ && forward_[n].at.face != no_vertex &&
                                 is_close(forward_[n].at.place, scene_.back_points[k], match_radius) &&
                                 dot(d, d) < 9 * match_radius * match_radius;
            const double weight = returns ? 1 : robust_weight(dot(d, d), sigma_);
            pulls_[n] = pulls_[n] + weight * pull_of(d, scene_.back_normals[k]);
            weights[n] += weight;
        }
        unmatched_target_ = 1 - double(matched) / double((std::max)(back_.size(), std::size_t{1}));
        for (std::size_t n = 0; n < pulls_.size(); ++n)
            pulls_[n] = (1 / (std::max)(weights[n], 1.0)) * pulls_[n];
    }

    WrapScene& scene_;
    const std::vector<std::uint32_t>& vertices_;
    double kappa_;
    bool returning_;
    const Running& running_;
    std::vector<Match> forward_;             ///< of the given vertices
    std::vector<std::uint32_t> back_;        ///< of the target's places: index among the given vertices
    std::vector<std::uint32_t> guard_faces_; ///< of the guarded followers: the last nearest face
    std::vector<Point> pulls_;
    double sigma_ = 1, unmatched_source_ = 1, unmatched_target_ = 1;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
