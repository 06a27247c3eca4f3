// Measures the weights of a range of points, all lanes at once, for the report.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/core/types/blocks.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The status and measures of a range of points.
struct BindPiece {
    Status status = Status::ok;
    Extreme partition, reproduction, change, before, least, amplification;

    void put_into(BindReport& report) const noexcept {
        report.partition_error.raise(partition);
        report.reproduction_error.raise(reproduction);
        report.weight_change.raise(change);
        report.residual_restored.raise(before);
        report.least_weight.lower(least);
        report.amplification.raise(amplification);
    }
};

/// The largest value in each lane, and the first block that has it.
template <Scalar T>
class LaneExtreme {
    using Number = Simd<T>;

public:
    /// A lane without a value.
    static constexpr T none = std::numeric_limits<T>::lowest();

    CAGEFORM_DETAIL_INLINE void raise(const Number& value, const Number& block) noexcept {
        const auto larger = value_ < value;
        value_ = select<T>(larger, value, value_);
        block_ = select<T>(larger, block, block_);
    }
    /// Returns the largest value of all lanes, and the first point that has it. Block 0 begins at point
    /// `first`.
    Extreme of_points_from(std::size_t first) const noexcept {
        Lanes<T> values, blocks;
        value_.store(values);
        block_.store(blocks);
        Extreme most;
        for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
            if (values[lane] == none) continue;
            const Extreme here{double(values[lane]),
                               first + std::size_t(blocks[lane]) * lane_count<T> + lane};
            if (here.value == most.value && here.point < most.point) most.point = here.point;
            most.raise(here);
        }
        return most;
    }

private:
    Number value_{none}, block_{T(0)};
};

/// Collects the measures of a range of points, per block.
template <Scalar T>
class PieceMeasures {
    using Number = Simd<T>;

public:
    explicit PieceMeasures(std::size_t first_point) noexcept
        : first_(first_point) {}

    /// Adds the measures of the lanes in which `bound` is 1.
    template <class Outcome>
    void add(const Outcome& outcome, const Lanes<T>& bound, std::size_t block) noexcept {
        const std::size_t blocks_before = block - first_ / lane_count<T>;
        const Number none(LaneExtreme<T>::none), zero(T(0)), at(static_cast<T>(blocks_before));
        const auto is_bound = zero < Number::load(bound);
        const auto raise = [&](LaneExtreme<T>& extreme, const Number& value) {
            extreme.raise(select<T>(is_bound, value, none), at);
        };
        const Number change = Number::load(outcome.change);
        raise(partition_, Number::load(outcome.partition));
        raise(reproduction_, Number::load(outcome.reproduction));
        raise(change_, change);
        raise(before_, select<T>(zero < change, Number::load(outcome.before), none));
        raise(least_, zero - Number::load(outcome.least));
        raise(amplification_, Number::load(outcome.sizes));
    }
    void put_into(BindPiece& piece) const noexcept {
        piece.partition.raise(partition_.of_points_from(first_));
        piece.reproduction.raise(reproduction_.of_points_from(first_));
        piece.change.raise(change_.of_points_from(first_));
        piece.before.raise(before_.of_points_from(first_));
        Extreme least = least_.of_points_from(first_);
        least.value = 0 - least.value; // no minus zero
        piece.least.lower(least);
        piece.amplification.raise(amplification_.of_points_from(first_));
    }

private:
    std::size_t first_;
    LaneExtreme<T> partition_, reproduction_, change_, before_, least_, amplification_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
