// Compiles `wrap`.
#include "../instantiate.hpp"

#include <cageform/fit/detail/find_wrap.hpp>
#include <cageform/fit/detail/find_wrap.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_WRAP(T, D)                                                                                  \
    CAGEFORM_COMPILE Status find_wrap(const WrapInput&, const Running&, Result<Wrap<T>, WrapReport>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_WRAP, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail
