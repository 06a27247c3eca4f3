#pragma once

// Lists of input files that several processes share: patterns, rows, and an output file for each input.

#include "cli/command_line.hpp"
#include "svg/path.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace cageform_support {

/// A file of points and the figure to write.
struct Tile {
    std::size_t row = 0; // index in the list of all tiles
    std::string points, output;
};

/// The options --points, --rows and --output.
struct TileChoice {
    std::vector<std::string> patterns;
    std::string rows, output;

    void add_options(CommandLine& line);
    /// The selected tiles, sorted by name. Fails if a pattern matches no file, the rows are invalid, or the
    /// output has no placeholder and there are several tiles.
    std::vector<Tile> tiles() const;
};

/// Checks whether outputs can be written, before computing; returns the error, if any. An output must not be
/// an input or another output, and its folder must be writable. Nothing is written.
///
///   inputs    further input files
///   outputs   further output files
std::optional<std::string> fault_of_tiles(const std::vector<Tile>& tiles,
                                          const std::vector<std::string>& inputs,
                                          const std::vector<std::string>& outputs);

} // namespace cageform_support
