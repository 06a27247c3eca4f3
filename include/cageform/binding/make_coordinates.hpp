// Makes coordinates of a type that is chosen at run time (list: coordinates/types.hpp).
#pragma once

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/binding/detail/kinds_of.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Options of all coordinate types; a type uses only its own.
template <Scalar T>
struct CoordinateOptions {
    HarmonicOptions harmonic{};
    SibsonOptions sibson{};
    CurvedGreenOptions<T> curved_green{};

    SibsonOptions sibson_c1() const {
        SibsonOptions smooth = sibson;
        smooth.degree = 3;
        return smooth;
    }
};

/// Makes coordinates of a type chosen at run time.
///
///   cage      Polygon, TriangleMesh, PolyhedralMesh, CellComplex, CurvedPolygon, PointSet or
///             LatticeCoordinates
///
/// Returns empty coordinates (status coordinates_empty) if the type does not support the kind of the
/// cage (CoordinateFacts::cages).
template <class Cage>
auto make_coordinates(CoordinateType type, const Cage& cage,
                      [[maybe_unused]] const CoordinateOptions<typename Cage::scalar>& options = {})
    -> AnyCoordinates<typename Cage::scalar, Cage::dimension> {
    using namespace cage_kinds;
    using T [[maybe_unused]] = typename Cage::scalar;
    [[maybe_unused]] constexpr std::size_t D = Cage::dimension;
    constexpr bool undefined = false, extended = true;
    switch (type) {
#define CAGEFORM_DETAIL_MAKE(name, NAME, cages, handles, outside, description, ...)                          \
    case CoordinateType::name:                                                                               \
        if constexpr (((cages) & detail::kinds_of<Cage>) != 0) {                                             \
            static_assert(std::remove_cvref_t<decltype(__VA_ARGS__)>::has_extension == outside);             \
            return __VA_ARGS__;                                                                              \
        }                                                                                                    \
        break;
        CAGEFORM_COORDINATE_TYPES(CAGEFORM_DETAIL_MAKE)
#undef CAGEFORM_DETAIL_MAKE
    }
    return {};
}

} // namespace cageform::inline CAGEFORM_ABI
