// BROKEN IN ONE LINE: PointsOfAnotherDimension|another dimension
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <array>

#if defined(BROKEN)
using Figure = std::array<std::array<double, 3>, 1>;
#else
using Figure = std::array<std::array<double, 2>, 1>;
#endif

cageform::BindReport report_of(const cageform::MeanValueCoordinates<double, 2>& coordinates,
                               const Figure& figure) {
    return cageform::bind(coordinates, figure).report;
}
