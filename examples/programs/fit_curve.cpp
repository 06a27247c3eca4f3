// Replaces a Bézier curve between two keys by a few polynomials in time. Draws both and the error.
//
//     fit_curve --css ease-in-out --pieces 4 --plot curve.svg --png
//     fit_curve --bezier 24,0,31,12,39,9,48,10 --tolerance 0.01 --degree 4 --json fit.json
//     fit_curve --lottie ball.json                  lists animated values
//     fit_curve --lottie ball.json --curve layers/0/ks/r/k/0:0 --tolerance 0.1
//     fit_curve --cases cases.json --json results.json
//
// JSON files have the format bezier-sobolev-cases/1: objects with control points, degree, weights, conditions
// and knots; the output has the fit in "result". Errors are in the units of the curve; null is infinite.

#include "cli/command_line.hpp"
#include "cli/progress_bar.hpp"
#include "files/lottie_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"
#include "svg/xml.hpp"

#include <cageform/animate/fit.hpp>
#include <cageform/exchange/css.hpp>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <iostream>
#include <stdexcept>

namespace {

using namespace cageform_support;
using cageform::BezierCurve;
using cageform::BezierFit;
using cageform::FitCondition;
using cageform::FitOptions;
using cageform::Status;
using Json = nlohmann::ordered_json;

struct ConditionName {
    const char* name;
    const char* short_name;
    FitCondition condition;
};
using enum FitCondition;
constexpr std::array<ConditionName, 9> condition_names{{{"end_value", "", end_value},
                                                        {"knot_c0", "c0", knot_c0},
                                                        {"knot_value", "", knot_value},
                                                        {"end_d1", "", end_d1},
                                                        {"knot_c1", "c1", knot_c1},
                                                        {"knot_d1", "", knot_d1},
                                                        {"end_d2", "", end_d2},
                                                        {"knot_c2", "c2", knot_c2},
                                                        {"knot_d2", "", knot_d2}}};

FitCondition condition_of(const std::string& name) {
    for (const auto& known : condition_names) {
        if (name == known.name || (!name.empty() && name == known.short_name)) return known.condition;
    }
    std::string all;
    for (const auto& known : condition_names) all += std::string(all.empty() ? "" : ", ") + known.name;
    throw Failure("unknown condition \"" + name + "\"; there are " + all);
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t comma = text.find(','); comma != std::string::npos; comma = text.find(',', begin)) {
        parts.emplace_back(detail::trim(std::string_view(text).substr(begin, comma - begin)));
        begin = comma + 1;
    }
    parts.emplace_back(detail::trim(std::string_view(text).substr(begin)));
    return parts;
}

/// Parses comma-separated numbers: `count` of them, or any positive count if it is 0.
std::vector<double> numbers(const std::string& option, const std::string& text, std::size_t count) {
    std::vector<double> result;
    for (const std::string& part : split(text)) {
        const std::string why = detail::parse_finite(part, result.emplace_back());
        if (!why.empty()) throw Failure(option + ": " + why);
    }
    if (count != 0 && result.size() != count) {
        throw Failure(option + ": " + std::to_string(result.size()) + " numbers instead of " +
                      std::to_string(count));
    }
    return result;
}

/// A curve, the requested fit, and its result.
struct Case {
    std::string id, note;
    BezierCurve curve;
    FitOptions options;
    Json knots; ///< as in the file
    cageform::Result<BezierFit, cageform::FitReport> fitted;
    std::vector<std::size_t> search_index;
};

/// Throws unless a status is ok.
void require(Status status, const std::string& what) {
    if (status != Status::ok) throw Failure(what + ": " + cageform::to_string(status));
}

/// Parameters of a curve at given times; the first and the last must be the keys.
std::vector<double> parameters_at(const BezierCurve& curve, const std::vector<double>& times,
                                  const std::string& what) {
    const cageform::BezierFunction function(curve);
    if (times.size() < 2 || times.front() != curve.begin() || times.back() != curve.end())
        throw Failure(what + ": knots begin at the first key and end at the second, " +
                      text_of("%.17g", curve.begin()) + " and " + text_of("%.17g", curve.end()));
    std::vector<double> parameters;
    for (const double x : times) parameters.push_back(function.parameter(x));
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
        if (!(times[i] < times[i + 1])) require(Status::knots_not_ascending, what);
    }
    return parameters;
}

