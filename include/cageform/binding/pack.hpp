// Packs a binding or a figure for run time: drops small weights, rounds the others, and stores points
// so that neighbours share rows of weights. The loss is limited by number or size of weights, or by the
// distance of points.
#pragma once

#include <cageform/binding/detail/packers.hpp>
#include <cageform/binding/detail/streamed_packer.hpp>
#include <cageform/core/detail/stopwatch.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Packs a binding. Weights are dropped and rounded, but Σ w and Σ w c of every point (c are the
/// handles at rest) are preserved. Rest and affine poses are therefore as exact as before:
///
///   - Without a tolerance, the kept weights change by the smallest amount, in the least-squares sense,
///     that restores both sums. Where this change would make a non-negative row negative, the weights
///     become those of `project` (coordinates/project.hpp), if the kept handles with positive weights
///     surround the point. With a tolerance, all kept weights are refitted, see below.
///   - D + 1 numbers per point store the errors of the sums by rounding (figure/packed_binding.hpp). Scalar
///     weights need none.
///
/// Points are stored in blocks of one cache line (16 points of float, 8 of double). A block has a row
/// of weights for every handle that is kept for at least one of its points. A point therefore keeps its
/// own largest weights and those of the other rows of its block.
///
/// Points with equal positions and weights may lie in different blocks, on a seam. Such points do not
/// keep the weights of other rows of their blocks, so the seam stays closed. Quantised formats open a
/// seam by rounding errors, since each block has its own scale. A tolerance opens a seam by at most
/// twice the tolerance.
///
/// With PackOptions::tolerance, two measures apply. The square loss δᵀKδ of a change δ of a point's
/// weights ranks handles and fits weights: it is the mean squared displacement over the poses, with a
/// small share of other movements (greedy_row_selection.hpp). The distance is the stopping criterion:
/// it is the largest over the poses. Without poses, K treats all handles equally, and the distance is
/// an upper bound over all poses within PackOptions::reach.
///
///   1. Rank: in each block, the next row is always the one that lowers the square losses most; points
///      with large losses have more weight.
///   2. Refit: for a number of rows, the kept weights are those with the least δᵀKδ among all weights
///      with the exact sums Σ w and Σ w c.
///   3. Test: the weights are stored in each possible format and read back. The block gets the smallest
///      number of rows found for which all its points meet the tolerance.
///   4. Format: the whole binding gets the smallest format that meets the tolerance in every block.
///
/// The tolerance is not guaranteed in poses between the given ones and in other motion. Rounding errors
/// of `clone` add to the reported distance.
///
/// Code: binding/detail/packer.hpp packs block by block, choose_rows.hpp finds the number of rows of a
/// block, greedy_row_selection.hpp their order.
///
///   binding  any binding, of points or vectors
///   returns  the packed binding and its report; fails with too_few_weights, too_many_handles (more
///            than 65,535 in sparse bindings), order_not_a_permutation, weight_not_finite
///            (PackReport::culprit), value_not_finite (a tolerance or reach that is negative or not
///            finite), pose_size_differs, pose_not_finite (culprit), format_too_coarse
///            (PackReport::distance is then a tolerance that it can meet), cancelled, out_of_memory
///   cost     O(#points · #handles · (D² + #poses)); with a tolerance also O(#poses · #handles²), and
///            O(#points · #handles · rows) per block: 0.5 s for 8,000 points, 112 handles and 24 poses
///   memory   the result; with a tolerance over poses also #handles² numbers
template <Scalar T, std::size_t D>
Result<PackedBinding<T, D>, PackReport> pack(const BindingView<T, D>& binding,
                                             const PackOptions& options = {}, const Running& running = {}) {
    return detail::pack_binding(binding, options, running, {});
}
template <Scalar T, std::size_t D>
Result<PackedBinding<T, D>, PackReport> pack(const Binding<T, D>& binding, const PackOptions& options = {},
                                             const Running& running = {}) {
    return pack(binding.view(), options, running);
}

