// One stage of a wrap: the pose of one basis, a lattice or the cage, for stiffnesses in descending order.
//
// With handles p, weights w, vertices y = Σ w p of the source, and Jacobians J of the map at samples, the
// energy is
//
//     1/N Σ ρ [(n·(y − q))² + 0.1 |y − q|²]     matches q of both directions (wrap_matches.hpp)
//     + λ Σ a |J − R|²                          as rigid as possible: R the nearest rotation, Σ a = 1
//     + λ ℓ²/S Σ |J − J'|²/|s − s'|²            neighbouring samples, ℓ = 0.1
//     + 0.3/K Σ max(0, n·(q − x))²              guarded followers x
//     + μ Σ m |x − t|²                          landmarks
//     + r Σ (second differences)²               of a lattice
//
// in units of the target's height. Each pull is written as a place z = y + u with the mean u of its weighted
// matches over max(1, Σρ), so |y − z|² majorises the first sum with a constant matrix. The matrix is factored
// once for each λ. Iterations alternate matches and rotations with a solve, and are accelerated (Anderson).
#pragma once

#include <cageform/fit/detail/fold_guard.hpp>
#include <cageform/fit/detail/wrap_matches.hpp>
#include <cageform/pose/detail/anderson.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

struct WrapStageOptions {
    WrapOptions::Stage stage;
    double floor = 0.1, residual = 0;
    double noise = 0; ///< of the target; 0: unknown or low
    bool first_by_landmarks = false, guards_followers = true, is_last = false;
    const std::vector<char>* free_handles = nullptr; ///< #handles: which may move; null: all
    /// Number of vertices of the source that are matched. The last stiffness of the last stage matches all.
    std::size_t vertices = 5000;
};

template <class Basis>
class WrapStageSolver {
    using Point = Vec<double, 3>;
    using Rows = typename Basis::Rows;
    using Matrix = typename Basis::Matrix;
    static constexpr double smoothing = 0.01; // ℓ²
    static constexpr double guard_weight = 0.3;

public:
    WrapStageSolver(WrapScene& scene, const Basis& basis, const WrapStageOptions& options,
                    const Running& running)
        : scene_(scene)
        , basis_(basis)
        , options_(options)
        , running_(running)
        , guard_(scene, basis, options.floor, running)
        , sample_rows_(guard_.sample_rows())
        , data_(basis.matrix({}))
        , rigid_(data_)
        , sum_(data_) {}

    /// Improves the pose (all handles of the basis). If cancelled, the pose is that of the last stiffness.
    /// Throws std::bad_alloc.
    Status run(std::vector<Point>& pose, WrapReport& report, WrapReport::End& ended) {
        if (const Status status = prepare(pose); status != Status::ok) return status;
        WrapMatches matches(scene_, matched_, options_.stage.normal_length, options_.is_last, running_);
        std::vector<double> list = options_.stage.stiffness;
        if (options_.first_by_landmarks && !list.empty()) list.insert(list.begin(), list.front());
        for (std::size_t n = 0; n < list.size(); ++n) {
            const double data = options_.first_by_landmarks && n == 0 ? 1e-3 : 1;
            const bool matches_all = options_.is_last && n + 1 == list.size();
            const std::size_t most = matches_all ? scene_.source.size() : options_.vertices;
            const bool restarts = n == 0 || matched_.size() < (std::min)(most, scene_.source.size());
            if (restarts) {
                choose_matched(most);
                matches.restart();
            }
            if (restarts || (options_.first_by_landmarks && n == 1)) set_data(data);
            WrapReport::Step step{options_.stage.cells, unknowns_.size(), list[n], 0, 0, 0, 1};
            const std::vector<Point> good = pose;
            const Running running =
                running_.subtask(double(n) / double(list.size()), double(n + 1) / double(list.size()));
            Status status = solve({list[n], data, matches, pose, step, running});
            step.residual = matches.rms();
            if (status == Status::ok) status = guard_.apply(unknowns_, good, pose, step);
            if (status != Status::ok) {
                pose = good;
                return status;
            }
            move_source(pose);
            report.steps.push_back(step);
            report.unmatched_source = matches.unmatched_source();
            report.unmatched_target = matches.unmatched_target();
            if (step.kept < 0.5) {
                ended = WrapReport::End::fold;
                break;
            }
            if (options_.noise > 0 && matches.back_residual(places_, normals_) <= options_.noise) {
                ended = WrapReport::End::noise;
                break;
            }
            if (options_.residual > 0 && options_.is_last &&
                matches.upper_residual(places_) < options_.residual) {
                ended = WrapReport::End::residual;
                break;
            }
        }
        return Status::ok;
    }

