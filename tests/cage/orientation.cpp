// The exact predicates of orientation and intersection, against integer arithmetic.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/cage/detail/primitives.hpp>

namespace orientation_tests {

using cageform::Vec;
using cageform::detail::orientation;
using cageform::detail::segment_distance;
using cageform::detail::segments_touch;
using cageform_tests::Random;

namespace {

__extension__ using Whole = __int128;
using Point = Vec<double, 2>;

/// The cross product of b − a and c − a for coordinates below 8 that are multiples of 2^-55.
int exact_orientation(const Point& a, const Point& b, const Point& c) {
    const auto whole = [](double x) { return Whole(std::ldexp(x, 55)); };
    const Whole left = (whole(b[0]) - whole(a[0])) * (whole(c[1]) - whole(a[1]));
    const Whole right = (whole(b[1]) - whole(a[1])) * (whole(c[0]) - whole(a[0]));
    return left > right ? 1 : left < right ? -1 : 0;
}

/// By definition: an end on the other segment, or ends on both sides of both.
bool exact_touch(const Point& a, const Point& b, const Point& c, const Point& d) {
    const auto holds = [](const Point& s, const Point& t, const Point& p) {
        return exact_orientation(s, t, p) == 0 && std::min(s[0], t[0]) <= p[0] &&
               p[0] <= std::max(s[0], t[0]) && std::min(s[1], t[1]) <= p[1] && p[1] <= std::max(s[1], t[1]);
    };
    return holds(a, b, c) || holds(a, b, d) || holds(c, d, a) || holds(c, d, b) ||
           (exact_orientation(a, b, c) * exact_orientation(a, b, d) < 0 &&
            exact_orientation(c, d, a) * exact_orientation(c, d, b) < 0);
}

/// Small integers times a number that is not an integer, rounded: exactly on a line, or next to it.
struct Places {
    Random random;
    Point step, start;