// ---- case files ----------------------------------------------------------------------------------

constexpr std::size_t most_pieces = 1000, most_candidates = 1000;

/// Returns the message of an nlohmann exception without its number in brackets.
std::string plain(const Json::exception& error) {
    const std::string text = error.what();
    return text.substr(std::min(text.find("] ") + 2, text.size()));
}

Json read_json(const std::string& path) {
    const auto text = value_or_fail(read_text(path));
    if (text.empty()) throw Failure(path + ": is empty");
    try {
        return Json::parse(text);
    } catch (const Json::exception& error) {
        throw Failure(path + ": " + plain(error));
    }
}

double number_of(const Json& json, const char* name) {
    if (!json.is_number()) throw Failure(std::string(name) + ": " + json.dump() + " is not a number");
    return json.get<double>();
}

std::size_t count_of(const Json& json, const char* name, std::size_t most) {
    const auto& value = json.at(name);
    if (!value.is_number_integer() || value.get<long long>() < 1 ||
        value.get<long long>() > static_cast<long long>(most))
        throw Failure(std::string(name) + " has to be a whole number from 1 to " + std::to_string(most));
    return value.get<std::size_t>();
}

void read_case(const Json& json, Case& one) {
    const auto& points = json.at("control_points");
    if (points.size() != 4) throw Failure("control_points has to have four points");
    for (std::size_t k = 0; k < 4; ++k) {
        if (points.at(k).size() != 2) throw Failure("a control point has two numbers");
        for (std::size_t axis = 0; axis < 2; ++axis)
            one.curve.points[k][axis] = number_of(points.at(k).at(axis), "control_points");
    }
    one.options.scale_free = false;
    one.options.degree = count_of(json, "degree", 100);
    if (json.at("weights").size() != 2) throw Failure("weights has to have two numbers");
    one.options.value_weight = number_of(json.at("weights").at(0), "weights");
    one.options.slope_weight = number_of(json.at("weights").at(1), "weights");
    one.options.conditions = FitCondition::none;
    for (const auto& name : json.at("conditions"))
        one.options.conditions = one.options.conditions | condition_of(name.get<std::string>());
    one.knots = json.at("knots");
    if (json.contains("note")) one.note = json.at("note").get<std::string>();
}

void solve_case(Case& one) {
    require(cageform::check(one.curve).status, "control_points");
    const auto mode = one.knots.at("mode").get<std::string>();
    const std::size_t pieces = count_of(one.knots, "pieces", most_pieces);
    std::vector<double> parameters;
    if (mode == "uniform_x") {
        parameters = cageform::uniform_in_time(one.curve, pieces);
    } else if (mode == "uniform_t") {
        parameters = cageform::uniform_in_parameter(pieces);
    } else if (mode == "given") {
        parameters = parameters_at(one.curve, one.knots.at("x").get<std::vector<double>>(), "knots.x");
        if (parameters.size() != pieces + 1) throw Failure("knots.x has to have pieces + 1 times");
    } else if (mode == "search_t") {
        ProgressBar bar("knots of " + one.id);
        const auto search = cageform::search_knots(
            one.curve, cageform::uniform_in_parameter(count_of(one.knots, "K", most_candidates)), pieces,
            {one.options}, {.progress = bar.callback()});
        require(search.status(), "knots");
        parameters = search.value.parameters;
        one.search_index = search.value.indices;
    } else {
        throw Failure("unknown mode of knots \"" + mode + "\"");
    }
    one.fitted = cageform::fit_pieces(one.curve, parameters, one.options);
    require(one.fitted.status(), "no fit");
}

/// The coefficients of x^d, …, 1 of a piece, by expanding powers of x − begin in long double.
std::vector<double> power_of_time(const BezierFit& fit, std::size_t piece) {
    const auto b = fit.coefficients(piece);
    const std::size_t d = fit.degree;
    const long double begin = fit.knots[piece], h = fit.knots[piece + 1] - begin;
    std::vector<long double> local(b.begin(), b.end()), power(d + 1, 0), product{1};
    long double binomial = 1;                          // d over n
    for (std::size_t order = 0; order <= d; ++order) { // forward differences, of powers of (x − begin) / h
        for (std::size_t i = d; i > order; --i) local[i] -= local[i - 1];
    }
    for (std::size_t n = 0; n <= d; ++n) { // product: (x − begin)ⁿ / hⁿ
        for (std::size_t k = 0; k <= n; ++k) power[k] += binomial * local[n] * product[k];
        product.push_back(0);
        for (std::size_t k = n + 1; k > 0; --k) product[k] = (product[k - 1] - begin * product[k]) / h;
        product[0] *= -begin / h;
        binomial = binomial * static_cast<long double>(d - n) / static_cast<long double>(n + 1);
    }
    return {power.rbegin(), power.rend()};
}

