#pragma once

// Rows of poses of a cage, counted from 0: the rows of a table, or samples of a clip at equal time steps.
// Tables may have any length.

#include "files/clip_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "svg/path.hpp"

#include <cageform/clip/clip.hpp>
#include <cageform/core/vec.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Help text on tables of poses.
inline constexpr const char* pose_table_format =
    "A table of poses is a CSV file with one pose per line: x,y,z of every vertex of the\n"
    "cage in its order (x,y in the plane), so 3n numbers for n vertices. Empty lines,\n"
    "lines that begin with # and a first row without a number are skipped. Cells can be\n"
    "quoted. A clip starts with a line length,SECONDS; row k is its pose after\n"
    "k / RATE seconds (--rate), and the rows end before the clip repeats.\n";

/// An unparsed row.
struct PoseRow {
    std::size_t row = 0;  // from 0
    std::size_t line = 0; // of a table; from 1
    std::string text;     // of a table
};

/// Sequential reader of a file of poses in dimension D, 2 or 3.
template <std::size_t D>
class PoseRows {
public:
    using Pose = std::vector<cageform::Vec<double, D>>;

    /// On failure error() is set. The first line that is not a comment distinguishes clips from tables.
    ///
    ///   rest   the vertices of the cage
    ///   rate   poses of a clip per second; positive
    PoseRows(const std::string& path, std::span<const cageform::Vec<double, D>> rest, double rate);

    /// Skips up to `count` rows without parsing them.
    void skip(std::size_t count);

    /// The next row; false at the end and on an error.
    bool next(PoseRow& row);

    /// Parses a row. Thread-safe.
    ///
    ///   fails   if a line does not have D numbers per vertex, or one is not finite
    Expected<Pose> pose_of(const PoseRow& row) const;

    /// Name of a row for messages: "poses.csv:12" or "walk.csv after 0.4 s".
    std::string name_of(const PoseRow& row) const;

    /// Index of the next row; at the end, the number of rows.
    std::size_t row() const { return row_; }

    /// The first error; empty if none.
    const std::string& error() const { return error_; }
    bool may_retry() const { return lines_.may_retry(); } ///< InputFile::may_retry

private:
    bool next_line(std::string_view& line); // the next row of a table
    void read_clip();

    std::string path_;
    std::vector<cageform::Vec<double, D>> rest_;
    double rate_ = 1;
    LineReader lines_;
    detail::RowFilter filter_;
    std::optional<std::string> first_; // first row of a table, until it is returned
    std::optional<cageform::CageClip<double, D>> clip_;
    std::size_t clip_rows_ = 0, row_ = 0;
    std::string error_;
};

} // namespace cageform_support
