#pragma once

// Objects and materials of OBJ and MTL files.

#include "files/mesh_file.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cageform_support {

/// A material; numbers are in [0, 1], `emission` is at least 0.
struct ObjMaterial {
    std::string name;
    std::array<double, 3> colour{0.72, 0.36, 0.2}; ///< default: clay
    std::array<double, 3> emission{};
    double opacity = 1, metallic = 0, roughness = 0.7;
    std::string texture;        ///< path of the colour image; empty: none
    bool opaque_texture = true; ///< false if `map_d` names the same image, whose alpha is the opacity
    std::string emission_texture, normal_texture; ///< `map_Ke` and `norm`, as `texture`
};

/// The objects and materials of an OBJ file.
struct ObjParts {
    std::vector<std::string> objects;                        ///< names, in the order of their first faces
    std::vector<ObjMaterial> materials;                      ///< likewise
    std::vector<std::uint32_t> face_objects, face_materials; ///< #faces
    std::map<std::string, std::size_t> unused; ///< statements without equivalent in glTF, with counts
    std::vector<std::string> warnings;         ///< on missing files, and on images and shapes in `unused`
};

/// Markdown table of OBJ and MTL statements and their equivalents in glTF.
std::string statement_table();

/// Returns the line `statements without equivalent in glTF: "Ka" 2, "illum" 2`, or an empty text if all
/// statements have an equivalent.
std::string describe_unused(const ObjParts& parts);

/// Reads the statements o, usemtl and mtllib of a file, and g if it has no o. Repeated names continue the
/// same object or material. MTL files and textures are opened only in the folder of the OBJ file and its
/// subfolders; of a path to another folder, only the file name is used, beside the OBJ file.
ObjParts read_parts(const MeshFile& file);

/// The MTL files that a file names, as written.
std::vector<std::string> material_files(const MeshFile& file);

/// Returns a note on material files that a copy of the file names, but that are in another folder; empty if
/// there are none.
std::string describe_materials(const MeshFile& file, const std::string& copy);

} // namespace cageform_support
