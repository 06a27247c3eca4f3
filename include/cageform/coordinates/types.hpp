// The list of coordinate types. The programs, the C interface, the bindings and the site take names and facts
// from this list. BlendedCoordinates is not in the list, because it takes several cages.
#pragma once

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/maximum_entropy.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/coordinates/three_point.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI {

// X(name, NAME, cages, handles, outside, "description", how to construct the type)
//
//   name, NAME   the enumerator here, and CAGEFORM_NAME in C. The command line and other languages write
//                "-" in place of "_". Add new types at the end: values are part of the C interface
//   cages        accepted cage_kinds
//   handles      vertices: only vertices are handles; with_normals: edges (2D) or faces (3D) too
//   outside      extended: weights are defined outside the cage; or undefined
//   how          an expression of T, D, `cage` and `options` (CoordinateOptions)
// clang-format off
#define CAGEFORM_COORDINATE_TYPES(X)                                                                         \
    X(mean_value, MEAN_VALUE, polygon | mesh, vertices, extended,                                            \
      "fast; negative weights in concave cages", MeanValueCoordinates(cage))                                 \
    X(harmonic, HARMONIC, polygon | mesh | cells, vertices, undefined,                                       \
      "weights in [0, 1], by a solve on a grid", HarmonicCoordinates(cage, options.harmonic))                \
    X(green, GREEN, polygon | triangles | fans, with_normals, extended,                                      \
      "preserves angles, but does not follow the cage's boundary exactly", GreenCoordinates(cage))           \
    X(sibson, SIBSON, sites, vertices, undefined,                                                            \
      "points without a cage", SibsonCoordinates<T, D>(cage, options.sibson))                                \
    X(barycentric, BARYCENTRIC, polygon | mesh, vertices, extended,                                          \
      "one triangle or tetrahedron", BarycentricCoordinates<T, D>(detail::corners_of(cage)))                 \
    X(wachspress, WACHSPRESS, polygon, vertices, undefined,                                                  \
      "one convex polygon; weights in [0, 1]", WachspressCoordinates<T>(cage))                               \
    X(discrete_harmonic, DISCRETE_HARMONIC, polygon, vertices, undefined,                                    \
      "one convex polygon", DiscreteHarmonicCoordinates<T>(cage))                                            \
    X(splines, SPLINES, lattice, vertices, extended,                                                         \
      "a box of control points", cage)                                                                       \
    X(curved_green, CURVED_GREEN, curves, with_normals, extended,                                            \
      "green for cages of curves, in the plane", CurvedGreenCoordinates<T>(cage, options.curved_green))      \
    X(sibson_c1, SIBSON_C1, sites, vertices, undefined,                                                      \
      "sibson of degree 3: smooth at the points too", SibsonCoordinates<T, D>(cage, options.sibson_c1()))    \
    X(maximum_entropy, MAXIMUM_ENTROPY, polygon | triangles | fans, vertices, undefined,                     \
      "weights in [0, 1], without a grid", MaximumEntropyCoordinates(cage))                                  \
    X(mec_1, MEC_1, polygon, vertices, undefined,                                                            \
      "maximum entropy with the first published prior", MaximumEntropyCoordinates(cage, EntropyPrior::mec1)) \
    X(mec_2, MEC_2, polygon, vertices, undefined,                                                            \
      "maximum entropy with the second published prior", MaximumEntropyCoordinates(cage, EntropyPrior::mec2))
// clang-format on

/// A coordinate type, chosen at run time. See `make_coordinates` in binding/make_coordinates.hpp.
enum class CoordinateType : std::uint8_t {
#define CAGEFORM_DETAIL_TYPE(name, ...) name,
    CAGEFORM_COORDINATE_TYPES(CAGEFORM_DETAIL_TYPE)
#undef CAGEFORM_DETAIL_TYPE
};

/// Kinds of cage, as bit flags.
namespace cage_kinds {
inline constexpr std::uint32_t polygon = 1;
inline constexpr std::uint32_t triangles = 2; ///< TriangleMesh
inline constexpr std::uint32_t fans = 4;      ///< PolyhedralMesh whose faces are fans around their means
inline constexpr std::uint32_t planar_faces =
    8; ///< PolyhedralMesh with planar faces of any number of corners
inline constexpr std::uint32_t mesh = triangles | fans | planar_faces;
inline constexpr std::uint32_t cells = 16;  ///< CellComplex with interior cells
inline constexpr std::uint32_t curves = 32; ///< CurvedPolygon
inline constexpr std::uint32_t lattice = 64;
inline constexpr std::uint32_t sites = 128; ///< PointSet
} // namespace cage_kinds

/// Properties of a coordinate type that do not depend on the cage.
struct CoordinateFacts {
    const char* name;    ///< of the enumerator
    std::uint32_t cages; ///< cage_kinds
    bool with_normals;   ///< edges or faces are handles too
    bool has_extension;  ///< weights are defined outside
    const char* description;
};

/// The facts of all types, in the order of CoordinateType.
inline constexpr auto coordinate_facts = [] {
    using namespace cage_kinds;
    constexpr bool vertices = false, with_normals = true, undefined = false, extended = true;
    return std::array{
#define CAGEFORM_DETAIL_FACTS(name, NAME, cages, handles, outside, description, ...)                         \
    CoordinateFacts{#name, cages, handles, outside, description},
        CAGEFORM_COORDINATE_TYPES(CAGEFORM_DETAIL_FACTS)
#undef CAGEFORM_DETAIL_FACTS
    };
}();

constexpr const CoordinateFacts& facts_of(CoordinateType type) noexcept {
    return coordinate_facts[std::size_t(type)];
}

} // namespace cageform::inline CAGEFORM_ABI
