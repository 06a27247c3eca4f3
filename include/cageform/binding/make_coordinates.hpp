// Makes coordinates whose type is chosen at run time, from the list in coordinates/types.hpp.
#pragma once

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/coordinates/types.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Options of all coordinate types. A type reads its own.
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

namespace detail {

/// The kinds of cage that a class stands for. A lattice is the cage of its own coordinates.
template <class Cage>
inline constexpr std::uint32_t kinds_of = 0;
template <class T>
inline constexpr std::uint32_t kinds_of<Polygon<T>> = cage_kinds::polygon;
template <class T>
inline constexpr std::uint32_t kinds_of<TriangleMesh<T>> = cage_kinds::triangles;
template <class T>
inline constexpr std::uint32_t kinds_of<PolyhedralMesh<T>> = cage_kinds::fans | cage_kinds::planar_faces;
template <class T, std::size_t D> // without cells it is its boundary
inline constexpr std::uint32_t
    kinds_of<CellComplex<T, D>> = cage_kinds::cells | (D == 2 ? cage_kinds::polygon : cage_kinds::triangles);
template <class T>
inline constexpr std::uint32_t kinds_of<CurvedPolygon<T>> = cage_kinds::curves;
template <class T, std::size_t D>
inline constexpr std::uint32_t kinds_of<PointSet<T, D>> = cage_kinds::sites;
template <class T, std::size_t D>
inline constexpr std::uint32_t kinds_of<LatticeCoordinates<T, D>> = cage_kinds::lattice;

/// What barycentric coordinates take of a cage: of a mesh the vertices.
template <class Cage>
decltype(auto) corners_of(const Cage& cage) {
    if constexpr (std::is_constructible_v<BarycentricCoordinates<typename Cage::scalar, Cage::dimension>,
                                          const Cage&>)
        return (cage);
    else
        return cage.vertices();
}

} // namespace detail

/// Makes coordinates of a type chosen at run time.
///
///   cage      Polygon, TriangleMesh, PolyhedralMesh, CellComplex, CurvedPolygon, PointSet or
///             LatticeCoordinates
///
/// Returns empty coordinates if the type does not take this kind of cage (CoordinateFacts::cages); their
/// status is coordinates_empty.
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
        if constexpr (((cages)&detail::kinds_of<Cage>) != 0) {                                               \
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
