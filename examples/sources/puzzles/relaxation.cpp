// Draws relaxation on a line: in each sweep, every cell without a given value becomes the mean of its
// neighbours. Draws it from zero and from a good initial guess.
//
//     relaxation line.csv -o relaxation.svg --png --play relaxation_plays.svg

#include "averaging/averaging_pyramid.hpp"
#include "cli/command_line.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"

#include <iostream>

namespace {

using namespace cageform_support;

constexpr std::size_t most_cells = 1000, most_sweeps = 200000;

/// Cells of a line; given cells keep their values.
struct Line {
    std::vector<double> values;
    std::vector<bool> given;

    double low() const { return *std::min_element(values.begin(), values.end()); }
    double high() const { return *std::max_element(values.begin(), values.end()); }
};

Line load_line(const std::string& path) {
    Line line;
    const auto size = value_or_fail(read_table(path, [&](std::string_view cell) -> std::string {
        const bool unknown = cell.empty() || cell == ".";
        double& value = line.values.emplace_back(0.0);
        line.given.push_back(!unknown);
        std::string why = unknown ? "" : detail::parse_number(cell, value);
        if (why.empty() && !(std::fabs(value) <= 1e100)) why = detail::quoted(cell) + " is beyond 1e100";
        return why;
    }));
    const std::size_t count = line.values.size();
    if (size.rows > 1 && size.columns > 1) {
        throw Failure(path + ": holds " + std::to_string(size.rows) + " rows of " +
                      std::to_string(size.columns) + " cells; a line is one row, or one column");
    }
    if (count > most_cells)
        throw Failure(path + ": holds " + std::to_string(count) + " cells; the limit is 1000");
    const auto given = std::count(line.given.begin(), line.given.end(), true);
    if (given == 0) throw Failure(path + ": no cell has a value");
    if (std::size_t(given) == count) throw Failure(path + ": every cell has a value, none is unknown (.)");
    return line;
}

/// Returns the limit of the sweeps: linear between given cells, constant beyond the last one.
std::vector<double> solution_of(const Line& line) {
    std::vector<std::size_t> places;
    for (std::size_t c = 0; c < line.given.size(); ++c) {
        if (line.given[c]) places.push_back(c);
    }
    std::vector<double> solution(line.values.size());
    for (std::size_t c = 0; c < solution.size(); ++c) {
        const auto next = std::lower_bound(places.begin(), places.end(), c);
        const std::size_t b = next == places.end() ? places.back() : *next;
        const std::size_t a = next == places.begin() || b == c || next == places.end() ? b : *(next - 1);
        const double part = a == b ? 0.0 : double(c - a) / double(b - a);
        solution[c] = (1 - part) * line.values[a] + part * line.values[b];
    }
    return solution;
}

namespace averaging = cageform_sources::averaging;
using averaging::AveragingPyramid, averaging::CellTag;

AveragingPyramid<double, 1> make_pyramid(const Line& line, const averaging::AveragingOptions& options) {
    std::vector<CellTag> tags;
    for (const bool given : line.given) tags.push_back(given ? CellTag::boundary : CellTag::interior);
    return {cageform::CellBox<1>{{tags.size()}}, std::move(tags), options};
}

/// The solution on cells of twice the length, each used for two cells.
std::vector<double> coarse_guess(const Line& line, double tolerance) {
    Line coarse{std::vector<double>((line.values.size() + 1) / 2, 0.0), {}};
    std::vector<double> children(coarse.values.size(), 0.0);
    for (std::size_t c = 0; c < line.values.size(); ++c) {
        if (!line.given[c]) continue;
        coarse.values[c / 2] += line.values[c];
        children[c / 2] += 1;
    }
    for (std::size_t c = 0; c < children.size(); ++c) {
        coarse.given.push_back(children[c] > 0);
        if (children[c] > 0) coarse.values[c] /= children[c];
    }
    (void)make_pyramid(coarse, {.tolerance = tolerance}).solve(std::span<double>(coarse.values));
    std::vector<double> guess;
    for (std::size_t c = 0; c < line.values.size(); ++c)
        guess.push_back(line.given[c] ? line.values[c] : coarse.values[c / 2]);
    return guess;
}

struct Frame {
    std::size_t sweeps;
    std::vector<double> values;
};

/// The line after 0, 1, 2, 5, 10 … sweeps, until convergence.
struct Run {
    std::string name;
    std::vector<Frame> frames;
    bool steady = false;
    double off = 0; ///< largest difference of the last frame from the solution

