#include "pictures/cage_picture.hpp"

#include "io/base64.hpp"
#include "pictures/field_plot.hpp"
#include "svg/document.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cageform_support {

void draw_numbers(SvgDocument& document, const CageFile& cage, double letter) {
    auto group = document.xml.document_element().append_child("g");
    group.append_attribute("font-family") = "DejaVu Sans, sans-serif";
    group.append_attribute("font-size") = letter;
    group.append_attribute("text-anchor") = "middle";
    group.append_attribute("fill") = "#222222";
    group.append_attribute("stroke") = "white";
    group.append_attribute("stroke-width") = letter / 5;
    group.append_attribute("paint-order") = "stroke";
    const auto outline = cage.curves ? cage.outline() : std::vector<Subpath>();
    std::vector<bool> is_drawn(cage.vertices.size());
    for (std::size_t b = 0; b < cage.blocks.size(); ++b) {
        const auto& points = cage.blocks[b].points;
        const std::size_t n = points.size();
        double area = 0;
        for (std::size_t k = 0; k < n; ++k) {
            const Point2 &p = points[k], &q = points[(k + 1) % n];
            area += p.x * q.y - p.y * q.x;
        }
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t i = cage.handles[b][k];
            if (is_drawn[i]) continue;
            is_drawn[i] = true;
            const Point2 &before = points[(k + n - 1) % n], &p = points[k], &after = points[(k + 1) % n];
            const auto side = [&](const Point2& from, const Point2& to) { // outward normal of an edge
                const double length = std::hypot(to.x - from.x, to.y - from.y) * (area < 0 ? -1 : 1);
                return length == 0 ? Point2{} : Point2{(to.y - from.y) / length, (from.x - to.x) / length};
            };
            const Point2 one = side(before, p), other = side(p, after);
            const double x = cage.lattice ? 1 : one.x + other.x, y = cage.lattice ? -1 : one.y + other.y,
                         length = std::hypot(x, y);
            const double reach = length > 0 ? 0.9 * letter / length : 0;
            if (!cage.curves ||
                (k % 3 != 0 && outline[b].segments[k / 3].is_line())) { // draw_cage() marks curves
                auto dot = group.append_child("circle");
                dot.append_attribute("cx") = p.x;
                dot.append_attribute("cy") = p.y;
                dot.append_attribute("r") = letter / 6;
                dot.append_attribute("fill") = "#c2377a";
                dot.append_attribute("stroke") = "none";
            }
            auto text = group.append_child("text");
            text.append_attribute("x") = p.x + reach * x;
            text.append_attribute("y") = p.y + reach * y + 0.35 * letter;
            text.text() = std::to_string(i).c_str();
        }
    }
}

namespace {

void set_box(pugi::xml_node node, const ViewBox& box) {
    const std::array<double, 4> numbers{box.x, box.y, box.width, box.height};
    const std::array<const char*, 4> names{"x", "y", "width", "height"};
    for (std::size_t k = 0; k < 4; ++k) detail::set_attribute(node, names[k], text_of("%.9g", numbers[k]));
}
void set_view(pugi::xml_node node, const ViewBox& box) {
    std::string text;
    for (const double x : {box.x, box.y, box.width, box.height}) text += text_of("%.9g ", x);
    text.pop_back();
    detail::set_attribute(node, "viewBox", text);
}

/// Embeds a figure as an image, so that its styles and ids do not affect the document. Content beyond its
/// viewBox is included, because a cage encloses that too.
void draw_figure(SvgDocument& document, const SvgDocument& figure, const ViewBox& view, const ViewBox& box) {
    SvgDocument copy = detail::copy_of(figure);
    const auto inner = detail::root_element(copy.xml);
    auto outer = copy.xml.insert_child_before("svg", inner);
    outer.append_attribute("xmlns") = "http://www.w3.org/2000/svg";
    constexpr double pixels = 1600; // resolution in programs that rasterise the image
    const double scale = pixels / std::max(box.width, box.height);
    set_view(outer, box);
    detail::set_attribute(outer, "width", text_of("%.9g", scale * box.width));
    detail::set_attribute(outer, "height", text_of("%.9g", scale * box.height));
    const auto moved = outer.append_move(inner);
    set_box(moved, view);
    set_view(moved, view);
    detail::set_attribute(moved, "overflow", "visible");
    auto image = document.xml.document_element().append_child("image");
    set_box(image, box);
    image.append_attribute("href") = ("data:image/svg+xml;base64," + base64(to_text(copy))).c_str();
}

} // namespace

Expected<SvgDocument> draw_pose(const CageFile& cage, const CageFile& pose, const SvgDocument* figure,
                                const std::string& name) {
    PlaneBox box;
    for (const auto* vertices : {&cage.vertices, &pose.vertices}) {
        for (const Point2& p : *vertices) box.add(p);
    }
    const double diagonal = std::hypot(box.width(), box.height()), letter = diagonal / 45;
    if (!(letter > 0) || !std::isfinite(diagonal))
        return FileError{cage.name + ": cannot be drawn: its size is not finite, or zero"};
    auto picture = parse_svg("<svg xmlns=\"http://www.w3.org/2000/svg\"/>", name);
    if (!picture) return picture;
    const ViewBox seen{box.low.x - 2 * letter, box.low.y - 2 * letter, box.width() + 4 * letter,
                       box.height() + 4 * letter};
    set_view(picture->xml.document_element(), seen);
    if (figure != nullptr) {
        const auto view = view_box(*figure);
        draw_figure(*picture, *figure, view, seen);
    }
    if (cage.vertices != pose.vertices) draw_cage(*picture, cage, diagonal, "#888888");
    draw_cage(*picture, pose, diagonal, "#c2377a");
    draw_numbers(*picture, pose, letter);
    return picture;
}

void draw_pins(SvgDocument& document, const std::vector<Pin<2>>& pins, double diagonal) {
    auto group = document.xml.document_element().append_child("g");
    const auto set = [](pugi::xml_node element, const char* name, const auto& value) {
        element.append_attribute(name) = value;
    };
    set(group, "stroke", "#1f6fb4");
    set(group, "stroke-width", diagonal / 300);
    for (const Pin<2>& pin : pins) {
        if (pin.target == pin.place) continue;
        auto line = group.append_child("line");
        set(line, "x1", pin.place[0]);
        set(line, "y1", pin.place[1]);
        set(line, "x2", pin.target[0]);
        set(line, "y2", pin.target[1]);
    }
    for (const Pin<2>& pin : pins) {
        auto dot = group.append_child("circle");
        set(dot, "cx", pin.target[0]);
        set(dot, "cy", pin.target[1]);
        set(dot, "r", diagonal / 90);
        set(dot, "fill", "white");
    }
}

} // namespace cageform_support
