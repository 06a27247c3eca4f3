// Defines make_clip() of clip_file.hpp for planar motions, which compiles key-frame tracks.
#include "files/clip_file.hpp"
#include "io/csv.hpp"

#include <cageform/animate/compile.hpp>

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

/// Keys of one axis of a control, repeated over the clip and one period beyond both ends, so that slopes
/// match there.
std::vector<cageform::Key> keys_of(const ClipControl& control, std::size_t axis, double length) {
    const auto& rows = control.rows;
    const double begin = rows.front().time, period = rows.back().time - begin;
    std::vector<cageform::Key> keys;
    const double first = std::floor(-begin / period) - 1, last = std::ceil((length - begin) / period) + 1;
    for (double turn = first; turn < last; ++turn) {
        for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
            cageform::Key key;
            key.time = rows[i].time + turn * period;
            key.value = rows[i].move[axis];
            key.kind = rows[i].kind;
            keys.push_back(key);
        }
    }
    constexpr double ease = 0.42; // of an interval, as CSS ease-in-out
    for (std::size_t i = 0; i < keys.size(); ++i) {
        cageform::Key& key = keys[i];
        const double before = i > 0 ? key.time - keys[i - 1].time : 0;
        const double after = i + 1 < keys.size() ? keys[i + 1].time - key.time : 0;
        key.in_handle = {key.time - ease * before, key.value};
        key.out_handle = {key.time + ease * after, key.value};
    }
    return keys;
}

/// A term of sum().
struct WeightedCurve {
    double weight = 0;
    const cageform::PiecewiseCubic<double>* curve = nullptr;
};

/// value + Σ weight · curve on [0, length]: cubic between the knots of all curves.
cageform::PiecewiseCubic<double> sum(double value, std::span<const WeightedCurve> terms, double length) {
    std::vector<double> knots{0};
    for (const auto& [weight, curve] : terms) {
        for (const auto& piece : curve->pieces()) {
            if (piece.begin > 0 && piece.begin < length) knots.push_back(piece.begin);
        }
    }
    std::sort(knots.begin(), knots.end());
    std::vector<cageform::CubicPiece<double>> pieces;
    for (const double knot : knots) {
        if (!pieces.empty() && knot - pieces.back().begin < 1e-9 * length) continue; // equal up to rounding
        cageform::CubicPiece<double> all{knot, value, 0, 0, 0};
        for (const auto& [weight, curve] : terms) {
            const auto& p = curve->pieces()[curve->locate(knot + 1e-9 * length)];
            all.c0 += weight * p(knot);
            all.c1 += weight * p.derivative(knot);
            all.c2 += weight * (p.c2 + 3 * p.c3 * (knot - p.begin));
            all.c3 += weight * p.c3;
        }
        pieces.push_back(all);
    }
    return {std::move(pieces), length};
}

} // namespace

Expected<cageform::CageClip<double, 2>> make_clip(const ClipFile& file, std::span<const Point2> vertices) {
    std::vector<std::array<cageform::PiecewiseCubic<double>, 3>> moves;
    for (const ClipControl& control : file.controls) {
        auto& move = moves.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto keys = keys_of(control, axis, file.length);
            double tolerance = cageform::screen_tolerance; // or a millionth of the largest value
            for (const cageform::Key& key : keys)
                tolerance = std::max(tolerance, 1e-6 * std::fabs(key.value));
            const auto compiled = cageform::compile<double>(keys, {.tolerance = tolerance});
            if (!compiled) {
                // The index counts repeated keys; the row has the time of the file.
                const std::size_t row = compiled.report.culprit % (control.rows.size() - 1);
                return FileError{file.name + ": " + detail::quoted(control.name) + ": the key at " +
                                 detail::short_number(control.rows[row].time) + ": " +
                                 cageform::to_string(compiled.status())};
            }
            move[axis] = compiled.value.curve;
        }
    }
    std::vector<cageform::PiecewiseCubic<double>> curves;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        std::array<std::vector<WeightedCurve>, 2> terms;
        for (std::size_t c = 0; c < file.controls.size(); ++c) {
            const ClipControl& control = file.controls[c];
            for (const auto& [vertex, weight] : control.shares) {
                if (vertex != i) continue;
                // Linearised rotation, which keeps the sum cubic.
                const double across = vertices[i].x - control.pivot.x, down = vertices[i].y - control.pivot.y;
                terms[0].push_back({weight, &moves[c][0]});
                terms[0].push_back({-weight * down, &moves[c][2]});
                terms[1].push_back({weight, &moves[c][1]});
                terms[1].push_back({weight * across, &moves[c][2]});
            }
        }
        curves.push_back(sum(vertices[i].x, terms[0], file.length));
        curves.push_back(sum(vertices[i].y, terms[1], file.length));
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    return cageform::CageClip<double, 2>(curves, cycle, cycle);
}

} // namespace cageform_support
