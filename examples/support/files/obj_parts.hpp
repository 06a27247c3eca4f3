#pragma once

// Which object and which material a face of an OBJ file belongs to, and what the MTL files say of the
// materials.

#include "files/obj_file.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cageform_support {

/// A material, its numbers within 0 to 1 but for `emission`, which is 0 or more.
struct ObjMaterial {
    std::string name;
    std::array<double, 3> colour{0.72, 0.36, 0.2}; ///< clay, where no file says another
    std::array<double, 3> emission{};
    double opacity = 1, metallic = 0, roughness = 0.7;
    std::string texture;        ///< of the colour: a file that is there; empty: none
    bool opaque_texture = true; ///< false: `map_d` names the same picture, whose alpha is the opacity
    std::string emission_texture, normal_texture; ///< `map_Ke` and `norm`, as `texture`
};

/// The objects and materials of an OBJ file: all that it holds beside its shape.
struct ObjParts {
    std::vector<std::string> objects;                        ///< names, in the order of their first faces
    std::vector<ObjMaterial> materials;                      ///< that faces have, likewise
    std::vector<std::uint32_t> face_objects, face_materials; ///< #faces
    std::map<std::string, std::size_t> unused; ///< statements that glTF has no place for, and how many
    std::vector<std::string> warnings; ///< files that are not there, and the pictures and shapes of `unused`
};

/// The statements of OBJ and MTL files and their places in a glTF file, as a table in Markdown.
std::string statement_table();

/// "statements without a place in glTF: Ka 2, illum 2\n", or nothing where there are none: for reports.
std::string describe_unused(const ObjParts& parts);

/// Reads the statements o, usemtl and mtllib of a file, and g where it has no o. A name that comes again
/// goes on with what has that name. Materials are read from MTL files, of which and of whose textures only
/// those are opened that lie in the folder of the OBJ file or in folders in it: one that is named by a path
/// to elsewhere is looked for beside the OBJ file.
ObjParts read_parts(const ObjFile& file);

/// The names of the MTL files that a file names, as it names them.
std::vector<std::string> material_files(const ObjFile& file);

} // namespace cageform_support
