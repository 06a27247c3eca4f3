// Computes the tables of Izdebski 2019, ch. 6 (Bézier curves fitted in a Sobolev norm), and compares them
// with known numbers: captions of figures, Table 6.1, and results of two prototypes.
//
//     bezier_tables bezier_tables.csv
//
// Each row is printed twice: our values above the known values. The largest difference of each table follows
// at the end.

#include "cli/command_line.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/animate/fit.hpp>

#include <Eigen/LU>

#include <chrono>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace {

using namespace cageform_support;
using cageform::BezierCurve;
using cageform::fit_pieces;
using cageform::FitCondition;
using cageform::FitOptions;
using cageform::search_knots;
using cageform::Status;
using cageform::uniform_in_parameter;
using cageform::uniform_in_time;
using enum FitCondition;

constexpr std::array<const char*, 27> roman{
    "I",  "II",  "III",  "IV",    "V",   "VI", "VII", "VIII", "IX",    "X",    "XI",  "XII",  "XIII", "XIV",
    "XV", "XVI", "XVII", "XVIII", "XIX", "XX", "XXI", "XXII", "XXIII", "XXIV", "XXV", "XXVI", "XXVII"};

/// The rows of Table 6.1.
const std::array<FitCondition, 27> configurations = [] {
    const auto c0 = end_value | knot_c0, value = end_value | knot_value;
    return std::array{none,
                      c0,
                      value,
                      c0 | knot_c1,
                      value | knot_c1,
                      c0 | knot_d1,
                      value | knot_d1,
                      c0 | knot_c1 | knot_c2,
                      value | knot_c1 | knot_c2,
                      c0 | knot_c1 | knot_d2,
                      c0 | knot_d1 | knot_c2,
                      c0 | end_d1,
                      value | end_d1,
                      c0 | end_d1 | end_d2,
                      value | end_d1 | end_d2,
                      c0 | end_d1 | knot_c1,
                      value | end_d1 | knot_c1,
                      c0 | end_d1 | knot_d1,
                      value | end_d1 | knot_d1,
                      c0 | end_d1 | knot_c1 | end_d2,
                      value | end_d1 | knot_c1 | end_d2,
                      c0 | end_d1 | knot_d1 | end_d2,
                      c0 | end_d1 | knot_c1 | knot_c2,
                      value | end_d1 | knot_c1 | knot_c2,
                      c0 | end_d1 | knot_c1 | knot_d2,
                      c0 | end_d1 | knot_d1 | knot_c2,
                      c0 | end_d1 | knot_c1 | end_d2 | knot_c2};
}();
/// Returns the options of a configuration by its number.
FitOptions configuration(std::size_t number, std::size_t degree = 3) {
    FitOptions options;
    options.conditions = configurations[number - 1];
    options.degree = degree;
    return options;
}

BezierCurve bezier(double u1, double y1, double u2, double y2, double height = 1) {
    return {{{{0, 0}, {u1, height * y1}, {u2, height * y2}, {1, height}}}};
}
/// The ten test curves.
BezierCurve test_curve(std::size_t c, double height = 1) {
    constexpr std::array<std::array<double, 4>, 10> handles{{{0.65, 1, 0.80, 1},
                                                             {0.20, 1, 0.25, 1},
                                                             {0.80, 1, 0.20, 1},
                                                             {0.40, 0, 0.60, 1},
                                                             {0.85, 0, 0.15, 1},
                                                             {0.20, 1, 0.80, 0},
                                                             {0.80, 1, 0.20, 0},
                                                             {0.20, 1.3, 0.80, 1.3},
                                                             {0.80, 1.3, 0.20, 1.3},
                                                             {0.80, -0.3, 0.20, 1.3}}};
    const auto& h = handles[c];
    return bezier(h[0], h[1], h[2], h[3], height);
}

// ---- tables --------------------------------------------------------------------------------------

using Row = std::vector<double>;

/// The rows of each known table.
std::map<std::string, std::vector<Row>> known_tables;

