#include "cli/landmarks.hpp"

#include "cli/pins.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

namespace cageform_support {

namespace {

using Parts = std::span<const std::string_view>;

/// Parses both points of a landmark. Returns the error; empty on success.
std::string parse_points(Parts from, Parts to, const LandmarkVertices& vertices, cageform::Landmark& mark) {
    std::string why = detail::parse_place<3>(from, vertices.source, mark.from);
    if (!why.empty()) return "source: " + why;
    why = detail::parse_place<3>(to, vertices.target, mark.to);
    return why.empty() ? why : "target: " + why;
}

/// Parses the columns of a line. Returns the error; empty on success.
std::string parse_row(Parts fields, const LandmarkVertices& vertices, cageform::Landmark& mark) {
    if (fields.size() < 2 || fields.size() > 7)
        return detail::counted(fields.size(), "column") +
               ", but a landmark has VERTEX,VERTEX or VERTEX,x,y,z or x,y,z,x,y,z, and optionally a weight";
    const bool has_weight = fields.size() % 2 == 1;
    const Parts places = has_weight ? fields.first(fields.size() - 1) : fields;
    const std::size_t of_source = places.size() == 6 ? 3 : 1;
    std::string why = parse_points(places.first(of_source), places.subspan(of_source), vertices, mark);
    if (why.empty() && has_weight) why = detail::parse_finite(fields.back(), mark.weight);
    if (why.empty() && !(mark.weight > 0))
        why = "the weight " + detail::quoted(fields.back()) + " is not positive";
    return why;
}

/// The first column of a point's line; empty if that is the point.
std::string_view name_of(const PointTable& table, std::size_t n) {
    const std::string_view text = table.text;
    const std::size_t number = table.numbers[n].begin[0];
    const std::size_t begin = text.rfind('\n', number) + 1; // in the first line: 0
    const std::size_t end = text.find(',', begin);
    return number < end ? std::string_view() : detail::trim(text.substr(begin, end - begin));
}

} // namespace

std::string parse_landmark(std::string_view word, const LandmarkVertices& vertices, Landmarks& landmarks) {
    const std::string name = "--landmark " + detail::quoted(word);
    const std::size_t colon = word.find(':');
    if (colon == word.npos) return name + ": write SOURCE:TARGET, such as 881:0,4.37,0.3";
    std::string_view target = detail::trim(word.substr(colon + 1));
    if (target.starts_with('=')) target.remove_prefix(1); // as in a pin
    const auto from = detail::parts_of(word.substr(0, colon), ','), to = detail::parts_of(target, ',');
    for (const auto& parts : {from, to}) {
        if (parts.size() != 1 && parts.size() != 3)
            return name + ": a point is x,y,z or the number of a vertex";
    }
    cageform::Landmark mark;
    const std::string why = parse_points(from, to, vertices, mark);
    if (!why.empty()) return name + ": " + why;
    landmarks.marks.push_back(mark);
    landmarks.names.push_back(name);
    return {};
}

std::string parse_landmarks(std::string_view text, const std::string& name, const LandmarkVertices& vertices,
                            Landmarks& landmarks) {
    const std::size_t before = landmarks.marks.size();
    detail::RowFilter rows;
    std::string_view line;
    for (std::size_t number = 1; take_line(text, line); ++number) {
        if (!rows.take(line)) continue;
        cageform::Landmark mark;
        const std::string why = parse_row(detail::cells_of(line), vertices, mark);
        if (!why.empty()) return to_string(detail::row_fault(name, number, line, why));
        landmarks.marks.push_back(mark);
        landmarks.names.push_back(name + ':' + std::to_string(number));
    }
    return landmarks.marks.size() > before ? "" : name + ": holds no landmarks";
}

std::string add_landmarks(const PointTable& source, const PointTable& target, Landmarks& landmarks) {
    if (source.points.size() != target.points.size())
        return target.name + " has " + detail::counted(target.points.size(), "point") + ", " + source.name +
               " has " + std::to_string(source.points.size()) + ": landmarks are pairs";
    for (std::size_t n = 0; n < source.points.size(); ++n) {
        const std::string_view name = name_of(source, n), other = name_of(target, n);
        const std::string place = source.name + ", point " + std::to_string(n + 1);
        if (name != other)
            return place + " is " + detail::quoted(name) + ", and in " + target.name + ' ' +
                   detail::quoted(other);
        landmarks.marks.push_back({source.points[n], target.points[n]});
        landmarks.names.push_back(place);
    }
    return {};
}

} // namespace cageform_support
