#pragma once

// Drawings posed by pins; shared by deform_svg and animate_svg.

#include "cli/figure_motion.hpp"
#include "cli/pinned_cage.hpp"
#include "cli/pose_choice.hpp"
#include "files/clip_file.hpp"

#include <utility>
#include <vector>

namespace cageform_support {

/// Options and start pose of a PinnedFigure.
struct PinnedControl {
    const CoordinatesChoice& coordinates;
    const PinChoice& pins;
    const OutsideChoice& outside;
    const std::vector<Point2>& start; ///< vertex positions; held vertices stay there
    std::vector<std::uint32_t> held;
};

/// Poses the vertices of a control by pins.
class PinnedFigure {
public:
    /// As PinnedCage::make(); also sets `control.poses_all_handles`: whether vectors are handles.
    static Expected<PinnedFigure> make(FigureControl& control, const PinnedControl& by,
                                       std::vector<Pin<2>> pins);

    /// The converged pose for the pins' targets.
    Expected<std::vector<Point2>> settled();

    /// Converts a motion of pins to keys of all handles. Solves for 60 poses per second of the motion, and
    /// fits few keys to them, within 1/1920 of the cage's size.
    ///
    ///   motion   of the pins
    ///   fails    as PinnedCage::settle()
    Expected<ClipFile> keys_of(const ClipFile& motion);

    const PinnedCage<double, 2>& cage() const { return cage_; }
    const std::vector<Point2>& rest() const { return rest_; } ///< rest positions of the posed handles

private:
    explicit PinnedFigure(PinnedCage<double, 2> cage)
        : cage_(std::move(cage)) {}

    Expected<std::vector<Point2>> pose_at(const PinnedCage<double, 2>::Targets& targets,
                                          const PinnedCage<double, 2>::Turns& turns);

    PinnedCage<double, 2> cage_;
    PinnedCage<double, 2>::Pose pose_; // last pose of all handles
    std::vector<Point2> rest_;
};

/// The pins of a motion, with their rest positions as targets.
std::vector<Pin<2>> pins_of(const ClipFile& motion);

/// The motion of pins from rest to their targets and back.
ClipFile motion_to(const std::vector<Pin<2>>& pins, double seconds);

} // namespace cageform_support