Json to_json(const Case& one) {
    Json json;
    json["id"] = one.id;
    for (const auto& p : one.curve.points) json["control_points"].push_back({p[0], p[1]});
    json["degree"] = one.options.degree;
    json["weights"] = {one.options.value_weight, one.options.slope_weight};
    if (one.options.scale_free) json["weights_scale_free"] = true;
    json["conditions"] = Json::array();
    for (const auto& known : condition_names) {
        if (cageform::contains(one.options.conditions, known.condition))
            json["conditions"].push_back(known.name);
    }
    if (!one.note.empty()) json["note"] = one.note;
    json["knots"] = one.knots;
    Json result;
    const auto& [fit, report] = one.fitted;
    result["knots_x"] = fit.knots;
    result["knots_t"] = fit.parameters;
    if (!one.search_index.empty()) result["search_index"] = one.search_index;
    double largest = 0;
    for (const double b : fit.bernstein) largest = std::max(largest, std::fabs(b));
    for (std::size_t i = 0; i < fit.pieces(); ++i) {
        const auto b = fit.coefficients(i);
        result["bernstein"].push_back(std::vector<double>(b.begin(), b.end()));
        result["power_x"].push_back(power_of_time(fit, i));
    }
    result["l2_error"] = report.l2_error;
    result["h1_semi_error"] = report.slope_error; // infinity is written as null
    result["w12_error"] = report.w12_error();
    result["sup_error"] = report.sup_error;
    const bool exact = report.sup_error <= 8 * cageform::epsilon<double> * largest;
    result["sup_at_x"] = exact ? Json(nullptr) : Json(report.sup_at);
    result["free_coefficients"] = fit.free_coefficients;
    json["result"] = result;
    return json;
}

std::vector<Case> run_cases(const std::string& path) {
    Json json = read_json(path);
    if (!json.is_object() || json.value("format", Json()) != "bezier-sobolev-cases/1" ||
        !json.value("cases", Json()).is_array())
        throw Failure(path + ": is not of the format bezier-sobolev-cases/1");
    std::vector<Case> cases;
    for (const auto& entry : json["cases"]) {
        Case& one = cases.emplace_back();
        one.id = "number " + std::to_string(cases.size());
        try {
            one.id = entry.at("id").get<std::string>();
            read_case(entry, one);
            solve_case(one);
        } catch (const Failure& error) {
            throw Failure(path + ": case " + one.id + ": " + error.what());
        } catch (const Json::exception& error) {
            throw Failure(path + ": case " + one.id + ": " + plain(error));
        }
    }
    return cases;
}

// ---- the plot ------------------------------------------------------------------------------------

/// A rectangle of a plot: axes with numbers, and lines in them.
class Panel {
public:
    Panel(double left, double top, double width, double height, std::array<double, 2> x,
          std::array<double, 2> y)
        : left_(left)
        , top_(top)
        , width_(width)
        , height_(height)
        , x_{x[0], x[1], left, left + width}
        , y_{y[0], y[1], top + height, top} {}

    double at_x(double x) const { return x_.at(x); }
    double at_y(double y) const { return y_.at(y); }

    static std::string text(double x, double y, const char* anchor, const std::string& words, int size,
                            const char* more = "") {
        return "<text x=\"" + text_of("%.1f", x) + "\" y=\"" + text_of("%.1f", y) + "\" text-anchor=\"" +
               anchor + "\" font-size=\"" + std::to_string(size) + "\" " + more + ">" + words + "</text>\n";
    }
    static std::string line(double xa, double ya, double xb, double yb, const std::string& style) {
        return "<path d=\"M" + text_of("%.2f", xa) + "," + text_of("%.2f", ya) + " L" + text_of("%.2f", xb) +
               "," + text_of("%.2f", yb) + "\" " + style + "/>\n";
    }

