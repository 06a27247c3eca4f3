#include "svg/shapes.hpp"

#include "svg/xml.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support::detail {

const std::map<std::string, std::vector<const char*>>& shape_attributes() {
    static const std::map<std::string, std::vector<const char*>> table = {
        {"path", {"d"}},
        {"rect", {"x", "y", "width", "height", "rx", "ry"}},
        {"circle", {"cx", "cy", "r"}},
        {"ellipse", {"cx", "cy", "rx", "ry"}},
        {"line", {"x1", "y1", "x2", "y2"}},
        {"polyline", {"points"}},
        {"polygon", {"points"}}};
    return table;
}

bool is_shape(const std::string& kind) {
    return shape_attributes().count(kind) != 0;
}

bool is_group(const std::string& kind) {
    return kind == "g" || kind == "a" || kind == "switch" || kind == "svg";
}

bool is_fixed(const std::string& kind) {
    return kind == "text" || kind == "image" || kind == "foreignObject";
}

void Box::add(const Point2& p) {
    x0 = std::min(x0, p.x);
    y0 = std::min(y0, p.y);
    x1 = std::max(x1, p.x);
    y1 = std::max(y1, p.y);
}

void Box::add(const Box& other) {
    if (other.empty()) return;
    add(Point2{other.x0, other.y0});
    add(Point2{other.x1, other.y1});
}

Box Box::within(const Box& other) const {
    return {std::max(x0, other.x0), std::max(y0, other.y0), std::min(x1, other.x1), std::min(y1, other.y1)};
}

Box Box::mapped(const Affine2& map) const {
    Box box;
    for (const Point2& p : corners()) box.add(apply(map, p));
    return box;
}

Box box_of(const ViewBox& view) {
    return {view.x, view.y, view.x + view.width, view.y + view.height};
}

void set_box(pugi::xml_node node, const Box& box, int digits) {
    set_attribute(node, "x", format_number(box.x0, digits));
    set_attribute(node, "y", format_number(box.y0, digits));
    set_attribute(node, "width", format_number(box.width(), digits));
    set_attribute(node, "height", format_number(box.height(), digits));
}

void set_view_box(pugi::xml_node node, const Box& box, int digits) {
    std::string text;
    for (const double number : {box.x0, box.y0, box.width(), box.height()})
        text += (text.empty() ? "" : " ") + format_number(number, digits);
    set_attribute(node, "viewBox", text);
}

bool Box::contains(const Box& other) const {
    return other.empty() || (x0 <= other.x0 && y0 <= other.y0 && x1 >= other.x1 && y1 >= other.y1);
}

/// Extends a range by a cubic's values along one axis: its ends and extrema.
void add_extremes(double a, double b, double c, double d, double& least, double& most) {
    least = std::min({least, a, d});
    most = std::max({most, a, d});
    if (std::min(b, c) >= least && std::max(b, c) <= most) return;
    const double p = d - a + 3 * (b - c); // the derivative is 3 (p t² + 2 q t + r)
    const double q = a - 2 * b + c;
    const double r = b - a;
    const double root = std::sqrt(std::max(0.0, q * q - p * r));
    const double e = q > 0 ? -q - root : -q + root; // zeros e / p and r / e, without cancellation
    for (const double t : {e / p, r / e}) {
        if (!(t > 0 && t < 1)) continue;
        const double u = 1 - t;
        const double value = u * u * u * a + 3 * u * u * t * b + 3 * u * t * t * c + t * t * t * d;
        least = std::min(least, value);
        most = std::max(most, value);
    }
}

Box bounds(const Path& path, const Affine2& map) {
    Box box;
    for (const Subpath& subpath : path) {
        Point2 from = apply(map, subpath.start);
        if (!subpath.segments.empty()) box.add(from);
        for (const Segment& s : subpath.segments) {
            const Point2 p1 = apply(map, s.p1);
            const Point2 p2 = apply(map, s.p2);
            const Point2 p3 = apply(map, s.p3);
            if (s.is_line()) {
                box.add(p3);
            } else {
                add_extremes(from.x, p1.x, p2.x, p3.x, box.x0, box.x1);
                add_extremes(from.y, p1.y, p2.y, p3.y, box.y0, box.y1);
            }
            from = p3;
        }
    }
    return box;
}

double largest_scale(const Affine2& m) {
    // from the sum of squares of the entries and the determinant
    const double square = m.a * m.a + m.b * m.b + m.c * m.c + m.d * m.d;
    const double determinant = m.a * m.d - m.b * m.c;
    const double spread = std::sqrt(std::max(0.0, square * square - 4 * determinant * determinant));
    return std::sqrt((square + spread) / 2);
}

std::string write_transform(const Affine2& map, int digits) {
    const auto decimals = [&](double largest) {
        const double size = std::log10(std::max(largest, 1e-300));
        return std::clamp(digits - 1 - static_cast<int>(std::floor(size)), 0, 17);
    };
    const double linear = std::max({std::abs(map.a), std::abs(map.b), std::abs(map.c), std::abs(map.d)});
    std::string text = "matrix(";
    for (const double v : {map.a, map.b, map.c, map.d}) text += format_number(v, decimals(linear)) + ' ';
    const int of_shift = decimals(std::max(std::abs(map.e), std::abs(map.f)));
    return text + format_number(map.e, of_shift) + ' ' + format_number(map.f, of_shift) + ')';
}

Expected<double> length_of(const SvgDocument& document, pugi::xml_node node, const char* name,
                           const Viewport& viewport, double whole, double otherwise) {
    const std::string text = attribute_text(node, name);
    if (is_blank(text) || trimmed(text) == "auto") return otherwise;
    auto value = parse_length(text, whole, viewport.em, viewport.root_em);
    return value ? value : error_in(document, node, name, value.error());
}

