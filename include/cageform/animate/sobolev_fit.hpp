// A Bézier key interval replaced by a few polynomials in time: the best ones in a Sobolev norm, under conditions.
//
// Izdebski, Interpolacja trajektorii w animacji (Trajectory interpolation in animation), PhD thesis, Warsaw University of
// Technology (2019), ch. 4; misprints corrected, integrals exact by substitution. Bind time: allocates, uses Eigen.
#pragma once

#include <cageform/animate/bezier.hpp>
#include <cageform/animate/detail/bernstein.hpp>
#include <cageform/animate/detail/gauss.hpp>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// What the pieces f_i are held to besides being near to the curve C (the columns of the source's Table 6.1). Values are
/// flags: `FitCondition::end_value | FitCondition::knot_c0`.
enum class FitCondition : std::uint16_t {
    none = 0,
    end_value = 1,  ///< f = C at both keys
    knot_c0 = 2,    ///< neighbours agree at inner knots
    knot_value = 4, ///< both are C there
    end_d1 = 8,     ///< f' = C' at both keys
    knot_c1 = 16,   ///< slopes of neighbours agree at inner knots
    knot_d1 = 32,   ///< both are C' there
    end_d2 = 64,    ///< f'' = C'' at both keys
    knot_c2 = 128,  ///< second derivatives of neighbours agree at inner knots
    knot_d2 = 256,  ///< both are C'' there
};
constexpr FitCondition operator|(FitCondition a, FitCondition b) noexcept {
    // NOLINTNEXTLINE(clang-analyzer-optin.core.EnumCastOutOfRange): flags, any sum of them is one
    return FitCondition(unsigned(a) | unsigned(b));
}
constexpr bool contains(FitCondition set, FitCondition one) noexcept {
    return (unsigned(set) & unsigned(one)) != 0;
}

/// What a fit makes small.
enum class FitNorm : std::uint8_t {
    sobolev, ///< value_weight ∫ (C − f)² + slope_weight ∫ (C' − f')²
    sup, ///< max |C − f|, from the Sobolev fit on; for pieces that are determined apart. Knots are searched as for sobolev
};

struct FitOptions {
    FitNorm norm = FitNorm::sobolev;
    std::size_t degree = 3; ///< of the pieces: 3, 4 or 5
    FitCondition conditions = FitCondition::end_value | FitCondition::knot_value;
    double value_weight = 1; ///< of ∫ (C − f)²
    double slope_weight = 1; ///< of ∫ (C' − f')²; 0 is the L² norm
    /// Weights count where the interval is one unit of time long, so that the unit does not matter; or in the curve's units.
    bool scale_free = true;
};

/// Polynomials in time, one after the other.
struct BezierFit {
    /// ok; as check(curve); and
    ///   degree_not_supported      not 3, 4 or 5
    ///   weights_not_positive      value_weight is not positive or slope_weight negative
    ///   norm_not_supported        the sup norm with conditions that tie pieces together
    ///   knots_not_ascending       knots that do not ascend from 0 to 1, or of which two are one by rounding
    ///   slope_unbounded           a condition asks for a derivative that the curve does not have there
    ///   too_many_conditions       more independent conditions than coefficients, or conditions that repeat each other
    ///   tolerance_not_positive    of `fit`
    ///   tolerance_not_met         of `fit`, with as many pieces as it may take
    Status status = Status::ok;
    std::size_t degree = 3;
    std::vector<double> knots;      ///< #pieces + 1 times
    std::vector<double> parameters; ///< of the curve at the knots, from 0 to 1
    std::vector<double>
        bernstein; ///< #pieces · (degree + 1) coefficients, each piece's on [0, 1] of its own interval
    std::size_t free_coefficients = 0; ///< less the conditions
    double l2_error = 0;               ///< (∫ (C − f)² dx)^½, in the units of the curve
    double slope_error = 0; ///< (∫ (C' − f')² dx)^½; infinite where the curve has a vertical tangent
    double sup_error = 0;   ///< max |C − f|, exact to rounding
    double sup_at = 0;      ///< a time where it occurs

