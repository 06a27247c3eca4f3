#pragma once

// Meshes that the programs read, and cages that the programs make around any figure.

#include "cli/command_line.hpp"
#include "files/cage_file.hpp"
#include "files/obj_file.hpp"
#include "svg/document.hpp"

#include <cageform/enclose/types/make_cage_options.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace cageform_support {

/// Text for --help, after the other values of --cage.
inline constexpr const char* auto_cage_help =
    "; or auto, hull or box (with N vertices auto:N or hull:N, with the fewest that are within 15 % of the "
    "tightest auto:15%) to make one, as make_cage does; or a lattice of points, lattice:4x4 in the plane and "
    "lattice:4x4x4 in space, or a .lattice.json file";

/// The files that a program accepts as --cage.
enum class CageFiles { drawing, drawing_or_sites, mesh, mesh_or_sites };

/// Adds the required option --cage.
void add_cage(CommandLine& line, std::string& cage, CageFiles files);

/// The choice of --cage: auto, hull, box, auto:N, hull:N, auto:15%, hull:15% or lattice:…, otherwise a file
/// (write ./auto for a file of that name).
struct CageWord {
    bool is_auto = false;
    bool is_lattice = false;  // then the rest of the word says which
    std::size_t vertices = 0; // 0: as many as make_cage takes
    double looseness = 0;     // above 0: as few as stay within this share of the tightest
    cageform::CageShape shape = cageform::CageShape::figure;

    static CageWord of(const std::string& word);
};

/// A cage made by make_cage, and its report.
template <class Cage>
struct AutoCage {
    Cage cage;
    cageform::MakeCageReport report;
};

/// Makes a cage around everything that a document paints, in root user space; its coordinates are
/// rounded, within a thousandth of what it keeps off the figure.
///
///   options   margins as shares; the mirror's place in root user space
///   fails     with a sentence that names the document
Expected<AutoCage<CageFile>> make_cage_for(const SvgDocument& figure,
                                           const cageform::MakeCageOptions& options);

/// Makes a cage around all faces of a mesh, on all threads of the machine. Its faces are in groups part_1,
/// part_2, part_-2 and so on, see find_parts().
Expected<AutoCage<ObjFile>> make_cage_for(const ObjFile& figure, const cageform::MakeCageOptions& options,
                                          const cageform::Progress& progress = {});

/// Pairs triangles of a cage to quads, as many as possible; its vertices stay.
Expected<AutoCage<ObjFile>> with_quads(const AutoCage<ObjFile>& made, const ObjFile& figure,
                                       const cageform::MakeCageOptions& options);

/// Makes a lattice about everything that a document paints, or about the vertices of a mesh.
///
///   margin   of the box, as a part of their diagonal
inline constexpr double lattice_margin = 0.02;
Expected<CageFile> make_lattice_for(const SvgDocument& figure, const LatticeWord& word, double margin);
Expected<ObjFile> make_lattice_for(const ObjFile& figure, const LatticeWord& word, double margin);

/// The cage that --cage names: made for the figure, or read from a file.
Expected<CageFile> load_or_make_cage(const std::string& word, const SvgDocument& figure,
                                     CageEdges edges = CageEdges::lines);
Expected<ObjFile> load_or_make_cage(const std::string& word, const ObjFile& figure);

/// Reads "15%" or "0.15", the share by which a cage may exceed the tightest. Returns the fault; empty if
/// there is none.
std::string parse_looseness(const std::string& word, double& looseness);

/// "24 vertices, …": the report for people, two lines; a third one where numbers of vertices were tried.
///
///   dimension   2 or 3
std::string describe(const cageform::MakeCageReport& report, std::size_t dimension);

/// "110 quads and 16 triangles, …": what became of the triangles of a cage in space, a line.
std::string describe_quads(const cageform::MakeCageReport& report);

/// "rings: about 2 (6 vertices), -2 (6)": the loops about limbs, a line; empty if there are none.
std::string describe_rings(const cageform::MakeCageReport& report);

/// Returns warnings for the user; empty if there are none.
std::vector<std::string> warnings_of(const cageform::MakeCageReport& report,
                                     const cageform::MakeCageOptions& options);

/// A pose for a first look, where none is given: a half of the cage, along its longest side, bends by 30
/// degrees.
template <std::size_t D>
std::vector<cageform::Vec<double, D>> first_pose(const std::vector<cageform::Vec<double, D>>& rest);

/// Adds --flip-faces, for with_faces_turned_over().
void add_flip_faces(CommandLine& line, bool& flips_faces);

/// Adds --strict for load_mesh_figure().
void add_strict(CommandLine& line, bool& is_strict);

enum class MeshFormats { obj, obj_or_medit };

/// Reads a figure. Vertices that are not finite and that no face has are left out with a warning; a strict
/// reader refuses them.
Expected<ObjFile> load_mesh_figure(const std::string& path, bool is_strict,
                                   MeshFormats formats = MeshFormats::obj);

/// Adds vertices that are not finite in a frame to those that the figure leaves out, with a warning.
///
///   vertices  ascend
///   frame     its name, before "v 1" in messages
///   returns   why a vertex cannot be left out: a face of the figure has it, or the reader is strict; empty
///             if all can be left out
std::string leave_out_also(ObjFile& figure, std::span<const std::size_t> vertices, const std::string& frame,
                           bool is_strict);

} // namespace cageform_support
