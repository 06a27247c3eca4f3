// From a binding to what is shipped: weights dropped, rounded, put into an order that lets
// neighbours share rows.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/blob.hpp>
#include <cageform/binding/detail/moments.hpp>
#include <cageform/binding/detail/order_by_place.hpp>
#include <cageform/binding/detail/stored_weights.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct PackOptions {
    WeightFormat format = WeightFormat::scalar;
    std::size_t largest =
        0;                ///< weights that a point keeps at least, the largest ones; 0: all. At least D + 1.
    double threshold = 0; ///< smaller weights are dropped; affects no others
    /// Of sparse bindings: the point at each place, #points; by nearness where empty. For vectors
    /// give the order of the packed binding of their points (PackedBindingView::order): vectors
    /// tell nothing of who their neighbours are.
    std::span<const std::uint32_t> order{};
    std::uint64_t cage_hash = 0;   ///< kept in the blob; 0: `hash_memory` of the handles at rest
    std::uint64_t figure_hash = 0; ///< kept in the blob; 0: `hash_memory` of the points at rest, as Vec<T, D>
};

/// How packing went. The error of a point is Σ |w' − w| over all handles, w' the weights that
/// clones by the packed binding have in effect: no pose that moves handles by at most d moves a
/// point by more than that times d beside where the binding had it.
struct PackReport {
    Status status = Status::ok;
    std::size_t culprit = Extreme::none; ///< weight_not_finite: the point
    std::size_t points = 0, handles = 0;
    std::size_t rows = 0;         ///< rows of weights over all blocks
    double weights_per_point = 0; ///< stored, zeros included
    std::size_t bytes = 0;        ///< of the blob
    std::size_t dense_bytes = 0;  ///< of the binding
    std::vector<float> errors;    ///< #points
    Extreme error;                ///< the largest of them
    double mean_error = 0;
    Extreme weight_change; ///< the largest change of a kept weight by which Σ w and Σ w c are restored
    std::size_t rows_added =
        0; ///< beyond those asked for, because a block's handles would lie too nearly in one plane
    double seconds = 0;
};

template <Scalar T, std::size_t D>
struct PackResult {
    PackedBinding<T, D> binding; ///< empty unless the report's status is ok
    PackReport report;
};

namespace detail {

template <Scalar T, std::size_t D>
class Packer {
public:
    Packer(const BindingView<T, D>& binding, const PackOptions& options, const Running& running)
        : binding_(binding)
        , options_(options)
        , running_(running)
        , handles_(binding.handle_count())
        , points_(binding.point_count())
        , blocks_(block_count<T>(points_))
        , sparse_((options.largest != 0 && options.largest < handles_) || options.threshold > 0)
        , moments_(binding.handle_view()) {}

