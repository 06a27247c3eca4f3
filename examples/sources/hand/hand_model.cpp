#include "hand_model.hpp"

#include "io/csv.hpp"

#include <cageform/cage/control_points.hpp>

#include <limits>
#include <numbers>

namespace cageform_sources {

using namespace cageform_support;

namespace {

using A = HandAngle;

constexpr std::size_t number(HandAngle angle) {
    return std::size_t(angle);
}

Point3 unit(const Point3& v) {
    return (1 / length(v)) * v;
}

RigidMotion3 after(const RigidMotion3& second, const RigidMotion3& first) {
    RigidMotion3 both;
    for (std::size_t r = 0; r < 3; ++r) {
        Point3 row{};
        for (std::size_t k = 0; k < 3; ++k) row = row + second.rows[r][k] * first.rows[k];
        both.rows[r] = row;
    }
    both.shift = second(first.shift);
    return both;
}

/// A rotation about a unit axis through a point.
RigidMotion3 turn(const Point3& place, const Point3& axis, double degrees) {
    const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    RigidMotion3 motion;
    for (std::size_t r = 0; r < 3; ++r) {
        const Point3 e{r == 0 ? 1.0 : 0.0, r == 1 ? 1.0 : 0.0, r == 2 ? 1.0 : 0.0};
        motion.rows[r] = c * e + (1 - c) * axis[r] * axis + s * cross(e, axis);
    }
    motion.shift = place - motion(place);
    return motion;
}

/// The rotation of a joint: flexion, then abduction. Without an axis the angle is 0.
struct JointTurn {
    Point3 place{}, bend_axis{}, spread_axis{};
    double bend = 0, spread = 0; ///< degrees

    JointTurn(const HandJoint& joint, const HandPose& angles)
        : place(joint.place)
        , bend_axis(joint.bend_axis)
        , spread_axis(joint.spread_axis)
        , bend(joint.bend == HandJoint::none ? 0 : angles[joint.bend])
        , spread(joint.spread == HandJoint::none ? 0 : angles[joint.spread]) {}