    /// Applies the pose to all points of the scene, and its Jacobian to theirs.
    Status finish(const std::vector<Point>& pose) {
        for (MovedPoints* points : {&scene_.samples, &scene_.source, &scene_.followers, &scene_.marks}) {
            std::vector<LinearMap<double, 3>> jacobians;
            Rows rows;
            Status status = guard_.add_jacobians(*points, pose, jacobians);
            if (status == Status::ok) status = basis_.weights(points->now, rows);
            if (status != Status::ok) return status;
            for (std::size_t i = 0; i < points->size(); ++i) points->now[i] = rows.product(i, pose);
            points->jacobians = std::move(jacobians);
        }
        return Status::ok;
    }

private:
    void choose_matched(std::size_t most) {
        matched_ = shuffled(scene_.source.size());
        matched_.resize((std::min)(matched_.size(), most));
        std::sort(matched_.begin(), matched_.end());
    }
    Status prepare(const std::vector<Point>& pose) {
        std::vector<Point> guarded;
        for (std::size_t n = 0; options_.guards_followers && n < scene_.guarded.size(); ++n)
            guarded.push_back(scene_.followers.now[scene_.guarded[n].follower]);
        Status status = basis_.weights(scene_.source.now, vertex_rows_);
        if (status == Status::ok) status = basis_.weights(guarded, guard_rows_);
        if (status == Status::ok) status = basis_.weights(scene_.marks.now, mark_rows_);
        if (status == Status::ok) status = guard_.evaluate_samples();
        if (status != Status::ok) return status;
        is_unknown_.assign(basis_.size(), 0);
        for (const Rows* rows : {&std::as_const(vertex_rows_), &std::as_const(guard_rows_),
                                 &std::as_const(mark_rows_), &sample_rows_}) {
            for (std::size_t n = 0; n < rows->size(); ++n)
                rows->for_each(n, [&](std::size_t i, double /*w*/) { is_unknown_[i] = 1; });
        }
        for (std::size_t i = 0; i < basis_.size(); ++i) {
            if (options_.free_handles != nullptr && (*options_.free_handles)[i] == 0) is_unknown_[i] = 0;
            if (is_unknown_[i] != 0) unknowns_.push_back(std::uint32_t(i));
        }
        if (unknowns_.empty()) return Status::samples_missing;
        rigidity_.assign(scene_.samples.size(), 1);
        turns_.resize(block_count<double>(scene_.samples.size()) * 9);
        for (auto& row : turns_) DoubleLanes(0).store(row);
        data_ = basis_.matrix(unknowns_);
        rigid_ = data_;
        sum_ = data_;
        set_rigid();
        move_source(pose);
        return Status::ok;
    }

    void move_source(const std::vector<Point>& pose) {
        places_.resize(vertex_rows_.size());
        for (std::size_t i = 0; i < places_.size(); ++i) places_[i] = vertex_rows_.product(i, pose);
        normals_ = vertex_normals(places_, scene_.source_faces);
    }

    /// Sets the matrix of the terms that do not depend on λ.
    void set_data(double data) {
        data_.clear();
        for (const std::uint32_t i : matched_)
            data_.add_product(vertex_rows_, i, i, data / double(matched_.size()));
        for (std::size_t n = 0; n < guard_rows_.size(); ++n)
            data_.add_product(guard_rows_, n, n, guard_weight / double(guard_rows_.size()));
        for (std::size_t n = 0; n < mark_rows_.size(); ++n)
            data_.add_product(mark_rows_, n, n, mark_weight(n));
    }
    double mark_weight(std::size_t n) const noexcept {
        return (options_.is_last ? 0.1 : 1) * scene_.mark_weights[n];
    }
    /// Sets the matrix of the rigidity and smoothness of the samples, for λ = 1.
    void set_rigid() {
        rigid_.clear();
        const double share = 1 / double(scene_.samples.size());
        std::vector<double> own(scene_.samples.size());
        for (std::size_t s = 0; s < own.size(); ++s) own[s] = share * rigidity_[s];
        for (const auto& [a, b] : scene_.neighbours) {
            const auto apart = scene_.samples.rest[a] - scene_.samples.rest[b];
            const double weight = smoothing * share / dot(apart, apart);
            own[a] += weight;
            own[b] += weight;
            for (std::size_t k = 0; k < 3; ++k) {
                rigid_.add_product(sample_rows_, std::size_t{3} * a + k, std::size_t{3} * b + k, -weight);
                rigid_.add_product(sample_rows_, std::size_t{3} * b + k, std::size_t{3} * a + k, -weight);
            }
        }
        for (std::size_t s = 0; s < own.size(); ++s) {
            for (std::size_t k = 0; k < 3; ++k)
                rigid_.add_product(sample_rows_, 3 * s + k, 3 * s + k, own[s]);
        }
    }

