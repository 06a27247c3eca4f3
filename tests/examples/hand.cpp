#include "catch.hpp"

#include "hand_model.hpp"
#include "support/larger.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <set>
#include <string>

namespace hand_test {

using namespace cageform_sources;

constexpr double rounding = 16 * cageform::epsilon<double>; // of points up to 2 from the origin

/// Coarse: the motion of joints does not depend on the resolution of the skin.
const Hand& hand() {
    static const Hand made = make_hand(1.0 / 40);
    return made;
}

/// A hand with other proportions: an affine map of all its parts makes it thicker and longer.
const Hand& built_hand() {
    static const Hand made = [] {
        Hand other = hand();
        const auto map = [](const Point3& p) { return Point3{p[0], 1.2 * p[1], 1.3 * p[2]}; };
        for (Point3& p : other.skin.vertices) p = map(p);
        for (HandPoint& point : other.points) point.place = map(point.place);
        for (HandJoint& joint : other.joints) {
            joint.place = map(joint.place);
            joint.end = map(joint.end);
        }
        return other;
    }();
    return made;
}

HandPose random_pose(unsigned seed) {
    std::mt19937 random(seed);
    HandPose pose;
    for (std::size_t i = 0; i < pose.size(); ++i)
        pose[i] = std::uniform_real_distribution<double>(hand_angle_ranges[i].least,
                                                         hand_angle_ranges[i].most)(random);
    return pose;
}

HandPose one_angle(std::size_t angle, double degrees) {
    HandPose pose{};
    pose[angle] = degrees;
    return pose;
}

Point3 unit(const Point3& v) {
    return (1 / length(v)) * v;
}
Point3 along(const HandJoint& joint) {
    return unit(joint.end - joint.place);
}
Point3 turned(const RigidMotion3& motion, const Point3& v) {
    return {dot(motion.rows[0], v), dot(motion.rows[1], v), dot(motion.rows[2], v)};
}
/// A rotation about an axis through a point, by Rodrigues' formula.
Point3 rotated(const Point3& p, const Point3& place, const Point3& axis, double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    const Point3 d = p - place;
    return place + std::cos(angle) * d + std::sin(angle) * cross(axis, d) +
           (1 - std::cos(angle)) * dot(axis, d) * axis;
}
/// Applies a fraction of a joint's angles to a point, before the rotations of its parents.
Point3 by_joint(const HandJoint& joint, const HandPose& angles, double part, Point3 p) {
    if (joint.bend != HandJoint::none)
        p = rotated(p, joint.place, joint.bend_axis, part * angles[joint.bend]);
    if (joint.spread != HandJoint::none)
        p = rotated(p, joint.place, joint.spread_axis, part * angles[joint.spread]);
    return p;
}
/// Forward kinematics, directly: from the joint inwards to the wrist.
Point3 by_chain(const Hand& of, std::size_t joint, const HandPose& angles, double part, Point3 p) {
    p = by_joint(of.joints[joint], angles, part, p);
    for (joint = of.joints[joint].parent; joint != HandJoint::none; joint = of.joints[joint].parent)
        p = by_joint(of.joints[joint], angles, 1, p);
    return p;
}

TEST_CASE("a hand has five rays of joints, each beginning where the one before ends", "[examples][hand]") {
    std::set<std::size_t> angles;
    std::size_t joints = 0;
    for (const auto& ray : hand().rays) {
        for (std::size_t k = 0; k < ray.size(); ++k, ++joints) {
            const HandJoint& joint = hand().joints[ray[k]];
            CHECK(joint.parent == (k == 0 ? HandJoint::none : ray[k - 1]));
            if (k > 0) CHECK(length(joint.place - hand().joints[ray[k - 1]].end) <= rounding);
            CHECK(std::fabs(length(joint.bend_axis) - 1) <= rounding);
            for (const std::size_t angle : {joint.bend, joint.spread}) {
                if (angle != HandJoint::none) CHECK(angles.insert(angle).second);
            }
        }
    }
    CHECK(joints == hand().joints.size());
    CHECK(angles.size() == hand_angle_count); // each angle belongs to one joint
    CHECK(*angles.rbegin() + 1 == hand_angle_count);
}

TEST_CASE("at rest nothing moves, bit for bit", "[examples][hand]") {
    for (const Hand* of : {&hand(), &built_hand()}) {
        const auto rest = of->sites();
        for (const bool half : {true, false}) {
            const auto sites = of->pose(HandPose{}, half);
            REQUIRE(sites.size() == rest.size());
            CHECK(std::memcmp(sites.data(), rest.data(), rest.size() * sizeof(rest[0])) == 0);
        }
        for (const double weight : of->weights(HandPose{}, 3)) CHECK(weight == 1);
    }
}

TEST_CASE("bones move rigidly and stay joined", "[examples][hand][property]") {
    const auto seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    const HandPose angles = random_pose(seed);
    for (const Hand* of : {&hand(), &built_hand()}) {
        const auto motions = of->bones(angles);
        REQUIRE(motions.size() == of->joints.size());
        for (std::size_t j = 0; j < motions.size(); ++j) {
            const HandJoint& joint = of->joints[j];
            const Point3 a = joint.end + Point3{0.03, 0.02, -0.04}, b = joint.end + Point3{0.01, -0.05, 0};
            for (const Point3& p : {joint.place, joint.end, a, b})
                CHECK(length(motions[j](p) - by_chain(*of, j, angles, 1, p)) <= rounding);
            if (joint.parent != HandJoint::none)
                CHECK(length(motions[j](joint.place) - motions[joint.parent](joint.place)) <= rounding);
        }
    }
}

TEST_CASE("an angle turns exactly the bones beyond its joint, by that angle", "[examples][hand]") {
    const auto angle = GENERATE(range(std::size_t{0}, hand_angle_count));
    CAPTURE(hand_angle_ranges[angle].name);
    const double degrees = hand_angle_ranges[angle].most;
    const auto motions = hand().bones(one_angle(angle, degrees));
    for (std::size_t j = 0; j < motions.size(); ++j) {
        std::size_t turns = j; // the joint of the angle, if it is between the bone and the wrist
        while (turns != HandJoint::none && hand().joints[turns].bend != angle &&
               hand().joints[turns].spread != angle)
            turns = hand().joints[turns].parent;
        const double trace = motions[j].rows[0][0] + motions[j].rows[1][1] + motions[j].rows[2][2];
        const double expected = turns == HandJoint::none ? 0 : degrees;
        CHECK(std::fabs(trace - (1 + 2 * std::cos(expected * std::numbers::pi / 180))) <= rounding);
    }
}

TEST_CASE("fingers bend to the inner side and spread apart", "[examples][hand]") {
    for (std::size_t ray = 0; ray < 4; ++ray) {
        const HandJoint& tip = hand().joints[hand().rays[ray].back()];
        for (std::size_t k = 1; k < 4; ++k) {
            const auto motions = hand().bones(one_angle(4 * ray + k, 60));
            CHECK(motions[hand().rays[ray].back()](tip.end)[2] < tip.end[2] - 0.05);
        }
        const double x = hand().bones(one_angle(4 * ray, 10))[hand().rays[ray].back()](tip.end)[0];
        CHECK((ray < 2 ? tip.end[0] - x : x - tip.end[0]) >
              0.05); // index and middle finger towards the thumb, the others away from it
    }
}

TEST_CASE("control points move with their bones, creases by half the angle, shared points by the mean",
          "[examples][hand][property]") {
    const auto seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    const HandPose angles = random_pose(seed);
    for (const Hand* of : {&hand(), &built_hand()}) {
        const auto motions = of->bones(angles);
        const auto sites = of->pose(angles), unhalved = of->pose(angles, false);
        std::size_t fixed = 0, half = 0;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const HandPoint& point = of->points[i];
            CAPTURE(i, to_string(point.kind));
            if (point.joint == HandJoint::none) {
                CHECK(sites[i] == point.place);
                ++fixed;
            } else if (point.other == HandJoint::none) {
                CHECK(length(sites[i] - by_chain(*of, point.joint, angles, point.part, point.place)) <=
                      rounding);
                CHECK(length(unhalved[i] - motions[point.joint](point.place)) <= rounding);
                if (point.part == 0.5) ++half;
            }
        }
        CHECK((fixed > 0 && half > 0));
    }
}

