// Declares the functions of figures, clips and samples in the C interface, per scalar and dimension.
#pragma once

#include <cageform/binding/types/pose_sample_options.hpp>
#include <cageform/c/detail/cages.hpp>
#include <cageform/c/detail/pins.hpp>

#include <memory>

struct cageform_bytes : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::bytes;

    std::shared_ptr<const void> owner;
    std::span<const std::byte> bytes;
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Binds copied points, and normals and tangents if given.
template <class T, std::size_t D>
cageform_status bind_copied(const AnyCoordinates<T, D>& coordinates, const std::vector<Vec<T, D>>& points,
                            const cageform_points* normals, const cageform_points* tangents,
                            const BindOptions& options, const Running& running,
                            Result<FigureBinding<T, D>, FigureBindReport>& result);

template <class T, std::size_t D>
cageform_status pack_figure(const FigureBinding<T, D>& figure, const cageform_pack_options& options,
                            const Running& running, cageform_bytes** packed, cageform_report& report);

template <class T, std::size_t D>
cageform_status compile_poses(const double* times, std::size_t count, const std::vector<Vec<T, D>>& poses,
                              const cageform_clip_options& options, const Running& running,
                              cageform_bytes** clip, cageform_report& report);

template <class T, std::size_t D>
cageform_status sample_cage(const AnyCoordinates<T, D>& coordinates, const PoseSampleOptions& options,
                            const Running& running, cageform_samples& samples, cageform_report& report);
template <class T, std::size_t D>
cageform_status pack_samples(const PoseSamples<T, D>& samples, cageform_bytes** packed,
                             cageform_report& report);

} // namespace cageform::inline CAGEFORM_ABI::detail::c

#if !defined(CAGEFORM_COMPILED)
#include <cageform/c/detail/figures.impl.hpp>
#endif
