#include "svg_shapes.hpp"

#include "svg_xml.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_examples {

namespace detail {

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

SvgResult<double> length_of(const SvgDocument& document, pugi::xml_node node, const char* name, double whole,
                            double otherwise) {
    const std::string text = attribute_text(node, name);
    if (is_blank(text) || trimmed(text) == "auto") return otherwise;
    const auto value = parse_length(text, whole);
    if (value) return *value;
    return error_in(document, node, name, value.error());
}

/// Reads one element; the first error stays.
class ShapeReader {
public:
    ShapeReader(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport)
        : document_(document)
        , node_(node)
        , viewport_(viewport) {}

    SvgResult<Path> read() {
        const std::string kind = local_name(node_);
        if (kind == "path") {
            const std::string data = attribute_text(node_, "d");
            auto parsed = parse_path_data(trimmed(data) == "none" ? std::string_view() : data);
            if (!parsed) return error_in(document_, node_, "d", parsed.error());
            return parsed;
        }
        if (kind == "polygon" || kind == "polyline") return points_path(kind == "polygon");
        Path path = kind == "line" ? line() : kind == "rect" ? rect() : ellipse(kind == "circle");
        if (error_) return *error_;
        return path;
    }

private:
    double length(const char* name, double whole, double otherwise) {
        const auto value = length_of(document_, node_, name, whole, otherwise);
        if (value) return *value;
        if (!error_) error_ = value.error();
        return otherwise;
    }
    double across(const char* name, double otherwise) { return length(name, viewport_.width, otherwise); }
    double down(const char* name, double otherwise) { return length(name, viewport_.height, otherwise); }

    SvgResult<Path> points_path(bool closed) const {
        const auto numbers = parse_numbers(attribute_text(node_, "points"));
        if (!numbers) return error_in(document_, node_, "points", numbers.error());
        if (numbers->size() % 2 != 0) {
            return error_at(document_, node_, "points: an odd number of coordinates");
        }
        PathBuilder builder;
        for (std::size_t i = 0; i < numbers->size(); i += 2) {
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
        double rx = across("rx", -1); // negative: as the other one
        double ry = down("ry", -1);
        if (rx < 0) rx = std::max(ry, 0.0);
        if (ry < 0) ry = rx;
        rx = std::min(rx, width / 2);
        ry = std::min(ry, height / 2);
        const bool round = rx > 0 && ry > 0;
        if (!round) rx = ry = 0;
        PathBuilder builder;
        const auto line = [&](const Point2& p) {
            if (!(p == builder.current())) builder.line_to(p);
        };
        const auto corner = [&](const Point2& p) {
            if (round) builder.arc_to(rx, ry, 0, false, true, p);
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
        PathBuilder builder;
        builder.move_to({centre.x + rx, centre.y});
        builder.arc_to(rx, ry, 0, false, true, {centre.x, centre.y + ry});
        builder.arc_to(rx, ry, 0, false, true, {centre.x - rx, centre.y});
        builder.arc_to(rx, ry, 0, false, true, {centre.x, centre.y - ry});
        builder.arc_to(rx, ry, 0, false, true, {centre.x + rx, centre.y});
        builder.close();
        return builder.take();
    }

    const SvgDocument& document_;
    pugi::xml_node node_;
    Viewport viewport_;
    std::optional<SvgError> error_;
};

SvgResult<Path> shape_path(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport) {
    return ShapeReader(document, node, viewport).read();
}

void write_shape(pugi::xml_node node, const std::string& data) {
    const std::string kind = local_name(node);
    if (kind == "path") {
        set_attribute(node, "d", data);
    } else {
        const std::vector<const char*>& geometry = shape_attributes().at(kind);
        node.remove_attribute("d"); // one without meaning here
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
    // by these an editor would rebuild the shape as it was
    for (const char* name :
         {"sodipodi:type", "sodipodi:nodetypes", "inkscape:path-effect", "inkscape:original-d"}) {
        node.remove_attribute(name);
    }
}

} // namespace detail

} // namespace cageform_examples
