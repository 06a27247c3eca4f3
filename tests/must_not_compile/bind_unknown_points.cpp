// BROKEN IN ONE LINE: PointTraits(NotSpecialised| is not specialised)
#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <vector>

#if defined(BROKEN)
struct Pixel {
    double x, y;
};
#else
using Pixel = cageform::Vec<double, 2>;
#endif

cageform::BindReport report_of(const cageform::MeanValueCoordinates<double, 2>& coordinates,
                               const std::vector<Pixel>& figure) {
    return cageform::bind(coordinates, figure).report;
}
