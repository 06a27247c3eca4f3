// Feeds numbers of any kind to compile_track, compile_clip and the fits of one interval, and plays what
// compiles: for libFuzzer. No input may take a minute of the processor: of a million the slowest, optimal
// knots in the sup norm, took 4 s without sanitizers.
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 tests/fuzz/compile_keys.cpp -o fuzz_compile_keys
//     ./fuzz_compile_keys -max_len=1024 -len_control=0
//
// With -DRANDOM_BYTES and without "fuzzer,": random bytes, a million in minutes.
//     ./fuzz_compile_keys COUNT [SEED]
#include <cageform/animate/compile.hpp>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>

using cageform::BezierCurve;
using cageform::Extrapolation;
using cageform::FitCondition;
using cageform::FitOptions;
using cageform::Key;
using cageform::KeyKind;
using cageform::Status;
using cageform::TrackOptions;

namespace {

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                         \
        std::abort();                                                                                        \
    }

/// Numbers from the input's bytes; zeros after its end.
class Bytes {
public:
    Bytes(const std::uint8_t* data, std::size_t size)
        : data_(data)
        , size_(size) {}

    bool ended() const { return size_ == 0; }
    std::size_t below(std::size_t count) { return take<std::uint8_t>() % count; }

    /// Mostly one of those that make trouble, or near to one; else small, or any bits.
    double number() {
        using Limits = std::numeric_limits<double>;
        using Floats = std::numeric_limits<float>;
        static constexpr std::array values{0.0,
                                           1.0,
                                           1e-3,
                                           1e3,
                                           1e9,
                                           1e16,
                                           1e-9,
                                           1e38,
                                           1e154,
                                           1e300,
                                           1e308,
                                           1e-154,
                                           1e-300,
                                           1e-310,
                                           double(Floats::max()),
                                           double(Floats::min()),
                                           double(Floats::denorm_min()),
                                           Limits::max(),
                                           Limits::min(),
                                           Limits::denorm_min(),
                                           Limits::infinity(),
                                           Limits::quiet_NaN()};
        const std::size_t way = below(8);
        if (way < 4) return double(take<std::int8_t>()) / 16;
        if (way == 4) return take<double>();
        double value = values[below(values.size())];
        if (way == 5) value = std::nextafter(value, below(2) == 0 ? 0 : Limits::infinity());
        return below(2) == 0 ? value : -value;
    }

private:
    template <class X>
    X take() {
        X x{};
        const std::size_t count = std::min(sizeof(X), size_);
        std::memcpy(&x, data_, count);
        data_ += count;
        size_ -= count;
        return x;
    }

    const std::uint8_t* data_;
    std::size_t size_;
};

FitOptions options_of(Bytes& bytes) {
    FitOptions options;
    if (bytes.below(32) != 0) return options;
    options.degree = bytes.below(7);
    options.conditions = FitCondition((bytes.below(2) << 8) + bytes.below(256));
    options.norm = bytes.below(4) == 0 ? cageform::FitNorm::sup : cageform::FitNorm::sobolev;
    options.scale_free = bytes.below(2) == 0;
    if (bytes.below(2) == 0) options.value_weight = bytes.number();
    if (bytes.below(2) == 0) options.slope_weight = bytes.number();
    return options;
}

std::vector<Key> keys_of(Bytes& bytes) {
    std::vector<Key> keys(bytes.below(6));
    const bool ascending = bytes.below(8) != 0;
    double time = bytes.number();
    for (Key& key : keys) {
        key.kind = KeyKind(bytes.below(6));
        key.time = time;
        key.value = bytes.number();
        const double step = bytes.number();
        time = ascending ? time + std::fabs(step) : step;
        if (bytes.below(2) == 0) continue;
        for (double* x : {&key.in_slope, &key.out_slope, &key.tension, &key.continuity, &key.bias})
            *x = bytes.number();
        key.in_handle = {key.time - std::fabs(bytes.number()), bytes.number()};
        key.out_handle = {key.time + std::fabs(bytes.number()), bytes.number()};
    }
    return keys;
}

std::map<Status, std::size_t> outcomes;

