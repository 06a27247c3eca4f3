// Packs one binding: chooses rows of weights per block, rounds them, and measures the loss.
#pragma once

#include <cageform/binding/detail/choose_rows.hpp>
#include <cageform/binding/detail/spatial_order.hpp>
#include <cageform/binding/types/pack_options.hpp>
#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/figure/types/blob.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <algorithm>
#include <iterator>
#include <memory>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Packs one binding, in these steps:
///
///   1. `choose_all_rows` sorts the points spatially and chooses for each block the handles that get a row:
///      by number and size of weights (`rows_by_size`), then by distance (`RowChooser`), which finds the
///      number of rows for each storage format.
///   2. `choose_format` chooses the smallest format that meets the tolerance.
///   3. `fill_block` fits the weights of the chosen rows, restores row sums, rounds and stores, and measures
///      the error and distance of every point.
///
/// Without limits there is no order and no list of rows: every block has a row for every handle.
template <Scalar T, std::size_t D>
class Packer {
public:
    Packer(const BindingView<T, D>& binding, const PackOptions& options, const Running& running,
           std::span<const char> on_seam)
        : binding_(binding)
        , options_(options)
        , running_(running)
        , handles_(binding.handle_count())
        , points_(binding.point_count())
        , blocks_(block_count<T>(points_))
        , sparse_((options.largest != 0 && options.largest < handles_) || options.threshold > 0)
        , moments_(binding.handle_view())
        , on_seam_(on_seam.begin(), on_seam.end())
        , format_(options.format.value_or(WeightFormat::scalar)) {}

