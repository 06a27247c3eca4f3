// Defines the clones of the C interface. clone_view.hpp includes it, unless the program links
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
    const auto with_output = [&](const auto& source, const auto& out, const auto& loop) {
        if (normals == nullptr) return code_of(clone(figure, source, out, loop));
        return with_points<T, D>(*normals, [&](const auto& turned) {
            if (tangents == nullptr) return code_of(clone(figure, source, FigureOutput{out, turned}, loop));
            if constexpr (D == 3) {
                const auto use = [&](const auto& along) {
                    return code_of(clone(figure, source, FigureOutput{out, turned, along}, loop));
                };
                if (tangents->dimension == 4) return with_points<T, 4>(*tangents, use);
                return with_points<T, 3>(*tangents, use);
            } else {
                return cageform_status(CAGEFORM_DIMENSION_DIFFERS);
            }
        });
    };
    return with_points<T, D>(pose, [&](const auto& source) {
        return with_points<T, D>(points, [&](const auto& out) {
            return with_loop(running, [&](const auto& loop) { return with_output(source, out, loop); });
        });
    });
}

template <class T, std::size_t D>
cageform_status clone_view_transposed(const PackedBindingView<T, D>& binding,
                                      const cageform_points& gradients, const cageform_output& handles,
                                      const cageform_running* running) {
    return with_points<T, D>(gradients, [&](const auto& source) {
        return with_points<T, D>(handles, [&](const auto& out) {
            return with_loop(running, [&](const auto& loop) {
                return code_of(clone_transposed(binding, source, out, {}, loop));
            });
        });
    });
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
