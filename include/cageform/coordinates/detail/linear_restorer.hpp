// Linear precision for weights that miss it by a little.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/core/blocks.hpp>
#include <cageform/core/detail/pack_sqrt.hpp>

#include <Eigen/LU>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The least change of a point's weights that restores Σw = 1 and Σwc = p, for all points of a block; or, of weights that
/// move a vector t, Σw = 0 and Σwc = t.
///
/// With A = [1 … 1; ĉ_0 … ĉ_{m−1}] (ĉ centred and scaled to the cage) the change is Aᵀ(AAᵀ)⁻¹ r, r what is
/// missing; AAᵀ is (D+1)² and the same for all points.
template <Scalar T, std::size_t D>
class LinearRestorer {
public:
    struct Result {
        Lanes<T> partition, reproduction, before, change, least;
    };

    explicit LinearRestorer(std::span<const Vec<T, D>> handles) {
        const auto bounds = bounds_of(handles);
        centre_ = T(0.5) * (bounds.lower + bounds.upper);
        size_ = bounds.diagonal();
        columns_.resize(handles.size());
        Eigen::Matrix<double, int(D + 1), int(D + 1)> normal;
        normal.setZero();
        for (std::size_t i = 0; i < handles.size(); ++i) {
            Eigen::Matrix<double, int(D + 1), 1> a;
            a[0] = 1;
            for (std::size_t k = 0; k < D; ++k) {
                columns_[i][k] = (handles[i][k] - centre_[k]) / size_;
                a[long(k) + 1] = double(columns_[i][k]);
            }
            normal += a * a.transpose();
        }
        const auto inverse = normal.inverse().eval();
        for (std::size_t r = 0; r <= D; ++r) {
            for (std::size_t c = 0; c <= D; ++c) inverse_[r][c] = static_cast<T>(inverse(long(r), long(c)));
        }
    }

    /// `row` holds the weights of a block of points; `bound` is one in lanes to treat and zero in others. Measures alone
    /// unless `restore`.
    Result run(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Pack wanted[D + 1];
        wanted[0] = Pack(T(1));
        for (std::size_t k = 0; k < D; ++k)
            wanted[k + 1] = (Pack::load(target[k]) - Pack(centre_[k])) * Pack(T(1) / size_);
        return run_to(wanted, Pack(T(1)), bound, row, restore);
    }

    /// The same for vectors. What is worth a change is relative to their length.
    Result run_vectors(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Pack wanted[D + 1], longest(T(0));
        wanted[0] = Pack(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            wanted[k + 1] = Pack::load(target[k]) * Pack(T(1) / size_);
            longest = max<T>(longest, abs<T>(wanted[k + 1]));
        }
        return run_to(wanted, longest, bound, row, restore);
    }

private:
    using Pack = detail::Pack<T>;

    /// `wanted`: Σw and Σwĉ. `unit` is what sums are to be accurate relative to.
    Result run_to(const Pack* wanted, const Pack& unit, const Lanes<T>& bound, Lanes<T>* row,
                  bool restore) const {
        // Two roundings of the cage's size are not worth a change: exact zeros on edges would be lost.
        const Pack enough = Pack(4 * epsilon<T>) * unit;
        const Pack treat = Pack::load(bound);
        Pack missing[D + 1], change(T(0));
        Result result;
        Pack least = measure(row, wanted, missing);
        distance(missing).store(result.before);
        for (int round = 0; restore && round < 3; ++round) {
            Pack worst = abs<T>(missing[0]);
            for (std::size_t k = 1; k <= D; ++k) worst = max<T>(worst, abs<T>(missing[k]));
            const Pack apply = select<T>(enough < worst, treat, Pack(T(0)));
            if (!any(apply)) break;
            Pack y[D + 1];
            for (std::size_t r = 0; r <= D; ++r) {
                y[r] = Pack(inverse_[r][0]) * missing[0];
                for (std::size_t c = 1; c <= D; ++c) y[r] = y[r] + Pack(inverse_[r][c]) * missing[c];
                y[r] = y[r] * apply;
            }
            for (std::size_t i = 0; i < columns_.size(); ++i) {
                Pack delta = y[0];
                for (std::size_t k = 0; k < D; ++k) delta = delta + y[k + 1] * Pack(columns_[i][k]);
                change = max<T>(change, abs<T>(delta));
                (Pack::load(row[i]) + delta).store(row[i]);
            }
            least = measure(row, wanted, missing);
        }
        abs<T>(missing[0]).store(result.partition);
        distance(missing).store(result.reproduction);
        change.store(result.change);
        least.store(result.least);
        return result;
    }

    /// What is missing to what is wanted; returns the least weight.
    Pack measure(const Lanes<T>* row, const Pack* wanted, Pack* missing) const {
        for (std::size_t k = 0; k <= D; ++k) missing[k] = wanted[k];
        Pack least = Pack::load(row[0]);
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const Pack w = Pack::load(row[i]);
            least = min<T>(least, w);
            missing[0] = missing[0] - w;
            for (std::size_t k = 0; k < D; ++k) missing[k + 1] = missing[k + 1] - w * Pack(columns_[i][k]);
        }
        return least;
    }

    Pack distance(const Pack* missing) const {
        // Squared in units of the cage: in the caller's the square of a small error may vanish.
        Pack sum(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            const Pack d = missing[k + 1] + Pack(centre_[k] / size_) * missing[0];
            sum = sum + d * d;
        }
        return Pack(size_) * sqrt(sum);
    }

    static bool any(const Pack& flags) {
        Lanes<T> lanes;
        flags.store(lanes);
        T sum = 0;
        for (const T x : lanes.v) sum += x;
        return sum != T(0);
    }

    Vec<T, D> centre_;
    T size_ = 1;
    std::vector<Vec<T, D>> columns_;
    T inverse_[D + 1][D + 1];
};

} // namespace cageform::inline CAGEFORM_ABI::detail
