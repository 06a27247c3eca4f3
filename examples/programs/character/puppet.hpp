#pragma once

// The puppet of make_character: its solid and its bones. The ground is y = 0, y is up, and the puppet faces
// along z, so that its left side has x > 0. Units are metres.

#include "pictures/surface_nets.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace cageform_programs {

using cageform_support::Point3;

/// Smooth step: 0 up to `from`, 1 beyond `to`; `to` may be less than `from`.
inline double ramp(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// A function that is negative inside the puppet.
inline double puppet(const Point3& at) {
    using cageform_support::ball;
    using cageform_support::carve;
    using cageform_support::ellipsoid;
    using cageform_support::join;
    using cageform_support::limb;
    const Point3 p{std::fabs(at[0]), at[1], at[2]}; // symmetric in x
    // Trunk.
    double body = ellipsoid(p, {0, 0.9, 0}, {0.21, 0.14, 0.145});
    body = join(body, ellipsoid(p, {0, 1.06, 0.015}, {0.195, 0.23, 0.15}), 0.06);
    body = join(body, ellipsoid(p, {0, 1.28, 0}, {0.205, 0.15, 0.13}), 0.06);
    body = join(body, limb(p, {0, 1.36, 0}, {0, 1.54, 0}, 0.085, 0.07), 0.05);
    // Legs, feet.
    body = join(body, limb(p, {0.15, 0.83, 0}, {0.178, 0.46, 0.005}, 0.1, 0.078), 0.04);
    body = join(body, limb(p, {0.178, 0.46, 0.005}, {0.186, 0.12, -0.01}, 0.078, 0.064), 0.03);
    body = join(body, limb(p, {0.186, 0.066, -0.035}, {0.196, 0.07, 0.15}, 0.062, 0.07), 0.04);
    // Arms, hands with a thumb.
    body = join(body, limb(p, {0.2, 1.325, 0}, {0.545, 1.325, -0.005}, 0.082, 0.066), 0.06);
    body = join(body, limb(p, {0.545, 1.325, -0.005}, {0.8, 1.325, 0}, 0.066, 0.05), 0.03);
    body = join(body, ellipsoid(p, {0.895, 1.325, 0}, {0.105, 0.055, 0.072}), 0.03);
    body = join(body, limb(p, {0.85, 1.335, 0.04}, {0.88, 1.345, 0.105}, 0.03, 0.027), 0.03);
    // Buttons.
    for (const Point3& button : {Point3{0, 1.31, 0.128}, Point3{0, 1.185, 0.147}, Point3{0, 1.06, 0.164}})
        body = join(body, ellipsoid(p, button, {0.036, 0.036, 0.022}), 0.008);
    // Head: nose, ears, eyes, a carved smile.
    double head = ellipsoid(p, {0, 1.71, 0.005}, {0.175, 0.19, 0.168});
    head = join(head, ball(p, {0, 1.695, 0.175}, 0.034), 0.02);
    head = join(head, ellipsoid(p, {0.177, 1.7, -0.005}, {0.032, 0.052, 0.035}), 0.02);
    head = join(head, ball(p, {0.068, 1.757, 0.143}, 0.031), 0.01);
    const double smile = std::hypot(std::hypot(p[0], p[1] - 1.705) - 0.088, p[2] - 0.155) - 0.018;
    head = carve(head, std::max(smile, p[1] - 1.66), 0.012);
    return join(body, head, 0.03);
}

/// A bone from its joint, the head, to its tail.
struct PuppetBone {
    static constexpr std::size_t none = ~std::size_t{0};

    std::string name;
    std::size_t parent = none; // comes before its children
    Point3 head, tail;
    Point3 turn{}; // degrees, as in the bones file of skin_mesh
};

/// Indices of bones. Those of a side are relative to its shoulder.
namespace bone {
enum Index : std::size_t { hips, chest, neck, head, left_shoulder, right_shoulder = 11 };
enum OfSide : std::size_t { shoulder, upper_arm, forearm, hand, thigh, shin, foot };
} // namespace bone

/// The 18 bones. The left arm has a pose.
inline std::vector<PuppetBone> puppet_bones() {
    std::vector<PuppetBone> bones{{"hips", PuppetBone::none, {0, 0.86, 0}, {0, 1.02, 0}},
                                  {"chest", bone::hips, {0, 1.02, 0}, {0, 1.38, 0}},
                                  {"neck", bone::chest, {0, 1.38, 0}, {0, 1.54, 0}},
                                  {"head", bone::neck, {0, 1.54, 0}, {0, 1.82, 0}, {0, 12, 0}}};
    for (const std::size_t first : {bone::left_shoulder, bone::right_shoulder}) {
        const bool is_left = first == bone::left_shoulder;
        const auto add = [&](const char* name, std::size_t parent, Point3 from, Point3 to,
                             const Point3& turn) {
            from[0] *= is_left ? 1 : -1;
            to[0] *= is_left ? 1 : -1;
            bones.push_back({std::string(is_left ? "left " : "right ") + name, parent, from, to,
                             is_left ? turn : Point3{}});
        };
        add("shoulder", bone::chest, {0.06, 1.34, 0}, {0.2, 1.325, 0}, {});
        add("upper arm", first + bone::shoulder, {0.2, 1.325, 0}, {0.545, 1.325, -0.005}, {0, 0, 20});
        add("forearm", first + bone::upper_arm, {0.545, 1.325, -0.005}, {0.8, 1.325, 0}, {0, 0, 75});
        add("hand", first + bone::forearm, {0.8, 1.325, 0}, {0.95, 1.325, 0}, {});
        add("thigh", bone::hips, {0.15, 0.83, 0}, {0.178, 0.46, 0.005}, {});
        add("shin", first + bone::thigh, {0.178, 0.46, 0.005}, {0.186, 0.1, -0.02}, {});
        add("foot", first + bone::shin, {0.186, 0.066, -0.02}, {0.196, 0.07, 0.15}, {});
    }
    return bones;
}

} // namespace cageform_programs