    /// The search for one stiffness.
    struct Task {
        double stiffness, data; ///< λ, and the weight of the matches
        WrapMatches& matches;
        std::vector<Point>& pose;
        WrapReport::Step& step;
        const Running& running;
    };

    Status solve(const Task& task) {
        constexpr int attempts = 3;
        for (int attempt = 0; attempt < attempts; ++attempt) {
            sum_.set_sum(data_, task.stiffness, rigid_);
            const double mean = sum_.trace() / double(unknowns_.size());
            const double ridge = 1e-5 * task.stiffness / (task.stiffness + 1e-4), proximity = 1e-7 * mean;
            basis_.add_ridge(sum_, is_unknown_, ridge * mean);
            for (const std::uint32_t i : unknowns_) sum_.add_entry(i, i, proximity);
            if (!factors_.factor(sum_)) return Status::pose_not_determined;
            if (!iterate(task, proximity)) return Status::cancelled;
            bool is_low = false;
            const auto least = guard_.stretches_of_samples(task.pose);
            for (std::size_t s = 0; s < least.size(); ++s) {
                if (!(least[s] < options_.floor)) continue;
                is_low = true;
                rigidity_[s] *= 10;
            }
            if (!is_low) break;
            set_rigid();
        }
        return Status::ok;
    }

    /// Returns false if cancelled.
    bool iterate(const Task& task, double proximity) {
        constexpr int most = 25;
        constexpr double settled = 1e-4;
        const std::size_t blocks = block_count<double>(3 * unknowns_.size());
        anderson_.reset(blocks, 5);
        from_.resize(blocks);
        to_.resize(blocks);
        for (std::size_t b = 0; b < blocks; ++b) { // also the padding
            DoubleLanes(0).store(from_[b]);
            DoubleLanes(0).store(to_[b]);
        }
        for (int n = 0; n < most; ++n) {
            task.matches.find(places_, normals_, n % 5 == 0);
            step(task, proximity);
            const std::vector<Point> before = places_;
            move_source(task.pose);
            double moved = 0;
            for (std::size_t i = 0; i < places_.size(); ++i)
                moved += dot(places_[i] - before[i], places_[i] - before[i]);
            const std::size_t done = ++task.step.iterations;
            if (!task.running.keep_going(double(done) / double(done + most))) return false;
            if (moved < settled * settled * double(places_.size())) break;
        }
        return true;
    }
    /// Returns the right-hand side for the matches and rotations of a pose; #handles.
    std::vector<Point> right_side(const Task& task) {
        std::vector<Point> right(basis_.size());
        const double share = task.data / double(matched_.size());
        for (std::size_t k = 0; k < matched_.size(); ++k)
            vertex_rows_.add(matched_[k], share * (places_[matched_[k]] + task.matches.pulls()[k]), right);
        for (std::size_t k = 0; k < guard_rows_.size(); ++k) {
            const Point x = guard_rows_.product(k, task.pose);
            const Point pull = task.matches.guard_pull(k, x, normals_[scene_.guarded[k].vertex]);
            guard_rows_.add(k, (guard_weight / double(guard_rows_.size())) * (x + pull), right);
        }
        for (std::size_t k = 0; k < mark_rows_.size(); ++k)
            mark_rows_.add(k, mark_weight(k) * scene_.mark_targets[k], right);
        add_rotations(task.stiffness, task.pose, right);
        sum_.subtract_fixed(task.pose, right);
        return right;
    }
    /// Solves for the pose, with acceleration unless the accelerated step is 20 times as long.
    void step(const Task& task, double proximity) {
        const std::vector<Point> right = right_side(task);
        std::vector<Point> solution(unknowns_.size());
        for (std::size_t u = 0; u < unknowns_.size(); ++u)
            solution[u] = right[unknowns_[u]] + proximity * task.pose[unknowns_[u]];
        factors_.solve(solution);
        const auto at = [](std::vector<Lanes<double>>& x, std::size_t i) -> double& {
            return x[i / lane_count<double>][i % lane_count<double>];
        };
        double plain = 0, accelerated = 0;
        for (std::size_t u = 0; u < unknowns_.size(); ++u) {
            for (std::size_t k = 0; k < 3; ++k) {
                at(from_, 3 * u + k) = task.pose[unknowns_[u]][k];
                at(to_, 3 * u + k) = solution[u][k];
                plain = (std::max)(plain, std::fabs(solution[u][k] - task.pose[unknowns_[u]][k]));
            }
        }
        anderson_.step(from_.data(), to_.data());
        for (std::size_t u = 0; u < unknowns_.size(); ++u) {
            for (std::size_t k = 0; k < 3; ++k)
                accelerated =
                    (std::max)(accelerated, std::fabs(at(from_, 3 * u + k) - task.pose[unknowns_[u]][k]));
        }
        auto& next = accelerated < 20 * plain + 1e-12 ? from_ : to_;
        for (std::size_t u = 0; u < unknowns_.size(); ++u)
            task.pose[unknowns_[u]] = {at(next, 3 * u), at(next, 3 * u + 1), at(next, 3 * u + 2)};
    }

