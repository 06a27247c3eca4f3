// Binds and packs points in batches, without holding all #points × #handles weights.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/falloff.hpp>
#include <cageform/binding/detail/packers.hpp>
#include <cageform/binding/detail/spatial_order.hpp>
#include <cageform/cage/detail/indices.hpp>
#include <cageform/figure/types/blob.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Binds and packs the points in the order of the packed binding, in batches of whole blocks.
template <Scalar T, std::size_t D>
class PackedBinder {
    static constexpr std::size_t lanes = lane_count<T>;

public:
    PackedBinder(std::vector<Vec<T, D>> points, const StreamedPackOptions& options, std::size_t handles)
        : points_(std::move(points))
        , options_(options)
        , sparse_((options.pack.largest != 0 && options.pack.largest < handles) ||
                  options.pack.threshold > 0 || options.pack.tolerance > 0)
        , batch_size_(points_of_batch(options, handles)) {}

    static std::size_t points_of_batch(const StreamedPackOptions& options, std::size_t handles) noexcept {
        const std::size_t of_block = sizeof(Lanes<T>) * (handles + D);
        return lanes * std::max<std::size_t>(options.batch / of_block, 1);
    }
    std::size_t batches() const noexcept { return (points_.size() + batch_size_ - 1) / batch_size_; }

    /// Binds and packs all points as one batch.
    template <class C>
    Status run_at_once(const C& coordinates, const Running& running,
                       Result<PackedBinding<T, D>, StreamedPackReport>& result) const {
        auto bound = bind(coordinates, points_, options_.bind, running.subtask(0, 0.5));
        result.report.bound = std::move(bound.report);
        if (result.report.bound.status != Status::ok) return result.report.bound.status;
        auto packed = pack_binding(bound.value.view(), pack_options(), running.subtask(0.5, 1), {});
        result.report.packed = std::move(packed.report);
        result.value = std::move(packed.value);
        return result.report.packed.status;
    }

    /// Binds and packs batch by batch; stops at the first failure.
    template <class C>
    Status run(const C& coordinates, const Running& running,
               Result<PackedBinding<T, D>, StreamedPackReport>& result) {
        Status status = result.report.packed.status = set_order();
        if (status != Status::ok) return status;
        status = result.report.bound.status = check_falloff(options_.bind, C::has_extension);
        if (status != Status::ok) return status;
        {
            C solved = coordinates; // destroyed before the batches are joined
            double from = 0;
            if constexpr (requires { solved.solve(running); }) {
                from = 0.5;
                const auto evaluation = solved.solve(running.subtask(0, from));
                result.report.bound.solver = evaluation.solver;
                status = result.report.bound.status = evaluation.status;
            }
            if (status == Status::ok) status = run_batches(solved, running.subtask(from, 1), result);
        }
        if (status != Status::ok) return status;
        std::uint64_t rows = 0;
        for (const auto& batch : batches_) rows += batch.view().row_count();
        if (sparse_ && rows > 0xFFFFFFFFu) return result.report.packed.status = Status::too_many_handles;
        join(rows, result);
        return status;
    }

private:
    template <class C>
    Status run_batches(const C& coordinates, const Running& running,
                       Result<PackedBinding<T, D>, StreamedPackReport>& result) {
        result.report.packed.errors.resize(points_.size());
        result.report.packed.distances.resize(points_.size());
        auto pack = pack_options();
        if (pack.figure_hash == 0) pack.figure_hash = hash_memory(std::span<const Vec<T, D>>(points_));
        const auto at = [this](std::size_t i, std::size_t k) { return points_[i][k]; };
        std::vector<char> on_seam; // of all points, since a batch does not contain the others
        if (sparse_ && options_.pack.tolerance == 0)
            on_seam = seam_points<T>(order_, [&at](std::uint32_t a, std::uint32_t b) {
                return compare_positions<D>(at, a, b) < 0;
            });
        Binding<T, D> recycled;
        for (std::size_t n = 0; n < batches(); ++n) {
            const std::size_t first = n * batch_size_,
                              count = (std::min)(batch_size_, points_.size() - first);
            const Running in_batch =
                running.subtask(double(n) / double(batches()), double(n + 1) / double(batches()));
            std::vector<Vec<T, D>> batch;
            for (std::size_t k = 0; k < count; ++k) batch.push_back(points_[order_[first + k]]);
            auto bound =
                bind(coordinates, batch, options_.bind, std::move(recycled), in_batch.subtask(0, 0.5));
            add(bound.report, first, result.report.bound);
            if (bound.report.status != Status::ok) return result.report.bound.status = bound.report.status;
            auto identity = first_indices<std::uint32_t>(sparse_ ? count : 0);
            pack.order = identity;
            std::vector<char> of_batch;
            for (std::size_t k = 0; k < count && !on_seam.empty(); ++k)
                of_batch.push_back(on_seam[order_[first + k]]);
            auto packed = pack_binding(bound.value.view(), pack, in_batch.subtask(0.5, 1), of_batch);
            add(packed.report, first, result.report.packed);
            if (packed.report.status != Status::ok) return result.report.packed.status = packed.report.status;
            batches_.push_back(std::move(packed.value));
            recycled = std::move(bound.value);
        }
        return Status::ok;
    }
    PackOptions pack_options() const {
        auto pack = options_.pack;
        if (!pack.format) pack.format = WeightFormat::scalar;
        return pack;
    }