    explicit Places(int seed)
        : random{std::uint64_t(seed)}
        , step{random.uniform(0.05, 0.15), random.uniform(0.05, 0.15)}
        , start{random.uniform(-1, 1), random.uniform(-1, 1)} {
        for (std::size_t k = 0; k < 2; ++k) { // multiples of 2^-55 or 2^-30
            const int places = seed % 2 == 0 ? 55 : 30;
            step[k] = std::ldexp(std::round(std::ldexp(step[k], places)), -places);
            start[k] = std::ldexp(std::round(std::ldexp(start[k], places)), -places);
        }
    }
    Point on_line() {
        const double t = double(random.below(41)) - 20;
        return {round_to_55(start[0] + t * step[0]), round_to_55(start[1] + t * step[1])};
    }
    Point anywhere() {
        return {round_to_55((double(random.below(21)) - 10) * 0.1),
                round_to_55((double(random.below(21)) - 10) * 0.1)};
    }
    static double round_to_55(double x) { return std::ldexp(std::round(std::ldexp(x, 55)), -55); }
};

} // namespace

TEST_CASE("orientation agrees with integer arithmetic", "[cage][orientation][property]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Places places(seed);
    std::size_t zeros = 0;
    for (int n = 0; n < 500; ++n) {
        const Point a = n % 3 == 0 ? places.anywhere() : places.on_line();
        const Point b = n % 3 == 0 ? places.anywhere() : places.on_line();
        const Point c = n % 3 == 0 ? places.anywhere() : places.on_line();
        const int expected = exact_orientation(a, b, c);
        zeros += expected == 0;
        CHECK(orientation(a, b, c) == expected);
        CHECK(orientation(b, a, c) == -expected);
        // The same at the limits of the range, where products overflow or underflow.
        for (const int exponent : {-900, -400, 400, 900}) {
            const double scale = std::ldexp(1.0, exponent);
            CHECK(orientation(scale * a, scale * b, scale * c) == expected);
        }
    }
    CHECK(zeros > 10);
}

TEST_CASE("orientation in 3D agrees with integer arithmetic", "[cage][orientation][property]") {
    using Place = Vec<double, 3>;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    constexpr int places = 38; // coordinates below 4: their determinants have 126 bits
    const auto lattice = [&](double reach) {
        Place p;
        for (double& x : p.v)
            x = std::ldexp(std::round(std::ldexp(random.uniform(-reach, reach), places)), -places);
        return p;
    };
    const auto exact = [](const std::array<Place, 4>& p) {
        std::array<std::array<Whole, 3>, 3> d{};
        for (std::size_t n = 0; n < 3; ++n) {
            for (std::size_t k = 0; k < 3; ++k)
                d[n][k] = Whole(std::ldexp(p[n + 1][k], places)) - Whole(std::ldexp(p[0][k], places));
        }
        Whole sum = 0;
        for (std::size_t k = 0; k < 3; ++k)
            sum += d[0][k] * (d[1][(k + 1) % 3] * d[2][(k + 2) % 3] - d[1][(k + 2) % 3] * d[2][(k + 1) % 3]);
        return sum > 0 ? 1 : sum < 0 ? -1 : 0;
    };
    std::size_t zeros = 0, near = 0;
    const Place start = lattice(1), u = lattice(0.05), v = lattice(0.05);
    for (int n = 0; n < 500; ++n) {
        std::array<Place, 4> p; // in a plane, a step of the lattice off it, or anywhere
        for (auto& each : p)
            each = start + (double(random.below(21)) - 10) * u + (double(random.below(21)) - 10) * v;
        if (n % 3 == 1) p[random.below(4)][random.below(3)] += std::ldexp(1.0, -places);
        if (n % 3 == 2) p[random.below(4)] = lattice(2);
        const int expected = exact(p);
        zeros += expected == 0;
        near += n % 3 == 1 && expected != 0;
        CHECK(orientation(p[0], p[1], p[2], p[3]) == expected);
        CHECK(orientation(p[1], p[0], p[2], p[3]) == -expected);
        CHECK(orientation(p[3], p[1], p[2], p[0]) == -expected);
        for (const int exponent : {-900, 900}) {
            const double scale = std::ldexp(1.0, exponent);
            CHECK(orientation(scale * p[0], scale * p[1], scale * p[2], scale * p[3]) == expected);
        }
    }
    CHECK(zeros > 100);
    CHECK(near > 100);
}

TEST_CASE("pierces: a segment that ends on a triangle touches it from both sides", "[cage][orientation]") {
    using cageform::detail::pierces;
    const cageform::detail::Corners<3> up{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, down{{up[0], up[2], up[1]}};
    for (const auto& corner : {up, down}) {
        for (const double height : {-1.0, 1.0}) {
            for (const Vec<double, 3>& p : {Vec<double, 3>{0.25, 0.25, 0}, {0.5, 0.5, 0}, {0, 0, 0}}) {
                const Vec<double, 3> above{0.1, 0.2, height}, behind = p + 0.5 * (p - above);
                CHECK(pierces(above, p, corner));
                CHECK(pierces(p, above, corner));
                CHECK(pierces(above, behind, corner));
                CHECK(!pierces(above, p + 0.125 * (above - p), corner));
            }
            CHECK(!pierces({0.1, 0.2, height}, {0.75, 0.75, 0}, corner));
        }
        CHECK(!pierces({-1, 0.25, 0}, {1, 0.25, 0}, corner)); // in the triangle's plane
    }
}

TEST_CASE("segments_touch agrees with integer arithmetic", "[cage][orientation][property]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Places places(seed);
    std::size_t apart = 0;
    for (int n = 0; n < 500; ++n) {
        const bool line = n % 2 == 0;
        const Point a = line ? places.on_line() : places.anywhere(),
                    b = line ? places.on_line() : places.anywhere();
        const Point c = line ? places.on_line() : places.anywhere(),
                    d = line ? places.on_line() : places.anywhere();
        const bool touch = exact_touch(a, b, c, d);
        CHECK(segments_touch(a, b, c, d) == touch);
        CHECK(segments_touch(d, c, a, b) == touch);
        if (touch) CHECK(segment_distance(a, b, c, d) == 0);
        // One after the other on a line, a step apart.
        const bool behind =
            std::max(a[0], b[0]) < std::min(c[0], d[0]) || std::max(c[0], d[0]) < std::min(a[0], b[0]);
        if (line && behind) CHECK(segment_distance(a, b, c, d) > 0.04);
        apart += line && behind;
    }
    CHECK(apart > 10);
}

} // namespace orientation_tests