    Status run(PackedBinding<T, D>& packed, PackReport& report) {
        Status status = check_input(report);
        if (status != Status::ok) return status;
        pieces_.resize(blocks_);
        report.errors.resize(points_);
        if (sparse_) {
            status = choose_all_rows();
            if (status != Status::ok) return status;
        }
        status = count_rows();
        if (status != Status::ok) return status;
        PackedBinding<T, D> result(header());
        fill_tables(result);
        status = for_each_block(blocks_, running_.part(sparse_ ? 0.5 : 0, 1),
                                [&](std::size_t begin, std::size_t end) {
                                    for (std::size_t b = begin; b < end; ++b) fill_block(b, result, report);
                                });
        if (status != Status::ok) return status;
        result.seal();
        packed = std::move(result);
        summarise(packed, report);
        return Status::ok;
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    using Column = typename Moments<D>::Column;
    using Matrix = typename Moments<D>::Matrix;

    struct Piece {
        std::vector<std::uint16_t> handles; ///< of the rows, ascending
        std::size_t added = 0;
        Extreme change;
    };

    Status check_input(PackReport& report) const {
        if (options_.largest != 0 && options_.largest < D + 1) return Status::too_few_weights;
        if (sparse_ && handles_ > 0xFFFFu) return Status::too_many_handles;
        if (points_ > 0xFFFFFFFFu || handles_ > 0xFFFFFFFFu) return Status::too_many_handles;
        for (std::size_t i = 0; i < points_; ++i) {
            for (std::size_t h = 0; h < handles_; ++h) {
                if (is_finite(binding_.weights(i, h))) continue;
                report.culprit = i;
                return Status::weight_not_finite;
            }
        }
        return Status::ok;
    }

    /// The order of the points, and the rows of every block.
    Status choose_all_rows() {
        order_ = options_.order.empty() ? order_by_place<T, D>(binding_.rest)
                                        : std::vector(options_.order.begin(), options_.order.end());
        if (!is_permutation(order_)) return Status::order_not_a_permutation;
        const Status status =
            for_each_block(blocks_, running_.part(0, 0.5), [this](std::size_t begin, std::size_t end) {
                for (std::size_t b = begin; b < end; ++b) choose_rows(b);
            });
        if (status == Status::ok && options_.order.empty()) sort_blocks();
        return status;
    }

    Status count_rows() {
        row_begin_.assign(1, 0);
        for (const Piece& piece : pieces_) {
            rows_ += sparse_ ? piece.handles.size() : handles_;
            if (sparse_ && rows_ > 0xFFFFFFFFu) return Status::too_many_handles;
            row_begin_.push_back(static_cast<std::uint32_t>(rows_));
        }
        return Status::ok;
    }

    BlobHeader header() const {
        BlobHeader header;
        header.format = std::uint32_t(options_.format);
        header.handles = handles_;
        header.points = points_;
        header.rows = rows_;
        header.row_begin = header.order = sparse_ ? 1 : 0;
        header.handle_kinds = binding_.handle_kinds != nullptr ? 1 : 0;
        header.handle_faces = binding_.handle_faces != nullptr ? 1 : 0;
        header.vectors = binding_.handle_view().vector_count();
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
        }
        for (std::size_t i = 0; i < points_; ++i) {
            report.error.raise({double(report.errors[i]), i});
            report.mean_error += double(report.errors[i]) / double(points_);
        }
        report.rows = std::size_t(rows_);
        report.weights_per_point = points_ > 0 ? double(rows_) / double(blocks_) : 0;
        report.bytes = packed.bytes().size();
        report.dense_bytes = blocks_ * (handles_ + D) * sizeof(Lanes<T>) + handles_ * sizeof(Vec<T, D>);
    }

    std::size_t used(std::size_t block) const { return std::min(lanes, points_ - block * lanes); }
    std::size_t point(std::size_t block, std::size_t lane) const {
        return sparse_ ? order_[block * lanes + lane] : block * lanes + lane;
    }

    /// The handles that any point of a block wants, and more where those would not do.
    void choose_rows(std::size_t block) {
        std::vector<double> largest(handles_, 0.0); // of any point
        std::vector<char> chosen(handles_, 0);
        std::vector<std::size_t> ranked;
        for (std::size_t lane = 0; lane < used(block); ++lane) {
            const std::size_t i = point(block, lane);
            const auto size = [&](std::size_t h) { return std::fabs(double(binding_.weights(i, h))); };
            ranked.clear();
            for (std::size_t h = 0; h < handles_; ++h) {
                largest[h] = std::max(largest[h], size(h));
                if (size(h) > 0 && size(h) >= options_.threshold) ranked.push_back(h);
            }
            if (options_.largest != 0 && ranked.size() > options_.largest) {
                const auto last = ranked.begin() + std::ptrdiff_t(options_.largest);
                std::nth_element(ranked.begin(), last - 1, ranked.end(), [&](std::size_t a, std::size_t b) {
                    return size(a) != size(b) ? size(a) > size(b) : a < b;
                });
                ranked.erase(last, ranked.end());
            }
            for (const std::size_t h : ranked) chosen[h] = 1;
        }
        // Handles that lie nearly in one plane could restore what is missing across it by huge
        // changes only.
        constexpr double enough = 0.05;
        Piece& piece = pieces_[block];
        const auto is_chosen = [&chosen](std::size_t h) { return chosen[h] != 0; };
        const bool all_are_needed =
            std::none_of(largest.begin(), largest.end(), [](double w) { return w > 0; });
        while (!all_are_needed && principal_axes(moments_.sum_of_squares(is_chosen)).least() < enough) {
            std::size_t next = handles_;
            for (std::size_t h = 0; h < handles_; ++h) {
                if (!is_chosen(h) && largest[h] > 0 && (next == handles_ || largest[h] > largest[next]))
                    next = h;
            }
            if (next == handles_) break;
            chosen[next] = 1;
            ++piece.added;
        }
        for (std::size_t h = 0; h < handles_; ++h) {
            if (is_chosen(h)) piece.handles.push_back(static_cast<std::uint16_t>(h));
        }
    }