/// Reads lines "TABLE,NUMBER,...". Returns the error; empty on success.
std::string read_known_tables(const std::string& path) {
    LineReader lines(path);
    detail::RowFilter rows;
    std::string_view line;
    while (lines.next(line)) {
        if (!rows.take(line)) continue;
        const auto cells = detail::cells_of(line);
        Row& row = known_tables[std::string(cells[0])].emplace_back(cells.size() - 1);
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string why = detail::parse_finite(cells[i + 1], row[i]);
            if (!why.empty()) return to_string(detail::row_fault(path, lines.line(), line, why));
        }
    }
    return lines.error();
}

/// Returns a row. Throws a Failure if the row is missing or has fewer than `least` numbers. The first
/// `counts` numbers of a row must be whole numbers from 0 to 100.
const Row& known(const std::string& table, std::size_t row, std::size_t least = 1, std::size_t counts = 0) {
    const auto& rows = known_tables[table];
    const auto fault = [&](const std::string& why) {
        return Failure("row " + std::to_string(row + 1) + " of table " + table + why);
    };
    if (row >= rows.size()) throw fault(" is missing");
    if (rows[row].size() < least) throw fault(" has fewer than " + std::to_string(least) + " numbers");
    for (std::size_t i = 0; i < counts; ++i) {
        const double count = rows[row][i];
        if (!(count >= 0 && count <= 100 && count == std::floor(count)))
            throw fault(": number " + std::to_string(i + 1) + " is not a whole number from 0 to 100");
    }
    return rows[row];
}

/// f(1), …, f(n).
template <class F>
Row row_of(std::size_t n, const F& f) {
    Row row;
    for (std::size_t i = 1; i <= n; ++i) row.push_back(f(i));
    return row;
}

/// The summaries of all tables, in the order of their construction.
std::vector<std::string> summaries;

/// Prints a table, ours above theirs. Its destructor adds a summary with the largest difference.
class Table {
public:
    Table(std::string name, std::string what, int decimals, bool sampled = false)
        : name_(std::move(name))
        , decimals_(decimals)
        , sampled_(sampled)
        , number_(summaries.size()) {
        summaries.emplace_back();
        std::printf("\n== %s: %s\n", name_.c_str(), what.c_str());
    }
    Table(const Table&) = delete;
    Table& operator=(const Table&) = delete;
    ~Table() { summaries[number_] = summary(); }
    template <class Theirs>
    void row(const std::string& label, const Row& ours, const Theirs& theirs) {
        if (theirs.size() < ours.size()) throw std::runtime_error(name_ + ": a known row is too short");
        std::printf("%-14s", label.c_str());
        for (const double x : ours) std::printf(" %10.*f", decimals_, x);
        std::printf("\n%-14s", "");
        for (const double x : theirs) std::printf(" %10.*f", decimals_, x);
        std::printf("\n");
        for (std::size_t i = 0; i < ours.size(); ++i, ++count_) {
            const double d = std::fabs(ours[i] - theirs[i]);
            if (d <= largest_) continue;
            largest_ = d;
            where_ = label + ", column " + std::to_string(i + 1);
        }
    }

private:
    /// "8.2.1   70 numbers   largest difference 5.0e-07 (half a last digit: 5e-07)".
    std::string summary() const {
        const double half = 0.5 * std::pow(10.0, -decimals_);
        std::string result =
            formatted("%-22s %4zu numbers, largest difference %8.2e %s", name_.c_str(), count_, largest_,
                      sampled_                   ? "(another sample)"
                      : largest_ <= 1.001 * half ? "(all digits)"
                                                 : "");
        if (!sampled_ && largest_ > 1.001 * half) result += "(" + where_ + ")";
        return result;
    }

    std::string name_;
    int decimals_;
    bool sampled_;
    std::size_t number_;
    double largest_ = 0;
    std::size_t count_ = 0;
    std::string where_;
};

std::string curve_name(std::size_t c) {
    return "F" + std::to_string(c + 1);
}

/// The W12 error of a fit; ends the program if the fit fails.
double error_at(const BezierCurve& curve, const std::vector<double>& parameters, const FitOptions& options) {
    const auto fit = fit_pieces(curve, parameters, options);
    if (!fit) throw std::runtime_error(cageform::to_string(fit.status()));
    return fit.report.w12_error();
}
/// Fits at the best knots among candidates.
double searched_error(const BezierCurve& curve, const std::vector<double>& candidates, std::size_t pieces,
                      const FitOptions& options) {
    const auto search = search_knots(curve, candidates, pieces, {options});
    if (!search) throw std::runtime_error(cageform::to_string(search.status()));
    return error_at(curve, search.value.parameters, options);
}

