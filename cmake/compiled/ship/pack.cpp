// Compiles `pack`.
#include "../instantiate.hpp"

#include <cageform/binding/detail/figure_packer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_PACK(T, D)                                                                                  \
    CAGEFORM_COMPILE Result<PackedBinding<T, D>, PackReport> pack_binding(                                   \
        const BindingView<T, D>&, const PackOptions&, const Running&, std::span<const char>);                \
    CAGEFORM_COMPILE Status pack_parts(const FigureBinding<T, D>&, const FigurePackOptions&, const Running&, \
                                       Result<PackedFigure<T, D>, FigurePackReport>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_PACK, 2)
CAGEFORM_FOR_SCALARS(CAGEFORM_PACK, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail
