#include "files/marker_file.hpp"

#include "io/csv.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

constexpr double way_back = 0.5; // seconds from the last row to the first, if they differ

/// Parser of marker files.
class MarkerReader {
public:
    ///   columns   largest number of nonempty columns of any row; trailing empty cells do not count
    MarkerReader(const std::string& name, std::size_t columns)
        : most_columns_(columns) {
        clip_.name = name;
    }

    /// Parses a line. Returns the error; empty on success.
    std::string take(std::string_view line) {
        const auto fields = detail::cells_of(line, columns_ != 0 ? columns_ : most_columns_);
        if (fields[0] == "late" || fields[0] == "ground") return take_setting(fields);
        if (columns_ == 0 && (fields[0] == "time" || detail::is_header(line))) return take_names(fields);
        if (columns_ == 0 && fields.size() % 2 == 0) return "a row is a time, then x,y of every marker";
        if (columns_ == 0) columns_ = fields.size();
        if (fields.size() != columns_) {
            return detail::counted(fields.size(), "column") + ", and the first row has " +
                   std::to_string(columns_);
        }
        if (columns_ < 3) return "holds no marker: a row is a time, then x,y of every marker";
        clip_.controls.resize(columns_ / 2);
        return fields[0] == "rest" ? take_rest(fields) : take_row(fields);
    }

    /// Checks and completes the clip. Returns the error; empty on success.
    std::string end() {
        if (times_ < 2) return "holds fewer than two times";
        const double length = last_ - first_;
        if (!(length <= 1e9)) return "its times are too far apart: at most 1e9 seconds are allowed";
        bool differs = false;
        for (std::size_t n = 0; n < clip_.controls.size(); ++n) {
            ClipControl& marker = clip_.controls[n];
            if (marker.name.empty()) marker.name = "marker " + std::to_string(n + 1);
            auto& rows = marker.rows;
            if (rows.empty()) return detail::quoted(marker.name) + " has no position at any time";
            if (!marker.pin) return detail::quoted(marker.name) + " has no rest position";
            const Point2& rest = marker.pin->place;
            for (auto& row : rows) {
                row.move = {row.move[0] - rest.x, row.move[1] - rest.y, 0};
                if (!std::isfinite(row.move[0]) || !std::isfinite(row.move[1]))
                    return detail::quoted(marker.name) + " exceeds the range of numbers";
            }
            if (rows.front().time > 0) rows.insert(rows.begin(), {0, rows.front().move});
            if (rows.back().time < length) rows.push_back({length, rows.back().move});
            differs = differs || rows.front().move != rows.back().move;
        }
        clip_.length = length + (differs ? way_back : 0);
        for (ClipControl& marker : clip_.controls) {
            if (differs) marker.rows.push_back({clip_.length, marker.rows.front().move});
        }
        return {};
    }

    ClipFile& clip() { return clip_; }

private:
    std::string take_names(std::span<const std::string_view> fields) {
        columns_ = fields.size();
        if (columns_ % 2 == 0 || columns_ < 3) return "a row is a time, then x,y of every marker";
        clip_.controls.resize(columns_ / 2);
        for (std::size_t n = 0; n < clip_.controls.size(); ++n) {
            std::string_view name = fields[2 * n + 1];
            if (name.size() > 2 && (name.ends_with(" x") || name.ends_with("_x") || name.ends_with(".x")))
                name.remove_suffix(2);
            clip_.controls[n].name = name;
        }
        return {};
    }

    std::string take_setting(std::span<const std::string_view> fields) {
        if (fields.size() != 3) return quoted_setting(fields[0]);
        double number = 0, other = 0;
        std::string why = detail::parse_finite(fields[2], number);
        if (fields[0] == "late") {
            clip_.late.push_back({std::string(fields[1]), number});
        } else {
            if (why.empty()) why = detail::parse_finite(fields[1], other);
            clip_.ground = {other, number};
        }
        return why;
    }
    static std::string quoted_setting(std::string_view word) {
        return word == "late" ? "\"late\" takes an element and seconds" : "\"ground\" takes y and a speed";
    }

