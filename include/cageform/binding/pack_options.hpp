// What packing is asked for, and what it tells.
#pragma once

#include <cageform/binding/bind_options.hpp>
#include <cageform/binding/detail/packed_binding.hpp>
#include <cageform/binding/figure.hpp>

#include <optional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The distance of a point is that between where clones by the packed binding put it and where
/// those by the binding do, in the units of the figure; of a vector, the length of the difference.
/// What is lost is what bends: rest and affine poses stay exact.
struct PackOptions {
    /// Of the weights. Empty: the one that takes the fewest bytes, of those that meet the tolerance;
    /// without a tolerance, scalar.
    std::optional<WeightFormat> format{};
    std::size_t largest =
        0;                ///< weights that a point keeps at least, the largest ones; 0: all. At least D + 1.
    double threshold = 0; ///< smaller weights are dropped; affects no others
    /// The largest distance that any point may have, over `poses` or else `reach`. Blocks are given
    /// rows until they keep it, beyond those that `largest` and `threshold` ask for. 0: no promise.
    double tolerance = 0;
    /// The poses that distances are taken over, those of a clip for instance: #poses · #handles · D
    /// numbers, as `append_pose` puts them there. Weights are fitted to them, with a share for moves
    /// of any other kind.
    std::span<const double> poses{};
    /// Without poses, distances are taken over all poses in which every handle lies within this
    /// distance of an affine image of the handles at rest. 0: a tenth of the cage's size. Vectors
    /// that `pose_handles` makes of faces leave it, even in affine poses of the cage: give poses.
    double reach = 0;
    /// Of sparse bindings: the point at each place, #points; by nearness where empty. For vectors
    /// give the order of the packed binding of their points (PackedBindingView::order): vectors
    /// tell nothing of who their neighbours are.
    std::span<const std::uint32_t> order{};
    std::uint64_t cage_hash = 0;   ///< kept in the blob; 0: `hash_memory` of the handles at rest
    std::uint64_t figure_hash = 0; ///< kept in the blob; 0: `hash_memory` of the points at rest, as Vec<T, D>
};

/// Appends a pose to those of PackOptions::poses: a point for every handle of the binding, vectors
/// included, in their order and units. May throw std::bad_alloc.
template <PointRange Pose>
void append_pose(std::vector<double>& poses, const Pose& pose) {
    for (std::size_t i = 0; i < std::size(pose); ++i) {
        const auto p = to_vec<double>(pose[i]);
        poses.insert(poses.end(), p.v, p.v + range_dimension<Pose>);
    }
}

/// How packing went. The error of a point is Σ |w' − w| over all handles, w' the weights that
/// clones by the packed binding have in effect. In a pose whose handles all lie within d of an
/// affine image of those at rest, a point is at most error · d from where the binding puts it.
struct PackReport {
    Status status = Status::ok;
    std::size_t culprit =
        Extreme::none; ///< weight_not_finite: the point; pose_not_finite: the pose; format_too_coarse: the
                       ///< point that is farthest off
    WeightFormat format = WeightFormat::scalar;
    std::size_t points = 0, handles = 0;
    std::size_t poses = 0;        ///< that distances were taken over; 0: all within `reach`
    double reach = 0;             ///< of the options, or a tenth of the cage's size
    double size = 0;              ///< of the figure: the diagonal of the box around the points at rest
    std::size_t rows = 0;         ///< rows of weights over all blocks
    double weights_per_point = 0; ///< stored, zeros included
    std::size_t bytes = 0;        ///< of the blob
    std::size_t dense_bytes = 0;  ///< of the binding
    std::vector<float> errors;    ///< #points
    Extreme error;                ///< the largest of them
    double mean_error = 0;
    std::vector<float> distances; ///< #points: the largest one over the poses
    /// The largest of them. With format_too_coarse, a tolerance that the format could keep.
    Extreme distance;
    std::size_t distance_pose = Extreme::none; ///< in which pose; none where there are no poses
    double mean_distance = 0;
    Extreme weight_change; ///< the largest change of a kept weight by which Σ w and Σ w c are restored
    std::size_t rows_added =
        0; ///< beyond those asked for, because a block's handles would lie too nearly in one plane
    double seconds = 0;
};

struct FigurePackOptions {
    /// Of the weights. The order and the tolerance are those of the points; tangents take the order
    /// over.
    PackOptions weights{};
    /// The largest change of a unit tangent, in radians where it turns; with points that have a
    /// tolerance or none. 0: ten times that of the points over the size of the figure, 1 at most,
    /// since a point that is off by d beside others that are not turns a surface whose features are
    /// a tenth of the figure by ten times d; none where the points have none.
    double tangent_tolerance = 0;
    /// Clips that move the figure, as `pack_clip` packs them, each of a name of its own and of as
    /// many vertices as there are handles, or handles that are points.
    std::span<const FigureClipData> clips{};
    /// Levels of less detail, 9 at most: packed figures of the same handles, without levels of their
    /// own (PackedFigure::bytes).
    std::span<const std::span<const std::byte>> levels{};
    /// What else is to be in the figure, under tags of its own.
    std::span<const FigurePartData> parts{};
};

struct FigurePackReport {
    Status status = Status::ok;
    FigureTag culprit;            ///< the part that the status is about; 0: the figure as a whole
    std::size_t culprit_clip = 0; ///< with FigureTags::clips: the one of them
    PackReport points;
    std::array<PackReport, 2> vectors; ///< of tangents and bitangents
    std::size_t bytes = 0;             ///< of the figure
    double seconds = 0;
};

struct StreamedPackOptions {
    BindOptions bind{};
    /// Without a format weights are scalars: the one that takes the fewest bytes would be known in the
    /// end alone.
    PackOptions pack{};
    /// In bytes: as many points are bound at once as their weights take, sixteen at least.
    std::size_t batch = std::size_t{64} << 20;
};

/// The reports of both steps.
struct StreamedPackReport {
    Status status = Status::ok; ///< of the step that failed
    BindReport bound;
    PackReport packed; ///< as left where the bind fails
};

/// What a streamed `pack` takes besides its points and their order, in bytes.
struct StreamedPackMemory {
    std::size_t solver = 0;    ///< of coordinates that are solved for, of one thread; of others 0
    std::size_t functions = 0; ///< of theirs, kept until all points are bound, at most
    std::size_t batch = 0;     ///< the weights bound at once
    std::size_t packed =
        0; ///< the result, at most: where nothing is dropped; twice, while it is put together
};

} // namespace cageform::inline CAGEFORM_ABI
