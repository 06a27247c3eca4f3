// An endless zoom into a self-similar curve. New sides grow at the rate of the magnification, so after one
// level the picture is equal to the first.
//
//     zooms koch -o koch.svg --png --gif koch.gif

#include "cli/command_line.hpp"
#include "film_choice.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"
#include "self_similar.hpp"

#include <iostream>

namespace {

using namespace cageform_sources;

/// A square frame, with a size in pixels, at the origin.
std::string frame_of(const SelfSimilarCurve& curve, int level, double time, int size) {
    std::string d;
    for (const auto& p : curve.frame(level, time)) {
        // Clamps coordinates far outside the picture, so that their numbers are short.
        const double x = std::clamp(p.real(), -9.0, 9.0), y = std::clamp(1 - p.imag(), -9.0, 9.0);
        d += (d.empty() ? "M" : " ") + text_of("%.3f", size * x) + "," + text_of("%.3f", size * y);
    }
    const std::string side = std::to_string(size);
    return "<svg width=\"" + side + "\" height=\"" + side + "\" viewBox=\"0 0 " + side + ' ' + side +
           "\"><rect width=\"100%\" height=\"100%\" fill=\"#f7f5ee\"/>\n<path d=\"" + d +
           (curve.is_closed() ? "Z" : "") + "\" fill=\"" + (curve.is_closed() ? "#cfe0ee" : "none") +
           "\" stroke=\"#1f3f7a\" stroke-width=\"1.6\" stroke-linejoin=\"round\"/></svg>\n";
}

std::string document(double width, double height, const std::string& content) {
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + text_of("%g", width) + ' ' +
           text_of("%g", height) + "\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"14\">\n" +
           content + "</svg>\n";
}

/// Prints the lengths of levels relative to level 0, and the areas of closed curves relative to their
/// triangle or square.
void print_levels(const SelfSimilarCurve& curve, int most) {
    const auto first = curve.corners(0);
    for (int level = 0; level <= most; ++level) {
        const auto corners = curve.corners(level);
        std::cout << "level " << level << ": " << corners.size() - 1 << " sides, length "
                  << text_of("%.6f", length_of(corners) / length_of(first));
        if (curve.is_closed())
            std::cout << ", area " << text_of("%.6f", area_of(curve.drawn(level)) / area_of(first));
        std::cout << '\n';
    }
    std::cout << "dimension " << text_of("%.6f", curve.dimension()) << '\n';
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Zooms endlessly into a self-similar curve, and prints the lengths of its levels.");
    line.set_examples({"koch -o koch.svg --png --gif koch.gif", "peano -o peano.svg --level 2",
                       "sierpinski -o sierpinski.svg --stills sierpinski_ --frames 25 --png"});
    std::string name, out;
    int columns = 6, level = 0, size = 300;
    bool png = false;
    FilmChoice film;
    line.add("curve", name, "koch, peano or sierpinski").required().one_of({"koch", "peano", "sierpinski"});
    line.add("-o,--output", out, "the strip of frames, an SVG file").required().ends_with({".svg"});
    line.add("--columns", columns, "frames on the strip, the last one equal to the first")
        .range(2, 60)
        .show_default();
    const CommandOption levels =
        line.add("--level", level, "the level of the first frame").range(0, 6).show_default("4, for peano 3");
    line.add("--size", size, "the width and height of a frame, in pixels").range(32, 2000).show_default();
    line.add_flag("--png", png, "also render it, and stills, to the same names with .png");
    film.add_options(line, 49, "SVG files");
    if (const auto code = line.parse(argc, argv)) return *code;
    using Kind = SelfSimilarCurve::Kind;
    const Kind kind = name == "koch" ? Kind::koch : name == "peano" ? Kind::peano : Kind::sierpinski;
    if (!levels.is_given()) level = kind == Kind::peano ? 3 : 4;
    if (kind == Kind::peano && level > 4)
        return fail("--level: 4 is the most for peano: each level has 9 times as many sides");
    fail_if(film.fault({out}, ".svg"));

    const SelfSimilarCurve curve(kind);
    print_levels(curve, level);
    constexpr double gap = 8, caption = 24;
    std::string strip;
    for (int n = 0; n < columns; ++n) {
        const double time = double(n) / (columns - 1), left = gap + n * (size + gap);
        strip += "<text x=\"" + text_of("%g", left + size / 2.0) +
                 "\" y=\"17\" text-anchor=\"middle\">t = " + text_of("%.2g", time) + ", ×" +
                 text_of("%.2f", std::pow(curve.ratio(), time)) + "</text>\n<g transform=\"translate(" +
                 text_of("%g", left) + ',' + text_of("%g", caption) + ")\">" +
                 frame_of(curve, level, time, size) + "</g>\n";
    }
    OutputFiles outputs;
    const double width = gap + columns * (size + gap);
    add_svg(outputs, out, document(width, caption + size + gap, strip), png ? int(width) : 0);
    std::vector<std::string> frames;
    for (int n = 0; film.is_given() && n < film.frames; ++n)
        frames.push_back(document(size, size, frame_of(curve, level, double(n) / (film.frames - 1), size)));
    film.write(outputs, frames, png, size, FilmChoice::End::is_start);
    return commit(outputs);
}
