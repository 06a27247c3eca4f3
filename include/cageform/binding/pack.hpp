// From a binding or a figure to what is shipped: weights dropped, by number or by the distance that points may
// be off, rounded, put into an order that lets neighbours share rows.
#pragma once

#include <cageform/binding/detail/figure_packer.hpp>
#include <cageform/binding/detail/streamed_packer.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Packs a binding: drops weights, rounds them, and restores Σ w and Σ w c of every point, so that
/// rest and affine poses stay as exact as they were. Dropping is followed by the least change of
/// the weights kept, in the sense of least squares; rounding by D + 1 numbers a point that hold
/// what is missing (binding/detail/packed_binding.hpp). A point keeps its own largest weights and those of
/// other handles its block has a row for: they cost nothing.
///
/// With a tolerance, every block is given the rows that serve its points best, one after the other,
/// until none of them has a larger distance. Over poses, the weights kept are those that lose the
/// least in them. What is promised is measured on the weights as stored; a clone adds the rounding
/// of its own sums.
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
    return detail::pack_binding(binding, options, running);
}
template <Scalar T, std::size_t D>
Result<PackedBinding<T, D>, PackReport> pack(const Binding<T, D>& binding, const PackOptions& options = {},
                                             const Running& running = {}) {
    return pack(binding.view(), options, running);
}

/// Packs a figure for `open`: its bindings as `pack` does, the tangents in the order of the
/// points, its labels, clips and levels, and parts of the user's.
///
///   returns  the packed figure and its report; fails as `pack`, with the part in
///            FigurePackReport::culprit; tag_taken, name_taken, too_many_parts; of a clip or level, as
///            `open_clip` and `open`, and blob_of_another_cage; bindings_differ,
///            vectors_do_not_match, labels_do_not_match, where the parts of the figure were replaced
///            by others that are of different points or handles
///   cost     that of `pack` for each binding, and a copy of all parts
template <Scalar T, std::size_t D>
Result<PackedFigure<T, D>, FigurePackReport>
pack(const FigureBinding<T, D>& figure, const FigurePackOptions& options = {}, const Running& running = {}) {
    Result<PackedFigure<T, D>, FigurePackReport> result;
    detail::run_into(result.report,
                     [&] { return detail::pack_parts<T, D>(figure, options, running, result); });
    return result;
}

/// `pack` of `bind`, without the weights between in memory: the same bytes, and the same reports but
/// for the times and PackReport::culprit of what is refused. Coordinates that are solved for are
/// solved once, their functions kept meanwhile; few points, of one batch, are bound as `bind` does.
///
///   points  any PointRange of the same dimension, converted to the scalar of the coordinates; copied
///   fails   as `bind` and `pack`; too_many_handles also where all blocks have more than 2³² rows
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

/// What that takes, told before; of coordinates that are solved for at the cost of making the grid.
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
