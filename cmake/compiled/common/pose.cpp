// Compiles the products of PoseSamples.
#include "../instantiate.hpp"

#include <cageform/binding/pose_samples/column_products.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

CAGEFORM_COMPILE void add_column_products(std::span<double>, std::span<const double>, std::size_t,
                                          const Running&);

} // namespace cageform::inline CAGEFORM_ABI::detail
