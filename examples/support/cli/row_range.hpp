#pragma once

// The rows of a long job that one run of a program does, and the names of their files: --rows A:B and a path
// with %06d. A farm gives every task other rows.

#include <cstddef>
#include <optional>
#include <string>

namespace cageform_support {

/// Rows `first` … `end` − 1, counted from 0.
struct RowRange {
    std::size_t first = 0, end = ~std::size_t{0};

    /// "A:B", "A:", ":B", ":" or one row, "A"; nothing of any other text, and where B is less than A.
    static std::optional<RowRange> of(const std::string& text);
};

/// The text for --help.
inline constexpr const char* rows_help = "the rows to do, as A:B: from A, counted from 0, to before B; "
                                         "either may be left out, and B may be larger than "
                                         "the number of rows";

/// A path with a place for the number of a row: %d, or %06d for at least six digits. %% is one %.
class RowPath {
public:
    /// Why a text is no such path; empty if it is one. A path without a place is one too.
    static std::string fault(const std::string& text);

    RowPath() = default;
    explicit RowPath(const std::string& text); // without a fault

    bool has_place() const { return has_place_; }
    std::string of(std::size_t row) const;

private:
    std::string before_, after_;
    std::size_t digits_ = 0;
    bool has_place_ = false;
};

} // namespace cageform_support