    /// Grid lines at round numbers, with labels.
    std::string axes(const std::string& y_title) const {
        std::string svg;
        for (const auto& [x, number] : marks_of(x_, 10)) {
            svg += line(at_x(x), top_, at_x(x), top_ + height_, "stroke=\"#e3e3e3\"");
            svg += text(at_x(x), top_ + height_ + 17, "middle", number, 12);
        }
        for (const auto& [y, number] : marks_of(y_, 6)) {
            svg += line(left_, at_y(y), left_ + width_, at_y(y),
                        y == 0 ? "stroke=\"#a8a8a8\"" : "stroke=\"#e3e3e3\"");
            svg += text(left_ - 8, at_y(y) + 4, "end", number, 12);
        }
        svg += "<rect x=\"" + text_of("%.1f", left_) + "\" y=\"" + text_of("%.1f", top_) + "\" width=\"" +
               text_of("%.1f", width_) + "\" height=\"" + text_of("%.1f", height_) +
               "\" fill=\"none\" stroke=\"#8a8a8a\"/>\n";
        svg += text(left_ + width_ / 2, top_ + height_ + 36, "middle", "time", 13);
        svg += text(left_, top_ - 10, "start", y_title, 13);
        return svg;
    }
    std::string polyline(const std::vector<std::array<double, 2>>& points, const std::string& style) const {
        std::string path;
        for (const auto& [x, y] : points)
            path += (path.empty() ? "M" : " L") + text_of("%.2f", at_x(x)) + "," + text_of("%.2f", at_y(y));
        return "<path d=\"" + path + "\" fill=\"none\" stroke-linejoin=\"round\" " + style + "/>\n";
    }
    std::string dot(double x, double y, const std::string& style) const {
        return "<circle cx=\"" + text_of("%.2f", at_x(x)) + "\" cy=\"" + text_of("%.2f", at_y(y)) + "\" " +
               style + "/>\n";
    }

private:
    double left_, top_, width_, height_;
    Axis x_, y_;
};

constexpr std::array<const char*, 2> colours{"#c8553d", "#1b6ca8"}; // of pieces, alternating
const std::string knot_style = "r=\"4.5\" fill=\"white\" stroke=\"#202020\" stroke-width=\"1.6\"";

/// Polylines of time and value.
struct Lines {
    std::vector<std::array<double, 2>> curve;
    std::vector<std::vector<std::array<double, 2>>> pieces, errors;
    std::array<double, 2> range; // of curve and pieces
};

Lines lines_of(const Case& one) {
    const cageform::BezierFunction function(one.curve);
    const BezierFit& fit = one.fitted.value;
    Lines drawn;
    drawn.pieces.resize(fit.pieces());
    drawn.errors.resize(fit.pieces());
    auto& range = drawn.range;
    range = {one.curve.points[0][1], one.curve.points[0][1]};
    constexpr std::size_t samples = 240; // per piece
    for (std::size_t i = 0; i < fit.pieces(); ++i) {
        for (std::size_t n = 0; n <= samples; ++n) {
            // Steps of the parameter are small at the ends, where tangents may be vertical.
            const double s = 0.5 - 0.5 * std::cos(3.141592653589793 * double(n) / samples);
            const double t = (1 - s) * fit.parameters[i] + s * fit.parameters[i + 1];
            const double part = std::fmin(std::fmax(function.time()(t), 0), 1);
            const double x = one.curve.begin() + function.length() * part;
            const double y = one.curve.points[0][1] + function.value()(t);
            const double u =
                std::fmin(std::fmax((x - fit.knots[i]) / (fit.knots[i + 1] - fit.knots[i]), 0), 1);
            const double fitted = fit.in_piece(i, u);
            drawn.curve.push_back({x, y});
            drawn.pieces[i].push_back({x, fitted});
            drawn.errors[i].push_back({x, y - fitted});
            range = {std::min({range[0], y, fitted}), std::max({range[1], y, fitted})};
        }
    }
    if (range[0] == range[1]) range = {range[0] - 1, range[1] + 1};
    return drawn;
}

