#include "cli/pose_operations.hpp"

#include "io/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

namespace cageform_support {

namespace {

using cageform::Vec;

constexpr double degree = 3.14159265358979323846 / 180;

/// An error that quotes a text.
std::string refusal(std::string_view text, const std::string& why) {
    return detail::quoted(text) + " " + why;
}

std::string parse_all(std::span<const std::string_view> parts, std::span<double> numbers) {
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (std::string why = detail::parse_finite(parts[k], numbers[k]); !why.empty()) return why;
    }
    return {};
}

/// The axis of a letter; D if invalid.
template <std::size_t D>
std::size_t axis_of(std::string_view letter) {
    const std::size_t axis = letter.size() == 1 ? std::string_view("xyz").find(letter) : D;
    return std::min(axis, D);
}

/// Applies a condition such as "x>10" to `selected`.
template <std::size_t D>
std::string keep_where(std::string_view condition, std::span<const Vec<double, D>> rest,
                       std::vector<std::size_t>& selected) {
    const std::size_t sign = std::min(condition.find_first_of("<>"), condition.size());
    const std::size_t axis = axis_of<D>(detail::trim(condition.substr(0, sign)));
    if (sign == condition.size() || axis == D) {
        return refusal(condition,
                       std::string("selects nothing: write a number, 5-9, all, or a condition such as x>10") +
                           (D == 2 ? "; the plane has x and y" : ""));
    }
    double bound = 0;
    if (std::string why = detail::parse_finite(detail::trim(condition.substr(sign + 1)), bound); !why.empty())
        return why;
    const double side = condition[sign] == '>' ? 1 : -1;
    std::erase_if(selected, [&](std::size_t i) { return !(side * rest[i][axis] > side * bound); });
    return {};
}

/// Parses an index below `count` of things such as vertices.
std::string parse_number_of(const std::string& thing, std::string_view text, std::size_t count,
                            std::size_t& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (end != text.data() + text.size() || text.empty())
        return refusal(text, "is not a " + thing + " number");
    if (error == std::errc{} && number < count) return {};
    return "there is no " + thing + " " + std::string(text.substr(0, 40)) + ": the " +
           (thing == "control point" ? "loop" : "cage") + " has " + std::to_string(count) + ", 0 to " +
           std::to_string(count - 1);
}

/// The part of a cage that "part -2" names; null if invalid.
const cageform::CagePart* part_named(std::string_view word, const cageform::CageParts* parts) {
    if (parts == nullptr || !word.starts_with("part ")) return nullptr;
    const std::string_view text = detail::trim(word.substr(5));
    int number = 0;
    return detail::parse_whole(text, number) ? parts->find(number) : nullptr;
}

/// Selects "part 3" and the parts attached to it.
std::string select_part(std::string_view word, const cageform::CageParts* parts,
                        std::vector<std::size_t>& selected) {
    if (parts == nullptr || parts->parts.empty())
        return refusal(word,
                       "selects nothing: the cage has no parts; a cage in space that make_cage writes has "
                       "them, as groups of faces part_1, part_2 and so on");
    const cageform::CagePart* const part = part_named(word, parts);
    if (part == nullptr) {
        std::string names;
        for (const auto& one : parts->parts)
            names += (names.empty() ? "part " : ", part ") + std::to_string(one.number);
        return refusal(word, "is no part of the cage, which has " + names);
    }
    const auto moved = parts->moved_with(part->number);
    selected.assign(moved.begin(), moved.end());
    return selected.empty() ? refusal(word, "has no vertices except those of its joint") : "";
}

/// Selects the vertices of one entry of a list.
template <std::size_t D>
std::string select(std::string_view part, std::span<const Vec<double, D>> rest,
                   const cageform::CageParts* parts, std::vector<std::size_t>& selected) {
    if (part.starts_with("part")) return select_part(part, parts, selected);
    selected.resize(rest.size());
    std::iota(selected.begin(), selected.end(), std::size_t{0});
    if (part == "all") return {};
    const bool is_number = !part.empty() && part.front() >= '0' && part.front() <= '9';
    if (!is_number) {
        for (const std::string_view condition : detail::parts_of(part, '&')) {
            if (std::string why = keep_where(condition, rest, selected); !why.empty()) return why;
        }
        return selected.empty() ? refusal(part, "holds for no vertex of the cage") : "";
    }
    const std::size_t dash = part.find('-');
    std::size_t first = 0;
    std::string why = parse_number_of("vertex", detail::trim(part.substr(0, dash)), rest.size(), first);
    std::size_t last = first;
    if (why.empty() && dash != part.npos)
        why = parse_number_of("vertex", detail::trim(part.substr(dash + 1)), rest.size(), last);
    if (!why.empty()) return why;
    if (last < first) return refusal(part, "counts backwards");
    selected.resize(last + 1);
    selected.erase(selected.begin(), selected.begin() + std::ptrdiff_t(first));
    return {};
}

/// A rotation in the plane of two axes, from the first towards the second; exact for multiples of 90 degrees.
struct Rotation {
    double cosine = 1, sine = 0;

