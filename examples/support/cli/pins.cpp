#include "cli/pins.hpp"

#include "cli/pose_operations.hpp"
#include "io/csv.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <numbers>

namespace cageform_support {

namespace {

using cageform::Vec;
using detail::quoted;

constexpr double radians = std::numbers::pi / 180;

template <std::size_t D>
constexpr const char* a_point = D == 2 ? "x,y" : "x,y,z";

template <std::size_t D>
std::string text_of(const Vec<double, D>& p) {
    std::string text;
    for (const double x : p.v) text += (text.empty() ? "(" : ", ") + detail::short_number(x);
    return text + ')';
}

/// Parses numbers. Returns the error; empty on success.
std::string read_numbers(std::span<const std::string_view> parts, std::span<double> numbers) {
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        if (std::string why = detail::parse_finite(parts[k], numbers[k]); !why.empty()) return why;
    }
    return {};
}

/// Parses the target of a pin: a position, or with signs a displacement.
template <std::size_t D>
std::string read_target(std::string_view text, Pin<D>& pin) {
    Vec<double, D>& target = pin.target;
    const bool is_place = text.starts_with('=');
    const auto parts = detail::parts_of(is_place ? text.substr(1) : text, ',');
    if (parts.size() != D) return quoted(text) + " is not a target: write " + a_point<D>;
    if (std::string why = read_numbers(parts, target.v); !why.empty()) return why;
    const bool has_signs = std::any_of(parts.begin(), parts.end(), [](std::string_view part) {
        return part.front() == '+' || part.front() == '-';
    });
    pin.is_relative = has_signs && !is_place;
    if (pin.is_relative) target = pin.place + target;
    return is_finite(target) ? "" : "the target exceeds the range of numbers";
}

/// Parses the columns of a line. Returns the error; empty on success.
template <std::size_t D>
std::string read_line(std::span<const std::string_view> fields, std::span<const Vec<double, D>> vertices,
                      Pin<D>& pin) {
    constexpr std::size_t turn_size = D == 2 ? 1 : 3;
    const auto is_known = [&](std::size_t place) { // whether the columns match, if a position takes `place`
        const std::size_t more = fields.size() - place;
        return fields.size() > place && (more == D || more == D + turn_size || more == D + turn_size + 1);
    };
    while (!is_known(D) && (D == 2 || !is_known(1)) && fields.size() > 1 && fields.back().empty())
        fields = fields.first(fields.size() - 1); // empty columns of spreadsheets
    const std::size_t place = is_known(D) ? D : 1;
    if (place == 1 && (D == 2 || !is_known(1))) {
        return detail::counted(fields.size(), "column") +
               (D == 2 ? ", but a pin has x,y,TX,TY[,ANGLE[,WEIGHT]]"
                       : ", but a pin has x,y,z,TX,TY,TZ[,RX,RY,RZ[,WEIGHT]], or a vertex for x,y,z");
    }
    std::string why = detail::parse_place<D>(fields.first(place), vertices, pin.place);
    if (why.empty()) why = read_numbers(fields.subspan(place), pin.target.v);
    const auto rest = fields.subspan(place + D);
    const auto of_turn = rest.first(std::min(rest.size(), turn_size));
    if (!std::all_of(of_turn.begin(), of_turn.end(), [](std::string_view f) { return f.empty(); })) {
        auto& turn = pin.turn.emplace();
        if (why.empty()) why = read_numbers(of_turn, turn.v);
        turn = radians * turn;
    }
    if (why.empty() && rest.size() > turn_size && !rest[turn_size].empty()) {
        why = detail::parse_finite(rest[turn_size], pin.weight);
        if (why.empty() && !(pin.weight > 0))
            why = "the weight " + quoted(rest[turn_size]) + " is not positive";
    }
    return why;
}

} // namespace

template <std::size_t D>
std::string detail::parse_place(std::span<const std::string_view> parts,
                                std::span<const Vec<double, D>> vertices, Vec<double, D>& place) {
    if (parts.size() == D) return read_numbers(parts, place.v);
    const std::string_view text = parts[0];
    std::size_t vertex = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), vertex);
    if (end != text.data() + text.size() || text.empty())
        return quoted(text) + " is not the number of a vertex";
    if (error != std::errc{} || vertex >= vertices.size()) {
        return "there is no vertex " + std::string(text.substr(0, 40)) + ": the figure has " +
               std::to_string(vertices.size()) + ", counted from 0";
    }
    place = vertices[vertex];
    return {};
}

