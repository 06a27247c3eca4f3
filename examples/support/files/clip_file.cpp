#include "files/clip_file.hpp"

#include "io/csv.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace cageform_support {

Expected<ClipFile> load_clip(const std::string& path, std::size_t vertex_count) {
    const auto text = read_text(path);
    return text ? parse_clip(*text, path, vertex_count) : text.error();
}

Expected<PoseClip> load_pose_clip(const std::string& path, std::size_t vertex_count) {
    const auto text = read_text(path);
    return text ? parse_pose_clip(*text, path, vertex_count) : text.error();
}

namespace {

/// Parses field k as a finite number. An error is stored in `why`, unless it has one already.
double field_number(const std::vector<std::string_view>& fields, std::size_t k, std::string& why) {
    double x = 0;
    const std::string fault = k < fields.size() ? detail::parse_finite(fields[k], x) : "a number is missing";
    if (why.empty() && !fault.empty()) why = "column " + std::to_string(k + 1) + ": " + fault;
    return x;
}

/// Returns the error if a line has too many columns, for example by decimal commas; else empty.
std::string fault_of_columns(const std::vector<std::string_view>& fields) {
    const std::string_view word = fields.front();
    if (word == "vertices" || word == "time") return {};
    const bool has_one = word == "length" || word == "control";
    const bool has_two = word == "late" || word == "ground" || word == "pivot" || word == "pose";
    const std::size_t most = has_one ? 2 : has_two ? 3 : 5;
    if (fields.size() <= most) return {};
    return std::to_string(fields.size()) + " columns, where a line of this kind has " + std::to_string(most) +
           " at most";
}

/// Parses "vertices,11:0.5,10". Returns the error; empty on success.
std::string add_shares(const std::vector<std::string_view>& fields, std::size_t vertex_count,
                       ClipControl& control) {
    for (std::size_t k = 1; k < fields.size(); ++k) {
        const std::size_t colon = fields[k].find(':');
        double vertex = 0, weight = 1;
        std::string why = detail::parse_number(fields[k].substr(0, colon), vertex);
        if (why.empty() && colon != std::string::npos)
            why = detail::parse_number(fields[k].substr(colon + 1), weight);
        if (!why.empty()) return why;
        if (!(vertex >= 0 && vertex < double(vertex_count)) || vertex != std::floor(vertex))
            return "the cage has no vertex " + detail::quoted(fields[k]);
        control.shares.push_back({std::size_t(vertex), weight});
    }
    return {};
}

/// Parses "pin,NAME,X,Y[,WEIGHT]". Returns the error; empty on success.
std::string add_pin(const std::vector<std::string_view>& fields, ClipControl& control) {
    std::string why;
    const auto value = [&](std::size_t k) { return field_number(fields, k, why); };
    control.pin = {{value(2), value(3)}, fields.size() > 4 ? value(4) : 1};
    return why.empty() && !(control.pin->weight > 0) ? "the weight of a pin is not positive" : why;
}

/// Parses "TIME,X,Y,TURN,KIND". Returns the error; empty on success.
std::string add_row(const std::vector<std::string_view>& fields, ClipControl& control) {
    std::string why;
    const auto value = [&](std::size_t k) { return field_number(fields, k, why); };
    ClipControl::Row row{value(0), {value(1), value(2), value(3)}};
    if (!why.empty()) return why;
    row.move[2] *= std::numbers::pi / 180;
    const std::string_view kind = fields.size() > 4 ? fields[4] : "";
    if (kind == "ease")
        row.kind = cageform::KeyKind::bezier;
    else if (kind == "hold")
        row.kind = cageform::KeyKind::hold;
    else if (kind == "linear")
        row.kind = cageform::KeyKind::linear;
    else if (kind != "automatic")
        return "a key is hold, linear, automatic or ease, not " + detail::quoted(kind);
    if (!control.rows.empty() && !(row.time > control.rows.back().time))
        return "a key is not later than the one before it";
    control.rows.push_back(row);
    return {};
}

/// Returns the error if the keys of a control do not fit a clip of this length; else empty.
std::string fault_of_rows(const ClipControl& control, double length) {
    if (control.rows.size() < 2) return "it has fewer than two keys";
    const double begin = control.rows.front().time, period = control.rows.back().time - begin;
    const double turns = length / period, keys = turns * double(control.rows.size() - 1);
    if (!(std::fabs(turns - std::round(turns)) <= 1e-9) || turns < 0.5)
        return "the length of the clip is not a multiple of the duration of these keys";
    if (keys > 1e5)
        return "repeated over the clip it has " + detail::short_number(keys) +
               " keys; at most 100000 are allowed";
    // Shifting times by whole periods would lose too many digits.
    if (std::fabs(begin) > 1e6 * period)
        return "its first key, at " + detail::short_number(begin) +
               ", is more than a million of its periods from the clip's start";
    return {};
}

} // namespace

