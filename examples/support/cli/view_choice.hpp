#pragma once

// Where pictures of meshes are seen from. All programs that draw some share it.

#include "cli/command_line.hpp"
#include "pictures/mesh_picture.hpp"

namespace cageform_examples {

struct ViewChoice {
    MeshSight sight;

    void add_options(CommandLine& line); ///< --view and --up
};

} // namespace cageform_examples
