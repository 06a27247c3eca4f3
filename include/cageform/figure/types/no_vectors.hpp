// Marks vectors that a figure lacks.
#pragma once

#include <cageform/core/vec.hpp>

#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// Stands for normals or tangents that a figure lacks or that the caller does not want.
struct NoVectors {};

namespace detail {

template <class Range>
inline constexpr bool is_wanted = !std::is_same_v<std::remove_cvref_t<Range>, NoVectors>;

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