std::string draw_values(const Panel& above, const BezierFit& fit, const Lines& drawn) {
    std::string svg = above.axes("value");
    svg += above.polyline(drawn.curve, "stroke=\"#c9c9c9\" stroke-width=\"9\" stroke-linecap=\"round\"");
    for (std::size_t i = 0; i < fit.pieces(); ++i)
        svg += above.polyline(drawn.pieces[i],
                              std::string("stroke=\"") + colours[i % 2] + "\" stroke-width=\"2.2\"");
    for (std::size_t i = 0; i <= fit.pieces(); ++i) {
        const double y = i < fit.pieces() ? drawn.pieces[i].front()[1] : drawn.pieces.back().back()[1];
        svg += above.dot(fit.knots[i], y, knot_style);
    }
    return svg;
}

/// Draws the errors and their bound.
///
///   reach   the largest value of the axis
std::string draw_errors(const Panel& below, const Case& one, const Lines& drawn, double reach) {
    const auto& [fit, report] = one.fitted;
    std::string svg = below.axes("error: curve minus pieces");
    for (std::size_t i = 1; i < fit.pieces(); ++i)
        svg += Panel::line(below.at_x(fit.knots[i]), below.at_y(-reach), below.at_x(fit.knots[i]),
                           below.at_y(reach), "stroke=\"#8a8a8a\" stroke-dasharray=\"1 3\"");
    for (const double sign : {1.0, -1.0}) {
        const double y = below.at_y(sign * report.sup_error);
        svg += Panel::line(below.at_x(one.curve.begin()), y, below.at_x(one.curve.end()), y,
                           "stroke=\"#7a4a9a\" stroke-width=\"1.4\" stroke-dasharray=\"7 4\"");
    }
    svg += Panel::text(below.at_x(one.curve.end()), below.at_y(reach) - 10, "end",
                       "± largest error " + text_of("%.4g", report.sup_error), 13, "fill=\"#7a4a9a\"");
    for (std::size_t i = 0; i < fit.pieces(); ++i)
        svg += below.polyline(drawn.errors[i],
                              std::string("stroke=\"") + colours[i % 2] + "\" stroke-width=\"1.8\"");
    return svg;
}

/// The legend, in the row of the upper title.
std::string draw_legend() {
    std::string svg;
    double at = 870;
    const auto entry = [&](double width, const std::string& words, const std::string& sign) {
        at -= width;
        svg += "<g transform=\"translate(" + text_of("%.0f", at) + ",56)\">" + sign + "</g>\n";
        svg += Panel::text(at + 40, 60, "start", words, 13);
    };
    entry(92, "knots", "<circle cx=\"26\" " + knot_style + "/>");
    entry(112, "pieces",
          std::string("<path d=\"M0,0 h17\" stroke-width=\"2.2\" stroke=\"") + colours[0] +
              "\"/><path d=\"M17,0 h17\" stroke-width=\"2.2\" stroke=\"" + colours[1] + "\"/>");
    entry(106, "curve",
          "<path d=\"M3,0 h28\" stroke=\"#c9c9c9\" stroke-width=\"9\" stroke-linecap=\"round\"/>");
    return svg;
}

std::string plot(const Case& one) {
    const auto& [fit, report] = one.fitted;
    const Lines drawn = lines_of(one);
    const double margin = 0.06 * (drawn.range[1] - drawn.range[0]);
    const std::array<double, 2> times{one.curve.begin(), one.curve.end()};
    const double reach = report.sup_error > 0 ? 1.25 * report.sup_error : 1e-16;
    const Panel above(90, 70, 780, 400, times, {drawn.range[0] - margin, drawn.range[1] + margin});
    const Panel below(90, 560, 780, 220, times, {-reach, reach});
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 900 856\" width=\"900\" "
                      "height=\"856\" font-family=\"DejaVu Sans, sans-serif\" fill=\"#202020\">\n"
                      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    svg += Panel::text(450, 28, "middle",
                       detail::escaped(one.id) + ": " + std::to_string(fit.pieces()) +
                           (fit.pieces() == 1 ? " piece" : " pieces") + " of degree " +
                           std::to_string(fit.degree),
                       17);
    svg += draw_values(above, fit, drawn) + draw_errors(below, one, drawn, reach) + draw_legend();
    svg +=
        Panel::text(90, 838, "start",
                    "W12 error " + text_of("%.6g", report.w12_error()) + ", L2 " +
                        text_of("%.6g", report.l2_error) + ", slope " + text_of("%.6g", report.slope_error),
                    13);
    return svg + "</svg>\n";
}

