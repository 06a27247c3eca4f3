// Keeps the map of a stage from folding: measures its stretch, and moves handles back where it would fold.
#pragma once

#include <cageform/fit/detail/wrap_scene.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Checks for folds at the samples, the vertices of the source and the followers of a scene.
template <class Basis>
class FoldGuard {
    using Point = Vec<double, 3>;
    using Rows = typename Basis::Rows;

public:
    ///   floor  lower bound of the least singular values
    FoldGuard(const WrapScene& scene, const Basis& basis, double floor, const Running& running)
        : scene_(scene)
        , basis_(basis)
        , floor_(floor)
        , running_(running) {}

    Status evaluate_samples() {
        return basis_.gradients(scene_.samples.now, scene_.samples.jacobians, sample_rows_);
    }
    /// The derivatives at the samples; empty before `evaluate_samples`.
    const Rows& sample_rows() const noexcept { return sample_rows_; }
    /// Returns the least singular values at the samples, negative where the map folds.
    std::vector<double> stretches_of_samples(const std::vector<Point>& pose) const {
        std::vector<double> least;
        add_stretches(sample_rows_, pose, least);
        return least;
    }

    /// Moves the handles near places whose least singular value is below the floor back towards their last
    /// good positions, without a new solve.
    ///
    ///   good  the pose before the step. A place below the floor in this pose keeps at least half of its
    ///         stretch. A place that folds in this pose has no limit
    Status apply(const std::vector<std::uint32_t>& unknowns, const std::vector<Point>& good,
                 std::vector<Point>& pose, WrapReport::Step& step) {
        constexpr int rounds = 80;
        constexpr double back = 0.3;
        if (const Status status = evaluate_others(); status != Status::ok) return status;
        std::vector<double> least = stretches(pose);
        if (std::none_of(least.begin(), least.end(), [&](double x) { return x < floor_; })) return Status::ok;

        std::vector<double> limits = stretches(good);
        for (double& limit : limits)
            limit = limit >= floor_ ? floor_
                                    : (limit > 0 ? 0.5 * limit : -std::numeric_limits<double>::infinity());
        std::vector<Point> places;
        for (const MovedPoints* points : {&scene_.samples, &scene_.source, &scene_.followers})
            places.insert(places.end(), points->now.begin(), points->now.end());
        Rows weights;
        if (const Status status = basis_.weights(places, weights); status != Status::ok) return status;
        std::vector<double> kept(basis_.size(), 1), pulled(basis_.size());
        const std::vector<Point> wanted = pose;
        for (int round = 0;; ++round) {
            std::size_t low = 0;
            std::fill(pulled.begin(), pulled.end(), 0);
            for (std::size_t n = 0; n < least.size(); ++n) {
                if (!(least[n] < limits[n])) continue;
                ++low;
                double largest = 0;
                weights.for_each(
                    n, [&](std::size_t /*i*/, double w) { largest = (std::max)(largest, std::fabs(w)); });
                weights.for_each(n, [&](std::size_t i, double w) {
                    if (largest > 0) pulled[i] = (std::max)(pulled[i], std::fabs(w) / largest);
                });
            }
            if (round == 0) step.held = low;
            if (low == 0) break;
            if (round == rounds) {
                std::fill(kept.begin(), kept.end(), 0);
                pose = good;
                break;
            }
            for (const std::uint32_t i : unknowns) {
                kept[i] *= 1 - back * std::cbrt(pulled[i]);
                pose[i] = good[i] + kept[i] * (wanted[i] - good[i]);
            }
            least = stretches(pose);
        }
        step.kept = 0;
        for (const std::uint32_t i : unknowns) step.kept += kept[i] / double(unknowns.size());
        return Status::ok;
    }

    /// Appends the Jacobians at points of the scene.
    Status add_jacobians(const MovedPoints& points, const std::vector<Point>& pose,
                         std::vector<LinearMap<double, 3>>& jacobians) const {
        constexpr std::size_t batch = 1024;
        const bool is_sample = &points == &scene_.samples, is_mark = &points == &scene_.marks;
        const Rows& known = is_sample ? sample_rows_ : other_rows_;
        if (!is_mark && known.size() > 0) {
            const std::size_t first = &points == &scene_.followers ? scene_.source.size() : 0;
            for (std::size_t n = 0; n < points.size(); ++n)
                jacobians.push_back(jacobian_of(known, first + n, pose));
            return Status::ok;
        }
        for (std::size_t first = 0; first < points.size(); first += batch) {
            const std::size_t count = (std::min)(batch, points.size() - first);
            const auto before = points.jacobians.empty() ? std::span<const LinearMap<double, 3>>{}
                                                         : std::span(points.jacobians).subspan(first, count);
            Rows rows;
            const Status status = basis_.gradients(std::span(points.now).subspan(first, count), before, rows);
            if (status != Status::ok) return status;
            for (std::size_t n = 0; n < count; ++n) jacobians.push_back(jacobian_of(rows, n, pose));
        }
        return Status::ok;
    }

private:
    static LinearMap<double, 3> jacobian_of(const Rows& rows, std::size_t n,
                                            const std::vector<Point>& pose) noexcept {
        LinearMap<double, 3> j;
        for (std::size_t c = 0; c < 3; ++c) {
            const Point column = rows.product(3 * n + c, pose);
            for (std::size_t r = 0; r < 3; ++r) j.at[r][c] = column[r];
        }
        return j;
    }
    void add_stretches(const Rows& rows, const std::vector<Point>& pose, std::vector<double>& least) const {
        const std::size_t first = least.size(), count = rows.size() / 3;
        least.resize(first + count);
        in_parallel(running_, count, 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                const auto j = jacobian_of(rows, n, pose);
                least[first + n] = std::copysign(std::sqrt(squared_stretches(j)[0]), determinant(j));
            }
        });
    }
    /// Returns the least singular values at all places.
    std::vector<double> stretches(const std::vector<Point>& pose) const {
        std::vector<double> least = stretches_of_samples(pose);
        add_stretches(other_rows_, pose, least);
        return least;
    }
    Status evaluate_others() {
        if (other_rows_.size() > 0) return Status::ok;
        std::vector<Point> places;
        std::vector<LinearMap<double, 3>> before;
        for (const MovedPoints* points : {&scene_.source, &scene_.followers}) {
            places.insert(places.end(), points->now.begin(), points->now.end());
            before.insert(before.end(), points->jacobians.begin(), points->jacobians.end());
        }
        return basis_.gradients(places, before, other_rows_);
    }

    const WrapScene& scene_;
    const Basis& basis_;
    double floor_;
    const Running& running_;
    Rows sample_rows_;
    Rows other_rows_; ///< derivatives at the vertices of the source, then at the followers
};

} // namespace cageform::inline CAGEFORM_ABI::detail
