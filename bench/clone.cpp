// How close is a clone to the cost of reading its weights, and what do fewer or smaller weights save?
//
// The limits are to read and sum the same memory, and to move all bytes with one and several threads. The
// memory bandwidth is measured with 256 MB. The peer is Eigen's dense product W · C in the better of its two
// storage orders. Packed bindings use BUMPY112 and mean value coordinates. Counters are errors relative to
// the figure's size: maxima of pack() and of renormalised weights, at rest and in a bending pose.
//
// transposed_…: gradients of handles from those of points, with the same bindings; compare with clone_….
// figure<…>: points of a figure in BUMPY112, normals, Jacobians, gradients from normals, folds, and the step
// of the first fold; compare with the points.
//
// pack_to_distance: bytes needed for a distance in 24 bending and twisting poses of cages with 42, 112 and
// 300 vertices and 8,000 points. Runs in every format (-1: the smallest) and with renormalised weights.
// `distance` is the maximum in these poses, relative to the figure's size. `between` is that in ten other
// poses of the motion, `elsewhere` in five that bend across it. Without the motion (0), the distance holds in
// all poses that bend by up to a tenth of the cage.
//
// played_…: a frame of that motion as engines play it. The three ways are a fitted skin with four weights,
// the packed clone, and the fewest morph targets within the distance of the skin. The second argument is the
// number of bones. `bytes` includes figure and motion.
#define CAGEFORM_C_IMPLEMENTATION
#define CAGEFORM_C_RUNTIME_ONLY
#include <cageform/c/cageform.h>

#include "counted.hpp"
#include "workloads.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/clone/clone_transposed.hpp>
#include <cageform/clone/folds.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include <sys/mman.h>

#include <cstdio>
#include <cstring>
#include <map>
#include <numeric>
#include <random>

namespace {

template <class T, std::size_t D>
struct Workload {
    std::size_t points, handles;
    cageform::Binding<T, D> binding;
    std::vector<cageform::Vec<T, D>> pose, out;

    explicit Workload(const benchmark::State& state)
        : points(std::size_t(state.range(0)))
        , handles(std::size_t(state.range(1))) {
        const std::size_t blocks = cageform::block_count<T>(points);
        std::vector<cageform::Lanes<T>> weights(blocks * handles), rest(blocks * D);
        std::uint32_t random = 1;
        for (auto* lines : {&weights, &rest}) {
            for (auto& lanes : *lines) {
                for (T& x : lanes.v)
                    x = T(random = random * 1664525u + 1013904223u) * T(0x1p-32) / T(handles);
            }
        }
        std::vector<cageform::Vec<T, D>> handles_at_rest(handles);
        pose.resize(handles);
        for (std::size_t h = 0; h < handles; ++h) {
            for (std::size_t k = 0; k < D; ++k) {
                handles_at_rest[h][k] = T(h + k);
                pose[h][k] = T(h) + T(0.5);
            }
        }
        out.resize(points);
        binding =
            cageform::Binding<T, D>(std::move(weights), std::move(rest), std::move(handles_at_rest), points);
    }

