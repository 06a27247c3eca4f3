// Fits skeletons to sequences of every kind that no one should give: flat, on a line, in a point, repeated,
// torn, huge, tiny, with numbers that are not finite, of one frame and of none; and makes their keys. Nothing
// may crash; what is refused is named, and what is made keeps its laws. A program of its own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 -Itests tests/fuzz/hostile_motions.cpp -o hostile_motions
//     ./hostile_motions FIRST_SEED COUNT
#include "support/meshes.hpp"

#include <cageform/skeleton/fit_skeleton.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::Random;
using V = Vec<double, 3>;

std::map<std::string, std::size_t> outcomes;
void count(const char* what, Status status) {
    ++outcomes[std::string(what) + ": " + to_string(status)];
}

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "seed %llu, line %d: %s\n", seed, __LINE__, #condition);                        \
        std::abort();                                                                                        \
    }

V any_vector(Random& random, double reach) {
    return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

struct Sequence {
    std::vector<V> rest;
    std::vector<std::vector<V>> frames;
    std::vector<std::array<std::int64_t, 3>> faces;
};

Sequence any_sequence(Random& random) {
    Sequence result;
    const std::size_t vertices = random.below(10) == 0 ? random.below(200) : random.below(30);
    const std::size_t flat = random.below(8), places = random.below(4);
    for (std::size_t i = 0; i < vertices; ++i) {
        V v = any_vector(random, 1);
        if (flat < 3) v[2] = 0;
        if (flat < 2) v[1] = 0;
        if (flat < 1) v[0] = 0;
        if (places == 0) v = {std::round(v[0]), std::round(v[1]), std::round(v[2])}; // together
        result.rest.push_back(v);
    }
    const std::size_t parts = 1 + random.below(4), kind = random.below(6);
    for (std::size_t t = random.below(10); t > 0; --t) {
        auto& frame = result.frames.emplace_back(result.rest);
        if (kind == 0) continue; // all alike
        std::vector<std::array<V, 4>> maps(parts);
        for (auto& map : maps)
            map = {any_vector(random, 1), any_vector(random, 1), any_vector(random, 1),
                   any_vector(random, kind == 1 ? 1e3 : 1)};
        for (std::size_t i = 0; i < frame.size(); ++i) {
            const auto& map = maps[i * parts / frame.size()];
            const V v = frame[i];
            frame[i] = v[0] * map[0] + (v[1] * map[1] + (v[2] * map[2] + map[3]));
            if (kind == 2) frame[i] = map[3];                // all in a point
            if (kind == 3) frame[i] = any_vector(random, 1); // torn
        }
    }
    double scale = random.below(3) == 0 ? std::pow(10, random.uniform(-300, 99)) : 1;
    const double shift = random.below(5) == 0 ? 1e8 : 0;
    const auto change = [&](std::vector<V>& list) {
        for (V& v : list) v = scale * v + V{shift, 0, 0};
    };
    change(result.rest);
    if (random.below(30) == 0)
        scale *= std::pow(10, random.uniform(-200, 200)); // of another size than at rest
    for (auto& frame : result.frames) change(frame);
    for (std::size_t f = vertices == 0 ? 0 : random.below(60); f > 0; --f) {
        const auto corner = [&] { return std::int64_t(random.below(vertices)); };
        result.faces.push_back({corner(), corner(), corner()});
    }
    if (random.below(12) == 0 && !result.faces.empty())
        result.faces[0][random.below(3)] = std::int64_t(random.bits());
    if (random.below(8) == 0 && !result.frames.empty() && vertices > 0) {
        constexpr std::array<double, 4> bad{std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, 1e101,
                                            -1e300};
        auto& list = random.below(3) == 0 ? result.rest : result.frames[random.below(result.frames.size())];
        list[random.below(vertices)][random.below(3)] = bad[random.below(4)];
    }
    if (random.below(15) == 0 && !result.frames.empty())
        result.frames[random.below(result.frames.size())].resize(random.below(vertices + 2));
    return result;
}

void run(unsigned long long seed) {
    Random random(seed);
    const Sequence given = any_sequence(random);
    const SkeletonOptions options{.bones = random.below(4) == 0 ? 0 : random.below(9),
                                  .influences =
                                      random.below(40) == 0 ? random.below(20) : 1 + random.below(8),
                                  .kind = BoneKind(random.below(3)),
                                  .max_distance = random.below(2) == 0 ? random.uniform(-0.01, 0.3) : 0,
                                  .rounds = random.below(3),
                                  .moves = random.below(3)};
    const auto [skeleton, report] = fit_skeleton(given.rest, given.frames, given.faces, options);
    count("skeleton", report.status);
    if (report.status != Status::ok) {
        REQUIRE(skeleton.bones == 0 && skeleton.maps.empty());
        if (report.status == Status::frame_not_finite) REQUIRE(report.vertex < given.rest.size());
        return;
    }
    REQUIRE(skeleton.bones >= 1 && skeleton.frames == given.frames.size());
    REQUIRE(std::isfinite(report.rms) && std::isfinite(report.max_distance) && std::isfinite(report.turn));
    for (std::size_t i = 0; i < given.rest.size(); ++i) {
        double sum = 0;
        for (std::size_t k = 0; k < options.influences; ++k) {
            const float w = skeleton.skin.weights[i * options.influences + k];
            REQUIRE(w >= 0);
            sum += double(w);
        }
        REQUIRE(std::fabs(sum - 1) < 1e-6);
    }
    std::vector<double> times;
    for (std::size_t t = 0; t < skeleton.frames; ++t) times.push_back(double(t));
    const double allowed = random.below(3) == 0 ? 0 : random.uniform(0, 0.1);
    const auto [keys, made] = fit_skeleton_keys(skeleton, given.rest, times, allowed);
    count("keys", made.status);
    if (made.status != Status::ok) {
        REQUIRE(keys.bones.empty());
        return;
    }
    // Whatever the size of the figure, numbers far from 0 round.
    double reach = 0, size = bounds_of(std::span<const V>(given.rest)).diagonal();
    if (!(size > 0)) size = 1;
    for (const auto& map : skeleton.maps)
        reach = std::fmax(reach, std::sqrt(dot(map.shift, map.shift)) / size);
    if (reach < 1e6) REQUIRE(made.max_distance <= allowed + 1e-6);
}

} // namespace

int main(int argc, char** argv) {
    const unsigned long long first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1;
    const unsigned long long many = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1000;
    for (unsigned long long seed = first; seed < first + many; ++seed) run(seed);
    for (const auto& [what, times] : outcomes) std::printf("%8zu  %s\n", times, what.c_str());
}
