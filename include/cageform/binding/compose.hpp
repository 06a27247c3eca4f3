// Composes two bindings: a figure bound to sites, and the sites bound to fewer handles.
#pragma once

#include <cageform/binding/detail/sparse_rows.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/detail/huge_pages.hpp>
#include <cageform/core/result.hpp>
#include <cageform/figure/binding.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct ComposeReport {
    Status status = Status::ok;
    std::vector<std::uint32_t> still; ///< sites without weights for coarse handles; they never move
};

/// Replaces two consecutive clones by one binding with the weights U V. U are the weights of a figure
/// bound to sites, V the weights of the sites bound to coarser handles.
///
///     clone(compose(fine, coarse)) = clone(fine) by the pose clone(coarse), to rounding
///
///   fine     the figure, bound to n sites, which must be points
///   coarse   the n sites as points, equal to the handles of `fine` bit for bit
///   running  threads, progress, cancellation; the result does not depend on it
///   returns  the binding. Up to rounding, weights have the sum 1 and reproduce the point if those of `fine`
///            and `coarse` do. Sites that are kept in place do not move the figure; the report lists them
///   cost     one product for each pair of a non-zero fine weight and a non-zero weight of its site;
///            (#coarse handles + D) scalars of memory per point. Sums are in double
///   fails    handles_not_points, bindings_differ, cancelled, out_of_memory
template <Scalar T, std::size_t D>
Result<Binding<T, D>, ComposeReport> compose(const Binding<T, D>& fine, const Binding<T, D>& coarse,
                                             const Running& running = {}) {
    constexpr std::size_t lanes = lane_count<T>;
    Result<Binding<T, D>, ComposeReport> result;
    result.report.status = detail::guard_memory([&] {
        Status status = detail::check_compose(fine, coarse);
        if (status != Status::ok) return status;
        const detail::SparseRows<T> rows(coarse);
        for (std::size_t i = 0; i < fine.handle_count(); ++i) {
            if (rows.begin[i] == rows.begin[i + 1])
                result.report.still.push_back(static_cast<std::uint32_t>(i));
        }
        const auto view = fine.view();
        const std::size_t handles = coarse.handle_count(), blocks = view.weights.blocks();
        std::vector<Lanes<T>> weights;
        detail::resize_large(weights, blocks * handles);
        status = detail::for_each_block(blocks, running, [&](std::size_t begin, std::size_t end) {
            std::vector<double> sums(handles);
            for (std::size_t n = begin * lanes; n < end * lanes; ++n) {
                const std::size_t block = n / lanes, lane = n % lanes;
                std::fill(sums.begin(), sums.end(), 0.0);
                for (std::size_t i = 0; i < fine.handle_count(); ++i) {
                    const auto w = double(view.weights.block(block)[i][lane]);
                    if (w == 0) continue;
                    for (std::size_t r = rows.begin[i]; r < rows.begin[i + 1]; ++r)
                        sums[rows.handle[r]] += w * rows.weight[r];
                }
                for (std::size_t h = 0; h < handles; ++h)
                    weights[block * handles + h][lane] = static_cast<T>(sums[h]);
            }
        });
        if (status != Status::ok) return status;
        std::vector<Lanes<T>> rest(view.rest.data, view.rest.data + blocks * D);
        result.value =
            Binding<T, D>(std::move(weights), std::move(rest), coarse.handle_view(), fine.point_count());
        return Status::ok;
    });
    if (result.report.status != Status::ok) result.report.still.clear();
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
