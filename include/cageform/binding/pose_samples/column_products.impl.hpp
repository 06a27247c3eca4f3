// Products of the gradients of samples, by Eigen.
#pragma once

#include <cageform/binding/pose_samples/column_products.hpp>

#include <Eigen/Core>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class S>
void add_column_products(std::span<S> matrix, std::span<const S> columns, std::size_t rows,
                         const Running& running) {
    using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
    constexpr Eigen::Index panel = 64;
    const auto size = Eigen::Index(rows);
    Eigen::Map<Matrix> sums(matrix.data(), size, size);
    const Eigen::Map<const Matrix> factor(columns.data(), size, Eigen::Index(columns.size() / rows));
    in_parallel(running, std::size_t((size + panel - 1) / panel), 1, [&](std::size_t begin, std::size_t end) {
        for (auto n = Eigen::Index(begin); n < Eigen::Index(end); ++n) {
            const Eigen::Index first = n * panel, width = (std::min)(panel, size - first);
            sums.block(first, first, size - first, width).noalias() +=
                factor.bottomRows(size - first) * factor.middleRows(first, width).transpose();
        }
    });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