Expected<ClipFile> parse_clip(std::string_view file, const std::string& path, std::size_t vertex_count) {
    ClipFile clip;
    clip.name = path;
    std::size_t number = 0;
    detail::RowFilter rows;
    for (std::string_view line; take_line(file, line);) {
        ++number;
        if (!rows.take(line)) continue;
        const auto fields = detail::cells_of(line);
        const std::string_view word = fields.front();
        std::string why = fault_of_columns(fields);
        const auto value = [&](std::size_t k) { return field_number(fields, k, why); };
        if (word == "length") {
            clip.length = value(1);
            if (why.empty() && !(clip.length > 0)) why = "the length is not positive";
        } else if (word == "late") {
            clip.late.push_back({std::string(fields.size() > 1 ? fields[1] : ""), value(2)});
        } else if (word == "ground") {
            clip.ground = {value(1), value(2)};
        } else if (word == "control") {
            clip.controls.emplace_back().name = fields.size() > 1 ? fields[1] : "";
            if (clip.has_pins()) why = "a clip has either controls or pins";
        } else if (word == "pin") {
            if (!clip.controls.empty() && !clip.has_pins()) why = "a clip has either controls or pins";
            ClipControl& control = clip.controls.emplace_back();
            control.name = fields.size() > 1 ? fields[1] : "";
            if (why.empty()) why = add_pin(fields, control);
        } else if (clip.controls.empty()) {
            why = "\"control,NAME\" is missing before this line";
        } else if (ClipControl& control = clip.controls.back();
                   control.pin && (word == "vertices" || word == "pivot")) {
            why = "a pin has no " + std::string(word);
        } else if (word == "vertices") {
            why = add_shares(fields, vertex_count, control);
        } else if (word == "pivot") {
            control.pivot = {value(1), value(2)};
        } else if (word != "time") {
            if (why.empty()) why = add_row(fields, control);
        }
        if (!why.empty()) return detail::row_fault(path, number, line, why);
    }
    if (clip.length == 0) return FileError{path + ": the line \"length,SECONDS\" is missing"};
    for (const ClipControl& control : clip.controls) {
        const std::string why = fault_of_rows(control, clip.length);
        if (!why.empty()) return FileError{path + ": " + detail::quoted(control.name) + ": " + why};
    }
    return clip;
}

std::string clip_text(const ClipFile& clip, const std::string& heading) {
    std::string text = "# " + heading + "\nlength," + detail::digits_of(clip.length) + '\n';
    const auto append = [&](std::initializer_list<double> numbers) {
        for (const double x : numbers) text += ',' + detail::digits_of(x);
    };
    for (const auto& late : clip.late)
        text += "late," + late.element + ',' + detail::digits_of(late.seconds) + '\n';
    if (clip.ground) {
        text += "ground";
        append({clip.ground->y, clip.ground->speed});
        text += '\n';
    }
    for (const ClipControl& control : clip.controls) {
        text += (control.pin ? "\npin," : "\ncontrol,") + control.name;
        if (control.pin) append({control.pin->place.x, control.pin->place.y, control.pin->weight});
        if (!control.pin) {
            text += "\nvertices";
            for (const auto& [vertex, weight] : control.shares)
                text += ',' + std::to_string(vertex) + ':' + detail::digits_of(weight);
            text += "\npivot";
            append({control.pivot.x, control.pivot.y});
        }
        text += "\ntime,x,y,turn,kind\n";
        for (const auto& [time, move, kind] : control.rows) {
            text += detail::digits_of(time);
            append({move[0], move[1], move[2] * 180 / std::numbers::pi});
            text += kind == cageform::KeyKind::bezier   ? ",ease\n"
                    : kind == cageform::KeyKind::hold   ? ",hold\n"
                    : kind == cageform::KeyKind::linear ? ",linear\n"
                                                        : ",automatic\n";
        }
    }
    return text;
}

namespace {

std::string parse_way(std::string_view word, PoseInterpolation& way) {
    if (word == "linear")
        way = PoseInterpolation::linear;
    else if (word == "ease")
        way = PoseInterpolation::ease;
    else if (word != "smooth" && !word.empty())
        return "a pose is smooth, linear or ease, not " + detail::quoted(word);
    return {};
}

/// Parses x,y,z in single precision; returns the error, or empty.
std::string parse_vertex(std::string_view line, cageform::Vec<double, 3>& vertex) {
    std::array<double, 3> p{};
    std::string why = detail::parse_point(line, p);
    for (std::size_t k = 0; k < 3 && why.empty(); ++k) {
        vertex[k] = p[k];
        why = detail::single_precision_fault(p[k]);
        if (!why.empty()) why = "column " + std::to_string(k + 1) + ": " + why;
    }
    return why;
}

} // namespace