template <class T>
void check_track(std::span<const Key> keys, const TrackOptions& options) {
    cageform::Running running; // tied pieces that miss the tolerance take long: cancelled after some
    std::size_t told = 0;
    running.progress = [&](double) { return ++told < 20; };
    const auto compiled = cageform::compile<T>(keys, options, running);
    const auto& curve = compiled.value.curve;
    ++outcomes[compiled.status()];
    if (compiled.status() != Status::ok) {
        REQUIRE(curve.empty());
        REQUIRE(compiled.status() == Status::keys_missing || compiled.report.culprit < keys.size());
        return;
    }
    REQUIRE(curve.begin() == T(keys.front().time) && curve.end() == T(keys.back().time));
    REQUIRE(compiled.report.sup_error == 0 || compiled.report.sup_error <= options.tolerance);
    for (std::size_t i = 0; i < curve.pieces().size(); ++i) {
        const T begin = curve.pieces()[i].begin;
        const T end = i + 1 < curve.pieces().size() ? curve.pieces()[i + 1].begin : curve.end();
        for (const T part : {T(0), T(0.25), T(0.5), T(0.75), T(1)}) {
            const T x = begin + part * (end - begin);
            REQUIRE(std::isfinite(curve(x)) && std::isfinite(curve.derivative(x)));
        }
    }
    for (const Key& key : keys) REQUIRE(std::isfinite(curve(T(key.time))));
    REQUIRE(curve(T(keys.back().time)) == T(keys.back().value));
    for (const T x : {curve.begin() - 1, curve.end() + 1, std::numeric_limits<T>::max(),
                      std::numeric_limits<T>::quiet_NaN(), -std::numeric_limits<T>::infinity()})
        (void)compiled.value(x);
}

template <class T>
void check_clip(const std::vector<Key>& first, const std::vector<Key>& second, TrackOptions options) {
    options.fit = {}; // no tied pieces, which no one could cancel here
    const std::vector<std::vector<Key>> curves{first, second};
    const auto compiled = cageform::compile<T, 2>(curves, options);
    if (compiled.status() != Status::ok) return;
    auto cursor = compiled.value.make_cursor();
    std::array<cageform::Vec<T, 2>, 1> pose{};
    for (const T part : {T(-0.5), T(0), T(0.3), T(1), T(1.5)})
        compiled.value.sample(compiled.value.begin() + part * (compiled.value.end() - compiled.value.begin()),
                              cursor, pose);
}

void check_fit(const BezierCurve& curve, double tolerance, FitOptions options, std::size_t pieces) {
    options.max_pieces = pieces;
    const auto [fitted, report] = cageform::fit(curve, tolerance, options);
    if (report.status == Status::ok) {
        REQUIRE(fitted.pieces() >= 1 && fitted.pieces() <= pieces);
        REQUIRE(report.sup_error <= tolerance);
        for (const double b : fitted.bernstein) REQUIRE(std::isfinite(b));
        for (std::size_t i = 0; i < fitted.pieces(); ++i) REQUIRE(fitted.knots[i] <= fitted.knots[i + 1]);
    }
    const auto search = cageform::optimal_knots(curve, pieces, {.fit = options, .rounds = 3});
    if (search.status() != Status::ok) return;
    REQUIRE(search.value.parameters.size() == pieces + 1);
    (void)cageform::fit_pieces(curve, search.value.parameters, options);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::clock_t start = std::clock();
    Bytes bytes(data, size);
    TrackOptions options;
    options.fit = options_of(bytes);
    if (bytes.below(3) != 0) options.tolerance = std::fabs(bytes.number());
    options.before = Extrapolation(bytes.below(5));
    options.after = Extrapolation(bytes.below(5));
    const auto first = keys_of(bytes), second = keys_of(bytes);
    const bool single = bytes.below(2) == 0;
    if (bytes.below(8) == 7)
        single ? check_clip<float>(first, second, options) : check_clip<double>(first, second, options);
    else
        single ? check_track<float>(first, options) : check_track<double>(first, options);
    if (first.size() >= 2 && bytes.below(32) == 31) {
        check_fit(cageform::key_interval(first, 0), options.tolerance.value_or(0), options.fit,
                  1 + bytes.below(6));
        BezierCurve curve;
        for (auto& p : curve.points) p = {bytes.number(), bytes.number()};
        check_fit(curve, options.tolerance.value_or(0), options.fit, 1 + bytes.below(6));
    }
    REQUIRE(double(std::clock() - start) / CLOCKS_PER_SEC < 60);
    return 0;
}

#ifdef RANDOM_BYTES
#include <random>
int main(int argc, char** argv) {
    const std::size_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1000;
    const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
    for (std::size_t n = 0; n < count; ++n) {
        std::mt19937_64 random(seed + n);
        std::array<std::uint64_t, 48> bytes{};
        for (auto& x : bytes) x = random();
        if (std::getenv("SHOW") != nullptr)
            std::fprintf(stderr, "%llu\n", static_cast<unsigned long long>(seed + n));
        (void)LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                     8 + random() % (sizeof bytes - 8));
    }
    for (const auto& [status, times] : outcomes) std::printf("%9zu %s\n", times, to_string(status));
}
#endif
