// Fits the pose of a lattice by least squares, with a penalty on second differences of displacements.
#pragma once

#include <cageform/binding/detail/least_squares.hpp>
#include <cageform/binding/types/lattice_fit.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/figure/binding.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <Scalar T, std::size_t D>
class LatticeFitter {
    using Term = LeastSquares::Term;

public:
    LatticeFitter(const LatticeCoordinates<T, D>& lattice, const BindingView<T, D>& binding,
                  const std::vector<Vec<double, D>>& displacements, const LatticeFitOptions& options)
        : lattice_(lattice)
        , binding_(binding)
        , displacements_(displacements)
        , options_(options) {}

    Status run(LatticeFitReport& report, std::vector<Vec<T, D>>& pose) {
        const Status status = check();
        report.unreached = unreached_;
        if (status != Status::ok) return status;
        number_unknowns();
        LeastSquares equations(unknowns_, D);
        std::vector<char> is_moving(unknowns_);
        for (std::size_t j = 0; j < displacements_.size(); ++j) {
            if (share_of(j) == 0) continue;
            read_row(j);
            for (const Term& term : row_) is_moving[term.unknown] = 1;
            equations.add(row_, displacements_[j].v, share_of(j));
        }
        for (std::size_t i = 0; i < unknown_of_.size(); ++i) {
            if (unknown_of_[i] != fixed && is_moving[unknown_of_[i]] == 0)
                report.idle.push_back(std::uint32_t(i));
        }
        add_smoothness(equations);
        const auto solution = equations.solve();
        report.pivot_ratio = solution.pivot_ratio;
        if (solution.status != Status::ok) return solution.status;
        for (const double x : solution.values) {
            if (!is_finite(x)) return Status::value_not_finite;
        }
        measure(solution.values, report);
        for (std::size_t i = 0; i < lattice_.handles().size(); ++i) {
            Vec<double, D> place = vec_cast<double>(lattice_.handles()[i]);
            if (i < unknown_of_.size() && unknown_of_[i] != fixed)
                place = place + value_of(solution.values, unknown_of_[i]);
            pose.push_back(vec_cast<T>(place));
            if (!is_finite(pose.back())) return Status::value_not_finite;
        }
        return Status::ok;
    }

private:
    static constexpr std::uint32_t fixed = ~std::uint32_t{0};

    Status check() {
        if (lattice_.cage_report().status != Status::ok) return lattice_.cage_report().status;
        if (lattice_.handles().empty()) return Status::coordinates_empty;
        const std::size_t count = binding_.point_count();
        const auto& given = options_.point_weights;
        if (binding_.handle_count() != lattice_.handles().size() || displacements_.size() != count ||
            (!given.empty() && given.size() != count))
            return Status::targets_do_not_match;
        if (!is_finite(options_.smoothness) || options_.smoothness < 0) return Status::value_not_finite;
        for (const double weight : given) {
            if (!is_finite(weight)) return Status::value_not_finite;
            if (weight < 0) return Status::weights_not_positive;
            largest_weight_ = (std::max)(largest_weight_, weight);
        }
        if (given.empty()) largest_weight_ = 1;
        if (!(largest_weight_ > 0)) return Status::weights_not_positive;
        has_residual_.assign(count, 0);
        for (std::size_t j = 0; j < count; ++j) {
            if (!is_finite(block_point<D>(binding_.rest, j))) continue;
            if (!is_finite(displacements_[j])) return Status::value_not_finite;
            has_residual_[j] = has_weights(j) ? 1 : 0;
            if (has_residual_[j] == 0) ++unreached_;
            if (has_residual_[j] != 0) total_ += relative_weight(j);
        }
        if (!(total_ > 0)) return Status::fit_not_determined;
        for (const std::uint32_t i : options_.frozen) {
            if (i >= lattice_.handles().size()) return Status::index_out_of_range;
        }
        return Status::ok;
    }
    void number_unknowns() {
        unknown_of_.assign(lattice_.handles().size() - lattice_.frame_handles(), 0);
        for (const std::uint32_t i : options_.frozen) {
            if (i < unknown_of_.size()) unknown_of_[i] = fixed;
        }
        for (auto& number : unknown_of_) {
            if (number != fixed) number = std::uint32_t(unknowns_++);
        }
    }

