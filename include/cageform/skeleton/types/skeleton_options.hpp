// Options and report of `fit_skeleton`.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// Maps of bones.
enum class BoneKind : std::uint8_t {
    rigid,     ///< rotation and translation: supported by all engines
    similar,   ///< also a uniform scale; children scale too
    stretched, ///< affine: only for players that use matrices
};

struct SkeletonOptions {
    static constexpr std::size_t largest_bones = 1024;

    std::size_t bones = 0;      ///< 0: as few as max_distance allows
    std::size_t influences = 4; ///< maximum number of weights per vertex, 1 to 8
    BoneKind kind = BoneKind::rigid;
    /// Maximum distance of every vertex in every frame, relative to the figure's diagonal in the rest pose.
    /// 0: no limit. If `bones` is set, the report counts the vertices beyond this distance.
    double max_distance = 0;
    /// Number of rounds after idle bones have been moved. A round fits the weights, then the bones. The
    /// rounds after the tenth are accelerated. More moves often help more than more rounds.
    std::size_t rounds = 10;
    std::size_t moves = 8; ///< attempts to move idle bones to the largest errors
};

struct SkeletonReport {
    Status status = Status::ok;
    std::size_t bones = 0;
    double rms = 0;          ///< RMS of all distances, relative to the figure's diagonal in the rest pose
    double max_distance = 0; ///< relative to the same diagonal
    /// Where max_distance is reached; with frame_not_finite, the invalid point.
    std::size_t frame = 0, vertex = 0;
    double turn = 0;            ///< rotation error of the faces: 99th percentile, in degrees
    double mean_influences = 0; ///< mean number of weights above 0 per vertex
    std::size_t beyond = 0;     ///< vertices beyond SkeletonOptions::max_distance
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
