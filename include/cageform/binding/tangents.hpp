// Computes tangents of normals; binding represents normals by tangents.
#pragma once

#include <cageform/binding/detail/tangent_frame.hpp>
#include <cageform/core/view.hpp>

#include <array>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Returns unit tangents for normals of any length. `bind_vectors` binds them, `clone_normals` converts
/// them back to normals. In 3D there are two per normal, orthogonal, with cross(tangent, bitangent)
/// along the normal. In 2D there is one, the normal rotated clockwise.
///
///   returns  an array of tangents and, in 3D, bitangents; zeros for a zero normal; not finite for a
///            normal that is not finite, so that `bind_vectors` reports it
template <PointRange R>
    requires(range_dimension<R> == 2 || range_dimension<R> == 3)
auto tangents_of(const R& normals) {
    using T = range_scalar_t<R>;
    constexpr std::size_t D = range_dimension<R>;
    std::array<std::vector<Vec<T, D>>, D - 1> result;
    for (auto& tangents : result) tangents.resize(std::size(normals));
    for (std::size_t i = 0; i < std::size(normals); ++i) {
        const auto given = to_vec<double>(normals[i]);
        if (!is_finite(given)) {
            result[0][i] = to_vec<T>(normals[i]);
            continue;
        }
        const auto n = detail::unit_or_zero(given);
        if (dot(n, n) == 0) continue;
        if constexpr (D == 2) {
            result[0][i] = vec_cast<T>(Vec<double, 2>{n[1], -n[0]});
        } else {
            const auto [t, b] = detail::any_tangents(n);
            result[0][i] = vec_cast<T>(t);
            result[1][i] = vec_cast<T>(b);
        }
    }
    return result;
}

/// Returns the given tangents, orthogonalised to the normals and normalised. The bitangents are always
/// cross(normal, tangent). The caller keeps the handedness of the texture (the w of a glTF tangent),
/// which no pose changes.
///
///   tangents  one per normal; a tangent that is zero or along the normal is replaced by an arbitrary one
template <PointRange R, PointRange S>
    requires(range_dimension<R> == 3 && range_dimension<S> == 3)
auto tangents_of(const R& normals, const S& tangents) {
    using T = range_scalar_t<R>;
    CAGEFORM_ASSERT(std::size(tangents) == std::size(normals), "a tangent for every normal");
    auto result = tangents_of(normals);
    for (std::size_t i = 0; i < std::size(normals); ++i) {
        const auto n = detail::unit_or_zero(to_vec<double>(normals[i]));
        const auto given = to_vec<double>(tangents[i]);
        if (!is_finite(n) || dot(n, n) == 0 || !is_finite(given)) continue;
        const auto unit = detail::unit_or_zero(given);
        const auto across = unit - dot(unit, n) * n;
        if (!(dot(across, across) > 1e-12)) continue; // along the normal
        auto t = detail::unit_or_zero(across);
        t = detail::unit_or_zero(t - dot(t, n) * n); // again, because of rounding
        result[0][i] = vec_cast<T>(t);
        result[1][i] = vec_cast<T>(cross(n, t));
    }
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
