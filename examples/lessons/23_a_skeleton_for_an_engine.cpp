// 23. A skeleton for an engine: bones fitted to the motion of a cage, four weights per vertex, a hierarchy.
#include <cageform/cageform.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

#include <cstdio>

int main() {
    using Points = std::vector<cageform::Vec<double, 3>>;
    const auto cage = cageform::box_mesh<double>({-1, -1, 0}, {1, 1, 4}, {2, 2, 4});
    Points column; // 16 rings of 12 vertices
    std::vector<std::array<std::size_t, 3>> faces;
    for (std::size_t n = 0; n < 16 * 12; ++n) {
        const std::size_t ring = n / 12, below = n - 12, next = n % 12 == 11 ? n - 11 : n + 1;
        const double angle = 6.283185307179586 / 12 * double(n);
        column.push_back({0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.125 + 0.25 * double(ring)});
        if (ring > 0) faces.insert(faces.end(), {{below, next - 12, next}, {below, next, n}});
    }
    const auto bound = cageform::bind(cageform::MeanValueCoordinates(cage), column);
    if (!bound) return 1;
    // A clip: 16 frames in which the cage is twisted.
    std::vector<Points> frames(16, column);
    for (std::size_t t = 0; t < frames.size(); ++t) {
        Points pose;
        for (const auto& v : cage.vertices()) {
            const double angle = 0.025 * double(t) * v[2], c = std::cos(angle), s = std::sin(angle);
            pose.push_back({c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]});
        }
        if (clone(bound.value, pose, frames[t]) != cageform::Status::ok) return 1;
    }
    // A given number of bones, or the fewest within 1 % of the size. Parents come before children.
    const auto one = cageform::fit_skeleton(column, frames, faces, {.bones = 1});
    std::printf("1 bone: within %.0f %%\n", 100 * one.report.max_distance);
    const auto [skeleton, report] = cageform::fit_skeleton(column, frames, faces, {.max_distance = 0.01});
    std::printf("within 1 %%: %s\n", report.beyond == 0 && report.bones < 9 ? "by few bones" : "by many");
    std::printf("the parent of bone 1 is bone %u\n", skeleton.parents[1]);
}

//> 1 bone: within 13 %
//> within 1 %: by few bones
//> the parent of bone 1 is bone 0
