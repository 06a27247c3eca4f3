// Packs a clip: measures the errors of 16-bit coefficients and chooses the curves to quantise.
#pragma once

#include <cageform/animate/types/clip_pack_options.hpp>
#include <cageform/clip/clip_blob.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The maximum of |c0 + u (c1 + u (c2 + u c3))| for u in [0, h].
inline double largest_of_cubic(const std::array<double, 4>& c, double h) noexcept {
    const auto at = [&c](double u) { return std::fabs(((c[3] * u + c[2]) * u + c[1]) * u + c[0]); };
    double most = std::fmax(at(0), at(h));
    const auto add = [&](double u) {
        if (u > 0 && u < h) most = std::fmax(most, at(u));
    };
    const double root = std::sqrt(std::fmax(c[2] * c[2] - 3 * c[3] * c[1], 0.0)); // sqrt of discriminant
    const double sum = -(c[2] + std::copysign(root, c[2]));                       // avoids cancellation
    if (c[3] != 0) add(sum / (3 * c[3]));
    if (sum != 0) add(c[1] / sum);
    return most;
}

/// A curve with 16-bit Bernstein coefficients: integer n means low + n · step, where 0 is the minimum of all
/// coefficients and 65535 the maximum. Quantisation changes values by at most half a step.
template <Scalar T>
struct QuantisedCurve {
    T low = 0, step = 0;
    std::vector<std::array<std::uint16_t, 4>> pieces;

    QuantisedCurve() = default;
    QuantisedCurve(const CurveBankView<T>& bank, std::size_t curve) {
        std::vector<std::array<double, 4>> exact(bank.piece_count(curve));
        const T* const knots = bank.knots.data() + bank.curves[curve].first_knot;
        for (std::size_t n = 0; n < exact.size(); ++n) {
            const auto p = bank.piece(curve, n);
            const double h = double(knots[n + 1]) - double(p.begin), c0 = double(p.c0);
            const double c1 = double(p.c1) * h, c2 = double(p.c2) * h * h, c3 = double(p.c3) * h * h * h;
            exact[n] = {c0, c0 + c1 / 3, c0 + 2 * c1 / 3 + c2 / 3, c0 + c1 + c2 + c3};
        }
        double least = exact[0][0], largest = least;
        for (const auto& piece : exact) {
            for (const double b : piece) {
                least = std::fmin(least, b);
                largest = std::fmax(largest, b);
            }
        }
        low = static_cast<T>(least);
        step = static_cast<T>((largest - least) / 65535);
        pieces.resize(exact.size());
        for (std::size_t n = 0; n < exact.size(); ++n) {
            for (std::size_t k = 0; k < 4 && largest > least; ++k) {
                const double steps = (exact[n][k] - least) / (largest - least) * 65535;
                pieces[n][k] = static_cast<std::uint16_t>(std::lround(steps));
            }
        }
    }
};

/// A bank in which the chosen curves are quantised.
template <Scalar T>
struct QuantisedBank {
    std::vector<BankCurve<T>> curves;
    std::vector<T> knots;
    std::vector<std::array<T, 4>> pieces;
    std::vector<std::array<std::uint16_t, 4>> steps;
    std::vector<KnotEvent> entries;

    QuantisedBank(const CurveBankView<T>& from, std::span<const QuantisedCurve<T>> quantised,
                  std::span<const char> chosen)
        : curves(from.curves.begin(), from.curves.end()) {
        for (const bool quantise : {false, true}) {
            for (std::size_t k = 0; k < from.size(); ++k) {
                if ((chosen[k] != 0) != quantise) continue;
                const std::uint32_t first = from.curves[k].first_knot;
                curves[k].first_knot = std::uint32_t(knots.size());
                curves[k].low = quantise ? quantised[k].low : T(0);
                curves[k].step = quantise ? quantised[k].step : T(0);
                for (std::uint32_t n = 0; n < curves[k].knots; ++n) {
                    entries.push_back({std::uint32_t(knots.size()), std::uint32_t(k)});
                    knots.push_back(from.knots[first + n]);
                    const CubicPiece<T> p = from.piece(k, n);
                    if (!quantise)
                        pieces.push_back({p.c0, p.c1, p.c2, p.c3});
                    else if (n + 1 < curves[k].knots)
                        steps.push_back(quantised[k].pieces[n]);
                    else
                        steps.push_back({});
                }
            }
        }
        std::sort(entries.begin(), entries.end(), [this](const KnotEvent& a, const KnotEvent& b) {
            return knots[a.knot] != knots[b.knot] ? knots[a.knot] < knots[b.knot] : a.knot < b.knot;
        });
    }
    CurveBankView<T> view() const noexcept { return {curves, knots, pieces, steps, entries}; }
};