    bool has_weights(std::size_t j) const noexcept {
        std::size_t i = 0;
        while (i < lattice_.handles().size() && binding_.weights(j, i) == 0) ++i;
        return i < lattice_.handles().size();
    }
    /// Returns the weight of a point divided by the largest one, so that sums do not overflow.
    double relative_weight(std::size_t j) const noexcept {
        return options_.point_weights.empty() ? 1 : options_.point_weights[j] / largest_weight_;
    }
    double share_of(std::size_t j) const noexcept {
        return has_residual_[j] != 0 ? relative_weight(j) / total_ : 0;
    }
    void read_row(std::size_t j) {
        row_.clear();
        for (std::size_t i = 0; i < unknown_of_.size(); ++i) {
            const auto weight = double(binding_.weights(j, i));
            if (weight != 0) add_term(i, weight);
        }
    }
    void add_term(std::size_t handle, double coefficient) {
        if (unknown_of_[handle] != fixed) row_.push_back({unknown_of_[handle], coefficient});
    }
    static Vec<double, D> value_of(const std::vector<double>& values, std::size_t unknown) noexcept {
        Vec<double, D> x;
        for (std::size_t k = 0; k < D; ++k) x[k] = values[unknown * D + k];
        return x;
    }

    /// Adds λ E, the mean squares of all second differences divided by the Greville abscissae. They are
    /// zero if and only if the displacements are affine. Mixed differences count twice.
    void add_smoothness(LeastSquares& equations) {
        if (!(options_.smoothness > 0)) return;
        std::array<std::size_t, D> stride;
        std::size_t points = 1;
        for (std::size_t k = 0; k < D; ++k) {
            stride[k] = points;
            points *= lattice_.points(k);
        }
        const auto index = [&](std::size_t n, std::size_t k) { return n / stride[k] % lattice_.points(k); };
        const auto step = [&](std::size_t k, std::size_t i) {
            return lattice_.greville(k, i + 1) - lattice_.greville(k, i);
        };
        const auto places = [&](std::size_t k, std::size_t fewer) {
            const std::size_t along = lattice_.points(k);
            return double(along - (std::min)(along, fewer)) / double(along);
        };
        constexpr Vec<double, D> zero{};
        for (std::size_t k = 0; k < D; ++k) {
            const double weight = options_.smoothness / (places(k, 2) * double(points));
            for (std::size_t n = 0; n < points; ++n) {
                const std::size_t i = index(n, k);
                if (i + 2 >= lattice_.points(k)) continue;
                const double before = step(k, i), after = step(k, i + 1), half = (before + after) / 2;
                row_.clear();
                add_term(n, 1 / (before * half));
                add_term(n + stride[k], -(1 / before + 1 / after) / half);
                add_term(n + 2 * stride[k], 1 / (after * half));
                equations.add(row_, zero.v, weight);
            }
            for (std::size_t l = k + 1; l < D; ++l) {
                const double twice = 2 * options_.smoothness / (places(k, 1) * places(l, 1) * double(points));
                for (std::size_t n = 0; n < points; ++n) {
                    const std::size_t i = index(n, k), j = index(n, l);
                    if (i + 1 >= lattice_.points(k) || j + 1 >= lattice_.points(l)) continue;
                    const double part = 1 / (step(k, i) * step(l, j));
                    row_.clear();
                    add_term(n, part);
                    add_term(n + stride[k], -part);
                    add_term(n + stride[l], -part);
                    add_term(n + stride[k] + stride[l], part);
                    equations.add(row_, zero.v, twice);
                }
            }
        }
    }

    void measure(const std::vector<double>& values, LatticeFitReport& report) {
        for (std::size_t j = 0; j < displacements_.size(); ++j) {
            const double share = share_of(j);
            if (share == 0) continue;
            read_row(j);
            Vec<double, D> residual = displacements_[j];
            for (const Term& term : row_)
                residual = residual - term.coefficient * value_of(values, term.unknown);
            double length = 0;
            for (const double x : residual.v) length = std::hypot(length, x);
            report.rms = std::hypot(report.rms, std::sqrt(share) * length);
            if (!(length > report.largest)) continue;
            report.largest = length;
            report.farthest = j;
        }
    }

    const LatticeCoordinates<T, D>& lattice_;
    const BindingView<T, D>& binding_;
    const std::vector<Vec<double, D>>& displacements_;
    const LatticeFitOptions& options_;
    double largest_weight_ = 0, total_ = 0; ///< of a point; the sum of the relative weights
    std::vector<char> has_residual_;        ///< whether a point has a residual
    std::size_t unreached_ = 0, unknowns_ = 0;
    std::vector<std::uint32_t> unknown_of_; ///< the unknown of each control point, or `fixed`
    std::vector<Term> row_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
