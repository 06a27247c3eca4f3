#pragma once

// The walk over what a document draws.

#include "svg_document.hpp"

#include <string>
#include <vector>

namespace cageform_examples {

namespace detail {

/// The shapes as they are drawn, of a document that is changed on the way, without changing what it shows: every
/// `use` becomes a group with a copy. Where references are followed, clip paths and masks needed under several
/// transforms are copied, and what they hold is listed too; what is not displayed is then left out.
SvgResult<std::vector<DrawnShape>> collect_shapes(SvgDocument& document, bool follow_references,
                                                  std::vector<std::string>& warnings);

} // namespace detail

} // namespace cageform_examples
