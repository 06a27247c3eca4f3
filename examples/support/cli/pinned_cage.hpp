#pragma once

// Pins pose a cage: the options that are common to all programs, and what solves for the pose.

#include "cli/coordinates.hpp"
#include "cli/pins.hpp"

#include <cageform/binding/types/pose_sample_options.hpp>
#include <cageform/enclose/types/cage_parts.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support {

/// --pin, --pins, --hold, --pin-weight, --hard-pins and --smoothing.
struct PinChoice {
    std::vector<std::pair<std::string, bool>> given; // words of --pin, and files of --pins (true)
    std::string held;                                // a selection of the cage's vertices; empty: none
    cageform::PoseOptions solving;
    cageform::PoseSampleOptions sampling;

    void add_options(CommandLine& line);
    bool is_given() const { return !given.empty(); }
    /// Returns why the options do not go together; empty if they do.
    ///
    ///   has_pose   whether a pose is given too, which is for held vertices
    std::string fault(bool has_pose) const;

    /// Reads all pins, in the order given; warns where two contradict each other.
    ///
    ///   vertices   the figure's, which pins in space may name; else empty
    ///   fails      as parse_pin() and load_pins() do
    template <std::size_t D>
    Expected<std::vector<Pin<D>>> pins(std::span<const cageform::Vec<double, D>> vertices = {}) const;

    /// The vertices that --hold selects, and those that stay still in every pose.
    ///
    ///   rest     the cage's vertices
    ///   still    as PoseChoice::still() has them
    ///   parts    of a cage in space, or null
    ///   fails    where --hold is no selection of them, or nothing is left to move
    template <std::size_t D>
    Expected<std::vector<std::uint32_t>> held_handles(std::span<const cageform::Vec<double, D>> rest,
                                                      const std::vector<std::size_t>& still,
                                                      const cageform::CageParts* parts = nullptr) const;
};

/// Names for the messages of a PinnedCage.
struct PinnedCageNames {
    std::string cage, coordinates;                                           // for messages
    std::function<std::string(const cageform::BindReport&)> describe_faults; // of the cage
};

/// A cage that pins move: samples of its inside, its pins, and a solver.
template <cageform::Scalar T, std::size_t D>
class PinnedCage {
public:
    using Pose = std::vector<cageform::Vec<T, D>>;
    using Targets = std::vector<cageform::Vec<double, D>>;
    using Turns = std::vector<cageform::PoseTurn<D>>;

    /// Samples the inside of a cage and binds the pins. A warning goes to stderr where a pin follows the
    /// extension of the coordinates.
    ///
    ///   held     handles that `settle` leaves where the pose has them
    ///   fails    where the coordinates have no gradients or cannot be sampled, a pin lies where they have no
    ///            weights, or no handle moves it; the message names the pin
    static Expected<PinnedCage> make(const ChosenCoordinates<T, D>& coordinates, const PinnedCageNames& names,
                                     std::vector<Pin<D>> pins, std::vector<std::uint32_t> held,
                                     const PinChoice& choice, const OutsideChoice& outside);

    const std::vector<Pin<D>>& pins() const { return pins_; }
    Pose rest() const { return solver_.samples().rest_handles; } ///< of all handles
    double size() const { return solver_.samples().size; }       ///< the diagonal of the cage's box
    Targets targets() const;                                     ///< of the pins
    Turns turns() const;                                         ///< of the pins; empty if none turns

    /// Starts the next pose from another than the last.
    Expected<bool> start(const Pose& pose);

    /// Moves a pose to the targets until it has settled, and adds to `report()`.
    ///
    ///   pose    of all handles; in: where held ones are
    ///   fails   where a target or the result is not finite
    Expected<bool> settle(const Targets& targets, const Turns& turns, Pose& pose);
    /// Returns the last pose's miss and stretch, and the costs of all poses, for people.
    std::string report() const;
    /// Says how many poses have not settled, and where the figure folds; empty where all is well.
    std::string warning() const;

private:
    PinnedCage() = default;

    std::vector<Pin<D>> pins_;
    std::size_t held_ = 0;
    cageform::PoseSolver<T, D> solver_;
    cageform::PoseSolverReport last_;
    double sampling_ms_ = 0, click_ms_ = 0, first_ms_ = 0, solving_ms_ = 0;
    std::size_t poses_ = 0, frames_ = 0, iterations_ = 0, unsettled_ = 0;
    std::size_t folded_ = 0;  // the most clusters in a pose
    double largest_step_ = 0; // of the last frames of poses that have not settled
};

} // namespace cageform_support
