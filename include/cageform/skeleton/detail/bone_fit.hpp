// State of a skeleton fit, and the steps that improve it.
#pragma once

#include <cageform/pose/detail/nearest_rotation.hpp>
#include <cageform/skeleton/detail/vertex_fit.hpp>
#include <cageform/skeleton/types/skeleton_options.hpp>

#include <Eigen/Core>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Bones and weights. `fit_weights` minimises the sum of squared distances over the weights of each vertex.
/// `fit_bones` minimises this sum, weighted by importance, over one map at a time. A step of weights sums
/// over the frames once, so the cost of a vertex does not depend on the number of frames. A step of bones
/// sums over the vertices once, so the cost of a frame does not depend on the number of vertices.
class BoneFit {
public:
    BoneFit(const Motion& motion, BoneKind kind, std::size_t influences)
        : motion_(&motion)
        , kind_(kind)
        , weights_{influences, std::vector<std::uint32_t>(motion.vertices * influences, 0),
                   std::vector<double>(motion.vertices * influences, 0)}
        , errors_(motion.vertices, 0)
        , importance_(motion.vertices, 1) {}

    std::size_t bones() const noexcept { return bones_; }
    const VertexWeights& weights() const noexcept { return weights_; }
    /// errors(): squared distance of each vertex, summed over the frames, after the last step of weights.
    /// error(): their sum.
    const std::vector<double>& errors() const noexcept { return errors_; }
    double error() const noexcept { return error_; }
    /// Entry (axis, column) of a bone's map in all frames; column 3 is the translation.
    const double* map(std::size_t bone, std::size_t axis, std::size_t column) const noexcept {
        return maps_.data() + row(bone, column, axis);
    }

    /// Maximum squared distance of each vertex over the frames.
    std::vector<double> largest_squares(const Running& running) const {
        std::vector<double> squares(motion_->vertices, 0);
        in_parallel(running, motion_->vertices, 32, [&](std::size_t begin, std::size_t end) {
            const std::size_t numbers = 3 * motion_->lanes;
            std::vector<double> off(numbers);
            for (std::size_t i = begin; i < end; ++i) {
                std::copy_n(motion_->path(i), numbers, off.begin());
                const auto& v = motion_->rest[i];
                const double place[4] = {v[0], v[1], v[2], 1};
                for (std::size_t k = i * weights_.width; k < (i + 1) * weights_.width; ++k) {
                    if (!(weights_.weights[k] > 0)) continue;
                    for (std::size_t c = 0; c < 4; ++c) {
                        const double factor = weights_.weights[k] * place[c];
                        const double* const column = map(weights_.joints[k], 0, c);
                        for (std::size_t n = 0; n < numbers; ++n) off[n] -= factor * column[n];
                    }
                }
                for (std::size_t t = 0; t < motion_->frames; ++t) {
                    double sum = 0;
                    for (std::size_t n = t; n < numbers; n += motion_->lanes) sum += off[n] * off[n];
                    squares[i] = (std::max)(squares[i], sum);
                }
            }
        });
        return squares;
    }

    /// Sets the importance of each vertex in later steps of bones, from 1 to `most`, by its error.
    void reweight_by_error(double most) {
        const double mean = error_ / double(errors_.size());
        for (std::size_t i = 0; i < errors_.size(); ++i)
            importance_[i] = mean > 0 ? 1 + (std::fmin)(errors_[i] / mean, most - 1) : 1;
    }

    /// Multiplies the importance of vertices by factors above 1, up to `most`.
    void reweight(const std::vector<double>& factors, double most) {
        for (std::size_t i = 0; i < factors.size(); ++i)
            importance_[i] = (std::fmin)(importance_[i] * (std::fmax)(factors[i], 1.0), most);
    }

