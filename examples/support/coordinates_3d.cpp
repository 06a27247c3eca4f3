#include "coordinates_model.hpp"

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/green_3d.hpp>
#include <cageform/coordinates/mean_value_3d.hpp>
#include <cageform/coordinates/pyramid_solver.hpp>

namespace cageform_examples {

namespace {

template <class T>
using Harmonic = cageform::HarmonicCoordinates<T, 3, cageform::TriangleMesh<T>,
                                               cageform::WithAveragingPyramid<cageform::TriangleMesh<T>>>;

} // namespace

template <class T>
std::unique_ptr<AnyCoordinates<T, 3>> make_coordinates(const CoordinatesChoice& choice, const ObjFile& file) {
    const cageform::TriangleMesh<T> cage(file.vertices, file.triangles);
    if (choice.name == "harmonic") return model_of(Harmonic<T>(cage, choice.harmonic_options(3)));
    if (choice.name == "mean-value") return model_of(cageform::MeanValueCoordinates<T, 3>(cage));
    if (choice.name == "green") return model_of(cageform::GreenCoordinates<T, 3>(cage));
    return model_of(cageform::BarycentricCoordinates<T, 3>(cage.vertices()));
}
template std::unique_ptr<AnyCoordinates<float, 3>> make_coordinates(const CoordinatesChoice&, const ObjFile&);
template std::unique_ptr<AnyCoordinates<double, 3>> make_coordinates(const CoordinatesChoice&,
                                                                     const ObjFile&);

cageform::FigureBindResult<float, 3>
bind_figure(const AnyCoordinates<float, 3>& coordinates,
            const cageform::FigurePoints<const std::vector<Point3>&, const std::vector<Point3>&>& figure,
            const cageform::BindOptions& options, const cageform::Running& running) {
    using HarmonicModel = CoordinatesModel<Harmonic<float>>;
    using MeanValue = CoordinatesModel<cageform::MeanValueCoordinates<float, 3>>;
    if (const auto* harmonic = dynamic_cast<const HarmonicModel*>(&coordinates))
        return cageform::bind_figure(harmonic->own, figure, options, running);
    return cageform::bind_figure(dynamic_cast<const MeanValue&>(coordinates).own, figure, options, running);
}

} // namespace cageform_examples