    std::size_t pieces() const noexcept { return knots.empty() ? 0 : knots.size() - 1; }
    double w12_error() const noexcept { return std::hypot(l2_error, slope_error); }
    std::span<const double> coefficients(std::size_t piece) const noexcept {
        return std::span(bernstein).subspan(piece * (degree + 1), degree + 1);
    }
    double operator()(double x) const noexcept {
        std::size_t i = 0;
        while (i + 2 < knots.size() && x >= knots[i + 1]) ++i;
        detail::Bernstein p{degree, {}};
        std::copy_n(bernstein.begin() + std::ptrdiff_t(i * (degree + 1)), degree + 1, p.c.begin());
        return p((x - knots[i]) / (knots[i + 1] - knots[i]));
    }
    /// A piece of degree 3 as a Bézier curve; its handles are at thirds of its interval.
    BezierCurve as_bezier(std::size_t piece) const noexcept {
        BezierCurve curve;
        const double begin = knots[piece], third = (knots[piece + 1] - begin) / 3;
        for (std::size_t k = 0; k < 4; ++k)
            curve.points[k] = {k < 3 ? begin + double(k) * third : knots[piece + 1], coefficients(piece)[k]};
        return curve;
    }
};

/// Fits pieces to one curve; the search for knots asks it many times. Time runs from 0 to 1 inside, values from the first
/// key's on.
class SobolevFitter {
public:
    SobolevFitter(const BezierCurve& curve, const FitOptions& options)
        : options_(options)
        , status_(check_all(curve, options))
        , function_(curve) {
        const BezierCheck checked = check(curve);
        vertical_ = checked.vertical_tangent;
        value_weight_ = options.scale_free ? options.value_weight : options.value_weight * function_.length();
        slope_weight_ = options.scale_free ? options.slope_weight : options.slope_weight / function_.length();
    }

    Status status() const noexcept { return status_; }
    const FitOptions& options() const noexcept { return options_; }
    const BezierFunction& function() const noexcept { return function_; }

    /// Whether every piece is determined by its own interval.
    bool decoupled() const noexcept {
        using enum FitCondition;
        return has(end_value) && has(knot_value) && !has(knot_c0) && !has(knot_c1) && !has(knot_c2) &&
               (has(end_d1) || !has(end_d2)) && (has(knot_d1) || !has(knot_d2));
    }

    /// One polynomial on its own interval.
    struct Piece {
        double begin = 0, end = 1;     ///< parameters of the curve
        double x_begin = 0, x_end = 1; ///< parts of the interval
        detail::Bernstein polynomial;
        bool solved = false;
    };
    /// The best piece between two parameters that has the values (and slopes) of the curve at its ends.
    Piece fit_piece(double begin, double end) const {
        Piece piece = interval(begin, end);
        const double h = piece.x_end - piece.x_begin;
        const std::size_t d = options_.degree;
        if (!(h > 0)) return piece;
        const std::size_t left = prescribed(begin == 0), right = prescribed(end == 1);
        if (left + right > d + 1) return piece;
        auto& b = piece.polynomial.c;
        piece.polynomial.degree = d;
        if (!prescribe(begin, h, left, b.data(), 1) || !prescribe(end, h, right, b.data() + d, -1))
            return piece;
        if (const std::size_t count = d + 1 - left - right; count > 0) {
            const Block gram = gram_of(h);
            const auto load = load_of(piece);
            Small free(count, count);
            SmallVector missing(count);
            for (std::size_t i = 0; i < count; ++i) {
                missing(long(i)) = load[left + i];
                for (std::size_t j = 0; j <= d; ++j) {
                    if (j >= left && j < left + count) {
                        free(long(i), long(j - left)) = gram[left + i][j];
                    } else {
                        missing(long(i)) -= gram[left + i][j] * b[j];
                    }
                }
            }
            const SmallVector solution = free.ldlt().solve(missing);
            for (std::size_t i = 0; i < count; ++i) b[left + i] = solution(long(i));
            if (options_.norm == FitNorm::sup) refine(piece, left, count);
        }
        piece.solved = true;
        return piece;
    }

