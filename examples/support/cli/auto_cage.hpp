#pragma once

// Cages that programs make around figures, and reading of meshes.

#include "cli/command_line.hpp"
#include "files/cage_file.hpp"
#include "files/mesh_file.hpp"
#include "svg/document.hpp"

#include <cageform/enclose/types/make_cage_options.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace cageform_support {

/// Help text, appended to the other values of --cage.
inline constexpr const char* auto_cage_help =
    "; or auto, hull or box to make one as make_cage does (auto:N or hull:N: with N vertices; auto:15%: with "
    "the fewest vertices within 15 % of the tightest cage); or a lattice of points: lattice:4x4 in the "
    "plane, lattice:4x4x4 in space, or a .lattice.json file";

/// The files that a program accepts as --cage.
enum class CageFiles : std::uint8_t { drawing, drawing_or_sites, mesh, mesh_or_sites };

/// Adds the required option --cage.
void add_cage(CommandLine& line, std::string& cage, CageFiles files);

/// The choice of --cage: auto, hull, box, auto:N, hull:N, auto:15%, hull:15% or lattice:…, otherwise a file
/// (write ./auto for a file of that name).
struct CageChoice {
    bool is_auto = false;
    bool is_lattice = false;  // described by the rest of the word
    std::size_t vertices = 0; // 0: chosen by make_cage
    double looseness = 0;     // positive: fewest vertices within this fraction of the tightest cage
    cageform::CageShape shape = cageform::CageShape::figure;

    static CageChoice of(const std::string& word);
};

/// A cage from make_cage, and its report.
template <class Cage>
struct AutoCage {
    Cage cage;
    cageform::MakeCageReport report;
};

/// Makes a cage around all visible parts of a document, in root user space. Coordinates are rounded to 1/1000
/// of the clearance.
///
///   options   margins relative to the figure; the mirror's position in root user space
///   fails     with the document's name
AutoCage<CageFile> make_cage_for(const SvgDocument& figure, const cageform::MakeCageOptions& options);

/// Makes a cage around all faces of a mesh, with all hardware threads. Its faces are in the groups part_1,
/// part_2, part_-2 and so on, see find_parts().
AutoCage<MeshFile> make_cage_for(const MeshFile& figure, const cageform::MakeCageOptions& options,
                                 const cageform::Progress& progress = {});

/// Merges as many pairs of triangles of a cage as possible to quads. The vertices do not change.
AutoCage<MeshFile> with_quads(const AutoCage<MeshFile>& made, const MeshFile& figure,
                              const cageform::MakeCageOptions& options);

/// Makes a lattice around all visible parts of a document, or around the vertices of a mesh.
///
///   margin   of the box, relative to the diagonal of these parts or vertices
inline constexpr double lattice_margin = 0.02;
CageFile make_lattice_for(const SvgDocument& figure, const LatticeWord& word, double margin);
MeshFile make_lattice_for(const MeshFile& figure, const LatticeWord& word, double margin);

/// The cage of --cage: made for the figure, or read from a file.
CageFile load_or_make_cage(const std::string& word, const SvgDocument& figure,
                           CageEdges edges = CageEdges::lines);
MeshFile load_or_make_cage(const std::string& word, const MeshFile& figure);

/// Parses "15%" or "0.15", the fraction by which a cage may exceed the tightest. Returns the error; empty on
/// success.
std::string parse_looseness(const std::string& word, double& looseness);

/// Formats the report in two lines, and a table if several numbers of vertices were tried.
///
///   dimension   2 or 3
std::string describe(const cageform::MakeCageReport& report, std::size_t dimension);

/// "110 quads and 16 triangles, …": one line on with_quads().
std::string describe_quads(const cageform::MakeCageReport& report);

/// "rings: about 2 (6 vertices), -2 (6)": one line on loops around limbs; empty if there are none.
std::string describe_rings(const cageform::MakeCageReport& report);

/// Warnings for the user.
std::vector<std::string> warnings_of(const cageform::MakeCageReport& report,
                                     const cageform::MakeCageOptions& options);

/// Default pose if none is given: half of the cage, along its longest side, bends by 30 degrees.
template <std::size_t D>
std::vector<cageform::Vec<double, D>> first_pose(const std::vector<cageform::Vec<double, D>>& rest);

/// Adds --flip-faces, for with_faces_reversed().
void add_flip_faces(CommandLine& line, bool& flips_faces);

/// Adds --strict for load_mesh_figure().
void add_strict(CommandLine& line, bool& is_strict);

/// Reads a figure. Unused vertices that are not finite are left out with a warning; a strict reader rejects
/// them.
MeshFile load_mesh_figure(const std::string& path, bool is_strict);

/// Leaves out vertices that are not finite in a frame, with a warning.
///
///   vertices   ascending
///   frame      its name, before "v 1" in messages
///   returns    the error if a face uses such a vertex, or the reader is strict; else empty
std::string leave_out_also(MeshFile& figure, std::span<const std::size_t> vertices, const std::string& frame,
                           bool is_strict);

} // namespace cageform_support
