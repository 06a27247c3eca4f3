// Samples of a cage's inside, for posing by pins: made once, shipped with a game.
#pragma once

#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/handles.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The energy of a pose, summed over samples of the inside (`pose_samples`). Lengths are relative to the
/// diagonal L of the cage's box; the origin is the centre of the box.
///
///     E(h, R) = Σ_s a_s |J_s(h) − R_c(s)|² + (ρ/#handles) Σ_i |g_iᵀh − R_c(i) u_i|²
///               + (ℓ²/#samples) Σ_neighbours |J_s − J_t|² / |s − t|²
///     J_s = Σ_i h_i ∇w_i(s)ᵀ,   Σ a_s = 1,   c(s) the cluster of sample s,   R_c a rotation for each cluster
///
/// The second sum is over spokes: u_i is the unit vector at rest from the centre of the nearest cluster c(i)
/// to handle i, or along a vector handle; g_iᵀh is its image in the pose.
///
/// In the displacements d = h − H from rest, cluster c has the matrix J_c = M_c + d G_cᵀ. The matrix K of the
/// energy includes all samples. The cost of a frame therefore depends on the number of clusters, not of
/// samples.
template <Scalar T, std::size_t D>
struct PoseSamples {
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr std::size_t most_handles = 4096;

    std::vector<Vec<T, D>> rest_handles;  ///< #handles
    std::vector<HandleKind> handle_kinds; ///< #handles
    Vec<double, D> centre{};              ///< centre of the cage's box
    double size = 0;                      ///< L
    std::vector<Vec<T, D>> points;        ///< #samples, in the units of the cage
    std::vector<std::uint32_t> clusters;  ///< #samples
    std::vector<std::uint32_t> centres;   ///< #clusters: the sample at the centre of each, where spokes end
    std::size_t cluster_count = 0;
    /// G: one block per group of clusters, with row handle · D + axis.
    std::vector<Lanes<T>> gradients;
    /// M: blocks as in `gradients`, with row D · row + column.
    std::vector<Lanes<T>> moments;
    std::vector<double> stiffness; ///< K: its lower triangle by rows
    /// Handles with negligible stiffness: a diagonal entry of K, without spokes, below 1e-6 of the mean.
    std::vector<std::uint32_t> weak_handles;

    std::size_t handle_count() const noexcept { return rest_handles.size(); }
    HandleView<T, D> handle_view() const noexcept {
        return {rest_handles.data(), rest_handles.size(), handle_kinds.data(), nullptr};
    }
    /// Returns K(i, j).
    double stiffness_of(std::size_t i, std::size_t j) const noexcept {
        return i < j ? stiffness[j * (j + 1) / 2 + i] : stiffness[i * (i + 1) / 2 + j];
    }
    /// Returns the size in bytes of the handles, G, M and K, which frames read.
    std::size_t bytes() const noexcept {
        return rest_handles.size() * (sizeof(Vec<T, D>) + sizeof(HandleKind)) +
               (gradients.size() + moments.size()) * sizeof(Lanes<T>) + stiffness.size() * sizeof(double);
    }
};

} // namespace cageform::inline CAGEFORM_ABI
