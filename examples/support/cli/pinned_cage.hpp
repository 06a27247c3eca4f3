#pragma once

// Poses of cages by pins: options and solver.

#include "cli/coordinates.hpp"
#include "cli/pins.hpp"

#include <cageform/binding/types/pose_sample_options.hpp>
#include <cageform/enclose/types/cage_parts.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support {

/// --pin, --pins, --hold, --pin-weight, --hard-pins and --smoothing.
struct PinChoice {
    std::vector<std::pair<std::string, bool>> given; // words of --pin, and files of --pins (true)
    std::string held;                                // selection of vertices; empty: none
    cageform::PoseOptions solving;
    cageform::PoseSampleOptions sampling;

    void add_options(CommandLine& line);
    bool is_given() const { return !given.empty(); }
    /// Error if options contradict each other; else empty.
    ///
    ///   has_pose   whether a pose is given too, for held vertices
    std::string fault(bool has_pose) const;

    /// Parses all pins, in the order given; warns if two contradict each other.
    ///
    ///   vertices   of the figure, for pins by vertex number in space; else empty
    ///   fails      as parse_pin() and load_pins()
    template <std::size_t D>
    Expected<std::vector<Pin<D>>> pins(std::span<const cageform::Vec<double, D>> vertices = {}) const;

    /// The vertices of --hold, and those that no pose moves.
    ///
    ///   rest    the cage's vertices
    ///   still   as from PoseChoice::still()
    ///   parts   of a cage in space, or null
    ///   fails   if --hold is not a valid selection, or no vertex can move
    template <std::size_t D>
    std::vector<std::uint32_t> held_handles(std::span<const cageform::Vec<double, D>> rest,
                                            const std::vector<std::size_t>& still,
                                            const cageform::CageParts* parts = nullptr) const;
};

/// Names for the messages of a PinnedCage.
struct PinnedCageNames {
    std::string cage, coordinates;
    std::function<std::string(const cageform::BindReport&)> describe_faults; // of the cage
};

/// A cage posed by pins: samples of its inside, pins and solver.
template <cageform::Scalar T, std::size_t D>
class PinnedCage {
public:
    using Pose = std::vector<cageform::Vec<T, D>>;
    using Targets = std::vector<cageform::Vec<double, D>>;
    using Turns = std::vector<cageform::PoseTurn<D>>;
    struct Handles {
        std::vector<Pin<D>> pins;
        std::vector<std::uint32_t> held; ///< handles that `settle` does not move
    };

    /// Samples the inside of a cage and binds the pins. Warns if a pin is outside and follows the extension
    /// of the coordinates.
    ///
    ///   fails   if the coordinates have no gradients or cannot be sampled, a pin has no weights, or no
    ///           handle moves it; the message names the pin
    static Expected<PinnedCage> make(const ChosenCoordinates<T, D>& coordinates, const PinnedCageNames& names,
                                     Handles handles, const PinChoice& choice, const OutsideChoice& outside);

    const std::vector<Pin<D>>& pins() const { return pins_; }
    Pose rest() const { return solver_.samples().rest_handles; } ///< of all handles
    double size() const { return solver_.samples().size; }       ///< the diagonal of the cage's box
    Targets targets() const;                                     ///< of the pins
    Turns turns() const;                                         ///< of the pins; empty if none turns

    /// Sets the initial pose of the next settle().
    Expected<bool> start(const Pose& pose);

    /// Iterates a pose until it converges to the targets, at most 2000 times, and updates `report()`.
    ///
    ///   pose    in and out: all handles; held ones keep their positions
    ///   fails   if a target or the result is not finite
    Expected<bool> settle(const Targets& targets, const Turns& turns, Pose& pose);
    /// Formats the residual and stretch of the last pose, and the costs of all poses.
    std::string report() const;
    /// Warning on poses that have not converged, and on folds; empty if there are none.
    std::string warning() const;

private:
    PinnedCage() = default;

    std::vector<Pin<D>> pins_;
    std::size_t held_ = 0;
    cageform::PoseSolver<T, D> solver_;
    cageform::PoseSolverReport last_;
    double sampling_ms_ = 0, click_ms_ = 0, first_ms_ = 0, solving_ms_ = 0;
    std::size_t poses_ = 0, frames_ = 0, iterations_ = 0, unsettled_ = 0;
    std::size_t folded_ = 0;  // maximum number of folded clusters in a pose
    double largest_step_ = 0; // in the last frames of poses that have not converged
};

} // namespace cageform_support
