// The options, pins and report of a PoseSolver.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <array>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

struct PoseOptions {
    /// μ: the stiffness of a pin of weight 1, relative to the stretch of the whole figure. The distance of a
    /// pin from its target is proportional to 1/μ: about 1e-5 of the figure's size by default. Lower μ if
    /// there are more pins than a quarter of the handles.
    double pin_weight = 1e4;
    /// Corrects every step, so that pins are a thousand times nearer to their targets. Does not affect turns.
    bool hard_pins = false;
    std::size_t iterations = 4; ///< per frame
    /// The number of previous steps used by Anderson acceleration, at most 10; 0: no acceleration, with slow
    /// convergence for long limbs.
    std::size_t history = 5;
    /// A pose has settled if no handle moves farther than this in a frame, relative to the cage's size.
    double settled_step = 3e-5;
};

/// Pins: bound points with targets. A PoseSolver copies the data.
///
///   binding  the view of a binding, dense or packed, with the handles of the samples
///   axes     if pins turn: views of the bindings of the D axes at the same points (`bind_jacobians`)
///   points   indices of the pins among the points of the binding; empty: all points
///   weights  one per pin; empty: all are 1
///   turned   whether a pin turns, one per pin; empty: all turn if there are axes
template <Scalar T, std::size_t D>
struct PosePins {
    PackedBindingView<T, D> binding{};
    std::array<PackedBindingView<T, D>, D> axes{};
    std::span<const std::uint32_t> points{};
    std::span<const double> weights{};
    std::span<const std::uint8_t> turned{};
};

/// The turn of a pin, in radians. 2D: the angle from the x axis to the y axis. 3D: the rotation axis times
/// the angle.
template <std::size_t D>
using PoseTurn = Vec<double, D == 2 ? 1 : 3>;

/// The length of the axes of pins that turn, in units of PoseSamples::size. Larger values weight turns higher
/// relative to targets.
inline constexpr double turn_lever = 0.03;

/// Result of one solve. Energies are defined by PoseSamples; lengths are in the units of the cage.
struct PoseSolverReport {
    static constexpr std::size_t none = ~std::size_t{0};

    Status status = Status::ok;
    std::size_t culprit = none; ///< the target or held handle that caused the status
    std::size_t iterations = 0;
    double rigid_energy = 0;      ///< of samples and spokes
    double pin_energy = 0;        ///< Σ μ m |miss|² / L², including turns
    double miss = 0;              ///< largest distance of a pin from its target
    std::size_t missed = none;    ///< the pin with that distance
    double step = 0;              ///< largest distance that a handle moved in this frame
    bool settled = false;         ///< whether `step` is within PoseOptions::settled_step
    std::size_t weak_handles = 0; ///< size of PoseSamples::weak_handles
    std::size_t folded = 0;       ///< number of clusters whose mean deformation is inverted
    double least_stretch = 1;     ///< least singular value of the clusters' mean deformations
    double largest_stretch = 1;   ///< largest singular value of the clusters' mean deformations
};

} // namespace cageform::inline CAGEFORM_ABI