template <std::size_t D>
Expected<Pin<D>> parse_pin(std::string_view word, std::span<const Vec<double, D>> vertices) {
    const std::size_t at = std::min(word.find('@'), word.size());
    const std::size_t colon = std::min(word.find(':'), at);
    const auto place = detail::parts_of(word.substr(0, colon), ',');
    Pin<D> pin;
    pin.name = "--pin " + quoted(word);
    std::string why;
    if (place.size() != D && (D == 2 || place.size() != 1))
        why = quoted(word.substr(0, colon)) + " is not a place: write " + a_point<D> +
              (D == 2 ? "" : ", or the number of a vertex");
    if (why.empty()) why = detail::parse_place<D>(place, vertices, pin.place);
    pin.target = pin.place;
    if (why.empty() && colon < at)
        why = read_target(detail::trim(word.substr(colon + 1, at - colon - 1)), pin);
    if (why.empty() && at < word.size()) {
        double degrees = 0;
        Vec<double, D> axis;
        why = parse_turn(detail::trim(word.substr(at + 1)), degrees, axis);
        if constexpr (D == 2)
            pin.turn = {radians * degrees};
        else
            pin.turn = radians * degrees * axis;
    }
    if (!why.empty()) return FileError{pin.name + ": " + why};
    return pin;
}

template <std::size_t D>
Expected<std::vector<Pin<D>>> parse_pins(std::string_view text, const std::string& name,
                                         std::span<const Vec<double, D>> vertices) {
    std::vector<Pin<D>> pins;
    std::size_t number = 0;
    detail::RowFilter rows;
    for (std::string_view line; take_line(text, line);) {
        ++number;
        if (!rows.take(line)) continue;
        Pin<D> pin;
        pin.name = name + ':' + std::to_string(number);
        const std::string why = read_line<D>(detail::cells_of(line, line.size()), vertices, pin);
        if (!why.empty()) return detail::row_fault(name, number, line, why);
        pins.push_back(std::move(pin));
    }
    if (pins.empty()) return FileError{name + ": holds no pins"};
    return pins;
}

template <std::size_t D>
Expected<std::vector<Pin<D>>> load_pins(const std::string& path, std::span<const Vec<double, D>> vertices) {
    const auto text = read_text(path);
    return text ? parse_pins<D>(*text, path, vertices) : text.error();
}

template <std::size_t D>
std::string name_of(const std::vector<Pin<D>>& pins, std::size_t n) {
    return "pin " + std::to_string(n + 1) + " (" + pins[n].name + ") at " + text_of(pins[n].place);
}

template <std::size_t D>
std::string describe_target(const Pin<D>& pin) {
    if (pin.target == pin.place) return "stays";
    return (pin.is_relative ? "moved by " + text_of(pin.target - pin.place) + " to " : "moved to ") +
           text_of(pin.target);
}

template <std::size_t D>
std::string contradiction(const std::vector<Pin<D>>& pins) {
    std::map<std::array<double, D>, std::size_t> first;
    for (std::size_t n = 0; n < pins.size(); ++n) {
        const auto [other, is_new] = first.emplace(std::to_array(pins[n].place.v), n);
        if (is_new || pins[other->second].target == pins[n].target) continue;
        return name_of(pins, n) + " has another target than " + pins[other->second].name +
               " at the same position: the figure moves between both targets";
    }
    return {};
}

template std::string detail::parse_place(std::span<const std::string_view>, std::span<const Vec<double, 2>>,
                                         Vec<double, 2>&);
template std::string detail::parse_place(std::span<const std::string_view>, std::span<const Vec<double, 3>>,
                                         Vec<double, 3>&);
template Expected<Pin<2>> parse_pin(std::string_view, std::span<const Vec<double, 2>>);
template Expected<Pin<3>> parse_pin(std::string_view, std::span<const Vec<double, 3>>);
template Expected<std::vector<Pin<2>>> parse_pins(std::string_view, const std::string&,
                                                  std::span<const Vec<double, 2>>);
template Expected<std::vector<Pin<3>>> parse_pins(std::string_view, const std::string&,
                                                  std::span<const Vec<double, 3>>);
template Expected<std::vector<Pin<2>>> load_pins(const std::string&, std::span<const Vec<double, 2>>);
template Expected<std::vector<Pin<3>>> load_pins(const std::string&, std::span<const Vec<double, 3>>);
template std::string name_of(const std::vector<Pin<2>>&, std::size_t);
template std::string name_of(const std::vector<Pin<3>>&, std::size_t);
template std::string describe_target(const Pin<2>&);
template std::string describe_target(const Pin<3>&);
template std::string contradiction(const std::vector<Pin<2>>&);
template std::string contradiction(const std::vector<Pin<3>>&);

} // namespace cageform_support
