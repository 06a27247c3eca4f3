// BROKEN IN ONE LINE: PointTraits(NotSpecialised| is not specialised)
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <array>
#include <vector>

#if defined(BROKEN)
struct Pixel {
    double v[3];
};
#else
using Pixel = std::array<double, 3>;
#endif

using Faces = std::vector<std::array<std::uint32_t, 3>>;

cageform::CageReport report_of(const std::vector<Pixel>& vertices, const Faces& faces) {
    return cageform::MeanValueCoordinates<double, 3>(vertices, faces).cage_report();
}
cageform::CageReport report_of_another(const std::vector<Pixel>& vertices, const Faces& faces) {
    return cageform::HarmonicCoordinates<double, 3>(vertices, faces).cage_report();
}
