// Deleted functions whose reason appears in the first line of a compiler error.
#pragma once

#include <cageform/config.hpp>

#if defined(__cpp_deleted_function)
#if defined(__clang__) // clang warns that this is a C++26 extension
#define CAGEFORM_DETAIL_DELETE(reason)                                                                       \
    _Pragma("clang diagnostic push") _Pragma("clang diagnostic ignored \"-Wc++26-extensions\"") delete (     \
        reason)_Pragma("clang diagnostic pop")
#else
#define CAGEFORM_DETAIL_DELETE(reason) delete (reason)
#endif
#else
#define CAGEFORM_DETAIL_DELETE(reason) delete
#endif
#define CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS                                                                \
    CAGEFORM_DETAIL_DELETE("PointTraits is not specialised for these points: core/point.hpp, adapt/")
#define CAGEFORM_DETAIL_DELETE_DIMENSION                                                                     \
    CAGEFORM_DETAIL_DELETE("the points have another dimension than the cage")
#define CAGEFORM_DETAIL_DELETE_NOT_WRITTEN                                                                   \
    CAGEFORM_DETAIL_DELETE("points that cannot be written: they are const, or their PointTraits has no set")

namespace cageform::inline CAGEFORM_ABI::detail {

/// Reasons, named in the signatures of deleted functions, for compilers without `delete("…")`.
struct PointTraitsNotSpecialisedForThesePoints {};
struct PointsOfAnotherDimensionThanTheCage {};
struct PointsThatCannotBeWritten {};
#if defined(__cpp_deleted_function)
template <class Reason, class Result>
using ReasonOr = Result;
#else
template <class Reason, class Result>
using ReasonOr = Reason;
#endif

} // namespace cageform::inline CAGEFORM_ABI::detail