void print_table(const Case& one) {
    const auto& [fit, report] = one.fitted;
    std::printf("%-6s %16s %10s   coefficients (Bernstein)\n", "piece", "from time", "parameter");
    for (std::size_t i = 0; i < fit.pieces(); ++i) {
        std::printf("%-6zu %16.9g %10.6f  ", i, fit.knots[i], fit.parameters[i]);
        for (const double b : fit.coefficients(i)) std::printf(" %13.9g", b);
        std::printf("\n");
    }
    std::printf("%-6s %16.9g %10.6f\n", "end", fit.knots.back(), 1.0);
    std::printf(
        "largest error %.6g at time %.6g; W12 error %.6g (L2 %.6g, slope %.6g); free coefficients %zu\n",
        report.sup_error, report.sup_at, report.w12_error(), report.l2_error, report.slope_error,
        fit.free_coefficients);
}

// ---- the command line ----------------------------------------------------------------------------

struct Arguments {
    std::string bezier, css, lottie, lottie_curve, knots, conditions = "end_value,knot_value", norm = "w12";
    std::string cases, json, plot;
    std::size_t pieces = 0, degree = 3;
    double tolerance = 0;
    bool has_tolerance = false, in_units = false, png = false;
};

BezierCurve css_curve(const std::string& text) {
    const std::string_view words = detail::trim(text);
    if (words.find_first_of("0123456789+-.") == 0) { // four numbers
        const auto n = numbers("--css", text, 4);
        return {{{{0, 0}, {n[0], n[1]}, {n[2], n[3]}, {1, 1}}}};
    }
    const auto easing = cageform::parse_css_easing(words);
    if (easing) return easing.value;
    for (const std::string_view other : {"steps(", "step-start", "step-end", "linear("}) {
        if (words.starts_with(other))
            throw Failure("--css: " + std::string(words) +
                          ": holds and straight lines need no fit; use keys of kind hold and linear");
    }
    if (easing.status() != Status::input_malformed)
        throw Failure("--css: " + std::string(words) + ": " +
                      (easing.status() == Status::handle_not_allowed ? "x1 and x2 lie between 0 and 1"
                                                                     : cageform::to_string(easing.status())));
    throw Failure("--css: \"" + std::string(words) +
                  "\" is not an easing: write linear, ease, ease-in, ease-out, ease-in-out, " +
                  "cubic-bezier(x1, y1, x2, y2) or x1,y1,x2,y2" +
                  (words.starts_with("cubic-bezier")
                       ? "; character " + std::to_string(easing.report.error_at + 1) + " is not expected"
                       : ""));
}

BezierCurve bezier_curve(const std::string& text) {
    BezierCurve curve;
    const auto n = numbers("--bezier", text, 8);
    for (std::size_t k = 0; k < 4; ++k) curve.points[k] = {n[2 * k], n[2 * k + 1]};
    return curve;
}

std::vector<LottieCurve> read_lottie(const std::string& path) {
    const Json file = read_json(path);
    try {
        auto curves = lottie_curves(file);
        if (curves.empty()) throw Failure(path + ": no animated values");
        return curves;
    } catch (const std::length_error& error) {
        throw Failure(path + ": " + error.what());
    } catch (const Json::exception& error) {
        throw Failure(path + ": invalid Lottie keyframe: " + plain(error));
    }
}

BezierCurve lottie_curve(const Arguments& given) {
    for (const LottieCurve& one : read_lottie(given.lottie)) {
        if (one.path != given.lottie_curve) continue;
        require(one.curve.status(), given.lottie + ": " + one.path);
        if (one.curve.value.kind == cageform::KeyKind::hold)
            throw Failure(given.lottie + ": " + one.path + ": the value is held; there is no curve to fit");
        return one.curve.value.curve;
    }
    throw Failure(given.lottie + ": there is no curve \"" + given.lottie_curve +
                  "\"; leave out --curve to list all");
}

