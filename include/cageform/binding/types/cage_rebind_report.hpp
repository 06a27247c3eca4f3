// The report of `rebind_cage`.
#pragma once

#include <cageform/binding/types/figure_binding.hpp>

#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct CageRebindReport : FigureBindReport {
    /// #handles of the edited cage: the old index of each, or `new_handle`.
    std::vector<std::size_t> old_handles;
};

/// The old index of a handle that did not exist before an edit.
inline constexpr std::size_t new_handle = ~std::size_t{0};

} // namespace cageform::inline CAGEFORM_ABI
