// Chooses few handles for each vertex of a mesh, all vertices at once, so that the loss is smooth.
#pragma once

#include <cageform/binding/detail/near_weights.hpp>
#include <cageform/cage/detail/indices.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>
#include <cageform/parallel/running.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Minimises over rows w, each with at most K non-negative weights of sum 1,
///
///     Σ_edges e_ij |r_i − r_j|² + α Σ_i |r_i|² + β Σ_i |w_i c − q_i|²,   r_i = (w_i − w0_i) B,
///
/// where B Bᵀ is the covariance of the handles' displacements. The loss therefore measures visible
/// differences: a handle may replace one close to it. Solved by projected gradients with Nesterov's
/// momentum (Beck and Teboulle, SIAM J. Imaging Sci. 2, 2009), with a step size per row. Handles are
/// dropped in rounds, between which the weights adapt. Weights smoothed over the mesh decide which
/// handles to drop, so that neighbours agree.
template <std::size_t D>
class SmoothWeights {
public:
    static constexpr std::size_t no_node = ~std::size_t{0};

    SmoothWeights(const std::vector<Vec<double, D>>& handles, std::size_t most)
        : handle_count_(handles.size())
        , most_((std::min)(most, handles.size())) {
        const auto bounds = bounds_of(std::span<const Vec<double, D>>(handles));
        size_ = (std::max)(double(bounds.diagonal()), (std::numeric_limits<double>::min)());
        for (const auto& handle : handles) {
            middle_ = middle_ + (1 / double(handle_count_)) * handle;
        }
        factorise(handles);
        for (std::size_t h = 0; h < handle_count_; ++h) {
            const auto c = (1 / size_) * (handles[h] - middle_);
            for (std::size_t k = 0; k < D; ++k) columns_[h * width_ + rank_ + k] = c[k];
        }
    }

    /// Adds the next vertex.
    ///
    ///   position  the point that its weights must reproduce
    ///   weight    weight(handle): w0 of a handle
    template <class Weight>
    void add_node(const Vec<double, D>& position, const Weight& weight) {
        positions_.push_back(position);
        const std::size_t first = target_.size();
        target_.resize(first + width_, 0.0);
        for (std::size_t h = 0; h < handle_count_; ++h) {
            const double w = weight(h);
            smoothed_.push_back(float((std::max)(w, 0.0)));
            for (std::size_t r = 0; r < rank_; ++r) target_[first + r] += w * columns_[h * width_ + r];
        }
        const auto q = (1 / size_) * (position - middle_);
        for (std::size_t k = 0; k < D; ++k) target_[first + rank_ + k] = q[k];
    }
    void add_edge(std::size_t a, std::size_t b) {
        if (a != b && a != no_node && b != no_node) edges_.push_back({(std::min)(a, b), (std::max)(a, b)});
    }

    Status solve(const Running& running) {
        connect();
        loss_.assign(positions_.size() * width_, 0.0);
        step_.resize(positions_.size());
        for (std::size_t round = 0; round < rounds.size(); ++round) {
            const bool is_last = round + 1 == rounds.size();
            if (!choose(round, running)) return Status::cancelled;
            const int passes = is_last ? 120 : 40;
            const double from = double(round) / double(rounds.size() + 2);
            const double to = is_last ? 1 : double(round + 1) / double(rounds.size() + 2);
            momentum_ = 1;
            for (int pass = 0; pass < passes; ++pass) {
                if (!running.keep_going(from + (to - from) * double(pass) / passes)) return Status::cancelled;
                improve(running);
            }
            if (rounds[round] == 2) wide_ = {kept_, weights()};
        }
        narrow_ = {kept_, weights()};
        return running.end(Status::ok);
    }