    void finish(benchmark::State& state) const {
        state.counters["points/s"] =
            benchmark::Counter(double(points), benchmark::Counter::kIsIterationInvariantRate);
        state.SetBytesProcessed(std::int64_t(state.iterations()) *
                                std::int64_t(points * handles * sizeof(T)));
    }
};

template <class T, std::size_t D>
void clone_dense(benchmark::State& state) {
    Workload<T, D> work(state);
    const cageform_bench::Counted counted;
    for (auto _ : state) {
        const auto status = cageform::clone(work.binding, work.pose, work.out);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

/// A packed figure cloned by C++ or by the C interface: the cost of a call.
template <bool by_c>
void clone_opened(benchmark::State& state) {
    Workload<float, 2> work(state);
    const auto packed = cageform::pack(work.binding);
    const auto opened = cageform::open<float, 2>(packed.value.bytes());
    cageform_figure* figure = nullptr;
    const auto bytes = packed.value.bytes();
    if (!opened || cageform_open(bytes.data(), bytes.size(), nullptr, &figure, nullptr) != CAGEFORM_OK)
        return state.SkipWithError("the figure does not open");
    const auto view = [](auto& points) {
        return cageform_output{
            points.data(), points.size(), 0, points.size() * sizeof(points[0]), CAGEFORM_FLOAT, 2};
    };
    const cageform_output pose = view(work.pose), out = view(work.out);
    const cageform_points posed{pose.data, pose.count, 0, pose.bytes, pose.scalar, 2};
    for (auto _ : state) {
        if constexpr (by_c) {
            if (cageform_clone(figure, posed, out, nullptr, nullptr, nullptr) != CAGEFORM_OK)
                state.SkipWithError("no clone");
        } else if (clone(opened.value, work.pose, work.out) != cageform::Status::ok) {
            state.SkipWithError("no clone");
        }
        benchmark::ClobberMemory();
    }
    cageform_free(figure);
    work.finish(state);
}

/// Gradients of handles from those of points. Uses the rest points as gradients.
template <class T, std::size_t D>
void transposed_dense(benchmark::State& state) {
    Workload<T, D> work(state);
    std::vector<cageform::Vec<T, D>> gradients(work.handles);
    for (std::size_t i = 0; i < work.points; ++i) work.out[i] = work.binding.rest_point(i);
    const cageform_bench::Counted counted;
    for (auto _ : state) {
        const auto status = cageform::clone_transposed(work.binding, work.out, gradients);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}
template <class T, std::size_t D>
void transposed_threads(benchmark::State& state) {
    Workload<T, D> work(state);
    const cageform::ThreadedFor threads{unsigned(state.range(2))};
    std::vector<cageform::Vec<T, D>> gradients(work.handles);
    for (std::size_t i = 0; i < work.points; ++i) work.out[i] = work.binding.rest_point(i);
    for (auto _ : state) {
        const auto status = cageform::clone_transposed(work.binding, work.out, gradients, {}, threads);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

/// With several threads, which start for each clone.
template <class T, std::size_t D>
void clone_threads(benchmark::State& state) {
    Workload<T, D> work(state);
    const cageform::ThreadedFor threads{unsigned(state.range(2))};
    for (auto _ : state) {
        const auto status = cageform::clone(work.binding, work.pose, work.out, {}, threads);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

/// Reads rows and sums them in eight independent sums.
template <class T>
void read_rows(const cageform::Lanes<T>* rows, std::size_t count) {
    std::array<cageform::detail::Simd<T>, 8> sums;
    sums.fill(T(0));
    for (std::size_t i = 0; i + 8 <= count; i += 8) {
        for (std::size_t s = 0; s < 8; ++s) sums[s] = sums[s] + cageform::detail::Simd<T>::load(rows[i + s]);
    }
    benchmark::DoNotOptimize(sums);
}

template <class T, std::size_t D>
void limit_read_weights(benchmark::State& state) {
    Workload<T, D> work(state);
    const auto weights = work.binding.view().weights;
    for (auto _ : state) read_rows(weights.data, weights.blocks() * weights.rows);
    work.finish(state);
}

/// All bytes of a clone of some blocks: reads weights and rest points, writes as many points.
template <class T, std::size_t D>
void move_bytes(Workload<T, D>& work, std::size_t begin, std::size_t end) {
    const auto weights = work.binding.view().weights, rest = work.binding.view().rest;
    read_rows(weights.data + begin * weights.rows, (end - begin) * weights.rows);
    const std::size_t first = begin * cageform::lane_count<T>;
    const std::size_t last = std::min(end * cageform::lane_count<T>, work.points);
    std::memcpy(static_cast<void*>(work.out.data() + first), rest.data + begin * D,
                (last - first) * D * sizeof(T));
}
template <class T, std::size_t D>
void limit_move_bytes(benchmark::State& state) {
    Workload<T, D> work(state);
    for (auto _ : state) {
        move_bytes(work, 0, cageform::block_count<T>(work.points));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}
template <class T, std::size_t D>
void limit_move_bytes_threads(benchmark::State& state) {
    Workload<T, D> work(state);
    const cageform::ThreadedFor threads{unsigned(state.range(2))};
    for (auto _ : state) {
        threads(cageform::block_count<T>(work.points), cageform::detail::clone_grain,
                [&](std::size_t begin, std::size_t end) { move_bytes(work, begin, end); });
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

/// 256 MB: memory bandwidth beyond all caches.
template <class T>
void limit_read_memory(benchmark::State& state) {
    std::vector<cageform::Lanes<T>> memory((std::size_t{256} << 20) / 64);
    std::memset(static_cast<void*>(memory.data()), 1,
                memory.size() * 64); // otherwise all pages would be the same zero page
    for (auto _ : state) read_rows(memory.data(), memory.size());
    state.SetBytesProcessed(std::int64_t(state.iterations()) * (std::int64_t{256} << 20));
}

/// Clones with the `largest` weights of each point, normalised.
template <class T>
std::vector<cageform::Vec<T, 3>> renormalised(const cageform::Binding<T, 3>& binding, std::size_t largest,
                                              const std::vector<cageform::Vec<T, 3>>& pose) {
    std::vector<cageform::Vec<T, 3>> out;
    for (std::size_t i = 0; i < binding.point_count(); ++i) {
        std::vector<std::size_t> order(binding.handle_count());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(largest), order.end(),
                          [&](std::size_t a, std::size_t b) {
                              return std::fabs(binding.weight(i, a)) > std::fabs(binding.weight(i, b));
                          });
        cageform::Vec<T, 3> p{};
        T sum = 0;
        for (std::size_t n = 0; n < largest; ++n) {
            sum += binding.weight(i, order[n]);
            p = p + binding.weight(i, order[n]) * pose[order[n]];
        }
        out.push_back((1 / sum) * p);
    }
    return out;
}

/// BUMPY112 with points inside, bound by mean value coordinates.
template <class T>
struct Bumpy {
    using Points = std::vector<cageform::Vec<T, 3>>;

    Points rest, bent, figure;
    cageform::Binding<T, 3> binding;

    explicit Bumpy(std::size_t count) {
        const auto mesh = cageform_bench::bumpy112<T>();
        rest.assign(mesh.vertices().begin(), mesh.vertices().end());
        for (const auto& p : cageform_bench::points_inside(cageform_bench::bumpy112<double>(), count, 2))
            figure.push_back(cageform::vec_cast<T>(p));
        binding = cageform::bind(cageform::MeanValueCoordinates<T, 3>(mesh), figure).value;
        for (auto p : rest) { // bent by 90 degrees along its height
            const T angle = T(0.75) * p[2], reach = p[0] + 2;
            bent.push_back({reach * std::cos(angle) - 2, p[1], reach * std::sin(angle)});
        }
    }

    static const Bumpy& of(std::size_t count) { // made once; benchmarks run several times
        static std::map<std::size_t, Bumpy> made;
        return made.try_emplace(count, count).first->second;
    }

    /// Maximum distance between two clones.
    static double distance(const Points& a, const Points& b) {
        double largest = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const auto d = cageform::vec_cast<double>(a[i]) - cageform::vec_cast<double>(b[i]);
            largest = std::max(largest, std::sqrt(dot(d, d)));
        }
        return largest;
    }
};

template <class T, cageform::WeightFormat Format>
void clone_packed(benchmark::State& state) {
    const auto& bumpy = Bumpy<T>::of(std::size_t(state.range(0)));
    const auto largest = std::size_t(state.range(1));
    const auto [packed, report] = cageform::pack(bumpy.binding, {.format = Format, .largest = largest});
    // With vertices in the binding's order, as an engine may store them, or in the original order.
    const auto view = state.range(2) != 0 ? packed.view().in_order() : packed.view();
    typename Bumpy<T>::Points out(bumpy.figure.size()), exact = out;
    for (auto _ : state) {
        const auto status = cageform::clone(view, bumpy.bent, out);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    const double size = 2 * 1.6; // approximate size of the figure
    const auto error = [&](const auto& pose) {
        if (cageform::clone(packed.view(), pose, out) != cageform::Status::ok ||
            cageform::clone(bumpy.binding, pose, exact) != cageform::Status::ok)
            return -1.0;
        return bumpy.distance(out, exact) / size;
    };
    state.counters["rest_error"] = error(bumpy.rest);
    state.counters["bend_error"] = error(bumpy.bent);
    if (largest != 0 && out.size() < 10000) {
        state.counters["renormalised_rest"] =
            bumpy.distance(renormalised(bumpy.binding, largest, bumpy.rest), bumpy.figure) / size;
        state.counters["renormalised_bend"] =
            bumpy.distance(renormalised(bumpy.binding, largest, bumpy.bent), exact) / size;
    }
    state.counters["weights_a_point"] = report.weights_per_point;
    state.counters["bytes_of_dense"] = double(report.bytes) / double(report.dense_bytes);
    state.counters["points/s"] =
        benchmark::Counter(double(out.size()), benchmark::Counter::kIsIterationInvariantRate);
}

/// With several threads, to 0.001 of the figure's size in any bending pose.
void pack_threads(benchmark::State& state) {
    const auto& bumpy = Bumpy<float>::of(8019);
    const cageform::Running running{.parallel = cageform::ThreadedFor{unsigned(state.range(0))}};
    for (auto _ : state) {
        const auto packed = cageform::pack(bumpy.binding, {.tolerance = 3.2e-3}, running);
        if (!packed) state.SkipWithError(to_string(packed.status()));
        benchmark::DoNotOptimize(packed.value.bytes().data());
    }
}

/// A figure with a motion that bends and twists it along its z axis.
struct MovedFigure {
    using Points = std::vector<cageform::Vec<float, 3>>;

    Points rest, figure;
    cageform::Binding<float, 3> binding;
    double size = 0;
    std::vector<double> poses; // of the motion, as input of `pack`
    std::vector<Points> given, between,
        elsewhere; // the same as points, others of the motion, and of another motion

    ///   number  0: 42 vertices, 1: 112, 2: 300
    explicit MovedFigure(int number) {
        const auto mesh = cage<float>(number);
        const auto points = cageform_bench::points_inside(cage<double>(number), 8000, 2);
        rest.assign(mesh.vertices().begin(), mesh.vertices().end());
        for (const auto& p : points) figure.push_back(cageform::vec_cast<float>(p));
        binding = cageform::bind(cageform::MeanValueCoordinates<float, 3>(mesh), figure).value;
        size = cageform::bounds_of(std::span<const cageform::Vec<float, 3>>(figure)).diagonal();
        for (int k = 0; k < 24; ++k) {
            given.push_back(bent(2, 1.5 * std::sin(0.26 * k), 0.8 * std::sin(0.52 * k + 1)));
            cageform::append_pose(poses, given.back());
        }
        for (int k = 0; k < 10; ++k)
            between.push_back(
                bent(2, 1.5 * std::sin(0.26 * (k + 0.5)), 0.8 * std::sin(0.52 * (k + 0.5) + 1)));
        for (int k = 0; k < 5; ++k) elsewhere.push_back(bent(0, 0.5 * std::sin(0.9 * k + 0.4), 0.3 * k));
    }

    template <class T>
    static cageform::TriangleMesh<T> cage(int number) {
        if (number == 0) return cageform_bench::divided_box<T>({2, 2, 4}, 0.5);
        return number == 1 ? cageform_bench::bumpy112<T>() : cageform_bench::divided_box<T>({4, 7, 11}, 0.25);
    }
    static const MovedFigure& of(int number) { // made once
        static std::map<int, MovedFigure> made;
        return made.try_emplace(number, number).first->second;
    }

    /// Twists by `twist` and bends by `angle` from one end of an axis to the other.
    Points bent(std::size_t axis, double angle, double twist) const {
        const auto bounds = cageform::bounds_of(std::span<const cageform::Vec<float, 3>>(rest));
        const double length = bounds.upper[axis] - bounds.lower[axis];
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        Points out = rest;
        for (auto& p : out) {
            const double along = (p[axis] - bounds.lower[axis]) / length, turn = twist * along;
            const double x = std::cos(turn) * p[u] - std::sin(turn) * p[v];
            const double y = std::sin(turn) * p[u] + std::cos(turn) * p[v];
            const double radius = length / (std::fabs(angle) < 1e-9 ? 1e-9 : angle);
            p[u] = float(radius - (radius - x) * std::cos(angle * along));
            p[v] = float(y);
            p[axis] = float((radius - x) * std::sin(angle * along));
        }
        return out;
    }

    /// Maximum distance over poses of the results of `clone_of`, relative to the size.
    template <class Clone>
    double distance(const std::vector<Points>& in, const Clone& clone_of) const {
        double largest = 0;
        Points exact(figure.size());
        for (const Points& pose : in) {
            if (cageform::clone(binding, pose, exact) != cageform::Status::ok) return -1;
            largest = std::max(largest, Bumpy<float>::distance(clone_of(pose), exact));
        }
        return largest / size;
    }
};

void pack_to_distance(benchmark::State& state) {
    const auto& moved = MovedFigure::of(int(state.range(0)));
    cageform::PackOptions options{.tolerance = moved.size * std::pow(10.0, -double(state.range(1)))};
    if (state.range(3) != 0) options.poses = moved.poses;
    if (state.range(2) >= 0) options.format = cageform::WeightFormat(state.range(2));
    cageform::Result<cageform::PackedBinding<float, 3>, cageform::PackReport> packed;
    for (auto _ : state) packed = cageform::pack(moved.binding, options);
    const auto& report = packed.report;
    state.counters["handles"] = double(report.handles);
    if (report.status != cageform::Status::ok) {
        state.counters["reachable"] = report.distance.value / moved.size;
        return state.SetLabel(to_string(report.status));
    }
    const auto cloned = [&](const MovedFigure::Points& pose) {
        MovedFigure::Points out(moved.figure.size());
        if (cageform::clone(packed.value.view(), pose, out) != cageform::Status::ok) out.clear();
        return out;
    };
    state.counters["format"] = double(report.format);
    state.counters["bytes"] = double(report.bytes);
    state.counters["weights_a_point"] = report.weights_per_point;
    state.counters["distance"] = moved.distance(moved.given, cloned);
    state.counters["between"] = moved.distance(moved.between, cloned);
    state.counters["elsewhere"] = moved.distance(moved.elsewhere, cloned);
}

/// The usual method: keeps the largest weights, normalised. Bytes as in an engine: one per joint, two per
/// weight, and the rest point.
void renormalised_distance(benchmark::State& state) {
    const auto& moved = MovedFigure::of(int(state.range(0)));
    const auto largest = std::size_t(state.range(1));
    const auto cloned = [&](const MovedFigure::Points& pose) {
        return renormalised(moved.binding, largest, pose);
    };
    for (auto _ : state) state.counters["distance"] = moved.distance(moved.given, cloned);
    state.counters["handles"] = double(moved.rest.size());
    state.counters["bytes"] = double(moved.figure.size() * (largest * 3 + 12));
    state.counters["at_rest"] = moved.distance({moved.rest}, cloned);
    state.counters["elsewhere"] = moved.distance(moved.elsewhere, cloned);
}

/// A figure with its motion in three representations.
struct Played {
    using Points = MovedFigure::Points;

    const MovedFigure& moved;
    std::vector<Points> frames;
    cageform::FittedSkeleton<float> skeleton;
    double distance = 0; ///< of the skin, relative to the size; also the tolerance of the others
    cageform::PackedBinding<float, 3> packed;
    std::vector<std::size_t> targets; ///< frames, interpolated linearly

    Played(int number, std::size_t bones)
        : moved(MovedFigure::of(number)) {
        for (const Points& pose : moved.given) {
            frames.emplace_back(moved.figure.size());
            if (clone(moved.binding, pose, frames.back()) != cageform::Status::ok)
                throw std::runtime_error("no clone");
        }
        const std::vector<std::array<int, 3>> no_faces;
        auto fitted = cageform::fit_skeleton(moved.figure, frames, no_faces, {.bones = bones});
        skeleton = std::move(fitted.value);
        distance = fitted.report.max_distance;
        packed =
            cageform::pack(moved.binding, {.tolerance = distance * moved.size, .poses = moved.poses}).value;
        targets.push_back(0);
        while (targets.back() + 1 < frames.size()) {
            std::size_t next = targets.back() + 1;
            while (next + 1 < frames.size() && is_straight(targets.back(), next + 1)) ++next;
            targets.push_back(next);
        }
    }
    static const Played& of(const benchmark::State& state) { // made once
        static std::map<std::pair<long, long>, Played> made;
        const std::pair<long, long> key(state.range(0), state.range(1));
        return made.try_emplace(key, int(key.first), std::size_t(key.second)).first->second;
    }

    void play_skin(std::size_t frame, Points& out) const {
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = skeleton.place(frame, i, moved.figure[i]);
    }
    bool play_packed(std::size_t frame, Points& out) const {
        return clone(packed.view(), moved.given[frame], out) == cageform::Status::ok;
    }
    void play_targets(std::size_t frame, Points& out) const {
        const auto last = std::lower_bound(targets.begin() + 1, targets.end(), frame);
        play_between(*(last - 1), *last, frame, out);
    }
    double distance_of(std::size_t frame, const Points& out) const {
        return Bumpy<float>::distance(frames[frame], out) / moved.size;
    }

private:
    void play_between(std::size_t from, std::size_t to, std::size_t frame, Points& out) const {
        const float share = float(frame - from) / float(to - from);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = (1 - share) * frames[from][i] + share * frames[to][i];
    }
    bool is_straight(std::size_t from, std::size_t to) const {
        Points out(moved.figure.size());
        for (std::size_t t = from + 1; t < to; ++t) {
            play_between(from, to, t, out);
            if (distance_of(t, out) > distance) return false;
        }
        return true;
    }
};

enum class By : std::uint8_t { skin, packed, targets };

template <By way>
void played(benchmark::State& state) {
    const Played& of = Played::of(state);
    const std::size_t points = of.moved.figure.size(), place = 3 * sizeof(float);
    Played::Points out(points);
    const auto play = [&](std::size_t frame) {
        if constexpr (way == By::skin) of.play_skin(frame, out);
        if constexpr (way == By::targets) of.play_targets(frame, out);
        return way != By::packed || of.play_packed(frame, out);
    };
    std::size_t frame = 0;
    for (auto _ : state) {
        if (!play(frame++ % of.frames.size())) state.SkipWithError("not played");
        benchmark::ClobberMemory();
    }
    double farthest = 0;
    for (std::size_t t = 0; t < of.frames.size(); ++t) {
        if (!play(t)) return state.SkipWithError("not played");
        farthest = std::max(farthest, of.distance_of(t, out));
    }
    const auto bytes_of = [](const auto& list) { return list.size() * sizeof(list[0]); };
    std::size_t bytes = 0;
    if (way == By::skin) {
        bytes = points * place + bytes_of(of.skeleton.skin.joints) + bytes_of(of.skeleton.skin.weights) +
                bytes_of(of.skeleton.maps);
    } else if (way == By::packed) {
        bytes = of.packed.bytes().size() + of.frames.size() * of.moved.rest.size() * place;
    } else {
        bytes = of.targets.size() * points * place;
        state.counters["targets"] = double(of.targets.size());
    }
    state.counters["distance"] = farthest;
    state.counters["bytes"] = double(bytes);
}

/// Opens a blob from a file in the page cache: map, check, unmap. No bytes are copied.
template <class T, cageform::BlobCheck Check, cageform::WeightFormat Format>
void map_blob(benchmark::State& state) {
    const auto& bumpy = Bumpy<T>::of(std::size_t(state.range(0)));
    const auto packed =
        cageform::pack(bumpy.binding, {.format = Format, .largest = std::size_t(state.range(1))}).value;
    const auto bytes = packed.bytes();
    std::FILE* const file = std::tmpfile();
    if (file == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size() ||
        std::fflush(file) != 0)
        return state.SkipWithError("no temporary file");
    for (auto _ : state) {
        void* const memory = mmap(nullptr, bytes.size(), PROT_READ, MAP_PRIVATE, fileno(file), 0);
        if (memory == MAP_FAILED) return state.SkipWithError("not mapped");
        const auto opened = cageform::open_blob<T, 3>({static_cast<const std::byte*>(memory), bytes.size()},
                                                      {.check = Check});
        if (!opened) state.SkipWithError(to_string(opened.status()));
        benchmark::DoNotOptimize(opened.value.weights);
        munmap(memory, bytes.size());
    }
    state.SetBytesProcessed(std::int64_t(state.iterations()) * std::int64_t(bytes.size()));
    std::fclose(file);
}

/// Points, and normals from two bound tangents.
template <class T>
void clone_with_normals(benchmark::State& state) {
    const auto& bumpy = Bumpy<T>::of(std::size_t(state.range(0)));
    const cageform::MeanValueCoordinates<T, 3> coordinates(cageform_bench::bumpy112<T>());
    constexpr std::array axes{cageform::Vec<T, 3>{1, 0, 0}, cageform::Vec<T, 3>{0, 1, 0}};
    const std::array along{std::vector(bumpy.figure.size(), axes[0]),
                           std::vector(bumpy.figure.size(), axes[1])};
    const auto [tangents, report] = cageform::bind_vectors(coordinates, bumpy.figure, along);
    if (report.status != cageform::Status::ok) return state.SkipWithError(to_string(report.status));
    typename Bumpy<T>::Points out(bumpy.figure.size()), normals = out;
    for (auto _ : state) {
        if (cageform::clone(bumpy.binding, bumpy.bent, out) != cageform::Status::ok ||
            cageform::clone_normals(tangents, bumpy.bent, normals) != cageform::Status::ok)
            state.SkipWithError("not cloned");
        benchmark::ClobberMemory();
    }
    state.counters["points/s"] =
        benchmark::Counter(double(out.size()), benchmark::Counter::kIsIterationInvariantRate);
}

/// Quantity computed for each point of a figure.
enum class Of : std::uint8_t { points, normals, normals_transposed, jacobians, folds, largest_step };

template <class T, Of what>
void figure(benchmark::State& state) {
    const auto& bumpy = Bumpy<T>::of(std::size_t(state.range(0)));
    const cageform::MeanValueCoordinates<T, 3> coordinates(cageform_bench::bumpy112<T>());
    auto [columns, report] = cageform::bind_jacobians(coordinates, bumpy.figure);
    if (report.status != cageform::Status::ok) return state.SkipWithError(to_string(report.status));
    const std::array tangents{columns[0].view(), columns[1].view()};
    typename Bumpy<T>::Points out(bumpy.figure.size()), handles(bumpy.rest.size());
    std::vector<T> matrices(9 * bumpy.figure.size());
    auto farther = bumpy.rest; // twice as far as the pose
    for (std::size_t i = 0; i < farther.size(); ++i)
        farther[i] = farther[i] + T(2) * (bumpy.bent[i] - bumpy.rest[i]);
    for (auto _ : state) {
        auto status = cageform::Status::ok;
        if constexpr (what == Of::points) status = cageform::clone(bumpy.binding, bumpy.bent, out);
        if constexpr (what == Of::normals) status = cageform::clone_normals(tangents, bumpy.bent, out);
        if constexpr (what == Of::normals_transposed)
            status = cageform::clone_normals_transposed(tangents, bumpy.bent, bumpy.figure, handles);
        if constexpr (what == Of::jacobians)
            status = cageform::clone_jacobians(
                columns, bumpy.bent, cageform::StridedMatrices<T, 3>(matrices.data(), bumpy.figure.size()));
        if constexpr (what == Of::folds) {
            const auto folds = cageform::report_folds(columns, bumpy.bent);
            status = folds.status;
            state.counters["folded"] = double(folds.count);
        }
        if constexpr (what == Of::largest_step) {
            const auto step = cageform::largest_step(columns, bumpy.rest, farther);
            status = step.status;
            state.counters["step"] = step.step;
        }
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    state.counters["points/s"] =
        benchmark::Counter(double(out.size()), benchmark::Counter::kIsIterationInvariantRate);
}

template <class T, cageform::WeightFormat Format>
void transposed_packed(benchmark::State& state) {
    const auto& bumpy = Bumpy<T>::of(std::size_t(state.range(0)));
    const auto packed =
        cageform::pack(bumpy.binding, {.format = Format, .largest = std::size_t(state.range(1))}).value;
    const auto view = state.range(2) != 0 ? packed.view().in_order() : packed.view();
    typename Bumpy<T>::Points gradients(view.handle_count());
    for (auto _ : state) {
        const auto status = cageform::clone_transposed(view, bumpy.figure, gradients);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    state.counters["points/s"] =
        benchmark::Counter(double(bumpy.figure.size()), benchmark::Counter::kIsIterationInvariantRate);
}

/// Points that depend on their 16 nearest handles, as natural neighbours in 3D do, packed.
template <class T>
struct Neighbours {
    std::vector<cageform::Vec<T, 3>> pose;
    std::vector<T> weights; ///< of the handles
    cageform::PackedBinding<T, 3> binding;
    double rows_a_block = 0;

    Neighbours(std::size_t points, std::size_t handles) {
        std::mt19937 random(1);
        std::uniform_real_distribution<double> in_cube(0, 1);
        const auto places = [&](std::size_t count) {
            std::vector<cageform::Vec<T, 3>> made(count);
            for (auto& p : made) p = {T(in_cube(random)), T(in_cube(random)), T(in_cube(random))};
            return made;
        };
        const auto rest_handles = places(handles), figure = places(points);
        const std::size_t blocks = cageform::block_count<T>(points);
        std::vector<cageform::Lanes<T>> rows(blocks * handles), rest(blocks * 3);
        for (auto& row : rows) std::fill(std::begin(row.v), std::end(row.v), T(0));
        const cageform::BlockView<T> w{rows.data(), handles, points}, p{rest.data(), 3, points};
        for (std::size_t i = 0; i < blocks * cageform::lane_count<T>; ++i) {
            const auto& at = figure[std::min(i, points - 1)];
            std::vector<std::pair<T, std::size_t>> near;
            for (std::size_t h = 0; h < handles; ++h)
                near.emplace_back(dot(rest_handles[h] - at, rest_handles[h] - at), h);
            std::nth_element(near.begin(), near.begin() + 16, near.end());
            T sum = 0;
            for (std::size_t n = 0; n < 16; ++n) sum += 1 / (T(1e-3) + near[n].first);
            for (std::size_t n = 0; n < 16; ++n) w(i, near[n].second) = 1 / (T(1e-3) + near[n].first) / sum;
            for (std::size_t k = 0; k < 3; ++k) p(i, k) = at[k];
        }
        const cageform::Binding<T, 3> dense(std::move(rows), std::move(rest), rest_handles, points);
        binding = cageform::pack(dense, {.threshold = 1e-30}).value;
        rows_a_block = double(binding.view().row_count()) / double(blocks);
        pose = rest_handles;
        for (auto& handle : pose)
            handle = handle + T(0.1) * cageform::Vec<T, 3>{handle[1], handle[2], handle[0]};
        for (std::size_t h = 0; h < handles; ++h) weights.push_back(h % 20 == 0 ? T(3) : T(1));
    }

    void finish(benchmark::State& state) const {
        const auto view = binding.view();
        state.counters["rows_a_block"] = rows_a_block;
        state.SetBytesProcessed(std::int64_t(state.iterations()) * std::int64_t(view.row_count() * 64));
    }
};

/// Handle weights that change every frame, with a view that is validated once or every time.
template <class T, bool Judged>
void clone_rational_sparse(benchmark::State& state) {
    const Neighbours<T> work(std::size_t(state.range(0)), std::size_t(state.range(1)));
    const auto view = work.binding.view();
    const auto fit = cageform::rational_view(view);
    std::vector<cageform::Vec<T, 3>> out(view.point_count());
    for (auto _ : state) {
        cageform::Status status = fit.status();
        if constexpr (Judged) {
            status = cageform::clone_rational(fit.value, work.pose, work.weights, out);
        } else {
            status = cageform::clone_rational(view, work.pose, work.weights, out);
        }
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}
template <class T>
void clone_sparse(benchmark::State& state) {
    const Neighbours<T> work(std::size_t(state.range(0)), std::size_t(state.range(1)));
    std::vector<cageform::Vec<T, 3>> out(work.binding.view().point_count());
    for (auto _ : state) {
        const auto status = cageform::clone(work.binding, work.pose, out);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}
template <class T>
void transposed_sparse(benchmark::State& state) {
    const Neighbours<T> work(std::size_t(state.range(0)), std::size_t(state.range(1)));
    const std::vector<cageform::Vec<T, 3>> of_points(work.binding.view().point_count(), {1, 2, 3});
    std::vector<cageform::Vec<T, 3>> gradients(work.pose.size());
    for (auto _ : state) {
        const auto status = cageform::clone_transposed(work.binding, of_points, gradients);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}
template <class T>
void limit_read_sparse(benchmark::State& state) {
    const Neighbours<T> work(std::size_t(state.range(0)), std::size_t(state.range(1)));
    const auto view = work.binding.view();
    for (auto _ : state) {
        std::array<cageform::detail::Simd<T>, 8> sums;
        sums.fill(T(0));
        for (std::size_t i = 0; i + 8 <= view.row_count(); i += 8) {
            for (std::size_t s = 0; s < 8; ++s)
                sums[s] = sums[s] + cageform::detail::load_row<cageform::WeightFormat::scalar, T>(
                                        view.weights + (i + s) * 64);
        }
        benchmark::DoNotOptimize(sums);
    }
    work.finish(state);
}

template <class T, std::size_t D, int Order>
void eigen_product(benchmark::State& state) {
    using Weights = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Order>;
    using Points = Eigen::Matrix<T, Eigen::Dynamic, int(D), D == 1 ? Eigen::ColMajor : Order>;
    const Workload<T, D> work(state);
    const Weights weights = Weights::Random(Eigen::Index(work.points), Eigen::Index(work.handles));
    const Points handles = Points::Random(Eigen::Index(work.handles), Eigen::Index(D));
    Points out(Eigen::Index(work.points), Eigen::Index(D));
    for (auto _ : state) {
        out.noalias() = weights * handles;
        benchmark::DoNotOptimize(out.data());
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

void sizes_figure(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgName("points")->Unit(benchmark::kMicrosecond)->Arg(8019);
}
void sizes_2d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"})
        ->Unit(benchmark::kMicrosecond)
        ->Args({152, 25})
        ->Args({1000000, 25});
}
void sizes_3d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"})
        ->Unit(benchmark::kMicrosecond)
        ->Args({8019, 112})
        ->Args({8019, 332}) // as many as Green coordinates of 112 vertices and 220 faces
        ->Args({100000, 112});
}

void threads_2d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles", "threads"})->Unit(benchmark::kMicrosecond)->UseRealTime();
    benchmark->ArgsProduct({{1000000}, {25}, {1, 2, 4}});
}
void threads_3d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles", "threads"})->Unit(benchmark::kMicrosecond)->UseRealTime();
    benchmark->ArgsProduct({{100000}, {112}, {1, 2, 4}});
}

void sizes_mapped(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "largest"})
        ->Unit(benchmark::kMicrosecond)
        ->Args({100000, 0})
        ->Args({100000, 8});
}
void sizes_sparse(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"})->Unit(benchmark::kMicrosecond)->Args({5000, 300});
}
void sizes_played(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"figure", "bones"})->ArgsProduct({{1, 2}, {12, 30}})->Unit(benchmark::kMicrosecond);
}
void sizes_packed(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "largest", "in_order"})->Unit(benchmark::kMicrosecond);
    for (const long points : {8019L, 100000L})
        benchmark->Args({points, 0, 0})->Args({points, 8, 0})->Args({points, 8, 1});
}

} // namespace

#define CAGEFORM_BENCH_CLONE(T)                                                                              \
    BENCHMARK_TEMPLATE(clone_dense, T, 2)->Apply(sizes_2d);                                                  \
    BENCHMARK_TEMPLATE(transposed_dense, T, 2)->Apply(sizes_2d);                                             \
    BENCHMARK_TEMPLATE(limit_read_weights, T, 2)->Apply(sizes_2d);                                           \
    BENCHMARK_TEMPLATE(limit_move_bytes, T, 2)->Apply(sizes_2d);                                             \
    BENCHMARK_TEMPLATE(eigen_product, T, 2, Eigen::RowMajor)->Apply(sizes_2d);                               \
    BENCHMARK_TEMPLATE(eigen_product, T, 2, Eigen::ColMajor)->Apply(sizes_2d);                               \
    BENCHMARK_TEMPLATE(clone_dense, T, 3)->Apply(sizes_3d);                                                  \
    BENCHMARK_TEMPLATE(transposed_dense, T, 3)->Apply(sizes_3d);                                             \
    BENCHMARK_TEMPLATE(limit_read_weights, T, 3)->Apply(sizes_3d);                                           \
    BENCHMARK_TEMPLATE(limit_move_bytes, T, 3)->Apply(sizes_3d);                                             \
    BENCHMARK_TEMPLATE(eigen_product, T, 3, Eigen::RowMajor)->Apply(sizes_3d);                               \
    BENCHMARK_TEMPLATE(eigen_product, T, 3, Eigen::ColMajor)->Apply(sizes_3d);                               \
    BENCHMARK_TEMPLATE(limit_read_memory, T)->Unit(benchmark::kMicrosecond);                                 \
    BENCHMARK_TEMPLATE(limit_read_sparse, T)->Apply(sizes_sparse);                                           \
    BENCHMARK_TEMPLATE(clone_sparse, T)->Apply(sizes_sparse);                                                \
    BENCHMARK_TEMPLATE(transposed_sparse, T)->Apply(sizes_sparse);                                           \
    BENCHMARK_TEMPLATE(clone_rational_sparse, T, true)->Apply(sizes_sparse);                                 \
    BENCHMARK_TEMPLATE(clone_rational_sparse, T, false)->Apply(sizes_sparse);                                \
    BENCHMARK_TEMPLATE(clone_packed, T, cageform::WeightFormat::scalar)->Apply(sizes_packed);                \
    BENCHMARK_TEMPLATE(transposed_packed, T, cageform::WeightFormat::scalar)->Apply(sizes_packed);           \
    BENCHMARK_TEMPLATE(clone_packed, T, cageform::WeightFormat::half)->Apply(sizes_packed);                  \
    BENCHMARK_TEMPLATE(transposed_packed, T, cageform::WeightFormat::half)->Apply(sizes_packed);             \
    BENCHMARK_TEMPLATE(clone_packed, T, cageform::WeightFormat::int16)->Apply(sizes_packed);                 \
    BENCHMARK_TEMPLATE(transposed_packed, T, cageform::WeightFormat::int16)->Apply(sizes_packed);            \
    BENCHMARK_TEMPLATE(clone_packed, T, cageform::WeightFormat::int8)->Apply(sizes_packed);                  \
    BENCHMARK_TEMPLATE(transposed_packed, T, cageform::WeightFormat::int8)->Apply(sizes_packed);             \
    BENCHMARK_TEMPLATE(figure, T, Of::points)->Apply(sizes_figure);                                          \
    BENCHMARK_TEMPLATE(figure, T, Of::normals)->Apply(sizes_figure);                                         \
    BENCHMARK_TEMPLATE(figure, T, Of::normals_transposed)->Apply(sizes_figure);                              \
    BENCHMARK_TEMPLATE(figure, T, Of::jacobians)->Apply(sizes_figure);                                       \
    BENCHMARK_TEMPLATE(figure, T, Of::folds)->Apply(sizes_figure);                                           \
    BENCHMARK_TEMPLATE(figure, T, Of::largest_step)->Apply(sizes_figure);                                    \
    BENCHMARK_TEMPLATE(clone_with_normals, T)->ArgName("points")->Arg(8019)->Unit(benchmark::kMicrosecond);

CAGEFORM_BENCH_CLONE(float)
BENCHMARK_TEMPLATE(clone_opened, false)->Apply(sizes_2d);
BENCHMARK_TEMPLATE(clone_opened, true)->Apply(sizes_2d);
CAGEFORM_BENCH_CLONE(double)
BENCHMARK_TEMPLATE(clone_threads, float, 2)->Apply(threads_2d);
BENCHMARK_TEMPLATE(clone_threads, float, 3)->Apply(threads_3d);
BENCHMARK_TEMPLATE(transposed_threads, float, 2)->Apply(threads_2d);
BENCHMARK_TEMPLATE(transposed_threads, float, 3)->Apply(threads_3d);
BENCHMARK_TEMPLATE(limit_move_bytes_threads, float, 2)->Apply(threads_2d);
BENCHMARK_TEMPLATE(limit_move_bytes_threads, float, 3)->Apply(threads_3d);
BENCHMARK(pack_threads)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_TEMPLATE(map_blob, float, cageform::BlobCheck::structure, cageform::WeightFormat::scalar)
    ->Apply(sizes_mapped);
BENCHMARK_TEMPLATE(map_blob, float, cageform::BlobCheck::all, cageform::WeightFormat::scalar)
    ->Apply(sizes_mapped);
BENCHMARK(pack_to_distance)
    ->ArgNames({"figure", "digits", "format", "motion"})
    ->ArgsProduct({{0, 1, 2}, {2, 3, 4}, {-1, 0, 1, 2, 3}, {1}})
    ->ArgsProduct({{0, 1, 2}, {2, 3, 4}, {-1}, {0}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(renormalised_distance)
    ->ArgNames({"figure", "largest"})
    ->ArgsProduct({{0, 1, 2}, {8, 16}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(played, By::skin)->Apply(sizes_played);
BENCHMARK_TEMPLATE(played, By::packed)->Apply(sizes_played);
BENCHMARK_TEMPLATE(played, By::targets)->Apply(sizes_played);
