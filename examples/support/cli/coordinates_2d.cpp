#include "cli/coordinates_model.hpp"

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/three_point.hpp>

namespace cageform_examples {

template <class T>
ChosenCoordinates<T, 2> make_coordinates(const CoordinatesChoice& choice, const CageFile& file) {
    if (file.lattice) return lattice_coordinates<T>(choice, *file.lattice);
    return file.visit<T>([&](const auto& cage) -> ChosenCoordinates<T, 2> {
        if (choice.name == "harmonic") {
            using Cage = std::remove_cvref_t<decltype(cage)>;
            return Harmonic<Cage>(cage, choice.harmonic_options(2));
        }
        if (choice.name == "mean-value") return cageform::MeanValueCoordinates<T, 2>(cage);
        if (choice.name == "green") return cageform::GreenCoordinates<T, 2>(cage);
        if (choice.name == "wachspress") return cageform::WachspressCoordinates<T>(cage);
        if (choice.name == "discrete-harmonic") return cageform::DiscreteHarmonicCoordinates<T>(cage);
        return cageform::BarycentricCoordinates<T, 2>(cage);
    });
}
template ChosenCoordinates<float, 2> make_coordinates(const CoordinatesChoice&, const CageFile&);
template ChosenCoordinates<double, 2> make_coordinates(const CoordinatesChoice&, const CageFile&);

} // namespace cageform_examples
