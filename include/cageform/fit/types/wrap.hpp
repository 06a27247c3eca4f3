// Options, result and report of `wrap`.
#pragma once

#include <cageform/coordinates/lattice.hpp>
#include <cageform/core/types/handles.hpp>
#include <cageform/fit/types/surface.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A point of the source, and the place where the wrapped source should have it.
struct Landmark {
    Vec<double, 3> from, to;
    double weight = 1; ///< relative to the other landmarks, positive
};

struct WrapOptions {
    /// One basis of the search: a lattice, or the cage. Lengths are relative to the target's height.
    struct Stage {
        unsigned cells = 0; ///< spans of the lattice along the target's height; 0: the cage
        /// Weights λ of the rigidity, in descending order. One matrix is factored for each.
        std::vector<double> stiffness{};
        /// κ multiplies normals before matching. Two perpendicular normals then count as κ √2 apart.
        double normal_length = 0.03;
    };

    std::span<const Landmark> landmarks{};
    /// Points that will follow the source, such as the vertices of clothes. The wrap samples the space around
    /// these points. A soft term keeps points that are outside the source outside the target. Points farther
    /// than the height from the box of the source are neither sampled nor checked. Beyond that
    /// distance the lattice is extended linearly, so displacements grow with the distance.
    std::span<const Vec<double, 3>> follow{};
    /// First moves the source: by a similarity that fits three or more landmarks, else by a scale and a
    /// translation that give the boxes of source and target the same height and centre.
    bool align = true;
    /// Whether source and target have different poses. A first step fits the landmarks with little weight
    /// on the surfaces.
    bool other_pose = false;
    /// Lattices have 6, 12, 24 … spans along the target's height, up to this number. With a cage, lattices
    /// begin at 12 spans; 0 means no lattice.
    unsigned finest = 24;
    double least_stiffness = 1e-7; ///< the stages end at this λ; 1e-5 suits scans with noise
    /// Halves the lattice cells wherever the source misses the target, such as between touching thighs. Takes
    /// about twice the time. Has no effect with a cage.
    bool refine_contacts = false;
    std::vector<Stage> stages{}; ///< replaces the stages of `finest` and `least_stiffness`
    /// The largest number of samples of space. Samples lie on a grid. Its spacing is at least 1/50
    /// of the height, for a cage alone 1/35.
    std::size_t samples = 16000;
    /// The largest number of unknown handles of a lattice. Stages with more are left out; at least one stage
    /// must remain. Compact figures, such as heads, have many handles.
    std::size_t handles = 8000;
    double floor = 0.1; ///< lower bound of the map's least singular value, relative to the source
    /// The search ends when the 95th percentile of the distances falls below this value, relative to the
    /// height.
    double residual = 0;
};

struct WrapReport {
    static constexpr std::size_t none = ~std::size_t{0};

    /// Why a search ended.
    enum class End : std::uint8_t {
        stages,   ///< all stages are done
        residual, ///< WrapOptions::residual is reached
        noise,    ///< the median residual is at the noise of the target
        fold,     ///< the handles of the last stiffness went back by more than half
    };
    /// One stiffness of a stage.
    struct Step {
        unsigned cells = 0;
        std::size_t handles = 0; ///< number of unknown handles
        double stiffness = 0;
        std::size_t iterations = 0;
        double residual = 0;  ///< RMS of the last pulls, relative to the height
        std::size_t held = 0; ///< places below the floor before the guard
        double kept = 1;      ///< mean share of the step that the guard kept
    };

    Status status = Status::ok;
    std::size_t culprit = none; ///< index of the vertex, face, landmark or follower that was refused
    bool of_target = false;     ///< whether the culprit is of the target
    End ended = End::stages;
    double height = 0; ///< of the target, along the longest principal axis of the source
    Transform<double, 3> alignment{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                   {}}; ///< of the source, before the search

    // Distances are relative to the height.
    SurfaceDistance start;     ///< from the aligned source to the target
    SurfaceDistance to_target; ///< from the vertices of the wrapped source to the target
    SurfaceDistance to_source; ///< from the vertices of the target to the wrapped source
    double noise = 0; ///< standard deviation of the target's vertices from quadric fits; 0 if below 1e-3

    double unmatched_source = 0, unmatched_target = 0; ///< share of the vertices without a match
    double miss = 0;                                   ///< the largest distance of a landmark from its place
    std::size_t missed = none;                         ///< the number of this landmark
    std::size_t skipped_faces = 0;                     ///< faces of the target without an area

    std::size_t samples = 0;
    std::size_t far_followers = 0; ///< points of WrapOptions::follow too far away to be checked
    std::size_t folded_vertices = 0, folded_followers = 0, folded_samples = 0; ///< after the alignment
    double least_stretch = 1, largest_stretch = 1; ///< singular values at these places
    std::vector<Step> steps;
    unsigned left_out = 0; ///< spans of the first lattice with more than WrapOptions::handles; 0: none
    double seconds = 0;
};

/// A map of space: `first`, then the pose of the cage, then the pose of the lattice. `move` evaluates it.
template <Scalar T>
struct Wrap {
    Transform<T, 3> first{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {}}; ///< the identity if there is a cage
    std::vector<Vec<T, 3>> pose; ///< of the cage, including the alignment, for `clone`; empty without a cage
    std::optional<LatticeCoordinates<T, 3>> lattice; ///< in the space of the target; absent: no lattice
    std::vector<Vec<T, 3>> lattice_pose;             ///< of the lattice, for `clone`
};

} // namespace cageform::inline CAGEFORM_ABI
