// Frames of an engine that allows no allocation once all is loaded: operator new ends the program then.
#include "made_up.hpp"

#include <cageform/clone/clone_transposed.hpp>
#include <cageform/runtime.hpp>

#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

bool loaded = false;
std::size_t allocations = 0;

void* allocate(std::size_t size, std::size_t alignment) noexcept {
    if (loaded) {
        std::printf("failed: an allocation of %zu bytes in a frame\n", size);
        std::_Exit(1);
    }
    ++allocations;
    return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

} // namespace

void* operator new(std::size_t size) {
    return allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    return allocate(size, std::size_t(alignment));
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}

namespace {

using cageform::Status;
using cageform::WeightFormat;

alignas(64) std::byte file[1 << 21]; ///< as a file of blobs is mapped
std::size_t file_bytes = 0;

/// Puts a blob behind those that are there.
void save(std::span<const std::byte> blob) {
    if (blob.size() > sizeof(file) - file_bytes) return; // is found out by their count
    std::memcpy(file + file_bytes, blob.data(), blob.size());
    file_bytes += blob.size();
}

// The functions of double that symbols.cpp finds do not allocate either.
int play(std::size_t points, std::size_t handles) {
    using T = float;
    using Vector = cageform::Vec<T, 3>;
    const auto dense = made_up::binding<T, 3>(points, handles, 1);
    const auto clip = made_up::clip<T, 3>(handles, cageform::Extrapolation::ping_pong, 2);
    auto cursor = clip.make_cursor();
    std::vector<Vector> pose(handles), gradients(handles), figure(points), normals(points), tangents(points);
    std::vector<T> numbers(points * 9), mask(points, T(0.5));
    std::vector<std::array<float, 4>> uniforms(handles + 4), signed_tangents(points);
    const auto whole = made_up::figure<T>(WeightFormat::int16, true, points, handles, 5);
    file_bytes = 0;
    for (const bool sparse : {false, true}) {
        for (const auto format :
             {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8})
            save(made_up::packed_binding<T, 3>(format, sparse, points, handles, 3).bytes());
    }

    loaded = true;
    int failures = 0;
    const auto expect = [&failures](Status status) { failures += status == Status::ok ? 0 : 1; };
    for (int frame = 0; frame < 30; ++frame) {
        clip.sample(T(frame) / 4, cursor, pose);
        expect(clone(dense, pose, figure));
        const std::array<cageform::BindingView<T, 3>, 3> axes{dense.view(), dense.view(), dense.view()};
        expect(clone_normals(std::array{axes[0], axes[1]}, pose, normals));
        const cageform::StridedMatrices<T, 3> jacobians(numbers.data(), points);
        expect(clone_jacobians(axes, pose, jacobians));
        expect(clone_jacobians_transposed(axes, jacobians, gradients));
        expect(clone_normals_transposed(std::array{axes[0], axes[1]}, pose, normals, gradients));
        const auto opened = cageform::open<T, 3>(whole.bytes());
        expect(opened.status());
        expect(clone(opened.value, pose, cageform::FigureOutput{figure, normals, signed_tangents}));
        std::size_t blobs = 0;
        for (std::size_t at = 0; at < file_bytes; ++blobs) {
            const auto blob =
                cageform::open_blob<T, 3>(std::span<const std::byte>(file, file_bytes).subspan(at));
            expect(blob.status());
            if (blob.status() != Status::ok) break;
            at += blob.report.bytes;
            expect(clone(blob.value, pose, figure, {{mask.data(), points}, cageform::CloneMode::add}));
            expect(clone_tangent_frames(std::array{blob.value, blob.value}, pose, normals, tangents));
            expect(write_displacements(blob.value, pose, uniforms));
            expect(clone_transposed(blob.value, figure, gradients, {{mask.data(), points}}));
        }
        failures += blobs == 8 ? 0 : 1;
    }
    loaded = false;
    return failures;
}

/// A thousand frames of the clip in a file with a figure: nothing is allocated from before it is opened,
/// and the cursor's memory is the player's.
int play_file(std::size_t points, std::size_t handles) {
    using Vector = cageform::Vec<float, 3>;
    const auto file_of_figure = made_up::figure<float>(WeightFormat::int8, true, points, handles, 5);
    const auto clip_in_memory =
        made_up::clip<float, 3>(handles, cageform::Extrapolation::cycle_with_offset, 5);
    std::vector<Vector> pose(handles), expected(handles), figure(points), normals(points);
    std::vector<cageform::Lanes<float>> memory(clip_in_memory.view().cursor_rows());
    auto beside = clip_in_memory.make_cursor();
    loaded = true;
    int failures = 0;
    const auto opened = cageform::open<float, 3>(file_of_figure.bytes());
    failures += opened.status() == Status::ok && opened.value.clip_count() == 1 ? 0 : 1;
    const auto clip = opened.value.clip(opened.value.find_clip("play"));
    failures += clip.vertex_count() == handles && clip.cursor_rows() == memory.size() ? 0 : 1;
    auto cursor = clip.make_cursor(memory);
    for (int frame = 0; frame < 1000; ++frame) {
        const float time = float(frame % 300 == 7 ? -frame : frame) / 60;
        clip.sample(time, cursor, pose);
        clip_in_memory.sample(time, beside, expected);
        failures += pose == expected ? 0 : 1;
        failures += clone(opened.value, pose, cageform::FigureOutput{figure, normals}) == Status::ok ? 0 : 1;
    }
    loaded = false;
    return failures;
}

} // namespace

int main() {
    int failures = play(777, 9);
    failures += play(50, 1500); // more handles than the table of displacements holds
    failures += play_file(777, 30);
    if (allocations == 0) failures = 1; // or operator new was not replaced
    std::printf(failures == 0 ? "ok\n" : "%d failures\n", failures);
    return failures;
}
