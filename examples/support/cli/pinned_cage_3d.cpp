#include "cli/pinned_cage.impl.hpp"

namespace cageform_support {

template class PinnedCage<double, 3>;

} // namespace cageform_support
