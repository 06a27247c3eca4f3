// Feeds bytes to open_blob, open_figure, open_clip and open_pose_samples, and whatever opens to clones,
// players and solvers, in buffers exactly as long as promised: for libFuzzer.
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 tests/fuzz/open_blob.cpp -o fuzz_open_blob
//     mkdir corpus && ./fuzz_open_blob --seeds=corpus && ./fuzz_open_blob -max_len=24576 corpus
#include <cageform/animate/pack_clip.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

using cageform::BlobCheck;
using cageform::BlobHeader;
using cageform::Status;
using cageform::Vec;
using cageform::WeightFormat;

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                         \
        std::abort();                                                                                        \
    }

constexpr std::size_t most = 1u << 16; ///< handles and points that are cloned

/// Memory aligned to 64 bytes and not a byte longer than asked for: a sanitizer sees what is read beyond.
class Exact {
public:
    explicit Exact(std::span<const std::byte> bytes)
        : data_(static_cast<std::byte*>(::operator new(bytes.size(), std::align_val_t(64))))
        , size_(bytes.size()) {
        if (!bytes.empty()) std::memcpy(data_, bytes.data(), bytes.size());
    }
    Exact(const Exact&) = delete;
    Exact& operator=(const Exact&) = delete;
    ~Exact() { ::operator delete(data_, std::align_val_t(64)); }
    std::span<std::byte> bytes() const noexcept { return {data_, size_}; }

private:
    std::byte* data_;
    std::size_t size_;
};

/// As `std::vector`, with nothing allocated beyond the end.
template <class X>
class Array {
public:
    Array(std::size_t size, const X& value)
        : values_(new X[size])
        , size_(size) {
        for (std::size_t i = 0; i < size; ++i) values_[i] = value;
    }
    std::size_t size() const noexcept { return size_; }
    X* data() const noexcept { return values_.get(); }
    X& operator[](std::size_t i) const noexcept { return values_[i]; }

private:
    std::unique_ptr<X[]> values_;
    std::size_t size_;
};

BlobHeader header_of(std::span<const std::byte> bytes) {
    BlobHeader header;
    std::memcpy(&header, bytes.data(), std::min(bytes.size(), sizeof(header)));
    return header;
}

/// Puts the checksum right, where there is a blob that one could be taken of.
void seal(std::span<std::byte> bytes) {
    if (bytes.size() < sizeof(BlobHeader)) return;
    BlobHeader header = header_of(bytes);
    if (header.bytes < 32 || header.bytes > bytes.size()) return;
    header.checksum =
        cageform::hash_memory(std::span<const std::byte>(bytes).subspan(32, std::size_t(header.bytes) - 32));
    std::memcpy(bytes.data(), &header, sizeof(header));
}

/// One block at a time, from the last on.
struct BackwardFor {
    template <class Body>
    void operator()(std::size_t count, std::size_t /*grain*/, Body&& body) const {
        for (; count > 0; --count) body(count - 1, count);
    }
};

template <class T, std::size_t D, class Out>
void clone_with(const cageform::PackedBindingView<T, D>& binding, const Array<Vec<T, D>>& pose, Out&& out,
                const cageform::CloneOptions<T>& options) {
    const Status forward = clone(binding, pose, out, options, cageform::SerialFor{});
    REQUIRE(forward == Status::ok || forward == Status::pose_not_finite);
    REQUIRE(clone(binding, pose, out, options, BackwardFor{}) == forward);
}

/// `pose_handles` of vertices that all stand in one place, and of those at rest.
template <class T, std::size_t D>
void pose_vertices(const cageform::PackedBindingView<T, D>& binding) {
    const auto handles = binding.handle_view();
    const std::size_t vectors = handles.vector_count();
    Array<Vec<T, D>> vertices(handles.count - vectors, Vec<T, D>{1, 2});
    const Array<Vec<T, D>> posed(handles.count, Vec<T, D>{});
    const Status expected = vectors > 0 && handles.faces == nullptr ? Status::handles_not_faces : Status::ok;
    REQUIRE(pose_handles(binding, vertices, posed).status == expected);
    for (std::size_t i = 0, n = 0; i < handles.count; ++i) {
        if (handles.is_point(i)) vertices[n++] = handles.rest[i];
    }
    const Status at_rest = pose_handles(binding, vertices, posed).status;
    REQUIRE(at_rest == expected || at_rest == Status::pose_not_finite);
}