/// Packs a figure for `open`: its bindings as above, the tangents in the order of the points, its
/// labels, clips and levels, and custom parts.
///
///   returns  the packed figure and its report; fails as `pack`, with the part in FigurePackReport::culprit;
///            duplicate_tag, duplicate_name, too_many_parts; for a clip or level as `open_clip` and `open`,
///            and blob_of_another_cage; bindings_differ, vectors_do_not_match, labels_do_not_match, if parts
///            of the figure were replaced by parts with other points or handles
///   cost     that of `pack` for each binding, and a copy of all parts
template <Scalar T, std::size_t D>
Result<PackedFigure<T, D>, FigurePackReport>
pack(const FigureBinding<T, D>& figure, const FigurePackOptions& options = {}, const Running& running = {}) {
    Result<PackedFigure<T, D>, FigurePackReport> result;
    detail::run_into(result.report,
                     [&] { return detail::pack_parts<T, D>(figure, options, running, result); });
    return result;
}

/// Binds points and packs the result in batches, without holding all weights in memory. Bytes and reports
/// equal those of `bind`, then `pack`, except for times and PackReport::culprit after an error. A solver
/// solves once and keeps its functions during the call. Points that fit one batch are bound by `bind`.
///
///   points  any PointRange of the same dimension, converted to the scalar of the coordinates; copied
///   fails   as `bind` and `pack`; too_many_handles also if all blocks have more than 2³² rows
///   cost    that of `bind` and `pack`
///   memory  see pack_memory
template <CageCoordinates C, PointRangeIn<C::dimension> R>
Result<PackedBinding<typename C::scalar, C::dimension>, StreamedPackReport>
pack(const C& coordinates, const R& points, const StreamedPackOptions& options = {},
     const Running& running = {}) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    Result<PackedBinding<T, D>, StreamedPackReport> result;
    const double start = detail::seconds_now();
    const std::size_t count = std::size(points), handles = coordinates.handles().size();
    result.report.bound.points = result.report.packed.points = count;
    result.report.packed.handles = handles;
    const Status status = detail::guard_memory([&] {
        std::vector<Vec<T, D>> all;
        for (std::size_t i = 0; i < count; ++i) all.push_back(to_vec<T>(points[i]));
        detail::PackedBinder<T, D> binder(std::move(all), options, handles);
        return binder.batches() > 1 ? binder.run(coordinates, running, result)
                                    : binder.run_at_once(coordinates, running, result);
    });
    result.report.status = status;
    if (status != Status::ok && result.report.bound.status == Status::ok &&
        result.report.packed.status == Status::ok)
        result.report.packed.status = status;
    result.report.bound.seconds = result.report.packed.seconds = detail::seconds_now() - start;
    return result;
}

/// Returns the memory of a streamed `pack` in advance. For coordinates with a solver, this costs as
/// much as making the grid.
template <CageCoordinates C>
StreamedPackMemory pack_memory(const C& coordinates, std::size_t points,
                               const StreamedPackOptions& options = {}) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    const std::size_t handles = coordinates.handles().size();
    const std::size_t batch_size = detail::PackedBinder<T, D>::points_of_batch(options, handles);
    const std::size_t format = weight_bytes<T>(options.pack.format.value_or(WeightFormat::scalar));
    const std::size_t blocks = block_count<T>(points);
    StreamedPackMemory memory;
    memory.batch = block_count<T>((std::min)(batch_size, points)) * (handles + D) * sizeof(Lanes<T>);
    memory.packed =
        blocks * lane_count<T> * (handles * format + 3 * D * sizeof(T)) + handles * 16 * sizeof(T);
    if constexpr (requires { coordinates.solver_memory(); }) {
        const auto solver = coordinates.solver_memory();
        memory.solver = solver.hierarchy + solver.block;
        if (points > batch_size) memory.functions = (handles + 15) / 16 * (solver.block / 2);
    }
    return memory;
}

} // namespace cageform::inline CAGEFORM_ABI