TEST_CASE("a point shared by two joints follows both", "[examples][hand]") {
    std::size_t shared = 0;
    for (std::size_t i = 0; i < hand().points.size(); ++i) {
        const HandPoint& point = hand().points[i];
        if (point.other == HandJoint::none) continue;
        ++shared;
        CHECK(point.joint != point.other);
        for (const std::size_t bent : {point.joint, point.other}) { // it moves with both
            const std::size_t angle = hand().joints[bent].bend;
            if (angle == HandJoint::none) continue;
            const auto path = [&](double degrees) {
                return length(hand().pose(one_angle(angle, degrees))[i] - point.place);
            };
            CHECK((path(5) > 0 && path(10) > path(5)));
        }
    }
    CHECK(shared > 0);
}

TEST_CASE("lines stay where they are to the planes between both bones", "[examples][hand][property]") {
    const auto degrees = GENERATE(0.0, 17.0, 60.0, 80.0);
    CAPTURE(degrees);
    std::size_t rings = 0;
    for (const auto& ray : hand().rays) {
        for (const std::size_t j : ray) {
            const HandJoint& joint = hand().joints[j];
            const auto is_ring = [&](const HandPoint& p) {
                return p.kind == HandPointKind::ring && p.joint == j;
            };
            if (std::none_of(hand().points.begin(), hand().points.end(), is_ring)) continue;
            ++rings;
            REQUIRE(joint.parent != HandJoint::none);
            const HandPose angles = one_angle(joint.bend, degrees);
            const auto motions = hand().bones(angles);
            const Point3 before = turned(motions[joint.parent], along(joint)),
                         after = turned(motions[j], along(joint));
            CHECK(std::fabs(dot(before, after) - std::cos(degrees * std::numbers::pi / 180)) <= rounding);
            const Point3 middle = unit(before + after), place = motions[j](joint.place);
            const auto sites = hand().pose(angles);
            for (std::size_t i = 0; i < sites.size(); ++i) {
                const HandPoint& point = hand().points[i];
                if (!is_ring(point)) continue;
                CHECK(std::fabs(dot(sites[i] - place, middle) -
                                dot(point.place - joint.place, along(joint))) <= rounding);
                CHECK(std::fabs(length(sites[i] - place) - length(point.place - joint.place)) <= rounding);
            }
        }
    }
    CHECK(rings == 10); // two per finger, two for the thumb
}