template <class T, std::size_t D>
void clone_all_ways(const cageform::PackedBindingView<T, D>& binding) {
    using cageform::CloneMode;
    using cageform::StridedPoints;
    const std::size_t points = binding.point_count(), handles = binding.handle_count();
    if (points > most || handles > most) return;
    const Array<Vec<T, D>> pose(handles, Vec<T, D>{1, 2});
    const Array<T> mask(points, T(0.5));
    const StridedPoints<const T, 1> masked(mask.data(), points);
    const Array<Vec<T, D>> out(points, Vec<T, D>{});
    clone_with(binding, pose, out, {});
    clone_with(binding, pose, out, {.mask = masked});
    clone_with(binding, pose, out, {.mode = CloneMode::add});
    clone_with(binding.in_order(), pose, out, {.mask = masked, .mode = CloneMode::add});

    const Array<T> numbers(points * D, T(0)); // all x, all y, …
    const StridedPoints<T, D> apart(numbers.data(), points, sizeof(T), std::ptrdiff_t(points * sizeof(T)));
    clone_with(binding, pose, apart, {});
    clone_with(binding.in_order(), pose, apart, {.mask = masked});
    const Array<Vec<double, D>> converted(points, Vec<double, D>{});
    clone_with(binding, pose, converted, {.mode = CloneMode::add});
    pose_vertices(binding);

    if (points > 0) { // one place too few is told before anything is written
        const Array<Vec<T, D>> less(points - 1, Vec<T, D>{});
        REQUIRE(clone(binding, pose, less) == Status::output_too_small);
    }
}

/// Opens bytes with and without their checksum. If they open, so do as many as they say and not one less, and
/// use(what) runs on what was opened without.
///
///   open      open(bytes, check): a Result
///   is_empty  is_empty(what): whether nothing was opened
template <class Open, class IsEmpty, class Use>
void open_and_use(std::span<const std::byte> bytes, const Open& open, const IsEmpty& is_empty,
                  const Use& use) {
    for (const BlobCheck check : {BlobCheck::all, BlobCheck::structure}) {
        const auto opened = open(bytes, check);
        if (opened.status() != Status::ok) {
            REQUIRE(is_empty(opened.value));
            continue;
        }
        REQUIRE(opened.report.bytes <= bytes.size());
        const auto again = [&](std::size_t size) { return open(bytes.first(size), check).status(); };
        REQUIRE(again(opened.report.bytes) == Status::ok && again(opened.report.bytes - 1) != Status::ok);
        if (check == BlobCheck::structure) use(opened.value);
    }
}

template <class T, std::size_t D>
void open_as(std::span<const std::byte> bytes) {
    open_and_use(
        bytes, [](auto some, BlobCheck check) { return cageform::open_blob<T, D>(some, {.check = check}); },
        [](const auto& what) { return what.point_count() == 0 && what.weights == nullptr; },
        [](const auto& what) { clone_all_ways(what); });
}

/// A clip at times within its range, far beyond and back, with a cursor in memory exactly as long as it
/// takes.
template <class T, std::size_t D>
void play(const cageform::CageClipView<T, D>& clip) {
    if (clip.vertex_count() > most) return;
    const Array<cageform::Lanes<T>> memory(clip.cursor_rows(), cageform::Lanes<T>());
    const Array<Vec<T, D>> pose(clip.vertex_count(), Vec<T, D>{});
    auto cursor = clip.make_cursor(std::span<cageform::Lanes<T>>(memory.data(), memory.size()));
    const double begin = clip.begin(), length = clip.end() - begin;
    for (const double part : {0.0, 0.01, 0.02, 1.0, 0.5, 0.49, 0.1, 3.0, -2.0, 1e9, -1e9, 0.3, 0.31}) {
        const double time = begin + part * length;
        if (cageform::is_finite(time)) clip.sample(time, cursor, {pose.data(), pose.size()});
    }
}

template <class T, std::size_t D>
void open_clip_as(std::span<const std::byte> bytes) {
    open_and_use(
        bytes, [](auto some, BlobCheck check) { return cageform::open_clip<T, D>(some, check); },
        [](const auto& what) { return what.vertex_count() == 0 && what.bank.knots.empty(); },
        [](const auto& what) { play(what); });
}

