// Packs a binding or a figure for shipping: drops small weights, rounds the others, and stores
// points so that neighbours share rows of weights. The loss is limited by number, by size,
// or by the distance that points may move.
#pragma once

#include <cageform/binding/detail/packers.hpp>
#include <cageform/binding/detail/streamed_packer.hpp>
#include <cageform/core/detail/stopwatch.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Packs a binding. It drops weights and rounds the others, but keeps Σ w and Σ w c of every point
/// (c are the handles at rest), so rest and affine poses stay as exact as they were:
///
///   - Without a tolerance, the kept weights change by the least amount, in the least-squares sense,
///     that restores both sums. With one, all kept weights are solved anew, see below.
///   - After rounding, D + 1 numbers per point hold what is missing of the sums
///     (figure/packed_binding.hpp). Scalar weights have no such numbers.
///
/// Points are stored in blocks of one cache line (16 points of float, 8 of double). A block has a
/// row of weights for every handle that is kept for at least one of its points, so a point keeps
/// its own largest weights, and also those of the other rows of its block, which cost nothing.
///
/// Points at one place with equal weights may lie in different blocks. They do not keep the extra weights
/// that other rows of their blocks offer, so a seam stays closed. Formats other than scalar round by the
/// scale of each block, and open a seam by that rounding. A tolerance opens a seam by at most twice the
/// tolerance.
///
/// PackOptions::tolerance packs by distance. Two measures have two jobs. The square loss δᵀKδ of a change
/// δ of a point's weights ranks handles and fits weights: it is the mean squared displacement over
/// the poses, with a small share for other motion (row_pursuit.hpp). The distance decides when to
/// stop: it is the largest over the poses. Without poses, K treats all handles alike, and the distance is
/// a bound over all poses within PackOptions::reach.
///
///   1. Rank: in each block, rows are added one after the other, always the one that lowers the square
///      losses most; points with large losses count most.
///   2. Refit: for a number of rows, all kept weights are solved anew. They have the least δᵀKδ of
///      all weights with exactly the sums Σ w and Σ w c of the full ones.
///   3. Test: the weights are stored in each possible format and read back. The block
///      gets the fewest rows found with which no point of it is farther off than the tolerance.
///   4. Format: the whole binding gets one format, that of the fewest bytes among those that keep the
///      tolerance in every block. No block has a format of its own.
///
/// Not promised: the tolerance in poses between the given ones or in other motion, and the rounding
/// of the sums that `clone` computes, which adds to the reported distance.
///
/// Code: binding/detail/packer.hpp packs block by block, choose_rows.hpp finds the number of rows
/// of a block, row_pursuit.hpp the order in which rows are added.
///
///   binding  any binding, of points or vectors
///   returns  the packed binding and its report; fails with too_few_weights, too_many_handles (more
///            than 65,535 in sparse bindings), order_not_a_permutation, weight_not_finite
///            (PackReport::culprit), value_not_finite (a tolerance or reach that is no number or
///            negative), pose_size_differs, pose_not_finite (culprit), format_too_coarse
///            (PackReport::distance is then one that it can keep), cancelled, out_of_memory
///   cost     O(#points · #handles · (D² + #poses)); with a tolerance also O(#poses · #handles²), and
///            O(#points · #handles · rows) a block: 0.5 s for 8,000 points, 112 handles and 24 poses
///   memory   with a tolerance over poses #handles² numbers, besides what is packed
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
/// labels, clips and levels, and parts of the user.
///
///   returns  the packed figure and its report; fails as `pack`, with the part in
///            FigurePackReport::culprit; duplicate_tag, duplicate_name, too_many_parts; for a clip or level
///            as `open_clip` and `open`, and blob_of_another_cage; bindings_differ,
///            vectors_do_not_match, labels_do_not_match, if the parts of the figure were replaced
///            by others of different points or handles
///   cost     that of `pack` for each binding, and a copy of all parts
template <Scalar T, std::size_t D>
Result<PackedFigure<T, D>, FigurePackReport>
pack(const FigureBinding<T, D>& figure, const FigurePackOptions& options = {}, const Running& running = {}) {
    Result<PackedFigure<T, D>, FigurePackReport> result;
    detail::run_into(result.report,
                     [&] { return detail::pack_parts<T, D>(figure, options, running, result); });
    return result;
}

/// Binds points and packs the result in batches, so that the full weights are never in memory at
/// once. The bytes are those of `pack` after `bind`, and so are the reports, except for times and
/// the PackReport::culprit of a refusal. Coordinates with a solver solve once and keep their
/// functions meanwhile. If the points fit into one batch, they are bound as `bind` does.
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

/// Returns the memory of a streamed `pack` in advance. For coordinates with a solver it costs as
/// much as making the grid.
template <CageCoordinates C>
StreamedPackMemory pack_memory(const C& coordinates, std::size_t points,
                               const StreamedPackOptions& options = {}) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    const std::size_t handles = coordinates.handles().size();
    const std::size_t together = detail::PackedBinder<T, D>::points_of_batch(options, handles);
    const std::size_t format = weight_bytes<T>(options.pack.format.value_or(WeightFormat::scalar));
    const std::size_t blocks = block_count<T>(points);
    StreamedPackMemory memory;
    memory.batch = block_count<T>((std::min)(together, points)) * (handles + D) * sizeof(Lanes<T>);
    memory.packed =
        blocks * lane_count<T> * (handles * format + 3 * D * sizeof(T)) + handles * 16 * sizeof(T);
    if constexpr (requires { coordinates.solver_memory(); }) {
        const auto solver = coordinates.solver_memory();
        memory.solver = solver.hierarchy + solver.block;
        if (points > together) memory.functions = (handles + 15) / 16 * (solver.block / 2);
    }
    return memory;
}

} // namespace cageform::inline CAGEFORM_ABI
