// Chooses the handles for which a block of a packed binding keeps rows.
#pragma once

#include <cageform/binding/detail/packed_block.hpp>
#include <cageform/binding/detail/row_pursuit.hpp>

#include <numeric>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns whether chosen handles are spread enough in all directions. If they lay nearly in one
/// plane, only huge changes of weights could restore row sums across it. Measured by the least mean
/// square of the affine rows, which is 1 for all handles together.
template <std::size_t D, class Chosen>
bool are_spread(const Moments<D>& moments, const Chosen& chosen) {
    constexpr double enough = 0.05;
    return principal_axes(moments.sum_of_squares(chosen)).least() >= enough;
}

/// The rows that a block needs because of the number or size of weights.
struct RowsBySize {
    std::vector<std::uint32_t> handles; ///< ascending
    std::size_t added = 0;              ///< because the others would lie too nearly in one plane
};

/// Returns the handles whose weights are kept for any point of a block, and more if those are not
/// spread.
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

/// How many rows a block needs in one format, in the order in which the pursuit added them.
struct RowTrial {
    static constexpr std::size_t none = ~std::size_t{0};

    explicit RowTrial(WeightFormat stored_as)
        : format(stored_as) {}

    WeightFormat format;
    std::size_t too_few = 0;  ///< the largest number of rows known to be too few
    std::size_t count = none; ///< the number of rows that keeps the tolerance
    std::size_t suspect = 0;  ///< the pose that decided last; tested first next time
    Extreme distance;         ///< the smallest distance found with too few rows
    bool tested_all = false, given_up = false;

    bool is_met() const { return count != none; }
    bool is_open() const { return !is_met() && !given_up; }
};

/// Finds the rows of one block that keep a tolerance.
template <Scalar T, std::size_t D>
class RowChooser {
public:
    static constexpr std::size_t lanes = lane_count<T>;

    /// The rows of `required` come first.
    RowChooser(const BlockPacker<T, D>& packer, const SquareLoss<D>& loss, const BlockPoints<T>& points,
               std::span<const std::uint32_t> required)
        : packer_(packer)
        , loss_(loss)
        , points_(points)
        , all_(all_rows(packer, loss, points))
        , pursuit_(loss, all_.weights) {
        for (const std::uint32_t h : required) pursuit_.add(h);
    }

    /// Fills `trials`, whose formats are set, with the smallest number of rows found to keep
    /// `tolerance`. The number grows by an eighth at a time and is then bisected. Rounded formats
    /// are tested only once scalar weights keep the tolerance.
    void run(std::span<RowTrial> trials, double tolerance) {
        // The final measurement sums in another order, so the limit is slightly lower here.
        const double limit = tolerance * (1 - 1e-9);
        const std::size_t candidates = pursuit_.candidates(), required = pursuit_.order().size();
        RowTrial scalar(WeightFormat::scalar);
        for (std::size_t count = (std::min)((std::max)(required, D + 1), candidates);;) {
            while (pursuit_.order().size() < count) pursuit_.add(pursuit_.best());
            if (test(scalar, count, limit)) {
                for (RowTrial& trial : trials) {
                    if (trial.is_open() && !test(trial, count, limit)) give_up(trial, count, limit);
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

    std::span<const std::uint32_t> order() const { return pursuit_.order(); }
    /// Returns the first `count` rows; the pursuit must have added as many.
    PackedRows rows(std::size_t count) const {
        const auto solution = pursuit_.solution(count);
        std::vector<std::size_t> sorted(count);
        std::iota(sorted.begin(), sorted.end(), std::size_t{0});
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
        std::vector<std::uint32_t> handles(loss.handles());
        std::iota(handles.begin(), handles.end(), 0u);
        return packer.rows_of(points, std::move(handles));
    }

    /// Returns whether the first `count` rows keep the limit in the format of a trial.
    bool keeps(RowTrial& trial, std::size_t count, double limit) const {
        PackedRows kept = rows(count);
        const auto has_row = [&](std::size_t h) {
            return std::binary_search(kept.handles.begin(), kept.handles.end(), h);
        };
        if (count < pursuit_.candidates() && !are_spread(loss_.moments(), has_row)) return false;
        packer_.restore(points_, kept);
        return packer_.distance(trial.format, points_, kept, limit, trial.suspect) <= limit;
    }

    bool test(RowTrial& trial, std::size_t count, double limit) const {
        const bool kept = keeps(trial, count, limit);
        if (!kept) {
            trial.too_few = count;
        } else if (!trial.is_met()) {
            trial.count = count;
        }
        return kept;
    }

    /// Decides whether a format is too coarse. More rows cannot undo its rounding. Once rounding is
    /// most of the distance, the format is tested with all rows, and given up if even these exceed
    /// the limit. When this test is made does not depend on the limit, so the distance reported as
    /// reachable does not either.
    void give_up(RowTrial& trial, std::size_t count, double limit) const {
        PackedRows kept = rows(count);
        packer_.restore(points_, kept);
        const Extreme here = packer_.farthest(trial.format, points_, kept);
        trial.distance.lower(here);
        trial.given_up = count == pursuit_.candidates();
        RowTrial scalar(WeightFormat::scalar);
        if (trial.given_up || trial.tested_all || !keeps(scalar, count, 0.25 * here.value)) return;
        trial.tested_all = true;
        const Extreme all = packer_.farthest(trial.format, points_, all_);
        trial.distance.lower(all);
        trial.given_up = all.value > limit;
    }

    /// Reduces the number of rows by bisection; returns the largest number known to be too few.
    std::size_t bisect(RowTrial& trial, std::size_t too_few, double limit) const {
        too_few = (std::max)(too_few, trial.too_few);
        while (trial.count > too_few + 1) {
            const std::size_t middle = too_few + (trial.count - too_few) / 2;
            if (keeps(trial, middle, limit)) {
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
    RowPursuit<D, lanes> pursuit_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
