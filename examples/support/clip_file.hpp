#pragma once

// Motions of a cage as text: controls, each of which moves some vertices, and keys that say how far and when.
//
//     length,2.4                  of the clip, in seconds; then it begins again
//     late,far-legs,0.6           the element far-legs of the figure does the same 0.6 s later
//     ground,744,166              a ground at y = 744 that passes by at 166 units a second
//
//     control,the tail sways
//     vertices,11:0.5,10,9        with weights, 1 where not given
//     pivot,775,400               about which the vertices turn
//     time,x,y,turn,kind
//     0.0,0,0,-6,ease
//     1.2,0,0,6,ease
//     2.4,0,0,-6,ease
//
// A key moves the control's vertices by x and y and turns them by degrees, clockwise on the screen. Its kind
// is hold, linear, automatic, or ease: Bézier handles that leave the key and come to it level. A control
// begins again after its last key, so its time is a part of the clip's. Where several controls move a vertex,
// it does all of it.

#include "csv.hpp"

#include <cageform/animate/clip.hpp>
#include <cageform/animate/compile_track.hpp>

#include <cstdio>
#include <numbers>
#include <span>

namespace cageform_examples {

struct ClipControl {
    struct Share {
        std::size_t vertex = 0;
        double weight = 1;
    };
    struct Row {
        double time = 0;
        std::array<double, 3> move{}; // x, y, turn
        cageform::KeyKind kind = cageform::KeyKind::automatic;
    };
    std::string name;
    std::vector<Share> shares;
    Point2 pivot;
    std::vector<Row> rows;
};

struct ClipFile {
    struct Late {
        std::string element;
        double seconds = 0;
    };
    struct Ground {
        double y = 0, speed = 0; // units a second, to the right
    };
    std::string name;
    double length = 0;
    std::vector<Late> late;
    std::optional<Ground> ground;
    std::vector<ClipControl> controls;
};

inline SvgResult<ClipFile> load_clip(const std::string& path, std::size_t vertex_count) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path)) return SvgError{path + ": cannot be read"};
    ClipFile clip;
    clip.name = path;
    std::size_t number = 0;
    const auto refuse = [&](const std::string& why) {
        return SvgError{path + ":" + std::to_string(number) + ": " + why};
    };
    for (std::string line; std::getline(file, line);) {
        ++number;
        const std::string_view text = detail::trim(line);
        if (text.empty() || text.front() == '#') continue;
        std::vector<std::string> fields;
        for (std::size_t at = 0; at <= text.size();) {
            const std::size_t end = std::min(text.find(',', at), text.size());
            fields.emplace_back(detail::trim(text.substr(at, end - at)));
            at = end + 1;
        }
        const std::string& word = fields.front();
        std::string why;
        const auto value = [&](std::size_t k) {
            double x = 0;
            const std::string fault =
                k < fields.size() ? detail::parse_number(fields[k], x) : "a number is missing";
            if (why.empty()) why = !fault.empty() ? fault : std::isfinite(x) ? "" : "a number is not finite";
            return x;
        };
        if (word == "length") {
            clip.length = value(1);
            if (why.empty() && !(clip.length > 0)) why = "the length is not positive";
        } else if (word == "late") {
            clip.late.push_back({fields.size() > 1 ? fields[1] : "", value(2)});
        } else if (word == "ground") {
            clip.ground = {value(1), value(2)};
        } else if (word == "control") {
            clip.controls.emplace_back().name = fields.size() > 1 ? fields[1] : "";
        } else if (clip.controls.empty()) {
            why = "\"control,NAME\" is missing before";
        } else if (ClipControl& control = clip.controls.back(); word == "vertices") {
            for (std::size_t k = 1; k < fields.size(); ++k) {
                const std::size_t colon = fields[k].find(':');
                double vertex = 0, weight = 1;
                if (why.empty()) why = detail::parse_number(fields[k].substr(0, colon), vertex);
                if (why.empty() && colon != std::string::npos)
                    why = detail::parse_number(fields[k].substr(colon + 1), weight);
                if (why.empty() &&
                    (!(vertex >= 0 && vertex < double(vertex_count)) || vertex != std::floor(vertex)))
                    why = "the cage has no vertex " + fields[k];
                if (why.empty()) control.shares.push_back({std::size_t(vertex), weight});
            }
        } else if (word == "pivot") {
            control.pivot = {value(1), value(2)};
        } else if (word != "time") {
            ClipControl::Row row{value(0), {value(1), value(2), value(3)}};
            row.move[2] *= std::numbers::pi / 180;
            const std::string kind = fields.size() > 4 ? fields[4] : "";
            if (kind == "ease")
                row.kind = cageform::KeyKind::bezier;
            else if (kind == "hold")
                row.kind = cageform::KeyKind::hold;
            else if (kind == "linear")
                row.kind = cageform::KeyKind::linear;
            else if (kind != "automatic" && why.empty())
                why = "a key is hold, linear, automatic or ease, not \"" + kind + '"';
            if (why.empty() && !control.rows.empty() && !(row.time > control.rows.back().time))
                why = "a key is not later than the one before it";
            control.rows.push_back(row);
        }
        if (!why.empty()) return refuse(why);
    }
    if (clip.length == 0) return SvgError{path + ": no \"length,SECONDS\""};
    for (const ClipControl& control : clip.controls) {
        if (control.rows.size() < 2) return SvgError{path + ": " + control.name + ": fewer than two keys"};
        const double turns = clip.length / (control.rows.back().time - control.rows.front().time);
        if (std::fabs(turns - std::round(turns)) > 1e-9 || turns < 0.5)
            return SvgError{path + ": " + control.name + ": its time is no part of the clip's"};
    }
    return clip;
}