    RigidMotion3 motion(double part) const {
        return after(turn(place, spread_axis, part * spread), turn(place, bend_axis, part * bend));
    }
};

/// Averages two rotations. Axes may be opposite; the angles then have opposite signs.
void take_mean(Point3& axis, double& angle, const Point3& other_axis, double other_angle) {
    const double side = dot(axis, other_axis) < 0 ? -1 : 1;
    const Point3 sum = axis + side * other_axis;
    if (length(sum) > 0) axis = unit(sum);
    angle = (angle + side * other_angle) / 2;
}

/// Returns the mean of two rotations: the mean angle about the mean axis.
JointTurn mean(JointTurn a, const JointTurn& b) {
    a.place = 0.5 * (a.place + b.place);
    take_mean(a.bend_axis, a.bend, b.bend_axis, b.bend);
    take_mean(a.spread_axis, a.spread, b.spread_axis, b.spread);
    return a;
}

/// Measurements of a ray, from the wrist outwards: typical proportions of an adult hand.
struct Ray {
    Point3 root, base, along,
        back; ///< starts of metacarpal and first phalanx; directions of the phalanges and their backs
    std::array<double, 3> lengths; ///< of the phalanges; of the thumb, of all bones
    std::array<double, 4> radii;   ///< at their ends
};

const std::array<Ray, 5>& measures() {
    constexpr std::array<double, 4> radii{0.050, 0.045, 0.040, 0.034};
    constexpr Point3 up{0, 0, 1};
    const auto direction = [](double degrees) {
        const double angle = degrees * std::numbers::pi / 180;
        return Point3{std::sin(angle), std::cos(angle), 0};
    };
    static const std::array<Ray, 5> rays{{
        {{-0.055, 0.05, 0}, {-0.13, 0.46, 0}, direction(-15), up, {0.245, 0.143, 0.097}, radii},
        {{-0.01, 0.05, 0}, {-0.01, 0.48, 0}, direction(-3), up, {0.266, 0.170, 0.108}, radii},
        {{0.035, 0.05, 0}, {0.10, 0.45, 0}, direction(9), up, {0.244, 0.165, 0.107}, radii},
        {{0.075, 0.05, 0},
         {0.20, 0.40, 0},
         direction(23),
         up,
         {0.204, 0.117, 0.093},
         {0.045, 0.041, 0.036, 0.031}},
        {{-0.10, 0.06, -0.02},
         {-0.10, 0.06, -0.02},
         unit({-0.70, 0.68, -0.22}),
         {-0.75, -0.2, 0.65},
         {0.25, 0.196, 0.158},
         {0.066, 0.060, 0.052, 0.044}},
    }};
    return rays;
}

void add_ray(Hand& hand, std::size_t number_of_ray) {
    const Ray& ray = measures()[number_of_ray];
    const bool thumb = number_of_ray == 4;
    const Point3 back = unit(ray.back - dot(ray.back, ray.along) * ray.along), axis = cross(back, ray.along);
    std::size_t parent = HandJoint::none;
    const auto add = [&](HandJoint joint) {
        joint.parent = parent;
        parent = hand.joints.size();
        hand.rays[number_of_ray].push_back(parent);
        hand.joints.push_back(joint);
    };
    if (!thumb) {
        HandJoint metacarpal;
        metacarpal.place = ray.root;
        metacarpal.end = ray.base;
        metacarpal.radius = 0.066;
        metacarpal.end_radius = 0.058;
        metacarpal.bend_axis = {-1, 0, 0};
        if (number_of_ray == 2) metacarpal.bend = number(A::ring_metacarpal);
        if (number_of_ray == 3) metacarpal.bend = number(A::little_metacarpal);
        add(metacarpal);
    }
    Point3 place = ray.base;
    for (std::size_t k = 0; k < 3; ++k) {
        HandJoint joint;
        joint.place = place;
        joint.end = place = place + ray.lengths[k] * ray.along;
        joint.radius = ray.radii[k];
        joint.end_radius = ray.radii[k + 1];
        joint.bend_axis = axis;
        if (thumb) {
            joint.bend = k == 0 ? number(A::thumb_cmc) : number(A::thumb_mcp) + k - 1;
            joint.spread = k == 0 ? number(A::thumb_oppose) : HandJoint::none;
            joint.spread_axis = {0, -1, 0}; // away from the palm
        } else {
            joint.bend = 4 * number_of_ray + 1 + k;
            joint.spread = k == 0 ? 4 * number_of_ray : HandJoint::none;
            joint.spread_axis = {0, 0, number_of_ray < 2 ? 1.0 : -1.0}; // away from the middle of the hand
        }
        add(joint);
    }
}

double bone(const HandJoint& joint, const Point3& p) {
    return limb(p, joint.place, joint.end, joint.radius, joint.end_radius);
}

/// The implicit function of the skin: bones in flesh, a palm with two eminences, creases below the joints.
class Skin {
public:
    explicit Skin(const Hand& hand)
        : hand_(hand) {}

    double operator()(const Point3& p) const {
        double palm = limb(p, {-0.02, -0.17, 0}, {-0.03, 0.1, 0}, 0.072, 0.07);
        palm = join(palm, limb(p, {0.035, -0.17, 0}, {0.05, 0.1, 0}, 0.066, 0.068), 0.06);
        for (std::size_t ray = 0; ray < 4; ++ray) palm = join(palm, bone(first(ray), p), 0.05);
        palm = join(palm, ellipsoid(p, {-0.115, 0.17, -0.045}, {0.072, 0.13, 0.062}), 0.05); // thenar
        palm = join(palm, ellipsoid(p, {0.125, 0.17, -0.035}, {0.06, 0.14, 0.058}), 0.05);   // hypothenar
        double fingers = std::numeric_limits<double>::max();
        for (std::size_t ray = 0; ray < 4; ++ray) fingers = join(fingers, phalanges(ray, p), 0.008);
        double all = join(palm, fingers, 0.035);
        all = join(all, phalanges(4, p), 0.045);
        return all;
    }

private:
    const HandJoint& first(std::size_t ray) const { return hand_.joints[hand_.rays[ray][0]]; }

