// The options and the report of `fit_skeleton`.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// How the bones of a skeleton move.
enum class BoneKind : std::uint8_t {
    rigid,     ///< they turn and move: every engine plays these
    similar,   ///< one scale besides; the children of a bone scale with it
    stretched, ///< any affine map: only players that multiply matrices show these
};

struct SkeletonOptions {
    static constexpr std::size_t largest_bones = 1024;

    std::size_t bones = 0;      ///< 0: as few as keep max_distance
    std::size_t influences = 4; ///< weights a vertex, 1 to 8
    BoneKind kind = BoneKind::rigid;
    /// The distance, a share of the figure's diagonal at rest, within which every vertex is to stay in every
    /// frame; 0: none. With `bones` the report counts the vertices that are farther away.
    double max_distance = 0;
    /// Rounds of weights and bones, after idle bones have found their places. Those after the tenth are
    /// accelerated; more moves often help more.
    std::size_t rounds = 10;
    std::size_t moves = 8; ///< tries to move idle bones to where the error is largest
};

struct SkeletonReport {
    Status status = Status::ok;
    std::size_t bones = 0;             ///< of the skeleton
    double rms = 0;                    ///< of all distances, a share of the figure's diagonal at rest
    double max_distance = 0;           ///< the largest, as such a share
    std::size_t frame = 0, vertex = 0; ///< where it is; if the status is frame_not_finite, where that is
    double turn = 0;                   ///< degrees by which 99 % of the faces are turned wrongly at most
    double mean_influences = 0;        ///< weights above 0 of a vertex
    std::size_t beyond = 0;            ///< vertices farther away than SkeletonOptions::max_distance
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
