#include "files/lattice_file.hpp"

#include "files/bind_report.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <numbers>

namespace cageform_support {

namespace {

constexpr double most_points = double(cageform::LatticeCoordinates<double, 2>::most_handles);

/// Takes the text before the first of some characters off a word.
std::string_view take_until(std::string_view& word, std::string_view marks) {
    const std::string_view part = word.substr(0, word.find_first_of(marks));
    word.remove_prefix(part.size());
    return part;
}

/// Parses the number after a character, if the word continues with it. Returns the error; empty on success.
std::string read_number_behind(char mark, std::string_view& word, std::string_view marks, double& number) {
    if (!word.starts_with(mark)) return {};
    word.remove_prefix(1);
    const std::string_view digits = take_until(word, marks);
    const std::string why = detail::parse_number(digits, number);
    return !why.empty() || std::isfinite(number) ? why : "not a number: " + detail::quoted(digits);
}

/// Returns the lattice, or the library's error.
template <std::size_t D>
Expected<LatticeBox<D>> accepted(LatticeBox<D> lattice, const std::string& name) {
    const auto coordinates = lattice.template coordinates<double>();
    const auto& report = coordinates.cage_report();
    if (report.status != cageform::Status::ok) return FileError{describe_faults(name, report)};
    return lattice;
}

using Json = nlohmann::ordered_json;

/// Reads an array of D numbers.
template <std::size_t D>
bool read_vector(const Json& json, cageform::Vec<double, D>& v) {
    if (!json.is_array() || json.size() != D) return false;
    for (std::size_t k = 0; k < D; ++k) {
        if (!json[k].is_number()) return false;
        v[k] = json[k].get<double>();
    }
    return true;
}

bool read_axis(const Json& json, cageform::LatticeAxis& axis) {
    if (!json.is_object()) return false;
    for (const char* name : {"points", "degree"}) {
        const auto count = json.find(name);
        if (count == json.end() || !count->is_number_unsigned() || count->get<double>() > most_points)
            return false;
        (*name == 'p' ? axis.points : axis.degree) = count->get<std::size_t>();
    }
    const auto knots = json.find("knots");
    if (knots == json.end()) return true;
    if (!knots->is_array()) return false;
    for (const auto& knot : *knots) {
        if (!knot.is_number()) return false;
        axis.knots.push_back(knot.get<double>());
    }
    return true;
}

Expected<Json> parse_json(std::string_view text, const std::string& name) {
    Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) return FileError{name + ": is no JSON"};
    const auto axes = json.find("axes");
    if (!json.is_object() || json.value("format", Json()) != "lattice/1" || axes == json.end() ||
        !axes->is_array() || (axes->size() != 2 && axes->size() != 3))
        return FileError{name +
                         R"(: is no lattice: "format": "lattice/1" and two or three "axes" are expected)"};
    return json;
}

} // namespace

Expected<LatticeWord> parse_lattice_word(std::string_view word) {
    const auto refuse = [word](const std::string& why) {
        return FileError{"lattice:" + std::string(word.substr(0, 60)) + ": " + why};
    };
    LatticeWord read;
    std::string_view left = word;
    double product = 1;
    do {
        if (!read.points.empty()) left.remove_prefix(1); // the x
        const std::string_view digits = take_until(left, "x/+@");
        double count = 0;
        if (!detail::parse_number(digits, count).empty() || count != std::floor(count) || count < 0)
            return refuse("write the numbers of points along the axes, such as 4x4 or 4x4x4");
        if (count < 2) return refuse("an axis has 2 points or more");
        product *= count;
        if (!(product <= most_points)) return refuse("a lattice has at most 16,777,216 points");
        read.points.push_back(std::size_t(count));
    } while (left.starts_with('x'));
    if (read.points.size() != 2 && read.points.size() != 3)
        return refuse("a lattice has two axes, for a drawing, or three, for a mesh");
    if (left.starts_with("/bernstein")) {
        left.remove_prefix(10);
        read.is_bernstein = true;
        for (const std::size_t count : read.points) {
            if (count > 64) return refuse("Bernstein polynomials take at most 64 points along an axis");
        }
    } else if (left.starts_with('/')) {
        double wanted = 0;
        const std::string why = read_number_behind('/', left, "/+@", wanted);
        if (!why.empty() || (wanted != 1 && wanted != 2 && wanted != 3))
            return refuse("the degree is 1, 2 or 3; for the highest, use /bernstein");
        read.degree = std::size_t(wanted);
    }
    std::string why = read_number_behind('+', left, "@", read.falloff);
    if (why.empty() && !(read.falloff >= 0)) why = "+R is a number of at least 0";
    const bool is_turned = left.starts_with('@');
    if (why.empty()) why = read_number_behind('@', left, "@", read.angle);
    if (why.empty() && is_turned && read.points.size() == 3) why = "@ANGLE is only for the box of a drawing";
    if (why.empty() && !left.empty()) why = "unexpected text: " + detail::quoted(left);
    if (!why.empty()) return refuse(why);
    return read;
}

bool is_lattice_path(std::string_view path) {
    return path.ends_with(".lattice.json");
}

Expected<std::size_t> lattice_dimension(const std::string& path) {
    const auto text = read_text(path);
    if (!text) return text.error();
    const auto json = parse_json(*text, path);
    if (!json) return json.error();
    return (*json)["axes"].size();
}

