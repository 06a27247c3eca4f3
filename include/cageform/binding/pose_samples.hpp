// Samples the interior of a cage for a PoseSolver. Bind time.
#pragma once

#include <cageform/binding/pose_samples/pose_sampler.hpp>
#include <cageform/pose/types/pose_blob.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Samples the interior of a cage on a lattice, clusters the samples, and computes the sums that a
/// PoseSolver needs.
///
///   coordinates  any with gradients; AnyCoordinates keep solved functions after the call
///   returns      the samples, empty unless the status is ok, and a report
///   cost         that of `bind_jacobians` at the samples, and #samples D #handles² operations. A solver
///                solves once and keeps its functions during the call. O(#handles²) memory, and the
///                samples
///   fails        as the cage's check and the coordinates; samples_missing (no sample is inside or has
///                gradients); too_many_handles (more than 4,096); value_not_finite (an option);
///                gradients_not_supported (AnyCoordinates); cancelled; out_of_memory
template <detail::SampledCoordinates C>
Result<PoseSamples<typename C::scalar, C::dimension>, PoseSamplesReport>
pose_samples(const C& coordinates, const PoseSampleOptions& options = {}, const Running& running = {}) {
    return detail::make_pose_samples(coordinates, nullptr, options, running);
}

/// Uses given points as samples, for example those of a figure. Points that are not finite or have no
/// gradients are ignored and counted in the report.
template <detail::SampledCoordinates C, PointRangeIn<C::dimension> R>
Result<PoseSamples<typename C::scalar, C::dimension>, PoseSamplesReport>
pose_samples(const C& coordinates, const R& points, const PoseSampleOptions& options = {},
             const Running& running = {}) {
    using T = typename C::scalar;
    std::vector<Vec<T, C::dimension>> given;
    const Status status = detail::guard_memory([&] {
        given.reserve(std::size(points));
        for (std::size_t n = 0; n < std::size(points); ++n) given.push_back(to_vec<T>(points[n]));
    });
    if (status == Status::ok) return detail::make_pose_samples(coordinates, &given, options, running);
    Result<PoseSamples<T, C::dimension>, PoseSamplesReport> refused;
    refused.report.status = status;
    return refused;
}

} // namespace cageform::inline CAGEFORM_ABI
