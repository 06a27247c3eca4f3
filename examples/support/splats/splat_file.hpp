#pragma once

// Scenes of 3D Gaussian splatting: binary PLY files as written by trainers and read by viewers.

#include "files/mesh_file.hpp"
#include "splats/splat.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Help text on scenes of splats.
inline constexpr const char* splat_format =
    "Scenes are PLY files, ASCII or binary. Each record of the element vertex is a splat, with\n"
    "the properties x y z, f_dc_0 to 2, opacity, scale_0 to 2, rot_0 to 3 and 0, 9, 24 or 45\n"
    "properties f_rest_N, channel by channel. Their order in the file is free. Other types\n"
    "become float; a pipe must be binary little-endian with these properties as float. Scales\n"
    "are logarithms, opacity is a logit, the quaternion is w x y z. All other properties and\n"
    "elements are kept; normals nx ny nz that are not zero turn with the splat. An opacity may\n"
    "be infinite; a scale of -inf makes a splat flat. Splats with other numbers that are not\n"
    "finite are left out, with a warning. So are splats farther from the median position than\n"
    "1e7 times the median distance, or with a scale above 88.\n"
    "Scenes are written as binary little-endian. Compressed files are not read. Messages\n"
    "count splats from 0. A scene is held in memory: 248 bytes per splat of degree 3.\n";

/// A splat in units of the file.
struct Splat {
    Point3 place;
    SplatShape shape;
    double opacity = 0; ///< a logit
    std::array<double, 3> colour{};
    std::array<std::vector<double>, 3> harmonics; ///< per channel, degrees 1 to the file's degree
};

/// Byte offsets of the numbers of a splat in its row.
struct SplatLayout {
    std::size_t row_bytes = 0;
    std::array<std::size_t, 3> place{}, colour{}, scales{};
    std::array<std::size_t, 4> rotation{};
    std::size_t opacity = 0;
    std::vector<std::size_t> rest;   ///< 0, 9, 24 or 45 coefficients, by channel
    std::vector<std::size_t> normal; ///< 3, or none

    std::size_t degree() const; ///< of the harmonics, 0 to 3
};

/// A scene: its header, and the rows of all splats as in the file.
struct SplatFile {
    std::string name;                // for messages
    std::vector<std::string> header; // lines between "format" and "end_header", without "element vertex"
    std::size_t element_at = 0;      // index of the header line before which "element vertex" is inserted
    SplatLayout layout;
    std::string before, rows, after; // bytes of elements before the splats, of the splats, and after
    std::string warning;             // on splats that were left out
    std::string others;              // properties and elements that are copied: "label", 1 of "camera"

    std::size_t size() const { return rows.size() / layout.row_bytes; }

    double number(std::size_t splat, std::size_t offset) const;
    void set(std::size_t splat, std::size_t offset, double value); ///< rounds to single precision
    Point3 vector(std::size_t splat, std::span<const std::size_t> offsets) const;
    void set(std::size_t splat, std::span<const std::size_t> offsets, const Point3& value);

    Point3 place(std::size_t splat) const { return vector(splat, layout.place); }
    SplatShape shape(std::size_t splat) const;
    void set(std::size_t splat, const SplatShape& shape);

    std::string header_text(std::size_t splats) const; ///< for a file with this many splats
};

/// Parses a binary little-endian file.
///
///   name     prefix of every message
///   strict   whether splats that splat_format leaves out are an error
///   fails    if the file does not match splat_format, is cut off, or no splat remains. The message names the
///            property, or the index of the splat from 0
Expected<SplatFile> parse_splats(std::string bytes, std::string name, bool strict = false);

/// As parse_splats(), from a file of any encoding; fails also if it cannot be read.
Expected<SplatFile> load_splats(const std::filesystem::path& path, bool strict = false);

/// An empty scene with all standard properties.
///
///   highest   degree of the harmonics, 0 to 3
SplatFile empty_scene(std::size_t highest);

/// Appends a splat; its other properties are 0.
void append(SplatFile& scene, const Splat& splat);

/// Conversion between a logit and the opacity at a splat's centre, 0 to 1.
double opacity_of(double logit);
double logit_of(double opacity);

} // namespace cageform_support
