// From a binding to what is shipped: weights dropped, rounded, put into an order that lets neighbours share rows.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/blob.hpp>

#include <Eigen/Eigenvalues>

#include <array>
#include <bit>
#include <numeric>

namespace cageform::inline CAGEFORM_ABI {

struct PackOptions {
    WeightFormat format = WeightFormat::scalar;
    std::size_t largest =
        0;                ///< weights that a point keeps at least, the largest ones; 0: all. At least D + 1.
    double threshold = 0; ///< smaller weights are dropped; affects no others
    /// Of sparse bindings: the point at each place, #points; by nearness where empty. For vectors give the order of the packed
    /// binding of their points (PackedBindingView::order): vectors tell nothing of who their neighbours are.
    std::span<const std::uint32_t> order{};
    std::uint64_t cage_hash = 0;   ///< kept in the blob; 0: `hash_memory` of the handles at rest
    std::uint64_t figure_hash = 0; ///< kept in the blob; 0: `hash_memory` of the points at rest, as Vec<T, D>
    ParallelFor parallel = SerialFor{};
    Progress progress{};
};

/// How packing went. The error of a point is Σ |w' − w| over all handles, w' the weights that clones by the packed binding
/// have in effect: no pose that moves handles by at most d moves a point by more than that times d beside where the binding
/// had it.
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

/// The affine rows of the handles, centred at the mean of the points and scaled so that their mean square is the identity:
/// what Σ wκ and Σ wH are taken with.
template <std::size_t D>
class Moments {
public:
    static constexpr int size = int(D) + 1;
    using Column = Eigen::Matrix<double, size, 1>;
    using Matrix = Eigen::Matrix<double, size, size>;

    template <Scalar T>
    explicit Moments(const HandleView<T, D>& handles)
        : columns_(handles.count) {
        AffineFrame<double, D> frame; // at the mean of the points
        const double points = double(handles.count - handles.vector_count());
        for (std::size_t i = 0; i < handles.count; ++i) {
            for (std::size_t k = 0; k < D && handles.is_point(i); ++k)
                frame.centre[k] += double(handles.rest[i][k]) / points;
        }
        const AffineRows<double, D> rows(handles, frame);
        Matrix square = Matrix::Zero();
        for (std::size_t i = 0; i < handles.count; ++i) {
            columns_[i] = rows.column(i);
            square += columns_[i] * columns_[i].transpose() / double(handles.count);
        }
        const Matrix whiten = power(square, -0.5);
        for (auto& a : columns_) a = whiten * a;
        inverse_of_all_ = power(sum_of_squares([](std::size_t) { return true; }), -1);
    }

    const Column& operator[](std::size_t handle) const { return columns_[handle]; }
    /// The best affine fit to values at all handles is Σ_i fit(i) · value_i, against these columns.
    Column fit(std::size_t handle) const { return inverse_of_all_ * columns_[handle]; }

    template <class Chosen>
    Matrix sum_of_squares(const Chosen& chosen) const {
        Matrix sum = Matrix::Zero();
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            if (chosen(i)) sum += columns_[i] * columns_[i].transpose();
        }
        return sum;
    }
    /// Of a symmetric matrix; directions without extent are left out.
    static Matrix power(const Matrix& m, double exponent) {
        const Eigen::SelfAdjointEigenSolver<Matrix> solver(m);
        Column values = solver.eigenvalues();
        const double least = values.maxCoeff() * 1e-12;
        for (double& x : values) x = x > least ? std::pow(x, exponent) : 0;
        return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
    }
    static double least_extent(const Matrix& m) {
        return Eigen::SelfAdjointEigenSolver<Matrix>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
    }

private:
    std::vector<Column> columns_;
    Matrix inverse_of_all_;
};

/// The nearest number of binary16, ties to even, subnormal ones flushed to zero; |x| below 65504.
inline std::uint16_t to_half(double x) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(x));
    const std::uint32_t sign = (bits >> 16) & 0x8000u, magnitude = bits & 0x7FFFFFFFu;
    if (magnitude < 0x38800000u) return static_cast<std::uint16_t>(sign);
    const std::uint32_t rounded = magnitude + 0x0FFFu + ((magnitude >> 13) & 1u);
    return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000u) >> 13));
}
inline double from_half(std::uint16_t half) noexcept {
    const std::uint32_t bits = ((half & 0x7FFFu) << 13) | (std::uint32_t(half & 0x8000u) << 16);
    return double(std::bit_cast<float>(bits)) * 0x1p112;
}

