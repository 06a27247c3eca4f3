#include "cli/pinned_cage.impl.hpp"

namespace cageform_examples {

template class PinnedCage<double, 2>;

} // namespace cageform_examples
