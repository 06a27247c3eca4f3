// The equations of a PoseSolver: the matrix for given pins and held handles, and its solutions.
#pragma once

#include <cageform/pose/detail/cholesky.hpp>
#include <cageform/pose/detail/pin_rows.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// D vectors of numbers in whole blocks, padded by zeros.
template <std::size_t D>
class AxisVectors {
public:
    /// Allocates zeros. May throw std::bad_alloc.
    void reset(std::size_t count) {
        blocks_ = block_count<double>(count);
        values_.resize(D * blocks_);
        clear();
    }
    void clear() noexcept {
        for (auto& block : values_) Simd<double>(0).store(block);
    }
    std::size_t blocks() const noexcept { return blocks_; }
    Lanes<double>* axis(std::size_t k) noexcept { return values_.data() + k * blocks_; }
    const Lanes<double>* axis(std::size_t k) const noexcept { return values_.data() + k * blocks_; }
    Lanes<double>* data() noexcept { return values_.data(); }
    const Lanes<double>* data() const noexcept { return values_.data(); }
    void copy(const AxisVectors& from) noexcept {
        for (std::size_t b = 0; b < values_.size(); ++b) values_[b] = from.values_[b];
    }
    Vec<double, D> get(std::size_t i) const noexcept {
        Vec<double, D> v{};
        for (std::size_t k = 0; k < D; ++k) v[k] = axis(k)[i / lane_count<double>][i % lane_count<double>];
        return v;
    }
    void set(std::size_t i, const Vec<double, D>& v) noexcept {
        for (std::size_t k = 0; k < D; ++k) axis(k)[i / lane_count<double>][i % lane_count<double>] = v[k];
    }
    /// Returns the dot products of all axes with a row.
    Vec<double, D> product(const Lanes<double>* row) const noexcept {
        Vec<double, D> sums{};
        for (std::size_t k = 0; k < D; ++k) {
            Simd<double> sum(0);
            for (std::size_t b = 0; b < blocks_; ++b)
                sum = multiply_add(Simd<double>::load(row[b]), Simd<double>::load(axis(k)[b]), sum);
            sums[k] = ordered_sum(sum);
        }
        return sums;
    }
    /// Adds a row times one factor per axis.
    void add(const Lanes<double>* row, const Vec<double, D>& factors) noexcept {
        with_axes([&](auto& axes) { subtract_row<D>(row, 0, blocks_, -1.0 * factors, axes); });
    }
    /// Calls f(axes) with an array of pointers to the axes.
    template <class F>
    void with_axes(const F& f) noexcept {
        Lanes<double>* axes[D];
        for (std::size_t k = 0; k < D; ++k) axes[k] = axis(k);
        Lanes<double>* const(&constant)[D] = axes;
        f(constant);
    }

private:
    std::size_t blocks_ = 0;
    std::vector<Lanes<double>> values_;
};

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
