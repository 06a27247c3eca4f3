// Compiles the coordinates of the C interface.
#include "../instantiate.hpp"

#include <cageform/c/detail/cages.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

#define CAGEFORM_C_COORDINATES(T, D)                                                                         \
    template cageform_status coordinates_of(const cageform_cage&, const cageform_coordinates_options&,       \
                                            AnyCoordinates<T, D>&);                                          \
    template cageform_status blend_of(std::span<const cageform_cage* const>,                                 \
                                      const cageform_coordinates_options&, AnyCoordinates<T, D>&,            \
                                      std::size_t&);                                                         \
    template cageform_status check_cage<T, D>(const cageform_cage&, CageReport&);
CAGEFORM_FOR_SCALARS(CAGEFORM_C_COORDINATES, 2)
CAGEFORM_FOR_SCALARS(CAGEFORM_C_COORDINATES, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail::c