double median(Row values) {
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}
double share_below(const Row& values, double limit) {
    return 100 * double(std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; })) /
           double(values.size());
}

/// SplitMix64, as the tests' random numbers.
class Random {
public:
    double uniform() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }
    std::size_t below(std::size_t n) { return std::size_t(uniform() * double(n)); }

private:
    std::uint64_t state_ = 1;
};

/// The W12 error of the natural cubic spline through a curve's points, for an interval of length 1.
double natural_spline_error(const BezierCurve& curve, const std::vector<double>& parameters) {
    const cageform::SobolevFitter fitter(curve, configuration(3));
    const std::size_t n = parameters.size() - 1;
    std::vector<cageform::SobolevFitter::Piece> pieces;
    for (std::size_t i = 0; i < n; ++i) pieces.push_back(fitter.fit_piece(parameters[i], parameters[i + 1]));
    // Second derivatives m at the knots; 0 at the keys.
    const auto h = [&](std::size_t i) { return pieces[i].x_end - pieces[i].x_begin; };
    const auto y = [&](std::size_t i) {
        return i < n ? pieces[i].polynomial.c[0] : pieces[n - 1].polynomial.c[3];
    };
    Eigen::MatrixXd a = Eigen::MatrixXd::Identity(long(n + 1), long(n + 1));
    Eigen::VectorXd right = Eigen::VectorXd::Zero(long(n + 1));
    for (std::size_t i = 1; i < n; ++i) {
        const long k = long(i);
        a(k, k - 1) = h(i - 1);
        a(k, k) = 2 * (h(i - 1) + h(i));
        a(k, k + 1) = h(i);
        right(k) = 6 * ((y(i + 1) - y(i)) / h(i) - (y(i) - y(i - 1)) / h(i - 1));
    }
    const Eigen::VectorXd m = a.partialPivLu().solve(right);
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double d = h(i), begin = y(i), end = y(i + 1), mb = m(long(i)), me = m(long(i) + 1);
        auto& c = pieces[i].polynomial.c;
        c[1] = (2 * begin + end) / 3 - d * d * (2 * mb + me) / 18;
        c[2] = (begin + 2 * end) / 3 - d * d * (mb + 2 * me) / 18;
        c[0] = begin;
        c[3] = end;
        sum += fitter.cost(pieces[i]);
    }
    return std::sqrt(fitter.in_units(sum));
}

void captions_and_sup_errors() {
    const auto candidates = uniform_in_parameter(30);
    Table errors("Figs 5.7-5.16", "W12 errors, values times 10, K = 30 steps of t, 1 ... 6 pieces", 6);
    std::array<Row, 10> w12, sup;
    for (std::size_t c = 0; c < 10; ++c) {
        for (std::size_t n = 1; n <= 8; ++n) {
            const auto curve = test_curve(c, 10);
            const auto fit =
                fit_pieces(curve, search_knots(curve, candidates, n, {configuration(2)}).value.parameters,
                           configuration(2));
            w12[c].push_back(fit.report.w12_error());
            sup[c].push_back(fit.report.sup_error / 10);
        }
        errors.row(curve_name(c), Row(w12[c].begin(), w12[c].begin() + 6), known("captions", c));
    }
    Table largest("8.1 sup errors", "of the same fits, values as they are, 1 ... 8 pieces", 6);
    for (std::size_t c = 0; c < 10; ++c) largest.row(curve_name(c), sup[c], known("sup_errors", c));
    Table needed("8.1 pieces needed", "sup <= 1/256, 0.0011598, 1/1920; W12 <= 0.125, 0.0125", 0);
    for (std::size_t c = 0; c < 10; ++c) {
        Row row;
        const auto first_below = [&](const Row& all, double limit) {
            const auto at = std::find_if(all.begin(), all.end(), [&](double e) { return e <= limit; });
            row.push_back(double(at - all.begin()) + 1);
        };
        for (const double limit : {1.0 / 256, 0.0011598, 1.0 / 1920}) first_below(sup[c], limit);
        for (const double limit : {1.25, 0.125}) first_below(w12[c], limit); // values are times 10
        needed.row(curve_name(c), row, known("pieces_needed", c));
    }
}

