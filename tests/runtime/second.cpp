// A second translation unit: inline functions and templates of the headers may be defined twice.
#include <cageform/clip/clip.hpp>
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

/// A clip of one vertex that goes from (0, 0) to (1, 2) in a second.
bool clip_plays() {
    std::vector<cageform::PiecewiseCubic<float>> curves;
    curves.push_back({{{0.0f, 0.0f, 1.0f, 0.0f, 0.0f}}, 1.0f});
    curves.push_back({{{0.0f, 0.0f, 2.0f, 0.0f, 0.0f}}, 1.0f});
    const cageform::CageClip<float, 2> clip(curves, cageform::Extrapolation::cycle,
                                            cageform::Extrapolation::cycle);
    auto cursor = clip.make_cursor();
    std::vector<cageform::Vec<float, 2>> pose(clip.vertex_count());
    clip.sample(1.25f, cursor, pose);
    return pose[0] == cageform::Vec<float, 2>{0.25f, 0.5f};
}
