// Compiles the coordinates of the C interface.
#include "../instantiate.hpp"

#include <cageform/c/detail/cages.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

template cageform_status coordinates_of(const cageform_cage&, const cageform_coordinates_options&,
                                        AnyCoordinates<CAGEFORM_T, CAGEFORM_D>&);
template cageform_status blend_of(std::span<const cageform_cage* const>, const cageform_coordinates_options&,
                                  AnyCoordinates<CAGEFORM_T, CAGEFORM_D>&, std::size_t&);
template cageform_status check_cage<CAGEFORM_T, CAGEFORM_D>(const cageform_cage&, CageReport&);

} // namespace cageform::inline CAGEFORM_ABI::detail::c