void knots() {
    const auto rows = [](Table& table, std::size_t n, const char* theirs, const auto& parameters) {
        for (std::size_t c = 0; c < 10; ++c) {
            const auto error = [&](std::size_t pieces) {
                return error_at(test_curve(c), parameters(test_curve(c), pieces), configuration(2));
            };
            table.row(curve_name(c), row_of(n, error), known(theirs, c));
        }
    };
    Table by_time("8.2.1", "uniform in time, 1 ... 7 pieces", 6);
    rows(by_time, 7, "uniform_time", uniform_in_time);
    Table by_parameter("8.2.2", "uniform in the parameter, 1 ... 7 pieces", 6);
    rows(by_parameter, 7, "uniform_parameter",
         [](const BezierCurve&, std::size_t n) { return uniform_in_parameter(n); });
    Table brute("8.2.3", "brute force, error against K, F1 ... F10", 5);
    for (std::size_t r = 0; r < 30; ++r) {
        const Row& theirs = known("brute_force", r, 13, 3);
        const auto pieces = std::size_t(theirs[0]), steps = std::size_t(theirs[2]);
        Row row;
        for (std::size_t c = 0; c < 10; ++c) {
            const auto candidates =
                theirs[1] == 0 ? uniform_in_time(test_curve(c), steps) : uniform_in_parameter(steps);
            row.push_back(searched_error(test_curve(c), candidates, pieces, configuration(2)));
        }
        brute.row("N " + std::to_string(pieces) + (theirs[1] == 0 ? ", x, K " : ", t, K ") +
                      std::to_string(steps),
                  row, std::span(theirs).subspan(3));
    }
    Table ratio("8.2.4", "uniform t over brute force in t, F1 ... F10", 2);
    for (std::size_t r = 0; r < 12; ++r) {
        const Row& theirs = known("uniform_over_brute", r, 12, 2);
        const auto steps = std::size_t(theirs[0]), pieces = std::size_t(theirs[1]);
        Row row;
        for (std::size_t c = 0; c < 10; ++c)
            row.push_back(
                error_at(test_curve(c), uniform_in_parameter(pieces), configuration(2)) /
                searched_error(test_curve(c), uniform_in_parameter(steps), pieces, configuration(2)));
        ratio.row("K " + std::to_string(steps) + ", N " + std::to_string(pieces), row,
                  std::span(theirs).subspan(2));
    }
    Table best("8.2.5", "optimal knots, 1 ... 6 pieces", 6);
    rows(best, 6, "optimum", [](const BezierCurve& curve, std::size_t n) {
        return cageform::optimal_knots(curve, n, {configuration(2)}).value.parameters;
    });
}

void conditions() {
    const auto candidates = uniform_in_parameter(20);
    Row base;
    for (std::size_t c = 0; c < 10; ++c)
        base.push_back(searched_error(test_curve(c), candidates, 3, configuration(1)));
    Table absolute("Table 6.1, base", "3 pieces, K = 20 steps of t, no condition, F1 ... F10", 6);
    absolute.row("I", base, known("conditions_base", 0));
    Table percent("Table 6.1", "increase over the base in percent, F1 ... F10", 1);
    for (std::size_t n = 2; n <= 27; ++n) {
        Row row;
        for (std::size_t c = 0; c < 10; ++c)
            row.push_back(100 *
                          (searched_error(test_curve(c), candidates, 3, configuration(n)) / base[c] - 1));
        percent.row(roman[n - 1], row, known("conditions_percent", n - 2));
    }
}