/// A solver with pins whose weights are any, for two frames; a matrix may have no solution.
template <class T, std::size_t D>
void solve(const cageform::PoseSamples<T, D>& samples) {
    const std::size_t handles = samples.handle_count();
    if (handles > 200) return;
    cageform::PoseSolver<T, D> solver(samples);
    REQUIRE(solver.status() == Status::ok || solver.status() == Status::pose_not_determined);
    const Array<cageform::Lanes<T>> weights(handles, [] {
        cageform::Lanes<T> row;
        for (std::size_t n = 0; n < cageform::lane_count<T>; ++n) row[n] = T(0.05) * T(n % 7);
        return row;
    }());
    const Array<cageform::Lanes<T>> rest(D, weights[0]);
    const cageform::BindingView<T, D> pins{{weights.data(), handles, 3},
                                           {rest.data(), D, 3},
                                           samples.rest_handles.data(),
                                           samples.handle_kinds.data(),
                                           nullptr,
                                           nullptr};
    if (solver.status() != Status::ok || solver.set_pins({.binding = pins}) != Status::ok) return;
    const Array<Vec<T, D>> targets(3, Vec<T, D>{1, 2}), pose(handles, Vec<T, D>{});
    for (int frame = 0; frame < 2; ++frame) {
        const Status status = solver.solve(targets, pose).status;
        REQUIRE(status == Status::ok || status == Status::pose_not_finite);
        for (std::size_t h = 0; h < handles; ++h) REQUIRE(cageform::is_finite(pose[h]));
    }
}

template <class T, std::size_t D>
void open_samples_as(std::span<const std::byte> bytes) {
    open_and_use(
        bytes,
        [](auto some, BlobCheck check) { return cageform::open_pose_samples<T, D>(some, {.check = check}); },
        [](const auto& what) { return what.handle_count() == 0 && what.gradients.empty(); },
        [](const auto& what) { solve(what); });
}

/// The figure that opens, cloned; its labels and parts, read; its clips, played.
template <class T, std::size_t D>
void play(const cageform::PackedFigureView<T, D>& figure) {
    std::size_t sum = 0;
    for (std::size_t h = 0; h < figure.handle_count(); ++h) {
        for (const char letter : figure.label(h)) sum += std::size_t(letter == 'x');
    }
    for (const auto& line : figure.table) {
        for (const std::byte byte : figure.part(line.tag)) sum += std::size_t(byte == std::byte{1});
    }
    for (std::size_t n = 0; n < figure.clip_count(); ++n) {
        sum += figure.find_clip(figure.clip_name(n));
        play(figure.clip(n));
    }
    for (std::size_t n = 1; n <= figure.level_count(); ++n) sum += open_level(figure, n).value.point_count();
    REQUIRE(sum + 1 > 0); // it is used
    const std::size_t points = figure.point_count(), handles = figure.handle_count();
    if (points > most || handles > most) return;
    const Array<Vec<T, D>> pose(handles, Vec<T, D>{1, 2}), out(points, Vec<T, D>{}),
        normals(points, Vec<T, D>{});
    const auto check = [&](Status status, bool there) {
        REQUIRE(status == Status::pose_not_finite ||
                status == (there ? Status::ok : Status::vectors_missing));
    };
    check(clone(figure, pose, cageform::FigureOutput{out, normals}), figure.has_normals());
    if constexpr (D == 3) {
        const Array<Vec<T, 4>> tangents(points, Vec<T, 4>{});
        check(clone(figure, pose, cageform::FigureOutput{out, normals, tangents}, BackwardFor{}),
              figure.has_tangents());
    }
}

template <class T, std::size_t D>
void open_figure_as(std::span<const std::byte> bytes) {
    open_and_use(
        bytes, [](auto some, BlobCheck check) { return cageform::open<T, D>(some, {.check = check}); },
        [](const auto& what) { return what.point_count() == 0 && what.table.empty(); },
        [](const auto& what) { play(what); });
}

void open_as_all(std::span<const std::byte> bytes) {
    open_figure_as<float, 3>(bytes);
    open_figure_as<double, 2>(bytes);
    open_clip_as<float, 3>(bytes);
    open_clip_as<double, 2>(bytes);
    open_samples_as<float, 3>(bytes);
    open_samples_as<double, 2>(bytes);
    open_as<float, 3>(bytes);
    open_as<double, 2>(bytes);
    open_as<float, 2>(bytes);
}

/// Numbers from a seed.
class Numbers {
public:
    explicit Numbers(std::uint64_t seed)
        : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
    std::uint64_t bits() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        return z ^ (z >> 31);
    }
    std::size_t below(std::size_t n) { return std::size_t((bits() >> 16) % n); }

private:
    std::uint64_t state_;
};

