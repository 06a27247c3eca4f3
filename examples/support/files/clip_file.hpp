#pragma once

// Motion files of cages. In the plane: controls that move vertices, with keys.
//
//     length,2.4                  duration in seconds, after which the clip repeats
//     late,far-legs,0.6           the element far-legs moves 0.6 s later
//     ground,744,166              a ground at y = 744 that moves to the right, 166 units per second
//
//     control,the tail sways
//     vertices,11:0.5,10,9        with weights, 1 by default
//     pivot,775,400               rotation centre of the vertices
//     time,x,y,turn,kind
//     0.0,0,0,-6,ease
//     1.2,0,0,6,ease
//     2.4,0,0,-6,ease
//
//     pin,the nose,130,240        a point of the figure moves in place of vertices, and the cage follows
//     time,x,y,turn,kind
//     0.0,0,0,0,ease
//     …
//
// A key moves the vertices by x and y and turns them by `turn` degrees, clockwise on the screen. Its kind is
// hold, linear, automatic, or ease (Bézier handles with zero slope). A control repeats after its last key, so
// the clip has to last a multiple of its duration. If several controls move a vertex, their motions add up.

#include "svg/path.hpp"

#include <cageform/animate/curves/key.hpp>
#include <cageform/clip/clip.hpp>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Help text on the format above.
inline constexpr const char* clip_format =
    "A motion of a cage in the plane is a CSV file of controls. Each control moves some\n"
    "vertices, and its keys give the distances and times:\n"
    "\n"
    "    length,2.4              the duration in seconds, after which the clip repeats\n"
    "    late,far-legs,0.6       the element with this id moves 0.6 s later\n"
    "    ground,744,166          a ground at y = 744 moves right, 166 units per second\n"
    "\n"
    "    control,the tail sways\n"
    "    vertices,11:0.5,10,9    counted from 0; with weights, 1 by default\n"
    "    pivot,775,400           the vertices turn about this point\n"
    "    time,x,y,turn,kind\n"
    "    0.0,0,0,-6,ease         moves by x = 0 and y = 0, and turns by -6 degrees\n"
    "    1.2,0,0,6,ease\n"
    "    2.4,0,0,-6,ease\n"
    "\n"
    "A key is hold, linear, automatic or ease. A control repeats after its last key, so\n"
    "the clip has to last a multiple of its duration. If several controls move a vertex,\n"
    "their motions add up. late and ground are optional; # begins a comment. Turns are\n"
    "linearised: vertices move along the tangent and end farther from the pivot, by\n"
    "1.5 % at 10 degrees and 22 % at 40.\n"
    "\n"
    "Instead of controls a clip can have pins, which move points of the figure; the cage\n"
    "follows as rigidly as possible, and its motion becomes keys. At a pin without\n"
    "turns, the figure is free to turn:\n"
    "\n"
    "    pin,the nose,130,240,1  its rest position, and an optional weight\n"
    "    time,x,y,turn,kind\n"
    "    0.0,0,0,0,ease\n";

/// Help text on motions in space.
inline constexpr const char* pose_clip_format =
    "A motion of a cage in space is a CSV file of its poses:\n"
    "\n"
    "    length,2.4              the duration in seconds, after which the first pose returns\n"
    "    pose,0,smooth           the time of a pose, and smooth, linear or ease\n"
    "    0.1,1.5,-0.2            x,y,z of every vertex, in the cage's order\n"
    "    …\n"
    "    pose,0.8,smooth\n"
    "    …\n"
    "\n"
    "The first pose is at time 0, and times ascend; # begins a comment.\n";

struct ClipControl {
    struct Share {
        std::size_t vertex = 0;
        double weight = 1;
    };
    struct Row {
        double time = 0;              // seconds
        std::array<double, 3> move{}; // x, y, turn in radians
        cageform::KeyKind kind = cageform::KeyKind::automatic;
    };
    struct Pin {
        Point2 place; // at rest
        double weight = 1;
    };
    std::string name;
    std::vector<Share> shares; // empty for a pin
    Point2 pivot;
    std::vector<Row> rows;
    std::optional<Pin> pin = {};
};

