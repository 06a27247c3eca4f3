#pragma once

// A right hand in three layers (Moccozet, Magnenat-Thalmann, Dirichlet free-form deformations and their
// application to hand simulation, Computer Animation '97, sec. 3): joint angles move control points, and
// these move the skin.
//
// Lengths are in hand lengths. The wrist is at the origin, the fingers point along y, the thumb to -x, the
// back of the hand faces z.

#include "files/mesh_file.hpp"
#include "pictures/surface_nets.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// The angles of the joints. Four fingers have a metacarpal (which bends only in the ring and the little
/// finger) and three phalanges; the thumb has three bones. The first joint of each finger and of the
/// thumb turns about two axes.
enum class HandAngle : std::uint8_t {
    index_spread,
    index_mcp,
    index_pip,
    index_dip,
    middle_spread,
    middle_mcp,
    middle_pip,
    middle_dip,
    ring_spread,
    ring_mcp,
    ring_pip,
    ring_dip,
    little_spread,
    little_mcp,
    little_pip,
    little_dip,
    ring_metacarpal,
    little_metacarpal,
    thumb_cmc,
    thumb_oppose,
    thumb_mcp,
    thumb_ip,
};
inline constexpr std::size_t hand_angle_count = 22;
using HandPose = std::array<double, hand_angle_count>; ///< degrees, in the order of HandAngle

struct HandAngleRange {
    const char* name;
    double least, most; // degrees
};
extern const std::array<HandAngleRange, hand_angle_count> hand_angle_ranges;

struct NamedHandPose {
    const char* name;
    HandPose angles;
};
/// rest, fist, point, spread, pinch (thumb to little finger), and ball and rod, the open poses for grasp().
const std::vector<NamedHandPose>& hand_poses();

/// A joint at rest, and the angles that turn it.
struct HandJoint {
    static constexpr std::size_t none = ~std::size_t{0};

    std::size_t parent = none;
    Point3 place{}, bend_axis{}, spread_axis{}; // axes are 0 if not used
    std::size_t bend = none, spread = none;     ///< HandAngle of each axis, or none
    double radius = 0;                          ///< of the skin at the joint
    Point3 end{};                               ///< of its bone
    double end_radius = 0;
};

enum class HandPointKind : std::uint8_t {
    ring,
    base,
    thenar,
    middle,
    shield, ///< free points between a finger and the next
    tip,
    inflation,
    metacarpal,
    wrist,
    surround
};
const char* to_string(HandPointKind kind);

/// A control point.
struct HandPoint {
    Point3 place{};
    HandPointKind kind = HandPointKind::surround;
    std::size_t joint = HandJoint::none; ///< none: fixed
    std::size_t other =
        HandJoint::none; ///< shared by two joints: turned by the mean angle about the mean axis
    double part = 1;     ///< share of the joint's angles; 0.5 for ring, base, thenar
    std::size_t vertex = HandJoint::none; ///< vertex of the skin of a constraint point
};

struct RigidMotion3 {
    std::array<Point3, 3> rows{Point3{1, 0, 0}, Point3{0, 1, 0}, Point3{0, 0, 1}};
    Point3 shift{};

    Point3 operator()(const Point3& p) const {
        return Point3{dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)} + shift;
    }
};

struct Hand {
    std::vector<HandJoint> joints;                ///< five rays, from the wrist outwards
    std::array<std::vector<std::size_t>, 5> rays; ///< index, middle, ring, little, thumb: joints of each
    ImplicitMesh skin;
    std::vector<std::size_t> vertex_joint; ///< the nearest bone of each vertex of the skin
    std::vector<HandPoint> points;

    std::vector<Point3> sites() const;
    /// The posed control points. If `half` is false, rings turn by the full angle, with their bones.
    std::vector<Point3> pose(const HandPose& angles, bool half = true) const;
    /// The motions of the bones, as `joints`.
    std::vector<RigidMotion3> bones(const HandPose& angles) const;
    /// Weights of the control points: 1, and 1 + kappa (1 − cos angle) of inflation points.
    std::vector<double> weights(const HandPose& angles, double kappa) const;
};

/// An object to grasp: a rod with round ends, or a ball if both ends are equal.
struct HandObject {
    Point3 from, to;
    double radius = 0;

    double distance(const Point3& p) const; ///< negative inside
};
const HandObject& hand_ball();
const HandObject& hand_rod();

/// Closes the fingers around an object, from the base outwards. A joint stops where a constraint point of its
/// finger touches the object (by bisection), or at the end of its range.
///
///   open   the initial pose; only bending angles change
HandPose grasp(const Hand& hand, const HandPose& open, const HandObject& object);

/// The approximate signed distance of a point from the skin at rest, negative inside.
double skin_function(const Hand& hand, const Point3& p);

/// The hand at rest.
///
///   cell   cell size of the grid that meshes the skin, in hand lengths
Hand make_hand(double cell);

/// A mesh as an OBJ file that begins with a comment.
std::string obj_text(const ImplicitMesh& mesh, const std::string& comment);

} // namespace cageform_sources