    /// Joins the packed batches into one blob, in the order of `pack`, and frees them.
    void join(std::uint64_t rows, Result<PackedBinding<T, D>, StreamedPackReport>& result) {
        order_blocks();
        BlobHeader header = header_of(batches_[0]);
        header.points = points_.size();
        header.rows = rows;
        PackedBinding<T, D> joined(header);
        copy_handles(joined);
        std::size_t row = 0;
        for (std::size_t b = 0; b < sequence_.size(); ++b) row = copy_block(sequence_[b], b, row, joined);
        batches_.clear();
        joined.seal();
        summarise(joined, result);
        result.value = std::move(joined);
    }

    Status set_order() {
        const auto& given = options_.pack.order;
        if (!sparse_ || given.empty()) {
            std::vector<Lanes<T>> rest(block_count<T>(points_.size()) * D);
            for (std::size_t i = 0; i < points_.size(); ++i) {
                for (std::size_t k = 0; k < D; ++k) rest[i / lanes * D + k][i % lanes] = points_[i][k];
            }
            order_ = spatial_order<T, D>({rest.data(), D, points_.size()});
            if (!sparse_) std::sort(order_.begin(), order_.end());
            return Status::ok;
        }
        order_.assign(given.begin(), given.end());
        const bool valid = detail::is_permutation(order_, points_.size());
        return valid ? Status::ok : Status::order_not_a_permutation;
    }

    // ---- reports ------------------------------------------------------------------------------------

