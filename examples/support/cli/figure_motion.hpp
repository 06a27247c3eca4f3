#pragma once

// Deforms a drawing by poses of a cage or of points; shared by deform_svg and animate_svg.

#include "cli/coordinates.hpp"
#include "svg/document.hpp"

#include <functional>
#include <string>
#include <vector>

namespace cageform_support {

/// Coordinates, and the poses of their handles per frame.
struct FigureControl {
    ChosenCoordinates<double, 2> coordinates;
    std::string name;                       // file of the cage or points, for messages
    std::string pose_name;                  // file of the poses
    std::size_t frames = 1;                 // 1 for a single pose
    std::vector<std::vector<Point2>> poses; // of the vertices: layer * frames + frame
    bool poses_all_handles = false;         // whether poses include vectors of edges
    std::vector<double> weights;            // of sites, or empty
    std::string weights_name;
    std::function<std::string(const cageform::BindReport&)> describe_faults;

    /// "walk.csv: frame 12" for a motion; else the pose's name.
    std::string name_of(std::size_t frame) const;
};

/// A control by a cage, without poses.
FigureControl control_of(const CoordinatesChoice& choice, const CageFile& cage);

/// Describes the first crossing edges of a posed cage, or the worst fold of a lattice, and the number of
/// frames with such errors; empty if there are none.
///
///   cage   the posed cage
std::string pose_faults(const FigureControl& control, const CageFile& cage);

struct MovedFigure {
    AnimatedSvg drawing;
    cageform::BindReport bound; // of the first batch of points
};

/// Binds a drawing and deforms it in every frame. Warnings go to stderr.
///
///   figure     name of its file
///   parallel   for binding; does not affect the result
///   fails      as animate(), if the bind fails, or points are outside and --outside forbids it
MovedFigure move_figure(const SvgDocument& document, const std::string& figure, const FigureControl& control,
                        const OutsideChoice& outside, const DeformOptions& options,
                        const cageform::ParallelFor& parallel = cageform::SerialFor{});

/// Moves points of layer 0 to all frames of a control. Points outside cause a warning only, even if most are.
///
///   returns   #frames · #points
std::vector<std::vector<Point2>> move_points(const std::vector<Point2>& points, const std::string& figure,
                                             const FigureControl& control, const OutsideChoice& outside);

/// Adds --text-as-paths and --threads of programs that deform drawings.
void add_text_as_paths(CommandLine& line, bool& text_as_paths);
void add_threads(CommandLine& line, std::size_t& threads);

} // namespace cageform_support
