#pragma once

// The options that pose a cage by operations, which are common to all programs.

#include "cli/command_line.hpp"
#include "cli/pose_operations.hpp"
#include "files/cage_file.hpp"
#include "files/clip_file.hpp"
#include "files/obj_file.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support {

/// The operations --move, --turn, --scale, --bend, --twist and --curve, in the order given.
struct PoseChoice {
    bool in_plane = false; // whether the program takes cages of curves
    std::vector<std::pair<PoseOperation, std::string>> operations;
    std::size_t freeze = 0; // layers of a lattice that stay at rest

    void add_options(CommandLine& line);

    /// A cage's vertices after all operations; fails with the word that cannot be done, and as `still`.
    ///
    ///   curves   the cage, if its edges are curves; else null
    ///   parts    of a cage in space, or null
    template <std::size_t D>
    Expected<std::vector<cageform::Vec<double, D>>>
    posed(const std::vector<cageform::Vec<double, D>>& rest, const std::optional<LatticeBox<D>>& lattice,
          const CageFile* curves = nullptr, const cageform::CageParts* parts = nullptr) const;

    /// The vertices that no pose moves: frozen and still handles of a lattice. Fails where --freeze is given
    /// for a cage that is none, or leaves nothing to move.
    template <std::size_t D>
    Expected<std::vector<std::size_t>> still(const std::optional<LatticeBox<D>>& lattice) const;
};

/// --clip, --pose, --seconds and the operations say how a cage in space moves: a clip, or from rest through
/// poses
/// and back.
struct MotionChoice {
    std::string clip;
    std::vector<std::string> poses;
    PoseChoice operations;
    double seconds = 1;

    void add_options(CommandLine& line);
    /// Puts `poses` in the order of their numbers (order_by_numbers()), with notes. Options are read before.
    void order_poses();

    bool is_given() const { return !clip.empty() || !poses.empty() || !operations.operations.empty(); }
    /// The motion; without keys where none is given. Vertices that stay still are put back to rest. Fails
    /// where a file cannot be read or fits not, an operation cannot be done, numbers are beyond single
    /// precision, or more than one of the three is given.
    Expected<PoseClip> motion(const ObjFile& cage) const;
};

/// A pose by a file or by operations; of a cage that the program made, where neither is given,
/// first_pose().
///
///   path    of the file; empty: none
///   fails   as load_pose() does, with the operation that cannot be done, and where both or none are given
Expected<CageFile> read_pose(const std::string& path, const PoseChoice& choice, const CageFile& cage,
                             bool is_made);

} // namespace cageform_support