/// The curve of --bezier, --css or --lottie, and its name.
void read_curve(const Arguments& given, Case& one) {
    if (!given.bezier.empty()) {
        one.id = "Bézier curve " + given.bezier;
        one.curve = bezier_curve(given.bezier);
    } else if (!given.css.empty()) {
        one.curve = css_curve(given.css);
        one.id = given.css.find_first_of("abcdefghijklmnopqrstuvwxyz") == std::string::npos
                     ? "cubic-bezier(" + given.css + ")"
                     : given.css;
    } else {
        one.curve = lottie_curve(given);
        one.id =
            printable(std::filesystem::path(given.lottie).filename().string()) + ", " + given.lottie_curve;
    }
    require(cageform::SobolevFitter(one.curve, {}).status(), !given.bezier.empty() ? "--bezier"
                                                             : !given.css.empty()  ? "--css"
                                                                                   : "--curve");
}

FitOptions options_of(const Arguments& given) {
    FitOptions options;
    options.degree = given.degree;
    options.scale_free = !given.in_units;
    options.conditions = FitCondition::none;
    for (const std::string& name : split(given.conditions))
        options.conditions = options.conditions | condition_of(name);
    if (given.norm == "l2") {
        options.slope_weight = 0;
    } else if (given.norm == "sup") {
        options.norm = cageform::FitNorm::sup;
    } else if (given.norm != "w12") {
        const auto weights = numbers("--norm", given.norm, 2);
        options.value_weight = weights[0];
        options.slope_weight = weights[1];
    }
    return options;
}

/// Knots for a number of pieces, by the method of --knots.
std::vector<double> knots_of(const Arguments& given, const Case& one, std::size_t pieces) {
    if (given.knots == "uniform") return cageform::uniform_in_time(one.curve, pieces);
    if (given.knots == "arcs") return cageform::uniform_in_parameter(pieces);
    ProgressBar bar("knots of " + std::to_string(pieces) + " pieces");
    const auto search =
        cageform::optimal_knots(one.curve, pieces, {one.options}, {.progress = bar.callback()});
    require(search.status(), "--knots optimal");
    return search.value.parameters;
}

/// Fits the fewest pieces within --tolerance.
void fit_within_tolerance(const Arguments& given, Case& one) {
    if (given.knots.empty()) {
        ProgressBar bar("pieces");
        one.fitted = cageform::fit(one.curve, given.tolerance, one.options, {.progress = bar.callback()});
    }
    for (std::size_t pieces = 1; !given.knots.empty() && pieces <= one.options.max_pieces; ++pieces) {
        one.fitted = cageform::fit_pieces(one.curve, knots_of(given, one, pieces), one.options);
        Status& status = one.fitted.report.status;
        if (status == Status::ok && one.fitted.report.sup_error <= given.tolerance) break;
        if (status == Status::ok && pieces == one.options.max_pieces) status = Status::tolerance_not_met;
        if (status == Status::too_many_conditions) continue; // needs more pieces
        if (status != Status::ok) break;
    }
    require(one.fitted.status(), "--tolerance " + text_of("%g", given.tolerance));
}

Case run_one(const Arguments& given) {
    Case one;
    read_curve(given, one);
    one.options = options_of(given);
    const bool named =
        given.knots.empty() || given.knots == "uniform" || given.knots == "arcs" || given.knots == "optimal";
    if (int(given.pieces > 0) + int(given.has_tolerance) + int(!named) != 1)
        throw Failure("choose the number of pieces with one of --pieces, --tolerance and --knots with times");
    if (given.has_tolerance && !(given.tolerance > 0)) require(Status::tolerance_not_positive, "--tolerance");
    const std::string mode = given.knots == "uniform" ? "uniform_x"
                             : given.knots == "arcs"  ? "uniform_t"
                                                      : "optimal";
    if (!named) {
        const auto times = numbers("--knots", given.knots, 0);
        one.fitted = cageform::fit_pieces(one.curve, parameters_at(one.curve, times, "--knots"), one.options);
        require(one.fitted.status(), "--knots");
        one.knots = {{"mode", "given"}, {"pieces", times.size() - 1}, {"x", times}};
    } else if (!given.has_tolerance) {
        one.fitted = cageform::fit_pieces(one.curve, knots_of(given, one, given.pieces), one.options);
        require(one.fitted.status(), "no fit of " + std::to_string(given.pieces) + " pieces");
        one.knots = {{"mode", mode}, {"pieces", given.pieces}};
    } else {
        fit_within_tolerance(given, one);
        one.knots = {{"mode", given.knots.empty() ? "tolerance" : mode},
                     {"pieces", one.fitted.value.pieces()},
                     {"tolerance", given.tolerance}};
    }
    return one;
}

