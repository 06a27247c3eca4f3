#include "io/expected.hpp"

#include <algorithm>

namespace cageform_support {

std::string to_string(const FileError& error) {
    if (error.line == 0) return error.message;
    std::string where = " (line " + std::to_string(error.line);
    if (error.column != 0) where += ", column " + std::to_string(error.column);
    return error.message + where + ")";
}

FileError error_in_text(std::string why, std::string_view text, std::size_t position) {
    const std::string_view before = text.substr(0, position);
    const std::size_t line_start = before.rfind('\n') + 1; // npos + 1 is zero
    const auto line = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n')) + 1;
    return {std::move(why), line, before.size() - line_start + 1};
}

} // namespace cageform_support