template <std::size_t D>
Expected<LatticeBox<D>> parse_lattice(std::string_view text, const std::string& name) {
    const auto read = parse_json(text, name);
    if (!read) return read.error();
    const Json& json = *read;
    if (json["axes"].size() != D)
        return FileError{name + (D == 2 ? ": this lattice has three axes, but a drawing needs two"
                                        : ": this lattice has two axes, but a mesh needs three")};
    LatticeBox<D> lattice;
    for (std::size_t k = 0; k < D; ++k) {
        if (!read_axis(json["axes"][k], lattice.axes[k]))
            return FileError{name + ": axis " + std::to_string(k) +
                             R"( is no object of "points", "degree" and optional "knots")"};
    }
    const auto columns = json.find("frame_columns"), origin = json.find("origin");
    bool is_sound = columns != json.end() && columns->is_array() && columns->size() == D &&
                    origin != json.end() && read_vector<D>(*origin, lattice.frame.translation);
    for (std::size_t k = 0; k < D && is_sound; ++k)
        is_sound = read_vector<D>((*columns)[k], lattice.frame.columns[k]);
    if (!is_sound)
        return FileError{name + R"(: "frame_columns" and "origin" are not vectors with a number per axis)"};
    const auto falloff = json.find("falloff");
    if (falloff != json.end() && !falloff->is_number())
        return FileError{name + R"(: "falloff" is no number)"};
    if (falloff != json.end()) lattice.falloff = falloff->template get<double>();
    return accepted(std::move(lattice), name);
}

template <std::size_t D>
Expected<LatticeBox<D>> load_lattice(const std::string& path) {
    const auto text = read_text(path);
    if (!text) return text.error();
    return parse_lattice<D>(*text, path);
}

template <std::size_t D>
std::string to_json(const LatticeBox<D>& lattice) {
    Json json = {{"format", "lattice/1"}};
    for (const auto& axis : lattice.axes) {
        Json of_axis = {{"points", axis.points}, {"degree", axis.degree}};
        if (!axis.knots.empty()) of_axis["knots"] = axis.knots;
        json["axes"].push_back(of_axis);
    }
    for (const auto& column : lattice.frame.columns) json["frame_columns"].push_back(column.v);
    json["origin"] = lattice.frame.translation.v;
    json["falloff"] = lattice.falloff;
    return json.dump(2) + '\n';
}

template <std::size_t D>
Expected<LatticeBox<D>> lattice_about(const LatticeWord& word,
                                      const std::vector<cageform::Vec<double, D>>& points, double margin,
                                      const std::string& figure) {
    if (word.points.size() != D)
        return FileError{figure + (D == 2 ? ": a lattice about a drawing has two axes: lattice:4x4"
                                          : ": a lattice about a mesh has three axes: lattice:4x4x4")};
    LatticeBox<D> lattice;
    for (std::size_t k = 0; k < D; ++k) {
        const std::size_t most = word.points[k] - 1;
        lattice.axes[k] = {word.points[k], word.is_bernstein ? most : std::min(word.degree, most), {}};
    }
    // The box is axis-aligned after rotating the figure back.
    const double angle = word.angle * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    const auto turned = [&](const cageform::Vec<double, D>& p, double sine) {
        auto q = p;
        q[0] = c * p[0] - sine * p[1];
        q[1] = sine * p[0] + c * p[1];
        return q;
    };
    auto places = points;
    if (word.angle != 0) {
        for (auto& p : places) p = turned(p, -s);
    }
    const auto box = cageform::box_around(places, margin);
    if (!box) return FileError{figure + ": no lattice about it: " + cageform::to_string(box.status())};
    lattice.frame = box.value;
    double square = 0;
    for (const auto& column : lattice.frame.columns) square += dot(column, column);
    lattice.falloff = word.falloff * std::sqrt(square);
    if (word.angle != 0) {
        for (auto& column : lattice.frame.columns) column = turned(column, s);
        lattice.frame.translation = turned(lattice.frame.translation, s);
    }
    return accepted(std::move(lattice), "the lattice about " + figure);
}

template <std::size_t D>
std::string describe(const LatticeBox<D>& lattice) {
    std::string text, degrees;
    for (const auto& axis : lattice.axes) {
        text += (text.empty() ? "" : " x ") + std::to_string(axis.points);
        degrees += (degrees.empty() ? "" : ", ") + std::to_string(axis.degree);
    }
    text += " control points of degree " + degrees;
    if (lattice.falloff > 0)
        text += "; outside, displacements fade within " + detail::short_number(lattice.falloff);
    return text;
}

template Expected<LatticeBox<2>> parse_lattice(std::string_view, const std::string&);
template Expected<LatticeBox<3>> parse_lattice(std::string_view, const std::string&);
template Expected<LatticeBox<2>> load_lattice(const std::string&);
template Expected<LatticeBox<3>> load_lattice(const std::string&);
template std::string to_json(const LatticeBox<2>&);
template std::string to_json(const LatticeBox<3>&);
template Expected<LatticeBox<2>>
lattice_about(const LatticeWord&, const std::vector<cageform::Vec<double, 2>>&, double, const std::string&);
template Expected<LatticeBox<3>>
lattice_about(const LatticeWord&, const std::vector<cageform::Vec<double, 3>>&, double, const std::string&);
template std::string describe(const LatticeBox<2>&);
template std::string describe(const LatticeBox<3>&);

} // namespace cageform_support
