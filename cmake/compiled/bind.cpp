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
#define CAGEFORM_BIND_FIGURE(T, D)                                                                           \
    CAGEFORM_BIND(T, D)                                                                                      \
    CAGEFORM_COMPILE Status bind_read_figure(const BindInput<T, D>&, FigureInput<T, D>&, const BindOptions&, \
                                             const Running&,                                                 \
                                             Result<FigureBinding<T, D>, FigureBindReport>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_BIND_FIGURE, CAGEFORM_D)
#if CAGEFORM_D == 2
CAGEFORM_FOR_SCALARS(CAGEFORM_BIND, 1)
#endif

} // namespace cageform::inline CAGEFORM_ABI::detail
