#pragma once

// The options and the steps by which programs find a skeleton in a motion.

#include "cli/command_line.hpp"
#include "files/bind_report.hpp"
#include "files/obj_file.hpp"
#include "svg/path.hpp"

#include <cageform/skeleton/fit_skeleton.hpp>

#include <string>
#include <vector>

namespace cageform_support {

/// A share as words give it: 0.002 or 0.2%.
///
///   returns   why it is none, from 0 to 1; empty where it is one
std::string parse_share(const std::string& word, double& share);

/// Adds an option whose value is a share.
CommandOption add_share(CommandLine& line, const std::string& name, double& share, const std::string& help);

struct SkeletonChoice {
    static constexpr double default_distance = 0.002;

    std::string bones; ///< a number or "auto"; empty: no skeleton
    double distance = 0;
    std::string kind = "rigid";
    std::size_t influences = 4;
    bool flat = false;
    bool tangents = false; ///< of keys

    /// Adds and returns --kind, --influences, --flat and --tangents; programs add --bones and --max-distance
    /// in their words.
    std::vector<CommandOption> add_options(CommandLine& line);
    /// Why `bones` is neither; empty where it is one.
    static std::string fault_of_bones(const std::string& word);
};

/// A figure and where its vertices are in each frame. Programs write these places in single precision: they
/// count them from near the figure (far_origin()).
struct FigureFrames {
    std::string name; ///< of the figure, for messages
    std::span<const Point3> rest;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    std::vector<std::vector<Point3>> places; ///< #frames · #vertices
    std::vector<double> times;               ///< #frames, in seconds; floats, ascending
    std::vector<std::string> files;          ///< #frames; or one of all; none: the frames have no file
};

/// A skeleton and its keys, and how far the figure as it is played is from its frames.
struct FittedMotion {
    cageform::FittedSkeleton<double> skeleton;
    cageform::SkeletonKeys<double> keys;
    std::vector<std::vector<Point3>> played; ///< #frames · #vertices
    StoredLoss loss;
    double rms = 0; ///< a share of the figure's size
    cageform::SkeletonReport report;
    cageform::SkeletonKeysReport keys_report;
};

/// A skin as a file stores it.
///
///   weights   float, unorm8 or unorm16
cageform::SkinWeights stored_skin(const cageform::SkinWeights& skin, const std::string& weights);

/// Fits a skeleton as the options choose it. Keys may use a fifth of the distance.
///
///   weights   as which they are stored: float, unorm8 or unorm16
///   fails     where the motion cannot be fitted, or the distance is asked for and not kept
Expected<FittedMotion> fit_motion(const SkeletonChoice& choice, const FigureFrames& frames,
                                  const std::string& weights = "float");

/// Bones, keys, distances and times, a line each.
std::string describe(const FittedMotion& motion);

/// "20 bones".
std::string count_bones(const FittedMotion& motion);

/// "off by at most …; faces turned by 4 degrees".
std::string describe_loss(const FittedMotion& motion);

} // namespace cageform_support
