// A placeholder for absent normals or tangents.
#pragma once

#include <cageform/core/vec.hpp>

#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// Passed instead of normals or tangents that are absent or not wanted.
struct NoVectors {};

namespace detail {

template <class Range>
inline constexpr bool is_wanted = !std::is_same_v<std::remove_cvref_t<Range>, NoVectors>;

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
