#include "character/motions.hpp"

#include <array>

namespace cageform_programs {

namespace {

constexpr std::size_t x = 0, y = 1, z = 2; // axes
constexpr double full_turn = 2 * std::numbers::pi;

/// Bones posed from the root outwards.
class Poser {
public:
    Poser(const std::vector<PuppetBone>& bones, const Point3& shift)
        : pose{std::vector<Rotation>(bones.size(), no_rotation), shift}
        , bones_(bones)
        , places_(bones.size())
        , turned_(bones.size(), no_rotation) {}

    /// Rotates a bone relative to its parent, which has been posed before.
    void turn(std::size_t b, const Rotation& rotation) {
        const PuppetBone& bone = bones_[b];
        pose.turns[b] = rotation;
        const Rotation before = bone.parent == bone.none ? no_rotation : turned_[bone.parent];
        turned_[b] = product(before, rotation);
        places_[b] = bone.parent == bone.none
                         ? bone.head + pose.shift
                         : places_[bone.parent] + rotated(before, bone.head - bones_[bone.parent].head);
    }
    /// Gives a bone a rotation relative to the rest pose.
    void turn_to(std::size_t b, const Rotation& rotation) {
        turn(b, product(inverse(turned_[bones_[b].parent]), rotation));
    }
    /// Bends a leg at the knee so that the foot's joint reaches a place. The foot has the given rotation.
    void place_foot(std::size_t side, const Point3& place, const Rotation& rotation);

