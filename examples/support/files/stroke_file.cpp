#include "files/stroke_file.hpp"

#include "svg/xml.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace cageform_support {

namespace detail {

void flatten(const Subpath& subpath, double tolerance, DrawnLine& line) {
    line.closed =
        subpath.closed || (!subpath.segments.empty() && subpath.segments.back().p3 == subpath.start);
    line.vertices = subpath.segments.size() + (line.closed ? 0 : 1);
    std::vector<double> lengths{0};
    const auto add = [&](const Point2& p, double along) {
        if (!line.points.empty())
            lengths.push_back(lengths.back() +
                              std::hypot(p.x - line.points.back()[0], p.y - line.points.back()[1]));
        line.points.push_back({p.x, p.y});
        line.along.push_back(along);
    };
    add(subpath.start, 0);
    Point2 from = subpath.start;
    for (std::size_t k = 0; k < subpath.segments.size(); ++k) {
        const Segment& s = subpath.segments[k];
        const std::size_t pieces = pieces_of(from, s, tolerance);
        for (std::size_t n = 1; n < pieces; ++n) {
            const double t = double(n) / double(pieces);
            add(place_on(from, s, t), double(k) + t);
        }
        add(s.p3, double(k + 1));
        from = s.p3;
    }
    for (const double length : lengths) line.part.push_back(lengths.back() > 0 ? length / lengths.back() : 0);
}

std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words(1);
    int depth = 0;
    for (const char c : text) {
        if (c == '(') ++depth;
        if (c == ')') --depth;
        if (depth == 0 && is_space(c)) {
            if (!words.back().empty()) words.emplace_back();
        } else {
            words.back() += c;
        }
    }
    if (words.back().empty()) words.pop_back();
    return words;
}

} // namespace detail

Expected<StrokeFile> load_strokes(const std::string& path, const std::vector<const char*>& attributes) {
    auto loaded = load_svg(path);
    if (!loaded) return loaded.error();
    const auto document = std::make_shared<SvgDocument>(std::move(*loaded));
    StrokeFile file{document->name, {}, {}};
    const auto canvas = view_box(*document);
    file.canvas = canvas;
    std::vector<std::string> warnings;
    const auto drawn = detail::drawn_shapes(*document, warnings);
    if (!drawn) return drawn.error();
    const double tolerance = 1e-4 * std::hypot(canvas.width, canvas.height);
    for (const auto& shape : *drawn) {
        const auto attribute = [document, node = shape.node](const char* name) {
            return detail::unescaped(detail::attribute_text(node, name));
        };
        const bool named = std::any_of(attributes.begin(), attributes.end(),
                                       [&](const char* name) { return !attribute(name).empty(); });
        if (shape.level > 0 || shape.is_box || (!named && shape.stroke == "none")) continue;
        for (const Subpath& subpath : shape.path) {
            if (subpath.segments.empty()) continue;
            DrawnLine line;
            line.label = detail::label(*document, shape.node);
            line.attribute = attribute;
            line.stroke = shape.stroke;
            detail::flatten(subpath, tolerance, line);
            for (auto& p : line.points) {
                const std::array<double, 2> low{canvas.x, canvas.y}, size{canvas.width, canvas.height};
                for (std::size_t k = 0; k < 2; ++k) {
                    const double rounding = 1e-9 * (std::fabs(low[k]) + size[k]);
                    if (!(p[k] >= low[k] - rounding && p[k] <= low[k] + size[k] + rounding))
                        return FileError{document->name + ": " + line.label +
                                         " extends beyond the picture (its viewBox)"};
                    p[k] = std::clamp(p[k], low[k], low[k] + size[k]);
                }
            }
            if (line.part.back() > 0) file.lines.push_back(std::move(line));
        }
    }
    if (file.lines.empty()) return FileError{document->name + ": holds no stroke"};
    return file;
}

Expected<std::vector<double>>
values_along(const DrawnLine& line, const std::string& text, std::size_t count,
             const std::function<Expected<std::vector<double>>(const std::string&)>& read) {
    std::vector<std::vector<double>> given;
    for (const std::string& word : detail::words_of(text)) {
        const auto values = read(word);
        if (!values) return values.error();
        given.push_back(*values);
    }
    const bool of_vertices = given.size() == line.vertices, of_ends = given.size() == 2 && !line.closed;
    if (given.size() != 1 && !of_vertices && !of_ends)
        return FileError{std::to_string(given.size()) + " values for " + std::to_string(line.vertices) +
                         " vertices: give one, " + (line.closed ? "" : "two for the ends, ") +
                         "or one for each"};
    std::vector<double> values;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
        const double at = given.size() == 1 ? 0 : of_vertices ? line.along[i] : line.part[i];
        const std::size_t before = std::min(std::size_t(at), line.vertices - 1);
        const double t = at - double(before);
        const auto &a = given[before % given.size()], &b = given[(before + 1) % given.size()];
        for (std::size_t c = 0; c < count; ++c)
            values.push_back(t > 0 && given.size() > 1 ? (1 - t) * a[c] + t * b[c] : a[c]);
    }
    return values;
}

} // namespace cageform_support