/// Puts points that lie near each other into the same block: the index of the point at each place. The whole is halved along
/// its longest side, at a multiple of a block, again and again. O(n log n).
template <Scalar T, std::size_t D>
std::vector<std::uint32_t> order_by_place(const BlockView<const T>& points) {
    std::vector<std::uint32_t> order(points.points);
    std::iota(order.begin(), order.end(), 0u);
    const auto coordinate = [&points](std::uint32_t i, std::size_t axis) {
        const T x = points(i, axis);
        return is_finite(x) ? x : T(0); // such a point is kept in place, wherever it lies
    };
    std::vector<std::array<std::size_t, 2>> parts{{0, order.size()}};
    while (!parts.empty()) {
        const auto [begin, end] = parts.back();
        parts.pop_back();
        const std::size_t blocks = block_count<T>(end - begin);
        if (blocks <= 1) continue;
        Vec<T, D> low{}, high{};
        for (std::size_t n = begin; n < end; ++n) {
            for (std::size_t k = 0; k < D; ++k) {
                const T x = coordinate(order[n], k);
                low[k] = n == begin ? x : std::min(low[k], x);
                high[k] = n == begin ? x : std::max(high[k], x);
            }
        }
        std::size_t axis = 0;
        for (std::size_t k = 1; k < D; ++k) {
            if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
        }
        const std::size_t middle = begin + blocks / 2 * lane_count<T>;
        const auto at = [&order](std::size_t n) { return order.begin() + std::ptrdiff_t(n); };
        std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
            const T x = coordinate(a, axis), y = coordinate(b, axis);
            return x != y ? x < y : a < b;
        });
        parts.push_back({begin, middle});
        parts.push_back({middle, end});
    }
    return order;
}

template <Scalar T, std::size_t D>
class Packer {
public:
    Packer(const BindingView<T, D>& binding, const PackOptions& options)
        : binding_(binding)
        , options_(options)
        , handles_(binding.handle_count())
        , points_(binding.point_count())
        , blocks_(block_count<T>(points_))
        , sparse_((options.largest != 0 && options.largest < handles_) || options.threshold > 0)
        , moments_(binding.handle_view()) {}

    Status run(PackedBinding<T, D>& packed, PackReport& report) {
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
        pieces_.resize(blocks_);
        report.errors.resize(points_);
        if (sparse_) {
            order_ = options_.order.empty() ? order_by_place<T, D>(binding_.rest)
                                            : std::vector(options_.order.begin(), options_.order.end());
            if (!is_permutation(order_)) return Status::order_not_a_permutation;
        }
        const Running half_way{options_.parallel, share_of_progress(0, 0.5)};
        Status status = for_each_block(blocks_, half_way, [this](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; sparse_ && b < end; ++b) choose_rows(b);
        });
        if (status != Status::ok) return status;