    bool is_permutation(const std::vector<std::uint32_t>& order) const {
        std::vector<char> there(points_, 0);
        for (const std::uint32_t i : order) {
            if (i >= points_ || there[i] != 0) return false;
            there[i] = 1;
        }
        return order.size() == points_;
    }

    /// Puts blocks with the same number of rows beside each other, or a processor would guess wrong
    /// at the end of each. A last block that is not full stays last.
    void sort_blocks() {
        std::vector<std::uint32_t> sequence(points_ / lanes);
        std::iota(sequence.begin(), sequence.end(), 0u);
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
        if (sparse_) {
            std::copy(row_begin_.begin(), row_begin_.end(), blob.writable(out.row_begin));
            auto* place = blob.writable(out.row_handle);
            for (const Piece& piece : pieces_)
                place = std::copy(piece.handles.begin(), piece.handles.end(), place);
            std::copy(order_.begin(), order_.end(), blob.writable(out.order));
        }
        std::copy_n(binding_.rest_handles, handles_, blob.writable(out.rest_handles));
        if (out.handle_kinds != nullptr)
            std::copy_n(binding_.handle_kinds, handles_, blob.writable(out.handle_kinds));
        if (out.handle_faces != nullptr)
            std::copy_n(binding_.handle_faces, binding_.handle_view().vector_count(),
                        blob.writable(out.handle_faces));
        for (std::size_t h = 0; out.affine_fit != nullptr && h < handles_; ++h) {
            const Column fit = moments_.fit(h);
            for (std::size_t r = 0; r <= D; ++r) blob.writable(out.affine_fit)[h][r] = static_cast<T>(fit[r]);
        }
    }

    /// Of a row of a block.
    std::size_t handle(std::size_t block, std::size_t row) const {
        return sparse_ ? std::size_t(pieces_[block].handles[row]) : row;
    }
    std::size_t row_count(std::size_t block) const {
        return sparse_ ? pieces_[block].handles.size() : handles_;
    }

    void fill_block(std::size_t block, PackedBinding<T, D>& blob, PackReport& report) {
        const auto out = blob.view();
        Lanes<T>* const rest = blob.writable(out.rest) + block * D;
        for (std::size_t lane = 0; lane < lanes; ++lane) { // copies of the last point fill the block
            const std::size_t i = point(block, std::min(lane, used(block) - 1));
            for (std::size_t k = 0; k < D; ++k) rest[k][lane] = binding_.rest(i, k);
        }
        std::vector<double> kept = kept_weights(block);
        std::byte* const place =
            blob.writable(out.weights) + out.first_row(block) * lanes * weight_bytes<T>(options_.format);
        const T scale = store_weights<T>(options_.format, kept, place);
        if (out.scale != nullptr) blob.writable(out.scale)[block] = scale;
        for (std::size_t lane = 0; lane < used(block); ++lane)
            report.errors[point(block, lane)] = store_residual(block, lane, kept, blob);
    }

    /// Σ w a of a point's weights in the binding.
    Column row_sums(std::size_t i) const {
        Column sum{};
        for (std::size_t h = 0; h < handles_; ++h) sum = sum + double(binding_.weights(i, h)) * moments_[h];
        return sum;
    }

