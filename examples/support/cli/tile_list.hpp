#pragma once

// Lists of files that many processes divide among them: patterns, rows, and a file to write for each.

#include "cli/command_line.hpp"
#include "svg/path.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace cageform_support {

/// A file of points and the figure that is made of it.
struct Tile {
    std::size_t row = 0; // in the list of all tiles
    std::string points, output;
};

/// The choice of --points, --rows and --output.
struct TileChoice {
    std::vector<std::string> patterns;
    std::string rows, output;

    void add_options(CommandLine& line);
    /// The chosen tiles, sorted by name. Fails where a pattern has no files, the
    /// rows are none, or the output has no place for a tile's name and there are several.
    Expected<std::vector<Tile>> tiles() const;
};

/// Why the outputs of tiles cannot be written, before anything is computed: one would write over an input or
/// another output, or has no folder that can be written to. Nothing is written.
///
///   inputs   further files that are read
///   outputs  further files to be written
std::optional<std::string> fault_of_tiles(const std::vector<Tile>& tiles,
                                          const std::vector<std::string>& inputs,
                                          const std::vector<std::string>& outputs);

} // namespace cageform_support