/// A blob of random counts whose parts are where they should be and whose tables make sense.
template <class T, std::size_t D>
std::vector<std::byte> made_up(Numbers& numbers) {
    // Now and then more handles than clones keep a table of.
    const bool many = numbers.below(8) == 0;
    const std::size_t handles = many                    ? 16384 / sizeof(Vec<T, D>) + numbers.below(8)
                                : numbers.below(4) == 0 ? numbers.below(3)
                                                        : 1 + numbers.below(40);
    const std::size_t points = numbers.below(4) == 0 ? numbers.below(2) : numbers.below(60);
    const std::size_t blocks = cageform::block_count<T>(points);
    const bool sparse = many || numbers.below(2) == 0;
    std::vector<std::uint32_t> row_begin(1, 0);
    for (std::size_t b = 0; b < blocks; ++b)
        row_begin.push_back(row_begin.back() + std::uint32_t(handles == 0 ? 0 : numbers.below(5)));
    BlobHeader header;
    header.format = many ? 0 : std::uint32_t(numbers.below(4));
    header.handles = handles;
    header.points = points;
    header.rows = sparse ? row_begin.back() : blocks * handles;
    header.row_begin = sparse ? 1 : 0;
    header.order = numbers.below(2);
    const std::size_t vectors = handles < 2 ? 0 : numbers.below(handles); // the last of the handles
    header.vectors = vectors;
    header.handle_kinds = vectors > 0 ? 1 : 0;
    header.handle_faces = vectors > 0 ? numbers.below(2) : 0;
    std::vector<std::uint32_t> loops; // whose means are corners of faces
    Numbers of_loops = numbers;       // a copy, which leaves all else as it is without loops
    if (header.handle_faces != 0 && of_loops.below(2) == 0) {
        const std::size_t count = 1 + of_loops.below(3);
        loops.push_back(std::uint32_t(count + 1));
        for (std::size_t l = 0; l < count; ++l)
            loops.push_back(loops.back() + std::uint32_t(1 + of_loops.below(4)));
        while (loops.size() < loops[count]) loops.push_back(std::uint32_t(of_loops.below(handles - vectors)));
    }
    header.handle_loops = loops.empty() ? 0 : 1;
    header.loop_numbers = std::uint32_t(loops.size());
    cageform::PackedBinding<T, D> packed(header);
    const auto view = packed.view();
    const auto open = [](auto* part) {
        return const_cast<std::remove_const_t<std::remove_pointer_t<decltype(part)>>*>(part);
    };
    if (sparse) {
        std::copy(row_begin.begin(), row_begin.end(), open(view.row_begin));
        for (std::size_t r = 0; r < header.rows; ++r)
            open(view.row_handle)[r] = std::uint16_t(numbers.below(handles));
    }
    if (header.order != 0) {
        for (std::size_t i = 0; i < points; ++i) open(view.order)[i] = std::uint32_t(numbers.below(points));
    }
    for (std::size_t n = 0; n < vectors; ++n) {
        open(view.handle_kinds)[handles - vectors + n] = cageform::HandleKind::vector;
        if (view.handle_faces == nullptr) continue;
        for (auto& corner : open(view.handle_faces)[n])
            corner = std::uint32_t(numbers.below(handles - vectors));
        if (!loops.empty())
            open(view.handle_faces)[n][D - 1] = std::uint32_t(handles + of_loops.below(loops[0] - 1));
    }
    std::copy(loops.begin(), loops.end(), open(view.handle_loops));
    packed.seal();
    return {packed.bytes().begin(), packed.bytes().end()};
}

/// A clip that is sound, of curves with up to a few pieces, some in 16 bits, and perhaps a motion.
template <class T, std::size_t D>
std::vector<std::byte> packed_clip(Numbers& numbers, std::size_t vertices) {
    const auto random = [&] { return T(double(numbers.below(2001)) / 1000 - 1); };
    const auto curve = [&] {
        std::vector<cageform::CubicPiece<T>> pieces;
        T time = random();
        for (std::size_t n = 1 + numbers.below(4); n > 0; --n) {
            pieces.push_back({time, random(), random(), random(), random()});
            time += T(1 + numbers.below(100)) / T(32);
        }
        return numbers.below(4) == 0 ? cageform::PiecewiseCubic<T>(std::move(pieces), time, random())
                                     : cageform::PiecewiseCubic<T>(std::move(pieces), time);
    };
    std::vector<cageform::PiecewiseCubic<T>> curves;
    while (curves.size() < vertices * D) curves.push_back(curve());
    const auto mode = [&] { return cageform::Extrapolation(numbers.below(5)); };
    const auto before = mode(), after = mode();
    cageform::CageClip<T, D> clip(curves, before, after);
    if (numbers.below(2) == 0) {
        cageform::RigidMotion<T, D> motion;
        const auto track = [&] {
            return numbers.below(3) == 0 ? cageform::Track<T>{} : cageform::Track<T>{curve(), mode(), mode()};
        };
        motion.angle = track();
        motion.phase = track();
        for (auto& axis : motion.translation) axis = track();
        for (std::size_t n = D == 3 ? numbers.below(4) : 0; n > 0; --n)
            motion.rotations.push_back({0, 0, random(), 1});
        clip.set_rigid_motion(motion);
    }
    const auto result = pack_clip(clip, {.tolerance = numbers.below(2) == 0 ? 0 : 2e-5});
    if (result.report.status == Status::value_not_finite)
        return packed_clip<T, D>(numbers, vertices); // another
    REQUIRE(result.report.status == Status::ok);
    return {result.value.bytes().begin(), result.value.bytes().end()};
}

