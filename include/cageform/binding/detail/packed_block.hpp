// One block of a packed binding: its points, its rows of weights, and their errors.
#pragma once

#include <cageform/binding/detail/moments.hpp>
#include <cageform/binding/detail/stored_weights.hpp>
#include <cageform/binding/detail/weight_loss.hpp>
#include <cageform/coordinates/project.hpp>

#include <array>
#include <new>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The points of a block; fewer than `lanes` in the last block.
template <Scalar T>
struct BlockPoints {
    std::array<std::size_t, lane_count<T>> index{};
    std::size_t count = 0;
};

/// Handles, and a row of weights for each: one weight per point of a block.
struct PackedRows {
    std::vector<std::uint32_t> handles; ///< ascending
    std::vector<double> weights;        ///< #handles rows of lanes
};

/// Reads, restores and measures the rows of a block.
template <Scalar T, std::size_t D>
class BlockPacker {
public:
    using Column = typename Moments<D>::Column;
    using Matrix = typename Moments<D>::Matrix;
    static constexpr std::size_t lanes = lane_count<T>;

    BlockPacker(const BindingView<T, D>& binding, const Moments<D>& moments, const WeightLoss<D>& loss)
        : binding_(binding)
        , moments_(moments)
        , loss_(loss) {}

    /// Returns the binding's weights as a row for each of `handles`. Lanes without a point are 0.
    PackedRows rows_of(const BlockPoints<T>& points, std::vector<std::uint32_t> handles) const {
        PackedRows rows{std::move(handles), {}};
        rows.weights.assign(rows.handles.size() * lanes, 0.0);
        for (std::size_t r = 0; r < rows.handles.size(); ++r) {
            for (std::size_t lane = 0; lane < points.count; ++lane)
                rows.weights[r * lanes + lane] =
                    double(binding_.weights(points.index[lane], rows.handles[r]));
        }
        return rows;
    }

    /// Restores the row sums of the points by the smallest change of their weights (2-norm). Where this
    /// change would make a non-negative row negative, the row is projected instead. Returns the largest
    /// change.
    Extreme restore(const BlockPoints<T>& points, PackedRows& rows) const {
        Extreme largest;
        const auto has_row = [&](std::size_t h) {
            return std::binary_search(rows.handles.begin(), rows.handles.end(), h);
        };
        const Matrix inverse = Moments<D>::power(moments_.sum_of_squares(has_row), -1);
        std::vector<double> weights(rows.handles.size()); // of one point
        for (std::size_t lane = 0; lane < points.count; ++lane) {
            const Column missing = residual(points.index[lane], lane, rows);
            const auto is_rounding = [](double x) { return std::fabs(x) <= 4 * double(epsilon<T>); };
            if (std::all_of(missing.v, missing.v + D + 1, is_rounding)) continue;
            const Column step = product(inverse, missing);
            double least_before = 0, least = 0;
            for (std::size_t r = 0; r < rows.handles.size(); ++r) {
                const double before = rows.weights[r * lanes + lane];
                weights[r] = before + dot(step, moments_[rows.handles[r]]);
                least_before = (std::min)(least_before, before);
                least = (std::min)(least, weights[r]);
            }
            if (least_before == 0 && least < 0) project_kept(points.index[lane], lane, rows, weights);
            for (std::size_t r = 0; r < rows.handles.size(); ++r) {
                const double change = weights[r] - rows.weights[r * lanes + lane];
                rows.weights[r * lanes + lane] = weights[r];
                largest.raise({std::fabs(change), points.index[lane]});
            }
        }
        return largest;
    }

    /// Returns the error of a point's row sums: Σ w a in the binding minus Σ w' a over `rows`.
    Column residual(std::size_t point, std::size_t lane, const PackedRows& rows) const {
        Column sum{};
        for (std::size_t h = 0; h < moments_.size(); ++h)
            sum = sum + double(binding_.weights(point, h)) * moments_[h];
        for (std::size_t r = 0; r < rows.handles.size(); ++r)
            sum = sum - rows.weights[r * lanes + lane] * moments_[rows.handles[r]];
        return sum;
    }

