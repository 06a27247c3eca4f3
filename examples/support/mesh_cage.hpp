#pragma once

// Cages in space: OBJ files of closed meshes, and what to say of them.

#include "cage_file.hpp"
#include "obj_file.hpp"

#include <iostream>

namespace cageform_examples {

/// A cage from an OBJ file; fails also where a face cannot be cut into triangles.
inline SvgResult<ObjFile> load_mesh_cage(const std::string& path) {
    auto file = load_obj(path);
    if (file && !file->folded.empty()) {
        return SvgError{file->name + ": a face cannot be cut into triangles; please split it",
                        file->faces[file->folded.front()].line};
    }
    return file;
}

/// describe_faults() of a mesh, whose file counts otherwise.
inline std::string describe_mesh_faults(const std::string& name, const cageform::BindReport& report) {
    return describe_faults(name, report) +
           (report.cage.faults.empty() ? "" : "\n  (vertices and triangles are counted from 0)");
}

/// Says on stderr how many open edges of a sound cage were closed, if any.
inline void warn_of_closed_gaps(const char* program, const std::string& name,
                                const cageform::CageReport& report) {
    std::size_t count = 0;
    const cageform::CageFault* first = nullptr;
    for (const auto& fault : report.faults) {
        if (fault.kind != cageform::CageFaultKind::gap_closed) continue;
        if (count++ == 0) first = &fault;
    }
    if (count == 0 || report.status != cageform::Status::ok) return;
    std::cerr << program << ": warning: " << name << ": " << count
              << " open edges were closed, first between vertices " << first->a + 1 << " and " << first->b + 1
              << " (counted from 1, as in the file)\n";
}

} // namespace cageform_examples