    Status run(PackedBinding<T, D>& packed, PackReport& report) {
        Status status = check_input(report);
        if (status != Status::ok) return status;
        report.poses = loss_.poses();
        report.reach = loss_.reach();
        report.size = size_of_points();
        pieces_.resize(blocks_);
        if (has_order()) {
            if (status = choose_all_rows(report); status != Status::ok) return status;
        }
        if (status = count_rows(); status != Status::ok) return status;
        PackedBinding<T, D> result(header());
        fill_tables(result);
        report.errors.resize(points_);
        report.distances.resize(points_);
        status = for_each_block(blocks_, running_.subtask(has_order() ? 0.7 : 0, 1),
                                [&](std::size_t begin, std::size_t end) {
                                    for (std::size_t b = begin; b < end; ++b) fill_block(b, result, report);
                                });
        if (status != Status::ok) return status;
        result.seal();
        summarise(result, report);
        if (keeps_distance() && report.distance.value > options_.tolerance)
            return too_coarse(report, report.distance);
        packed = std::move(result);
        return Status::ok;
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    using Column = typename Moments<D>::Column;

    struct Piece {
        std::vector<std::uint32_t> handles; ///< of the rows; ascending unless there is a tolerance
        std::vector<RowTrial> trials;       ///< with a tolerance: the number of rows per format
        std::size_t added = 0;
        Extreme change, distance;
        std::size_t pose = Extreme::none;
    };

    bool keeps_distance() const { return options_.tolerance > 0; }
    bool has_order() const { return sparse_ || keeps_distance(); }

    Status check_input(PackReport& report) {
        if (options_.largest != 0 && options_.largest < D + 1) return Status::too_few_weights;
        if (has_order() && handles_ > 0xFFFFu) return Status::too_many_handles;
        if (points_ > 0xFFFFFFFFu || handles_ > 0xFFFFFFFFu) return Status::too_many_handles;
        for (std::size_t i = 0; i < points_; ++i) {
            for (std::size_t h = 0; h < handles_; ++h) {
                if (is_finite(binding_.weights(i, h))) continue;
                report.culprit = i;
                return Status::weight_not_finite;
            }
        }
        return loss_.load(binding_.handle_view(), options_, report.culprit);
    }

    /// Chooses the order of the points and the rows of every block.
    Status choose_all_rows(PackReport& report) {
        order_ = options_.order.empty() ? spatial_order<T, D>(binding_.rest)
                                        : std::vector(options_.order.begin(), options_.order.end());
        if (!detail::is_permutation(order_, points_)) return Status::order_not_a_permutation;
        if (on_seam_.empty() && !keeps_distance())
            on_seam_ =
                seam_points<T>(order_, [this](std::uint32_t a, std::uint32_t b) { return is_less(a, b); });
        if (keeps_distance()) square_loss_ = std::make_unique<const SquareLoss<D>>(moments_, loss_);
        Status status =
            for_each_block(blocks_, running_.subtask(0, 0.7), [this](std::size_t begin, std::size_t end) {
                for (std::size_t b = begin; b < end; ++b) choose_rows(b);
            });
        if (status == Status::ok && keeps_distance()) status = choose_format(report);
        if (status == Status::ok && options_.order.empty()) sort_blocks();
        return status;
    }

    /// Orders points by position, then by weights.
    bool is_less(std::uint32_t a, std::uint32_t b) const {
        if (const int order = compare_positions<D>(binding_.rest, a, b); order != 0) return order < 0;
        for (std::size_t h = 0; h < handles_; ++h) {
            const T x = binding_.weights(a, h), y = binding_.weights(b, h);
            if (x != y) return x < y;
        }
        return false;
    }

    /// Calls f(lane, rows, change) for each seam point of a block. `rows` are those of the point if it were
    /// alone in a block, with restored sums; `change` is the largest change of a weight by restoring.
    template <class F>
    void for_each_seam_lane(const BlockPoints<T>& points, const F& f) const {
        for (std::size_t lane = 0; lane < points.count && !on_seam_.empty(); ++lane) {
            if (on_seam_[points.index[lane]] == 0) continue;
            const BlockPoints<T> alone{{points.index[lane]}, 1};
            PackedRows rows =
                packer_.rows_of(alone, rows_by_size(binding_, moments_, alone, options_).handles);
            const Extreme change = packer_.restore(alone, rows);
            f(lane, rows, change);
        }
    }

    void choose_rows(std::size_t block) {
        Piece& piece = pieces_[block];
        const BlockPoints<T> points = points_of(block);
        if (sparse_) {
            RowsBySize rows = rows_by_size(binding_, moments_, points, options_);
            piece.handles = std::move(rows.handles);
            piece.added = rows.added;
            for_each_seam_lane(points, [&piece](std::size_t, const PackedRows& own, const Extreme&) {
                std::vector<std::uint32_t> both;
                std::set_union(piece.handles.begin(), piece.handles.end(), own.handles.begin(),
                               own.handles.end(), std::back_inserter(both));
                piece.handles = std::move(both);
            });
        }
        if (!keeps_distance()) return;
        for (const WeightFormat format :
             {WeightFormat::int8, WeightFormat::int16, WeightFormat::half, WeightFormat::scalar}) {
            if (!options_.format || *options_.format == format) piece.trials.emplace_back(format);
        }
        RowChooser<T, D> chooser(packer_, *square_loss_, points, piece.handles);
        chooser.run(piece.trials, options_.tolerance);
        piece.handles.assign(chooser.order().begin(), chooser.order().end());
    }

    /// Chooses the smallest format in which every block meets the tolerance.
    Status choose_format(PackReport& report) {
        std::optional<std::size_t> best;
        std::size_t least_bytes = 0;
        Extreme reachable;
        for (std::size_t t = 0; t < (blocks_ > 0 ? pieces_[0].trials.size() : 0); ++t) {
            const WeightFormat format = pieces_[0].trials[t].format;
            std::size_t rows = 0;
            bool all = true;
            for (const Piece& piece : pieces_) {
                const RowTrial& trial = piece.trials[t];
                all = all && trial.is_met();
                rows += trial.is_met() ? trial.count : 0;
                if (!trial.is_met()) reachable.raise(trial.distance);
            }
            const std::size_t bytes = bytes_of(format, rows);
            if (!all || (best && bytes >= least_bytes)) continue;
            best = t;
            least_bytes = bytes;
        }
        if (blocks_ == 0) return Status::ok;
        if (!best) return too_coarse(report, reachable);
        format_ = pieces_[0].trials[*best].format;
        for (Piece& piece : pieces_) piece.handles.resize(piece.trials[*best].count);
        return Status::ok;
    }

    /// Returns the size of those arrays of a blob that depend on format and rows.
    std::size_t bytes_of(WeightFormat format, std::size_t rows) const {
        BlobHeader header;
        header.format = std::uint32_t(format);
        header.handles = handles_;
        header.points = points_;
        header.rows = rows;
        header.row_begin = 1;
        std::size_t sum = 0;
        for_each_blob_array<T, D>(header, [&sum](std::uint64_t, std::uint64_t bytes, bool wanted) {
            if (wanted) sum += std::size_t(whole_lines(bytes));
        });
        return sum;
    }

    static Status too_coarse(PackReport& report, const Extreme& distance) {
        report.distance = distance;
        report.culprit = distance.point;
        return Status::format_too_coarse;
    }

    Status count_rows() {
        row_begin_.assign(1, 0);
        for (const Piece& piece : pieces_) {
            rows_ += has_order() ? piece.handles.size() : handles_;
            if (has_order() && rows_ > 0xFFFFFFFFu) return Status::too_many_handles;
            row_begin_.push_back(static_cast<std::uint32_t>(rows_));
        }
        return Status::ok;
    }

    BlobHeader header() const {
        BlobHeader header;
        header.format = std::uint32_t(format_);
        header.handles = handles_;
        header.points = points_;
        header.rows = rows_;
        header.row_begin = header.order = has_order() ? 1 : 0;
        header.handle_kinds = binding_.handle_kinds != nullptr ? 1 : 0;
        header.handle_faces = binding_.handle_faces != nullptr ? 1 : 0;
        header.vectors = binding_.handle_view().vector_count();
        header.handle_loops = binding_.handle_loops != nullptr ? 1 : 0;
        header.loop_numbers = std::uint32_t(binding_.handle_view().loop_numbers());
        header.cage_hash = options_.cage_hash;
        header.figure_hash = options_.figure_hash;
        if (header.cage_hash == 0)
            header.cage_hash = hash_memory(std::span<const Vec<T, D>>(binding_.rest_handles, handles_));
        if (header.figure_hash == 0) {
            std::vector<Vec<T, D>> at_rest(points_);
            for (std::size_t i = 0; i < points_; ++i) at_rest[i] = block_point<D>(binding_.rest, i);
            header.figure_hash = hash_memory(std::span<const Vec<T, D>>(at_rest));
        }
        return header;
    }

    void summarise(const PackedBinding<T, D>& packed, PackReport& report) const {
        for (const Piece& piece : pieces_) {
            report.weight_change.raise(piece.change);
            report.rows_added += piece.added;
            const Extreme before = report.distance;
            report.distance.raise(piece.distance);
            if (report.distance.point != before.point) report.distance_pose = piece.pose;
        }
        for (std::size_t i = 0; i < points_; ++i) {
            report.error.raise({double(report.errors[i]), i});
            report.mean_error += double(report.errors[i]) / double(points_);
            report.mean_distance += double(report.distances[i]) / double(points_);
        }
        report.format = format_;
        report.rows = std::size_t(rows_);
        report.weights_per_point = points_ > 0 ? double(rows_) / double(blocks_) : 0;
        report.bytes = packed.bytes().size();
        report.dense_bytes = blocks_ * (handles_ + D) * sizeof(Lanes<T>) + handles_ * sizeof(Vec<T, D>);
    }

    /// Returns the diagonal of the bounds of the finite points at rest.
    double size_of_points() const {
        std::vector<Vec<double, D>> at_rest;
        for (std::size_t i = 0; i < points_; ++i) {
            const auto p = vec_cast<double>(block_point<D>(binding_.rest, i));
            if (is_finite(p)) at_rest.push_back(p);
        }
        return at_rest.empty() ? 0 : bounds_of(std::span<const Vec<double, D>>(at_rest)).diagonal();
    }

    std::size_t used(std::size_t block) const { return (std::min)(lanes, points_ - block * lanes); }
    std::size_t point(std::size_t block, std::size_t lane) const {
        return has_order() ? order_[block * lanes + lane] : block * lanes + lane;
    }
    BlockPoints<T> points_of(std::size_t block) const {
        BlockPoints<T> points;
        points.count = used(block);
        for (std::size_t lane = 0; lane < points.count; ++lane) points.index[lane] = point(block, lane);
        return points;
    }

    /// Sorts blocks by their number of rows. Otherwise the processor would mispredict the end of the
    /// row loop in each block. An incomplete last block stays last.
    void sort_blocks() {
        auto sequence = first_indices<std::uint32_t>(points_ / lanes);
        std::sort(sequence.begin(), sequence.end(), [this](std::uint32_t a, std::uint32_t b) {
            const std::size_t rows_a = pieces_[a].handles.size(), rows_b = pieces_[b].handles.size();
            return rows_a != rows_b ? rows_a < rows_b : a < b;
        });
        std::vector<std::uint32_t> order(order_);
        std::vector<Piece> pieces(blocks_);
        for (std::size_t b = 0; b < sequence.size(); ++b) {
            std::copy_n(order_.begin() + std::ptrdiff_t(sequence[b] * lanes), lanes,
                        order.begin() + std::ptrdiff_t(b * lanes));
            pieces[b] = std::move(pieces_[sequence[b]]);
        }
        if (sequence.size() < blocks_) pieces.back() = std::move(pieces_.back());
        order_ = std::move(order);
        pieces_ = std::move(pieces);
    }

    void fill_tables(PackedBinding<T, D>& blob) const {
        const auto out = blob.view();
        if (has_order()) {
            std::copy(row_begin_.begin(), row_begin_.end(), blob.writable(out.row_begin));
            auto* to = blob.writable(out.row_handle);
            for (const Piece& piece : pieces_) {
                std::vector<std::uint32_t> handles(piece.handles);
                std::sort(handles.begin(), handles.end());
                for (const std::uint32_t h : handles) *to++ = static_cast<std::uint16_t>(h);
            }
            std::copy(order_.begin(), order_.end(), blob.writable(out.order));
        }
        std::copy_n(binding_.rest_handles, handles_, blob.writable(out.rest_handles));
        if (out.handle_kinds != nullptr)
            std::copy_n(binding_.handle_kinds, handles_, blob.writable(out.handle_kinds));
        if (out.handle_faces != nullptr)
            std::copy_n(binding_.handle_faces, binding_.handle_view().vector_count(),
                        blob.writable(out.handle_faces));
        if (out.handle_loops != nullptr)
            std::copy_n(binding_.handle_loops, binding_.handle_view().loop_numbers(),
                        blob.writable(out.handle_loops));
        for (std::size_t h = 0; out.affine_fit != nullptr && h < handles_; ++h) {
            const Column fit = moments_.fit(h);
            for (std::size_t r = 0; r <= D; ++r) blob.writable(out.affine_fit)[h][r] = static_cast<T>(fit[r]);
        }
    }

    /// Returns the rows of a block, with restored row sums.
    PackedRows rows_of(std::size_t block, const BlockPoints<T>& points) {
        Piece& piece = pieces_[block];
        if (!has_order()) return packer_.rows_of(points, first_indices<std::uint32_t>(handles_));
        PackedRows rows;
        if (keeps_distance()) { // as they were tested
            rows = RowChooser<T, D>(packer_, *square_loss_, points, piece.handles).rows(piece.handles.size());
        } else {
            rows = packer_.rows_of(points, piece.handles);
        }
        piece.change = packer_.restore(points, rows);
        for_each_seam_lane(points, [&](std::size_t lane, const PackedRows& own, const Extreme& change) {
            piece.change.raise(change);
            for (std::size_t r = 0, k = 0; r < rows.handles.size(); ++r) {
                const bool is_own = k < own.handles.size() && own.handles[k] == rows.handles[r];
                rows.weights[r * lanes + lane] = is_own ? own.weights[k++ * lanes] : 0;
            }
        });
        return rows;
    }

    void fill_block(std::size_t block, PackedBinding<T, D>& blob, PackReport& report) {
        const auto out = blob.view();
        const BlockPoints<T> points = points_of(block);
        Lanes<T>* const rest = blob.writable(out.rest) + block * D;
        for (std::size_t lane = 0; lane < lanes; ++lane) { // filled with copies of the last point
            const std::size_t i = points.index[(std::min)(lane, points.count - 1)];
            for (std::size_t k = 0; k < D; ++k) rest[k][lane] = binding_.rest(i, k);
        }
        PackedRows rows = rows_of(block, points);
        std::byte* const to =
            blob.writable(out.weights) + out.first_row(block) * lanes * weight_bytes<T>(format_);
        const T scale = store_weights<T>(format_, rows.weights, to);
        if (out.scale != nullptr) blob.writable(out.scale)[block] = scale;
        const auto residuals = packer_.residuals(format_, points, rows);
        for (std::size_t lane = 0; lane < residuals.size(); ++lane) {
            for (std::size_t k = 0; k <= D; ++k)
                blob.writable(out.residual)[block * (D + 1) + k][lane] = static_cast<T>(residuals[lane][k]);
        }
        measure(pieces_[block], points, packer_.change(points, rows, residuals), report);
    }

    /// Measures the effect of changed weights on each point of a block.
    void measure(Piece& piece, const BlockPoints<T>& points, std::span<const double> change,
                 PackReport& report) const {
        const auto distances = loss_.template distances<lanes>(change);
        for (std::size_t lane = 0; lane < points.count; ++lane) {
            const std::size_t i = points.index[lane];
            double error = 0;
            for (std::size_t h = 0; h < handles_; ++h) error += std::fabs(change[h * lanes + lane]);
            report.errors[i] = static_cast<float>(error);
            report.distances[i] = static_cast<float>(distances[lane].value);
            if (piece.distance.point == Extreme::none || distances[lane].value > piece.distance.value)
                piece.pose = distances[lane].pose;
            piece.distance.raise({distances[lane].value, i});
        }
    }

    const BindingView<T, D> binding_;
    const PackOptions& options_;
    const Running& running_;
    std::size_t handles_, points_, blocks_;
    bool sparse_; ///< weights are limited by number or size
    Moments<D> moments_;
    std::vector<char> on_seam_; ///< per point: see seam_points; empty if unused
    WeightLoss<D> loss_;
    BlockPacker<T, D> packer_{binding_, moments_, loss_};
    std::unique_ptr<const SquareLoss<D>> square_loss_; ///< if there is a tolerance
    WeightFormat format_;
    std::vector<std::uint32_t> order_, row_begin_;
    std::uint64_t rows_ = 0;
    std::vector<Piece> pieces_;
};

template <class T, std::size_t D>
Result<PackedBinding<T, D>, PackReport> pack_binding(const BindingView<T, D>& binding,
                                                     const PackOptions& options, const Running& running,
                                                     std::span<const char> on_seam) {
    Result<PackedBinding<T, D>, PackReport> result;
    result.report.points = binding.point_count();
    result.report.handles = binding.handle_count();
    run_into(result.report, [&] {
        return Packer<T, D>(binding, options, running, on_seam).run(result.value, result.report);
    });
    return result;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
