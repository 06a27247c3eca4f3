// Contiguous ranges of numbers; bind time.
#pragma once

#include <cageform/core/vec.hpp>

#include <iterator>
#include <type_traits>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The element type of a contiguous range, const if the range is.
template <class R>
using element_t = std::remove_pointer_t<decltype(std::data(std::declval<R&>()))>;

} // namespace detail

/// A contiguous range of float or double: a vector, an array or a span.
template <class R>
concept ScalarRange = Scalar<std::remove_cv_t<detail::element_t<R>>>;
/// A writable ScalarRange.
template <class R>
concept MutableScalarRange = ScalarRange<R> && !std::is_const_v<detail::element_t<R>>;

} // namespace cageform::inline CAGEFORM_ABI