    PuppetPose pose;

private:
    const std::vector<PuppetBone>& bones_;
    std::vector<Point3> places_;   // posed joints
    std::vector<Rotation> turned_; // relative to the rest pose
};

Point3 unit(const Point3& p) {
    return (1 / std::sqrt(dot(p, p))) * p;
}

/// The part of `p` that is perpendicular to a unit vector, with length 1.
Point3 across(const Point3& p, const Point3& direction) {
    return unit(p - dot(p, direction) * direction);
}

void Poser::place_foot(std::size_t side, const Point3& place, const Rotation& rotation) {
    const std::size_t thigh = side + bone::thigh, shin = side + bone::shin, foot = side + bone::foot;
    turn(thigh, no_rotation); // finds the place of its joint
    const Point3 upper = bones_[shin].head - bones_[thigh].head,
                 lower = bones_[foot].head - bones_[shin].head;
    const double a = std::sqrt(dot(upper, upper)), b = std::sqrt(dot(lower, lower));
    const Point3 way = place - places_[thigh];
    const double reach = std::min(std::sqrt(dot(way, way)), 0.9995 * (a + b));
    const Point3 along = unit(way), forwards = across({0, 0, 1}, along);
    const double t = (a * a + reach * reach - b * b) / (2 * reach); // of the knee, along the way
    const Point3 to_knee = t * along + std::sqrt(std::max(a * a - t * t, 0.0)) * forwards;
    const Point3 hinge = cross(along, forwards);
    const auto point = [&](std::size_t index, const Point3& rest, const Point3& direction) {
        const Rotation swing = between(rest, direction);
        const Point3 axis = rotated(swing, across({-1, 0, 0}, unit(rest)));
        turn_to(index, product(between(axis, across(hinge, unit(direction))), swing));
    };
    point(thigh, upper, to_knee);
    point(shin, lower, reach * along - to_knee);
    turn_to(foot, rotation);
}

/// Angles of a left arm in degrees; a right arm is mirrored.
struct Arm {
    double down;      ///< of the upper arm, from the T-pose
    double backward;  ///< of the whole arm, about x
    double bend;      ///< of the elbow, forward
    double raise = 0; ///< of the forearm, in the plane of the T-pose
};

void pose_arm(Poser& poser, std::size_t side, const Arm& arm) {
    const auto turn = [&](std::size_t b, const Rotation& q) {
        poser.turn(side + b, side == bone::left_shoulder ? q : mirrored(q));
    };
    turn(bone::shoulder, product(about(x, 0.12 * arm.backward), about(z, -0.1 * arm.down)));
    turn(bone::upper_arm, product(about(x, 0.88 * arm.backward), about(z, -0.9 * arm.down)));
    turn(bone::forearm, product(about(z, arm.raise), about(y, -arm.bend)));
    turn(bone::hand, about(y, -0.25 * arm.bend));
}

/// A curve through (part, value) pairs, with slope 0 at each pair.
template <std::size_t N>
double through(const std::array<std::array<double, 2>, N>& keys, double part) {
    std::size_t k = 0;
    while (k + 2 < N && part > keys[k + 1][0]) ++k;
    return keys[k][1] + (keys[k + 1][1] - keys[k][1]) * ramp(keys[k][0], keys[k + 1][0], part);
}

/// A foot of the walk, in the plane of y and z.
struct Step {
    double pitch;           // degrees, positive if the toes are up
    double height, forward; // of the sole if it were flat, relative to the rest pose
};

/// The step at a part of the cycle, which begins with the heel strike.
Step step_at(double part) {
    constexpr double contact = walk_contact, reach = walk_reach;
    constexpr std::array<std::array<double, 2>, 7> pitches{
        {{0, 20}, {0.1, 0}, {0.38, 0}, {0.66, -44}, {0.74, -40}, {0.95, 20}, {1, 20}}};
    Step step{through(pitches, part), 0, reach * (1 - 2 * part / contact)};
    if (part <= contact) return step;
    const double s = (part - contact) / (1 - contact);
    const double slope = -2 * reach / contact * (1 - contact); // the speed of the ground, at both ends
    step.forward = -reach * (1 - 3 * s * s + 2 * s * s * s) + slope * (s - 2 * s * s + s * s * s) +
                   reach * (3 * s * s - 2 * s * s * s) + slope * (s * s * s - s * s);
    step.height = 0.045 * std::pow(std::sin(std::numbers::pi * s), 2);
    return step;
}

} // namespace

PuppetPose walk_pose(const std::vector<PuppetBone>& bones, double part) {
    const double angle = full_turn * part;
    const double ahead = std::cos(angle);         // 1: the left foot strikes
    const double on_left = std::sin(angle - 0.3); // 1: the weight is on the left foot
    const double high = std::cos(2 * angle - full_turn * 0.6);
    Poser poser(bones, {0.022 * on_left, -0.021 + 0.011 * high, 0.01});
    const double yaw = -7 * ahead, roll = 2.5 * on_left;
    poser.turn(bone::hips, product(about(y, yaw), product(about(z, roll), about(x, 2))));
    poser.turn(bone::chest, product(about(y, -2.2 * yaw), product(about(z, -1.4 * roll), about(x, 2))));
    poser.turn(bone::neck, product(about(y, 0.7 * yaw), about(z, 0.2 * roll)));
    poser.turn(bone::head,
               product(about(y, 0.4 * yaw), product(about(z, 0.2 * roll), about(x, -3 - 1.5 * high))));
    for (const std::size_t side : {bone::left_shoulder, bone::right_shoulder}) {
        const bool is_left = side == bone::left_shoulder;
        const double back = is_left ? std::cos(angle - 0.2) : -std::cos(angle - 0.2); // of the arm
        pose_arm(poser, side, {70, 27 * back - 4, 24 - 14 * back});
        const double own = is_left ? part : part + 0.5;
        const Step step = step_at(own - std::floor(own));
        const Point3& joint = bones[side + bone::foot].head;
        // The foot rolls on its round heel or its round toes.
        const Point3 centre =
            step.pitch > 0 ? Point3{joint[0], 0.067, -0.035} : Point3{joint[0], 0.075, 0.15};
        const Rotation pitch = about(x, -step.pitch);
        const double rolled = -centre[1] * step.pitch * std::numbers::pi / 180;
        const Point3 place =
            centre + rotated(pitch, joint - centre) + Point3{0, step.height, step.forward + rolled};
        poser.place_foot(side, place, pitch);
    }
    poser.pose.breath = 0.25 + 0.25 * ahead;
    return poser.pose;
}

PuppetPose greeting_pose(const std::vector<PuppetBone>& bones, double part) {
    const double up = ramp(0.05, 0.3, part) * ramp(0.95, 0.7, part); // of the hand
    const double wave = std::sin(6 * full_turn * part) * up * up;
    const double breath = 0.5 - 0.5 * std::cos(full_turn * part);
    Poser poser(bones, {});
    poser.turn(bone::hips, no_rotation);
    poser.turn(bone::chest, product(about(z, 4 * up), about(x, -2 * breath)));
    poser.turn(bone::neck, about(z, -5 * up));
    poser.turn(bone::head, product(about(y, -9 * up), about(z, -7 * up + 2 * wave)));
    pose_arm(poser, bone::left_shoulder, {70, 0, 14 + 4 * breath});
    pose_arm(poser, bone::right_shoulder, {70 - 98 * up, 0, 14 - 6 * up, 62 * up + 20 * wave});
    poser.pose.smile = ramp(0.02, 0.2, part) * ramp(0.98, 0.85, part);
    poser.pose.surprise = 0.6 * ramp(0.3, 0.4, part) * ramp(0.62, 0.5, part);
    poser.pose.breath = breath;
    return poser.pose;
}

} // namespace cageform_programs