void w12_against_sup() {
    // A random sample of the source's set of seven million.
    Row all;
    std::array<Row, 6> by_pieces;
    std::array<Row, 4> by_conditions;
    constexpr std::array<std::size_t, 4> numbers{2, 4, 8, 16};
    Row ys;
    for (int i = -10; i < 0; ++i) ys.push_back(0.1 * i);
    for (int i = 0; i < 20; ++i) ys.push_back(0.05 * i);
    for (int i = 10; i <= 20; ++i) ys.push_back(0.1 * i);
    Random random;
    while (all.size() < 29164) {
        const auto x = [&] { return 0.1 + 0.05 * double(random.below(17)); };
        const auto y = [&] { return ys[random.below(ys.size())]; };
        const double u1 = x(), y1 = y(), u2 = x(), y2 = y();
        const std::size_t pieces = 1 + random.below(6), which = random.below(4);
        const auto fit =
            fit_pieces(bezier(u1, y1, u2, y2), uniform_in_parameter(pieces), configuration(numbers[which]));
        if (!fit || fit.report.sup_error < 1e-12) continue; // a straight line
        const double ratio = fit.report.w12_error() / fit.report.sup_error;
        all.push_back(ratio);
        by_pieces[pieces - 1].push_back(ratio);
        by_conditions[which].push_back(ratio);
    }
    std::sort(all.begin(), all.end());
    double mean = 0;
    for (const double r : all) mean += r / double(all.size());
    Table table("8.4", "W12 over sup: least, median, mean, 95 %, largest, share above 20", 2, true);
    table.row(
        "all",
        {all.front(), median(all), mean, all[all.size() * 95 / 100], all.back(), 100 - share_below(all, 20)},
        Row{2.30, 11.0, 12.5, 25.8, 42.0, 15});
    constexpr std::array<std::array<double, 3>, 6> theirs{{{2.3, 5.7, 11.2},
                                                           {3.4, 8.4, 17.4},
                                                           {4.0, 11.5, 26.1},
                                                           {4.8, 14.0, 29.3},
                                                           {5.4, 16.7, 35.2},
                                                           {6.2, 19.0, 42.0}}};
    for (std::size_t n = 0; n < 6; ++n) {
        const auto [least, most] = std::minmax_element(by_pieces[n].begin(), by_pieces[n].end());
        table.row("N " + std::to_string(n + 1), {*least, median(by_pieces[n]), *most}, theirs[n]);
    }
    Row medians;
    for (const Row& values : by_conditions) medians.push_back(median(values));
    table.row("II IV VIII XVI", medians, Row{16.6, 15.1, 9.3, 7.2});
}

void inner_handles() {
    constexpr std::array<std::array<double, 2>, 4> outer{
        {{1. / 3, 2. / 3}, {1. / 6, 1. / 2}, {0, 1}, {-0.5, 1.5}}};
    const auto candidates = uniform_in_parameter(20);
    constexpr std::array<std::array<double, 2>, 5> their_shares{
        {{90.9, 92.0}, {89.9, 91.7}, {81.8, 85.0}, {72.7, 75.7}, {83.8, 86.1}}};
    Table shares("8.5", "inner functions: percent with W12 < 0.1, handles in steps of 0.1 and 0.05", 1);
    std::array<Row, 2> all;
    Row medians;
    for (std::size_t o = 0; o < 4; ++o) {
        Row row;
        for (const std::size_t steps : {10u, 20u}) {
            Row errors;
            for (std::size_t i = 0; i <= steps; ++i) {
                for (std::size_t j = 0; j <= steps; ++j) {
                    const double n = double(steps);
                    const auto curve = bezier(double(i) / n, outer[o][0], double(j) / n, outer[o][1]);
                    if (cageform::check(curve).vertical_tangent) continue;
                    errors.push_back(searched_error(curve, candidates, 3, configuration(2)));
                }
            }
            row.push_back(share_below(errors, 0.1));
            if (steps == 10) medians.push_back(median(errors));
            auto& sum = all[steps == 10 ? 0 : 1];
            sum.insert(sum.end(), errors.begin(), errors.end());
        }
        shares.row("outer " + std::to_string(o + 1), row, their_shares[o]);
    }
    shares.row("all", {share_below(all[0], 0.1), share_below(all[1], 0.1)}, their_shares[4]);
    Table middles("8.5 medians", "steps of 0.1, outer 1 ... 4", 4);
    middles.row("", medians, Row{0.0154, 0.0176, 0.0228, 0.0556});

    Table corners("8.5 corners", "L2 errors, outer (0, 1), K = 10: (0,0), (1,1), (1,0), (0,1)", 6);
    Row row;
    for (const auto& [a, b] : {std::array{0., 0.}, {1., 1.}, {1., 0.}, {0., 1.}}) {
        auto options = configuration(2);
        options.slope_weight = 0;
        const auto curve = bezier(a, 0, b, 1);
        const auto search = search_knots(curve, uniform_in_parameter(10), 3, {options});
        row.push_back(fit_pieces(curve, search.value.parameters, options).report.l2_error);
    }
    corners.row("", row, Row{0.001463, 0.001463, 0.008739, 0});
}

