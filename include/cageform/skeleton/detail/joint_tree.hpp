// Joints between the bones of a fit, and their hierarchy (after Le and Deng, Robust and accurate skeletal
// rigging from mesh sequences, ACM TOG 33(4), 2014, sec. 4).
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/skeleton/detail/bone_fit.hpp>

#include <Eigen/Dense>

#include <map>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The joint p of bones a and b minimises Σ_t |M_a^t p − M_b^t p|² + λ |p − c|². c is the mean of the
/// vertices, weighted by the products of their weights for a and b. λ is 1e-2 of the scale of the first term,
/// increased until the distance of p from c is within the standard deviation of those vertices. The tree
/// maximises Σ_i w_ia w_ib exp(−r), where r is the RMS of the remaining distances.
class JointTree {
public:
    static constexpr std::uint32_t none = 0xffffffff;

    JointTree(const Motion& motion, const BoneFit& fit)
        : motion_(motion)
        , fit_(fit) {
        add_up();
        grow();
    }

    std::vector<std::uint32_t> order;   ///< bones, parents before children
    std::vector<std::uint32_t> parents; ///< per bone; none for the root
    std::vector<Vec<double, 3>> places; ///< joint of each bone in the rest pose, in the units of Motion

private:
    struct Shared {
        double weight = 0, squares = 0;
        Vec<double, 3> sum{};
        Vec<double, 3> place{};
        double value = 0;
    };
    using Pair = std::pair<std::uint32_t, std::uint32_t>;

    void add_up() {
        const VertexWeights& of = fit_.weights();
        masses_.assign(fit_.bones(), 0);
        places.assign(fit_.bones(), {});
        for (std::size_t i = 0; i < motion_.vertices; ++i) {
            for (std::size_t k = i * of.width; k < (i + 1) * of.width; ++k) {
                const double w = of.weights[k];
                if (!(w > 0)) continue;
                masses_[of.joints[k]] += w;
                places[of.joints[k]] = places[of.joints[k]] + w * motion_.rest[i];
                for (std::size_t l = i * of.width; l < k; ++l) {
                    if (!(of.weights[l] > 0)) continue;
                    Shared& shared = shared_[std::minmax(of.joints[k], of.joints[l])];
                    shared.weight += w * of.weights[l];
                    shared.sum = shared.sum + w * of.weights[l] * motion_.rest[i];
                    shared.squares += w * of.weights[l] * dot(motion_.rest[i], motion_.rest[i]);
                }
            }
        }
        for (std::size_t j = 0; j < places.size(); ++j) {
            if (masses_[j] > 0) places[j] = (1 / masses_[j]) * places[j];
        }
        for (auto& [pair, shared] : shared_) set_joint(pair, shared);
    }
    void set_joint(const Pair& pair, Shared& shared) const {
        using Matrix = Eigen::Matrix<double, 3, 4>;
        const auto difference = [&](std::size_t t) {
            Matrix d;
            for (std::size_t r = 0; r < 3; ++r) {
                for (std::size_t c = 0; c < 4; ++c)
                    d(Eigen::Index(r), Eigen::Index(c)) =
                        fit_.map(pair.first, r, c)[t] - fit_.map(pair.second, r, c)[t];
            }
            return d;
        };
        Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
        Eigen::Vector3d right = Eigen::Vector3d::Zero();
        for (std::size_t t = 0; t < motion_.frames; ++t) {
            const Matrix d = difference(t);
            square += d.leftCols<3>().transpose() * d.leftCols<3>();
            right -= d.leftCols<3>().transpose() * d.col(3);
        }
        const Vec<double, 3> mean = (1 / shared.weight) * shared.sum;
        const Eigen::Vector3d centre(mean[0], mean[1], mean[2]);
        const double spread = (std::max)(shared.squares / shared.weight - centre.squaredNorm(), 0.0);
        constexpr double most = 1e6; // limit of the factor of λ; there the position is nearly the mean
        Eigen::Vector3d p = centre;
        for (double more = 1; more < most; more *= 4) {
            const double hold = more * (1e-2 * square.trace() / 3 + 1e-12 * double(motion_.frames));
            const Eigen::Matrix3d held = square + hold * Eigen::Matrix3d::Identity();
            p = held.ldlt().solve(right + hold * centre);
            if ((p - centre).squaredNorm() <= spread) break;
        }
        double rest = 0;
        for (std::size_t t = 0; t < motion_.frames; ++t) {
            const Matrix d = difference(t);
            rest += (d.leftCols<3>() * p + d.col(3)).squaredNorm();
        }
        shared.place = {p[0], p[1], p[2]};
        shared.value = shared.weight * std::exp(-std::sqrt(rest / double(motion_.frames)));
    }
    void grow() {
        const std::size_t bones = fit_.bones();
        std::vector<std::pair<Pair, const Shared*>> edges;
        edges.reserve(shared_.size());
        for (const auto& [pair, shared] : shared_) edges.push_back({pair, &shared});
        std::stable_sort(edges.begin(), edges.end(),
                         [](const auto& a, const auto& b) { return a.second->value > b.second->value; });
        DisjointSets sets(bones);
        std::vector<std::vector<std::pair<std::uint32_t, const Shared*>>> links(bones);
        for (const auto& [pair, shared] : edges) {
            if (!sets.join(pair.first, pair.second)) continue;
            links[pair.first].push_back({pair.second, shared});
            links[pair.second].push_back({pair.first, shared});
        }
        parents.assign(bones, none);
        auto heaviest = first_indices<std::uint32_t>(bones);
        std::stable_sort(heaviest.begin(), heaviest.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return masses_[a] > masses_[b]; });
        std::vector<bool> seen(bones, false);
        for (const std::uint32_t root : heaviest) { // first of its set; sets have no common weights
            if (seen[root]) continue;
            if (root != heaviest[0]) parents[root] = heaviest[0];
            seen[root] = true;
            std::size_t next = order.size();
            order.push_back(root);
            for (; next < order.size(); ++next) {
                for (const auto& [child, shared] : links[order[next]]) {
                    if (seen[child]) continue;
                    seen[child] = true;
                    parents[child] = order[next];
                    places[child] = shared->place;
                    order.push_back(child);
                }
            }
        }
    }

    const Motion& motion_;
    const BoneFit& fit_;
    std::vector<double> masses_; ///< sum of each bone's weights
    std::map<Pair, Shared> shared_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