    /// What knots are searched by: the weighted squares of a piece's errors. Where the curve's slope is unbounded, less a
    /// constant that is infinite but the same for all knots.
    double cost(const Piece& piece) const {
        const std::size_t d = options_.degree;
        if (!vertical_ || slope_weight_ == 0) {
            const auto error = residual(piece);
            double sum = value_weight_ * l2_square(piece, error);
            if (slope_weight_ > 0) sum += slope_weight_ * slope_square(piece, error);
            return sum;
        }
        const Block gram = gram_of(piece.x_end - piece.x_begin);
        const auto load = load_of(piece);
        double sum = 0;
        for (std::size_t i = 0; i <= d; ++i) {
            double row = 0;
            for (std::size_t j = 0; j <= d; ++j) row += gram[i][j] * piece.polynomial.c[j];
            sum += piece.polynomial.c[i] * (row - 2 * load[i]);
        }
        return sum;
    }

    /// The largest |C − f| on a piece; exact, since the difference is a polynomial of the curve's parameter.
    double largest_error(const Piece& piece) const { return detail::largest_absolute(residual(piece)).value; }
    /// What is found of it at a few places: never more, seldom less by more than a twentieth. Much faster.
    double sampled_error(const Piece& piece) const noexcept {
        const double h = piece.x_end - piece.x_begin;
        double largest = 0;
        for (const double v : {0.04, 0.12, 0.22, 0.34, 0.45, 0.55, 0.66, 0.78, 0.88, 0.96}) {
            const double t = piece.begin + v * (piece.end - piece.begin);
            const double error =
                function_.value()(t) - piece.polynomial((function_.time()(t) - piece.x_begin) / h);
            largest = std::fmax(largest, std::fabs(error));
        }
        return largest;
    }

    /// All pieces between parameters that ascend from 0 to 1.
    BezierFit fit(std::span<const double> parameters) const {
        BezierFit result;
        result.status = status_;
        result.degree = options_.degree;
        if (status_ != Status::ok) return result;
        bool ascending = parameters.size() >= 2 && parameters.front() == 0 && parameters.back() == 1;
        std::vector<Piece> pieces;
        for (std::size_t i = 0; i + 1 < parameters.size() && ascending; ++i) {
            pieces.push_back(interval(parameters[i], parameters[i + 1]));
            ascending = parameters[i + 1] > parameters[i] && pieces.back().x_end > pieces.back().x_begin;
        }
        if (!ascending) {
            result.status = Status::knots_not_ascending;
            return result;
        }
        result.status = decoupled() ? solve_apart(pieces) : solve_together(pieces);
        if (result.status != Status::ok) return result;
        return gather(std::move(result), pieces);
    }

    /// The sum of the costs of the pieces between parameters; infinite where there is no fit.
    double objective(std::span<const double> parameters) const {
        std::vector<Piece> pieces;
        double sum = 0;
        for (std::size_t i = 0; i + 1 < parameters.size(); ++i) {
            pieces.push_back(interval(parameters[i], parameters[i + 1]));
            if (!(pieces.back().x_end > pieces.back().x_begin))
                return std::numeric_limits<double>::infinity();
        }
        const Status status = decoupled() ? solve_apart(pieces) : solve_together(pieces);
        if (status != Status::ok) return std::numeric_limits<double>::infinity();
        for (const Piece& piece : pieces) sum += cost(piece);
        return sum;
    }

