// The report of binding a figure again to an edited cage.
#pragma once

#include <cageform/binding/types/figure_binding.hpp>

#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The report of `rebind_cage`.
struct CageRebindReport : FigureBindReport {
    /// #handles of the edited cage: the number that each had before, or `new_handle`.
    std::vector<std::size_t> old_handles;
};

/// Marks a handle that did not exist before an edit.
inline constexpr std::size_t new_handle = ~std::size_t{0};

} // namespace cageform::inline CAGEFORM_ABI
