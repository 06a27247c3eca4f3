#include "cli/pinned_cage.impl.hpp"

namespace cageform_examples {

template class PinnedCage<double, 3>;

} // namespace cageform_examples