    /// The result made of solved pieces.
    BezierFit gather(BezierFit result, std::span<const Piece> pieces) const {
        const double length = function_.length(), begin = function_.curve().begin();
        const double value = function_.curve().points[0][1];
        result.degree = options_.degree;
        result.free_coefficients = (options_.degree + 1) * pieces.size() - rows(pieces.size());
        result.parameters = {0};
        result.knots = {begin};
        double l2 = 0, slope = 0;
        for (const Piece& piece : pieces) {
            const auto error = residual(piece);
            result.parameters.push_back(piece.end);
            result.knots.push_back(piece.end == 1 ? function_.curve().end() : begin + length * piece.x_end);
            for (std::size_t k = 0; k <= options_.degree; ++k)
                result.bernstein.push_back(value + piece.polynomial.c[k]);
            l2 += l2_square(piece, error);
            slope += slope_square(piece, error);
            const auto largest = detail::largest_absolute(error);
            if (largest.value <= result.sup_error && &piece != pieces.data()) continue;
            result.sup_error = largest.value;
            result.sup_at =
                begin + length * function_.time()(piece.begin + largest.at * (piece.end - piece.begin));
        }
        result.l2_error = std::sqrt(l2 * length);
        result.slope_error = std::sqrt(slope / length);
        return result;
    }

private:
    static constexpr std::size_t most = 6; ///< coefficients of a piece
    using Block = std::array<std::array<double, most>, most>;
    using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, int(most), int(most)>;
    using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, int(most), 1>;

    bool has(FitCondition one) const noexcept { return contains(options_.conditions, one); }

    static Status check_all(const BezierCurve& curve, const FitOptions& options) noexcept {
        if (const Status status = check(curve).status; status != Status::ok) return status;
        if (options.degree < 3 || options.degree > 5) return Status::degree_not_supported;
        using enum FitCondition;
        const bool tied = contains(options.conditions, knot_c0 | knot_c1 | knot_c2) ||
                          !contains(options.conditions, end_value) ||
                          !contains(options.conditions, knot_value);
        if (options.norm == FitNorm::sup && tied) return Status::norm_not_supported;
        if (!(options.value_weight > 0) || !(options.slope_weight >= 0) || !is_finite(options.value_weight) ||
            !is_finite(options.slope_weight))
            return Status::weights_not_positive;
        return Status::ok;
    }

    Piece interval(double begin, double end) const noexcept {
        const auto& time = function_.time();
        return {begin, end, begin == 0 ? 0 : time(begin), end == 1 ? 1 : time(end), {}, false};
    }

    /// Values, slopes and curvatures that a piece takes from the curve at a key or an inner knot.
    std::size_t prescribed(bool at_key) const noexcept {
        using enum FitCondition;
        return 1 + std::size_t(has(at_key ? end_d1 : knot_d1)) + std::size_t(has(at_key ? end_d2 : knot_d2));
    }
    /// C, C' and C'' by time at a parameter; false where a derivative asked for is unbounded.
    bool derivatives(double t, std::size_t count, std::array<double, 3>& c) const noexcept {
        const double length = function_.length();
        c = {t == 1 ? function_.curve().points[3][1] - function_.curve().points[0][1] : function_.value()(t),
             0, 0};
        // A vertical tangent inside the interval is met but for rounding.
        constexpr double none = 1e-12;
        const double rise = std::fabs(function_.value().slope(t));
        if (vertical_ && count > 1 && function_.time().slope(t) <= none && rise > none * largest_value())
            return false;
        if (count > 1) c[1] = function_.slope_at(t) * length;
        if (count > 2) c[2] = function_.curvature_at(t) * length * length;
        return is_finite(c[1]) && is_finite(c[2]);
    }
    double largest_value() const noexcept { // of the control points, from the first key on
        double largest = 0;
        for (const auto& p : function_.curve().points)
            largest = std::fmax(largest, std::fabs(p[1] - function_.curve().points[0][1]));
        return largest;
    }
    /// Sets the first coefficients from an end (way 1: the left, -1: the right).
    bool prescribe(double t, double h, std::size_t count, double* b, std::ptrdiff_t way) const noexcept {
        std::array<double, 3> c{};
        if (!derivatives(t, count, c)) return false;
        const double d = double(options_.degree), step = double(way) * h;
        b[0] = c[0];
        if (count > 1) b[way] = b[0] + c[1] * step / d;
        if (count > 2) b[2 * way] = 2 * b[way] - b[0] + c[2] * step * step / (d * (d - 1));
        return true;
    }

