#pragma once

// A drawing whose cage, or points without a cage, pins pose: what deform_svg and animate_svg share.

#include "cli/figure_motion.hpp"
#include "cli/pinned_cage.hpp"
#include "cli/pose_choice.hpp"
#include "files/clip_file.hpp"

#include <string>
#include <utility>
#include <vector>

namespace cageform_support {

/// Names what pins pose, and the options.
struct PinnedControl {
    const CoordinatesChoice& coordinates;
    const PinChoice& pins;
    const OutsideChoice& outside;
    const std::vector<Point2>& start; ///< the vertices, where held ones stay
    std::vector<std::uint32_t> held;
};

/// Moves the vertices of a control by pins.
class PinnedFigure {
public:
    /// Works as PinnedCage::make(). The control's poses are then of all handles where vectors are among them.
    static Expected<PinnedFigure> make(FigureControl& control, const PinnedControl& by,
                                       std::vector<Pin<2>> pins);

    /// Settles the pins at their targets.
    Expected<std::vector<Point2>> settled();

    /// The keys of all handles that follow pins through a motion: as few as keep to the poses, settled 60
    /// times a second, to a 1,920th of the cage's size.
    ///
    ///   motion   of the pins
    ///   fails    as PinnedCage::settle() does
    Expected<ClipFile> keys_of(const ClipFile& motion);

    const PinnedCage<double, 2>& cage() const { return cage_; }
    const std::vector<Point2>& rest() const { return rest_; } ///< of what poses are of

private:
    explicit PinnedFigure(PinnedCage<double, 2> cage)
        : cage_(std::move(cage)) {}

    Expected<std::vector<Point2>> pose_at(const PinnedCage<double, 2>::Targets& targets,
                                          const PinnedCage<double, 2>::Turns& turns);

    PinnedCage<double, 2> cage_;
    PinnedCage<double, 2>::Pose pose_; // of all handles, the last
    std::vector<Point2> rest_;
};

/// The pins of a motion, with their places at rest as targets.
std::vector<Pin<2>> pins_of(const ClipFile& motion);

/// The motion of pins from rest to their targets and back.
ClipFile motion_to(const std::vector<Pin<2>>& pins, double seconds);

} // namespace cageform_support
