// Fits a skeleton to a motion: clusters, rounds of weights and bones, relocation of idle bones.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/skeleton/detail/bone_fit.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

class SkeletonFitter {
public:
    SkeletonFitter(const Motion& motion, const SkeletonOptions& options, const Running& running)
        : motion_(motion)
        , options_(options)
        , running_(running)
        , smoothing_(7.5e-7 * double(motion.frames))
        , fit_(motion, options.kind, options.influences) {}

    const BoneFit& fit() const noexcept { return fit_; }

    /// Fits up to `bones` bones; bones without vertices are removed.
    Status run(std::size_t bones) {
        steps_ = 1 + first_rounds + 4 * options_.moves + options_.rounds;
        if (!start(bones)) return Status::cancelled;
        extra_ = (std::max)(std::size_t{1}, fit_.bones() / 6);
        for (std::size_t move = 0; move < options_.moves; ++move) {
            if (!relocate()) return Status::cancelled;
        }
        if (!last_rounds()) return Status::cancelled;
        weights();
        remove_idle();
        return Status::ok;
    }

    // Steps of a fit; they return false if cancelled.

    /// Starts with clusters of vertices that move together.
    bool start(std::size_t bones) {
        fit_ = BoneFit(motion_, options_.kind, options_.influences);
        if (!begin(bones)) return false;
        weights(false, 0);
        fit_.fit_bones(sweeps, running_);
        tried_.assign(motion_.vertices, false);
        return rounds(first_rounds);
    }
    void weights() { weights(false, smoothing_); }
    /// Sets the importance of vertices from their errors and refits the bones.
    bool reweight_by_error() {
        fit_.reweight_by_error(max_importance);
        return move_bones();
    }
    /// Multiplies the importance of vertices by factors and refits the bones.
    bool reweight(const std::vector<double>& factors, bool first) {
        if (first) fit_.reweight_by_error(max_importance);
        fit_.reweight(factors, 10 * max_importance);
        return move_bones();
    }
    /// Adds bones at the largest errors, up to `bones` + `more`, then removes those whose removal costs
    /// least.
    bool exchange(std::size_t bones, std::size_t more) {
        std::vector<double> errors = fit_.errors();
        while (fit_.bones() < bones + more) {
            std::size_t worst = errors.size();
            for (std::size_t i = 0; i < errors.size(); ++i) {
                if (errors[i] > 0 && !tried_[i] && (worst == errors.size() || errors[i] > errors[worst]))
                    worst = i;
            }
            if (worst == errors.size()) break;
            const auto nearest = nearest_at_rest(worst);
            fit_.add_bone(nearest, false, running_);
            for (const std::uint32_t i : nearest) errors[i] = 0;
            tried_[worst] = true;
        }
        if (fit_.bones() < bones) tried_.assign(motion_.vertices, false);
        if (!rounds(2)) return false;
        weights(true, smoothing_);
        auto order = first_indices<std::size_t>(fit_.bones());
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return fit_.removals()[a] < fit_.removals()[b];
        });
        std::vector<bool> removed(fit_.bones(), false);
        for (std::size_t n = bones; n < order.size(); ++n) removed[order[n - bones]] = true;
        fit_.remove_bones(removed);
        return rounds(2);
    }
    void remove_idle() {
        std::vector<bool> idle(fit_.bones(), true);
        const VertexWeights& of = fit_.weights();
        for (std::size_t k = 0; k < of.weights.size(); ++k) {
            if (of.weights[k] > 0) idle[of.joints[k]] = false;
        }
        fit_.remove_bones(idle);
    }
    void restore(BoneFit fit) { fit_ = std::move(fit); }