namespace detail {

/// Keys of one axis of a control, repeated until they cover the clip and a turn more at both ends, so that
/// slopes at the clip's ends agree.
inline std::vector<cageform::Key> keys_of(const ClipControl& control, std::size_t axis, double length) {
    const auto& rows = control.rows;
    const double begin = rows.front().time, period = rows.back().time - begin;
    std::vector<cageform::Key> keys;
    const double first = std::floor(-begin / period) - 1, last = std::ceil((length - begin) / period) + 1;
    for (double turn = first; turn < last; ++turn) {
        for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
            cageform::Key key;
            key.time = rows[i].time + turn * period;
            key.value = rows[i].move[axis];
            key.kind = rows[i].kind;
            keys.push_back(key);
        }
    }
    constexpr double ease = 0.42; // of an interval, as CSS has it
    for (std::size_t i = 0; i < keys.size(); ++i) {
        cageform::Key& key = keys[i];
        const double before = i > 0 ? key.time - keys[i - 1].time : 0;
        const double after = i + 1 < keys.size() ? keys[i + 1].time - key.time : 0;
        key.in_handle = {key.time - ease * before, key.value};
        key.out_handle = {key.time + ease * after, key.value};
    }
    return keys;
}

/// value + Σ weight · curve on [0, length]: cubics again, on all the curves' knots.
struct WeightedCurve {
    double weight = 0;
    const cageform::PiecewiseCubic<double>* curve = nullptr;
};
inline cageform::PiecewiseCubic<double> sum(double value, std::span<const WeightedCurve> terms,
                                            double length) {
    std::vector<double> knots{0};
    for (const auto& [weight, curve] : terms) {
        for (const auto& piece : curve->pieces()) {
            if (piece.begin > 0 && piece.begin < length) knots.push_back(piece.begin);
        }
    }
    std::sort(knots.begin(), knots.end());
    std::vector<cageform::CubicPiece<double>> pieces;
    for (const double knot : knots) {
        if (!pieces.empty() && knot - pieces.back().begin < 1e-9 * length)
            continue; // the same but for rounding
        cageform::CubicPiece<double> all{knot, value, 0, 0, 0};
        for (const auto& [weight, curve] : terms) {
            const auto& p = curve->pieces()[curve->locate(knot + 1e-9 * length)];
            all.c0 += weight * p(knot);
            all.c1 += weight * p.derivative(knot);
            all.c2 += weight * (p.c2 + 3 * p.c3 * (knot - p.begin));
            all.c3 += weight * p.c3;
        }
        pieces.push_back(all);
    }
    return {std::move(pieces), length};
}

} // namespace detail