TEST_CASE("constraint points are vertices of the skin, and no two control points are one",
          "[examples][hand]") {
    const auto& points = hand().points;
    std::set<std::size_t> vertices;
    double least = 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].vertex != HandJoint::none) {
            REQUIRE(points[i].vertex < hand().skin.vertices.size());
            CHECK(points[i].place == hand().skin.vertices[points[i].vertex]);
            CHECK(vertices.insert(points[i].vertex).second);
            // A crease may be moved into its plane by at most the width of its groove.
            CHECK(std::fabs(skin_function(hand(), points[i].place)) < 0.01);
        }
        for (std::size_t k = 0; k < i; ++k)
            least = std::min(least, length(points[i].place - points[k].place));
    }
    CHECK(least > 1e-3);
}

TEST_CASE("weights of inflation points rise with their angle", "[examples][hand]") {
    double before = 1;
    for (const double degrees : {10.0, 45.0, 90.0}) {
        const auto weights = hand().weights(one_angle(std::size_t(HandAngle::ring_mcp), degrees), 3);
        double most = 1;
        for (std::size_t i = 0; i < weights.size(); ++i) {
            const HandPoint& point = hand().points[i];
            const bool swells = point.kind == HandPointKind::inflation && point.joint == hand().rays[2][1];
            if (!swells) CHECK(weights[i] == 1);
            most = cageform_tests::larger(most, weights[i]);
        }
        CHECK(most > before);
        CHECK(std::fabs(most - (1 + 3 * (1 - std::cos(degrees * std::numbers::pi / 180)))) <= rounding);
        before = most;
    }
}

TEST_CASE("poses stay within the ranges of their angles, and so does rest", "[examples][hand]") {
    for (std::size_t i = 0; i < hand_angle_count; ++i) {
        const auto& [name, least, most] = hand_angle_ranges[i];
        CAPTURE(name);
        for (const NamedHandPose& pose : hand_poses())
            CHECK((least <= pose.angles[i] && pose.angles[i] <= most));
        CHECK((least <= 0 && 0 < most));
    }
}

TEST_CASE("a grasp closes until contact, without penetration", "[examples][hand]") {
    const auto& poses = hand_poses();
    for (const auto& [name, object] : {std::pair{"ball", &hand_ball()}, {"rod", &hand_rod()}}) {
        CAPTURE(name);
        const auto open = std::find_if(poses.begin(), poses.end(),
                                       [&](const auto& pose) { return pose.name == std::string(name); });
        REQUIRE(open != poses.end());
        const HandPose closed = grasp(hand(), open->angles, *object);
        const auto sites = hand().pose(closed);
        std::size_t touching = 0;
        for (const auto& ray : hand().rays) {
            double least = 1;
            for (std::size_t i = 0; i < sites.size(); ++i) {
                const HandPoint& point = hand().points[i];
                const bool of_ray = std::find(ray.begin(), ray.end(), point.joint) != ray.end();
                if (of_ray && (point.kind == HandPointKind::middle || point.kind == HandPointKind::tip))
                    least = std::min(least, object->distance(sites[i]));
            }
            CHECK(least >= 0);
            if (least < 1e-6) ++touching;
        }
        CHECK(touching >= 3);
        for (std::size_t i = 0; i < hand_angle_count; ++i)
            CHECK((open->angles[i] <= closed[i] && closed[i] <= hand_angle_ranges[i].most));
    }
}

} // namespace hand_test
