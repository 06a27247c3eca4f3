// BROKEN IN ONE LINE: PointsThatCannotBeWritten|cannot be written
#include <cageform/clone/clone.hpp>

#if defined(BROKEN)
using Out = const float;
#else
using Out = float;
#endif

cageform::Status move(const cageform::BindingView<float, 2>& binding,
                      cageform::StridedPoints<const float, 2> pose, cageform::StridedPoints<Out, 2> out) {
    return cageform::clone(binding, pose, out);
}