/// The largest difference of a curve between two banks with the same knots; infinite if a
/// coefficient is not finite.
template <Scalar T>
double largest_difference(const CurveBankView<T>& a, const CurveBankView<T>& b, std::size_t curve) noexcept {
    double most = 0;
    for (std::size_t n = 0; n < a.piece_count(curve); ++n) {
        const CubicPiece<T> p = a.piece(curve, n), q = b.piece(curve, n);
        if (!is_finite_piece(p) || !is_finite_piece(q)) return std::numeric_limits<double>::infinity();
        const T* const knot = a.knots.data() + a.curves[curve].first_knot + n;
        most = std::fmax(most, largest_of_cubic({double(p.c0) - double(q.c0), double(p.c1) - double(q.c1),
                                                 double(p.c2) - double(q.c2), double(p.c3) - double(q.c3)},
                                                double(knot[1]) - double(knot[0])));
    }
    return most;
}

/// The diagonal of the bounding box of all vertices at their knots.
template <Scalar T, std::size_t D>
double size_of_cage(const CurveBankView<T>& bank) noexcept {
    double square = 0;
    for (std::size_t axis = 0; axis < D; ++axis) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (std::size_t k = axis; k < bank.size(); k += D) {
            for (std::size_t n = 0; n <= bank.piece_count(k); ++n) {
                low = std::fmin(low, double(bank.piece(k, n).c0));
                high = std::fmax(high, double(bank.piece(k, n).c0));
            }
        }
        if (high > low) square += (high - low) * (high - low);
    }
    return std::sqrt(square);
}

/// Quantises the curves of a vertex in order of ascending error while the distance stays within the
/// tolerance. Returns the distance of the vertex.
template <std::size_t D>
double choose_curves(std::span<const double> errors, double tolerance, std::span<char> chosen) noexcept {
    std::array<std::size_t, D> order{};
    for (std::size_t k = 0; k < D; ++k) order[k] = k;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return errors[a] != errors[b] ? errors[a] < errors[b] : a < b;
    });
    double square = 0;
    for (const std::size_t k : order) {
        const double with = square + errors[k] * errors[k];
        if (!(std::sqrt(with) <= tolerance)) break;
        square = with;
        chosen[k] = 1;
    }
    return std::sqrt(square);
}

template <Scalar T, std::size_t D>
Status pack_clip_into(const CageClipView<T, D>& clip, const ClipPackOptions& options,
                      PackedClip<T, D>& packed, ClipPackReport& report) {
    const CurveBankView<T>& bank = clip.bank;
    for (const double limit : {options.tolerance, options.share}) {
        if (!is_finite(limit) || limit < 0) return Status::value_not_finite;
    }
    report.vertices = clip.vertex_count();
    report.curves = bank.size();
    report.size = size_of_cage<T, D>(bank);
    double tolerance = options.tolerance > 0 ? options.tolerance : std::numeric_limits<double>::infinity();
    if (options.share > 0) tolerance = std::fmin(tolerance, options.share * report.size);
    std::vector<char> chosen(bank.size(), 0);
    std::vector<QuantisedCurve<T>> quantised(bank.size());
    if (options.tolerance > 0 || options.share > 0) {
        for (std::size_t k = 0; k < bank.size(); ++k) quantised[k] = {bank, k};
        const QuantisedBank<T> all(bank, quantised, std::vector<char>(bank.size(), 1));
        for (std::size_t v = 0; v < report.vertices; ++v) {
            std::array<double, D> errors{};
            for (std::size_t k = 0; k < D; ++k) errors[k] = largest_difference(bank, all.view(), v * D + k);
            const double distance = choose_curves<D>(errors, tolerance, std::span(chosen).subspan(v * D, D));
            if (distance > report.distance) report.distance_vertex = v;
            report.distance = std::fmax(report.distance, distance);
        }
    }
    packed = PackedClip<T, D>(clip);
    report.unquantised_bytes = packed.bytes().size();
    const QuantisedBank<T> mixed(bank, quantised, chosen);
    CageClipView<T, D> made = clip;
    made.bank = mixed.view();
    PackedClip<T, D> smaller(made);
    if (smaller.bytes().size() < packed.bytes().size()) { // false for a few constant curves
        packed = std::move(smaller);
        report.quantised = std::size_t(std::count(chosen.begin(), chosen.end(), char(1)));
    } else {
        report.distance = 0;
        report.distance_vertex = 0;
    }
    report.bytes = packed.bytes().size();
    if (open_clip<T, D>(packed.bytes(), BlobCheck::structure)) return Status::ok;
    packed = {};
    return Status::value_not_finite;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