    /// Adds a bone with the best map for some vertices. If `owns`, the bone gets all weight of these
    /// vertices. Returns its index.
    std::size_t add_bone(std::span<const std::uint32_t> vertices, bool owns, const Running& running) {
        const std::size_t lanes = motion_->lanes, bone = bones_++;
        maps_.resize(bones_ * 12 * lanes, 0);
        rotations_.resize(bones_ * 9 * lanes, 0);
        std::vector<Share> shares;
        for (const std::uint32_t i : vertices) shares.push_back({i, 1});
        Couplings alone;
        alone.of.resize(bones_);
        alone.right_sides.resize(bones_);
        sum_couplings(bone, shares, alone);
        in_parallel(running, lanes / Motion::group, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) fit_bone(bone, g, alone);
        });
        if (owns) {
            for (const std::uint32_t i : vertices) weights_.set_single(i, std::uint32_t(bone));
        }
        return bone;
    }

    /// Optimises the maps for fixed weights: sweeps over the bones, one at a time, in every frame.
    void fit_bones(std::size_t sweeps, const Running& running) {
        Couplings couplings = couple(running);
        in_parallel(running, motion_->lanes / Motion::group, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) {
                for (std::size_t sweep = 0; sweep < sweeps; ++sweep) {
                    for (std::size_t j = 0; j < bones_; ++j) fit_bone(j, g, couplings);
                }
            }
        });
    }

    /// Optimises the weights for fixed maps. With `removals`, also computes the error added by removing each
    /// bone.
    void fit_weights(const WeightStep& step, const Running& running) {
        const std::size_t n = motion_->vertices, b = bones_;
        const MapPairs pairs = pair_maps(running);
        const VertexWeights before = weights_;
        std::vector<double> removal(step.removals ? weights_.weights.size() : 0, 0);
        constexpr std::size_t block = 32;
        in_parallel(running, (n + block - 1) / block, 1, [&](std::size_t begin, std::size_t end) {
            VertexFit vertex(*motion_, pairs, before, step);
            Eigen::MatrixXd against;
            const auto numbers = Eigen::Index(3 * motion_->lanes);
            const Eigen::Map<const MapRows> maps(maps_.data(), Eigen::Index(4 * b), numbers);
            for (std::size_t piece = begin; piece < end; ++piece) {
                const std::size_t first = piece * block, last = (std::min)(first + block, n);
                const Eigen::Map<const Eigen::MatrixXd> paths(motion_->path(first), numbers,
                                                              Eigen::Index(last - first));
                against.noalias() = maps * paths;
                for (std::size_t i = first; i < last; ++i) {
                    errors_[i] = vertex.fit(i, against.data() + (i - first) * 4 * b, weights_);
                    for (std::size_t k = 0; step.removals && k < vertex.used(); ++k)
                        removal[i * weights_.width + k] = vertex.removal(k);
                }
            }
        });
        error_ = std::accumulate(errors_.begin(), errors_.end(), 0.0);
        removals_.assign(b, 0);
        for (std::size_t k = 0; k < removal.size(); ++k) removals_[weights_.joints[k]] += removal[k];
    }
    /// Extrapolates the weights by a share of the difference to `last`; does not add bones to vertices.
    void extrapolate(const VertexWeights& last, double share) noexcept {
        const std::size_t width = weights_.width;
        for (std::size_t i = 0; i < motion_->vertices; ++i) {
            double* const w = weights_.weights.data() + i * width;
            const std::uint32_t* const owner = weights_.joints.data() + i * width;
            double sum = 0;
            for (std::size_t k = 0; k < width; ++k) {
                if (!(w[k] > 0)) continue;
                double before = 0;
                for (std::size_t n = i * width; n < (i + 1) * width; ++n) {
                    if (last.weights[n] > 0 && last.joints[n] == owner[k]) before = last.weights[n];
                }
                sum += w[k] = (std::fmax)(w[k] + share * (w[k] - before), 0.0);
            }
            for (std::size_t k = 0; k < width; ++k) w[k] /= sum;
        }
    }
    /// Returns, per bone, the error added by its removal. Valid after a step of weights with `removals`.
    const std::vector<double>& removals() const noexcept { return removals_; }

    /// Removes bones and renormalises the remaining weights.
    void remove_bones(const std::vector<bool>& removed) {
        const std::size_t lanes = motion_->lanes;
        std::vector<std::uint32_t> number(bones_, 0);
        std::size_t kept = 0;
        for (std::size_t j = 0; j < bones_; ++j) {
            if (removed[j]) continue;
            number[j] = std::uint32_t(kept);
            std::copy_n(maps_.begin() + std::ptrdiff_t(12 * lanes * j), 12 * lanes,
                        maps_.begin() + std::ptrdiff_t(12 * lanes * kept));
            std::copy_n(rotations_.begin() + std::ptrdiff_t(9 * lanes * j), 9 * lanes,
                        rotations_.begin() + std::ptrdiff_t(9 * lanes * kept));
            ++kept;
        }
        maps_.resize(kept * 12 * lanes);
        rotations_.resize(kept * 9 * lanes);
        for (std::size_t i = 0; i < motion_->vertices; ++i) {
            double* const w = weights_.weights.data() + i * weights_.width;
            std::uint32_t* const owner = weights_.joints.data() + i * weights_.width;
            double sum = 0;
            for (std::size_t k = 0; k < weights_.width; ++k) {
                if (removed[owner[k]]) w[k] = 0;
                owner[k] = w[k] > 0 ? number[owner[k]] : 0;
                sum += w[k];
            }
            for (std::size_t k = 0; k < weights_.width; ++k) w[k] = sum > 0 ? w[k] / sum : k == 0 ? 1 : 0;
        }
        bones_ = kept;
    }

