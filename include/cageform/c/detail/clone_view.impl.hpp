// Defines the functions of clone_view.hpp. That header includes this file, unless the program links
// cageform::compiled.
#pragma once

#include <cageform/c/detail/clone_view.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/clone/clone_transposed.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

template <class T, std::size_t D>
cageform_status clone_view(const PackedFigureView<T, D>& figure, const cageform_points& pose,
                           const cageform_output& points, const cageform_output* normals,
                           const cageform_output* tangents, const cageform_running* running) {
    cageform_status status = CAGEFORM_OK;
    const auto source = view_of<T, D>(pose, status);
    const auto out = view_of<T, D>(points, status);
    cageform_running own;
    if (status == CAGEFORM_OK) status = read_struct(running, own);
    if (status != CAGEFORM_OK) return status;
    const CallersFor loop{own};
    if (normals == nullptr) return code_of(clone(figure, source, out, loop));
    const auto turned = view_of<T, D>(*normals, status);
    if (status != CAGEFORM_OK) return status;
    if (tangents == nullptr) return code_of(clone(figure, source, FigureOutput{out, turned}, loop));
    if constexpr (D == 3) {
        const auto clone_all = [&](const auto& along) {
            return status != CAGEFORM_OK
                       ? status
                       : code_of(clone(figure, source, FigureOutput{out, turned, along}, loop));
        };
        return tangents->dimension == 4 ? clone_all(view_of<T, 4>(*tangents, status))
                                        : clone_all(view_of<T, 3>(*tangents, status));
    }
    return CAGEFORM_DIMENSION_DIFFERS;
}

template <class T, std::size_t D>
cageform_status clone_view_transposed(const PackedBindingView<T, D>& binding,
                                      const cageform_points& gradients, const cageform_output& handles,
                                      const cageform_running* running) {
    cageform_status status = CAGEFORM_OK;
    const auto source = view_of<T, D>(gradients, status);
    const auto out = view_of<T, D>(handles, status);
    cageform_running own;
    if (status == CAGEFORM_OK) status = read_struct(running, own);
    if (status != CAGEFORM_OK) return status;
    return code_of(clone_transposed(binding, source, out, {}, CallersFor{own}));
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