    /// Parses the position of a marker; `is_seen` is false if both fields are empty.
    static std::string read_place(std::span<const std::string_view> fields, std::size_t n, Point2& p,
                                  bool& is_seen) {
        const std::string_view x = fields[2 * n + 1], y = fields[2 * n + 2];
        is_seen = !(x.empty() && y.empty());
        if (!is_seen) return {};
        std::string why = detail::parse_finite(x, p.x);
        return why.empty() ? detail::parse_finite(y, p.y) : why;
    }

    std::string take_rest(std::span<const std::string_view> fields) {
        if (has_rest_ || times_ > 0) return "the rest row has to be the first row, and only one is allowed";
        has_rest_ = true;
        return set_rest(fields);
    }
    std::string set_rest(std::span<const std::string_view> fields) {
        for (std::size_t n = 0; n < clip_.controls.size(); ++n) {
            bool is_seen = false;
            Point2 place;
            if (std::string why = read_place(fields, n, place, is_seen); !why.empty()) return why;
            if (is_seen) clip_.controls[n].pin = ClipControl::Pin{place, 1};
        }
        return {};
    }

    std::string take_row(std::span<const std::string_view> fields) {
        double time = 0;
        if (std::string why = detail::parse_finite(fields[0], time); !why.empty()) return why;
        if (times_ > 0 && !(time - first_ > last_ - first_))
            return "a time is not later than the one before it";
        if (times_++ == 0) first_ = time;
        last_ = time;
        if (times_ == 1 && !has_rest_) {
            if (std::string why = set_rest(fields); !why.empty()) return why;
        }
        for (std::size_t n = 0; n < clip_.controls.size(); ++n) {
            bool is_seen = false;
            Point2 place;
            if (std::string why = read_place(fields, n, place, is_seen); !why.empty()) return why;
            if (is_seen) clip_.controls[n].rows.push_back({time - first_, {place.x, place.y, 0}});
        }
        return {};
    }

    ClipFile clip_;
    std::size_t most_columns_, columns_ = 0, times_ = 0;
    bool has_rest_ = false;
    double first_ = 0, last_ = 0;
};

} // namespace

Expected<ClipFile> parse_markers(std::string_view text, const std::string& name) {
    std::size_t number = 0, columns = 1;
    std::string_view all = text;
    for (std::string_view line; take_line(all, line);) {
        line = detail::trim(line);
        if (!line.starts_with('#')) columns = std::max(columns, detail::cells_of(line).size() | 1);
    }
    MarkerReader reader(name, columns);
    for (std::string_view line; take_line(text, line);) {
        ++number;
        line = detail::trim(line);
        if (detail::is_empty_row(line) || line.front() == '#') continue;
        if (const std::string why = reader.take(line); !why.empty())
            return detail::row_fault(name, number, line, why);
    }
    if (const std::string why = reader.end(); !why.empty()) return FileError{name + ": " + why};
    return std::move(reader.clip());
}

Expected<ClipFile> load_markers(const std::string& path) {
    const auto text = read_text(path);
    return text ? parse_markers(*text, path) : text.error();
}

std::string markers_text(const Tracks& tracks, const ClipFile& of, const std::string& heading) {
    std::string text = "# " + heading + '\n';
    for (const auto& late : of.late)
        text += "late," + late.element + ',' + detail::digits_of(late.seconds) + '\n';
    if (of.ground)
        text +=
            "ground," + detail::digits_of(of.ground->y) + ',' + detail::digits_of(of.ground->speed) + '\n';
    text += "time";
    for (std::size_t n = 1; n <= tracks.rest.size(); ++n) {
        for (const char* axis : {" x", " y"}) text += ",marker " + std::to_string(n) + axis;
    }
    const auto add_row = [&](const std::string& time, const std::vector<Point2>& places) {
        text += '\n' + time;
        for (const Point2& p : places) text += ',' + format_number(p.x, 2) + ',' + format_number(p.y, 2);
    };
    add_row("rest", tracks.rest);
    for (std::size_t n = 0; n < tracks.times.size(); ++n)
        add_row(format_number(tracks.times[n], 4), tracks.places[n]);
    return text + '\n';
}

} // namespace cageform_support