/// The motion of a cage with these vertices. It begins again at its end.
inline SvgResult<cageform::CageClip<double, 2>> make_clip(const ClipFile& file,
                                                          std::span<const Point2> vertices) {
    std::vector<std::array<cageform::PiecewiseCubic<double>, 3>> moves;
    for (const ClipControl& control : file.controls) {
        auto& move = moves.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto compiled =
                cageform::compile_track<double>(detail::keys_of(control, axis, file.length));
            if (compiled.status != cageform::Status::ok)
                return SvgError{file.name + ": " + control.name + ": " +
                                cageform::to_string(compiled.status)};
            move[axis] = compiled.track.curve;
        }
    }
    std::vector<cageform::PiecewiseCubic<double>> curves;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        std::array<std::vector<detail::WeightedCurve>, 2> terms;
        for (std::size_t c = 0; c < file.controls.size(); ++c) {
            const ClipControl& control = file.controls[c];
            for (const auto& [vertex, weight] : control.shares) {
                if (vertex != i) continue;
                // Small turns: along the tangent, which keeps the sum cubic.
                const double across = vertices[i].x - control.pivot.x, down = vertices[i].y - control.pivot.y;
                terms[0].push_back({weight, &moves[c][0]});
                terms[0].push_back({-weight * down, &moves[c][2]});
                terms[1].push_back({weight, &moves[c][1]});
                terms[1].push_back({weight * across, &moves[c][2]});
            }
        }
        curves.push_back(detail::sum(vertices[i].x, terms[0], file.length));
        curves.push_back(detail::sum(vertices[i].y, terms[1], file.length));
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    return cageform::CageClip<double, 2>(curves, cycle, cycle);
}

/// How a pose is come to and left.
enum class PoseWay { smooth, linear, ease };

struct PoseKey {
    double time = 0;
    PoseWay way = PoseWay::smooth;
    std::vector<cageform::Vec<double, 3>> places; // of all vertices
};

/// A motion in space. The first key is at 0, times ascend and are less than the length, at which the first
/// pose comes again.
struct PoseClip {
    std::string name; // for messages
    double length = 0;
    std::vector<PoseKey> keys;
};

/// A clip in space from a file.
///
///   fails   where a line is no number, time or way, a pose has not `vertex_count` lines, or times do not ascend
///           from 0 to less than the length, in single precision
inline SvgResult<PoseClip> load_pose_clip(const std::string& path, std::size_t vertex_count) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path)) return SvgError{path + ": cannot be read"};
    PoseClip clip;
    clip.name = path;
    std::size_t number = 0;
    const auto count_fault = [&]() -> std::string {
        if (clip.keys.empty() || clip.keys.back().places.size() == vertex_count) return {};
        return "the pose before has " + std::to_string(clip.keys.back().places.size()) +
               " vertices, the cage " + std::to_string(vertex_count);
    };
    const auto finite_number = [](std::string_view field, double& x) {
        const std::string why = detail::parse_number(detail::trim(field), x);
        return !why.empty() ? why : std::isfinite(x) ? "" : "a number is not finite";
    };
    for (std::string line; std::getline(file, line);) {
        ++number;
        std::string_view text = detail::trim(line);
        if (text.empty() || text.front() == '#') continue;
        std::string why;
        if (text.starts_with("length,")) {
            why = finite_number(text.substr(7), clip.length);
            if (why.empty() && !(clip.length > 0)) why = "the length is not positive";
        } else if (text.starts_with("pose,")) {
            why = count_fault();
            text.remove_prefix(5);
            PoseKey key;
            const std::size_t comma = std::min(text.find(','), text.size());
            if (why.empty()) why = finite_number(text.substr(0, comma), key.time);
            const std::string_view way = detail::trim(text.substr(std::min(comma + 1, text.size())));
            if (way == "linear")
                key.way = PoseWay::linear;
            else if (way == "ease")
                key.way = PoseWay::ease;
            else if (way != "smooth" && !way.empty() && why.empty())
                why = "a pose is smooth, linear or ease, not \"" + std::string(way) + '"';
            if (why.empty() && clip.keys.empty() && key.time != 0) why = "the first pose is at 0";
            if (why.empty() && !clip.keys.empty() && !(float(key.time) > float(clip.keys.back().time)))
                why = "a pose is not later than the one before it";
            clip.keys.push_back(std::move(key));
        } else if (clip.keys.empty()) {
            why = "\"pose,TIME\" is missing before";
        } else {
            std::array<double, 3> p{};
            why = detail::parse_point(text, p);
            const auto& [x, y, z] = p;
            if (why.empty() && !std::isfinite(x + y + z)) why = "a number is not finite";
            if (why.empty() && clip.keys.back().places.size() == vertex_count)
                why = "more vertices than the cage has, " + std::to_string(vertex_count);
            clip.keys.back().places.push_back({x, y, z});
        }
        if (!why.empty()) return SvgError{path + ":" + std::to_string(number) + ": " + why};
    }
    if (clip.length == 0) return SvgError{path + ": no \"length,SECONDS\""};
    if (clip.keys.size() < 2) return SvgError{path + ": fewer than two poses"};
    const std::string why = count_fault();
    if (!why.empty()) return SvgError{path + ":" + std::to_string(number) + ": " + why};
    if (!(float(clip.keys.back().time) < float(clip.length)))
        return SvgError{path + ": the last pose is not before the end, where the first comes again"};
    return clip;
}

