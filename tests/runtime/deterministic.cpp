// The promise of CAGEFORM_DETERMINISTIC: whatever compiler, level of optimisation and registers this is
// built with, it prints the same hashes of clones and clips.
#include "made_up.hpp"

#include <cageform/animate/pack_clip.hpp>
#include <cageform/clone/clone.hpp>

#include <cinttypes>
#include <cstdio>

#if !defined(CAGEFORM_DETERMINISTIC)
#error "to be compiled with CAGEFORM_DETERMINISTIC"
#endif

namespace {

using cageform::CloneMode;
using cageform::Extrapolation;
using cageform::Status;
using cageform::Vec;
using cageform::WeightFormat;

class Hash {
public:
    template <class X>
    void add(const std::vector<X>& values) noexcept {
        hash_ = cageform::hash_memory(std::span<const X>(values), hash_);
    }
    void print(const char* what) const { std::printf("%016" PRIx64 " %s\n", hash_, what); }

private:
    std::uint64_t hash_ = 0;
};

/// All ways to clone by a binding.
template <class Bound, class T, std::size_t D>
void add_clones(Hash& hash, const Bound& binding, const std::vector<Vec<T, D>>& pose) {
    const std::size_t points = binding.point_count();
    const auto from = made_up::points<T, D>(points, 11);
    std::vector<T> mask(points);
    made_up::Numbers numbers(12);
    for (T& m : mask) m = numbers.fraction<T>();
    const cageform::StridedPoints<const T, 1> masked(mask.data(), points);
    for (const cageform::CloneOptions<T>& options :
         {cageform::CloneOptions<T>{}, {masked}, {.mode = CloneMode::add}, {masked, CloneMode::add}}) {
        auto out = from, in_pieces = from;
        if (clone(binding, pose, out, options) != Status::ok ||
            clone(binding, pose, in_pieces, options, made_up::Backwards{}) != Status::ok || in_pieces != out)
            out.clear();
        hash.add(out);
    }
}

template <class T, std::size_t D>
void print_clones(const char* what) {
    Hash hash;
    for (const std::size_t handles : {1u, 2u, 3u, 4u, 30u, 2100u}) {
        const std::size_t points = handles > 1000 ? 40 : 300;
        const auto pose = made_up::points<T, D>(handles, 1);
        add_clones(hash, made_up::binding<T, D>(points, handles, 2), pose);
        for (const auto format :
             {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
            for (const bool sparse : {false, true})
                add_clones(hash, made_up::packed_binding<T, D>(format, sparse, points, handles, 3).view(),
                           pose);
        }
    }
    hash.print(what);
}

/// More than caches hold.
void print_large() {
    Hash hash;
    add_clones(hash, made_up::binding<float, 3>(4000, 1100, 4), made_up::points<float, 3>(1100, 5));
    hash.print("a large figure");
}

template <class T, std::size_t D>
void print_clips(const char* what) {
    Hash hash;
    for (const auto outside : {Extrapolation::constant, Extrapolation::linear, Extrapolation::cycle,
                               Extrapolation::cycle_with_offset, Extrapolation::ping_pong}) {
        auto clip = made_up::clip<T, D>(37, outside, 6);
        const auto track = [](std::uint32_t seed) {
            made_up::Numbers numbers(seed);
            std::vector<cageform::CubicPiece<T>> pieces;
            for (int i = 0; i < 9; ++i)
                pieces.push_back({T(i), numbers.fraction<T>(), numbers.fraction<T>(), numbers.fraction<T>(),
                                  numbers.fraction<T>()});
            return cageform::PiecewiseCubic<T>(std::move(pieces), T(9));
        };
        cageform::RigidMotion<T, D> motion;
        for (std::size_t k = 0; k < D; ++k)
            motion.translation[k] = {track(std::uint32_t(k)), outside, outside};
        auto cursor = clip.make_cursor();
        std::vector<Vec<T, D>> pose(clip.vertex_count());
        std::vector<T> values;
        const auto curve = track(8);
        for (int frame = 0; frame < 400; ++frame) {
            if (frame == 200) clip.set_rigid_motion(motion);
            const T time = T(frame * (frame % 50 == 0 ? -3 : 1)) / T(10);
            clip.sample(time, cursor, pose);
            hash.add(pose);
            values.insert(values.end(), {curve(time), curve.derivative(time), motion.translation[0](time)});
        }
        hash.add(values);
    }
    hash.print(what);
}

/// Clips opened where they lie, some of their curves in 16 bits.
template <class T, std::size_t D>
void print_opened_clips(const char* what) {
    Hash hash;
    for (const auto outside : {cageform::Extrapolation::linear, cageform::Extrapolation::ping_pong}) {
        const auto clip = made_up::clip<T, D>(37, outside, 6);
        const auto [packed, report] = pack_clip(clip, {.tolerance = 1e-4});
        if (report.quantised == 0 || report.quantised == report.curves) return hash.print("no mixture");
        const auto opened = cageform::open_clip<T, D>(packed.bytes());
        if (opened.status() != Status::ok) return hash.print("a clip that does not open");
        auto cursor = opened.value.make_cursor();
        std::vector<Vec<T, D>> pose(opened.value.vertex_count());
        for (int frame = 0; frame < 400; ++frame) {
            opened.value.sample(T(frame * (frame % 50 == 0 ? -3 : 1)) / T(10), cursor, pose);
            hash.add(pose);
        }
    }
    hash.print(what);
}

} // namespace

int main() {
    // Each scalar and each dimension, but not every pair of them.
    print_clones<float, 1>("float, 1 dimension");
    print_clones<float, 3>("float, 3 dimensions");
    print_clones<double, 2>("double, 2 dimensions");
    print_large();
    print_clips<float, 2>("clips of float");
    print_clips<double, 3>("clips of double");
    print_opened_clips<float, 3>("opened clips of float");
    print_opened_clips<double, 2>("opened clips of double");
}

//> a9be8762e2b20fb8 float, 1 dimension
//> 1a0910a937d7ff45 float, 3 dimensions
//> 6aa3adc6f0fa4f5f double, 2 dimensions
//> 84175fb6dcd5294e a large figure
//> aacfc6f759aa7348 clips of float
//> 4fe1da3a1552e50b clips of double
//> ce4173ecb6e4dda5 opened clips of float
//> 1b9604754575dbcb opened clips of double
