#pragma once

// The options that pose a cage by operations. The same in all programs.

#include "cage_file.hpp"
#include "command_line.hpp"
#include "pose_operations.hpp"

#include <string>
#include <utility>
#include <vector>

namespace cageform_examples {

/// What --move, --turn, --scale, --bend and --twist say, in the order given.
struct PoseChoice {
    std::vector<std::pair<PoseOperation, std::string>> operations;

    void add_options(CommandLine& line);

    /// A cage's vertices after all operations; fails with the word that cannot be done.
    template <std::size_t D>
    SvgResult<std::vector<cageform::Vec<double, D>>>
    posed(const std::vector<cageform::Vec<double, D>>& rest) const;
};

/// A pose by a file or by operations; of a cage that the program made, where neither is given, first_pose().
///
///   path    of the file; empty: none
///   fails   as load_pose() does, with the operation that cannot be done, and where both or none are given
SvgResult<CageFile> read_pose(const std::string& path, const PoseChoice& choice, const CageFile& cage,
                              bool is_made);

} // namespace cageform_examples
