// Reads and writes any point type through one trait, PointTraits.
//
// A user's type needs five lines:
//
//     template <> struct cageform::PointTraits<my::vec3> {
//         using scalar = float;
//         static constexpr std::size_t dimension = 3;
//         static constexpr scalar get(const my::vec3& p, std::size_t k) noexcept { return p[k]; }
//         static constexpr void set(my::vec3& p, std::size_t k, scalar x) noexcept { p[k] = x; }
//     };
//
// `set` is needed only for types that are written to (the output of `clone`).
#pragma once

#include <cageform/core/detail/indexed_point_traits.hpp>
#include <cageform/core/vec.hpp>

#include <array>
#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// Deliberately undefined: a type without a specialisation is not a Point.
template <class P>
struct PointTraits;

/// A type whose components can be read.
template <class P>
concept Point = requires(const P& p, std::size_t axis) {
    typename PointTraits<P>::scalar;
    requires std::is_arithmetic_v<typename PointTraits<P>::scalar>;
    requires PointTraits<P>::dimension >= 1;
    { PointTraits<P>::get(p, axis) } -> std::same_as<typename PointTraits<P>::scalar>;
};

/// A Point whose components can be set and are floating-point numbers.
template <class P>
concept MutablePoint =
    Point<P> && std::floating_point<typename PointTraits<P>::scalar> &&
    requires(P& p, std::size_t axis) { PointTraits<P>::set(p, axis, typename PointTraits<P>::scalar{}); };

template <class T, std::size_t D>
struct PointTraits<Vec<T, D>> : detail::IndexedPointTraits<Vec<T, D>, T, D> {};
template <class T, std::size_t D>
struct PointTraits<std::array<T, D>> : detail::IndexedPointTraits<std::array<T, D>, T, D> {};
template <class T, std::size_t D>
struct PointTraits<T[D]> : detail::IndexedPointTraits<T[D], T, D> {};

/// Converts a user's point to the library's vector with scalar `T`.
template <class T, Point P>
constexpr Vec<T, PointTraits<P>::dimension> to_vec(const P& p) noexcept {
    Vec<T, PointTraits<P>::dimension> r{};
    for (std::size_t k = 0; k < PointTraits<P>::dimension; ++k) {
        r.v[k] = static_cast<T>(PointTraits<P>::get(p, k));
    }
    return r;
}

} // namespace cageform::inline CAGEFORM_ABI
