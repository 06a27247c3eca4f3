// Declares the products of the gradients of samples.
#pragma once

#include <cageform/parallel/detail/in_parallel.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Adds A Aᵀ to the lower half of a matrix, and something to the upper half of blocks on its diagonal. Both
/// are stored column after column, each column of `rows` numbers, `rows` not 0. Threads take columns of the
/// matrix. `S` is double.
template <class S>
void add_column_products(std::span<S> matrix, std::span<const S> columns, std::size_t rows,
                         const Running& running);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/binding/pose_samples/column_products.impl.hpp>
#endif
