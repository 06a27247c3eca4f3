#pragma once

// The view direction of pictures of meshes, shared by all programs that draw them.

#include "cli/command_line.hpp"
#include "pictures/mesh_picture.hpp"

namespace cageform_support {

struct ViewChoice {
    MeshSight sight;

    void add_options(CommandLine& line); ///< --view and --up
};

} // namespace cageform_support
