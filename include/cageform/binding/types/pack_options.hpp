// Options and reports of packing.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/figure/figure.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <optional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The *distance* of a point is that between its positions from the packed and from the original binding,
/// in the units of the figure. For a vector it is the length of the difference. The distance is zero in
/// rest and affine poses.
struct PackOptions {
    /// Storage of the weights. Empty: the smallest format that meets the tolerance; without a
    /// tolerance, scalar.
    std::optional<WeightFormat> format{};
    /// Maximum number of weights of a point, at least D + 1; the largest are kept. 0: no limit.
    std::size_t largest = 0;
    /// Weights below this may be dropped, unless the block has a row for them anyway. 0: no limit.
    double threshold = 0;
    /// The maximum distance of any point, over `poses` if given, else within `reach`. If `largest` or
    /// `threshold` drop weights, the rows of the kept ones are required, and rows are added to a block
    /// until it meets the tolerance. If both are 0, only the distance decides which weights are kept.
    /// 0: no limit; if all three are 0, nothing is dropped.
    double tolerance = 0;
    /// The poses in which distances are measured, for instance those of a clip: #poses · #handles · D
    /// numbers, see `append_pose`. Weights are fitted to these poses, with a small share of other movements.
    std::span<const double> poses{};
    /// Without poses, distances are bounded over all poses in which every handle is within this
    /// distance of an affine image of the handles at rest. 0: a tenth of the cage's size. Face normals
    /// violate this bound even in affine poses; with Green coordinates, pass `poses`.
    double reach = 0;
    /// Sparse bindings only, #points: the point stored at each position. Empty: points are sorted
    /// spatially. For vectors, pass the order of the packed binding of their points
    /// (PackedBindingView::order), because vectors have no positions.
    std::span<const std::uint32_t> order{};
    std::uint64_t cage_hash = 0; ///< stored in the blob; 0: `hash_memory` of the handles at rest
    /// Stored in the blob; 0: `hash_memory` of the points at rest, as Vec<T, D>.
    std::uint64_t figure_hash = 0;
};

/// Appends a pose to PackOptions::poses: all handles of the binding, including vectors, in their order
/// and units. May throw std::bad_alloc.
template <PointRange Pose>
void append_pose(std::vector<double>& poses, const Pose& pose) {
    for (std::size_t i = 0; i < std::size(pose); ++i) {
        const auto p = to_vec<double>(pose[i]);
        poses.insert(poses.end(), p.v, p.v + range_dimension<Pose>);
    }
}

/// The result of packing. The error of a point is Σ |w' − w| over all handles, where w' are the
/// effective weights of the packed binding. If all handles lie within d of an affine image of the
/// handles at rest, the distance of the point is at most error · d.
struct PackReport {
    Status status = Status::ok;
    /// weight_not_finite: the point; pose_not_finite: the pose; format_too_coarse: the point with the
    /// largest distance
    std::size_t culprit = Extreme::none;
    WeightFormat format = WeightFormat::scalar;
    std::size_t points = 0, handles = 0;
    std::size_t poses = 0;        ///< number of given poses; 0: distances are bounds within `reach`
    double reach = 0;             ///< of the options, or a tenth of the cage's size
    double size = 0;              ///< of the figure: the diagonal of the bounds of the points at rest
    std::size_t rows = 0;         ///< rows of weights over all blocks
    double weights_per_point = 0; ///< stored, zeros included
    std::size_t bytes = 0;        ///< of the blob
    std::size_t dense_bytes = 0;  ///< of the binding
    std::vector<float> errors;    ///< #points
    Extreme error;                ///< the largest of `errors`
    double mean_error = 0;
    std::vector<float> distances; ///< #points: the largest one over the poses
    /// The largest of `distances`. With format_too_coarse: a tolerance that the format can meet.
    Extreme distance;
    std::size_t distance_pose = Extreme::none; ///< the pose with that distance; none without poses
    double mean_distance = 0;
    /// The largest change of a kept weight by restoring Σ w and Σ w c.
    Extreme weight_change;
    /// Rows added because the other handles of a block are nearly coplanar.
    std::size_t rows_added = 0;
    double seconds = 0;
};

struct FigurePackOptions {
    /// Options of the weights. The order and the tolerance apply to the points; tangents use the same order.
    PackOptions weights{};
    /// The maximum change of a unit tangent (radians for a rotation), with or without a tolerance of
    /// the points. 0: ten times the tolerance of the points divided by the size of the figure, at most
    /// 1; no limit if the points have no tolerance. Reason: for features of a tenth of the figure's size,
    /// moving a point by d rotates the surface by ten times d divided by the size.
    double tangent_tolerance = 0;
    /// Clips of the figure, packed by `pack_clip`, with different names. A clip has one vertex per
    /// handle of the figure, or one per point handle.
    std::span<const FigureClipData> clips{};
    /// Levels of less detail, at most 9: packed figures of the same handles (PackedFigure::bytes),
    /// which have no levels themselves.
    std::span<const std::span<const std::byte>> levels{};
    /// Custom parts to store in the figure, with tags other than FigureTags.
    std::span<const FigurePartData> parts{};
};

struct FigurePackReport {
    Status status = Status::ok;
    FigureTag culprit;            ///< the part that the status refers to; 0 for the figure as a whole
    std::size_t culprit_clip = 0; ///< with FigureTags::clips: the index of the clip
    PackReport points;
    std::array<PackReport, 2> vectors; ///< for tangents and bitangents
    std::size_t bytes = 0;             ///< of the figure
    double seconds = 0;
};

struct StreamedPackOptions {
    BindOptions bind{};
    /// Options of the weights. Without a format, `scalar` is used, since the smallest format is known
    /// only after all batches.
    PackOptions pack{};
    /// The size of the weights that are bound at once, in bytes; at least one block of points.
    std::size_t batch = std::size_t{64} << 20;
};

/// The reports of both steps.
struct StreamedPackReport {
    Status status = Status::ok; ///< of the step that failed
    BindReport bound;
    PackReport packed; ///< empty if binding fails
};

/// The memory of a streamed `pack` in bytes, without its points and their order.
struct StreamedPackMemory {
    std::size_t solver = 0; ///< of a solver on one thread; else 0
    /// The maximum size of the solved functions, which are kept until all points are bound.
    std::size_t functions = 0;
    std::size_t batch = 0; ///< the weights of one batch
    /// The maximum size of the result; doubled while batches are joined.
    std::size_t packed = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
