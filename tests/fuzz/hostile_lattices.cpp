// Makes lattices of every kind that no one should (knots, frames, falloffs), binds points to them and fits
// poses: nothing may crash, and either a status says what is wrong or the weights are finite, sum to one and
// give the point back. A program of its own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude -Itests
//             -isystem /usr/include/eigen3 tests/fuzz/hostile_lattices.cpp -o hostile_lattices
//     ./hostile_lattices FIRST_SEED COUNT
#include "support/cages.hpp"
#include "support/spoilt.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/fit_lattice.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/lattice/refine.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::Random;
using cageform_tests::spoilt;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "seed %llu, line %d: %s\n", seed, __LINE__, #condition);                        \
        std::abort();                                                                                        \
    }

/// An axis with sound knots, or knots that are close together, multiple, descending, too many or no numbers.
LatticeAxis make_axis(Random& random) {
    LatticeAxis axis{2 + random.below(5), 1 + random.below(3), {}};
    if (random.below(16) == 0) axis = {random.below(9), random.below(6), {}};
    if (random.below(4) == 0) axis = {2 + random.below(random.below(20) == 0 ? 14 : 5), 63, {}};
    if (random.below(200) == 0) axis.points = std::size_t{1} << random.below(64);
    if (random.below(3) != 0 || axis.points > 64 || axis.points < 2) return axis;
    const std::size_t degree = std::min(axis.degree, axis.points - 1);
    const std::size_t kind = random.below(16);
    const double close = kind == 1 ? std::pow(10.0, random.uniform(-320, -1)) : 1;
    axis.knots.assign(degree + 1, 0.0);
    for (std::size_t n = degree + 1; n < axis.points; ++n)
        axis.knots.push_back(kind == 2 && n % 2 == 0 ? axis.knots.back() : close * random.uniform(0, 1));
    if (kind != 3) std::sort(axis.knots.begin(), axis.knots.end());
    axis.knots.insert(axis.knots.end(), degree + 1, 1.0);
    if (kind == 4) axis.knots.resize(random.below(20), 1);
    if (kind == 5) {
        for (double& knot : axis.knots) knot = spoilt<double>(random, knot, random.below(18));
    }
    if (kind == 6) axis.knots.back() = std::nextafter(1.0, 2.0);
    return axis;
}

/// A frame of any axes, flat or nearly so, spoilt.
template <class T, std::size_t D>
Transform<T, D> make_frame(Random& random) {
    const std::size_t kind = random.below(18), shape = random.below(12);
    const double thin = std::pow(10.0, random.uniform(-40, 0));
    Transform<T, D> frame{};
    for (std::size_t k = 0; k < D; ++k) {
        Vec<double, D> column{};
        for (std::size_t a = 0; a < D; ++a)
            column[a] = random.uniform(-1, 1) * (shape == 0 ? 1 : 0.2) + (a == k ? 1 : 0);
        if (shape == 1 && k == D - 1) column = vec_cast<double>(frame.columns[0]);
        if (shape == 2 && k == D - 1) column = vec_cast<double>(frame.columns[0]) + thin * column;
        if (shape == 3 && k == 0) column = thin * column;
        if (shape == 4 && k == 0) column = {};
        for (std::size_t a = 0; a < D; ++a) frame.columns[k][a] = spoilt<T>(random, column[a], kind);
        frame.translation[k] = spoilt<T>(random, random.uniform(-2, 2), random.below(3) == 0 ? kind : 0);
    }
    return frame;
}

