#include "cli/coordinates_2d.hpp"

namespace cageform_support {

template ChosenCoordinates<float, 2> make_coordinates(const CoordinatesChoice&, const CageFile&);
template ChosenCoordinates<float, 2> make_coordinates(const CoordinatesChoice&, const SiteFile<2>&);

} // namespace cageform_support
