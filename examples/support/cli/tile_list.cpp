#include "cli/tile_list.hpp"

#include "cli/row_range.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"

#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include <glob.h>
#include <sys/stat.h>

namespace cageform_support {

void TileChoice::add_options(CommandLine& line) {
    line.add(
            "--points", patterns,
            "files of points, tiles: PLY, OBJ or .npy; quote patterns such as 'tiles/*.ply', which may match "
            "more files than a command line holds")
        .required();
    add_rows(line, rows, "; rows are the tiles, sorted by name");
    line.add("-o,--output", output,
             "the figure to write; with several tiles a pattern whose * becomes the name of the tile")
        .required()
        .ends_with({".figure"});
}

std::vector<Tile> TileChoice::tiles() const {
    std::set<std::string> files;
    for (const std::string& pattern : patterns) {
        std::error_code none;
        if (std::filesystem::exists(pattern, none)) { // even with a * in its name
            files.insert(pattern);
            continue;
        }
        glob_t found{};
        const int code = glob(pattern.c_str(), 0, nullptr, &found);
        for (std::size_t n = 0; code == 0 && n < found.gl_pathc; ++n) files.insert(found.gl_pathv[n]);
        globfree(&found);
        if (code != 0) throw Failure("--points " + pattern + ": no such file");
    }
    const RowRange chosen = RowRange::of(rows.empty() ? ":" : rows).value_or(RowRange{});
    const std::size_t star = output.find('*');
    if (star == std::string::npos && files.size() > 1)
        throw Failure("--output " + output + ": there are " + std::to_string(files.size()) +
                      " tiles: write a * in place of the name of the tile, such as out/*.figure");
    std::vector<Tile> all;
    std::size_t row = 0;
    for (const std::string& file : files) {
        Tile tile{row++, file, output};
        if (star != std::string::npos)
            tile.output.replace(star, 1, std::filesystem::path(file).stem().string());
        if (tile.row >= chosen.first && tile.row < chosen.end) all.push_back(std::move(tile));
    }
    return all;
}

std::optional<std::string> fault_of_tiles(const std::vector<Tile>& tiles,
                                          const std::vector<std::string>& inputs,
                                          const std::vector<std::string>& outputs) {
    std::map<std::pair<dev_t, ino_t>, std::string> read; // by device and inode
    const auto identity = [](const std::string& path, std::pair<dev_t, ino_t>& id) {
        struct stat status{};
        if (stat(path.c_str(), &status) != 0) return false;
        id = {status.st_dev, status.st_ino};
        return true;
    };
    std::pair<dev_t, ino_t> id;
    for (const std::string& path : inputs) {
        if (identity(path, id)) read.emplace(id, path);
    }
    for (const Tile& tile : tiles) {
        if (identity(tile.points, id)) read.emplace(id, tile.points);
    }
    std::vector<std::string> written = outputs;
    for (const Tile& tile : tiles) written.push_back(tile.output);
    std::map<std::string, std::string> targets;
    for (const std::string& path : written) {
        if (identity(path, id) && read.contains(id))
            return "cannot write " + path + ": it is the same file as " + read[id] + ", which is read";
        const AtomicFile file(path);
        if (file.error()) return file.error();
        const auto [other, is_new] = targets.emplace(file.target().string(), path);
        if (!is_new)
            return "cannot write " + path + ": it is the same file as " + other->second +
                   ", which is written too";
    }
    return std::nullopt;
}

} // namespace cageform_support
