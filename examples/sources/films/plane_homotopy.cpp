// Draws a regular homotopy between two closed curves with equal turning numbers; for different turning
// numbers, where it fails. Below each curve is the spiral of its tangent: angle around, arc length upwards.
//
//     plane_homotopy circle loops -o homotopy.svg --png
//     plane_homotopy circle eight -o fails.svg

#include "cli/command_line.hpp"
#include "film_choice.hpp"
#include "homotopy.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"

#include <iostream>

namespace {

using namespace cageform_sources;
using Complex = std::complex<double>;

constexpr int most_turns = 12;

/// Parses a turning number; returns the fault, or empty.
std::string parse_turns(std::string_view text, int& turns) {
    double number = 0;
    if (std::string why = detail::parse_number(text, number); !why.empty()) return why;
    if (!(std::fabs(number) <= most_turns) || number != std::round(number))
        return detail::quoted(text) + " is not a whole number of turns from -12 to 12";
    turns = int(number);
    return {};
}

/// circle, loops, eight, random:TURNS:SEED or TURNS:A1,A2,…
TurningCurve parse_curve(const std::string& word) {
    if (word == "circle") return TurningCurve{1};
    if (word == "loops") return TurningCurve{1, {0, 2.5}};
    if (word == "eight")
        return TurningCurve{0, {2.404825557695773}}; // the first zero of the Bessel function J0
    const std::string start = word + ": ";
    const bool is_random = word.starts_with("random:");
    const std::string_view rest = std::string_view(word).substr(is_random ? 7 : 0);
    const std::size_t colon = rest.find(':');
    if (colon == rest.npos)
        throw Failure(start +
                      "a curve is circle, loops, eight, random:TURNS:SEED, or TURNS:A1,A2, such as 1:0,2.5");
    int turns = 0;
    if (const std::string why = parse_turns(rest.substr(0, colon), turns); !why.empty())
        throw Failure(start + why);
    TurningCurve curve{turns};
    std::string_view numbers = rest.substr(colon + 1);
    while (!numbers.empty()) {
        const std::size_t comma = std::min(numbers.find(','), numbers.size());
        double& number = curve.sines.emplace_back(0.0);
        if (const std::string why = detail::parse_number(numbers.substr(0, comma), number); !why.empty())
            throw Failure(start + why);
        if (!(std::fabs(number) <= 20) || curve.sines.size() > 16)
            throw Failure(start + "at most 16 numbers from -20 to 20 are allowed");
        numbers.remove_prefix(std::min(comma + 1, numbers.size()));
    }
    if (!is_random) return curve;
    if (curve.sines.size() != 1 || !(curve.sines[0] >= 0) || curve.sines[0] != std::round(curve.sines[0]))
        throw Failure(start + "the seed is a whole number from 0 to 20");
    return random_curve(turns, unsigned(curve.sines[0]));
}

/// Draws a family of curves at the same scale.
class Tiles {
public:
    static constexpr double width = 200, height = 330;

    Tiles(const Homotopy& homotopy, std::vector<Homotopy::Stop> stops)
        : homotopy_(homotopy)
        , stops_(std::move(stops)) {
        for (int n = 0; n <= 32; ++n) {
            for (const Complex& p : homotopy.points(n / 32.0))
                reach_ = std::fmax(reach_, std::fmax(std::fabs(p.real()), std::fabs(p.imag())));
        }
    }

    /// The curve at s, the spiral of its tangent, and the points with speed 0.
    std::string tile(double s) const {
        const auto points = homotopy_.points(s);
        std::string svg = caption(s);
        std::vector<Point2> line;
        for (const Complex& p : points) line.push_back(place(p));
        svg += path(line, "#1f3f7a", 2.2) + dot(line[0], "#1f3f7a");
        const auto angles = homotopy_.angles(s);
        constexpr double middle = width / 2, bottom = 310, high = 84, wide = 46;
        line.clear();
        std::vector<Point2> floor, roof;
        for (std::size_t k = 0; k < angles.size(); ++k) {
            const double around = wide * std::cos(angles[k]), back = -0.28 * wide * std::sin(angles[k]);
            const double turn = Homotopy::tau(k);
            line.push_back({middle + around, bottom + back - high * double(k) / Homotopy::samples});
            floor.push_back({middle + wide * std::cos(turn), bottom + 0.28 * wide * std::sin(turn)});
            roof.push_back({floor.back().x, floor.back().y - high});
        }
        svg += path(floor, "#cccccc", 1) + path(roof, "#cccccc", 1) + path(line, "#b5482a", 1.8) +
               dot(line.front(), "#b5482a") + dot(line.back(), "#b5482a");
        for (const auto& stop : stops_) {
            if (std::fabs(stop.s - s) > 1e-9) continue;
            const auto k = std::size_t(std::lround(stop.tau / Homotopy::tau(1))) % Homotopy::samples;
            const Point2 at = place(points[k]);
            svg += "<circle cx=\"" + text_of("%.2f", at.x) + "\" cy=\"" + text_of("%.2f", at.y) +
                   "\" r=\"7\" fill=\"none\" stroke=\"#d01010\" stroke-width=\"2\"/>\n";
        }
        return svg;
    }

