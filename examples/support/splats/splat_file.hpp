#pragma once

// Scenes of 3D Gaussian splatting: the binary PLY files that trainers write and viewers read.

#include "files/obj_file.hpp"
#include "splats/splat.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// The text for --help.
inline constexpr const char* splat_format =
    "Scenes are PLY files, ASCII or binary, with the element vertex, a splat each. It has the\n"
    "properties x y z, f_dc_0 to 2, opacity, scale_0 to 2, rot_0 to 3 and 0, 9, 24 or 45 of\n"
    "f_rest, one channel after the other, in any order. Other types become float; a pipe must\n"
    "have float properties. Scales are logarithms, opacity is a logit, the quaternion is\n"
    "w x y z. All other properties and elements are kept, and nx ny nz turn where they are not\n"
    "zero. An opacity may be infinite, and a scale -inf, of a flat splat. Splats with other\n"
    "numbers that are not finite are left out, with a warning. So are splats farther from the\n"
    "median place than 1e7 times the median distance, and those with a scale above 88.\n"
    "Scenes are written as binary little-endian. Compressed files are not read. Messages\n"
    "count splats from 0. A scene is held in memory: 248 bytes a splat of degree 3.\n";

/// One splat, as the file has it.
struct Splat {
    Point3 place;
    SplatShape shape;
    double opacity = 0; ///< a logit
    std::array<double, 3> colour{};
    std::array<std::vector<double>, 3> harmonics; ///< by channel: of degrees 1 to the file's
};

/// Where the numbers of a splat stand in its row, in bytes.
struct SplatLayout {
    std::size_t row_bytes = 0;
    std::array<std::size_t, 3> place{}, colour{}, scales{};
    std::array<std::size_t, 4> rotation{};
    std::size_t opacity = 0;
    std::vector<std::size_t> rest;   ///< 0, 9, 24 or 45: the first channel first
    std::vector<std::size_t> normal; ///< 3, or none

    std::size_t degree() const; ///< of the harmonics, 0 to 3
};

/// A scene: its header, and the rows of all splats as they stand in the file.
struct SplatFile {
    std::string name;                // for messages
    std::vector<std::string> header; // lines between "format" and "end_header" but for that of the element
    std::size_t element_at = 0;      // before which of these lines the element's stands
    SplatLayout layout;
    std::string before, rows, after; // bytes of the elements before the splats, of the splats, and after
    std::string warning;             // of splats that were left out
    std::string others; // properties and elements that are kept as they are: "label", 1 of "camera"

    std::size_t size() const { return rows.size() / layout.row_bytes; }

    double number(std::size_t splat, std::size_t offset) const;
    void set(std::size_t splat, std::size_t offset, double value); ///< rounds to single precision
    Point3 vector(std::size_t splat, std::span<const std::size_t> offsets) const;
    void set(std::size_t splat, std::span<const std::size_t> offsets, const Point3& value);

    Point3 place(std::size_t splat) const { return vector(splat, layout.place); }
    SplatShape shape(std::size_t splat) const;
    void set(std::size_t splat, const SplatShape& shape);

    std::string header_text(std::size_t splats) const; ///< of a file with so many
};

/// A scene from the bytes of a binary little-endian file.
///
///   name     stands before every message.
///   strict   whether a splat that splat_format leaves out is an error.
///   fails    if the bytes are not as splat_format says, if the file is cut off, or if no splat is left.
///            The message names the property, or the number of the splat, counted from 0.
Expected<SplatFile> parse_splats(std::string bytes, std::string name, bool strict = false);

/// Works as parse_splats(), from a file of any encoding; fails also where it cannot be read.
Expected<SplatFile> load_splats(const std::filesystem::path& path, bool strict = false);

/// An empty scene with all standard properties.
///
///   highest   degree of the harmonics, 0 to 3
SplatFile empty_scene(std::size_t highest);

/// Appends a splat to a scene, whose other properties become 0.
void append(SplatFile& scene, const Splat& splat);

/// The share of light that a splat takes in its middle, 0 to 1, from a logit, and back.
double opacity_of(double logit);
double logit_of(double opacity);

} // namespace cageform_support