template <class T, std::size_t D>
Status try_lattice(Random& random, unsigned long long seed) {
    std::array<LatticeAxis, D> axes;
    for (auto& axis : axes) axis = make_axis(random);
    const auto frame = make_frame<T, D>(random);
    const T falloff =
        random.below(2) == 0 ? T(0) : spoilt<T>(random, random.uniform(-0.2, 2), random.below(18));
    const LatticeCoordinates<T, D> lattice(axes, frame, falloff);
    const Status status = lattice.cage_report().status;
    for (const auto& axis : axes) {
        const auto halves = axis.points < 100 ? halve_spans(axis) : Result<RefinedAxis>{{}, Status::ok};
        const auto raised = axis.points < 100 ? raise_degree(axis) : Result<RefinedAxis>{{}, Status::ok};
        const auto inserted =
            axis.points < 100
                ? insert_knot(axis, spoilt<double>(random, random.uniform(0, 1), random.below(18)))
                : Result<RefinedAxis>{{}, Status::ok};
        for (const auto* refined : {&halves, &raised, &inserted}) {
            for (const double share : refined->value.matrix) REQUIRE(share >= 0 && share <= 1 + 1e-9);
        }
    }
    std::vector<Vec<T, D>> points(10);
    for (auto& p : points) {
        Vec<T, D> u;
        for (T& x : u.v)
            x = T(random.below(4) == 0 ? double(random.below(3)) / 2 : random.uniform(-0.6, 1.6));
        p = frame.translation + frame.map_vector(u);
        if (random.below(4) == 0) {
            for (T& x : p.v) x = spoilt<T>(random, random.uniform(-2, 2), random.below(18));
        }
    }
    const auto outside = OutsidePoints(random.below(3));
    const double fading =
        random.below(2) == 0 ? 0.0 : spoilt<double>(random, random.uniform(-0.2, 2), random.below(18));
    const auto bound = bind(lattice, points, {.outside = outside, .falloff = fading});
    REQUIRE((lattice.handles().size() > 0) == (status == Status::ok));
    const bool can_fade = fading > 0 && is_finite(fading) && outside != OutsidePoints::keep_in_place;
    const Status expected =
        status == Status::ok && fading != 0 && !can_fade ? Status::falloff_not_supported : status;
    REQUIRE(bound.report.status == expected);
    if (expected != Status::ok) return expected;

    const auto weights = bound.value.view().weights;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto lists = [&](const std::vector<std::size_t>& list) {
            return std::find(list.begin(), list.end(), i) != list.end();
        };
        double sum = 0, sizes = 0;
        for (std::size_t h = 0; h < weights.rows; ++h) {
            const auto w = double(weights(i, h));
            REQUIRE(is_finite(w));
            // Restored weights may be negative, in frames that are nearly flat.
            REQUIRE(w >= -16 * double(epsilon<T>) - 2 * bound.report.weight_change.value ||
                    lists(bound.report.outside));
            sum += w;
            sizes += std::fabs(w);
        }
        const double rounding = 256 * double(epsilon<T>) * sizes;
        REQUIRE(sum == 0 || std::fabs(sum - 1) <= rounding || lists(bound.report.not_restored) ||
                lists(bound.report.faded));
    }
    // A pose, and the pose that does what it does.
    std::vector<Vec<T, D>> pose(lattice.handles().begin(), lattice.handles().end()), out(points.size());
    for (auto& p : pose) {
        for (T& x : p.v)
            x += spoilt<T>(random, random.uniform(-0.1, 0.1), random.below(3) == 0 ? random.below(18) : 0);
    }
    const Status cloned = clone(bound.value, pose, out);
    if (pose.size() > 150 && random.below(16) != 0) return status; // fits of large lattices take long
    std::vector<double> importance(random.below(2) * points.size());
    if (random.below(20) == 0) importance.resize(random.below(20));
    const std::size_t of_importance = random.below(18);
    for (double& weight : importance) weight = spoilt<double>(random, random.uniform(0, 2), of_importance);
    std::vector<Vec<T, D>> displacements(out.size());
    for (std::size_t i = 0; i < out.size() && cloned == Status::ok; ++i)
        displacements[i] = out[i] - points[i];
    const auto frozen = lattice.frozen_handles(random.below(2));
    const auto fit =
        fit_lattice(lattice, bound.value, displacements,
                    {.smoothness = spoilt<double>(random, random.uniform(-0.01, 1), random.below(18)),
                     .point_weights = importance,
                     .frozen = frozen});
    REQUIRE(fit.value.size() == (fit ? pose.size() : 0));
    for (const auto i : frozen) REQUIRE(!fit || fit.value[i] == lattice.handles()[i]);
    return fit.status();
}

} // namespace

int main(int argc, char** argv) {
    const unsigned long long first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 0;
    const unsigned long long count = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1000;
    std::map<std::string, std::size_t> seen;
    for (unsigned long long seed = first; seed < first + count; ++seed) {
        Random random(seed);
        const std::size_t type = random.below(4);
        const Status status = type == 0   ? try_lattice<float, 2>(random, seed)
                              : type == 1 ? try_lattice<double, 2>(random, seed)
                              : type == 2 ? try_lattice<float, 3>(random, seed)
                                          : try_lattice<double, 3>(random, seed);
        ++seen[to_string(status)];
    }
    for (const auto& [status, times] : seen) std::printf("%8zu  %s\n", times, status.c_str());
}