    /// Returns the weights of a node, possibly 0; `wide_row` returns those of the round with 2K handles.
    std::span<const HandleWeight> row(std::size_t node) const { return narrow_.row(node); }
    std::span<const HandleWeight> wide_row(std::size_t node) const { return wide_.row(node); }

private:
    // The best of several values, tried on two models: a head and a lamp.
    static constexpr double alpha = 0.02, beta = 100;
    // σ relative to the cage's diagonal: handles closer than this move similarly.
    static constexpr double sigma = 0.2;
    // The number of handles per round, relative to K.
    static constexpr std::array<double, 10> rounds{4, 3, 2.5, 2, 1.75, 1.5, 1.375, 1.25, 1.125, 1};

    struct Entry {
        std::uint32_t handle = 0;
        double weight = 0, extrapolated = 0; // at the end of a pass, and at the start of the next one
    };
    struct Neighbour {
        std::size_t node;
        double weight;
    };
    struct Rows {
        std::size_t width = 0;
        std::vector<HandleWeight> entries;

        std::span<const HandleWeight> row(std::size_t node) const {
            return std::span<const HandleWeight>(entries).subspan(node * width, width);
        }
    };

    std::vector<HandleWeight> weights() const {
        std::vector<HandleWeight> entries;
        entries.reserve(rows_.size());
        for (const Entry& entry : rows_) entries.push_back({entry.handle, entry.weight});
        return entries;
    }

    std::size_t handle_count_of(double factor) const {
        return (std::min)(handle_count_, std::size_t(std::lround(factor * double(most_))));
    }

    /// Computes the columns B of the covariance exp(−|c − c'|² / 2σ²) by a pivoted Cholesky
    /// factorisation, up to a residual of a thousandth.
    void factorise(const std::vector<Vec<double, D>>& handles) {
        constexpr std::size_t most_columns = 64;
        const auto covariance = [&](std::size_t a, std::size_t b) {
            const auto d = (1 / (sigma * size_)) * (handles[a] - handles[b]);
            return std::exp(-0.5 * dot(d, d));
        };
        std::vector<std::vector<double>> found; // columns
        std::vector<double> left(handle_count_, 1.0);
        while (found.size() < (std::min)(most_columns, handle_count_)) {
            const auto pivot = std::size_t(std::max_element(left.begin(), left.end()) - left.begin());
            if (left[pivot] < 1e-3) break;
            std::vector<double> column(handle_count_);
            for (std::size_t h = 0; h < handle_count_; ++h) {
                column[h] = covariance(h, pivot);
                for (const auto& before : found) column[h] -= before[h] * before[pivot];
            }
            const double scale = 1 / std::sqrt(left[pivot]);
            for (std::size_t h = 0; h < handle_count_; ++h) {
                column[h] *= scale;
                left[h] = (std::max)(left[h] - column[h] * column[h], 0.0);
            }
            found.push_back(std::move(column));
        }
        rank_ = found.size();
        width_ = rank_ + D;
        columns_.assign(handle_count_ * width_, 0.0);
        for (std::size_t h = 0; h < handle_count_; ++h) {
            // The largest row sum of the covariance bounds its largest eigenvalue.
            double sum = 0;
            for (std::size_t r = 0; r < rank_; ++r) columns_[h * width_ + r] = found[r][h];
            for (std::size_t other = 0; other < handle_count_; ++other) sum += covariance(h, other);
            covariance_bound_ = (std::max)(covariance_bound_, sum);
        }
    }

