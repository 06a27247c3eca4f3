// BROKEN IN ONE LINE: PointTraits(NotSpecialised| is not specialised)
#include <cageform/clone/clone.hpp>

#include <vector>

#if defined(BROKEN)
struct Pixel {
    float x, y;
};
#else
using Pixel = cageform::Vec<float, 2>;
#endif

cageform::Status move(const cageform::BindingView<float, 2>& binding,
                      cageform::StridedPoints<const float, 2> pose, std::vector<Pixel>& out) {
    return cageform::clone(binding, pose, out);
}
