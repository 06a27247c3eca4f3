// The equations of a PoseSolver: the matrix for given pins and held handles, and its solutions.
#pragma once

#include <cageform/pose/detail/axis_vectors.hpp>
#include <cageform/pose/detail/pin_rows.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The factored matrix of the unknown handles, for given pins and held handles.
template <Scalar T, std::size_t D>
class PoseSystem {
public:
    PinRows<T, D> pins;
    std::vector<std::uint32_t> unknowns, held; ///< handles, ascending
    double proximity = 0;                      ///< 1e-9 of the mean diagonal entry of K

    /// Factors the matrix for the members `pins` and `held`. May throw std::bad_alloc.
    ///
    ///   culprit  out: the handle with a pivot that is not positive (pose_not_determined)
    Status factor(const PoseSamples<T, D>& samples, bool hard, std::size_t& culprit) {
        constexpr double epsilon_of_matrix = 1e-9;
        const std::size_t count = samples.handle_count();
        std::vector<std::uint32_t> place(count, 0);
        unknowns.clear();
        for (std::size_t h = 0, at = 0; h < count; ++h) {
            if (at < held.size() && held[at] == h) {
                place[h] = std::uint32_t(at++);
                continue;
            }
            place[h] = std::uint32_t(unknowns.size());
            unknowns.push_back(std::uint32_t(h));
        }
        double trace = 0;
        for (std::size_t h = 0; h < count; ++h) trace += samples.stiffness_of(h, h);
        proximity = epsilon_of_matrix * trace / double(count);
        factors_.reset(unknowns.size());
        for (std::size_t n = 0; n < unknowns.size(); ++n) {
            for (std::size_t m = n; m < unknowns.size(); ++m)
                factors_.at(n, m) = entry(samples, unknowns[n], unknowns[m]) + (m == n ? proximity : 0);
        }
        coupling_.assign(held.size(), {});
        for (std::size_t n = 0; n < held.size(); ++n) {
            coupling_[n].reset(unknowns.size());
            for (std::size_t m = 0; m < unknowns.size(); ++m)
                coupling_[n].set(m, {entry(samples, held[n], unknowns[m])});
        }
        const std::size_t failed = factors_.factor();
        if (failed != Cholesky::none) {
            culprit = unknowns[failed];
            return Status::pose_not_determined;
        }
        responses_.clear();
        if (hard && !unknowns.empty()) correct();
        return Status::ok;
    }

    /// Solves for the unknowns.
    ///
    ///   right          A d for all handles
    ///   displacements  of held handles
    ///   demands        the target positions of the rows of hard pins
    ///   to             out: the unknowns
    void solve(const AxisVectors<D>& right, const AxisVectors<D>& displacements,
               const Vec<double, D>* demands, AxisVectors<D>& to) noexcept {
        for (std::size_t n = 0; n < unknowns.size(); ++n) to.set(n, right.get(unknowns[n]));
        for (std::size_t n = 0; n < held.size(); ++n)
            to.add(coupling_[n].data(), -1.0 * displacements.get(held[n]));
        to.with_axes([&](auto& axes) { factors_.solve(axes); });
        if (responses_.empty()) return;
        std::size_t m = 0;
        for (std::size_t r = 0; r < pins.rows.size(); ++r) {
            if (!pins.rows[r].is_point()) continue;
            Vec<double, D> miss = demands[r] - to.product(of_unknowns_[m].data());
            for (const std::uint32_t h : held)
                miss = miss - pin_weight(r, right.blocks(), h) * displacements.get(h);
            misses_.set(m++, miss);
        }
        misses_.with_axes([&](auto& axes) { correction_.solve(axes); });
        for (std::size_t n = 0; n < m; ++n) to.add(responses_[n].data(), misses_.get(n));
    }

private:
    double pin_weight(std::size_t row, std::size_t blocks, std::size_t handle) const noexcept {
        return pins.weights[row * blocks + handle / lane_count<double>][handle % lane_count<double>];
    }
    double entry(const PoseSamples<T, D>& samples, std::size_t i, std::size_t j) const noexcept {
        const std::size_t blocks = block_count<double>(samples.handle_count());
        double sum = samples.stiffness_of(i, j);
        for (std::size_t r = 0; r < pins.rows.size(); ++r)
            sum += pins.rows[r].weight * pin_weight(r, blocks, i) * pin_weight(r, blocks, j);
        return sum;
    }
    /// Computes Z = A⁻¹Wᵀ and factors W Z plus 1e-3 / (μ m) of each pin on the diagonal (augmented
    /// Lagrangian, Powell).
    void correct() {
        const std::size_t blocks = pins.rows.empty() ? 0 : pins.weights.size() / pins.rows.size();
        of_unknowns_.clear();
        std::vector<double> softness;
        for (std::size_t r = 0; r < pins.rows.size(); ++r) {
            if (!pins.rows[r].is_point()) continue;
            auto& row = of_unknowns_.emplace_back();
            row.reset(unknowns.size());
            for (std::size_t n = 0; n < unknowns.size(); ++n)
                row.set(n, {pin_weight(r, blocks, unknowns[n])});
            softness.push_back(1e-3 / pins.rows[r].weight);
        }
        const std::size_t count = of_unknowns_.size();
        responses_ = of_unknowns_;
        for (auto& response : responses_) response.with_axes([&](auto& axes) { factors_.solve(axes); });
        correction_.reset(count);
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t j = i; j < count; ++j)
                correction_.at(i, j) =
                    responses_[j].product(of_unknowns_[i].data())[0] + (i == j ? softness[i] : 0);
        }
        if (correction_.factor() != Cholesky::none) responses_.clear(); // falls back to soft pins
        misses_.reset(count);
    }

    Cholesky factors_, correction_;
    std::vector<AxisVectors<1>> coupling_;    ///< a row of A for each held handle
    std::vector<AxisVectors<1>> of_unknowns_; ///< W, for hard pins
    std::vector<AxisVectors<1>> responses_;   ///< A⁻¹Wᵀ; empty for soft pins
    AxisVectors<D> misses_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