    /// Returns w' − w for all handles, as #handles rows of lanes. `stored` are the weights as stored;
    /// `residuals` are the stored errors of the row sums, empty for scalar weights.
    std::vector<double> change(const BlockPoints<T>& points, const PackedRows& stored,
                               std::span<const Column> residuals) const {
        std::vector<double> change(moments_.size() * lanes, 0.0);
        for (std::size_t h = 0, r = 0; h < moments_.size(); ++h) {
            const bool has_row = r < stored.handles.size() && stored.handles[r] == h;
            const Column fit = residuals.empty() ? Column{} : moments_.fit(h);
            for (std::size_t lane = 0; lane < points.count; ++lane) {
                double effective = has_row ? stored.weights[r * lanes + lane] : 0;
                if (!residuals.empty()) effective += dot(residuals[lane], fit);
                change[h * lanes + lane] = effective - double(binding_.weights(points.index[lane], h));
            }
            if (has_row) ++r;
        }
        return change;
    }

    /// Returns the errors of the row sums that a format stores per point; empty for scalar weights.
    std::vector<Column> residuals(WeightFormat format, const BlockPoints<T>& points,
                                  const PackedRows& stored) const {
        std::vector<Column> residuals;
        for (std::size_t lane = 0; format != WeightFormat::scalar && lane < points.count; ++lane)
            residuals.push_back(residual(points.index[lane], lane, stored));
        return residuals;
    }

    /// Returns the largest distance of the points if `rows` are stored in a format, or any distance
    /// above `limit`.
    double distance(WeightFormat format, const BlockPoints<T>& points, const PackedRows& rows, double limit,
                    std::size_t& first_pose) const {
        return loss_.template largest<lanes>(stored_change(format, points, rows), limit, first_pose);
    }

    /// Returns the largest distance and its point.
    Extreme farthest(WeightFormat format, const BlockPoints<T>& points, const PackedRows& rows) const {
        const auto distances = loss_.template distances<lanes>(stored_change(format, points, rows));
        Extreme farthest;
        for (std::size_t lane = 0; lane < points.count; ++lane)
            farthest.raise({distances[lane].value, points.index[lane]});
        return farthest;
    }

private:
    /// Projects the kept weights of a point so that they have the row sums of the binding's. Leaves `weights`
    /// unchanged if the handles of positive weights do not surround the point, or if handles are vectors.
    void project_kept(std::size_t point, std::size_t lane, const PackedRows& rows,
                      std::span<double> weights) const {
        if (binding_.handle_view().vector_count() > 0) return;
        const auto rest = vec_cast<double>(block_point<D>(binding_.rest, point));
        const auto handle = [&](std::size_t h) { return vec_cast<double>(binding_.rest_handles[h]) - rest; };
        double sum = 0;
        Vec<double, D> weighted{};
        for (std::size_t h = 0; h < moments_.size(); ++h) {
            const double w = double(binding_.weights(point, h));
            sum += w;
            weighted = weighted + w * handle(h);
        }
        if (!(sum > 0)) return;
        std::vector<double> prior, projected(weights.size());
        std::vector<Vec<double, D>> handles;
        for (std::size_t r = 0; r < weights.size(); ++r) {
            prior.push_back(rows.weights[r * lanes + lane]);
            handles.push_back(handle(rows.handles[r]));
        }
        const Status status = project<double, D>(prior, handles, (1 / sum) * weighted, projected);
        if (status == Status::out_of_memory) throw std::bad_alloc();
        for (std::size_t r = 0; r < weights.size() && status == Status::ok; ++r)
            weights[r] = sum * projected[r];
    }

    std::vector<double> stored_change(WeightFormat format, const BlockPoints<T>& points,
                                      PackedRows rows) const {
        std::vector<std::byte> memory(rows.weights.size() * sizeof(T));
        store_weights<T>(format, rows.weights, memory.data());
        return change(points, rows, residuals(format, points, rows));
    }

    const BindingView<T, D>& binding_;
    const Moments<D>& moments_;
    const WeightLoss<D>& loss_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
