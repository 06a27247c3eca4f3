// Compiles `bind`; D = 2 includes D = 1.
#include "instantiate.hpp"

#include <cageform/binding/detail/binders.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_BIND(T, D)                                                                                  \
    CAGEFORM_COMPILE Result<Binding<T, D>, BindReport> bind_points(                                          \
        const BindInput<T, D>&, const BindOptions&, Binding<T, D>&&, const Running&);                        \
    CAGEFORM_COMPILE BindReport bind_vectors_into(std::span<Binding<T, D>>, const BindInput<T, D>&,          \
                                                  std::span<const PointReader<T>>, const BindOptions&,       \
                                                  const Running&);                                           \
    CAGEFORM_COMPILE Result<std::array<Binding<T, D>, D>, BindReport> bind_axes(                             \
        const BindInput<T, D>&, const BindOptions&, const Running&);
CAGEFORM_BIND(CAGEFORM_T, CAGEFORM_D)
CAGEFORM_COMPILE Status bind_read_figure(const BindInput<CAGEFORM_T, CAGEFORM_D>&,
                                         FigureInput<CAGEFORM_T, CAGEFORM_D>&, const BindOptions&,
                                         const Running&,
                                         Result<FigureBinding<CAGEFORM_T, CAGEFORM_D>, FigureBindReport>&);
#if CAGEFORM_D == 2
CAGEFORM_BIND(CAGEFORM_T, 1)
#endif

} // namespace cageform::inline CAGEFORM_ABI::detail