    explicit Rotation(double degrees) {
        const double within = std::remainder(degrees, 360), quarters = std::round(within / 90);
        const double rest = (within - 90 * quarters) * degree;
        cosine = std::cos(rest);
        sine = std::sin(rest);
        for (int n = (int(quarters) + 4) % 4; n > 0; --n) {
            const double old = cosine;
            cosine = -sine;
            sine = old;
        }
    }
    template <std::size_t D>
    void apply(Vec<double, D>& v, std::size_t from, std::size_t to) const {
        const double x = v[from], y = v[to];
        v[from] = cosine * x - sine * y;
        v[to] = sine * x + cosine * y;
    }
};

/// An operation with parsed NUMBERS.
template <std::size_t D>
class Operation {
public:
    using Point = Vec<double, D>;

    Operation(PoseOperation kind, const Point& centre)
        : kind_(kind)
        , centre_(centre) {}

    /// Returns the error; empty on success.
    std::string parse(std::string_view numbers) {
        text_ = numbers;
        return parse_parts(detail::parts_of(numbers, ','));
    }

    void apply(Point& p) const {
        switch (kind_) {
        case PoseOperation::move:
        case PoseOperation::curve: p = p + vector_; break;
        case PoseOperation::turn: p = centre_ + turned(p - centre_); break;
        case PoseOperation::scale:
            for (std::size_t k = 0; k < D; ++k) p[k] = centre_[k] + vector_[k] * (p[k] - centre_[k]);
            break;
        case PoseOperation::bend: bend(p); break;
        case PoseOperation::twist: twist(p); break;
        }
    }

private:
    std::string parse_parts(std::span<const std::string_view> parts) {
        constexpr bool in_plane = D == 2;
        switch (kind_) {
        case PoseOperation::move:
        case PoseOperation::curve:
            if (parts.size() != D) return refusal(text_, in_plane ? "is not x,y" : "is not x,y,z");
            return parse_all(parts, vector_.v);
        case PoseOperation::scale:
            if (parts.size() != D && parts.size() != 1)
                return refusal(text_,
                               in_plane ? "is neither a factor nor x,y" : "is neither a factor nor x,y,z");
            if (std::string why = parse_all(parts, vector_.v); !why.empty()) return why;
            for (std::size_t k = parts.size(); k < D; ++k) vector_[k] = vector_[0];
            return {};
        case PoseOperation::turn: return parse_turn<D>(text_, degrees_, vector_);
        case PoseOperation::bend:
            return parse_span(parts, in_plane ? "xy or yx" : "xy, zx or another two axes");
        case PoseOperation::twist:
            if (in_plane) return refusal(text_, "is for cages in space");
            return parse_span(parts, "x, y or z");
        }
        return {};
    }

    /// Parses AXES,FROM,TO,DEGREES.
    std::string parse_span(std::span<const std::string_view> parts, const std::string& axes) {
        if (parts.size() != 4) return refusal(text_, "is not AXES,FROM,TO,DEGREES");
        const std::size_t letters = kind_ == PoseOperation::bend ? 2 : 1;
        along_ = axis_of<D>(parts[0].substr(0, 1));
        towards_ = letters == 2 ? axis_of<D>(parts[0].substr(std::min<std::size_t>(1, parts[0].size())))
                                : (along_ + 1) % D;
        if (parts[0].size() != letters || along_ == D || towards_ == D || along_ == towards_)
            return refusal(text_, "must begin with " + axes);
        std::array<double, 3> numbers{};
        if (std::string why = parse_all(parts.subspan(1), numbers); !why.empty()) return why;
        from_ = numbers[0];
        to_ = numbers[1];
        degrees_ = numbers[2];
        return from_ == to_ ? refusal(text_, "begins and ends at the same position") : "";
    }