private:
    using MapRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    struct Share {
        std::uint32_t vertex;
        double weight;
    };
    /// The sums Σ_i w_ij w_ik (x, y, z, 1)(x, y, z, 1)ᵀ for each pair of bones, and Σ_i w_ij (x, y, z, 1)
    /// x_iᵀ for each bone. All vertices are weighted by importance.
    struct Couplings {
        struct Other {
            std::uint32_t bone;
            Products sum;
        };
        std::vector<Products> of;               ///< sum of each bone with itself
        std::vector<std::vector<Other>> others; ///< sums of each bone with others
        std::vector<std::vector<double>>
            right_sides; ///< per bone, laid out as its map; empty for an idle bone
    };
    void sum_couplings(std::size_t bone, std::span<const Share> shares, Couplings& to) const {
        const std::size_t numbers = 3 * motion_->lanes;
        Products& own = to.of[bone];
        own = {};
        auto& first = to.right_sides[bone];
        first.assign(shares.empty() ? 0 : 4 * numbers, 0);
        for (const auto& [i, w] : shares) {
            const auto v = products_of(motion_->rest[i]);
            for (std::size_t n = 0; n < v.size(); ++n) own[n] += importance_[i] * w * w * v[n];
            const double* const path = motion_->path(i);
            for (std::size_t c = 0; c < 4; ++c) {
                const double factor = importance_[i] * w * v[product_of[c][3]];
                double* const row = first.data() + c * numbers;
                for (std::size_t n = 0; n < numbers; ++n) row[n] += factor * path[n];
            }
        }
    }

    Couplings couple(const Running& running) const {
        Couplings result;
        result.of.resize(bones_);
        result.right_sides.resize(bones_);
        result.others.resize(bones_);
        std::vector<std::vector<Share>> shares(bones_);
        for (std::size_t i = 0; i < motion_->vertices; ++i) {
            for (std::size_t k = i * weights_.width; k < (i + 1) * weights_.width; ++k) {
                const double w = weights_.weights[k];
                if (w > 0) shares[weights_.joints[k]].push_back({std::uint32_t(i), w});
            }
        }
        in_parallel(running, bones_, 1, [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t> place(bones_);
            for (std::size_t j = begin; j < end; ++j) {
                sum_couplings(j, shares[j], result);
                auto& others = result.others[j];
                std::fill(place.begin(), place.end(), std::uint32_t(bones_));
                for (const auto& [i, w] : shares[j]) {
                    const auto v = products_of(motion_->rest[i]);
                    for (std::size_t n = i * weights_.width; n < (i + 1) * weights_.width; ++n) {
                        const std::uint32_t other = weights_.joints[n];
                        const double with = weights_.weights[n];
                        if (!(with > 0) || other == j) continue;
                        if (place[other] == bones_) {
                            place[other] = std::uint32_t(others.size());
                            others.push_back({other, {}});
                        }
                        Products& sum = others[place[other]].sum;
                        for (std::size_t m = 0; m < v.size(); ++m) sum[m] += importance_[i] * w * with * v[m];
                    }
                }
            }
        });
        return result;
    }

    /// Index of the entry (axis, column) of a bone's map in frame 0.
    std::size_t row(std::size_t bone, std::size_t column, std::size_t axis) const noexcept {
        return ((4 * bone + column) * 3 + axis) * motion_->lanes;
    }
    static DoubleLanes load(const double* from) noexcept {
        Lanes<double> numbers;
        for (std::size_t n = 0; n < Motion::group; ++n) numbers[n] = from[n];
        return DoubleLanes::load(numbers);
    }
    /// Right sides of a bone minus the contributions of other bones, by column and axis, in the frames of a
    /// group that starts at `at`.
    std::array<std::array<DoubleLanes, 3>, 4> residual_of(std::size_t bone, std::size_t at,
                                                          const Couplings& couplings) const noexcept {
        std::array<std::array<DoubleLanes, 3>, 4> left;
        for (std::size_t c = 0; c < 4; ++c) {
            for (std::size_t r = 0; r < 3; ++r)
                left[c][r] = load(couplings.right_sides[bone].data() + row(0, c, r) + at);
        }
        if (couplings.others.empty()) return left;
        for (const auto& [other, sum] : couplings.others[bone]) {
            for (std::size_t r = 0; r < 3; ++r) {
                DoubleLanes map[4];
                for (std::size_t c = 0; c < 4; ++c) map[c] = load(maps_.data() + row(other, c, r) + at);
                for (std::size_t c = 0; c < 4; ++c) {
                    for (std::size_t d = 0; d < 4; ++d)
                        left[c][r] = multiply_add(DoubleLanes(-sum[product_of[c][d]]), map[d], left[c][r]);
                }
            }
        }
        return left;
    }
    /// Fits the map of a bone to the residual of the other bones, in the frames of a group.
    void fit_bone(std::size_t bone, std::size_t group, const Couplings& couplings) noexcept {
        if (couplings.right_sides[bone].empty()) return;
        const std::size_t at = group * Motion::group;
        const auto left = residual_of(bone, at, couplings);
        const Products& own = couplings.of[bone];
        const double mass = own[9];
        if (!(mass > 1e-12)) return;
        const Vec<double, 3> centre{own[3] / mass, own[6] / mass, own[8] / mass};
        // Covariance of the vertices, and J, from which the rotation is computed.
        double spread[3][3];
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c)
                spread[r][c] = own[product_of[r][c]] - mass * centre[r] * centre[c];
        }
        const double size = (std::fmax)(spread[0][0] + spread[1][1] + spread[2][2], 0.0);
        LinearMap<DoubleLanes, 3> j, turn, pulled;
        const auto turn_row = [&](std::size_t r, std::size_t c) {
            return rotations_.data() + ((3 * bone + r) * 3 + c) * motion_->lanes + at;
        };
        // Adds a weak pull towards the previous rotation. It determines the rotation if J is singular.
        const double pull = 1e-4 * size + 1e-9 * mass;
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                j.at[r][c] = left[c][r] - DoubleLanes(centre[c]) * left[3][r];
                turn.at[r][c] = load(turn_row(r, c));
                pulled.at[r][c] = j.at[r][c] + DoubleLanes(pull) *
                                                   (r == c ? turn.at[r][c] + DoubleLanes(1) : turn.at[r][c]);
            }
        }
        nearest_rotation(pulled, turn);
        LinearMap<DoubleLanes, 3> linear = turn;
        for (std::size_t r = 0; r < 3; ++r) linear.at[r][r] += DoubleLanes(1);
        if (kind_ == BoneKind::similar) scale(linear, j, size, pull);
        if (kind_ == BoneKind::stretched) stretch(linear, j, spread, size + 1e-9 * mass);
        const auto store = [&](const DoubleLanes& x, double* to) {
            Lanes<double> numbers;
            x.store(numbers);
            for (std::size_t n = 0; n < Motion::group; ++n) to[n] = at + n < motion_->frames ? numbers[n] : 0;
        };
        for (std::size_t r = 0; r < 3; ++r) {
            DoubleLanes shift = DoubleLanes(1 / mass) * left[3][r];
            for (std::size_t c = 0; c < 3; ++c) {
                shift -= linear.at[r][c] * DoubleLanes(centre[c]);
                store(linear.at[r][c], maps_.data() + row(bone, c, r) + at);
                store(turn.at[r][c], turn_row(r, c));
            }
            store(shift, maps_.data() + row(bone, 3, r) + at);
        }
    }
    /// Multiplies a rotation by the scale that fits J best.
    static void scale(LinearMap<DoubleLanes, 3>& turn, const LinearMap<DoubleLanes, 3>& j, double size,
                      double pull) {
        DoubleLanes along(pull);
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) along = multiply_add(turn.at[r][c], j.at[r][c], along);
        }
        const DoubleLanes factor = (max)(along / DoubleLanes(size + pull), DoubleLanes(1e-3));
        for (auto& line : turn.at) {
            for (DoubleLanes& x : line) x *= factor;
        }
    }
    /// Replaces a rotation by the affine map that fits J best. The rotation is kept in directions without
    /// extent.
    static void stretch(LinearMap<DoubleLanes, 3>& turn, const LinearMap<DoubleLanes, 3>& j,
                        const double (&spread)[3][3], double size) {
        const double hold = 1e-3 * size / 3;
        double a[3][3];
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) a[r][c] = spread[r][c] + (r == c ? hold : 0);
        }
        double inverse[3][3];
        const auto minor = [&a](std::size_t r, std::size_t c) {
            const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            return a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
        };
        const double determinant = a[0][0] * minor(0, 0) + a[0][1] * minor(0, 1) + a[0][2] * minor(0, 2);
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) inverse[r][c] = minor(c, r) / determinant;
        }
        LinearMap<DoubleLanes, 3> result;
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                result.at[r][c] = DoubleLanes(0);
                for (std::size_t k = 0; k < 3; ++k) {
                    const DoubleLanes right = multiply_add(DoubleLanes(hold), turn.at[r][k], j.at[r][k]);
                    result.at[r][c] = multiply_add(right, DoubleLanes(inverse[k][c]), result.at[r][c]);
                }
            }
        }
        turn = result;
    }

    MapPairs pair_maps(const Running& running) const {
        MapPairs pairs{bones_, std::vector<Products>(bones_ * bones_)};
        const auto numbers = Eigen::Index(3 * motion_->lanes);
        const Eigen::Map<const MapRows> maps(maps_.data(), Eigen::Index(4 * bones_), numbers);
        in_parallel(running, bones_, 1, [&](std::size_t begin, std::size_t end) {
            Eigen::MatrixXd dots;
            for (std::size_t j = begin; j < end; ++j) {
                dots.noalias() = maps.topRows(Eigen::Index(4 * j + 4)) *
                                 maps.middleRows(Eigen::Index(4 * j), 4).transpose();
                for (std::size_t k = 0; k <= j; ++k) {
                    Products p{};
                    for (std::size_t c = 0; c < 4; ++c) {
                        for (std::size_t d = 0; d < 4; ++d)
                            p[product_of[c][d]] += dots(Eigen::Index(4 * k + c), Eigen::Index(d));
                    }
                    pairs.of[j * bones_ + k] = pairs.of[k * bones_ + j] = p;
                }
            }
        });
        return pairs;
    }

    const Motion* motion_;
    BoneKind kind_;
    VertexWeights weights_;
    std::size_t bones_ = 0;
    std::vector<double> maps_;      ///< #bones · 4 columns · 3 axes · lanes
    std::vector<double> rotations_; ///< #bones · 9 · lanes: rotations minus the identity
    std::vector<double> errors_, removals_;
    std::vector<double> importance_; ///< importance of each vertex in the step of bones
    double error_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
