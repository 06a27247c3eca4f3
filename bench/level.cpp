// One shared object per compiler and optimisation level (bench/run.sh), measured in turns by
// bench/levels.cpp. In one program, functions of equal name would be merged.
#include "level.hpp"

namespace cageform_bench {
namespace {

template <class T>
constexpr Level::Of<T> clones() noexcept {
    return {
        .plane = [](const auto& binding, auto pose, auto out) { return clone(binding, pose, out); },
        .space = [](const auto& binding, auto pose, auto out) { return clone(binding, pose, out); },
        .packed = [](const auto& binding, auto pose, auto out) { return clone(binding, pose, out); },
        .figure =
            [](const auto& figure, auto pose, auto points, auto normals, auto tangents) {
                return clone(figure, pose, cageform::FigureOutput{points, normals, tangents});
            },
        .normals = [](const auto& tangents, auto pose,
                      auto out) { return clone_normals(tangents, pose, out); },
        .jacobians = [](const auto& axes, auto pose,
                        const auto& out) { return clone_jacobians(axes, pose, out); },
    };
}

} // namespace
} // namespace cageform_bench

extern "C" __attribute__((visibility("default"))) const cageform_bench::Level cageform_level;
const cageform_bench::Level cageform_level{cageform_bench::clones<float>(), cageform_bench::clones<double>()};
