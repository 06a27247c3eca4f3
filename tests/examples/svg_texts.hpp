// Texts of drawings for tests, what a deformation makes of them, and random input.
#pragma once

#include "svg/document.hpp"
#include "svg/xml.hpp"

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace svg_texts {

using namespace cageform_support;

/// A drawing of 100 by 100 units.
inline std::string svg(std::string_view content, std::string_view view_box = "0 0 100 100") {
    return R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox=")" + std::string(view_box) + R"(">)" +
           std::string(content) + "</svg>";
}

inline SvgDocument parsed(std::string_view text) {
    auto document = parse_svg(text, "test.svg");
    INFO(text);
    INFO((document ? std::string() : to_string(document.error())));
    REQUIRE(document);
    return std::move(*document);
}

inline pugi::xml_node by_id(const SvgDocument& document, std::string_view id) {
    return document.xml.find_node([&](pugi::xml_node node) { return node.attribute("id").value() == id; });
}

inline pugi::xml_node by_name(pugi::xml_node top, std::string_view name) {
    return top.find_node([&](pugi::xml_node node) { return detail::local_name(node) == name; });
}

inline Deformer by(const Affine2& map) {
    return [map](std::span<const Point2> in, std::span<Point2> out) {
        std::transform(in.begin(), in.end(), out.begin(), [&](const Point2& p) { return apply(map, p); });
        return true;
    };
}

struct Deformed {
    SvgDocument document;
    DeformReport report;
    std::string text;
};

inline Deformed deformed(std::string_view text, const Deformer& deformer, const DeformOptions& options = {}) {
    SvgDocument document = parsed(text);
    auto report = deform(document, deformer, options);
    INFO(text);
    INFO((report ? std::string() : to_string(report.error())));
    REQUIRE(report);
    std::string after = to_text(document);
    return {std::move(document), *report, std::move(after)};
}

class Random {
public:
    explicit Random(unsigned seed)
        : engine_(seed) {}
    double in(double least, double most) {
        return std::uniform_real_distribution<double>(least, most)(engine_);
    }
    std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(engine_); }
    std::string any_of(const std::vector<std::string>& texts) { return texts[below(texts.size())]; }
    Affine2 map(double shift) {
        const double turn = in(0, 6), skew = in(-0.8, 0.8), sx = in(0.4, 2), sy = in(0.4, 2);
        const double side = below(4) == 0 ? -1 : 1; // some are mirrored
        const double c = std::cos(turn), s = std::sin(turn);
        return {sx * c,
                sx * s,
                side * (skew * c - sy * s),
                side * (skew * s + sy * c),
                in(-shift, shift),
                in(-shift, shift)};
    }

private:
    std::mt19937 engine_;
};

} // namespace svg_texts