/// The part of a figure that holds clips: of its vertices, or now and then of others.
template <class T, std::size_t D>
std::vector<std::byte> clip_part(Numbers& numbers, std::size_t vertices) {
    std::vector<std::byte> part(64 + 64 * numbers.below(2));
    const std::uint64_t count = numbers.below(3);
    std::memcpy(part.data(), &count, sizeof(count));
    for (std::size_t n = 0; n < count; ++n) {
        const auto clip = packed_clip<T, D>(numbers, numbers.below(16) == 0 ? vertices + 1 : vertices);
        const cageform::FigureClip line{part.size(), clip.size(), 56, std::uint32_t(numbers.below(9))};
        std::memcpy(part.data() + 8 + 24 * n, &line, sizeof(line));
        part.insert(part.end(), clip.begin(), clip.end());
    }
    return part;
}

/// Samples that are sound, with or without what no frame reads, of a matrix that mostly has a solution.
template <class T, std::size_t D>
std::vector<std::byte> packed_samples(Numbers& numbers) {
    const auto random = [&] { return double(numbers.below(2001)) / 1000 - 1; };
    cageform::PoseSamples<T, D> samples;
    const std::size_t handles = 1 + numbers.below(12), blocks = 1 + numbers.below(2);
    samples.cluster_count = blocks * cageform::lane_count<T> - numbers.below(cageform::lane_count<T>);
    samples.rest_handles.resize(handles);
    for (auto& h : samples.rest_handles) {
        for (T& x : h.v) x = T(random());
    }
    for (std::size_t i = 0; i < handles; ++i)
        samples.handle_kinds.push_back(cageform::HandleKind(numbers.below(4) / 3));
    samples.size = 2;
    samples.gradients.resize(blocks * handles * D);
    samples.moments.resize(blocks * D * D);
    for (auto* rows : {&samples.gradients, &samples.moments}) {
        for (auto& row : *rows) {
            for (T& x : row.v) x = T(random());
        }
    }
    for (std::size_t i = 0; i < handles; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
            samples.stiffness.push_back(i == j ? double(handles) : 0.9 * random());
        if (numbers.below(4) == 0) samples.weak_handles.push_back(std::uint32_t(i));
    }
    for (std::size_t s = 1 + numbers.below(40); s > 0; --s) {
        samples.points.push_back({T(random()), T(random())});
        samples.clusters.push_back(std::uint32_t(numbers.below(samples.cluster_count)));
    }
    for (std::size_t c = 0; c < samples.cluster_count; ++c)
        samples.centres.push_back(std::uint32_t(numbers.below(samples.points.size())));
    const auto result = pack(samples, {.keep_points = numbers.below(2) == 0});
    REQUIRE(result.status() == Status::ok);
    return {result.value.bytes().begin(), result.value.bytes().end()};
}

/// A binding packed by the library itself.
template <class T, std::size_t D>
std::vector<std::byte> packed(Numbers& numbers, const cageform::PackOptions& options) {
    const std::size_t handles = D + 2 + numbers.below(10), points = 1 + numbers.below(60);
    const std::size_t blocks = cageform::block_count<T>(points);
    const auto random = [&] { return T(double(numbers.below(2001)) / 1000 - 1); };
    std::vector<cageform::Lanes<T>> weights(blocks * handles), rest(blocks * D);
    std::vector<Vec<T, D>> rest_handles(handles);
    for (auto& lanes : weights) {
        for (T& w : lanes.v) w = random();
    }
    for (auto& lanes : rest) {
        for (T& x : lanes.v) x = random();
    }
    for (auto& c : rest_handles) {
        for (T& x : c.v) x = random();
    }
    const auto result = cageform::pack(cageform::Binding<T, D>(weights, rest, rest_handles, points), options);
    REQUIRE(result.report.status == Status::ok);
    return {result.value.bytes().begin(), result.value.bytes().end()};
}

/// Sets or shifts a number by what may matter; `limit` is one that others are checked against.
template <class X>
void disturb(std::byte* at, Numbers& numbers, std::size_t limit) {
    X x;
    std::memcpy(&x, at, sizeof(x));
    const X values[] = {X(0),
                        X(1),
                        X(x + 1),
                        X(x - 1),
                        X(x + 64),
                        X(x - 64),
                        X(2 * x),
                        X(x / 2),
                        X(limit),
                        X(limit - 1),
                        X(~X(0)),
                        X(numbers.below(limit)),
                        X(192),
                        X(~X(63)),
                        X(x ^ (X(1) << numbers.below(8 * sizeof(X)))),
                        X(numbers.below(limit) & ~std::size_t{63}),
                        X(numbers.bits())};
    x = values[numbers.below(std::size(values))];
    std::memcpy(at, &x, sizeof(x));
}

