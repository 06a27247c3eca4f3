// Texts of drawings for tests.
#pragma once

#include "svg/document.hpp"

#include "catch.hpp"

#include <string>
#include <string_view>

namespace svg_texts {

/// A drawing of 100 by 100 units.
inline std::string svg(std::string_view content, std::string_view view_box = "0 0 100 100") {
    return R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox=")" + std::string(view_box) + R"(">)" +
           std::string(content) + "</svg>";
}

inline cageform_examples::SvgDocument parsed(std::string_view text) {
    auto document = cageform_examples::parse_svg(text, "test.svg");
    INFO(text);
    INFO((document ? std::string() : to_string(document.error())));
    REQUIRE(document);
    return std::move(*document);
}

} // namespace svg_texts
