// A solution stored as the sum of a high and a low float, which has about twice float's digits.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/level.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The sum of all float solutions so far.
class HighLow {
public:
    std::size_t bytes() const noexcept { return (high_.capacity() + low_.capacity()) * sizeof(NodeRow); }
    void clear() noexcept {
        high_.clear();
        low_.clear();
    }

    /// Adds a float solution. `u` is unspecified afterwards. The second call allocates the low part.
    void add(Buffer<NodeRow>& u, const WorkShare& share) {
        if (high_.empty()) {
            std::swap(u, high_);
            u.resize(high_.size());
            return;
        }
        const bool first = low_.empty();
        if (first) low_.resize(high_.size());
        share.for_ranges(u.size(), 8192, [&](std::size_t begin, std::size_t end) {
            if (first) set_zero(low_, begin, end);
            for (std::size_t i = begin; i < end; ++i) add_at(i, u[i]);
        });
    }

    void add_to(NodeValues& sum, std::uint32_t node, double factor) const noexcept {
        for (const auto* half : {&high_, &low_}) {
            if (half->empty()) return;
            for (std::size_t k = 0; k < functions_together; ++k) sum[k] += factor * double((*half)[node][k]);
        }
    }
    /// Sets out = −A · solution, computed in double, at the nodes of a run of the finest level.
    template <std::size_t D>
    void apply_minus_a(const RegularRun<D>& run, double diagonal, Buffer<NodeRow>& out) const noexcept {
        const auto to = run.nearest();
        const auto add = [&to, diagonal](NodeValues& sum, const NodeRow* here) {
            for (const auto step : to) {
                for (std::size_t k = 0; k < functions_together; ++k) sum[k] += double(here[step][k]);
            }
            for (std::size_t k = 0; k < functions_together; ++k) sum[k] -= diagonal * double((*here)[k]);
        };
        for (std::size_t i = run.first; i < run.first + run.count; ++i) {
            NodeValues sum{};
            add(sum, high_.data() + i);
            if (!low_.empty()) add(sum, low_.data() + i);
            for (std::size_t k = 0; k < functions_together; ++k) out[i][k] = float(sum[k]);
        }
    }

private:
    void add_at(std::size_t i, const NodeRow& u) noexcept {
        for (std::size_t k = 0; k < functions_together; ++k) {
            const double low = double(low_[i][k]) + double(u[k]);
            const double sum = double(high_[i][k]) + low;
            high_[i][k] = float(sum);
            low_[i][k] = float(sum - double(high_[i][k]));
        }
    }

    Buffer<NodeRow> high_, low_; ///< per node of the finest level, or empty
};

} // namespace cageform::inline CAGEFORM_ABI::detail