    double phalanges(std::size_t ray, const Point3& p) const {
        const auto& joints = hand_.rays[ray];
        double finger = std::numeric_limits<double>::max();
        for (std::size_t k = ray == 4 ? 0 : 1; k < joints.size(); ++k)
            finger = join(finger, bone(hand_.joints[joints[k]], p), 0.012);
        for (std::size_t k = ray == 4 ? 1 : 2; k < joints.size(); ++k) { // a crease on the inner side
            const HandJoint& joint = hand_.joints[joints[k]];
            const Point3 along = unit(joint.end - joint.place), inner = cross(joint.bend_axis, along);
            const Point3 d = p - joint.place;
            const double s = dot(d, along), across = length(d - s * along);
            const double groove = std::hypot(s, across - joint.radius - 0.002) - 0.008;
            finger = carve(finger, std::max(groove, 0.3 * joint.radius - dot(d, inner)), 0.006);
        }
        return finger;
    }

    const Hand& hand_;
};

/// Makes the control points.
class Points {
public:
    Points(Hand& hand, const Skin& skin)
        : hand_(hand)
        , skin_(skin) {}

    void add_all() {
        for (std::size_t ray = 0; ray < 5; ++ray) add_ray_points(ray);
        add_bases();
        add_thenar_line();
        add_metacarpals();
        add_wrist();
    }

private:
    static constexpr double beside = 0.015; // distance of free points from the skin
    static constexpr double beyond = 0.02;  // distance of inflation points

    /// The point where a ray from inside leaves the skin, at the distance `most` or less.
    Point3 on_skin(const Point3& from, const Point3& direction, double most = 0.3) const {
        constexpr double step = 0.004;
        double inside = 0;
        while (inside < most && skin_(from + (inside + step) * direction) < 0) inside += step;
        double outside = inside + step;
        for (int k = 0; k < 30; ++k) {
            const double middle = (inside + outside) / 2;
            (skin_(from + middle * direction) < 0 ? inside : outside) = middle;
        }
        return from + inside * direction;
    }

    /// The distance of a shield from the skin: at most 30 % of the gap to the next finger.
    double apart(const Point3& p, const Point3& direction) const {
        double gap = 0.004;
        while (gap < 0.08 && skin_(p + gap * direction) > 0) gap += 0.002;
        return std::min(0.02, 0.3 * gap);
    }

    /// Adds a point, unless another point is closer than 0.004, which would tear the skin.
    void add(const HandPoint& point) {
        const auto at_it = [&](const HandPoint& other) { return length(other.place - point.place) < 0.004; };
        if (std::none_of(hand_.points.begin(), hand_.points.end(), at_it)) hand_.points.push_back(point);
    }

    /// Adds a point at the nearest vertex of the skin. A ring first moves this vertex into the plane of the
    /// ring.
    void add_constraint(HandPoint point) {
        double least = std::numeric_limits<double>::max();
        for (std::size_t i = 0; i < hand_.skin.vertices.size(); ++i) {
            const double distance = length(hand_.skin.vertices[i] - point.place);
            if (distance < least) {
                least = distance;
                point.vertex = i;
            }
        }
        Point3& vertex = hand_.skin.vertices[point.vertex];
        if (point.kind == HandPointKind::ring) {
            const HandJoint& j = hand_.joints[point.joint];
            const Point3 along = unit(j.end - j.place);
            vertex = vertex - dot(vertex - j.place, along) * along;
        }
        point.place = vertex;
        add(point);
    }