        if (sparse_ && options_.order.empty()) sort_blocks();
        row_begin_.assign(1, 0);
        std::uint64_t rows = 0;
        for (const Piece& piece : pieces_) {
            rows += sparse_ ? piece.handles.size() : handles_;
            if (sparse_ && rows > 0xFFFFFFFFu) return Status::too_many_handles;
            row_begin_.push_back(static_cast<std::uint32_t>(rows));
        }
        BlobHeader header;
        header.format = std::uint32_t(options_.format);
        header.handles = handles_;
        header.points = points_;
        header.rows = rows;
        header.row_begin = header.order = sparse_ ? 1 : 0;
        header.handle_kinds = binding_.handle_kinds != nullptr ? 1 : 0;
        header.handle_faces = binding_.handle_faces != nullptr ? 1 : 0;
        header.vectors = binding_.handle_view().vector_count();
        std::vector<Vec<T, D>> at_rest(points_);
        for (std::size_t i = 0; i < points_; ++i) at_rest[i] = block_point<D>(binding_.rest, i);
        const std::span<const Vec<T, D>> handles_at_rest(binding_.rest_handles, handles_);
        header.cage_hash = options_.cage_hash != 0 ? options_.cage_hash : hash_memory(handles_at_rest);
        header.figure_hash = options_.figure_hash != 0 ? options_.figure_hash
                                                       : hash_memory(std::span<const Vec<T, D>>(at_rest));
        PackedBinding<T, D> result(header);
        fill_tables(result);
        const Running rest_of_way{options_.parallel, share_of_progress(0.5, 1)};
        status = for_each_block(blocks_, rest_of_way, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) fill_block(b, result, report);
        });
        if (status != Status::ok) return status;
        result.seal();

        for (const Piece& piece : pieces_) {
            report.weight_change.raise(piece.change);
            report.rows_added += piece.added;
        }
        for (std::size_t i = 0; i < points_; ++i) {
            report.error.raise({double(report.errors[i]), i});
            report.mean_error += double(report.errors[i]) / double(points_);
        }
        report.rows = std::size_t(rows);
        report.weights_per_point =
            points_ > 0 ? double(rows) * double(lane_count<T>) / double(blocks_ * lane_count<T>) : 0;
        report.bytes = result.bytes().size();
        report.dense_bytes = blocks_ * (handles_ + D) * sizeof(Lanes<T>) + handles_ * sizeof(Vec<T, D>);
        packed = std::move(result);
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

    Progress share_of_progress(double from, double to) const {
        if (!options_.progress) return {};
        return [this, from, to](double done) { return options_.progress(from + (to - from) * done); };
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
        // Handles that lie nearly in one plane could restore what is missing across it by huge changes only.
        constexpr double enough = 0.05;
        Piece& piece = pieces_[block];
        const auto is_chosen = [&chosen](std::size_t h) { return chosen[h] != 0; };
        const bool all_are_needed =
            std::none_of(largest.begin(), largest.end(), [](double w) { return w > 0; });
        while (!all_are_needed && Moments<D>::least_extent(moments_.sum_of_squares(is_chosen)) < enough) {
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

    /// Puts blocks with the same number of rows beside each other, or a processor would guess wrong at the end of each. A last
    /// block that is not full stays last.
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
            for (std::size_t r = 0; r <= D; ++r)
                blob.writable(out.affine_fit)[h][r] = static_cast<T>(fit[Eigen::Index(r)]);
        }
    }

    void fill_block(std::size_t block, PackedBinding<T, D>& blob, PackReport& report) {
        const auto out = blob.view();
        Piece& piece = pieces_[block];
        const std::size_t first = out.first_row(block), rows = out.first_row(block + 1) - first;
        const auto handle = [&](std::size_t row) { return sparse_ ? std::size_t(piece.handles[row]) : row; };
        std::vector<double> kept(rows * lanes, 0.0);
        Lanes<T>* const rest = blob.writable(out.rest) + block * D;
        const Matrix inverse = sparse_ ? Moments<D>::power(moments_.sum_of_squares([&](std::size_t h) {
            return std::binary_search(piece.handles.begin(), piece.handles.end(), h);
        }),
                                                           -1)
                                       : Matrix::Zero();
        std::array<Column, lanes> wanted; // Σ w a of the binding
        for (std::size_t lane = 0; lane < used(block); ++lane) {
            const std::size_t i = point(block, lane);
            for (std::size_t k = 0; k < D; ++k) rest[k][lane] = binding_.rest(i, k);
            wanted[lane].setZero();
            for (std::size_t h = 0; h < handles_; ++h)
                wanted[lane] += double(binding_.weights(i, h)) * moments_[h];
            Column missing = wanted[lane];
            for (std::size_t r = 0; r < rows; ++r) {
                const double w = double(binding_.weights(i, handle(r)));
                kept[r * lanes + lane] = w;
                missing -= w * moments_[handle(r)];
            }
            if (!sparse_ || missing.cwiseAbs().maxCoeff() <= 4 * double(epsilon<T>)) continue;
            const Column step = inverse * missing;
            for (std::size_t r = 0; r < rows; ++r) {
                const double change = step.dot(moments_[handle(r)]);
                kept[r * lanes + lane] += change;
                piece.change.raise({std::fabs(change), i});
            }
        }
        for (std::size_t k = 0; k < D; ++k) { // copies of the last point fill the block
            for (std::size_t lane = used(block); lane < lanes; ++lane)
                rest[k][lane] = rest[k][used(block) - 1];
        }
        store(block, first, rows, kept, blob);

        // What was stored, and its residual.
        for (std::size_t lane = 0; lane < used(block); ++lane) {
            const std::size_t i = point(block, lane);
            Column residual = wanted[lane];
            for (std::size_t r = 0; r < rows; ++r) residual -= kept[r * lanes + lane] * moments_[handle(r)];
            for (std::size_t k = 0; out.residual != nullptr && k <= D; ++k)
                blob.writable(out.residual)[block * (D + 1) + k][lane] =
                    static_cast<T>(residual[Eigen::Index(k)]);
            double error = 0;
            for (std::size_t h = 0, r = 0; h < handles_; ++h) {
                double effective = 0;
                if (r < rows && handle(r) == h) effective = kept[r++ * lanes + lane];
                if (out.residual != nullptr) effective += residual.dot(moments_.fit(h));
                error += std::fabs(effective - double(binding_.weights(i, h)));
            }
            report.errors[i] = static_cast<float>(error);
        }
    }

    /// Writes the weights of a block in their format and puts into `kept` what they have become.
    void store(std::size_t block, std::size_t first, std::size_t rows, std::vector<double>& kept,
               PackedBinding<T, D>& blob) const {
        const auto out = blob.view();
        std::byte* place = blob.writable(out.weights) + first * lanes * weight_bytes<T>(options_.format);
        const auto write = [&place](auto x) {
            std::memcpy(place, &x, sizeof(x));
            place += sizeof(x);
        };
        if (options_.format == WeightFormat::scalar) {
            for (double& w : kept) {
                const T stored = static_cast<T>(w);
                write(stored);
                w = double(stored);
            }
            return;
        }
        double largest = 0;
        for (const double w : kept) largest = std::max(largest, std::fabs(w));
        // Halves are kept well away from the subnormal ones, which not every processor takes as they are.
        const double reach = options_.format == WeightFormat::int16  ? 32767.0
                             : options_.format == WeightFormat::int8 ? 127.0
                                                                     : 32768.0;
        const T scale = largest > 0 ? static_cast<T>(largest / reach) : T(1);
        blob.writable(out.scale)[block] = scale;
        for (std::size_t n = 0; n < rows * lanes; ++n) {
            const double q = std::clamp(kept[n] / double(scale), -reach, reach);
            if (options_.format == WeightFormat::half) {
                const auto half = to_half(q);
                write(half);
                kept[n] = double(scale) * from_half(half);
            } else {
                const double whole = std::nearbyint(q);
                if (options_.format == WeightFormat::int16) {
                    write(static_cast<std::int16_t>(whole));
                } else {
                    write(static_cast<std::int8_t>(whole));
                }
                kept[n] = double(scale) * whole;
            }
        }
    }

    const BindingView<T, D> binding_;
    const PackOptions& options_;
    std::size_t handles_, points_, blocks_;
    bool sparse_;
    Moments<D> moments_;
    std::vector<std::uint32_t> order_, row_begin_;
    std::vector<Piece> pieces_;
};

} // namespace detail

