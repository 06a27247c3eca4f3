// Places SVG and PNG files side by side, with captions.
//
//     contact_sheet -o sheet.svg --columns 2 --png "at rest" cat.svg "a step" step.svg

#include "cli/command_line.hpp"
#include "io/base64.hpp"
#include "io/input_file.hpp"
#include "io/messages.hpp"
#include "pictures/render.hpp"
#include "svg/xml.hpp"

namespace {

using namespace cageform_support;

/// Adds a prefix to all identifiers of a document, so that several documents can share a file.
void prefix_ids(pugi::xml_node node, const std::string& prefix) {
    for (auto attribute : node.attributes()) {
        const std::string name = attribute.name();
        std::string value = attribute.value();
        if (name == "id")
            value = prefix + value;
        else if ((name == "href" || name == "xlink:href") && value.starts_with('#'))
            value = '#' + prefix + value.substr(1);
        else {
            for (std::size_t at = 0; (at = value.find("url(#", at)) != std::string::npos; at += 5)
                value.insert(at + 5, prefix);
        }
        attribute.set_value(value.c_str());
    }
    for (auto child : node.children()) prefix_ids(child, prefix);
}

/// Wraps a PNG file in an SVG document.
Expected<SvgDocument> wrap_png(const std::string& path) {
    const auto file = read_file(path);
    if (!file) return file.error();
    const std::string& bytes = *file;
    if (bytes.size() < 24 || !bytes.starts_with("\x89PNG\r\n\x1a\n"))
        return FileError{path + ": is not a PNG file"};
    const auto number = [&](std::size_t at) { // big-endian
        std::uint32_t n = 0;
        for (std::size_t k = 0; k < 4; ++k) n = n << 8 | std::uint8_t(bytes[at + k]);
        return std::to_string(n);
    };
    const std::string width = number(16), height = number(20);
    return parse_svg("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + width + ' ' + height +
                         "\"><image width=\"" + width + "\" height=\"" + height +
                         "\" xlink:href=\"data:image/png;base64," + base64(bytes) + "\"/></svg>",
                     path);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Places SVG and PNG files side by side, with captions.");
    line.set_examples({"-o sheet.svg --columns 2 --png \"at rest\" cat.svg \"a step\" step.svg",
                       "-o heat.svg \"one vertex\" field.png"});
    std::string out_path;
    std::vector<std::string> words;
    std::size_t columns = 2;
    bool png = false;
    int png_width = 1200, tile = 400;
    line.add("-o,--output", out_path, "the SVG file to write").required().ends_with({".svg"});
    line.add("--columns", columns, "tiles in a row").range(1, 64).show_default();
    line.add("--tile", tile, "width of a tile, in user units").range(10, 10000).show_default();
    line.add_flag("--png", png, "also render it, to the same name with .png");
    line.add("--png-width", png_width, "the width of the PNG file, in pixels").range(1, 16384).show_default();
    line.add("tiles", words, "CAPTION FILE pairs; files are SVG or PNG").required();
    if (const auto code = line.parse(argc, argv)) return *code;
    if (words.size() % 2 != 0) return fail("captions and files have to alternate");
    for (std::size_t n = 0; n < words.size(); n += 2) {
        if (printable(words[n]) != words[n])
            return fail("the caption \"" + words[n] + "\" holds control characters, or is not UTF-8");
    }

    SvgDocument sheet;
    auto root = sheet.xml.append_child("svg");
    root.append_attribute("xmlns") = "http://www.w3.org/2000/svg";
    root.append_attribute("xmlns:xlink") = "http://www.w3.org/1999/xlink";
    constexpr double caption = 30, gap = 12;
    double height = gap, row_height = 0;
    for (std::size_t n = 0; n < words.size() / 2; ++n) {
        const std::string& path = words[2 * n + 1];
        const auto document = (path.ends_with(".png") ? wrap_png(path) : load_svg(path)).value();
        const auto view = view_box(document);
        if (n % columns == 0) {
            height += row_height;
            row_height = 0;
        }
        const double x = gap + double(n % columns) * (tile + gap);
        const double tile_height = tile * view.height / view.width;
        row_height = std::max(row_height, caption + tile_height + gap);

        auto text = root.append_child("text");
        text.append_attribute("x") = x + tile / 2.0;
        text.append_attribute("y") = height + 0.7 * caption;
        text.append_attribute("font-family") = "DejaVu Sans, sans-serif";
        text.append_attribute("font-size") = 17;
        text.append_attribute("text-anchor") = "middle";
        text.text() = detail::escaped(words[2 * n]).c_str();
        auto nested = root.append_copy(document.xml.document_element());
        prefix_ids(nested, "t" + std::to_string(n) + "-");
        for (const char* name : {"x", "y", "width", "height", "viewBox"}) nested.remove_attribute(name);
        nested.append_attribute("x") = x;
        nested.append_attribute("y") = height + caption;
        nested.append_attribute("width") = tile;
        nested.append_attribute("height") = tile_height;
        nested.append_attribute("viewBox") = (std::to_string(view.x) + " " + std::to_string(view.y) + " " +
                                              std::to_string(view.width) + " " + std::to_string(view.height))
                                                 .c_str();
    }
    height += row_height;
    const double width = gap + double(std::min(columns, words.size() / 2)) * (tile + gap);
    root.append_attribute("viewBox") =
        ("0 0 " + std::to_string(width) + " " + std::to_string(height)).c_str();
    root.append_attribute("width") = width;
    root.append_attribute("height") = height;
    OutputFiles outputs;
    add_svg(outputs, out_path, to_text(sheet), png ? png_width : 0);
    return commit(outputs);
}