/// The text of a clip in space, numbers to a millionth.
inline std::string pose_clip_text(const PoseClip& clip, const std::string& heading) {
    std::array<char, 128> line;
    std::string text = "# " + heading + '\n';
    const auto append = [&](const char* format, auto... values) {
        const int size = std::snprintf(line.data(), line.size(), format, values...);
        text.append(line.data(), std::size_t(size));
    };
    append("length,%.9g\n", clip.length);
    for (const PoseKey& key : clip.keys) {
        append("pose,%.9g,%s\n", key.time,
               key.way == PoseWay::smooth   ? "smooth"
               : key.way == PoseWay::linear ? "linear"
                                            : "ease");
        for (const auto& p : key.places) append("%.6f,%.6f,%.6f\n", p[0], p[1], p[2]);
    }
    return text;
}

/// The curve of one number through the clip's keys, `values` (#keys), from 0 to its length: a piece from every key to
/// the next. Linear in the values, so that whatever is linear in the poses goes the same way.
inline cageform::PiecewiseCubic<double> curve_through(const PoseClip& clip, std::span<const double> values) {
    const std::size_t count = clip.keys.size();
    const auto step = [&](std::size_t k) { // from key k to the next
        return (k + 1 < count ? clip.keys[k + 1].time : clip.length) - clip.keys[k].time;
    };
    const auto chord = [&](std::size_t k) { return (values[(k + 1) % count] - values[k]) / step(k); };
    const auto slope = [&](std::size_t k) {
        if (clip.keys[k].way == PoseWay::ease) return 0.0;
        const std::size_t last = (k + count - 1) % count;
        const double before = step(last), after = step(k);
        return (after * chord(last) + before * chord(k)) / (before + after);
    };
    std::vector<cageform::CubicPiece<double>> pieces;
    for (std::size_t k = 0; k < count; ++k) {
        const bool straight = clip.keys[k].way == PoseWay::linear;
        const double h = step(k), all = chord(k);
        const double a = straight ? all : slope(k), b = straight ? all : slope((k + 1) % count);
        pieces.push_back(
            {clip.keys[k].time, values[k], a, (3 * all - 2 * a - b) / h, (a + b - 2 * all) / (h * h)});
    }
    return {std::move(pieces), clip.length, values[0]};
}

/// The motion of the vertices. It begins again at its end.
template <cageform::Scalar T>
cageform::CageClip<T, 3> make_clip(const PoseClip& clip) {
    std::vector<cageform::PiecewiseCubic<T>> curves;
    std::vector<double> values(clip.keys.size());
    for (std::size_t i = 0; i < clip.keys.front().places.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t k = 0; k < values.size(); ++k) values[k] = clip.keys[k].places[i][axis];
            std::vector<cageform::CubicPiece<T>> pieces;
            const auto curve = curve_through(clip, values);
            for (const auto& [begin, c0, c1, c2, c3] : curve.pieces())
                pieces.push_back({T(begin), T(c0), T(c1), T(c2), T(c3)});
            curves.emplace_back(std::move(pieces), T(clip.length), T(curve.end_value()));
        }
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    return cageform::CageClip<T, 3>(curves, cycle, cycle);
}

} // namespace cageform_examples
