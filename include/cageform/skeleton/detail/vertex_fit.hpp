// Optimal weights of a vertex for fixed bones.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/skeleton/detail/motion.hpp>
#include <cageform/skeleton/detail/simplex_weights.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Products of (x, y, z, 1) with itself: ten numbers, and the index of the product of two entries.
using Products = std::array<double, 10>;
inline constexpr std::size_t product_of[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
inline Products products_of(const Vec<double, 3>& v) noexcept {
    return {v[0] * v[0], v[0] * v[1], v[0] * v[2], v[0], v[1] * v[1],
            v[1] * v[2], v[1],        v[2] * v[2], v[2], 1};
}

/// Sums over all frames of products of two maps. The dot product of `of` for bones j and k with
/// products_of(v) is Σ_t (M_j^t v) · (M_k^t v).
struct MapPairs {
    std::size_t bones = 0;
    std::vector<Products> of;

    double at(std::size_t j, std::size_t k, const Products& v) const noexcept {
        const Products& p = of[j * bones + k];
        double sum = 0;
        for (std::size_t n = 0; n < p.size(); ++n) sum += p[n] * v[n];
        return sum;
    }
};

struct WeightStep {
    std::size_t influences = 4;
    double smoothing = 0;  ///< λ: adds λ |w − mean of the neighbours' weights|²
    bool removals = false; ///< also compute the error added by removing each bone
};

/// Weights of all vertices: `width` bones and weights each.
struct VertexWeights {
    std::size_t width = 0;
    std::vector<std::uint32_t> joints;
    std::vector<double> weights;

    /// Gives all weight of vertex i to one bone.
    void set_single(std::size_t i, std::uint32_t bone) noexcept {
        for (std::size_t k = i * width; k < (i + 1) * width; ++k) {
            joints[k] = k == i * width ? bone : 0;
            weights[k] = k == i * width ? 1 : 0;
        }
    }
};

/// Computes the weights of vertices, one at a time; one object per thread.
class VertexFit {
public:
    VertexFit(const Motion& motion, const MapPairs& pairs, const VertexWeights& before,
              const WeightStep& step)
        : motion_(motion)
        , pairs_(pairs)
        , before_(before)
        , step_(step)
        , own_(pairs.bones)
        , across_(pairs.bones)
        , mean_(pairs.bones, 0)
        , taken_(pairs.bones, 0) {}

    /// Computes the weights of vertex i.
    ///
    ///   correlations  #bones · 4: Σ_t of the columns of a bone's maps times the vertex's positions
    ///   returns       the sum over the frames of squared distances
    double fit(std::size_t i, const double* correlations, VertexWeights& to) {
        v_ = products_of(motion_.rest[i]);
        square_ = motion_.squares[i];
        for (std::size_t j = 0; j < own_.size(); ++j) {
            across_[j] = 0;
            for (std::size_t c = 0; c < 4; ++c) across_[j] += v_[product_of[c][3]] * correlations[4 * j + c];
            own_[j] = std::fmax(pairs_.at(j, j, v_) - 2 * across_[j] + square_, 0.0);
        }
        if (step_.influences == 1) return take_nearest(i, to);
        choose_candidates(i);
        set_up();
        full_ = problem_;
        problem_.solve(step_.influences);
        return store(i, to);
    }
    /// Returns the increase of the error if the k-th bone of the last fitted vertex is removed.
    double removal(std::size_t k) {
        const double before = problem_.value();
        without_ = full_;
        const std::size_t c = order_[k], last = --without_.count;
        for (std::size_t a = 0; a < last; ++a) without_.w[a] = problem_.w[a];
        if (c != last) { // move the last candidate into its slot
            for (std::size_t a = 0; a <= last; ++a) without_.q[c][a] = without_.q[last][a];
            without_.q[c][c] = without_.q[last][last];
            for (std::size_t a = 0; a < last; ++a) without_.q[a][c] = without_.q[c][a];
            without_.f[c] = without_.f[last];
            without_.w[c] = problem_.w[last];
        }
        without_.start();
        without_.solve(step_.influences);
        return std::fmax(without_.value() - before, 0.0);
    }
    std::size_t used() const noexcept { return used_; }

private:
    static constexpr std::size_t nearest = 10;

    double take_nearest(std::size_t i, VertexWeights& to) {
        const auto best = std::min_element(own_.begin(), own_.end());
        to.set_single(i, std::uint32_t(best - own_.begin()));
        used_ = 0;
        return *best;
    }
    void take(std::uint32_t bone, double weight) {
        if (problem_.count == SimplexWeights::max_candidates || taken_[bone] != 0) return;
        taken_[bone] = 1;
        candidates_[problem_.count] = bone;
        problem_.w[problem_.count++] = weight;
    }
    /// Candidates: current bones, nearest bones, and bones of neighbours.
    void choose_candidates(std::size_t i) {
        const std::size_t width = before_.width;
        problem_.count = 0;
        for (std::size_t n = i * width; n < (i + 1) * width; ++n) {
            if (before_.weights[n] > 0) take(before_.joints[n], before_.weights[n]);
        }
        order_ = first_indices<std::uint32_t>(own_.size());
        const std::size_t few = (std::min)(nearest, order_.size());
        std::partial_sort(order_.begin(), order_.begin() + std::ptrdiff_t(few), order_.end(),
                          [&](std::uint32_t a, std::uint32_t b) {
                              return own_[a] < own_[b] || (own_[a] == own_[b] && a < b);
                          });
        for (std::size_t n = 0; n < few; ++n) take(order_[n], 0);
        for (double& x : mean_) x = 0;
        const std::size_t first = motion_.first_neighbour[i], last = motion_.first_neighbour[i + 1];
        for (std::size_t n = first; n < last; ++n) {
            const std::size_t other = motion_.neighbours[n];
            for (std::size_t k = other * width; k < (other + 1) * width; ++k) {
                mean_[before_.joints[k]] += before_.weights[k] / double(last - first);
                if (before_.weights[k] > 0.05) take(before_.joints[k], 0);
            }
        }
        has_neighbours_ = first != last;
        for (std::size_t a = 0; a < problem_.count; ++a) taken_[candidates_[a]] = 0;
    }
    void set_up() {
        const std::size_t m = problem_.count;
        double trace = 0;
        for (std::size_t a = 0; a < m; ++a) {
            const std::size_t j = candidates_[a];
            trace += problem_.q[a][a] = own_[j];
            for (std::size_t b = 0; b < a; ++b) {
                const std::size_t k = candidates_[b];
                problem_.q[a][b] = problem_.q[b][a] = pairs_.at(j, k, v_) - across_[j] - across_[k] + square_;
            }
        }
        const double smoothing = has_neighbours_ ? step_.smoothing : 0;
        ridge_ = smoothing + 1e-11 * trace / double(m) + 1e-20;
        for (std::size_t a = 0; a < m; ++a) {
            problem_.q[a][a] += ridge_;
            problem_.f[a] = smoothing * mean_[candidates_[a]];
        }
        problem_.start();
    }
    double store(std::size_t i, VertexWeights& to) {
        const std::size_t m = problem_.count;
        used_ = 0;
        double error = 0;
        order_.clear();
        for (std::size_t a = 0; a < m; ++a) {
            if (!(problem_.w[a] > 0)) continue;
            order_.push_back(std::uint32_t(a));
            for (std::size_t b = 0; b < m; ++b)
                error += problem_.w[a] * problem_.w[b] * (problem_.q[a][b] - (a == b ? ridge_ : 0));
        }
        used_ = order_.size();
        std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
            return problem_.w[a] > problem_.w[b] || (problem_.w[a] == problem_.w[b] && a < b);
        });
        for (std::size_t k = 0; k < to.width; ++k) {
            to.joints[i * to.width + k] = k < used_ ? candidates_[order_[k]] : 0;
            to.weights[i * to.width + k] = k < used_ ? problem_.w[order_[k]] : 0;
        }
        return std::fmax(error, 0.0);
    }

    const Motion& motion_;
    const MapPairs& pairs_;
    const VertexWeights& before_;
    WeightStep step_;
    std::vector<double> own_,  ///< per bone: squared distance if the bone has all weight
        across_;               ///< per bone: Σ_t of the dot product of the mapped and the given position
    std::vector<double> mean_; ///< mean of the neighbours' weights
    std::vector<std::uint8_t> taken_;
    std::vector<std::uint32_t> order_;
    std::array<std::uint32_t, SimplexWeights::max_candidates> candidates_;
    SimplexWeights problem_, full_, without_;
    Products v_{};
    double square_ = 0, ridge_ = 0;
    std::size_t used_ = 0;
    bool has_neighbours_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
