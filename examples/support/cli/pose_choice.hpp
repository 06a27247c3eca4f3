#pragma once

// Options that pose a cage by operations.

#include "cli/command_line.hpp"
#include "cli/pose_operations.hpp"
#include "files/cage_file.hpp"
#include "files/lattice_file.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support {

/// The operations --move, --turn, --scale, --bend, --twist and --curve, in the order given.
struct PoseChoice {
    bool in_plane = false; // whether the program supports cages of curves
    std::vector<std::pair<PoseOperation, std::string>> operations;
    std::size_t freeze = 0; // number of outer layers of a lattice that do not move

    void add_options(CommandLine& line);

    /// A cage's vertices after all operations. Fails on an invalid operation, which the error names, and as
    /// still().
    ///
    ///   curves   the cage if its edges are curves; else null
    ///   parts    of a cage in space, or null
    template <std::size_t D>
    std::vector<cageform::Vec<double, D>>
    posed(const std::vector<cageform::Vec<double, D>>& rest, const std::optional<LatticeBox<D>>& lattice,
          const CageFile* curves = nullptr, const cageform::CageParts* parts = nullptr) const;

    /// The vertices that no pose moves: frozen and frame handles of a lattice. Fails if --freeze is given for
    /// a cage that is not a lattice, or leaves nothing to move.
    template <std::size_t D>
    std::vector<std::size_t> still(const std::optional<LatticeBox<D>>& lattice) const;
};

/// The pose from a file or operations; if neither is given, first_pose() for generated cages.
///
///   path    of the file; empty: none
///   fails   as load_pose(); on an invalid operation; if both are given. A cage that is not generated needs
///           one of them
CageFile read_pose(const std::string& path, const PoseChoice& choice, const CageFile& cage, bool is_made);

} // namespace cageform_support