void outer_handles() {
    const auto candidates = uniform_in_parameter(20);
    constexpr std::array<std::array<double, 2>, 3> inner{
        {{1. / 6, 5. / 6}, {2. / 3, 1. / 3}, {2. / 3, 2. / 3}}};
    constexpr std::array<std::array<double, 2>, 3> found{
        {{0.1511, 0.0672}, {0.1077, 0.0447}, {0.0343, 0.0127}}};
    std::array<Row, 3> errors;
    for (std::size_t k = 0; k < 3; ++k) {
        for (int i = -10; i <= 20; ++i) {
            for (int j = -10; j <= 20; ++j) {
                const auto curve = bezier(inner[k][0], 0.1 * i, inner[k][1], 0.1 * j);
                errors[k].push_back(searched_error(curve, candidates, 3, configuration(2)));
            }
        }
    }
    Table below("8.6", "outer functions: percent with W12 < 0.1, inner 1 ... 3", 1);
    below.row("", {share_below(errors[0], 0.1), share_below(errors[1], 0.1), share_below(errors[2], 0.1)},
              Row{80.3, 99.4, 100});
    Table sizes("8.6 errors", "largest, median", 4);
    for (std::size_t k = 0; k < 3; ++k)
        sizes.row("inner " + std::to_string(k + 1),
                  {*std::max_element(errors[k].begin(), errors[k].end()), median(errors[k])}, found[k]);
}

void degrees_and_splines() {
    Table by_degree("8.7", "degrees 3, 4, 5 of each curve, K = 20 steps of t, 1 ... 4 pieces", 6);
    for (std::size_t r = 0; r < 30; ++r) {
        Row row;
        for (std::size_t n = 1; n <= 4; ++n)
            row.push_back(
                searched_error(test_curve(r / 3), uniform_in_parameter(20), n, configuration(3, 3 + r % 3)));
        by_degree.row(curve_name(r / 3) + ", degree " + std::to_string(3 + r % 3), row, known("degrees", r));
    }
    for (const bool in_time : {true, false}) {
        Table ratio(in_time ? "8.8 uniform in time" : "8.8 uniform in t",
                    "clamped spline over IX, over II, 1 ... 8 pieces", 2);
        for (std::size_t r = 0; r < 20; ++r) {
            Row row;
            const auto curve = test_curve(r / 2);
            for (std::size_t n = 1; n <= 8; ++n) {
                const auto t = in_time ? uniform_in_time(curve, n) : uniform_in_parameter(n);
                row.push_back(error_at(curve, t, configuration(24)) /
                              error_at(curve, t, configuration(r % 2 == 0 ? 9 : 2)));
            }
            ratio.row(curve_name(r / 2) + (r % 2 == 0 ? ", IX" : ", II"), row,
                      known(in_time ? "spline_ratio_time" : "spline_ratio_parameter", r));
        }
    }
    Table absolute("8.8 errors", "clamped, natural, IX, II, uniform in t, 1 ... 8 pieces", 6);
    constexpr std::array<const char*, 4> methods{"clamped", "natural", "IX", "II"};
    for (std::size_t r = 0; r < 40; ++r) {
        Row row;
        const auto curve = test_curve(r / 4);
        for (std::size_t n = 1; n <= 8; ++n) {
            const auto t = uniform_in_parameter(n);
            row.push_back(r % 4 == 1 ? natural_spline_error(curve, t)
                                     : error_at(curve, t,
                                                configuration(r % 4 == 0   ? 24
                                                              : r % 4 == 2 ? 9
                                                                           : 2)));
        }
        absolute.row(curve_name(r / 4) + ", " + methods[r % 4], row, known("spline_errors", r));
    }
}