Expected<PoseClip> parse_pose_clip(std::string_view file, const std::string& path, std::size_t vertex_count) {
    PoseClip clip;
    clip.name = path;
    std::size_t number = 0;
    const auto count_fault = [&]() -> std::string {
        if (clip.keys.empty() || clip.keys.back().places.size() == vertex_count) return {};
        return "the previous pose has " + std::to_string(clip.keys.back().places.size()) +
               " vertices, but the cage has " + std::to_string(vertex_count);
    };
    detail::RowFilter rows;
    for (std::string_view line; take_line(file, line);) {
        ++number;
        if (!rows.take(line)) continue;
        const auto fields = detail::cells_of(line);
        std::string why = fault_of_columns(fields);
        const auto finite_number = [&] {
            const double x = field_number(fields, 1, why);
            if (why.empty()) why = detail::single_precision_fault(x);
            return x;
        };
        if (fields[0] == "length") {
            clip.length = finite_number();
            if (why.empty() && !(clip.length > 0)) why = "the length is not positive";
        } else if (fields[0] == "pose") {
            if (why.empty()) why = count_fault();
            PoseKey key;
            key.time = finite_number();
            if (why.empty()) why = parse_way(fields.size() > 2 ? fields[2] : "", key.way);
            if (why.empty() && clip.keys.empty() && key.time != 0) why = "the first pose has to be at time 0";
            if (why.empty() && !clip.keys.empty() && !(float(key.time) > float(clip.keys.back().time)))
                why = "a pose is not later than the one before it";
            clip.keys.push_back(std::move(key));
        } else if (clip.keys.empty()) {
            why = "\"pose,TIME\" is missing before this line";
        } else {
            why = parse_vertex(line, clip.keys.back().places.emplace_back());
            if (why.empty() && clip.keys.back().places.size() > vertex_count)
                why = "more vertices than the cage has, " + std::to_string(vertex_count);
        }
        if (!why.empty()) return detail::row_fault(path, number, line, why);
    }
    if (clip.length == 0) return FileError{path + ": the line \"length,SECONDS\" is missing"};
    if (clip.keys.size() < 2) return FileError{path + ": holds fewer than two poses"};
    const std::string why = count_fault();
    if (!why.empty()) return FileError{path + ":" + std::to_string(number) + ": " + why};
    if (!(float(clip.keys.back().time) < float(clip.length)))
        return FileError{
            path + ": the last pose has to be before the end of the clip, where the first pose returns"};
    return clip;
}

std::string pose_clip_text(const PoseClip& clip, const std::string& heading) {
    std::string text = "# " + heading + formatted("\nlength,%.9g\n", clip.length);
    for (const PoseKey& key : clip.keys) {
        text += formatted("pose,%.9g,%s\n", key.time,
                          key.way == PoseInterpolation::smooth   ? "smooth"
                          : key.way == PoseInterpolation::linear ? "linear"
                                                                 : "ease");
        for (const auto& p : key.places) text += formatted("%.6f,%.6f,%.6f\n", p[0], p[1], p[2]);
    }
    return text;
}

cageform::PiecewiseCubic<double> curve_through(const PoseClip& clip, std::span<const double> values) {
    const std::size_t count = clip.keys.size();
    const auto step = [&](std::size_t k) { // from key k to the next
        return (k + 1 < count ? clip.keys[k + 1].time : clip.length) - clip.keys[k].time;
    };
    const auto chord = [&](std::size_t k) { return (values[(k + 1) % count] - values[k]) / step(k); };
    const auto slope = [&](std::size_t k) {
        if (clip.keys[k].way == PoseInterpolation::ease) return 0.0;
        const std::size_t last = (k + count - 1) % count;
        const double before = step(last), after = step(k);
        return (after * chord(last) + before * chord(k)) / (before + after);
    };
    std::vector<cageform::CubicPiece<double>> pieces;
    for (std::size_t k = 0; k < count; ++k) {
        const bool straight = clip.keys[k].way == PoseInterpolation::linear;
        const double h = step(k), all = chord(k);
        const double a = straight ? all : slope(k), b = straight ? all : slope((k + 1) % count);
        pieces.push_back(
            {clip.keys[k].time, values[k], a, (3 * all - 2 * a - b) / h, (a + b - 2 * all) / (h * h)});
    }
    return {std::move(pieces), clip.length, values[0]};
}

SampledPoses sample_poses(const PoseClip& clip, double rate) {
    const auto motion = make_clip<double>(clip);
    auto cursor = motion.make_cursor();
    std::vector<cageform::Vec<double, 3>> pose(motion.vertex_count());
    SampledPoses samples;
    for (std::size_t k = 0; k < clip.keys.size(); ++k) {
        const double begin = clip.keys[k].time;
        const double end = k + 1 < clip.keys.size() ? clip.keys[k + 1].time : clip.length;
        const double parts = std::max(4.0, std::ceil(rate * (end - begin)));
        for (double part = 0; part < parts; ++part) {
            samples.times.push_back(begin + part / parts * (end - begin));
            motion.sample(samples.times.back(), cursor, pose);
            for (const auto& p : pose) samples.numbers.insert(samples.numbers.end(), p.v, p.v + 3);
        }
    }
    return samples;
}

std::string name_of_pose(const PoseClip& clip, double time) {
    std::ostringstream text;
    text << clip.name << " after " << time << " s";
    return text.str();
}

} // namespace cageform_support