    /// Builds the neighbours of every node. The weight of an edge penalises changes of angles: the inverse
    /// square of its length relative to the mean length, at most 25.
    void connect() {
        sort_unique(edges_);
        const auto length = [&](const std::array<std::size_t, 2>& edge) {
            const auto d = positions_[edge[0]] - positions_[edge[1]];
            return std::sqrt(dot(d, d));
        };
        double mean = 0;
        for (const auto& edge : edges_) mean += length(edge) / double(edges_.size());
        begins_.assign(positions_.size() + 1, 0);
        for (const auto& edge : edges_) {
            for (const std::size_t node : edge) ++begins_[node + 1];
        }
        for (std::size_t n = 0; n < positions_.size(); ++n) begins_[n + 1] += begins_[n];
        neighbours_.resize(2 * edges_.size());
        std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
        for (const auto& edge : edges_) {
            constexpr double most = 25;
            const double l = length(edge), ratio = mean / l;
            const double weight = mean > 0 ? (ratio * ratio < most ? ratio * ratio : most) : 1;
            neighbours_[next[edge[0]]++] = {edge[1], weight};
            neighbours_[next[edge[1]]++] = {edge[0], weight};
        }
    }
    std::span<const Neighbour> neighbours_of(std::size_t node) const {
        return std::span<const Neighbour>(neighbours_)
            .subspan(begins_[node], begins_[node + 1] - begins_[node]);
    }

