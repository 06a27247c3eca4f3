// Options and reports of packing.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/figure/figure.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <optional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The *distance* of a point is the distance between where the packed binding and the original
/// binding put it, in the units of the figure; for a vector it is the length of the difference.
/// Only bending poses have a distance: rest and affine poses stay exact.
struct PackOptions {
    /// Storage of the weights. Empty: of the formats that keep the tolerance, the one with the
    /// fewest bytes; without a tolerance, scalar.
    std::optional<WeightFormat> format{};
    /// The largest weights of a point, which it keeps: this many, at least D + 1. 0, or the number of
    /// handles or more: their number is no reason to drop weights.
    std::size_t largest = 0;
    /// Weights below this may be dropped, unless the block has a row for them anyway. 0: their size
    /// is no reason to drop weights.
    double threshold = 0;
    /// The largest distance allowed for any point, over `poses` if given, else within `reach`. If
    /// `largest` or `threshold` drops weights, the rows for the others are required, and more are
    /// added to a block until the distance is kept. If both are 0, no rows are required, and the
    /// distance alone decides which weights are kept. 0: no limit; with all three 0, nothing is dropped.
    double tolerance = 0;
    /// The poses in which distances are measured, for instance those of a clip: #poses · #handles ·
    /// D numbers, as `append_pose` writes them. Weights are fitted to these poses, with a small
    /// share for any other movement.
    std::span<const double> poses{};
    /// Without poses, distances are bounded over all poses in which every handle lies within this
    /// distance of an affine image of the handles at rest. 0: a tenth of the cage's size. Face
    /// normals violate this bound even under affine poses. With Green coordinates, pass `poses`.
    double reach = 0;
    /// Sparse bindings only, #points: the point stored at each position. Empty: points are sorted
    /// by position, so that the points of a block are close to each other. For vectors pass the
    /// order of the packed binding of their points (PackedBindingView::order), because vectors do
    /// not show which of them are neighbours.
    std::span<const std::uint32_t> order{};
    std::uint64_t cage_hash = 0; ///< stored in the blob; 0: `hash_memory` of the handles at rest
    /// Stored in the blob; 0: `hash_memory` of the points at rest, as Vec<T, D>.
    std::uint64_t figure_hash = 0;
};

/// Appends a pose to PackOptions::poses: a point for every handle of the binding, including
/// vectors, in their order and units. May throw std::bad_alloc.
template <PointRange Pose>
void append_pose(std::vector<double>& poses, const Pose& pose) {
    for (std::size_t i = 0; i < std::size(pose); ++i) {
        const auto p = to_vec<double>(pose[i]);
        poses.insert(poses.end(), p.v, p.v + range_dimension<Pose>);
    }
}

/// How packing went. The error of a point is Σ |w' − w| over all handles, where w' are the weights
/// that the packed binding has in effect. In a pose whose handles all lie within d of an affine image
/// of the handles at rest, a point is at most error · d from where the original binding puts it.
struct PackReport {
    Status status = Status::ok;
    /// weight_not_finite: the point; pose_not_finite: the pose; format_too_coarse: the farthest
    /// point
    std::size_t culprit = Extreme::none;
    WeightFormat format = WeightFormat::scalar;
    std::size_t points = 0, handles = 0;
    std::size_t poses = 0;        ///< in which distances were measured; 0: all within `reach`
    double reach = 0;             ///< that of the options, or a tenth of the cage's size
    double size = 0;              ///< of the figure: the diagonal of the box around the points at rest
    std::size_t rows = 0;         ///< rows of weights over all blocks
    double weights_per_point = 0; ///< stored, zeros included
    std::size_t bytes = 0;        ///< of the blob
    std::size_t dense_bytes = 0;  ///< of the binding
    std::vector<float> errors;    ///< #points
    Extreme error;                ///< the largest of them
    double mean_error = 0;
    std::vector<float> distances; ///< #points: the largest one over the poses
    /// The largest of them. With format_too_coarse: a tolerance that the format could keep.
    Extreme distance;
    std::size_t distance_pose = Extreme::none; ///< the pose with that distance; none without poses
    double mean_distance = 0;
    /// The largest change of a kept weight by which Σ w and Σ w c are restored.
    Extreme weight_change;
    /// Rows beyond those required, added because a block's handles would lie too nearly in one plane.
    std::size_t rows_added = 0;
    double seconds = 0;
};

struct FigurePackOptions {
    /// How weights are packed. The order and the tolerance apply to the points; tangents use the
    /// same order.
    PackOptions weights{};
    /// The largest change of a unit tangent, in radians if it rotates; it can be used with or
    /// without a tolerance of the points. 0: ten times the tolerance of the points over the size of
    /// the figure, at most 1. Reason: where features have a tenth of the figure's size, moving a
    /// point by d relative to its neighbours rotates the surface by ten times d over the size. No
    /// tolerance if the points have none.
    double tangent_tolerance = 0;
    /// Clips that move the figure, as packed by `pack_clip`. Each has its own name, and as many
    /// vertices as the figure has handles, or handles that are points.
    std::span<const FigureClipData> clips{};
    /// Levels of less detail, at most 9: packed figures of the same handles, without levels of
    /// their own (PackedFigure::bytes).
    std::span<const std::span<const std::byte>> levels{};
    /// Further parts to be stored in the figure, under their own tags.
    std::span<const FigurePartData> parts{};
};

struct FigurePackReport {
    Status status = Status::ok;
    FigureTag culprit;            ///< the part that the status refers to; 0: the figure as a whole
    std::size_t culprit_clip = 0; ///< with FigureTags::clips: the number of the clip
    PackReport points;
    std::array<PackReport, 2> vectors; ///< for tangents and bitangents
    std::size_t bytes = 0;             ///< of the figure
    double seconds = 0;
};

struct StreamedPackOptions {
    BindOptions bind{};
    /// How weights are packed. Without a format `scalar` is used: the smallest format is only known
    /// after all batches.
    PackOptions pack{};
    /// In bytes: the size of the weights that are bound at once. A batch has at least one block of
    /// points.
    std::size_t batch = std::size_t{64} << 20;
};

/// The reports of both steps.
struct StreamedPackReport {
    Status status = Status::ok; ///< of the step that failed
    BindReport bound;
    PackReport packed; ///< not filled if the bind fails
};

/// The memory of a streamed `pack` beside its points and their order, in bytes.
struct StreamedPackMemory {
    std::size_t solver = 0; ///< of coordinates with a solver, on one thread; else 0
    /// The most that the solved functions take, kept until all points are bound.
    std::size_t functions = 0;
    std::size_t batch = 0; ///< the weights of one batch
    /// The result, at most: as if nothing were dropped; twice that while batches are joined.
    std::size_t packed = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
