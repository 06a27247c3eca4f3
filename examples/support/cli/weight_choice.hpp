#pragma once

// Options for packing weights, and the poses in which errors are measured.

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "files/clip_file.hpp"

#include <cageform/binding/types/pack_options.hpp>

#include <optional>
#include <string>
#include <vector>

namespace cageform_support {

/// The name of a format in --format.
const char* name_of(cageform::WeightFormat format);

/// The options --largest, --max-distance and --format.
struct WeightChoice {
    std::optional<cageform::WeightFormat> format;
    std::size_t largest = 0;
    double distance = 0; // relative; 0: no bound

    /// Adds the options.
    ///
    ///   share_of         reference of the distance
    ///   more             additional text on the distance, ending with ";"
    ///   default_format   for the help
    void add_options(CommandLine& line, const std::string& share_of, const std::string& more,
                     const std::string& default_format);
    /// Error if the options do not match the coordinates and the motion; else empty.
    std::string fault(const CoordinatesChoice& choice, bool has_motion) const;
};

/// The poses of all handles, concatenated, from poses of the cage's vertices. Warns of faces without area.
std::vector<double> poses_of_handles(const cageform::Binding<float, 3>& binding, const PoseClip& clip,
                                     const SampledPoses& poses);

} // namespace cageform_support