    /// The weights of a block's rows, changed the least that restores the row sums of its points.
    std::vector<double> kept_weights(std::size_t block) {
        Piece& piece = pieces_[block];
        const std::size_t rows = row_count(block);
        std::vector<double> kept(rows * lanes, 0.0);
        const auto has_row = [&](std::size_t h) {
            return std::binary_search(piece.handles.begin(), piece.handles.end(), h);
        };
        const Matrix inverse = sparse_ ? Moments<D>::power(moments_.sum_of_squares(has_row), -1) : Matrix{};
        for (std::size_t lane = 0; lane < used(block); ++lane) {
            const std::size_t i = point(block, lane);
            for (std::size_t r = 0; r < rows; ++r)
                kept[r * lanes + lane] = double(binding_.weights(i, handle(block, r)));
            if (!sparse_) continue;
            Column missing = row_sums(i);
            for (std::size_t r = 0; r < rows; ++r)
                missing = missing - kept[r * lanes + lane] * moments_[handle(block, r)];
            const auto is_rounding = [](double x) { return std::fabs(x) <= 4 * double(epsilon<T>); };
            if (std::all_of(missing.v, missing.v + D + 1, is_rounding)) continue;
            const Column step = product(inverse, missing);
            for (std::size_t r = 0; r < rows; ++r) {
                const double change = dot(step, moments_[handle(block, r)]);
                kept[r * lanes + lane] += change;
                piece.change.raise({std::fabs(change), i});
            }
        }
        return kept;
    }

    /// What the weights `stored` leave of a point's row sums. Returns Σ |w' − w| of the weights
    /// then in effect.
    float store_residual(std::size_t block, std::size_t lane, std::span<const double> stored,
                         PackedBinding<T, D>& blob) const {
        const auto out = blob.view();
        const std::size_t i = point(block, lane), rows = row_count(block);
        Column residual{};
        if (out.residual != nullptr) {
            residual = row_sums(i);
            for (std::size_t r = 0; r < rows; ++r)
                residual = residual - stored[r * lanes + lane] * moments_[handle(block, r)];
            for (std::size_t k = 0; k <= D; ++k)
                blob.writable(out.residual)[block * (D + 1) + k][lane] = static_cast<T>(residual[k]);
        }
        double error = 0;
        for (std::size_t h = 0, r = 0; h < handles_; ++h) {
            double effective = 0;
            if (r < rows && handle(block, r) == h) effective = stored[r++ * lanes + lane];
            if (out.residual != nullptr) effective += dot(residual, moments_.fit(h));
            error += std::fabs(effective - double(binding_.weights(i, h)));
        }
        return static_cast<float>(error);
    }

    const BindingView<T, D> binding_;
    const PackOptions& options_;
    const Running& running_;
    std::size_t handles_, points_, blocks_;
    bool sparse_;
    Moments<D> moments_;
    std::vector<std::uint32_t> order_, row_begin_;
    std::uint64_t rows_ = 0;
    std::vector<Piece> pieces_;
};

} // namespace detail

/// Packs a binding: drops weights, rounds them, and restores Σ w and Σ w c of every point, so that
/// rest and affine poses stay as exact as they were. Dropping is followed by the least change of
/// the weights kept, in the sense of least squares; rounding by D + 1 numbers a point that hold
/// what is missing (binding/packed_binding.hpp). A point keeps its own largest weights and those of
/// other handles its block has a row for: they cost nothing.
///
///   binding  any binding, of points or vectors
///   returns  the packed binding and its report; fails with too_few_weights, too_many_handles (more
///            than 65,535 in sparse bindings), order_not_a_permutation, weight_not_finite
///            (PackReport::culprit), cancelled, out_of_memory
///   cost     O(#points · #handles · D²)
template <Scalar T, std::size_t D>
PackResult<T, D> pack(const BindingView<T, D>& binding, const PackOptions& options = {},
                      const Running& running = {}) {
    PackResult<T, D> result;
    result.report.points = binding.point_count();
    result.report.handles = binding.handle_count();
    detail::run_into(result.report, [&] {
        return detail::Packer<T, D>(binding, options, running).run(result.binding, result.report);
    });
    return result;
}
template <Scalar T, std::size_t D>
PackResult<T, D> pack(const Binding<T, D>& binding, const PackOptions& options = {},
                      const Running& running = {}) {
    return pack(binding.view(), options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