    /// Rotates a vector; in space by Rodrigues' formula.
    Point turned(Point v) const {
        const Rotation rotation(degrees_);
        if constexpr (D == 2) {
            rotation.apply(v, 0, 1);
            return v;
        } else {
            return rotation.cosine * v + rotation.sine * cross(vector_, v) +
                   ((1 - rotation.cosine) * dot(vector_, v)) * vector_;
        }
    }

    /// Signed distance of a point from FROM towards TO.
    double beyond(const Point& p) const { return to_ > from_ ? p[along_] - from_ : from_ - p[along_]; }

    /// Bends the axis through the centre to a line, an arc of the same length, and a line.
    void bend(Point& p) const {
        const double length = std::fabs(to_ - from_), way = beyond(p),
                     across = p[towards_] - centre_[towards_];
        if (way <= 0) return;
        const double on_arc = std::min(way, length), degrees = degrees_ * on_arc / length;
        const Rotation whole(degrees), half(degrees / 2);
        const double angle = degrees * degree;
        const double chord = angle == 0 ? on_arc : on_arc * half.sine / (angle / 2);
        const double forward = chord * half.cosine + (way - on_arc) * whole.cosine - across * whole.sine;
        p[along_] = from_ + (to_ > from_ ? forward : -forward);
        p[towards_] =
            centre_[towards_] + chord * half.sine + (way - on_arc) * whole.sine + across * whole.cosine;
    }

    /// Rotates a point about the axis through the centre, by an angle that grows along it.
    void twist(Point& p) const {
        const double share = std::clamp(beyond(p) / std::fabs(to_ - from_), 0.0, 1.0);
        if (share == 0) return;
        const std::size_t from = (along_ + 1) % D, to = (along_ + 2) % D;
        Point v = p - centre_;
        Rotation(share * degrees_).apply(v, from, to);
        for (const std::size_t k : {from, to}) p[k] = centre_[k] + v[k];
    }

    PoseOperation kind_;
    std::string_view text_;
    Point centre_;
    Point vector_{}; // displacement, scale factors, or axis of a turn in space
    double degrees_ = 0, from_ = 0, to_ = 0;
    std::size_t along_ = 0, towards_ = 1;
};

template <std::size_t D, class Index>
Vec<double, D> mean_of(std::span<const Vec<double, D>> pose, const std::vector<Index>& selected) {
    Vec<double, D> mean{};
    for (const Index i : selected) mean = mean + (1.0 / double(selected.size())) * pose[i];
    return mean;
}

/// Parses "3,4", or "v2,7" (the mean of these vertices).
template <std::size_t D>
std::string parse_centre(std::string_view text, std::span<const Vec<double, D>> rest,
                         std::span<const Vec<double, D>> pose, const cageform::CageParts* parts,
                         Vec<double, D>& centre) {
    if (text.starts_with('v')) {
        const auto selected = parse_selection(text.substr(1), rest, parts);
        if (!selected) return to_string(selected.error());
        centre = mean_of(pose, *selected);
        return {};
    }
    const auto numbers = detail::parts_of(text, ',');
    if (numbers.size() == D) return parse_all(numbers, centre.v);
    return refusal(text, std::string("is not a point: write ") + (D == 2 ? "x,y" : "x,y,z") +
                             ", or v and vertices such as v2,7");
}

} // namespace

template <std::size_t D>
Expected<std::vector<std::size_t>> parse_selection(std::string_view word,
                                                   std::span<const Vec<double, D>> rest,
                                                   const cageform::CageParts* parts) {
    std::vector<std::size_t> selected, more;
    for (const std::string_view part : detail::parts_of(word, ',')) {
        if (const std::string why = select(part, rest, parts, more); !why.empty()) return FileError{why};
        selected.insert(selected.end(), more.begin(), more.end());
    }
    std::sort(selected.begin(), selected.end());
    selected.erase(std::unique(selected.begin(), selected.end()), selected.end());
    return selected;
}

template <std::size_t D>
std::string parse_turn(std::string_view text, double& degrees, Vec<double, D>& axis) {
    const auto parts = detail::parts_of(text, ',');
    if (D == 2 ? parts.size() != 1 : parts.size() != 2 && parts.size() != 4)
        return refusal(text,
                       D == 2 ? "is not one angle" : "is not an angle and an axis, such as 30,y or 30,1,1,0");
    if (std::string why = detail::parse_finite(parts[0], degrees); !why.empty()) return why;
    if (D == 2) return {};
    if (parts.size() == 2) {
        const std::size_t k = axis_of<D>(parts[1]);
        if (k == D) return refusal(text, "has no axis x, y or z");
        axis = {};
        axis[k] = 1;
        return {};
    }
    if (std::string why = parse_all(std::span(parts).subspan(1), axis.v); !why.empty()) return why;
    double largest = 0;
    for (const double x : axis.v) largest = std::max(largest, std::fabs(x));
    if (largest == 0) return refusal(text, "has an axis of length zero");
    for (double& x : axis.v) x /= largest; // avoids overflow
    axis = (1 / std::sqrt(dot(axis, axis))) * axis;
    return {};
}