    std::string caption(std::size_t n) const {
        const std::size_t sweeps = frames[n].sweeps;
        const std::string count = std::to_string(sweeps) + (sweeps == 1 ? " sweep" : " sweeps");
        if (n + 1 < frames.size()) return count;
        return count + (steady ? ": steady, " : ": not steady yet, ") + text_of("%.2g", off) + " off";
    }
};

Run relax(const std::string& name, const Line& line, std::vector<double> values, double tolerance) {
    Run run{name, {{0, values}}, false, 0};
    std::size_t next = 1;
    while (!run.steady && run.frames.back().sweeps < most_sweeps) {
        const std::size_t before = run.frames.back().sweeps;
        auto pyramid = make_pyramid(
            line, {.tolerance = tolerance, .max_sweeps = next - before, .use_initial_values = true});
        const auto outcome = pyramid.solve(std::span<double>(values));
        run.steady = outcome.converged;
        run.frames.push_back({before + outcome.sweeps, values});
        const bool is_two = std::to_string(next).front() == '2'; // 1, 2, 5, 10 …
        next = is_two ? next / 2 * 5 : 2 * next;
    }
    const auto solution = solution_of(line);
    for (std::size_t c = 0; c < solution.size(); ++c)
        run.off = std::max(run.off, std::fabs(values[c] - solution[c]));
    return run;
}

/// A plot of values over the cells, with the upper left corner at (0, 0).
class LinePlot {
public:
    LinePlot(const Line& line, double width, double height)
        : line_(line)
        , solution_(solution_of(line))
        , x_{-0.5, double(line.values.size()) - 0.5, 40, width - 10}
        , y_{0, 1, height - 12, 34} {
        y_.from = std::min(0.0, line.low()); // the sweeps begin there
        y_.to = std::max(0.0, line.high());
        if (y_.from == y_.to) y_.to = y_.from + 1;
    }

    /// Draws the common part of all frames: the axis, and the solution as a dashed line.
    std::string ground() const {
        std::string svg;
        for (const auto& [value, number] : marks_of(y_, 4)) {
            const std::string y = place(y_.at(value));
            svg += "<path d=\"M" + place(x_.begin) + "," + y + " H" + place(x_.end) +
                   "\" stroke=\"#e0e0e0\"/>\n";
            svg += text(x_.begin - 5, y_.at(value) + 4, "end", 11, number);
        }
        return svg + "<path d=\"" + path(solution_) +
               "\" fill=\"none\" stroke=\"#c8553d\" stroke-dasharray=\"5 4\"/>\n";
    }
    std::string frame(const std::vector<double>& values, const std::string& caption) const {
        const std::string zero = place(y_.at(0));
        std::string svg = text(x_.begin, 20, "start", 14, caption);
        svg += "<path d=\"" + path(values) + " V" + zero + " H" + place(x_.at(0)) +
               "z\" fill=\"#1b6ca8\" fill-opacity=\"0.25\"/>\n<path d=\"" + path(values) +
               "\" fill=\"none\" stroke=\"#1b6ca8\" stroke-width=\"2\"/>\n";
        for (std::size_t c = 0; c < values.size(); ++c) {
            if (line_.given[c])
                svg += "<circle cx=\"" + place(x_.at(double(c))) + "\" cy=\"" + place(y_.at(values[c])) +
                       "\" r=\"3.5\"/>\n";
        }
        return svg;
    }

    static std::string text(double x, double y, const char* anchor, int size, const std::string& words) {
        return "<text x=\"" + place(x) + "\" y=\"" + place(y) + "\" text-anchor=\"" + anchor +
               "\" font-size=\"" + std::to_string(size) + "\">" + words + "</text>\n";
    }

private:
    static std::string place(double x) { return text_of("%.1f", x); }
    std::string path(const std::vector<double>& values) const {
        std::string d;
        for (std::size_t c = 0; c < values.size(); ++c)
            d += (c == 0 ? "M" : " ") + place(x_.at(double(c))) + "," + place(y_.at(values[c]));
        return d;
    }