private:
    static constexpr std::size_t sweeps = 6, first_rounds = 3, plain_rounds = 10, min_cluster = 6,
                                 patch_size = 24;
    /// Upper bound of the importance of a vertex. Weighting vertices by their errors lowers the maximum error
    /// by 25 % and raises the mean error by 1 %.
    static constexpr double max_importance = 10;

    void weights(bool removals, double smoothing) {
        fit_.fit_weights({options_.influences, smoothing, removals}, running_);
    }
    bool rounds(std::size_t count) {
        for (std::size_t n = 0; n < count; ++n) {
            weights(false, smoothing_);
            if (!move_bones()) return false;
        }
        return true;
    }
    /// Runs rounds with vertices weighted by importance. Later rounds extrapolate the weights (Ang and
    /// Gillis, Accelerating nonnegative matrix factorization algorithms using extrapolation, Neural
    /// Computation 31(2), 2019). The momentum grows while the error falls, and then restarts (as in
    /// O'Donoghue and Candès, Adaptive restart for accelerated gradient schemes, Found. Comput. Math. 15(3),
    /// 2015).
    bool last_rounds() {
        VertexWeights last;
        double error = 0;
        std::size_t falls = 0;
        for (std::size_t n = 0; n < options_.rounds; ++n) {
            weights();
            fit_.reweight_by_error(max_importance);
            falls = n >= plain_rounds && fit_.error() < error ? falls + 1 : 0;
            error = fit_.error();
            VertexWeights now = fit_.weights();
            if (falls > 0 && n + 1 < options_.rounds)
                fit_.extrapolate(last, double(falls) / double(falls + 3));
            last = std::move(now);
            if (!move_bones()) return false;
        }
        return true;
    }
    bool keep_going(std::size_t steps) {
        step_ += steps;
        return running_.keep_going(double(step_) / double(steps_ > 0 ? steps_ : step_ + 100));
    }
    bool move_bones() {
        fit_.fit_bones(sweeps, running_);
        return keep_going(1);
    }
    /// Clusters vertices that move together: bisects the clusters with the largest errors.
    bool begin(std::size_t bones) {
        auto all = first_indices<std::uint32_t>(motion_.vertices);
        fit_.add_bone(all, true, running_);
        fit_.fit_weights({1, 0, false}, running_);
        while (fit_.bones() < bones) {
            if (!split(bones)) break;
            for (std::size_t n = 0; n < 5; ++n) {
                fit_.fit_weights({1, 0, false}, running_);
                fit_.fit_bones(1, running_);
            }
            if (!keep_going(0)) return false;
        }
        return keep_going(1);
    }
    bool split(std::size_t bones) {
        const std::size_t had = fit_.bones();
        std::vector<std::vector<std::uint32_t>> clusters(had);
        std::vector<double> errors(had, 0);
        for (std::uint32_t i = 0; i < motion_.vertices; ++i) {
            const std::uint32_t j = fit_.weights().joints[i * options_.influences];
            clusters[j].push_back(i);
            errors[j] += fit_.errors()[i];
        }
        auto order = first_indices<std::size_t>(had);
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return errors[a] > errors[b]; });
        for (const std::size_t j : order) {
            if (fit_.bones() == bones) break;
            const auto& cluster = clusters[j];
            if (cluster.size() < 2 * min_cluster) continue;
            const auto by_error = [&](std::uint32_t i, std::uint32_t k) {
                return fit_.errors()[i] < fit_.errors()[k];
            };
            const std::uint32_t a = *std::max_element(cluster.begin(), cluster.end(), by_error);
            std::uint32_t b = a;
            double farthest = 0;
            for (const std::uint32_t i : cluster) {
                const double d = path_distance(i, a);
                if (d > farthest) b = i;
                farthest = (std::max)(farthest, d);
            }
            std::vector<std::uint32_t> nearer;
            for (const std::uint32_t i : cluster) {
                if (path_distance(i, a) < path_distance(i, b)) nearer.push_back(i);
            }
            if (nearer.size() < min_cluster || cluster.size() - nearer.size() < min_cluster) continue;
            fit_.add_bone(nearer, true, running_);
        }
        return fit_.bones() > had;
    }
    double path_distance(std::size_t i, std::size_t j) const {
        const double *a = motion_.path(i), *b = motion_.path(j);
        double sum = 0;
        for (std::size_t n = 0; n < 3 * motion_.lanes; ++n) sum += (a[n] - b[n]) * (a[n] - b[n]);
        return sum;
    }

    /// Moves bones to the largest errors. If the error does not fall, reverts, and halves the number of moved
    /// bones for the next call.
    bool relocate() {
        BoneFit before = fit_;
        if (!exchange(fit_.bones(), extra_)) return false;
        if (fit_.error() < before.error()) {
            tried_.assign(motion_.vertices, false);
        } else {
            fit_ = std::move(before);
            extra_ = (extra_ + 1) / 2;
        }
        return true;
    }
    /// Returns the vertices nearest to vertex `i` in the rest pose.
    std::vector<std::uint32_t> nearest_at_rest(std::size_t i) const {
        std::vector<std::pair<double, std::uint32_t>> order(motion_.vertices);
        for (std::uint32_t k = 0; k < motion_.vertices; ++k) {
            const auto d = motion_.rest[k] - motion_.rest[i];
            order[k] = {dot(d, d), k};
        }
        const std::size_t count = (std::min)(patch_size, order.size());
        std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(count), order.end());
        std::vector<std::uint32_t> result;
        result.reserve(count);
        for (std::size_t n = 0; n < count; ++n) result.push_back(order[n].second);
        return result;
    }

    const Motion& motion_;
    const SkeletonOptions& options_;
    const Running& running_;
    double smoothing_;
    BoneFit fit_;
    std::size_t step_ = 0, steps_ = 0; ///< steps done, and all steps of a fit by number
    std::size_t extra_ = 1;            ///< bones added by a relocation
    std::vector<bool> tried_;          ///< vertices at which an added bone did not help
};

} // namespace cageform::inline CAGEFORM_ABI::detail