/// A figure whose parts are one blob over and over, or now and then several.
template <class T, std::size_t D>
std::vector<std::byte> made_up_figure(Numbers& numbers) {
    using cageform::FigureTags;
    const auto blob = made_up<T, D>(numbers), other = made_up<T, D>(numbers);
    const BlobHeader header = header_of(blob);
    const auto any = [&]() -> const std::vector<std::byte>& { return numbers.below(16) == 0 ? other : blob; };
    std::vector<std::int8_t> signs(std::size_t(header.points), std::int8_t(1));
    std::vector<std::uint32_t> labels{0};
    for (std::size_t h = 0; h < header.handles; ++h)
        labels.push_back(labels.back() + std::uint32_t(numbers.below(3)));
    labels.resize(labels.size() + (labels.back() + 3) / 4, 0x78787878u);
    const auto& points = any();
    const auto& tangents = any();
    const auto& bitangents = any();
    std::vector<cageform::FigurePartData> parts{{FigureTags::points, points}};
    if (numbers.below(8) != 0) {
        parts.push_back({FigureTags::tangents, tangents});
        if (D == 3) parts.push_back({FigureTags::bitangents, bitangents});
        if (numbers.below(4) != 0) parts.push_back({FigureTags::handedness, std::as_bytes(std::span(signs))});
    }
    if (numbers.below(4) != 0) parts.push_back({FigureTags::labels, std::as_bytes(std::span(labels))});
    if (numbers.below(4) == 0) parts.push_back({"ELSE", std::as_bytes(std::span(signs))});
    std::vector<std::byte> clips;
    if (header.handles <= 64 && numbers.below(2) == 0) {
        clips = clip_part<T, D>(numbers, std::size_t(header.handles - numbers.below(2) * header.vectors));
        parts.push_back({FigureTags::clips, clips});
    }
    const cageform::FigurePartData of_level[] = {{FigureTags::points, any()}};
    const cageform::PackedFigure<T, D> level(of_level);
    for (std::size_t n = numbers.below(3) == 0 ? numbers.below(3) : 0; n > 0; --n)
        parts.push_back({FigureTags::level(n), level.bytes()});
    const cageform::PackedFigure<T, D> figure(parts);
    return {figure.bytes().begin(), figure.bytes().end()};
}

/// Changes the table of a figure, or what its parts hold.
void disturb_figure(std::span<std::byte> bytes, Numbers& numbers) {
    cageform::FigureHeader header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    const std::size_t lines = std::min<std::size_t>(header.parts, 8);
    for (std::size_t n = 1 + numbers.below(3); n > 0 && lines > 0; --n) {
        const auto line_at = [](std::size_t line) {
            return sizeof(header) + line * sizeof(cageform::FigurePart);
        };
        const std::size_t at = line_at(numbers.below(lines)), from = line_at(numbers.below(lines));
        cageform::FigurePart part;
        if (std::max(at, from) + sizeof(part) > bytes.size()) return;
        std::memcpy(&part, bytes.data() + at, sizeof(part));
        switch (numbers.below(5)) {
        case 0: disturb<std::uint64_t>(bytes.data() + at + 8, numbers, bytes.size()); break;
        case 1: disturb<std::uint64_t>(bytes.data() + at + 16, numbers, std::size_t(part.bytes | 1)); break;
        case 2: std::memmove(bytes.data() + at + 8 * numbers.below(2), bytes.data() + from, 8); break;
        case 3:
            disturb<std::uint32_t>(bytes.data() + offsetof(cageform::FigureHeader, parts), numbers, 8);
            break;
        default: {
            const std::size_t place = std::size_t(part.offset) + 4 * numbers.below(64);
            if (part.offset < bytes.size() && place + 8 <= bytes.size())
                numbers.below(2) == 0 ? disturb<std::uint32_t>(bytes.data() + place, numbers, bytes.size())
                                      : disturb<std::uint64_t>(bytes.data() + place, numbers, bytes.size());
        }
        }
    }
    cageform::FigureHeader plausible;
    std::memcpy(&header, bytes.data(), sizeof(header));
    plausible.bytes = numbers.below(8) == 0 ? header.bytes : bytes.size() / 64 * 64;
    plausible.checksum = header.checksum;
    plausible.parts = header.parts;
    plausible.scalar_bytes = header.scalar_bytes;
    plausible.dimension = header.dimension;
    std::memcpy(bytes.data(), &plausible, sizeof(plausible));
}

