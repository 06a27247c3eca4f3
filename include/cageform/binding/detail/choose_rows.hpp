// Chooses the handles that get a row in a block of a packed binding.
#pragma once

#include <cageform/binding/detail/greedy_row_selection.hpp>
#include <cageform/binding/detail/packed_block.hpp>
#include <cageform/cage/detail/indices.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns whether the chosen handles are spread in all directions. For nearly coplanar handles, only
/// huge changes of weights would restore the row sums. The measure is the least mean square of the
/// affine rows along any direction, which is 1 for all handles together.
template <std::size_t D, class Chosen>
bool are_spread(const Moments<D>& moments, const Chosen& chosen) {
    constexpr double enough = 0.05;
    return principal_axes(moments.sum_of_squares(chosen)).least() >= enough;
}

/// The rows of a block that the number and size of weights require.
struct RowsBySize {
    std::vector<std::uint32_t> handles; ///< ascending
    std::size_t added = 0;              ///< rows added because the other handles are nearly coplanar
};

/// Returns the handles whose weights are kept for any point of a block. Adds handles until they are spread.
template <Scalar T, std::size_t D>
RowsBySize rows_by_size(const BindingView<T, D>& binding, const Moments<D>& moments,
                        const BlockPoints<T>& points, const PackOptions& options) {
    const std::size_t handles = moments.size();
    std::vector<double> largest(handles, 0.0); // of any point
    std::vector<char> chosen(handles, 0);
    std::vector<std::size_t> candidates;
    for (std::size_t lane = 0; lane < points.count; ++lane) {
        const std::size_t i = points.index[lane];
        const auto size = [&](std::size_t h) { return std::fabs(double(binding.weights(i, h))); };
        candidates.clear();
        for (std::size_t h = 0; h < handles; ++h) {
            largest[h] = (std::max)(largest[h], size(h));
            if (size(h) > 0 && size(h) >= options.threshold) candidates.push_back(h);
        }
        if (options.largest != 0 && candidates.size() > options.largest) {
            const auto last = candidates.begin() + std::ptrdiff_t(options.largest);
            std::nth_element(
                candidates.begin(), last - 1, candidates.end(),
                [&](std::size_t a, std::size_t b) { return size(a) != size(b) ? size(a) > size(b) : a < b; });
            candidates.erase(last, candidates.end());
        }
        for (const std::size_t h : candidates) chosen[h] = 1;
    }
    RowsBySize result;
    const auto is_chosen = [&chosen](std::size_t h) { return chosen[h] != 0; };
    const bool all_are_needed = std::none_of(largest.begin(), largest.end(), [](double w) { return w > 0; });
    while (!all_are_needed && !are_spread(moments, is_chosen)) {
        std::size_t next = handles;
        for (std::size_t h = 0; h < handles; ++h) {
            if (!is_chosen(h) && largest[h] > 0 && (next == handles || largest[h] > largest[next])) next = h;
        }
        if (next == handles) break;
        chosen[next] = 1;
        ++result.added;
    }
    for (std::size_t h = 0; h < handles; ++h) {
        if (is_chosen(h)) result.handles.push_back(static_cast<std::uint32_t>(h));
    }
    return result;
}

/// The number of rows that a block needs in one format, in the order of selection.
struct RowTrial {
    static constexpr std::size_t none = ~std::size_t{0};

    explicit RowTrial(WeightFormat stored_as)
        : format(stored_as) {}

    WeightFormat format;
    std::size_t too_few = 0;    ///< the largest insufficient number of rows found
    std::size_t count = none;   ///< the number of rows that meets the tolerance
    std::size_t first_pose = 0; ///< the pose that decided the last test; tested first next time
    Extreme distance;           ///< the smallest distance found above the tolerance
    bool tested_all = false, rejected = false;

    bool is_met() const { return count != none; }
    bool is_open() const { return !is_met() && !rejected; }
};

/// Finds the fewest rows of a block that meet a tolerance.
template <Scalar T, std::size_t D>
class RowChooser {
public:
    static constexpr std::size_t lanes = lane_count<T>;

    /// The rows of `required` are selected first.
    RowChooser(const BlockPacker<T, D>& packer, const SquareLoss<D>& loss, const BlockPoints<T>& points,
               std::span<const std::uint32_t> required)
        : packer_(packer)
        , loss_(loss)
        , points_(points)
        , all_(all_rows(packer, loss, points))
        , selection_(loss, all_.weights) {
        for (const std::uint32_t h : required) selection_.add(h);
    }