template <std::size_t D>
std::string apply_operation(PoseOperation operation, std::string_view word,
                            std::span<const Vec<double, D>> rest, std::span<Vec<double, D>> pose,
                            std::span<const std::vector<std::size_t>> followers,
                            const cageform::CageParts* parts) {
    const std::size_t colon = word.find(':');
    if (colon == word.npos)
        return refusal(word, "has no colon between the vertices and the numbers, such as 5-9:30");
    const std::string_view which = word.substr(0, colon);
    auto selected = parse_selection(which, rest, parts);
    if (!selected) return to_string(selected.error());
    const std::string_view numbers = word.substr(colon + 1);
    const std::size_t at = std::min(numbers.find('@'), numbers.size());
    const std::span<const Vec<double, D>> before(pose);
    const cageform::CagePart* const part = part_named(detail::trim(which), parts);
    const bool has_joint = part != nullptr && !part->joint.empty();
    auto centre = has_joint ? mean_of(before, part->joint) : mean_of(before, *selected);
    if (at < numbers.size()) {
        if (operation == PoseOperation::move) return refusal(word, "has a point, which a move does not use");
        if (std::string why = parse_centre(detail::trim(numbers.substr(at + 1)), rest, before, parts, centre);
            !why.empty())
            return why;
    }
    Operation<D> what(operation, centre);
    if (std::string why = what.parse(detail::trim(numbers.substr(0, at))); !why.empty()) return why;
    for (std::size_t n = followers.empty() ? 0 : selected->size(); n-- > 0;) {
        const auto& more = followers[(*selected)[n]];
        selected->insert(selected->end(), more.begin(), more.end());
    }
    std::sort(selected->begin(), selected->end());
    selected->erase(std::unique(selected->begin(), selected->end()), selected->end());
    std::vector<Vec<double, D>> moved;
    for (const std::size_t i : *selected) {
        what.apply(moved.emplace_back(pose[i]));
        if (!is_finite(moved.back())) return "vertex " + std::to_string(i) + " exceeds the range of numbers";
    }
    for (std::size_t k = 0; k < moved.size(); ++k) pose[(*selected)[k]] = moved[k];
    return {};
}

std::string move_control_point(std::string_view word, std::span<const std::vector<std::size_t>> loops,
                               std::span<Vec<double, 2>> pose) {
    const auto parts = detail::parts_of(word, ':');
    if (parts.size() != 3)
        return refusal(word, "is not LOOP:K:DX,DY: a loop, one of its control points, and a move");
    std::size_t loop = 0, point = 0;
    if (std::string why = parse_number_of("loop", parts[0], loops.size(), loop); !why.empty()) return why;
    const auto& handles = loops[loop];
    if (std::string why = parse_number_of("control point", parts[1], handles.size(), point); !why.empty())
        return why;
    Operation<2> move(PoseOperation::curve, {});
    if (std::string why = move.parse(parts[2]); !why.empty()) return why;
    auto moved = pose[handles[point]];
    move.apply(moved);
    if (!is_finite(moved)) return "control point " + std::to_string(point) + " exceeds the range of numbers";
    pose[handles[point]] = moved;
    return {};
}

template Expected<std::vector<std::size_t>> parse_selection(std::string_view, std::span<const Vec<double, 2>>,
                                                            const cageform::CageParts*);
template Expected<std::vector<std::size_t>> parse_selection(std::string_view, std::span<const Vec<double, 3>>,
                                                            const cageform::CageParts*);
template std::string parse_turn(std::string_view, double&, Vec<double, 2>&);
template std::string parse_turn(std::string_view, double&, Vec<double, 3>&);
template std::string apply_operation(PoseOperation, std::string_view, std::span<const Vec<double, 2>>,
                                     std::span<Vec<double, 2>>, std::span<const std::vector<std::size_t>>,
                                     const cageform::CageParts*);
template std::string apply_operation(PoseOperation, std::string_view, std::span<const Vec<double, 3>>,
                                     std::span<Vec<double, 3>>, std::span<const std::vector<std::size_t>>,
                                     const cageform::CageParts*);

} // namespace cageform_support