struct ClipFile {
    struct Late {
        std::string element;
        double seconds = 0;
    };
    struct Ground {
        double y = 0, speed = 0; // speed to the right, in units per second
    };
    std::string name;
    double length = 0;
    std::vector<Late> late;
    std::optional<Ground> ground;
    std::vector<ClipControl> controls; // either all with vertices or all with pins

    bool has_pins() const { return !controls.empty() && controls.front().pin.has_value(); }
};

/// Parses a planar motion.
///
///   name    prefix of every message
///   fails   on an unknown line, a number that is not finite, a vertex not below `vertex_count`; if times of
///           a control do not ascend, the length is not a multiple of the control's duration, or controls and
///           pins are mixed
Expected<ClipFile> parse_clip(std::string_view text, const std::string& name, std::size_t vertex_count);

/// As parse_clip(), from a file; fails also if it cannot be read.
Expected<ClipFile> load_clip(const std::string& path, std::size_t vertex_count);

/// The text of a clip file. parse_clip() restores every bit except of turns.
std::string clip_text(const ClipFile& clip, const std::string& heading);

/// The repeating motion of a cage with these vertices.
Expected<cageform::CageClip<double, 2>> make_clip(const ClipFile& file, std::span<const Point2> vertices);

/// Interpolation at a pose.
enum class PoseInterpolation : std::uint8_t { smooth, linear, ease };

struct PoseKey {
    double time = 0;
    PoseInterpolation way = PoseInterpolation::smooth;
    std::vector<cageform::Vec<double, 3>> places; // of all vertices
};

/// A motion in space. The first key is at time 0; times ascend and are less than the length, after which the
/// motion repeats.
struct PoseClip {
    std::string name; // for messages
    double length = 0;
    std::vector<PoseKey> keys;
};

/// Parses a motion in space.
///
///   name    prefix of every message
///   fails   on an invalid number, time or interpolation, a number out of single precision; if a pose does
///           not have `vertex_count` lines, or times do not ascend from 0 to less than the length in single
///           precision
Expected<PoseClip> parse_pose_clip(std::string_view text, const std::string& name, std::size_t vertex_count);

/// As parse_pose_clip(), from a file; fails also if it cannot be read.
Expected<PoseClip> load_pose_clip(const std::string& path, std::size_t vertex_count);

/// The text of a motion in space, with six decimals.
std::string pose_clip_text(const PoseClip& clip, const std::string& heading);

/// The curve through one value per key (`values`, #keys) over one period, one piece per key. It depends
/// linearly on the values, so a linear function of the poses follows the curve through its own values.
cageform::PiecewiseCubic<double> curve_through(const PoseClip& clip, std::span<const double> values);

/// The repeating motion of the vertices.
template <cageform::Scalar T>
cageform::CageClip<T, 3> make_clip(const PoseClip& clip) {
    std::vector<cageform::PiecewiseCubic<T>> curves;
    std::vector<double> values(clip.keys.size());
    for (std::size_t i = 0; i < clip.keys.front().places.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t k = 0; k < values.size(); ++k) values[k] = clip.keys[k].places[i][axis];
            std::vector<cageform::CubicPiece<T>> pieces;
            const auto curve = curve_through(clip, values);
            for (const auto& [begin, c0, c1, c2, c3] : curve.pieces())
                pieces.push_back({T(begin), T(c0), T(c1), T(c2), T(c3)});
            curves.emplace_back(std::move(pieces), T(clip.length), T(curve.end_value()));
        }
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    return cageform::CageClip<T, 3>(curves, cycle, cycle);
}

/// Poses of a motion: those of the keys, and at least three between consecutive keys.
struct SampledPoses {
    std::vector<double> times;   // in seconds
    std::vector<double> numbers; // #times · #vertices · 3, as in PackOptions::poses
};
///   rate   minimum number of poses per second
SampledPoses sample_poses(const PoseClip& clip, double rate = 0);

/// "walk.csv after 0.5 s": names a pose in messages.
std::string name_of_pose(const PoseClip& clip, double time);

} // namespace cageform_support