    /// Fills `trials`, whose formats are given, with the smallest number of rows that meets
    /// `tolerance`. The number grows by an eighth per step and is then bisected. Quantised formats are
    /// tested only after scalar weights meet the tolerance.
    void run(std::span<RowTrial> trials, double tolerance) {
        // The final measurement sums in another order; this margin covers its rounding errors.
        const double limit = tolerance * (1 - 1e-9);
        const std::size_t candidates = selection_.candidates(), required = selection_.order().size();
        RowTrial scalar(WeightFormat::scalar);
        for (std::size_t count = (std::min)((std::max)(required, D + 1), candidates);;) {
            while (selection_.order().size() < count) selection_.add(selection_.best());
            if (test(scalar, count, limit)) {
                for (RowTrial& trial : trials) {
                    if (trial.is_open() && !test(trial, count, limit))
                        reject_if_too_coarse(trial, count, limit);
                }
            }
            const bool open = std::any_of(trials.begin(), trials.end(), [](auto& t) { return t.is_open(); });
            if (!open || count == candidates) break;
            count = (std::min)(count + std::max<std::size_t>(count / 8, 1), candidates);
        }
        std::size_t too_few = required > 0 ? required - 1 : 0;
        too_few = bisect(scalar, too_few, limit);
        for (RowTrial& trial : trials) {
            if (trial.is_met()) (void)bisect(trial, too_few, limit);
        }
    }

    std::span<const std::uint32_t> order() const { return selection_.order(); }
    /// Returns the first `count` selected rows.
    PackedRows rows(std::size_t count) const {
        const auto solution = selection_.solution(count);
        auto sorted = first_indices<std::size_t>(count);
        std::sort(sorted.begin(), sorted.end(),
                  [&](std::size_t a, std::size_t b) { return order()[a] < order()[b]; });
        PackedRows rows;
        for (const std::size_t n : sorted) {
            rows.handles.push_back(order()[n]);
            rows.weights.insert(rows.weights.end(), solution[n].begin(), solution[n].end());
        }
        return rows;
    }

private:
    static PackedRows all_rows(const BlockPacker<T, D>& packer, const SquareLoss<D>& loss,
                               const BlockPoints<T>& points) {
        return packer.rows_of(points, first_indices<std::uint32_t>(loss.handles()));
    }

    /// Returns whether the first `count` rows meet the limit in the format of a trial.
    bool meets(RowTrial& trial, std::size_t count, double limit) const {
        PackedRows kept = rows(count);
        const auto has_row = [&](std::size_t h) {
            return std::binary_search(kept.handles.begin(), kept.handles.end(), h);
        };
        if (count < selection_.candidates() && !are_spread(loss_.moments(), has_row)) return false;
        packer_.restore(points_, kept);
        return packer_.distance(trial.format, points_, kept, limit, trial.first_pose) <= limit;
    }

    bool test(RowTrial& trial, std::size_t count, double limit) const {
        const bool kept = meets(trial, count, limit);
        if (!kept) {
            trial.too_few = count;
        } else if (!trial.is_met()) {
            trial.count = count;
        }
        return kept;
    }

    /// Rejects a format that is too coarse: more rows do not reduce its rounding errors. Once rounding
    /// dominates the distance, the format is tested with all rows, and rejected if the distance exceeds the
    /// limit. The limit does not influence when this test runs. So the reported reachable distance does not
    /// depend on the limit.
    void reject_if_too_coarse(RowTrial& trial, std::size_t count, double limit) const {
        PackedRows kept = rows(count);
        packer_.restore(points_, kept);
        const Extreme here = packer_.farthest(trial.format, points_, kept);
        trial.distance.lower(here);
        trial.rejected = count == selection_.candidates();
        RowTrial scalar(WeightFormat::scalar);
        if (trial.rejected || trial.tested_all || !meets(scalar, count, 0.25 * here.value)) return;
        trial.tested_all = true;
        const Extreme all = packer_.farthest(trial.format, points_, all_);
        trial.distance.lower(all);
        trial.rejected = all.value > limit;
    }

    /// Bisects the number of rows; returns the largest insufficient number.
    std::size_t bisect(RowTrial& trial, std::size_t too_few, double limit) const {
        too_few = (std::max)(too_few, trial.too_few);
        while (trial.count > too_few + 1) {
            const std::size_t middle = too_few + (trial.count - too_few) / 2;
            if (meets(trial, middle, limit)) {
                trial.count = middle;
            } else {
                too_few = middle;
            }
        }
        return too_few;
    }

    const BlockPacker<T, D>& packer_;
    const SquareLoss<D>& loss_;
    const BlockPoints<T>& points_;
    PackedRows all_;
    GreedyRowSelection<D, lanes> selection_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
