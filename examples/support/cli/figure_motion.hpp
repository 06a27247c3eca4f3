#pragma once

// A drawing moved by the poses of its cage, or of points: what deform_svg and animate_svg share.

#include "cli/coordinates.hpp"
#include "svg/document.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cageform_support {

/// Coordinates, and the poses of their handles in every frame: they move a figure.
struct FigureControl {
    ChosenCoordinates<double, 2> coordinates;
    std::string name;                       // of the cage's or the points' file, for messages
    std::string pose_name;                  // of the poses' file
    std::size_t frames = 1;                 // of a motion; of a pose 1
    std::vector<std::vector<Point2>> poses; // of the vertices: layer * frames + frame
    bool poses_all_handles = false;         // whether the poses are of edges' vectors too
    std::vector<double> weights;            // of sites, or none
    std::string weights_name;
    std::function<std::string(const cageform::BindReport&)> describe_faults;

    /// "walk.csv: frame 12", of a motion; else the pose's name.
    std::string name_of(std::size_t frame) const;
};

/// A control by a cage that has no pose yet.
FigureControl control_of(const CoordinatesChoice& choice, const CageFile& cage);

/// Describes which edges of the posed cage cross, or where a lattice folds, and in how many frames; empty if
/// it is sound in all.
///
///   cage   what the poses are of
std::string pose_faults(const FigureControl& control, const CageFile& cage);

struct MovedFigure {
    AnimatedSvg drawing;
    cageform::BindReport bound; // of the first batch of points
};

/// Binds all that a drawing shows and moves it to every frame. Warnings go to stderr.
///
///   figure     the name of its file
///   parallel   what binds; the result does not depend on it
///   fails      as animate() does, where the bind fails, or points are outside and --outside forbids it
Expected<MovedFigure> move_figure(const SvgDocument& document, const std::string& figure,
                                  const FigureControl& control, const OutsideChoice& outside,
                                  const DeformOptions& options,
                                  const cageform::ParallelFor& parallel = cageform::SerialFor{});

/// Moves points of layer 0 to all frames of a control. Points outside give a warning, never an error by their
/// number.
///
///   returns  the points in every frame
Expected<std::vector<std::vector<Point2>>> move_points(const std::vector<Point2>& points,
                                                       const std::string& figure,
                                                       const FigureControl& control,
                                                       const OutsideChoice& outside);

} // namespace cageform_support
