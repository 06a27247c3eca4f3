#include "cli/coordinates_model.hpp"

#include <cageform/coordinates/sibson.hpp>

namespace cageform_examples {

template <class T, std::size_t D>
ChosenCoordinates<T, D> make_coordinates(const CoordinatesChoice& choice, const SiteFile<D>& sites) {
    cageform::SibsonOptions options{.degree = choice.name == "sibson-c1" ? 3 : 1};
    if (choice.gradients == "gentle") options.gradients = cageform::SiteGradients::gentle;
    if (choice.gradients == "mirrored") options.gradients = cageform::SiteGradients::mirrored;
    ChosenCoordinates<T, D> made = cageform::SibsonCoordinates<T, D>(sites.points, options);
    made.takes_sites = true;
    return made;
}
template ChosenCoordinates<float, 2> make_coordinates(const CoordinatesChoice&, const SiteFile<2>&);
template ChosenCoordinates<double, 2> make_coordinates(const CoordinatesChoice&, const SiteFile<2>&);
template ChosenCoordinates<float, 3> make_coordinates(const CoordinatesChoice&, const SiteFile<3>&);
template ChosenCoordinates<double, 3> make_coordinates(const CoordinatesChoice&, const SiteFile<3>&);

} // namespace cageform_examples