    /// Moves the free coefficients of a piece towards the least largest error: least squares again and again, each place
    /// weighted by the errors it has had (Lawson 1961). Keeps what is best.
    void refine(Piece& piece, std::size_t left, std::size_t count) const {
        constexpr std::size_t places = 48;
        const std::size_t d = options_.degree;
        const double h = piece.x_end - piece.x_begin;
        std::array<SmallVector, places> basis;
        std::array<double, places> rest{}, weight{};
        for (std::size_t k = 0; k < places; ++k) {
            const double v = 0.5 - 0.5 * std::cos(3.141592653589793 * (double(k) + 0.5) / double(places));
            const double t = piece.begin + v * (piece.end - piece.begin);
            const double u = (function_.time()(t) - piece.x_begin) / h;
            basis[k].resize(long(count));
            rest[k] = function_.value()(t);
            weight[k] = 1;
            for (std::size_t j = 0; j <= d; ++j) {
                const double value =
                    detail::binomials[d][j] * std::pow(u, double(j)) * std::pow(1 - u, double(d - j));
                if (j >= left && j < left + count) {
                    basis[k](long(j - left)) = value;
                } else {
                    rest[k] -= piece.polynomial.c[j] * value;
                }
            }
        }
        double least = largest_error(piece);
        for (int round = 0; round < 40; ++round) {
            Small normal = Small::Zero(long(count), long(count));
            SmallVector right = SmallVector::Zero(long(count));
            for (std::size_t k = 0; k < places; ++k) {
                normal += weight[k] * basis[k] * basis[k].transpose();
                right += weight[k] * rest[k] * basis[k];
            }
            const SmallVector solution = normal.ldlt().solve(right);
            double largest = 0;
            std::array<double, places> error{};
            for (std::size_t k = 0; k < places; ++k) {
                error[k] = std::fabs(rest[k] - basis[k].dot(solution));
                largest = std::fmax(largest, error[k]);
            }
            if (!(largest > 0)) return;
            for (std::size_t k = 0; k < places; ++k) weight[k] *= error[k] / largest + 1e-12;
            if (largest >= least) continue;
            Piece moved = piece;
            for (std::size_t i = 0; i < count; ++i) moved.polynomial.c[left + i] = solution(long(i));
            if (const double exact = largest_error(moved); exact < least) {
                least = exact;
                piece = moved;
            }
        }
    }

