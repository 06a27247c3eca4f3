// Tests the progress that compilers of key frames report.
#include "../support/progress.hpp"
#include "../catch.hpp"
#include "../support/keys.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/animate/fit/knots.hpp>

namespace animate_progress_tests {

using namespace cageform_tests;

TEST_CASE("progress never decreases and ends with 1: curves", "[animate][progress]") {
    const cageform::BezierCurve curve{{{{0, 0}, {0.1, 2}, {0.9, -1}, {1, 1}}}};
    using enum cageform::FitCondition;
    for (const auto conditions : {cageform::FitOptions{}.conditions, end_value | knot_c0}) {
        cageform::FitOptions options;
        options.conditions = conditions;
        check_progress("fit", [&](const Running& r) { return fit(curve, 1e-2, options, r); });
        cageform::KnotOptions knots;
        knots.fit = options;
        check_progress("optimal_knots", [&](const Running& r) { return optimal_knots(curve, 4, knots, r); });
        const std::vector<double> candidates{0, 0.2, 0.4, 0.6, 0.8, 1};
        check_progress("search_knots",
                       [&](const Running& r) { return search_knots(curve, candidates, 3, knots, r); });
        cageform::TrackOptions track;
        track.fit = options;
        for (const std::size_t count : {1u, 5u}) {
            std::vector<cageform::Key> keys;
            for (std::size_t i = 0; i < count; ++i) keys.push_back(key(double(i), double(i * i % 3)));
            check_progress("compile, a track", [&](const Running& r) {
                return cageform::compile<float>(std::span<const cageform::Key>(keys), track, r);
            });
            const std::vector<std::vector<cageform::Key>> curves(3, keys);
            check_progress("compile, a clip",
                           [&](const Running& r) { return cageform::compile<float, 3>(curves, track, r); });
        }
    }
    check_progress("compile, a clip of no curves", [&](const Running& r) {
        return cageform::compile<float, 3>(std::span<const std::vector<cageform::Key>>{}, {}, r);
    });
}

} // namespace animate_progress_tests