/// Changes the counts and offsets of a clip, or what its parts hold.
void disturb_clip(std::span<std::byte> bytes, Numbers& numbers) {
    using cageform::ClipHeader;
    constexpr std::size_t counts = offsetof(ClipHeader, curves), times = offsetof(ClipHeader, begin),
                          offsets = offsetof(ClipHeader, curve_table);
    for (std::size_t n = 1 + numbers.below(3); n > 0; --n) {
        switch (numbers.below(6)) {
        case 0: disturb<std::uint64_t>(bytes.data() + counts + 8 * numbers.below(4), numbers, 64); break;
        case 1: disturb<std::uint64_t>(bytes.data() + times + 8 * numbers.below(2), numbers, 64); break;
        case 2:
            disturb<std::uint64_t>(bytes.data() + offsets + 8 * numbers.below(12), numbers, bytes.size());
            break;
        case 3: disturb<std::uint32_t>(bytes.data() + 40 + 4 * numbers.below(2), numbers, 6); break;
        default: {
            const std::size_t at = 4 * numbers.below(bytes.size() / 4);
            numbers.below(2) == 0 ? disturb<std::uint32_t>(bytes.data() + at, numbers, bytes.size())
                                  : disturb<std::uint16_t>(bytes.data() + at, numbers, 64);
        }
        }
    }
    ClipHeader header;
    const ClipHeader plausible;
    std::memcpy(&header, bytes.data(), sizeof(header));
    header.magic = plausible.magic;
    header.version = plausible.version;
    header.endian = plausible.endian;
    header.bytes = numbers.below(8) == 0 ? header.bytes : bytes.size() / 64 * 64;
    std::memcpy(bytes.data(), &header, sizeof(header));
}

/// Changes the counts and offsets of samples, or what their parts hold.
void disturb_samples(std::span<std::byte> bytes, Numbers& numbers) {
    using cageform::PoseBlobHeader;
    constexpr std::size_t counts = offsetof(PoseBlobHeader, handles),
                          offsets = offsetof(PoseBlobHeader, rest_handles);
    for (std::size_t n = 1 + numbers.below(3); n > 0; --n) {
        switch (numbers.below(4)) {
        case 0: disturb<std::uint64_t>(bytes.data() + counts + 8 * numbers.below(4), numbers, 64); break;
        case 1:
            disturb<std::uint64_t>(bytes.data() + offsets + 8 * numbers.below(9), numbers, bytes.size());
            break;
        default: {
            const std::size_t at = 4 * numbers.below(bytes.size() / 4 - 1);
            numbers.below(2) == 0 ? disturb<std::uint32_t>(bytes.data() + at, numbers, bytes.size())
                                  : disturb<std::uint64_t>(bytes.data() + at, numbers, 64);
        }
        }
    }
    PoseBlobHeader header;
    const PoseBlobHeader plausible;
    std::memcpy(&header, bytes.data(), sizeof(header));
    header.magic = plausible.magic;
    header.version = plausible.version;
    header.endian = plausible.endian;
    header.bytes = numbers.below(8) == 0 ? header.bytes : bytes.size() / 64 * 64;
    std::memcpy(bytes.data(), &header, sizeof(header));
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Exact memory(std::as_bytes(std::span(data, size)));
    open_as_all(memory.bytes());
    seal(memory.bytes());
    open_as_all(memory.bytes());
    return 0;
}

