#pragma once

// Rows of a long job that one run processes (--rows A:B), and file names per row (a path with %06d). The
// tasks of a render farm process different rows.

#include "cli/command_line.hpp"

#include <cstddef>
#include <optional>
#include <string>

namespace cageform_support {

/// Rows `first` … `end` − 1, from 0.
struct RowRange {
    std::size_t first = 0, end = ~std::size_t{0};

    /// Parses "A:B", "A:", ":B", ":" or a single row "A"; nothing if invalid, or B is less than A.
    static std::optional<RowRange> of(const std::string& text);
};

/// Adds the option --rows. RowRange::of(rows) is then valid.
inline void add_rows(CommandLine& line, std::string& rows, const std::string& more_help = "") {
    const std::string help = "the rows to process, A:B, counted from 0: from A to B - 1; A or B can be "
                             "omitted, and B can exceed the "
                             "number of rows";
    line.add("--rows", rows, help + more_help).check([](const std::string& text) {
        return RowRange::of(text) ? std::string() : "\"" + text + "\" is no range of rows, such as 0:100";
    });
}

/// A path with a placeholder for a row number: %d, or %06d for at least six digits. %% is a percent sign.
class RowPath {
public:
    /// Returns the error; empty if the path is valid. The placeholder is optional.
    static std::string fault(const std::string& text);

    RowPath() = default;
    explicit RowPath(const std::string& text); // `text` is valid

    bool has_place() const { return has_place_; }
    std::string of(std::size_t row) const;

private:
    std::string before_, after_;
    std::size_t digits_ = 0;
    bool has_place_ = false;
};

} // namespace cageform_support