    /// Calls add(from, direction) for `count` rays around a bone, at a share of its length. The first ray is
    /// `offset` steps from the inner side.
    template <class Add>
    void around(std::size_t joint, double share, std::size_t count, const Add& add, double offset = 0) const {
        const HandJoint& j = hand_.joints[joint];
        const Point3 along = unit(j.end - j.place), axis = j.bend_axis, inner = cross(axis, along);
        const Point3 from = j.place + share * (j.end - j.place);
        for (std::size_t k = 0; k < count; ++k) {
            const double angle = 2 * std::numbers::pi * (double(k) + offset) / double(count);
            add(from, std::cos(angle) * inner + std::sin(angle) * axis);
        }
    }

    void add_ray_points(std::size_t ray) {
        const auto& joints = hand_.rays[ray];
        const std::size_t phalanx = ray == 4 ? 0 : 1;
        for (std::size_t k = phalanx; k < joints.size(); ++k) {
            const std::size_t joint = joints[k];
            const HandJoint& j = hand_.joints[joint];
            const Point3 inner = cross(j.bend_axis, unit(j.end - j.place)), middle = 0.5 * (j.place + j.end);
            add({on_skin(middle, inner, 0.1) + beyond * inner, HandPointKind::inflation, joint});
            if (k > phalanx) { // the ring of this joint
                around(joint, 0, 8, [&](const Point3& from, const Point3& direction) {
                    add_constraint(
                        {on_skin(from, direction, 0.1), HandPointKind::ring, joint, HandJoint::none, 0.5});
                });
            }
            // Thicker places belong to a web, not to the finger. The offset of half a step makes two of six
            // points face the neighbouring fingers.
            const double thick = 1.25 * hand_.joints[joint].radius;
            const bool is_last = k + 1 == joints.size();
            const auto shares = k == 1 && ray < 4 ? std::vector{0.24, 0.47, 0.72}
                                : is_last         ? std::vector{0.27, 0.61}
                                                  : std::vector{0.33, 0.67};
            for (const double share : shares) {
                const auto add_middle = [&](const Point3& from, const Point3& direction) {
                    const Point3 p = on_skin(from, direction, 0.1);
                    if (length(p - from) < thick) add_constraint({p, HandPointKind::middle, joint});
                };
                around(joint, share, 6, add_middle, 0.5);
            }
            for (const double share : {0.13, 0.35, 0.6, 0.85}) {
                const auto add_shield = [&](const Point3& from, const Point3& direction) {
                    const Point3 p = on_skin(from, direction, 0.1);
                    if (length(p - from) < thick)
                        add({p + apart(p, direction) * direction, HandPointKind::shield, joint});
                };
                around(joint, share, 6, add_shield, 0.5);
                if (ray < 4 && k < 3) around(joint, share + 0.115, 2, add_shield, 0.5); // at the sides only
            }
        }
        const std::size_t last = joints.back();
        const HandJoint& j = hand_.joints[last];
        const Point3 along = unit(j.end - j.place), inner = cross(j.bend_axis, along);
        for (int k = -1; k < 6; ++k) {
            const double angle = std::numbers::pi / 3 * k;
            const Point3 d =
                unit(k < 0 ? along : along + std::cos(angle) * inner + std::sin(angle) * j.bend_axis);
            const Point3 p = on_skin(j.end, d, 0.1);
            add_constraint({p, HandPointKind::tip, last});
            add({p + apart(p, d) * d, HandPointKind::shield, last});
        }
    }