    static std::string document(double wide, const std::string& content) {
        return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + text_of("%g", wide) + ' ' +
               text_of("%g", height) + "\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"13\">\n" +
               content + "</svg>\n";
    }

private:
    Point2 place(const Complex& p) const {
        const double scale = 88 / reach_;
        return {width / 2 + scale * p.real(), 118 - scale * p.imag()};
    }
    std::string caption(double s) const {
        const bool stands = std::any_of(stops_.begin(), stops_.end(),
                                        [&](const auto& stop) { return std::fabs(stop.s - s) <= 1e-9; });
        const std::string what =
            stands ? "speed 0" : "turns " + text_of("%.0f", std::round(homotopy_.turns(s)) + 0.0);
        return "<text x=\"100\" y=\"18\" text-anchor=\"middle\">s = " + text_of("%.3g", s) + ", " + what +
               "</text>\n";
    }
    static std::string path(const std::vector<Point2>& line, const char* colour, double thickness) {
        std::string d;
        for (const Point2& p : line)
            d += (d.empty() ? "M" : " ") + text_of("%.2f", p.x) + "," + text_of("%.2f", p.y);
        return "<path d=\"" + d + "\" fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"" +
               text_of("%g", thickness) + "\" stroke-linejoin=\"round\"/>\n";
    }
    static std::string dot(const Point2& at, const char* colour) {
        return "<circle cx=\"" + text_of("%.2f", at.x) + "\" cy=\"" + text_of("%.2f", at.y) +
               "\" r=\"3.4\" fill=\"" + colour + "\"/>\n";
    }

    const Homotopy& homotopy_;
    std::vector<Homotopy::Stop> stops_;
    double reach_ = 1e-9;
};

/// The times of frames from 0 to 1. The times nearest to the stops are moved to the stops.
std::vector<double> times_of(int count, const std::vector<Homotopy::Stop>& stops) {
    std::vector<double> times;
    for (int n = 0; n < count; ++n) times.push_back(double(n) / (count - 1));
    for (const auto& stop : stops) times[std::size_t(std::lround(stop.s * (count - 1)))] = stop.s;
    return times;
}

/// Prints the least speed of a regular homotopy, otherwise where its speed is 0.
void print(const Homotopy& homotopy, const TurningCurve& first, const TurningCurve& last,
           const std::vector<Homotopy::Stop>& stops) {
    if (homotopy.is_regular()) {
        const auto bound = homotopy.least_speed();
        std::cout << "both tangents turn " << first.turns << " times: the speed is at least "
                  << text_of("%.4g", bound.least) << " (" << bound.intervals
                  << " intervals; smallest found: " << text_of("%.4g", bound.reached) << ")\n";
        if (homotopy.start() > 0)
            std::cout << "the second curve starts at t = " << text_of("%.4g", homotopy.start())
                      << " because from t = 0 both curves would cancel each other\n";
    } else {
        std::cout << "the tangents turn " << first.turns << " and " << last.turns
                  << " times, so no homotopy is regular; the speed of this one is 0\n";
        for (const auto& stop : stops)
            std::cout << "  at s = " << text_of("%.6f", stop.s) << ", t = " << text_of("%.6f", stop.tau)
                      << ": speed " << text_of("%.2g", stop.speed) << '\n';
    }
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws a deformation of a closed curve into another one without corners or, if none "
                     "exists, where it fails.");
    line.set_examples({"circle loops -o homotopy.svg --png", "eight 0:0,1.8 -o eights.svg --gif eights.gif",
                       "random:2:1 random:2:7 -o random.svg --stills random_ --frames 24",
                       "circle eight -o fails.svg"});
    std::vector<std::string> words;
    std::string out;
    int columns = 7;
    bool png = false;
    FilmChoice film;
    line.add("curves", words,
             "the first and the last curve: circle, loops, eight, random:TURNS:SEED, or TURNS:A1,A2,…, with "
             "the tangent angle TURNS t + A1 sin t + A2 sin 2t + …")
        .required()
        .count(2, 2);
    line.add("-o,--output", out, "the strip of frames, an SVG file").required().ends_with({".svg"});
    line.add("--columns", columns, "frames on the strip").range(2, 60).show_default();
    line.add_flag("--png", png, "also render it, and stills, to the same names with .png");
    film.add_options(line, 48, "SVG files");
    if (const auto code = line.parse(argc, argv)) return *code;
    std::vector<TurningCurve> curves;
    for (const std::string& word : words) curves.push_back(parse_curve(word));
    fail_if(film.fault({out}, ".svg"));

    const Homotopy homotopy(curves[0], curves[1]);
    const auto stops = homotopy.is_regular() ? std::vector<Homotopy::Stop>() : homotopy.stops();
    print(homotopy, curves[0], curves[1], stops);
    const Tiles tiles(homotopy, stops);
    std::string strip;
    int column = 0;
    for (const double s : times_of(columns, stops))
        strip += "<g transform=\"translate(" + text_of("%g", Tiles::width * column++) + ",0)\">\n" +
                 tiles.tile(s) + "</g>\n";
    OutputFiles outputs;
    add_svg(outputs, out, Tiles::document(Tiles::width * columns, strip),
            png ? int(Tiles::width) * columns : 0);
    std::vector<std::string> frames;
    if (film.is_given()) {
        for (const double s : times_of(film.frames, stops))
            frames.push_back(Tiles::document(Tiles::width, tiles.tile(s)));
    }
    film.write(outputs, frames, png, int(Tiles::width));
    return commit(outputs);
}
