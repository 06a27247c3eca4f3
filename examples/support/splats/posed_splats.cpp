#include "splats/posed_splats.hpp"

#include "splats/harmonics.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

void turn_harmonics(SplatFile& scene, std::size_t row, const Matrix3& jacobian) {
    const auto& rest = scene.layout.rest;
    if (rest.empty()) return;
    const TurnedHarmonics turned(nearest_orthogonal(jacobian));
    const std::size_t count = rest.size() / 3;
    std::array<double, most_harmonics> numbers{};
    for (std::size_t channel = 0; channel < 3; ++channel) {
        for (std::size_t k = 0; k < count; ++k) numbers[k] = scene.number(row, rest[channel * count + k]);
        turned.turn(std::span(numbers).first(count));
        for (std::size_t k = 0; k < count; ++k) scene.set(row, rest[channel * count + k], numbers[k]);
    }
}

/// Normals transform by J⁻ᵀ, the cofactor matrix over det J, and keep their length.
void turn_normal(SplatFile& scene, std::size_t row, const Matrix3& j) {
    if (scene.layout.normal.empty()) return;
    const Point3 normal = scene.vector(row, scene.layout.normal);
    const Matrix3 cofactors{cross(j[1], j[2]), cross(j[2], j[0]), cross(j[0], j[1])};
    const Point3 turned = product(cofactors, normal);
    const double before = length_of(normal), after = length_of(turned);
    if (before > 0 && after > 0)
        scene.set(row, scene.layout.normal, (std::copysign(before, determinant(j)) / after) * turned);
}

} // namespace

SplatPart part_of(const SplatFile& scene, std::size_t row) {
    const SplatShape shape = scene.shape(row);
    const auto& scales = shape.log_scales.v;
    return {row, scene.place(row), factor_of(shape), std::exp(*std::max_element(scales, scales + 3))};
}

SingularValues posed_shape(const SplatPart& part, const Matrix3& jacobian) {
    return singular_values(product(jacobian, part.factor));
}

double stretch_of(const SplatPart& part, const SingularValues& posed) {
    return part.size > 0 ? posed.sizes[posed.largest()] / part.size : 1;
}

std::array<SplatPart, 2> halves_of(const SplatPart& part, const SingularValues& posed, std::size_t row) {
    const HalfSplat half = half_of(part.factor, posed);
    const double opacity = part.opacity * HalfSplat::opacity;
    return {SplatPart{part.row, part.place - half.offset, half.factor, part.size, opacity},
            SplatPart{row, part.place + half.offset, half.factor, part.size, opacity}};
}

void write_posed(SplatFile& scene, const SplatPart& part, const Point3& place, const Matrix3& jacobian,
                 const SingularValues& posed) {
    const auto row = part.row;
    const auto equal = [](const Point3& a, const Point3& b) { return std::equal(a.v, a.v + 3, b.v); };
    const bool turns = !std::equal(jacobian.begin(), jacobian.end(), identity3.begin(), equal);
    const bool is_whole = part.opacity >= 1;
    scene.set(row, scene.layout.place, place);
    if (turns || !is_whole) scene.set(row, shape_of(posed));
    if (!is_whole) {
        const std::size_t opacity = scene.layout.opacity;
        scene.set(row, opacity, logit_of(part.opacity * opacity_of(scene.number(row, opacity))));
    }
    if (!turns) return;
    turn_harmonics(scene, row, jacobian);
    turn_normal(scene, row, jacobian);
}

} // namespace cageform_support
