// Draws strokes and walls that no one should, and diffuses them: nothing may crash, and either a status
// says what is wrong or all values are finite and between the least and the largest given. A program of its
// own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude -Itests
//             tests/fuzz/hostile_strokes.cpp -o hostile_strokes
//     ./hostile_strokes FIRST_SEED COUNT
#include "support/cages.hpp"

#include <cageform/fields/strokes.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::Random;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "seed %llu, line %d: %s\n", seed, __LINE__, #condition);                        \
        std::abort();                                                                                        \
    }

/// Mostly sound; else not finite, huge, tiny, or on the lattice lines of a small grid.
double number(Random& random, double low, double high) {
    switch (random.below(150)) {
    case 0: return std::numeric_limits<double>::quiet_NaN();
    case 1: return std::numeric_limits<double>::infinity();
    case 2: return random.uniform(-1, 1) * std::pow(10.0, random.uniform(-320, 308));
    case 3: return low;
    case 4: return high;
    default: break;
    }
    return random.below(4) == 0 ? low + (high - low) * double(random.below(33)) / 32
                                : random.uniform(low, high);
}

template <class T, std::size_t D>
Status draw(Random& random, Diffusion<T, D>& field, double size, double far, std::vector<T>& given) {
    const std::size_t channels = field.channels(),
                      points = random.below(20) == 0 ? random.below(2) : 2 + random.below(5);
    const double wide = std::pow(10.0, random.uniform(-12, 0)) * size;
    const auto place = [&](const Vec<T, D>& near) {
        Vec<T, D> p;
        for (std::size_t k = 0; k < D; ++k) p[k] = T(far + number(random, 0, size));
        if (random.below(6) == 0) p = near + T(wide / size) * (p - near); // close together
        return p;
    };
    std::vector<Vec<T, D>> places;
    for (std::size_t i = 0; i < points; ++i)
        places.push_back(place(places.empty() ? Vec<T, D>{} : places.back()));
    if (points > 2 && random.below(3) == 0) places.back() = places.front();
    const auto values = [&](bool wanted) {
        std::vector<T> list;
        for (std::size_t i = 0; wanted && i < channels * points; ++i)
            list.push_back(T(number(random, -2, 3)));
        if (random.below(200) == 0) list.push_back(0);
        return list;
    };
    const auto front = values(true), back = values(random.below(2) == 0);
    Status status = Status::ok;
    if constexpr (D == 2) {
        const T radius = points == 1 || random.below(6) == 0 ? T(number(random, 0, 0.3 * size)) : T(0);
        status = field.add({places, front, back, radius});
    } else {
        Wall<T> wall{places, {}, front, back};
        for (std::size_t f = random.below(4); f-- > 0;) {
            const auto corner = [&] {
                return std::uint32_t(random.below(points + (random.below(30) == 0 ? 2 : 0) + 1));
            };
            wall.faces.push_back({corner(), corner(), corner()});
        }
        status = field.add(wall);
    }
    if (status != Status::ok) return status;
    for (const auto* side : {&front, &back}) given.insert(given.end(), side->begin(), side->end());
    return status;
}

template <class T, std::size_t D>
void run(unsigned long long seed, std::map<std::string, std::size_t>& seen) {
    Random random(seed);
    const double size = std::pow(10.0, random.uniform(-6, 6)), far = random.below(3) == 0 ? 1e3 * size : 0;
    Bounds<T, D> canvas;
    for (std::size_t k = 0; k < D; ++k) {
        canvas.lower[k] = T(far);
        canvas.upper[k] = T(far + size * (random.below(12) == 0 ? random.uniform(0.01, 1) : 1));
    }
    const std::size_t channels = 1 + random.below(3);
    Diffusion<T, D> field(canvas, 2 + random.below(D == 2 ? 60 : 14), channels);
    std::vector<T> given;
    for (std::size_t n = 1 + random.below(5); n-- > 0;)
        ++seen[to_string(draw(random, field, size, far, given))];
    const auto solved = field.solve({.tolerance = 1e-4, .max_cycles = 200});
    ++seen[std::string("solve: ") + to_string(solved.status)];
    if (solved.status != Status::ok) return;
    std::vector<Vec<T, D>> places(20);
    for (auto& p : places) {
        for (std::size_t k = 0; k < D; ++k) p[k] = T(far + random.uniform(-0.2, 1.2) * size);
    }
    std::vector<T> values(places.size() * channels);
    REQUIRE(field.sample(places, std::span(values)) == Status::ok);
    const auto [low, high] = std::minmax_element(given.begin(), given.end());
    const double rounding = 1e-5 * std::max(std::fabs(double(*low)), std::fabs(double(*high)));
    const auto between = [&](T value) {
        return is_finite(value) && double(value) >= double(*low) - rounding &&
               double(value) <= double(*high) + rounding;
    };
    for (const T value : values) REQUIRE(between(value));
    for (std::size_t channel = 0; channel < channels; ++channel) {
        for (const T value : field.field(channel)) REQUIRE(between(value));
    }
}

} // namespace

int main(int argc, char** argv) {
    const unsigned long long first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1;
    const unsigned long long count = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1000;
    std::map<std::string, std::size_t> seen;
    for (unsigned long long seed = first; seed < first + count; ++seed) {
        if (seed % 2 == 0) {
            seed % 4 == 0 ? run<double, 2>(seed, seen) : run<float, 2>(seed, seen);
        } else {
            seed % 4 == 1 ? run<double, 3>(seed, seen) : run<float, 3>(seed, seen);
        }
    }
    for (const auto& [what, times] : seen) std::printf("%9zu %s\n", times, what.c_str());
}
