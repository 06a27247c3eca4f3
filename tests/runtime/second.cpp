// A second translation unit: inline functions and templates of the headers may be defined twice.
#include <cageform/clone/clone.hpp>

#include <vector>

bool second_file_agrees(const cageform::BindingView<float, 3>& binding) {
    std::vector<cageform::Vec<float, 3>> out(binding.point_count());
    const cageform::StridedPoints<const float, 3> pose(binding.rest_handles[0].v, binding.handle_count());
    if (cageform::clone(binding, pose, out) != cageform::Status::ok) return false;
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (out[i] != cageform::block_point<3>(binding.rest, i)) return false;
    }
    return true;
}
