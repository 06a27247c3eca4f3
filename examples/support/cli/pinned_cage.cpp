#include "cli/pinned_cage.impl.hpp"

namespace cageform_support {

template class PinnedCage<double, 2>;

} // namespace cageform_support