    /// Adds open lines at the bases of the fingers. Neighbours share the end points, which turn by the mean
    /// of both.
    void add_bases() {
        for (std::size_t ray = 0; ray < 4; ++ray) {
            const std::size_t joint = hand_.rays[ray][1];
            const HandJoint& j = hand_.joints[joint];
            const Point3 along = unit(j.end - j.place), inner = cross(j.bend_axis, along);
            for (const double angle : {-40.0, 40.0, 140.0, 180.0, 220.0}) {
                const double a = angle * std::numbers::pi / 180;
                add_constraint({on_skin(j.place, std::cos(a) * inner + std::sin(a) * j.bend_axis, 0.1),
                                HandPointKind::base, joint, HandJoint::none, 0.5});
            }
            const std::size_t next = ray == 3 ? HandJoint::none : hand_.rays[ray + 1][1];
            const Point3 side = ray == 3 ? j.place : 0.5 * (j.place + hand_.joints[next].place);
            if (next == HandJoint::none) {
                add_constraint(
                    {on_skin(side, {1, 0, 0}, 0.1), HandPointKind::base, joint, HandJoint::none, 0.5});
            } else {
                for (const double z : {1.0, -1.0})
                    add_constraint({on_skin(side, {0, 0, z}, 0.1), HandPointKind::base, joint, next, 0.5});
                add_constraint(
                    {on_skin(side, unit(along + unit(hand_.joints[next].end - hand_.joints[next].place)),
                             0.2),
                     HandPointKind::base, joint, next, 0.5});
            }
            if (ray == 0)
                add_constraint(
                    {on_skin(side_of(j), {-1, 0, 0}, 0.1), HandPointKind::base, joint, HandJoint::none, 0.5});
        }
    }
    static Point3 side_of(const HandJoint& joint) { return joint.place; }

    /// Adds points from the wrist along the thenar eminence and over the web to the back.
    void add_thenar_line() {
        const std::size_t cmc = hand_.rays[4][0];
        const auto add = [&](const Point3& from, const Point3& direction, bool on) {
            HandPoint point{on_skin(from, direction, 0.2), HandPointKind::thenar, cmc, HandJoint::none, 0.5};
            if (on) return add_constraint(point);
            point.place = point.place + beside * direction;
            this->add(point);
        };
        for (const auto& [x, y] : {std::pair{-0.045, 0.07}, {-0.035, 0.15}, {-0.04, 0.23}, {-0.065, 0.31}})
            add({x, y, -0.02}, {0, 0, -1}, true);
        add({-0.13, 0.33, -0.02}, unit({-0.8, 0.2, -0.5}), true);
        for (const auto& [x, y] : {std::pair{-0.14, 0.27}, {-0.12, 0.18}, {-0.11, 0.09}})
            add({x, y, 0}, unit({-0.35, 0, 1}), false);
    }

    void add_metacarpals() {
        for (std::size_t ray = 0; ray < 4; ++ray) {
            const std::size_t joint = hand_.rays[ray][0];
            const HandJoint& j = hand_.joints[joint];
            for (const double share : {0.25, 0.55, 0.85}) {
                const Point3 from = j.place + share * (j.end - j.place);
                for (const double z : {1.0, -1.0}) {
                    const Point3 direction{0, 0, z};
                    add({on_skin(from, direction, 0.2) + beside * direction, HandPointKind::metacarpal,
                         joint});
                }
                if (ray == 3)
                    add({on_skin(from, {1, 0, 0}, 0.2) + beside * Point3{1, 0, 0}, HandPointKind::metacarpal,
                         joint});
                if (ray < 1 || ray == 3 || share < 0.5) continue; // between this one and the next
                const std::size_t next = hand_.rays[ray + 1][0];
                const HandJoint& n = hand_.joints[next];
                const Point3 between = 0.5 * (from + n.place + share * (n.end - n.place));
                for (const double z : {1.0, -1.0}) {
                    const Point3 direction{0, 0, z};
                    add({on_skin(between, direction, 0.2) + beside * direction, HandPointKind::metacarpal,
                         joint, next});
                }
            }
        }
    }

    void add_wrist() {
        for (std::size_t k = 0; k < 12; ++k) {
            const double angle = 2 * std::numbers::pi * double(k) / 12;
            add_constraint(
                {on_skin({0.01, -0.04, 0}, {std::cos(angle), 0, std::sin(angle)}), HandPointKind::wrist});
        }
    }

