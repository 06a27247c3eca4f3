// BROKEN: nodiscard|unused
#include <cageform/clone/clone.hpp>

void move(const cageform::BindingView<float, 2>& binding, cageform::StridedPoints<const float, 2> pose,
          cageform::StridedPoints<float, 2> out) {
#if defined(BROKEN)
    cageform::clone(binding, pose, out);
#else
    (void)cageform::clone(binding, pose, out);
#endif
}
