// Makes point sets of every kind that no one should, and binds points to them: nothing may crash, and
// either a status says what is wrong or the weights are finite, sum to one and give the point back. A
// program of its own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude -Itests
//             -isystem /usr/include/eigen3 tests/fuzz/hostile_sites.cpp -o hostile_sites
//     ./hostile_sites FIRST_SEED COUNT
#include "support/cages.hpp"
#include "support/spoilt.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/sibson.hpp>

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

/// Places in [-1, 1]^D: random, clustered, on a line or plane but for some, on a sphere, on a lattice, in a
/// ring, almost so, or twice.
template <std::size_t D>
std::vector<Vec<double, D>> places(Random& random, std::size_t count) {
    const std::size_t kind = random.below(9), thin = random.below(4);
    const double off = random.below(2) == 0 ? 0 : std::pow(10.0, random.uniform(-18, -1));
    const double width = std::pow(10.0, random.uniform(-17, 0));
    std::vector<Vec<double, D>> sites(count);
    for (std::size_t i = 0; i < count; ++i) {
        auto& p = sites[i];
        for (std::size_t k = 0; k < D; ++k) p[k] = random.uniform(-1, 1);
        if (kind == 1 && i % 3 != 0) p = sites[i - i % 3] + width * p;
        if (kind == 2) {
            for (std::size_t k = 1; k < D; ++k) p[k] = double(k) * p[0];
        }
        if (kind == 3) p[D - 1] = p[0];
        if (kind == 4) p = (1 / std::sqrt(dot(p, p))) * p;
        if (kind == 5) {
            for (std::size_t k = 0; k < D; ++k) p[k] = std::round(2 * p[k]) / 2;
        }
        if (kind == 6) {
            const double angle = 2 * std::numbers::pi * double(i % 7) / 7;
            p[0] = std::cos(angle);
            p[1] = std::sin(angle);
            if (D == 3) p[D - 1] = double(i / 7) / 3;
        }
        if (kind == 7 && i > 0 && random.below(8) == 0) p = sites[random.below(i)];
        if (kind == 8) p[0] = i % 2 == 0 ? -1 : 1;
        for (std::size_t k = 0; k < D; ++k) p[k] += off * random.uniform(-1, 1);
        if (thin == 1) p[D - 1] *= width;
    }
    return sites;
}

template <class T, std::size_t D>
Status try_sites(Random& random, unsigned long long seed) {
    const std::size_t kind = random.below(18);
    const auto plain = places<D>(random, random.below(30) + (random.below(8) == 0 ? 0 : D + 1));
    std::vector<Vec<T, D>> sites(plain.size()), points(8);
    for (std::size_t i = 0; i < plain.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k) sites[i][k] = spoilt<T>(random, plain[i][k], kind);
    }
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k) p[k] = spoilt<T>(random, random.uniform(-1.2, 1.2), kind);
        if (!sites.empty() && random.below(2) == 0) p = sites[random.below(sites.size())];
        if (!sites.empty() && random.below(3) == 0)
            p = T(0.5) * p + T(0.5) * sites[random.below(sites.size())];
    }
    const SibsonOptions options{.degree = random.below(2) == 0 ? 1 : 3,
                                .gradients = SiteGradients(random.below(3)),
                                .frames = random.below(3) == 0};
    const SibsonCoordinates<T, D> sibson(sites, options);
    const auto outside = OutsidePoints(random.below(3));
    const auto result = bind(sibson, points, {.outside = outside});
    REQUIRE(result.report.status == sibson.cage_report().status);
    if (result.report.status != Status::ok) return result.report.status;
    const auto weights = result.value.view().weights;
    const double size = double(bounds_of(std::span<const Vec<T, D>>(sites)).magnitude());
    const double extent = double(bounds_of(std::span<const Vec<T, D>>(sites)).diagonal());
    // Points that bind reports as not restored: a point within tolerance of the hull (which is relative
    // to the coordinates) may lie off the plane of its sites by that, and the sum misses as much
    // relative to the extent. At degree 3 they also occur for sites so near to a line or plane that
    // rounding leaves no gradient across it.
    const auto unrestored = [&](std::size_t i) {
        const auto& list = result.report.not_restored;
        if (std::find(list.begin(), list.end(), i) == list.end()) return 1.0;
        return std::fmax(options.degree == 3 ? 1e6 : 1.0, size / extent);
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        double sum = 0, sizes = 0;
        for (std::size_t h = 0; h < weights.rows; ++h) {
            REQUIRE(is_finite(weights(i, h)));
            // Restored weights may be negative, for points within tolerance of a thin hull.
            REQUIRE(options.degree == 3 ||
                    double(weights(i, h)) >=
                        -16 * double(epsilon<T>) - 2 * result.report.weight_change.value);
            sum += double(weights(i, h));
            sizes += std::fabs(double(weights(i, h)));
        }
        REQUIRE(sum == 0 || std::fabs(sum - 1) <= 64 * double(epsilon<T>) * sizes * unrestored(i));
    }
    // The rows of estimated gradients are as right as sites nearly in a plane allow, 1e5 in size and more.
    const double roundings = options.degree == 3 && !options.frames ? 4096 : 256;
    REQUIRE(result.report.reproduction_error.point == Extreme::none ||
            result.report.reproduction_error.value <=
                roundings * unrestored(result.report.reproduction_error.point) * double(epsilon<T>) * size *
                    std::fmax(1.0, result.report.amplification.value));
    return Status::ok;
}

} // namespace

int main(int argc, char** argv) {
    const unsigned long long first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 0;
    const unsigned long long count = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1000;
    std::map<std::string, std::size_t> seen;
    for (unsigned long long seed = first; seed < first + count; ++seed) {
        Random random(seed);
        const std::size_t type = random.below(4);
        const Status status = type == 0   ? try_sites<float, 2>(random, seed)
                              : type == 1 ? try_sites<double, 2>(random, seed)
                              : type == 2 ? try_sites<float, 3>(random, seed)
                                          : try_sites<double, 3>(random, seed);
        ++seen[to_string(status)];
    }
    for (const auto& [status, times] : seen) std::printf("%8zu  %s\n", times, status.c_str());
}