    Hand& hand_;
    const Skin& skin_;
};

} // namespace

const std::array<HandAngleRange, hand_angle_count> hand_angle_ranges{{
    {"index_spread", -20, 20},  {"index_mcp", -20, 90},       {"index_pip", 0, 110},  {"index_dip", 0, 80},
    {"middle_spread", -15, 15}, {"middle_mcp", -20, 90},      {"middle_pip", 0, 110}, {"middle_dip", 0, 80},
    {"ring_spread", -15, 15},   {"ring_mcp", -20, 90},        {"ring_pip", 0, 110},   {"ring_dip", 0, 80},
    {"little_spread", -25, 25}, {"little_mcp", -20, 90},      {"little_pip", 0, 100}, {"little_dip", 0, 80},
    {"ring_metacarpal", 0, 10}, {"little_metacarpal", 0, 20}, {"thumb_cmc", -10, 45}, {"thumb_oppose", 0, 60},
    {"thumb_mcp", 0, 55},       {"thumb_ip", 0, 80},
}};

const std::vector<NamedHandPose>& hand_poses() {
    static const std::vector<NamedHandPose> poses{
        {"rest", {}},
        {"fist", {-8, 82, 100, 62, 0, 84, 104, 64, -6, 84, 102, 62, -14, 84, 98, 60, 5, 10, 30, 38, 45, 50}},
        {"point", {0, 0, 4, 2, 0, 84, 104, 64, -6, 84, 102, 62, -14, 84, 98, 60, 5, 10, 34, 42, 45, 50}},
        {"ball", {6, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 6, 0, 0, 0, 4, 8, -10, 60, 0, 0}},
        {"rod", {-8, 0, 0, 0, -2, 0, 0, 0, -6, 0, 0, 0, -16, 0, 0, 0, 4, 8, -5, 58, 0, 0}},
        {"spread", {14, -6, 0, 0, 2, -6, 0, 0, 10, -6, 0, 0, 18, -6, 0, 0, 0, 0, -10, 0, 0, 0}},
        {"pinch", {0, 14, 14, 9, 0, 20, 20, 14, -2, 34, 34, 22, 16, 89, 100, 80, 10, 12, 19, 51, 41, 80}},
    };
    return poses;
}

const char* to_string(HandPointKind kind) {
    switch (kind) {
    case HandPointKind::ring: return "ring";
    case HandPointKind::base: return "base";
    case HandPointKind::thenar: return "thenar";
    case HandPointKind::middle: return "middle";
    case HandPointKind::shield: return "shield";
    case HandPointKind::tip: return "tip";
    case HandPointKind::inflation: return "inflation";
    case HandPointKind::metacarpal: return "metacarpal";
    case HandPointKind::wrist: return "wrist";
    case HandPointKind::surround: return "surround";
    }
    return "unknown";
}

std::vector<Point3> Hand::sites() const {
    std::vector<Point3> places;
    for (const HandPoint& point : points) places.push_back(point.place);
    return places;
}

std::vector<RigidMotion3> Hand::bones(const HandPose& angles) const {
    std::vector<RigidMotion3> motions;
    for (const HandJoint& joint : joints) {
        const RigidMotion3 own = JointTurn(joint, angles).motion(1);
        motions.push_back(joint.parent == HandJoint::none ? own : after(motions[joint.parent], own));
    }
    return motions;
}

std::vector<Point3> Hand::pose(const HandPose& angles, bool half) const {
    const auto motions = bones(angles);
    std::vector<Point3> places;
    for (const HandPoint& point : points) {
        Point3 p = point.place;
        double part = half ? point.part : 1;
        if (point.joint != HandJoint::none && point.other == HandJoint::none) {
            const HandJoint& joint = joints[point.joint];
            p = JointTurn(joint, angles).motion(part)(p);
            if (joint.parent != HandJoint::none) p = motions[joint.parent](p);
        } else { // both joints have the same number of parents
            for (std::size_t a = point.joint, b = point.other; a != HandJoint::none;
                 a = joints[a].parent, b = joints[b].parent, part = 1)
                p = mean(JointTurn(joints[a], angles), JointTurn(joints[b], angles)).motion(part)(p);
        }
        places.push_back(p);
    }
    return places;
}

std::vector<double> Hand::weights(const HandPose& angles, double kappa) const {
    std::vector<double> all(points.size(), 1.0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].kind != HandPointKind::inflation) continue;
        const double angle = angles[joints[points[i].joint].bend] * std::numbers::pi / 180;
        all[i] += kappa * (1 - std::cos(angle));
    }
    return all;
}

