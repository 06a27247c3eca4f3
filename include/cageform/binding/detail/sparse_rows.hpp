// The non-zero weights of sites, and the check of two bindings to compose.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/figure/binding.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The non-zero weights of each site for the coarse handles, site after site.
template <Scalar T>
struct SparseRows {
    std::vector<std::size_t> begin; ///< #sites + 1
    std::vector<std::size_t> handle;
    std::vector<double> weight;

    template <std::size_t D>
    explicit SparseRows(const Binding<T, D>& binding) {
        begin.push_back(0);
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            for (std::size_t h = 0; h < binding.handle_count(); ++h) {
                const T w = binding.weight(i, h);
                if (w == T(0)) continue;
                handle.push_back(h);
                weight.push_back(double(w));
            }
            begin.push_back(handle.size());
        }
    }
};

template <Scalar T, std::size_t D>
Status check_compose(const Binding<T, D>& fine, const Binding<T, D>& coarse) noexcept {
    if (fine.handle_view().vector_count() != 0) return Status::handles_not_points;
    if (coarse.point_count() != fine.handle_count()) return Status::bindings_differ;
    for (std::size_t i = 0; i < fine.handle_count(); ++i) {
        if (coarse.rest_point(i) != fine.rest_handle(i)) return Status::bindings_differ;
    }
    return Status::ok;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