void scales_of_time() {
    constexpr std::array<double, 10> lengths{0.1, 0.25, 0.5, 2, 5, 10, 20, 50, 100, 1000};
    constexpr std::array<std::array<double, 10>, 2> theirs{
        {{3.16, 2, 1.414, 0.708, 0.45, 0.33, 0.26, 0.22, 0.25, 0.71},
         {3.16, 2, 1.414, 0.708, 0.45, 0.33, 0.26, 0.26, 0.32, 0.93}}};
    Table scale("8.9",
                "W12 error in units over that of length 1, least and most of F1 ... F10 (theirs: of six "
                "curves), T = 0.1 ... 1000",
                3, true);
    Row least(10, 1e9), most(10, 0);
    for (std::size_t c = 0; c < 10; ++c) {
        for (std::size_t k = 0; k < 10; ++k) {
            auto options = configuration(2);
            options.scale_free = false;
            auto curve = test_curve(c);
            for (auto& p : curve.points) p[0] *= lengths[k];
            const auto t = uniform_in_parameter(3);
            const double ratio = error_at(curve, t, options) / error_at(test_curve(c), t, configuration(2));
            least[k] = std::min(least[k], ratio);
            most[k] = std::max(most[k], ratio);
        }
    }
    scale.row("least", least, theirs[0]);
    scale.row("most", most, theirs[1]);
}

void memory_of_pieces() {
    Table memory("8.10",
                 "random curves, degrees 3, 4, 5: mean pieces for 0.0125, size over Bezier's, % over 0.125",
                 2, true);
    constexpr std::array<std::array<double, 2>, 2> ranges{{{0, 1}, {-1, 2}}};
    constexpr std::array<std::array<double, 3>, 2> sizes{{{2.40, 2.14, 2.08}, {2.80, 2.40, 2.26}}};
    for (std::size_t r = 0; r < 2; ++r) {
        Random random;
        std::array<Row, 2> pieces{Row(3, 0), Row(3, 0)};
        constexpr std::size_t curves = 300;
        for (std::size_t k = 0; k < curves; ++k) {
            const auto y = [&] { return ranges[r][0] + (ranges[r][1] - ranges[r][0]) * random.uniform(); };
            const double u1 = random.uniform(), y1 = y(), u2 = random.uniform(), y2 = y();
            const auto curve = bezier(u1, y1, u2, y2);
            for (std::size_t degree = 3; degree <= 5; ++degree) {
                std::size_t n = 1;
                for (std::size_t limit = 0; limit < 2; ++limit) { // 0.125, then 0.0125
                    while (n < 20 && searched_error(curve, uniform_in_parameter(20), n,
                                                    configuration(3, degree)) > (limit == 0 ? 0.125 : 0.0125))
                        ++n;
                    pieces[limit][degree - 3] += double(n) / curves;
                }
            }
        }
        Row size, more;
        for (std::size_t d = 0; d < 3; ++d) {
            const auto values = [&](double n) { return (10 * n * double(d + 5) + 1) / 80; }; // 10 intervals
            size.push_back(values(pieces[1][d]));
            more.push_back(100 * (values(pieces[1][d]) / values(pieces[0][d]) - 1));
        }
        const std::string range = r == 0 ? "y in [0,1]" : "y in [-1,2]";
        if (r == 0) memory.row(range, pieces[1], Row{3.83, 2.84, 2.36});
        memory.row(range + ", x", size, sizes[r]);
        std::printf("%-14s", "  % over 0.125");
        for (const double m : more) std::printf(" %10.0f", m);
        std::printf("   theirs: 52 to 107\n");
    }
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine options("Prints tables of fits of Bezier curves beside known numbers.");
    options.set_examples({"bezier_tables.csv"});
    std::string path;
    options.add("tables", path, "a CSV file of the known numbers, with rows TABLE,NUMBER,...").required();
    if (const auto code = options.parse(argc, argv)) return *code;
    if (const std::string why = read_known_tables(path); !why.empty()) return fail(why);
    const auto start = std::chrono::steady_clock::now();
    captions_and_sup_errors();
    knots();
    conditions();
    w12_against_sup();
    inner_handles();
    outer_handles();
    degrees_and_splines();
    scales_of_time();
    memory_of_pieces();
    std::printf("\n== differences from the known numbers\n");
    for (const std::string& line : summaries) std::printf("%s\n", line.c_str());
    std::printf("%.1f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return 0;
}
