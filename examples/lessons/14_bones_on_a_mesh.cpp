// 14. Bones on a mesh: weights by bone heat. Bones are handles, so `clone` also deforms a skin.
#include <cageform/binding/bind_bones.hpp>
#include <cageform/cageform.hpp>
#include <cageform/fields/skin.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 3>;

int main() {
    // A bar along x, made of square rings and closed at both ends, with a bone in each half.
    std::vector<Point> points;
    std::vector<std::array<int, 3>> faces{{0, 2, 1}, {0, 3, 2}};
    const int rings = 17;
    for (int r = 0; r < rings; ++r) {
        const double x = 0.25 * r;
        points.insert(points.end(), {{x, -0.3, -0.3}, {x, 0.3, -0.3}, {x, 0.3, 0.3}, {x, -0.3, 0.3}});
        for (int k = 0; k < 4 && r + 1 < rings; ++k) {
            const int a = 4 * r + k, b = 4 * r + (k + 1) % 4;
            faces.insert(faces.end(), {{a, b, b + 4}, {a, b + 4, a + 4}});
        }
    }
    const int last = 4 * (rings - 1);
    faces.insert(faces.end(), {{last, last + 1, last + 2}, {last, last + 2, last + 3}});
    const std::array<cageform::BoneSegment, 2> bones{{{{0, 0, 0}, {2, 0, 0}}, {{2, 0, 0}, {4, 0, 0}}}};

    const auto skin = cageform::bone_heat(points, faces, bones);
    if (!skin) return std::puts(to_string(skin.status()));
    std::printf("weight of the second bone along the bar:");
    for (const int r : {0, 4, 7, 8, 9, 12, 16}) std::printf(" %.2f", skin.value[std::size_t(8 * r + 1)]);

    // The handles of a bone are its position (a point) and its three axes (vectors).
    using Frame = cageform::Transform<double, 3>;
    const std::vector<Frame> frames{{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 0}},
                                    {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {2, 0, 0}}};
    const auto bound = cageform::bind_bones(points, std::span<const Frame>(frames), std::span(skin.value));
    if (!bound) return 1;
    std::printf("\n%zu bones, %zu handles\n", bones.size(), bound.value.handle_count());

    // Every frame: transforms of the bones, then clone. The second bone rotates by 90 degrees about the z
    // axis through (2, 0, 0).
    const std::vector<Frame> moves{frames[0], {{{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}}, {2, -2, 0}}};
    std::vector<Point> handles(bound.value.handle_count()), out(points.size());
    if (pose_bones(bound.value, std::span<const Frame>(moves), handles) != cageform::Status::ok) return 1;
    if (clone(bound.value, handles, out) != cageform::Status::ok) return 1;
    const auto& tip = out[std::size_t(last)];
    std::printf("(4, -0.3, -0.3) moves to (%.2f, %.2f, %.2f)\n", tip[0], tip[1], tip[2]);
}

//> weight of the second bone along the bar: 0.01 0.05 0.28 0.50 0.72 0.95 0.99
//> 2 bones, 8 handles
//> (4, -0.3, -0.3) moves to (2.32, 1.97, -0.30)
