// Documents whose attributes change from frame to frame.

#include "svg/document.hpp"
#include "svg/shapes.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace cageform_examples {

namespace {

/// The four animations whose product is a map: SVG animates no matrix. Each is a type and its values.
std::array<std::pair<const char*, std::string>, 4> animated_parts(const std::vector<Affine2>& maps) {
    std::array<std::pair<const char*, std::string>, 4> parts{
        {{"translate", {}}, {"rotate", {}}, {"skewX", {}}, {"scale", {}}}};
    constexpr double per_degree = std::numbers::pi / 180;
    double turn = 0;
    const auto put = [&](const Affine2& m) {
        const double before = turn;
        turn = std::atan2(m.b, m.a);
        turn +=
            2 * std::numbers::pi * std::round((before - turn) / (2 * std::numbers::pi)); // the shorter way
        const double along = m.c * std::cos(turn) + m.d * std::sin(turn);
        const double across = -m.c * std::sin(turn) + m.d * std::cos(turn);
        const double lean = std::atan(along / across);
        const auto pair = [](double x, double y) {
            return format_number(x, 5) + ' ' + format_number(y, 5) + ';';
        };
        parts[0].second += pair(m.e, m.f);
        parts[1].second += format_number(turn / per_degree, 4) + ';';
        parts[2].second += format_number(lean / per_degree, 4) + ';';
        parts[3].second += pair(std::hypot(m.a, m.b), across);
    };
    for (const Affine2& m : maps) put(m);
    put(maps.front()); // ends as it begins
    for (auto& [type, values] : parts) values.pop_back();
    return parts;
}

} // namespace

void AnimatedSvg::show(std::size_t frame) {
    for (const Track& track : tracks) {
        detail::set_attribute(track.node, track.attribute.c_str(),
                              track.maps.empty() ? track.texts[frame]
                                                 : detail::write_transform(track.maps[frame]));
    }
}

void AnimatedSvg::append_animation(pugi::xml_node node, const std::string& attribute, const std::string& type,
                                   double seconds, const std::string& values) {
    const pugi::xml_node root = detail::root_element(node.root());
    const std::string element = detail::name_prefix(root) + (type.empty() ? "animate" : "animateTransform");
    const bool is_pattern =
        detail::local_name(node) == "pattern"; // with an element in it, it takes no content
    pugi::xml_node animation = is_pattern ? node.parent().insert_child_before(element.c_str(), node)
                                          : node.append_child(element.c_str());
    if (is_pattern) {
        detail::set_attribute(animation, detail::reference_name(root).c_str(),
                              std::string("#") + node.attribute("id").value());
    }
    animation.append_attribute("attributeName") = attribute.c_str();
    if (!type.empty()) animation.append_attribute("type") = type.c_str();
    if (!type.empty() && type != "translate") animation.append_attribute("additive") = "sum";
    animation.append_attribute("dur") = (format_number(seconds, 6) + 's').c_str();
    animation.append_attribute("repeatCount") = "indefinite";
    animation.append_attribute("values") = values.c_str();
}

void AnimatedSvg::play(double seconds) {
    for (const Track& track : tracks) {
        if (!track.maps.empty()) {
            for (const auto& [type, values] : animated_parts(track.maps))
                append_animation(track.node, track.attribute, type, seconds, values);
            continue;
        }
        std::string values;
        for (const std::string& text : track.texts) values += text + ';';
        append_animation(track.node, track.attribute, "", seconds,
                         values + track.texts.front()); // ends as it begins
    }
}

} // namespace cageform_examples
