#pragma once

// Fits skeletons to motions, with options.

#include "cli/command_line.hpp"
#include "files/bind_report.hpp"
#include "files/mesh_file.hpp"
#include "svg/path.hpp"

#include <cageform/skeleton/fit_skeleton.hpp>

#include <string>
#include <vector>

namespace cageform_support {

/// Parses a fraction from 0 to 1, such as 0.002 or 0.2%.
///
///   returns   the error; empty on success
std::string parse_share(const std::string& word, double& share);

/// Adds an option with a fraction.
CommandOption add_share(CommandLine& line, const std::string& name, double& share, const std::string& help);

struct SkeletonChoice {
    static constexpr double default_distance = 0.002;

    std::string bones;   ///< a number or "auto"; empty: no skeleton
    double distance = 0; ///< largest error, relative to the figure's size; 0: none, with "auto" the default
    std::string kind = "rigid";
    std::size_t influences = 4;
    bool flat = false;
    bool tangents = false; ///< of keys

    /// Adds --kind, --influences, --flat and --tangents, and returns them. Programs add --bones and
    /// --max-distance with their own help.
    std::vector<CommandOption> add_options(CommandLine& line);
    /// Error if `bones` is neither a number nor "auto"; else empty.
    static std::string fault_of_bones(const std::string& word);
};

/// A figure and its vertex positions per frame. Programs write positions in single precision relative to
/// far_origin().
struct FigureFrames {
    std::string name; ///< of the figure, for messages
    std::span<const Point3> rest;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    std::vector<std::vector<Point3>> places; ///< #frames · #vertices
    std::vector<double> times;               ///< #frames, in seconds; floats, ascending
    std::vector<std::string> files;          ///< one per frame, one for all frames, or none
};

/// A skeleton, its keys, and the error of the played figure.
struct FittedMotion {
    cageform::FittedSkeleton<double> skeleton;
    cageform::SkeletonKeys<double> keys;
    std::vector<std::vector<Point3>> played; ///< #frames · #vertices
    PackingLoss loss;
    double rms = 0; ///< relative to the figure's size
    cageform::SkeletonReport report;
    cageform::SkeletonKeysReport keys_report;
};

/// A skin as stored in a file.
///
///   weights   float, unorm8 or unorm16
cageform::SkinWeights stored_skin(const cageform::SkinWeights& skin, const std::string& weights);

/// Fits a skeleton and keys. The keys may cause up to a fifth of the maximum distance.
///
///   weights   as stored: float, unorm8 or unorm16
///   fails     if the motion cannot be fitted, or a requested distance is exceeded
FittedMotion fit_motion(const SkeletonChoice& choice, const FigureFrames& frames,
                        const std::string& weights = "float");

/// Formats bones, keys, distances and times, one line each.
std::string describe(const FittedMotion& motion);

/// "20 bones".
std::string count_bones(const FittedMotion& motion);

/// "off by at most …; faces turned by 4 degrees".
std::string describe_loss(const FittedMotion& motion);

} // namespace cageform_support
