// Least-squares fits of leaf models, by the formulas of leaf_models.hpp.
#pragma once

#include <cageform/coordinates/harmonic/leaf_data.hpp>
#include <cageform/coordinates/harmonic/stencil_table.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/buffer.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <string>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Solves a weighted least-squares fit. The share of a datum is its factor in a function's coefficient. Cost:
/// O(#functions² (#functions + #data)).
///
///   width   number of columns computed, at least #functions
///   basis   #data rows: the values of the functions at a datum, padded by zeros
///   weight  #data
///   ridge   #functions
///   shares  out: #functions rows of #data shares, in SIMD blocks padded by zeros
template <std::size_t width, std::size_t most>
void ridge_fit(std::span<const std::array<double, most>> basis, std::span<const double> weight,
               std::span<const double> ridge, Buffer<Lanes<double>>& shares) {
    using X = Simd<double>;
    const std::size_t n = ridge.size(), data = weight.size(), blocks = block_count<double>(data);
    std::array<std::array<double, width>, width>
        matrix;                        // only the upper triangle matters; full rows are faster
    std::array<double, width> inverse; // reciprocals of the diagonal
    for (std::size_t i = 0; i < n; ++i) {
        std::array<double, width> row{};
        row[i] = ridge[i];
        for (std::size_t d = 0; d < data; ++d) {
            const double weighted = weight[d] * basis[d][i];
            for (std::size_t j = 0; j < width; ++j) row[j] += weighted * basis[d][j];
        }
        matrix[i] = row;
    }
    for (std::size_t k = 0; k < n; ++k) { // Cholesky, in place
        inverse[k] = 1 / std::sqrt(matrix[k][k]);
        for (double& x : matrix[k]) x *= inverse[k];
        for (std::size_t i = k + 1; i < n; ++i) {
            const double factor = matrix[k][i];
            for (std::size_t j = 0; j < width; ++j) matrix[i][j] -= factor * matrix[k][j];
        }
    }
    shares.resize(n * blocks);
    for (std::size_t b = 0; b < blocks; ++b) {
        std::array<X, width> x;
        for (std::size_t i = 0; i < n; ++i) {
            Lanes<double> weighted;
            for (std::size_t lane = 0; lane < lane_count<double>; ++lane) {
                const std::size_t d = b * lane_count<double> + lane;
                weighted[lane] = d < data ? weight[d] * basis[d][i] : 0;
            }
            x[i] = X::load(weighted);
        }
        for (std::size_t k = 0; k < n; ++k) {
            x[k] *= X(inverse[k]);
            for (std::size_t i = k + 1; i < n; ++i) x[i] -= X(matrix[k][i]) * x[k];
        }
        for (std::size_t k = n; k-- > 0;) {
            x[k] *= X(inverse[k]);
            for (std::size_t i = 0; i < k; ++i) x[i] -= X(matrix[i][k]) * x[k];
            x[k].store(shares[k * blocks + b]);
        }
    }
}

/// Fits models, one at a time, and evaluates them.
template <class Model>
class ModelFit {
    using Point = typename Model::Point;
    using Values = typename Model::Values;
    using X = Simd<double>;

public:
    using Handle = typename StencilTable<Model::D>::Handle;

    ///   degree  the largest degree of polynomials, at most Model::degree
    ModelFit(const typename Model::Field&, unsigned degree)
        : degree_(degree) {}

    /// Fits a model for evaluation at `points`.
    ///
    ///   is_screened  see LeafModel::values
    void set(const Model& model, std::span<const Point>, bool is_screened = true) {
        model_ = &model;
        is_screened_ = is_screened;
        blocks_ = block_count<double>(model.data().size());
        shares_ = model.is_near() ? &fitted(own_shares_) : &fitted_by_pattern();
    }
    /// Appends the shares in a sum of the model's values at points, multiplied by factors.
    ///
    ///   first     the index of points[0] in the points of `set`
    ///   shares    out: appends one share per datum
    ///   vertices  out: appends shares of vertices that do not come from data
    void add(std::span<const Point> points, std::span<const double> factors, std::size_t /*first*/,
             Buffer<double>& shares, Buffer<Handle>& /*vertices*/) {
        const auto data = model_->data();
        Values sum{};
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Values values = model_->values(points[n], is_screened_);
            for (std::size_t k = 0; k < values.size(); ++k) sum[k] += factors[n] * values[k];
        }
        row_.resize(blocks_);
        for (std::size_t b = 0; b < blocks_; ++b) {
            X row(0.0);
            for (std::size_t k = 0; k < model_->functions(); ++k)
                row = multiply_add(X(sum[k]), X::load((*shares_)[k * blocks_ + b]), row);
            row.store(row_[b]);
        }
        for (std::size_t d = 0; d < data.size(); ++d)
            shares.push_back(row_[d / lane_count<double>][d % lane_count<double>]);
    }

protected:
    /// The shares of data in the functions' coefficients, from ridge_fit.
    using Shares = Buffer<Lanes<double>>;

    const Model& model() const noexcept { return *model_; }
    const Shares& row() const noexcept { return row_; } ///< the shares of the data in the latest sum

private:
    /// Returns the shares of a model far from faces, which depend only on the offsets of the data.
    const Shares& fitted_by_pattern() {
        pattern_.clear();
        for (const auto& datum : model_->data()) {
            const auto place = model_->place_in_leaf(datum);
            pattern_.append(place.begin(), place.end());
        }
        if (is_screened_ && model_->screening() > 0) pattern_ += std::to_string(model_->size());
        const auto [known, is_new] = patterns_.try_emplace(pattern_);
        return is_new ? fitted(known->second) : known->second;
    }
    const Shares& fitted(Shares& shares) {
        const auto data = model_->data();
        basis_.resize(data.size());
        weight_.resize(data.size());
        double trace = 0;
        for (std::size_t d = 0; d < data.size(); ++d) {
            basis_[d] = model_->values(data[d].at, is_screened_);
            weight_[d] = data[d].weight;
            trace += data[d].weight;
        }
        const double damping = model_->is_near() ? trace : 1e-4 * trace;
        Values ridges{};
        for (std::size_t k = 0; k < ridges.size(); ++k) {
            constexpr double excludes = 1e8;
            const double ridge = Model::degree_of(k) > degree_ ? excludes : Model::ridge(k);
            ridges[k] = k <= Model::D ? 1e-13 * trace : ridge * damping;
        }
        const std::span<const Values> basis(basis_);
        const auto ridge = std::span<const double>(ridges).first(model_->functions());
        if (ridge.size() == Model::polynomials) {
            ridge_fit<Model::polynomials>(basis, weight_, ridge, shares);
        } else {
            ridge_fit<Model::most_functions>(basis, weight_, ridge, shares);
        }
        return shares;
    }

    unsigned degree_;
    bool is_screened_ = true;
    const Model* model_ = nullptr;
    std::size_t blocks_ = 0; ///< SIMD blocks of data
    const Shares* shares_ = nullptr;
    Shares own_shares_;
    std::map<std::string, Shares> patterns_; ///< by the offsets of data, for leaves far from faces
    std::string pattern_;
    std::vector<Values> basis_;
    std::vector<double> weight_;
    Shares row_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