    /// The Gram matrix of the Bernstein polynomials on an interval of length h.
    Block gram_of(double h) const noexcept {
        using detail::binomials;
        const std::size_t d = options_.degree;
        const auto product = [&](std::size_t n, std::size_t a,
                                 std::size_t b) { // ∫ of two of degree n, by index
            return a > n || b > n
                       ? 0.0
                       : binomials[n][a] * binomials[n][b] / (binomials[2 * n][a + b] * double(2 * n + 1));
        };
        Block gram{};
        for (std::size_t i = 0; i <= d; ++i) {
            for (std::size_t j = 0; j <= d; ++j) {
                constexpr std::size_t before = ~std::size_t{0}; // i − 1 of i = 0: no polynomial
                const std::size_t p = i > 0 ? i - 1 : before, q = j > 0 ? j - 1 : before;
                const double slopes =
                    product(d - 1, p, q) - product(d - 1, p, j) - product(d - 1, i, q) + product(d - 1, i, j);
                gram[i][j] =
                    value_weight_ * h * product(d, i, j) + slope_weight_ * double(d * d) / h * slopes;
            }
        }
        return gram;
    }
    /// The same with the curve: w0 ∫ C B_j dx + w1 ∫ C' B_j' dx, by substitution polynomials in the curve's parameter.
    std::array<double, most> load_of(const Piece& piece) const {
        if (options_.degree == 3) return load_by<8>(piece);
        return load_by<11>(piece); // exact for degree 3 · 5 + 5
    }
    template <std::size_t Nodes>
    std::array<double, most> load_by(const Piece& piece) const {
        const auto& rule = detail::Gauss<Nodes>::rule();
        const auto &time = function_.time(), &value = function_.value();
        const std::size_t d = options_.degree;
        const double h = piece.x_end - piece.x_begin, width = piece.end - piece.begin;
        std::array<double, most> load{};
        for (std::size_t n = 0; n < Nodes; ++n) {
            const double t = piece.begin + width * rule.node[n];
            const double u = (time(t) - piece.x_begin) / h;
            std::array<double, most> basis{}, lower{}; // of degree d and d − 1 at u
            lower[0] = 1;
            for (std::size_t k = 1; k <= d; ++k) {
                if (k == d) basis = lower;
                auto& b = k == d ? basis : lower;
                for (std::size_t i = k; i > 0; --i) b[i] = (1 - u) * b[i] + u * b[i - 1];
                b[0] *= 1 - u;
            }
            const double weight = rule.weight[n] * width;
            const double of_value = value_weight_ * weight * value(t) * time.slope(t);
            const double of_slope = slope_weight_ * weight * value.slope(t) * double(d) / h;
            for (std::size_t j = 0; j <= d; ++j)
                load[j] +=
                    of_value * basis[j] + of_slope * ((j > 0 ? lower[j - 1] : 0) - (j < d ? lower[j] : 0));
        }
        return load;
    }

    /// C − f on a piece, a polynomial in the curve's parameter (0 and 1 at the ends of the piece).
    detail::Bernstein residual(const Piece& piece) const noexcept {
        using detail::Bernstein;
        const auto restricted = [&](const detail::PowerForm& p) { // by its polar form
            const double a = piece.begin, b = piece.end;
            const auto polar = [&](double x, double y, double z) {
                return p.c1 * (x + y + z) / 3 + p.c2 * (x * y + y * z + z * x) / 3 + p.c3 * x * y * z;
            };
            return Bernstein{3, {polar(a, a, a), polar(a, a, b), polar(a, b, b), polar(b, b, b)}};
        };
        Bernstein u = restricted(function_.time()), rest{3, {}};
        const double h = piece.x_end - piece.x_begin;
        for (std::size_t k = 1; k < 3; ++k) u.c[k] = (u.c[k] - piece.x_begin) / h;
        u.c[0] = 0;
        u.c[3] = 1;
        for (std::size_t k = 0; k < 4; ++k) rest.c[k] = 1 - u.c[k];
        // The piece's polynomial at u, by de Casteljau's steps on polynomials.
        const std::size_t d = options_.degree;
        std::array<Bernstein, most> b;
        for (std::size_t i = 0; i <= d; ++i) b[i].c[0] = -piece.polynomial.c[i];
        for (std::size_t n = d; n > 0; --n) {
            for (std::size_t i = 0; i < n; ++i) b[i] = rest * b[i] + u * b[i + 1];
        }
        return b[0] + elevated(restricted(function_.value()), 3 * d);
    }