/// Keeps what every blob begins with, and changes numbers that others are checked against.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
    Numbers numbers(seed);
    const std::size_t way = numbers.below(8);
    if (way == 0 || size < sizeof(BlobHeader)) {
        const std::size_t kind = numbers.below(10);
        const auto blob = kind == 0   ? made_up<float, 3>(numbers)
                          : kind == 1 ? made_up<double, 2>(numbers)
                          : kind == 3 ? made_up_figure<double, 2>(numbers)
                          : kind == 4 ? packed_clip<float, 3>(numbers, numbers.below(9))
                          : kind == 5 ? packed_clip<double, 2>(numbers, numbers.below(9))
                          : kind == 6 ? packed_samples<float, 3>(numbers)
                          : kind == 7 ? packed_samples<double, 2>(numbers)
                          : kind >= 8 ? made_up_figure<float, 3>(numbers)
                                      : made_up<float, 2>(numbers);
        if (blob.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
        std::memcpy(data, blob.data(), blob.size());
        return blob.size();
    }
    if (way == 1) return LLVMFuzzerMutate(data, size, max_size);
    auto* const bytes = reinterpret_cast<std::byte*>(data);
    if (header_of({bytes, size}).magic == cageform::FigureHeader::magic_number) {
        disturb_figure({bytes, size}, numbers);
        return size;
    }
    if (header_of({bytes, size}).magic == cageform::ClipHeader::magic_number) {
        disturb_clip({bytes, size}, numbers);
        return size;
    }
    if (header_of({bytes, size}).magic == cageform::PoseBlobHeader::magic_number) {
        disturb_samples({bytes, size}, numbers);
        return size;
    }
    if (way == 2) { // what follows the header alone
        size = sizeof(BlobHeader) + LLVMFuzzerMutate(data + sizeof(BlobHeader), size - sizeof(BlobHeader),
                                                     max_size - sizeof(BlobHeader));
    }
    for (std::size_t n = 1 + numbers.below(3); n > 0; --n) {
        constexpr std::size_t counts = offsetof(BlobHeader, handles), offsets = offsetof(BlobHeader, weights);
        const BlobHeader header = header_of({bytes, size});
        const std::uint64_t tables[] = {header.row_begin,    header.row_handle,   header.order,
                                        header.rest_handles, header.handle_kinds, header.handle_faces,
                                        header.handle_loops};
        const std::uint64_t table = tables[numbers.below(7)];
        const std::uint64_t limits[] = {size, header.handles, header.points, header.rows};
        const auto limit = std::max<std::size_t>(std::size_t(limits[numbers.below(4)]), 1);
        switch (numbers.below(5)) {
        case 0: disturb<std::uint64_t>(bytes + counts + 8 * numbers.below(3), numbers, limit); break;
        case 1: disturb<std::uint64_t>(bytes + offsets + 8 * numbers.below(12), numbers, limit); break;
        case 2: { // a part in the place of another, or none
            const std::size_t to = offsets + 8 * numbers.below(12), from = offsets + 8 * numbers.below(12);
            std::memmove(bytes + to, bytes + from, 8);
            break;
        }
        case 3: {
            const std::uint32_t format = std::uint32_t(numbers.below(5));
            std::memcpy(bytes + offsetof(BlobHeader, format), &format, 4);
            break;
        }
        default: {
            const std::size_t at = std::size_t(table) + 2 * numbers.below(64);
            if (table >= size || at + 4 > size) break;
            numbers.below(2) == 0 ? disturb<std::uint16_t>(bytes + at, numbers, limit)
                                  : disturb<std::uint32_t>(bytes + at, numbers, limit);
        }
        }
    }
    BlobHeader header = header_of({bytes, size});
    const BlobHeader plausible;
    header.magic = plausible.magic;
    header.version = plausible.version - (numbers.below(16) == 0 ? 1 : 0);
    header.endian = plausible.endian;
    header.bytes = numbers.below(8) == 0 ? header.bytes : size / 64 * 64;
    header.scalar_bytes =
        numbers.below(16) == 0 ? 4 + 4 * std::uint32_t(numbers.below(2)) : header.scalar_bytes;
    header.dimension = numbers.below(16) == 0 ? 2 + std::uint32_t(numbers.below(2)) : header.dimension;
    std::memcpy(bytes, &header, sizeof(header));
    return size;
}

/// --seeds=FOLDER writes blobs to begin with, and ends.
extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
    const std::string option = "--seeds=";
    for (int n = 1; n < *count; ++n) {
        const std::string argument = (*arguments)[n];
        if (argument.compare(0, option.size(), option) != 0) continue;
        Numbers numbers(1);
        int written = 0;
        const auto write = [&](const std::vector<std::byte>& blob) {
            const std::string name = argument.substr(option.size()) + "/" + std::to_string(written++);
            std::FILE* const file = std::fopen(name.c_str(), "wb");
            REQUIRE(file != nullptr);
            REQUIRE(std::fwrite(blob.data(), 1, blob.size(), file) == blob.size());
            REQUIRE(std::fclose(file) == 0);
        };
        for (const WeightFormat format :
             {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
            for (const std::size_t largest : {0u, 4u}) {
                write(packed<float, 3>(numbers, {.format = format, .largest = largest}));
                write(packed<double, 2>(numbers, {.format = format, .largest = largest}));
                write(packed<float, 2>(numbers, {.format = format, .largest = largest}));
                write(made_up_figure<float, 3>(numbers));
                write(made_up_figure<double, 2>(numbers));
                write(packed_clip<float, 3>(numbers, 5));
                write(packed_clip<double, 2>(numbers, 4));
                write(packed_samples<float, 3>(numbers));
                write(packed_samples<double, 2>(numbers));
            }
        }
        std::printf("%d blobs\n", written);
        std::exit(0);
    }
    return 0;
}