    /// Converts the index of the point in a batch that begins at `first` to its index among all points.
    Extreme with_global_point(Extreme extreme, std::size_t first) const noexcept {
        if (extreme.point != Extreme::none) extreme.point = order_[first + extreme.point];
        return extreme;
    }
    void add(const BindReport& batch, std::size_t first, BindReport& all) const {
        if (first == 0) all.cage = batch.cage;
        const std::pair<const std::vector<std::size_t>&, std::vector<std::size_t>&> lists[] = {
            {batch.on_boundary, all.on_boundary},
            {batch.outside, all.outside},
            {batch.faded, all.faded},
            {batch.not_finite, all.not_finite},
            {batch.unreached, all.unreached},
            {batch.not_restored, all.not_restored}};
        for (const auto& [from, to] : lists) {
            for (const std::size_t i : from) to.push_back(order_[first + i]);
        }
        all.partition_error.raise(with_global_point(batch.partition_error, first));
        all.reproduction_error.raise(with_global_point(batch.reproduction_error, first));
        all.weight_change.raise(with_global_point(batch.weight_change, first));
        all.residual_restored.raise(with_global_point(batch.residual_restored, first));
        all.least_weight.lower(with_global_point(batch.least_weight, first));
        all.amplification.raise(with_global_point(batch.amplification, first));
    }
    void add(const PackReport& batch, std::size_t first, PackReport& all) const {
        for (std::size_t k = 0; k < batch.errors.size(); ++k) {
            all.errors[order_[first + k]] = batch.errors[k];
            all.distances[order_[first + k]] = batch.distances[k];
        }
        if (batch.distance.point != Extreme::none &&
            (all.distance.point == Extreme::none || batch.distance.value > all.distance.value))
            all.distance_pose = batch.distance_pose;
        all.distance.raise(with_global_point(batch.distance, first));
        all.weight_change.raise(with_global_point(batch.weight_change, first));
        all.rows_added += batch.rows_added;
        all.format = batch.format;
        all.poses = batch.poses;
        all.reach = batch.reach;
        const bool names_point =
            batch.status == Status::weight_not_finite || batch.status == Status::format_too_coarse;
        all.culprit = names_point ? order_[first + batch.culprit] : batch.culprit;
    }
    void summarise(const PackedBinding<T, D>& blob,
                   Result<PackedBinding<T, D>, StreamedPackReport>& result) const {
        BindReport& bound = result.report.bound;
        for (auto* list : {&bound.on_boundary, &bound.outside, &bound.faded, &bound.not_finite,
                           &bound.unreached, &bound.not_restored})
            std::sort(list->begin(), list->end());
        PackReport& packed = result.report.packed;
        std::vector<Vec<double, D>> finite;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            packed.error.raise({double(packed.errors[i]), i});
            packed.mean_error += double(packed.errors[i]) / double(points_.size());
            packed.mean_distance += double(packed.distances[i]) / double(points_.size());
            if (is_finite(points_[i])) finite.push_back(vec_cast<double>(points_[i]));
        }
        if (!finite.empty()) packed.size = bounds_of(std::span<const Vec<double, D>>(finite)).diagonal();
        const auto view = blob.view();
        packed.rows = view.row_count();
        packed.weights_per_point = double(packed.rows) / double(view.block_count());
        packed.bytes = blob.bytes().size();
        packed.dense_bytes =
            view.block_count() * (view.handles + D) * sizeof(Lanes<T>) + view.handles * sizeof(Vec<T, D>);
    }

    // ---- blocks -------------------------------------------------------------------------------------

    struct BlockSource {
        std::size_t batch, block;
        std::size_t first; ///< position of its points in order_
    };
    static BlobHeader header_of(const PackedBinding<T, D>& batch) noexcept {
        BlobHeader header;
        std::memcpy(&header, batch.bytes().data(), sizeof(header));
        return header;
    }
    std::size_t rows_of(const BlockSource& source) const noexcept {
        const auto view = batches_[source.batch].view();
        return view.first_row(source.block + 1) - view.first_row(source.block);
    }
    /// Lists the blocks of all batches in the order of `pack`: by number of rows.
    void order_blocks() {
        for (std::size_t batch = 0; batch < batches_.size(); ++batch) {
            for (std::size_t b = 0; b < batches_[batch].view().block_count(); ++b)
                sequence_.push_back({batch, b, batch * batch_size_ + b * lanes});
        }
        if (!sparse_ || !options_.pack.order.empty()) return;
        const auto full = sequence_.begin() + std::ptrdiff_t(points_.size() / lanes);
        std::stable_sort(sequence_.begin(), full, [this](const BlockSource& a, const BlockSource& b) {
            return rows_of(a) < rows_of(b);
        });
    }
    void copy_handles(PackedBinding<T, D>& joined) const {
        const auto from = batches_[0].view(), to = joined.view();
        const auto copy = [&](const auto* source, const auto* target, std::size_t count) {
            if (source != nullptr) std::copy_n(source, count, joined.writable(target));
        };
        copy(from.rest_handles, to.rest_handles, from.handles);
        copy(from.affine_fit, to.affine_fit, from.handles);
        copy(from.handle_kinds, to.handle_kinds, from.handles);
        copy(from.handle_faces, to.handle_faces, from.handle_view().vector_count());
        copy(from.handle_loops, to.handle_loops, from.handle_view().loop_numbers());
    }
    /// Copies a block to position `b`, and its rows to rows from `row` on. Returns the end of its rows.
    std::size_t copy_block(const BlockSource& source, std::size_t b, std::size_t row,
                           PackedBinding<T, D>& joined) const {
        const auto from = batches_[source.batch].view(), to = joined.view();
        const std::size_t first = from.first_row(source.block), rows = rows_of(source);
        const std::size_t bytes = lanes * weight_bytes<T>(from.format);
        std::memcpy(joined.writable(to.weights) + row * bytes, from.weights + first * bytes, rows * bytes);
        std::copy_n(from.rest + source.block * D, D, joined.writable(to.rest) + b * D);
        if (from.scale != nullptr) {
            joined.writable(to.scale)[b] = from.scale[source.block];
            std::copy_n(from.residual + source.block * (D + 1), D + 1,
                        joined.writable(to.residual) + b * (D + 1));
        }
        if (from.row_begin != nullptr) {
            std::copy_n(from.row_handle + first, rows, joined.writable(to.row_handle) + row);
            joined.writable(to.row_begin)[b + 1] = std::uint32_t(row + rows);
            const std::size_t count = (std::min)(lanes, points_.size() - source.first);
            std::copy_n(order_.begin() + std::ptrdiff_t(source.first), count,
                        joined.writable(to.order) + b * lanes);
        }
        return row + rows;
    }

    std::vector<Vec<T, D>> points_;
    const StreamedPackOptions& options_;
    bool sparse_;
    std::size_t batch_size_; ///< points in a batch
    std::vector<std::uint32_t> order_;
    std::vector<PackedBinding<T, D>> batches_;
    std::vector<BlockSource> sequence_; ///< the blocks in the order of the result
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