    double l2_square(const Piece& piece, const detail::Bernstein& error) const {
        const double width = piece.end - piece.begin;
        const auto square = [&](double v) {
            const double e = error(v);
            return e * e * function_.time().slope(piece.begin + v * width) * width;
        };
        return options_.degree == 3 ? detail::Gauss<11>::rule()(0, 1, square)
                                    : detail::Gauss<17>::rule()(0, 1, square);
    }
    /// ∫ E'²/g' by panels small beside their distance from the roots of g', where the integrand is singular.
    double slope_square(const Piece& piece, const detail::Bernstein& error) const {
        const auto& time = function_.time();
        const auto slope = error.derivative();
        const double width = piece.end - piece.begin;
        const auto slope_at = [&](double t) { return slope((t - piece.begin) / width) / width; };
        double re[2] = {1e300, 1e300}, im = 0; // roots of g'
        if (time.c3 != 0) {
            const double root = time.c2 * time.c2 - 3 * time.c1 * time.c3, middle = -time.c2 / (3 * time.c3);
            const double away = std::sqrt(std::fabs(root)) / (3 * std::fabs(time.c3));
            re[0] = root >= 0 ? middle - away : middle;
            re[1] = root >= 0 ? middle + away : middle;
            im = root >= 0 ? 0 : away;
        } else if (time.c2 != 0) {
            re[0] = re[1] = -time.c1 / (2 * time.c2);
        }
        if (vertical_) {
            const double scale =
                function_.value().slope(0.5) == 0 ? 1 : std::fabs(function_.value().slope(0.5));
            for (const double t : re) {
                if (t < piece.begin - 1e-12 || t > piece.end + 1e-12 || im > 1e-7) continue;
                if (std::fabs(slope_at(std::clamp(t, piece.begin, piece.end))) > 1e-9 * scale)
                    return std::numeric_limits<double>::infinity();
            }
        }
        const auto& rule = detail::Gauss<16>::rule();
        const auto square = [&](double t) {
            const double e = slope_at(t), g = time.slope(t);
            return g > 0 ? e * e / g : 0.0;
        };
        struct Panel {
            double begin, end;
        };
        double sum = 0;
        std::vector<Panel> panels{{piece.begin, piece.end}};
        while (!panels.empty()) {
            const auto [begin, end] = panels.back();
            panels.pop_back();
            const double middle = 0.5 * (begin + end), radius = 0.5 * (end - begin);
            const double near = std::min(std::hypot(re[0] - middle, im), std::hypot(re[1] - middle, im));
            if (near >= 2 * radius || radius < 1e-14) {
                sum += rule(begin, end, square);
            } else {
                panels.push_back({begin, middle});
                panels.push_back({middle, end});
            }
        }
        return sum;
    }

    /// Rows of the conditions for a number of pieces.
    std::size_t rows(std::size_t pieces) const noexcept {
        using enum FitCondition;
        std::size_t at_ends = 0, at_knots = 0;
        for (const auto one : {end_value, end_d1, end_d2}) at_ends += has(one) ? 2 : 0;
        for (const auto one : {knot_c0, knot_c1, knot_c2}) at_knots += has(one) ? 1 : 0;
        for (const auto one : {knot_value, knot_d1, knot_d2}) at_knots += has(one) ? 2 : 0;
        return at_ends + (pieces - 1) * at_knots;
    }

    Status solve_apart(std::vector<Piece>& pieces) const {
        for (Piece& piece : pieces) {
            std::array<double, 3> c{};
            for (const double t : {piece.begin, piece.end}) {
                if (!derivatives(t, prescribed(t == 0 || t == 1), c)) return Status::slope_unbounded;
            }
            piece = fit_piece(piece.begin, piece.end);
            if (!piece.solved) return Status::too_many_conditions;
        }
        return Status::ok;
    }