void add_ellipse(PathBuilder& builder, const Point2& centre, double rx, double ry) {
    builder.move_to({centre.x + rx, centre.y});
    builder.arc_to({rx, ry}, {centre.x, centre.y + ry});
    builder.arc_to({rx, ry}, {centre.x - rx, centre.y});
    builder.arc_to({rx, ry}, {centre.x, centre.y - ry});
    builder.arc_to({rx, ry}, {centre.x + rx, centre.y});
    builder.close();
}

/// Converts an element to a path.
class ShapeReader {
public:
    ShapeReader(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport,
                std::vector<FileError>& faults, double most_turn)
        : document_(document)
        , node_(node)
        , viewport_(viewport)
        , faults_(faults)
        , most_turn_(most_turn) {}

    Path read() {
        const std::string kind = local_name(node_);
        if (kind == "path") {
            const std::string data = attribute_text(node_, "d");
            auto read = read_path_data(trimmed(data) == "none" ? std::string_view() : data, most_turn_);
            if (read.fault) faults_.push_back(error_in(document_, node_, "d", *read.fault));
            return std::move(read.path);
        }
        if (kind == "polygon" || kind == "polyline") return points_path(kind == "polygon");
        return kind == "line" ? line() : kind == "rect" ? rect() : ellipse(kind == "circle");
    }

private:
    double length(const char* name, double whole, double otherwise) {
        const auto value = length_of(document_, node_, name, viewport_, whole, otherwise);
        if (value) return *value;
        faults_.push_back(value.error());
        return otherwise;
    }
    double across(const char* name, double otherwise) { return length(name, viewport_.width, otherwise); }
    double down(const char* name, double otherwise) { return length(name, viewport_.height, otherwise); }

    Path points_path(bool closed) {
        const auto numbers = parse_numbers(attribute_text(node_, "points"));
        if (!numbers) { // browsers draw nothing then
            faults_.push_back(error_in(document_, node_, "points", numbers.error()));
            return {};
        }
        if (numbers->size() % 2 != 0)
            faults_.push_back(error_at(document_, node_, "points: the number of coordinates is odd"));
        PathBuilder builder;
        for (std::size_t i = 0; i + 1 < numbers->size(); i += 2) {
            const Point2 p{(*numbers)[i], (*numbers)[i + 1]};
            i == 0 ? builder.move_to(p) : builder.line_to(p);
        }
        if (closed) builder.close();
        return builder.take();
    }

    Path line() {
        PathBuilder builder;
        builder.move_to({across("x1", 0), down("y1", 0)});
        builder.line_to({across("x2", 0), down("y2", 0)});
        return builder.take();
    }

    Path rect() {
        const double x = across("x", 0);
        const double y = down("y", 0);
        const double width = across("width", 0);
        const double height = down("height", 0);
        if (!(width > 0 && height > 0)) return {};
        double rx = across("rx", -1); // negative: same as the other radius
        double ry = down("ry", -1);
        if (rx < 0) rx = std::max(ry, 0.0);
        if (ry < 0) ry = rx;
        rx = std::min(rx, width / 2);
        ry = std::min(ry, height / 2);
        const bool round = rx > 0 && ry > 0;
        if (!round) rx = ry = 0;
        PathBuilder builder(most_turn_);
        const auto line = [&](const Point2& p) {
            if (!(p == builder.current())) builder.line_to(p);
        };
        const auto corner = [&](const Point2& p) {
            if (round) builder.arc_to({rx, ry}, p);
        };
        builder.move_to({x + rx, y});
        line({x + width - rx, y});
        corner({x + width, y + ry});
        line({x + width, y + height - ry});
        corner({x + width - rx, y + height});
        line({x + rx, y + height});
        corner({x, y + height - ry});
        line({x, y + ry});
        corner({x + rx, y});
        builder.close();
        return builder.take();
    }

    Path ellipse(bool circle) {
        const Point2 centre{across("cx", 0), down("cy", 0)};
        double rx = circle ? length("r", viewport_.diagonal(), 0) : across("rx", -1);
        double ry = circle ? rx : down("ry", -1);
        if (rx < 0) rx = ry;
        if (ry < 0) ry = rx;
        if (!(rx > 0 && ry > 0)) return {};
        PathBuilder builder(most_turn_);
        add_ellipse(builder, centre, rx, ry);
        return builder.take();
    }

    const SvgDocument& document_;
    pugi::xml_node node_;
    Viewport viewport_;
    std::vector<FileError>& faults_;
    double most_turn_;
};

Path shape_path(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport,
                std::vector<FileError>& faults, double most_turn) {
    return ShapeReader(document, node, viewport, faults, most_turn).read();
}

void write_shape(pugi::xml_node node, const std::string& data) {
    const std::string kind = local_name(node);
    if (kind == "path") {
        set_attribute(node, "d", data);
    } else {
        const std::vector<const char*>& geometry = shape_attributes().at(kind);
        node.remove_attribute("d"); // has no meaning on this element
        pugi::xml_attribute d;
        for (const pugi::xml_attribute attribute : node.attributes()) {
            const bool replaced = std::find(geometry.begin(), geometry.end(),
                                            std::string_view(attribute.name())) != geometry.end();
            if (replaced && !d) d = node.insert_attribute_before("d", attribute);
        }
        if (!d) d = node.append_attribute("d");
        d.set_value(data.c_str());
        for (const char* name : geometry) node.remove_attribute(name);
        node.set_name((name_prefix(node) + "path").c_str());
    }
    // editors would restore the original shape from these
    for (const char* name :
         {"sodipodi:type", "sodipodi:nodetypes", "inkscape:path-effect", "inkscape:original-d"}) {
        node.remove_attribute(name);
    }
}

} // namespace cageform_support::detail
