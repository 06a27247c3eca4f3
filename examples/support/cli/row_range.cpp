#include "cli/row_range.hpp"

#include "io/csv.hpp"

#include <algorithm>
#include <string_view>

namespace cageform_support {

std::optional<RowRange> RowRange::of(const std::string& text) {
    RowRange rows;
    const std::string_view all = text;
    const std::size_t colon = all.find(':');
    const std::string_view from = all.substr(0, colon);
    if (colon == all.npos) {
        if (!detail::parse_whole(from, rows.first) || rows.first == rows.end) return std::nullopt;
        rows.end = rows.first + 1;
        return rows;
    }
    const std::string_view to = all.substr(colon + 1);
    if ((!from.empty() && !detail::parse_whole(from, rows.first)) ||
        (!to.empty() && !detail::parse_whole(to, rows.end)) || rows.end < rows.first)
        return std::nullopt;
    return rows;
}

namespace detail {

/// A path split at its placeholder.
struct CutPath {
    std::string fault, before, after;
    std::size_t digits = 0, places = 0;
};

CutPath cut_path(std::string_view text) {
    CutPath cut;
    while (!text.empty() && cut.fault.empty()) {
        std::string& part = cut.places == 0 ? cut.before : cut.after;
        if (!text.starts_with('%') || text.starts_with("%%")) {
            part += text.front();
            text.remove_prefix(text.starts_with('%') ? 2 : 1);
            continue;
        }
        text.remove_prefix(1);
        const std::size_t length = std::min(text.find_first_not_of("0123456789"), text.size());
        const std::string_view width = text.substr(0, length);
        text.remove_prefix(length);
        const bool is_width = width.empty() || (width.size() <= 3 && width.starts_with('0'));
        if (!is_width || !text.starts_with('d') || ++cut.places > 1)
            cut.fault = "has a % that is not a placeholder for the row number: write %06d once, or %% for a "
                        "percent sign";
        if (width.size() > 1) (void)parse_whole(width, cut.digits);
        if (!text.empty()) text.remove_prefix(1);
    }
    return cut;
}

} // namespace detail

std::string RowPath::fault(const std::string& text) {
    return detail::cut_path(text).fault;
}

RowPath::RowPath(const std::string& text) {
    auto cut = detail::cut_path(text);
    before_ = std::move(cut.before);
    after_ = std::move(cut.after);
    digits_ = cut.digits;
    has_place_ = cut.places > 0;
}

std::string RowPath::of(std::size_t row) const {
    if (!has_place_) return before_;
    const std::string number = std::to_string(row);
    return before_ + std::string(digits_ > number.size() ? digits_ - number.size() : 0, '0') + number +
           after_;
}

} // namespace cageform_support