    /// The whole Lagrange system [M Aᵀ; A 0] of the source's (4.59), in local Bernstein coefficients.
    Status solve_together(std::vector<Piece>& pieces) const {
        using enum FitCondition;
        const std::size_t d = options_.degree, count = pieces.size(), size = (d + 1) * count,
                          conditions = rows(count);
        if (conditions > size) return Status::too_many_conditions;
        Eigen::MatrixXd system = Eigen::MatrixXd::Zero(long(size + conditions), long(size + conditions));
        Eigen::VectorXd right = Eigen::VectorXd::Zero(long(size + conditions));
        for (std::size_t i = 0; i < count; ++i) {
            const Block gram = gram_of(pieces[i].x_end - pieces[i].x_begin);
            const auto load = load_of(pieces[i]);
            for (std::size_t p = 0; p <= d; ++p) {
                right(long(i * (d + 1) + p)) = load[p];
                for (std::size_t q = 0; q <= d; ++q)
                    system(long(i * (d + 1) + p), long(i * (d + 1) + q)) = gram[p][q];
            }
        }
        // Rows are derivatives over their size on the unit interval, so that all are of one order.
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(long(conditions), long(size));
        std::size_t row = 0;
        const auto add = [&](std::size_t order, std::size_t piece, bool at_end, double sign) {
            static constexpr std::array<std::array<double, 3>, 3> differences{
                {{1, 0, 0}, {-1, 1, 0}, {1, -2, 1}}};
            const double h = pieces[piece].x_end - pieces[piece].x_begin;
            for (std::size_t k = 0; k <= order; ++k) {
                // From the right end the same differences backwards, with the sign of the order.
                const std::size_t j = at_end ? d - k : k;
                const double turned = at_end && order == 1 ? -1 : 1;
                a(long(row), long(piece * (d + 1) + j)) +=
                    sign * turned * differences[order][k] * std::pow(h, -double(order));
            }
        };
        const auto factor = [&](std::size_t order) {
            return order == 0 ? 1.0 : order == 1 ? double(d) : double(d * (d - 1));
        };
        bool bounded = true;
        const auto to_curve = [&](std::size_t order, std::size_t piece, bool at_end) {
            std::array<double, 3> c{};
            bounded = derivatives(at_end ? pieces[piece].end : pieces[piece].begin, order + 1, c) && bounded;
            add(order, piece, at_end, 1);
            right(long(size + row)) = c[order] / factor(order);
            ++row;
        };
        for (std::size_t order = 0; order < 3; ++order) {
            if (has(FitCondition(unsigned(end_value) << (3 * order)))) {
                to_curve(order, 0, false);
                to_curve(order, count - 1, true);
            }
            for (std::size_t i = 0; i + 1 < count; ++i) {
                if (has(FitCondition(unsigned(knot_c0) << (3 * order)))) {
                    add(order, i, true, 1);
                    add(order, i + 1, false, -1);
                    ++row;
                }
                if (has(FitCondition(unsigned(knot_value) << (3 * order)))) {
                    to_curve(order, i, true);
                    to_curve(order, i + 1, false);
                }
            }
        }
        if (!bounded) return Status::slope_unbounded;
        for (std::size_t r = 0; r < conditions; ++r) {
            const double norm = a.row(long(r)).norm();
            a.row(long(r)) /= norm;
            right(long(size + r)) /= norm;
        }
        if (conditions > 0) {
            Eigen::ColPivHouseholderQR<Eigen::MatrixXd> rank(a.transpose());
            rank.setThreshold(1e-10);
            if (std::size_t(rank.rank()) < conditions) return Status::too_many_conditions;
        }
        system.block(long(size), 0, long(conditions), long(size)) = a;
        system.block(0, long(size), long(size), long(conditions)) = a.transpose();
        const Eigen::VectorXd solution = system.partialPivLu().solve(right);
        for (std::size_t i = 0; i < count; ++i) {
            pieces[i].polynomial.degree = d;
            for (std::size_t k = 0; k <= d; ++k) pieces[i].polynomial.c[k] = solution(long(i * (d + 1) + k));
            pieces[i].solved = true;
        }
        return Status::ok;
    }

    FitOptions options_;
    Status status_;
    BezierFunction function_;
    bool vertical_ = false;
    double value_weight_ = 1, slope_weight_ = 1;
};

/// The best pieces between given parameters of the curve, ascending from 0 to 1: exact integrals, one linear system.
inline BezierFit fit_pieces(const BezierCurve& curve, std::span<const double> parameters,
                            const FitOptions& options = {}) {
    return SobolevFitter(curve, options).fit(parameters);
}

} // namespace cageform::inline CAGEFORM_ABI
