#pragma once

// Options of the view direction of meshes.

#include "cli/command_line.hpp"
#include "pictures/mesh_picture.hpp"

namespace cageform_support {

struct ViewChoice {
    ViewAngles sight;

    void add_options(CommandLine& line); ///< --view and --up
};

} // namespace cageform_support