    const Line& line_;
    std::vector<double> solution_;
    Axis x_, y_;
};

std::string open_svg(double width, double height) {
    const std::string w = text_of("%.0f", width), h = text_of("%.0f", height);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" + w +
           "\" height=\"" + h +
           "\" font-family=\"DejaVu Sans, sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
           "fill=\"white\"/>\n";
}
std::string at(double x, double y) {
    return "<g transform=\"translate(" + text_of("%.0f", x) + "," + text_of("%.0f", y) + ")\">\n";
}

/// All frames of both runs, side by side.
std::string sheet_of(const Line& line, const std::vector<Run>& runs) {
    constexpr double width = 280, height = 170, title = 34;
    constexpr std::size_t columns = 5;
    const auto rows = [](const Run& run) { return (run.frames.size() + columns - 1) / columns; };
    double bottom = 0;
    for (const Run& run : runs) bottom += title + double(rows(run)) * height;
    std::string text = open_svg(double(columns) * width, bottom);
    const LinePlot plot(line, width, height);
    double top = 0;
    for (const Run& run : runs) {
        text += LinePlot::text(10, top + 25, "start", 18, run.name);
        for (std::size_t n = 0; n < run.frames.size(); ++n) {
            text += at(double(n % columns) * width, top + title + double(n / columns) * height) +
                    plot.ground() + plot.frame(run.frames[n].values, run.caption(n)) + "</g>\n";
        }
        top += title + double(rows(run)) * height;
    }
    return text + "</svg>\n";
}

/// Animates both runs side by side; viewers without animation show the last frame.
void write_film(AtomicFile& out, const Line& line, const std::vector<Run>& runs) {
    constexpr double width = 560, height = 360, title = 34, hold = 0.8, hold_last = 3;
    std::size_t count = 0;
    for (const Run& run : runs) count = std::max(count, run.frames.size());
    const double seconds = hold * double(count - 1) + hold_last;
    const LinePlot plot(line, width, height);
    out.write(open_svg(width * double(runs.size()), height + title));
    for (std::size_t r = 0; r < runs.size(); ++r) {
        out.write(at(double(r) * width, 0) + LinePlot::text(10, 25, "start", 18, runs[r].name) + "</g>\n" +
                  at(double(r) * width, title) + plot.ground() + "</g>\n");
    }
    for (std::size_t n = 0; n < count; ++n) {
        const bool last = n + 1 == count;
        const auto part = [&](std::size_t frame) { return text_of("%.5f", hold * double(frame) / seconds); };
        std::string times = n == 0 ? "0" : "0;" + part(n), shown = n == 0 ? "visible" : "hidden;visible";
        if (!last) {
            times += ";" + part(n + 1);
            shown += ";hidden";
        }
        out.write("<g visibility=\"" + std::string(last ? "visible" : "hidden") + "\">\n");
        if (count > 1) {
            out.write("<animate attributeName=\"visibility\" calcMode=\"discrete\" dur=\"" +
                      text_of("%.1f", seconds) + "s\" repeatCount=\"indefinite\" keyTimes=\"" + times +
                      "\" values=\"" + shown + "\"/>\n");
        }
        for (std::size_t r = 0; r < runs.size(); ++r) {
            const std::size_t frame = std::min(n, runs[r].frames.size() - 1);
            out.write(at(double(r) * width, title) +
                      plot.frame(runs[r].frames[frame].values, runs[r].caption(frame)) + "</g>\n");
        }
        out.write("</g>\n");
    }
    out.write("</svg>\n");
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine words(
        "Draws relaxation on a line of cells: in each sweep, cells without a given value become the mean of "
        "their neighbours. Draws it twice, from zero and from a good first guess.");
    words.set_examples({"line.csv -o line.svg --png", "line.csv -o line.svg --play sweeps.svg"});
    std::string path, sheet, film, guess = "coarse";
    double tolerance = 1e-6;
    bool png = false;
    words.add("line", path, "a CSV file of one row, or one column; cells . are unknown").required();
    words.add("-o,--output", sheet, "the SVG file of all frames to write").required().ends_with({".svg"});
    words.add_flag("--png", png, "also render it, to the same name with .png");
    words.add("--play", film, "an animated SVG file to write").ends_with({".svg"});
    words
        .add("--guess", guess,
             "the good guess: the solution on cells twice as long, the nearest value, or "
             "linear pieces")
        .one_of({"coarse", "nearest", "linear"})
        .show_default();
    words
        .add("--tolerance", tolerance,
             "stop when the mean change of a cell is below this share of the largest value")
        .range(1e-12, 0.1)
        .show_default("1e-06");
    words.set_footer("Sweeps work in place, from the first cell to the last. The dashed line is the\n"
                     "solution. Sweeps that change little can still be far from it; the last caption\n"
                     "gives the distance.\n");
    if (const auto code = words.parse(argc, argv)) return *code;

    const auto line = load_line(path);
    double scale = std::max(std::fabs(line.low()), std::fabs(line.high()));
    if (scale == 0) scale = 1;
    std::vector<double> good;
    if (guess == "coarse") {
        good = coarse_guess(line, tolerance * scale);
    } else if (guess == "linear") {
        good = solution_of(line);
    } else {
        for (std::size_t c = 0; c < line.values.size(); ++c) {
            std::size_t off = 0; // distance to the nearest given cell, on ties the one before
            while (!(c >= off && line.given[c - off]) &&
                   !(c + off < line.given.size() && line.given[c + off]))
                ++off;
            good.push_back(line.values[c >= off && line.given[c - off] ? c - off : c + off]);
        }
    }
    const std::string words_of = guess == "coarse"   ? "from the solution on cells twice as long"
                                 : guess == "linear" ? "from linear pieces"
                                                     : "from the nearest value";
    const std::vector<Run> runs{relax("from zero", line, line.values, tolerance * scale),
                                relax(words_of, line, good, tolerance * scale)};
    for (const Run& run : runs)
        std::cout << run.name << ": " << run.caption(run.frames.size() - 1) << " at most\n";
    OutputFiles outputs;
    add_svg(outputs, sheet, sheet_of(line, runs), png ? 1400 : 0);
    if (!film.empty()) write_film(outputs.add(film), line, runs);
    return commit(outputs);
}
