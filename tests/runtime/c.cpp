// The C interface as a game has it: without exceptions and RTTI, in memory of the caller.
#define CAGEFORM_C_IMPLEMENTATION
#define CAGEFORM_C_RUNTIME_ONLY
#include <cageform/c/cageform.h>

#include "made_up.hpp"

#include <cstdio>
#include <vector>

namespace {

int failures = 0;

void check(bool holds, const char* what) {
    if (holds) return;
    ++failures;
    std::printf("failed: %s\n", what);
}

template <class T>
void play_figure() {
    using Points = std::vector<cageform::Vec<T, 3>>;
    constexpr std::size_t points = 1000, handles = 20;
    const auto whole = made_up::figure<T>(cageform::WeightFormat::int16, true, points, handles, 5);
    const auto bytes = whole.bytes();
    alignas(64) static std::byte memory[4096];
    cageform_open_options options{};
    options.size = sizeof(options);
    options.memory = memory;
    options.memory_bytes = sizeof(memory);
    cageform_figure* figure = nullptr;
    check(cageform_open(bytes.data(), bytes.size(), &options, &figure, nullptr) == CAGEFORM_OK, "open");
    cageform_figure_info info{};
    info.size = sizeof(info);
    check(cageform_figure_describe(figure, &info) == CAGEFORM_OK && info.points == points, "describe");
    const auto view = [](auto& its) {
        cageform_output out{};
        out.data = its.data();
        out.count = its.size();
        out.bytes = its.size() * sizeof(its[0]);
        out.scalar = sizeof(T) == sizeof(double) ? CAGEFORM_DOUBLE : CAGEFORM_FLOAT;
        out.dimension = 3;
        return out;
    };
    Points pose(info.handles), out(info.points), normals(out), expected(out), turned(out);
    check(cageform_figure_rest(figure, view(pose)) == CAGEFORM_OK, "rest");
    pose[3][1] += 1;
    const auto posed = view(pose), to = view(normals);
    const cageform_points from{posed.data, posed.count, 0, posed.bytes, posed.scalar, posed.dimension};
    check(cageform_clone(figure, from, view(out), info.has_normals ? &to : nullptr, nullptr, nullptr) ==
              CAGEFORM_OK,
          "clone");
    const auto opened = cageform::open<T, 3>(bytes);
    if (info.has_normals)
        check(clone(opened.value, pose, cageform::FigureOutput{expected, turned}) == cageform::Status::ok,
              "C++");
    else
        check(clone(opened.value, pose, expected) == cageform::Status::ok, "C++");
    check(out == expected && normals == turned, "the bits of C++");
    check(cageform_free(figure) == CAGEFORM_OK, "free");
}

} // namespace

int main() {
    play_figure<float>();
    play_figure<double>();
    return failures == 0 ? 0 : 1;
}