    template <class Body>
    void for_each_node(const Running& running, const Body& body) {
        in_parallel(running, positions_.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) body(n);
        });
    }

    /// Chooses the handles of a round: those with the largest smoothed weights among the remaining ones.
    bool choose(std::size_t round, const Running& running) {
        const std::size_t before = kept_;
        kept_ = handle_count_of(rounds[round]);
        if (round > 0) {
            if (kept_ == before) {
                for (Entry& entry : rows_) entry.extrapolated = entry.weight;
                return true;
            }
            std::fill(smoothed_.begin(), smoothed_.end(), 0.0F);
            for (std::size_t n = 0; n < positions_.size(); ++n) {
                for (std::size_t k = 0; k < before; ++k) {
                    const Entry& entry = rows_[n * before + k];
                    smoothed_[n * handle_count_ + entry.handle] = float(entry.weight);
                }
            }
        }
        std::vector<float> unsmoothed = smoothed_;
        for (int times = 0; times < 3; ++times) {
            smooth(running);
            if (!running.keep_going(double(round) / double(rounds.size() + 2))) return false;
        }
        std::vector<Entry> kept(positions_.size() * kept_);
        for_each_node(running, [&](std::size_t n) {
            std::vector<HandleWeight> order;
            const std::size_t count = round == 0 ? handle_count_ : before;
            for (std::size_t k = 0; k < count; ++k) {
                const std::uint32_t h = round == 0 ? std::uint32_t(k) : rows_[n * before + k].handle;
                order.push_back({h, double(smoothed_[n * handle_count_ + h])});
            }
            std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(kept_), order.end(), is_heavier);
            for (std::size_t k = 0; k < kept_; ++k)
                kept[n * kept_ + k] = {order[k].handle, 0,
                                       double(unsmoothed[n * handle_count_ + order[k].handle])};
            project(std::span(kept).subspan(n * kept_, kept_));
            double stiffness = 2 * alpha;
            for (const Neighbour& neighbour : neighbours_of(n)) stiffness += 2 * neighbour.weight;
            // Upper bounds of the largest eigenvalues. Positions are relative to the node, since the
            // sum of weights is 1.
            double position_bound = 0;
            for (std::size_t k = 0; k < kept_; ++k) {
                for (std::size_t r = rank_; r < width_; ++r) {
                    const double d =
                        columns_[kept[n * kept_ + k].handle * width_ + r] - target_[n * width_ + r];
                    position_bound += d * d;
                }
            }
            step_[n] = 1 / (stiffness * (std::min)(covariance_bound_, double(kept_)) + beta * position_bound);
        });
        rows_.swap(kept);
        return true;
    }

    /// Averages the smoothed weights of each node with the mean of its neighbours.
    void smooth(const Running& running) {
        std::vector<float> other(smoothed_.size());
        for_each_node(running, [&](std::size_t n) {
            const auto around = neighbours_of(n);
            for (std::size_t h = 0; h < handle_count_; ++h) {
                float sum = 0;
                for (const Neighbour& neighbour : around)
                    sum += smoothed_[neighbour.node * handle_count_ + h];
                const float own = smoothed_[n * handle_count_ + h];
                other[n * handle_count_ + h] =
                    around.empty() ? own : 0.5F * own + 0.5F * sum / float(around.size());
            }
        });
        smoothed_.swap(other);
    }

    /// Projects `extrapolated` to non-negative weights with the sum 1; sets both fields.
    static void project(std::span<Entry> row) {
        // Michelot, J. Optim. Theory Appl. 50 (1986): subtracts the mean surplus of the entries above it.
        double sum = -1, shift = -std::numeric_limits<double>::infinity();
        for (const Entry& entry : row) sum += entry.extrapolated;
        for (std::size_t count = row.size(), before = 0; count != before;) {
            before = count;
            shift = sum / double(count);
            sum = -1;
            count = 0;
            for (const Entry& entry : row) {
                if (!(entry.extrapolated > shift)) continue;
                sum += entry.extrapolated;
                ++count;
            }
        }
        for (Entry& entry : row)
            entry.weight = entry.extrapolated = (std::max)(entry.extrapolated - shift, 0.0);
    }

    /// Makes one pass over all rows.
    void improve(const Running& running) {
        for_each_node(running, [&](std::size_t n) {
            double* const loss = &loss_[n * width_];
            for (std::size_t r = 0; r < width_; ++r) loss[r] = -target_[n * width_ + r];
            for (std::size_t k = 0; k < kept_; ++k) {
                const Entry& entry = rows_[n * kept_ + k];
                const double* const column = &columns_[entry.handle * width_];
                for (std::size_t r = 0; r < width_; ++r) loss[r] += entry.extrapolated * column[r];
            }
        });
        const double next = 0.5 * (1 + std::sqrt(1 + 4 * momentum_ * momentum_));
        const double factor = (momentum_ - 1) / next;
        momentum_ = next;
        for_each_node(running, [&](std::size_t n) {
            std::array<double, 64 + D> force{};
            const double* const loss = &loss_[n * width_];
            for (std::size_t r = 0; r < rank_; ++r) force[r] = alpha * loss[r];
            for (std::size_t k = 0; k < D; ++k) force[rank_ + k] = beta * loss[rank_ + k];
            for (const Neighbour& neighbour : neighbours_of(n)) {
                const double* const other = &loss_[neighbour.node * width_];
                for (std::size_t r = 0; r < rank_; ++r) force[r] += neighbour.weight * (loss[r] - other[r]);
            }
            const auto row = std::span(rows_).subspan(n * kept_, kept_);
            std::array<double, 64> stack;
            std::vector<double> heap(kept_ > stack.size() ? kept_ : 0);
            double* const old = heap.empty() ? stack.data() : heap.data();
            for (std::size_t k = 0; k < kept_; ++k) {
                Entry& entry = row[k];
                const double* const column = &columns_[entry.handle * width_];
                double slope = 0;
                for (std::size_t r = 0; r < width_; ++r) slope += force[r] * column[r];
                old[k] = entry.weight;
                entry.extrapolated -= step_[n] * slope;
            }
            project(row);
            for (std::size_t k = 0; k < kept_; ++k)
                row[k].extrapolated = row[k].weight + factor * (row[k].weight - old[k]);
        });
    }

    std::size_t handle_count_, most_, kept_ = 0, rank_ = 0, width_ = D;
    double size_ = 1, covariance_bound_ = 0, momentum_ = 1;
    Vec<double, D> middle_{};
    std::vector<double> columns_;              // #handles · width: B, then positions
    std::vector<Vec<double, D>> positions_;    // #nodes
    std::vector<double> target_, loss_, step_; // #nodes · width; the same; #nodes
    std::vector<float> smoothed_;              // #nodes · #handles
    std::vector<std::array<std::size_t, 2>> edges_;
    std::vector<std::size_t> begins_;
    std::vector<Neighbour> neighbours_;
    std::vector<Entry> rows_; // #nodes · kept
    Rows narrow_, wide_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