/// Packs a binding: drops weights, rounds them, and restores Σ w and Σ w c of every point, so that rest and affine poses stay
/// as exact as they were. Dropping is followed by the least change of the weights kept, in the sense of least squares; rounding
/// by D + 1 numbers a point that hold what is missing (binding/packed_binding.hpp). A point keeps its own largest weights and
/// those of other handles its block has a row for: they cost nothing.
///
///   binding  any binding, of points or vectors
///   returns  the packed binding and its report; fails with too_few_weights, too_many_handles (more than 65,535 in sparse
///            bindings), order_not_a_permutation, weight_not_finite (PackReport::culprit), cancelled, out_of_memory
///   cost     O(#points · #handles · D²)
template <Scalar T, std::size_t D>
PackResult<T, D> pack(const BindingView<T, D>& binding, const PackOptions& options = {}) {
    const auto start = std::chrono::steady_clock::now();
    PackResult<T, D> result;
    PackReport& report = result.report;
    report.points = binding.point_count();
    report.handles = binding.handle_count();
    report.status = detail::guard_memory(
        [&] { return detail::Packer<T, D>(binding, options).run(result.binding, report); });
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}
template <Scalar T, std::size_t D>
PackResult<T, D> pack(const Binding<T, D>& binding, const PackOptions& options = {}) {
    return pack(binding.view(), options);
}

} // namespace cageform::inline CAGEFORM_ABI
