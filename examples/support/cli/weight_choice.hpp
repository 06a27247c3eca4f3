#pragma once

// The options that say how weights are packed, and the poses in which their loss is measured.

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "files/clip_file.hpp"

#include <cageform/binding/types/pack_options.hpp>

#include <optional>
#include <string>
#include <vector>

namespace cageform_support {

/// The name of a format, as --format has it.
const char* name_of(cageform::WeightFormat format);

/// The choice of --largest, --max-distance and --format.
struct WeightChoice {
    std::optional<cageform::WeightFormat> format;
    std::size_t largest = 0;
    double distance = 0; // a share; 0: no promise

    /// Adds the options.
    ///
    ///   share_of        what the distance is a share of
    ///   more            about the distance: more text, with ";" at its end
    ///   default_format  for the help
    void add_options(CommandLine& line, const std::string& share_of, const std::string& more,
                     const std::string& default_format);
    /// Why the options do not go with the coordinates and the motion; empty: they do.
    std::string fault(const CoordinatesChoice& choice, bool has_motion) const;
};

/// The poses of all handles, one after the other, from those of the cage's vertices. Warns of faces without
/// area.
Expected<std::vector<double>> poses_of_handles(const cageform::Binding<float, 3>& binding,
                                               const PoseClip& clip, const SampledPoses& poses);

} // namespace cageform_support