/// Returns the option --tolerance.
CommandOption add_options(CommandLine& line, Arguments& given) {
    line.add("--bezier", given.bezier,
             "x0,y0,x1,y1,x2,y2,x3,y3: keys and handles (--bezier=-1,… if negative)");
    line.add("--css", given.css,
             "a CSS easing, from (0, 0) to (1, 1): linear, ease, ease-in, ease-out, ease-in-out, "
             "'cubic-bezier(x1, y1, x2, y2)', or the four numbers alone");
    line.add("--lottie", given.lottie,
             "a Lottie file: list its animated values, or fit the one given by --curve");
    line.add("--curve", given.lottie_curve, "the name of the curve in the list");
    line.add("--cases", given.cases, "a JSON file of curves (bezier-sobolev-cases/1); needs --json");
    line.add("--pieces", given.pieces, "the number of polynomials").range(1, int(most_pieces));
    const CommandOption tolerance =
        line.add("--tolerance", given.tolerance,
                 "the largest error, in units of the value; the fewest pieces that meet it are used");
    line.add("--degree", given.degree, "3, 4 or 5").show_default();
    line.add("--knots", given.knots,
             "where pieces meet: optimal (the default), uniform (in time), arcs (of the curve's parameter), "
             "or a list of times that includes both keys");
    line.add("--conditions", given.conditions,
             "the conditions, any of end_value, knot_c0, knot_value, end_d1, knot_c1, knot_d1, end_d2, "
             "knot_c2, knot_d2")
        .show_default();
    line.add("--norm", given.norm,
             "the norm to minimise: w12, l2, sup, or W0,W1, the weights of value and slope")
        .show_default();
    line.add_flag("--in-units", given.in_units,
                  "apply the weights in the curve's unit of time, not on an interval of length 1");
    line.add("--json", given.json, "the JSON file to write").ends_with({".json"});
    line.add("--plot", given.plot, "the SVG file to draw to").ends_with({".svg"});
    line.add_flag("--png", given.png, "also render the plot, to the same name with .png");
    return tolerance;
}

/// Fails if options conflict.
void check_options(const Arguments& given) {
    if (given.png && given.plot.empty()) throw Failure("--png needs --plot");
    const int curves = int(!given.bezier.empty()) + int(!given.css.empty()) + int(!given.lottie.empty()) +
                       int(!given.cases.empty());
    if (curves != 1) throw Failure("a curve is given by one of --bezier, --css, --lottie and --cases");
    if (!given.lottie_curve.empty() && given.lottie.empty()) throw Failure("--curve needs --lottie");
    if (!given.lottie.empty() && given.lottie_curve.empty() && !(given.json.empty() && given.plot.empty()))
        throw Failure("--lottie needs --curve to fit one");
    if (!given.cases.empty() && (given.json.empty() || !given.plot.empty()))
        throw Failure("--cases needs --json and takes no --plot");
}

std::string results_of_cases(const Arguments& given) {
    Json all;
    all["format"] = "bezier-sobolev-cases/1";
    all["description"] = "results of fit_curve for " + printable(given.cases);
    all["cases"] = Json::array();
    for (const Case& one : run_cases(given.cases)) all["cases"].push_back(to_json(one));
    return all.dump(1) + "\n";
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Replaces a Bézier curve between two keys by a few polynomials in time.");
    line.set_examples({"--css ease-in-out --pieces 4 --plot curve.svg --png", "--lottie ball.json"});
    Arguments given;
    const CommandOption tolerance = add_options(line, given);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.has_tolerance = tolerance.is_given();
    check_options(given);
    if (!given.lottie.empty() && given.lottie_curve.empty()) {
        for (const LottieCurve& one : read_lottie(given.lottie))
            std::cout << printable(describe(one)) << '\n';
        return 0;
    }

    std::string json, svg;
    if (!given.cases.empty()) {
        json = results_of_cases(given);
    } else {
        const Case one = run_one(given);
        if (!given.json.empty()) json = to_json(one).dump(1) + "\n";
        if (!given.plot.empty()) svg = plot(one);
        if (json.empty() && svg.empty()) print_table(one);
    }
    OutputFiles outputs;
    if (!json.empty()) outputs.add(given.json).write(json);
    if (!svg.empty()) add_svg(outputs, given.plot, svg, given.png ? 1200 : 0);
    return commit(outputs);
}
