#include "cli/coordinates_2d.hpp"

namespace cageform_support {

template ChosenCoordinates<double, 2> make_coordinates(const CoordinatesChoice&, const CageFile&);
template ChosenCoordinates<double, 2> make_coordinates(const CoordinatesChoice&, const SiteFile<2>&);

} // namespace cageform_support