double HandObject::distance(const Point3& p) const {
    return length(to - from) > 0 ? limb(p, from, to, radius, radius) : ball(p, from, radius);
}

const HandObject& hand_ball() {
    static const HandObject object{{0.0, 0.44, -0.29}, {0.0, 0.44, -0.29}, 0.2};
    return object;
}
const HandObject& hand_rod() {
    static const HandObject object{{-0.35, 0.48, -0.165}, {0.4, 0.42, -0.19}, 0.075};
    return object;
}

HandPose grasp(const Hand& hand, const HandPose& open, const HandObject& object) {
    HandPose pose = open;
    for (const auto& ray : hand.rays) {
        const std::size_t first = &ray == &hand.rays[4] ? 0 : 1;
        for (std::size_t k = first; k < ray.size(); ++k) {
            const std::size_t angle = hand.joints[ray[k]].bend;
            const auto touches = [&] {
                const auto places = hand.pose(pose);
                for (std::size_t i = 0; i < places.size(); ++i) {
                    const HandPoint& point = hand.points[i];
                    const bool beyond =
                        std::find(ray.begin() + std::ptrdiff_t(k), ray.end(), point.joint) != ray.end();
                    const bool own = point.kind == HandPointKind::middle || point.kind == HandPointKind::tip;
                    if (beyond && own && point.vertex != HandJoint::none && object.distance(places[i]) < 0)
                        return true;
                }
                return false;
            };
            double closed = hand_angle_ranges[angle].most, free = pose[angle];
            if (touches()) continue;
            for (int step = 0; step < 30; ++step) {
                pose[angle] = (free + closed) / 2;
                (touches() ? closed : free) = pose[angle];
            }
            pose[angle] = free;
        }
    }
    return pose;
}

double skin_function(const Hand& hand, const Point3& p) {
    return Skin(hand)(p);
}

Hand make_hand(double cell) {
    Hand hand;
    for (std::size_t ray = 0; ray < 5; ++ray) add_ray(hand, ray);
    const Skin skin(hand);
    hand.skin = surface_nets(skin, {-0.62, -0.28, -0.32}, {0.48, 1.12, 0.22}, cell);
    for (const Point3& p : hand.skin.vertices) {
        std::size_t nearest = 0;
        for (std::size_t j = 1; j < hand.joints.size(); ++j) {
            if (bone(hand.joints[j], p) < bone(hand.joints[nearest], p)) nearest = j;
        }
        hand.vertex_joint.push_back(nearest);
    }
    Points(hand, skin).add_all();
    auto all = hand.skin.vertices;
    for (const HandPoint& point : hand.points) all.push_back(point.place);
    const auto box = cageform::surround(
        all, {.margin = 0.3, .sites = cageform::SurroundSites::lattice}); // room for bent fingers
    for (const Point3& site : box.value) hand.points.push_back({site});
    return hand;
}

std::string obj_text(const ImplicitMesh& mesh, const std::string& comment) {
    std::string text = "# " + comment + '\n';
    for (const Point3& p : mesh.vertices)
        text += cageform_support::formatted("v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    for (const auto& [a, b, c] : mesh.faces)
        text += cageform_support::formatted("f %u %u %u\n", a + 1, b + 1, c + 1);
    return text;
}

} // namespace cageform_sources
