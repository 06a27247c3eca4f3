#pragma once

// The puppet of make_character: its solid, shapes, clothes, bones and landmarks. The ground is y = 0, y is
// up, and the puppet faces along z, so that its left side has x > 0. Units are metres.

#include "pictures/surface_nets.hpp"

#include <cageform/cage/triangle_mesh.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace cageform_programs {

using cageform_support::ImplicitMesh;
using cageform_support::Point3;

/// Smooth step: 0 up to `from`, 1 beyond `to`; `to` may be less than `from`.
inline double ramp(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// A function that is negative inside the puppet of the default shape.
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

// ---- shapes ----

/// The shape of a puppet's body.
struct PuppetShape {
    static constexpr double least_girth = 0.7, most_girth = 1.5;

    double girth = 1; ///< of the trunk and the limbs, in [least_girth, most_girth]
    double child = 0; ///< proportions: 0 for an adult to 1 for a child
};

/// The shift of a point of the default puppet to the same point of the puppet of another shape.
inline Point3 shape_shift(const Point3& p, const PuppetShape& shape) {
    const double side = p[0] < 0 ? -1 : 1, x = std::fabs(p[0]), y = p[1], z = p[2];
    const double thick = shape.girth - 1;
    const double trunk = ramp(0.6, 1, y) * ramp(1.55, 1, y);
    const double arm = ramp(0.2, 0.42, x) * ramp(0.75, 1.2, y);
    const double leg = ramp(0.08, 0.25, y) * ramp(1, 0.6, y);
    const double head = 0.15 * shape.child * ramp(1.46, 1.6, y);
    const double wide =
        thick * (0.2 * std::tanh(x / 0.2) * trunk + 0.5 * leg * ramp(0, 0.1, x) * (x - 0.17)) -
        0.15 * shape.child * ramp(0.2, 0.85, x);
    const double up =
        0.5 * thick * arm * (y - 1.325) + head * (y - 1.5) -
        shape.child * (0.12 * (ramp(0.08, 0.5, y) + ramp(0.45, 0.9, y)) + 0.1 * ramp(0.8, 1.4, y));
    const double deep = thick * (trunk * (1 - arm) + 0.5 * std::max(arm, leg));
    return {side * (wide + head * x), up, (deep + head) * z};
}

/// The point of the puppet of a shape that corresponds to a point of the default puppet.
inline Point3 shaped(const Point3& p, const PuppetShape& shape) {
    return p + shape_shift(p, shape);
}

/// The inverse of shaped(), by iteration, which converges for shapes in their ranges.
inline Point3 unshaped(const Point3& p, const PuppetShape& shape) {
    Point3 at = p;
    for (int step = 0; step < 100; ++step) {
        const Point3 next = p - shape_shift(at, shape);
        const double way = cageform_support::length(next - at);
        at = next;
        if (way < 1e-10) break;
    }
    return at;
}

/// The skin of a puppet, by surface nets.
///
///   cell   edge length of the grid's cells; down to 3/4 of it where the mesh would else be no manifold,
///          because thin details meet in a cell
inline ImplicitMesh puppet_mesh(const PuppetShape& shape = {}, double cell = 0.0218) {
    const double more = std::max(shape.girth - 1, 0.0), wide = 1.05 + 0.1 * more, deep = 1 + more;
    for (double share = 1;; share -= 0.03) {
        ImplicitMesh mesh = cageform_support::surface_nets(
            [&](const Point3& p) { return puppet(unshaped(p, shape)); }, {-wide, -0.05, -0.25 * deep},
            {wide, 1.95, 0.3 * deep}, share * cell);
        const auto report = cageform::check(cageform::TriangleMesh<double>(mesh.vertices, mesh.faces));
        if (report.status == cageform::Status::ok || share < 0.78) return mesh;
    }
}

// ---- clothes: open surfaces outside the skin ----

/// The part between two heights of the surface where a function of the default puppet's space is 0.
template <class F>
ImplicitMesh puppet_cloth(const F& solid, double low, double high, const PuppetShape& shape, double cell) {
    const double wide = 0.5 * std::max(shape.girth, 1.0);
    const auto below = [&](const Point3& p) {
        const Point3 at = unshaped(p, shape);
        return std::max(solid(at), at[1] - high - 3 * cell);
    };
    const ImplicitMesh whole =
        cageform_support::surface_nets(below, {-wide, -0.1, -wide}, {wide, high + 5 * cell, wide}, cell);
    const double near = cell / 4; // vertices so close to an end move onto it, to avoid narrow faces
    std::vector<Point3> places;
    std::vector<bool> is_between;
    for (const Point3& p : whole.vertices) {
        Point3 at = unshaped(p, shape);
        is_between.push_back(at[1] > low + near && at[1] < high - near);
        if (!is_between.back()) at[1] = at[1] < (low + high) / 2 ? low : high;
        places.push_back(shaped(at, shape));
    }
    ImplicitMesh cloth;
    std::vector<std::uint32_t> index(places.size(), ~std::uint32_t{0});
    for (auto face : whole.faces) {
        if (!is_between[face[0]] && !is_between[face[1]] && !is_between[face[2]]) continue;
        for (std::uint32_t& corner : face) {
            if (index[corner] == ~std::uint32_t{0}) {
                index[corner] = std::uint32_t(cloth.vertices.size());
                cloth.vertices.push_back(places[corner]);
            }
            corner = index[corner];
        }
        cloth.faces.push_back(face);
    }
    return cloth;
}

/// Tights from the ankles to the waist, about 1 cm outside the skin.
inline ImplicitMesh puppet_tights(const PuppetShape& shape = {}, double cell = 0.0218) {
    return puppet_cloth([](const Point3& p) { return puppet(p) - 0.012; }, 0.17, 0.96, shape, cell);
}

/// A skirt from above the knees to the waist, outside the tights.
inline ImplicitMesh puppet_skirt(const PuppetShape& shape = {}, double cell = 0.0218) {
    const auto solid = [](const Point3& p) {
        const double cone =
            cageform_support::limb({p[0], p[1], 1.25 * p[2]}, {0, 0.95, 0}, {0, 0.55, 0}, 0.19, 0.34);
        return cageform_support::join(puppet(p) - 0.024, cone, 0.05);
    };
    return puppet_cloth(solid, 0.56, 0.95, shape, cell);
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
inline std::vector<PuppetBone> puppet_bones(const PuppetShape& shape = {}) {
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
    for (PuppetBone& bone : bones) {
        bone.head = shaped(bone.head, shape);
        bone.tail = shaped(bone.tail, shape);
    }
    return bones;
}

struct PuppetLandmark {
    std::string name;
    Point3 place;
};

/// Places on the skin, then the joints: the bones' heads.
inline std::vector<PuppetLandmark> puppet_landmarks(const PuppetShape& shape = {}) {
    std::vector<PuppetLandmark> landmarks;
    const auto add = [&](const std::string& name, Point3 p) {
        for (int step = 0; step < 20; ++step) { // onto the surface, by Newton's method
            const Point3 g = cageform_support::slope(puppet, p);
            p = p - (puppet(p) / dot(g, g)) * g;
        }
        landmarks.push_back({name, shaped(p, shape)});
    };
    add("crown", {0, 1.9, 0.005});
    add("chin", {0, 1.54, 0.11});
    add("crotch", {0, 0.76, 0});
    for (const double side : {1.0, -1.0}) {
        const std::string of = side > 0 ? "left " : "right ";
        add(of + "finger tip", {1 * side, 1.325, 0});
        add(of + "elbow", {0.545 * side, 1.325, -0.07});
        add(of + "armpit", {0.24 * side, 1.24, 0});
        add(of + "knee", {0.178 * side, 0.46, 0.08});
        add(of + "heel", {0.19 * side, 0.06, -0.1});
        add(of + "toe", {0.196 * side, 0.07, 0.22});
    }
    for (const PuppetBone& bone : puppet_bones(shape)) landmarks.push_back({bone.name + " joint", bone.head});
    return landmarks;
}

} // namespace cageform_programs
