// 26. Stiff along a limb: anisotropic Green coordinates, by a linear map before `bind` and after `clone`.
#include <cageform/cageform.hpp>

#include <cmath>
#include <cstdio>

/// Green coordinates satisfy Δw = 0; with a stiffness A they satisfy ∇·(A ∇w) = 0 (Xiao, Chen, Deng 2025).
/// The map B = A^(-1/2) takes one equation to the other. Here A = diag(1/b², 1), so B = diag(b, 1).
template <class T>
std::vector<cageform::Vec<T, 2>> scaled_x(std::vector<cageform::Vec<T, 2>> points, T b) {
    for (auto& p : points) p[0] *= b;
    return points;
}

/// The largest stretch on the axis of a limb when its middle is pulled apart.
template <class T>
T largest_stretch(T b) {
    std::vector<cageform::Vec<T, 2>> cage, axis, moved;
    for (int i = 0; i <= 6; ++i) cage.push_back({T(i), 0}); // a limb along x, 6 long and 1 wide
    for (int i = 6; i >= 0; --i) cage.push_back({T(i), 1});
    for (int i = 0; i <= 100; ++i) axis.push_back({T(0.3 + 0.054 * i), T(0.5)});
    auto pose = cage;
    for (auto& p : pose) p[0] += p[0] > 3 ? T(1) : T(0);

    const cageform::GreenCoordinates<T, 2> coordinates(scaled_x(cage, b));
    const auto [binding, report] = cageform::bind(coordinates, scaled_x(axis, b));
    moved.resize(axis.size());
    std::vector<cageform::Vec<T, 2>> handles(binding.handle_count());
    if (pose_handles(binding, scaled_x(pose, b), handles).status != cageform::Status::ok) return 0;
    if (clone(binding, handles, moved) != cageform::Status::ok) return 0;
    moved = scaled_x(moved, 1 / b);

    T largest = 0;
    for (std::size_t i = 1; i < moved.size(); ++i)
        largest = std::fmax(largest, (moved[i][0] - moved[i - 1][0]) / (axis[i][0] - axis[i - 1][0]));
    return largest;
}

int main() {
    std::printf("the middle sixth of a limb becomes twice as long; the largest stretch of its axis:\n");
    for (const double b : {1.0, 0.25})
        std::printf("stiffness along x %2.0f: %.2f (float: %.2f)\n", 1 / (b * b), largest_stretch(b),
                    double(largest_stretch(float(b))));
}

//> the middle sixth of a limb becomes twice as long; the largest stretch of its axis:
//> stiffness along x  1: 1.50 (float: 1.50)
//> stiffness along x 16: 1.16 (float: 1.16)
