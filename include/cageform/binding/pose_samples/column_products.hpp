// Declares the products of the gradients of samples.
#pragma once

#include <cageform/parallel/detail/in_parallel.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Adds A Aᵀ to the lower triangle of a matrix; blocks on the diagonal also change the upper triangle. Both
/// matrices are stored by columns of `rows` > 0 numbers. Parallel over columns of the matrix. `S` is double.
template <class S>
void add_column_products(std::span<S> matrix, std::span<const S> columns, std::size_t rows,
                         const Running& running);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/binding/pose_samples/column_products.impl.hpp>
#endif
