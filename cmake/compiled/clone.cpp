// Compiles `clone`, so that debug builds play at release speed.
#include "instantiate.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_transposed.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_CLONE(View, T, D)                                                                           \
    CAGEFORM_COMPILE void StridedCloner<View<T, D>>::run(std::size_t, std::size_t) const noexcept;           \
    CAGEFORM_COMPILE void StridedTransposed<View<T, D>>::run(StridedPoints<T, D>&, CloneMode, std::size_t,   \
                                                             std::size_t) const noexcept;
#define CAGEFORM_CLONES(T, D) CAGEFORM_CLONE(BindingView, T, D) CAGEFORM_CLONE(PackedBindingView, T, D)
CAGEFORM_FOR_SCALARS(CAGEFORM_CLONES, CAGEFORM_D)

} // namespace cageform::inline CAGEFORM_ABI::detail
