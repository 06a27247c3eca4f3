// Compiles `clone`, so that a debug build of a game plays at the speed of a release.
#include "instantiate.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_transposed.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_CLONE(T, D)                                                                                 \
    CAGEFORM_COMPILE void StridedCloner<BindingView<T, D>>::run(std::size_t, std::size_t) const noexcept;    \
    CAGEFORM_COMPILE void StridedCloner<PackedBindingView<T, D>>::run(std::size_t, std::size_t)              \
        const noexcept;                                                                                      \
    CAGEFORM_COMPILE void StridedTransposed<BindingView<T, D>>::run(                                         \
        StridedPoints<T, D>&, CloneOnto, std::size_t, std::size_t) const noexcept;                           \
    CAGEFORM_COMPILE void StridedTransposed<PackedBindingView<T, D>>::run(                                   \
        StridedPoints<T, D>&, CloneOnto, std::size_t, std::size_t) const noexcept;
CAGEFORM_CLONE(float, 2)
CAGEFORM_CLONE(float, 3)
CAGEFORM_CLONE(double, 2)
CAGEFORM_CLONE(double, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail
