// The options and pins that a PoseSolver takes, and its report.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <array>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

struct PoseOptions {
    /// μ: what a pin of weight 1 counts beside the stretch of the whole figure. Pins miss their targets by
    /// about 1/μ of what they pull. Lower it where there are more pins than a quarter of the handles.
    double pin_weight = 1e4;
    /// Corrects every step, so that pins miss a thousand times less. Turns of pins are not corrected.
    bool hard_pins = false;
    std::size_t iterations = 4; ///< in a frame
    /// The number of steps that Anderson acceleration looks back at, at most 10; 0: none. Figures with long
    /// limbs then settle slowly.
    std::size_t history = 5;
    /// A pose has settled when no handle moves farther in a frame; a share of the cage's size.
    double settled_step = 3e-5;
};

/// Pins: bound points that are to go to targets. A PoseSolver copies what it needs of them.
///
///   binding  the view of a binding, dense or packed, with the handles of the samples
///   axes     views of the bindings of the D axes at the same points (`bind_jacobians`) if pins turn; else
///            empty
///   points   the pins among the points of the binding; empty: all are pins
///   weights  one for each pin; empty: all are 1
///   turned   whether a pin turns, one for each pin; empty: all turn if there are axes
template <Scalar T, std::size_t D>
struct PosePins {
    PackedBindingView<T, D> binding{};
    std::array<PackedBindingView<T, D>, D> axes{};
    std::span<const std::uint32_t> points{};
    std::span<const double> weights{};
    std::span<const std::uint8_t> turned{};
};

/// The turn of a pin, in radians: in the plane an angle from the x axis to the y axis; in space the axis of
/// the turn, times its angle.
template <std::size_t D>
using PoseTurn = Vec<double, D == 2 ? 1 : 3>;

/// The length of the axes by which a pin turns, in units of PoseSamples::size. It weights turns against
/// targets.
inline constexpr double turn_lever = 0.03;

/// How a frame went. Energies are those of PoseSamples, lengths in the units of the cage.
struct PoseSolverReport {
    static constexpr std::size_t none = ~std::size_t{0};

    Status status = Status::ok;
    std::size_t culprit = none; ///< the target or the held handle that the status names
    std::size_t iterations = 0;
    double rigid_energy = 0;      ///< of the samples and spokes
    double pin_energy = 0;        ///< Σ μ m |miss|² / L², with turns
    double miss = 0;              ///< the largest distance of a pin from its target …
    std::size_t missed = none;    ///< … and which pin that is
    double step = 0;              ///< the farthest that a handle moved in this frame
    bool settled = false;         ///< whether that is less than PoseOptions::settled_step allows
    std::size_t weak_handles = 0; ///< the number of PoseSamples::weak_handles
    std::size_t folded = 0;       ///< how many clusters are turned inside out, in the mean of their samples
    double least_stretch = 1;     ///< the least singular value of such means
    double largest_stretch = 1;   ///< the largest singular value of such means
};

} // namespace cageform::inline CAGEFORM_ABI
