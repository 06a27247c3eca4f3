// Compiles the functions of the C interface for figures, clips and samples.
#include "../instantiate.hpp"

#include <cageform/c/detail/clone_view.impl.hpp>
#include <cageform/c/detail/figures.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

#define CAGEFORM_C_FIGURES(T, D)                                                                             \
    template cageform_status clone_view(const PackedFigureView<T, D>&, const cageform_points&,               \
                                        const cageform_output&, const cageform_output*,                      \
                                        const cageform_output*, const cageform_running*);                    \
    template cageform_status clone_view_transposed(const PackedBindingView<T, D>&, const cageform_points&,   \
                                                   const cageform_output&, const cageform_running*);         \
    template cageform_status bind_copied(const AnyCoordinates<T, D>&, const std::vector<Vec<T, D>>&,         \
                                         const cageform_points*, const cageform_points*, const BindOptions&, \
                                         const Running&, Result<FigureBinding<T, D>, FigureBindReport>&);    \
    template cageform_status pack_figure(const FigureBinding<T, D>&, const cageform_pack_options&,           \
                                         const Running&, cageform_bytes**, cageform_report&);                \
    template cageform_status compile_poses(const double*, std::size_t, const std::vector<Vec<T, D>>&,        \
                                           const cageform_clip_options&, const Running&, cageform_bytes**,   \
                                           cageform_report&);                                                \
    template cageform_status sample_cage(const AnyCoordinates<T, D>&, const PoseSampleOptions&,              \
                                         const Running&, cageform_samples&, cageform_report&);               \
    template cageform_status pack_samples(const PoseSamples<T, D>&, cageform_bytes**, cageform_report&);
CAGEFORM_FOR_SCALARS(CAGEFORM_C_FIGURES, 2)
CAGEFORM_FOR_SCALARS(CAGEFORM_C_FIGURES, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail::c