    /// Adds λ a Σ_k g_k R_k of all samples to the right-hand side.
    void add_rotations(double stiffness, const std::vector<Point>& pose, std::vector<Point>& right) {
        const std::size_t count = scene_.samples.size();
        std::vector<Lanes<double>> jacobians(turns_.size());
        in_parallel(running_, turns_.size() / 9, 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                LinearMap<DoubleLanes, 3> j, turn;
                for (std::size_t lane = 0; lane < lane_count<double>; ++lane) {
                    const std::size_t s = (std::min)(b * lane_count<double> + lane, count - 1);
                    for (std::size_t c = 0; c < 3; ++c) {
                        const Point column = sample_rows_.product(3 * s + c, pose);
                        for (std::size_t r = 0; r < 3; ++r) jacobians[9 * b + 3 * r + c][lane] = column[r];
                    }
                }
                for (std::size_t n = 0; n < 9; ++n) {
                    j.at[n / 3][n % 3] = DoubleLanes::load(jacobians[9 * b + n]);
                    turn.at[n / 3][n % 3] = DoubleLanes::load(turns_[9 * b + n]);
                }
                nearest_rotation(j, turn);
                for (std::size_t n = 0; n < 9; ++n) turn.at[n / 3][n % 3].store(turns_[9 * b + n]);
            }
        });
        for (std::size_t s = 0; s < count; ++s) {
            const Lanes<double>* const turn = &turns_[s / lane_count<double> * 9];
            const std::size_t lane = s % lane_count<double>;
            const double weight = stiffness * rigidity_[s] / double(count);
            for (std::size_t c = 0; c < 3; ++c) {
                Point column{turn[c][lane], turn[3 + c][lane], turn[6 + c][lane]};
                column[c] += 1;
                sample_rows_.add(3 * s + c, weight * column, right);
            }
        }
    }

    WrapScene& scene_;
    const Basis& basis_;
    const WrapStageOptions& options_;
    const Running& running_;
    std::vector<std::uint32_t> matched_; ///< vertices of the source that are matched
    Rows vertex_rows_, guard_rows_, mark_rows_;
    FoldGuard<Basis> guard_;
    const Rows& sample_rows_;             ///< derivatives
    std::vector<char> is_unknown_;        ///< #handles
    std::vector<std::uint32_t> unknowns_; ///< handles with a row
    std::vector<double> rigidity_;        ///< #samples times the weights a
    std::vector<Lanes<double>> turns_;    ///< R − 1, nine rows per block of samples
    Matrix data_, rigid_, sum_;           ///< D, R and D + λ R
    typename Basis::Factors factors_;
    Anderson anderson_;
    std::vector<Lanes<double>> from_, to_; ///< unknowns before and after a step
    std::vector<Point> places_, normals_;  ///< of all vertices of the moved source
};

} // namespace cageform::inline CAGEFORM_ABI::detail
