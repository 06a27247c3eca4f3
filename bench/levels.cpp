// How much slower are clones that are not compiled with -O3?
//
// Measures the shared objects in the folder "levels" beside this program, in turns. bench/run.sh compiles
// them from bench/level.cpp at several levels with several compilers. Benchmarks are named what/object.
// STAR(25) in 2D and BUMPY112 in 3D with 500 points, mean value coordinates; packed bindings keep eight
// weights per point. All data fits in caches, which exposes the code around the sums.
#include "counted.hpp"
#include "level.hpp"
#include "workloads.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <benchmark/benchmark.h>
#include <dlfcn.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace {

using cageform::Status;
using cageform::Vec;
using cageform::WeightFormat;
using cageform_bench::Level;
constexpr std::size_t count = 500;

/// A bound cage, a pose, and memory for clones.
template <class T, std::size_t D>
struct Bound {
    cageform::Binding<T, D> binding;
    std::vector<Vec<T, D>> pose, out = std::vector<Vec<T, D>>(count);

    Bound() {
        static_assert(D == 2);
        const auto star = cageform_bench::star(25);
        std::vector<Vec<T, D>> cage, points;
        for (const auto& c : star) cage.push_back(cageform::vec_cast<T>(c));
        for (const auto& p : cageform_bench::points_inside(star, count))
            points.push_back(cageform::vec_cast<T>(p));
        binding = cageform::bind(cageform::MeanValueCoordinates<T, D>(cage), points).value;
        for (const auto& c : cage) pose.push_back({c[0] + T(0.3) * c[1] * c[1], c[1]});
    }
};

/// 3D, with all vectors of a figure.
template <class T>
struct Bound<T, 3> {
    cageform::FigureBinding<T, 3> figure;
    std::vector<Vec<T, 3>> points, pose, out = std::vector<Vec<T, 3>>(count), normals = out;
    std::vector<Vec<T, 4>> tangents = std::vector<Vec<T, 4>>(count);
    std::vector<T> matrices = std::vector<T>(9 * count);

    Bound() {
        const auto cage = cageform_bench::bumpy112<T>();
        for (const auto& p : cageform_bench::points_inside(cageform_bench::bumpy112<double>(), count, 2))
            points.push_back(cageform::vec_cast<T>(p));
        for (std::size_t i = 0; i < count; ++i) tangents[i] = {-points[i][1], points[i][0], 0, 1};
        figure = cageform::bind(coordinates(), cageform::FigurePoints{points, points, tangents}).value;
        for (const auto& c : cage.vertices()) pose.push_back({c[0] + T(0.3) * c[2] * c[2], c[1], c[2]});
    }
    static cageform::MeanValueCoordinates<T, 3> coordinates() {
        return cageform::MeanValueCoordinates<T, 3>(cageform_bench::bumpy112<T>());
    }
    cageform::PackedFigure<T, 3> packed(WeightFormat format) const {
        return cageform::pack(figure, {.weights = {.format = format, .largest = 8}}).value;
    }
};

template <class T, std::size_t D>
Bound<T, D>& bound() { // made once, on first use
    static Bound<T, D> made;
    return made;
}

template <class Clone>
void measure(benchmark::State& state, const Clone& clone) {
    if (const Status status = clone(); status != Status::ok) return state.SkipWithError(to_string(status));
    const cageform_bench::Counted counted;
    for (auto _ : state) {
        if (const Status status = clone(); status != Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
}

template <class T>
void add(const Level::Of<T>& level, const std::string& name) {
    const auto add_one = [&](const std::string& what, auto run) {
        const std::string full = what + (sizeof(T) == sizeof(float) ? "/float/" : "/double/") + name;
        benchmark::RegisterBenchmark(full.c_str(), run)->Unit(benchmark::kMicrosecond);
    };
    add_one("dense_plane", [&level](benchmark::State& state) {
        auto& work = bound<T, 2>();
        const auto view = work.binding.view();
        measure(state, [&] { return level.plane(view, work.pose, work.out); });
    });
    add_one("dense_space", [&level](benchmark::State& state) {
        auto& work = bound<T, 3>();
        const auto view = work.figure.points.view();
        measure(state, [&] { return level.space(view, work.pose, work.out); });
    });
    for (const auto& [format, called] : {std::pair{WeightFormat::scalar, "scalar"},
                                         {WeightFormat::half, "half"},
                                         {WeightFormat::int16, "int16"},
                                         {WeightFormat::int8, "int8"}}) {
        add_one(std::string("packed_") + called, [&level, format = format](benchmark::State& state) {
            auto& work = bound<T, 3>();
            const auto packed = work.packed(format);
            const auto view = cageform::open<T, 3>(packed.bytes()).value.points;
            measure(state, [&] { return level.packed(view, work.pose, work.out); });
        });
        add_one(std::string("figure_") + called, [&level, format = format](benchmark::State& state) {
            auto& work = bound<T, 3>();
            const auto packed = work.packed(format);
            const auto view = cageform::open<T, 3>(packed.bytes()).value;
            measure(state,
                    [&] { return level.figure(view, work.pose, work.out, work.normals, work.tangents); });
        });
    }
    add_one("normals", [&level](benchmark::State& state) {
        auto& work = bound<T, 3>();
        const auto views = cageform::detail::views_of(work.figure.tangents);
        measure(state, [&] { return level.normals(views, work.pose, work.normals); });
    });
    add_one("jacobians", [&level](benchmark::State& state) {
        auto& work = bound<T, 3>();
        const auto axes = cageform::bind_jacobians(work.coordinates(), work.points).value;
        const auto views = cageform::detail::views_of(axes);
        const cageform::StridedMatrices<T, 3> out(work.matrices.data(), count);
        measure(state, [&] { return level.jacobians(views, work.pose, out); });
    });
}

} // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    const auto folder = std::filesystem::absolute(argv[0]).parent_path() / "levels";
    std::error_code error;
    std::size_t found = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        void* const object = dlopen(entry.path().c_str(), RTLD_NOW | RTLD_LOCAL);
        const void* const level = object != nullptr ? dlsym(object, "cageform_level") : nullptr;
        if (level == nullptr) {
            std::fprintf(stderr, "%s\n", dlerror());
            return 1;
        }
        add(static_cast<const Level*>(level)->in_float, entry.path().stem());
        add(static_cast<const Level*>(level)->in_double, entry.path().stem());
        ++found;
    }
    if (found == 0) {
        std::fprintf(stderr, "no objects in %s: run sh bench/run.sh\n", folder.c_str());
        return 1;
    }
    benchmark::RunSpecifiedBenchmarks();
}
