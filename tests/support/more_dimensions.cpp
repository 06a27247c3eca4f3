// Compiles what tests need in dimensions that the compiled library has not.
#include <cageform/binding/detail/binders.impl.hpp>
#include <cageform/binding/detail/figure_packer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template Result<Binding<double, 4>, BindReport> bind_points(const BindInput<double, 4>&, const BindOptions&,
                                                            Binding<double, 4>&&, const Running&);
template Result<PackedBinding<float, 1>, PackReport>
pack_binding(const BindingView<float, 1>&, const PackOptions&, const Running&, std::span<const char>);
template Result<PackedBinding<double, 1>, PackReport>
pack_binding(const BindingView<double, 1>&, const PackOptions&, const Running&, std::span<const char>);

} // namespace cageform::inline CAGEFORM_ABI::detail
