// One program with a clone for each level of processors: those that this one has agree to rounding, or to
// the bit under CAGEFORM_DETERMINISTIC. Compiled for the lowest level.
#include "../runtime/made_up.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>

#define CAGEFORM_TEST_LEVEL(level)                                                                           \
    bool clone_##level(const std::byte*, std::size_t, const float*, std::size_t, float*, std::size_t);       \
    const char* namespace_##level();
CAGEFORM_TEST_LEVEL(sse2)
CAGEFORM_TEST_LEVEL(avx)
CAGEFORM_TEST_LEVEL(fma)
CAGEFORM_TEST_LEVEL(avx512)

namespace {

struct Level {
    bool (*clone)(const std::byte*, std::size_t, const float*, std::size_t, float*, std::size_t);
    const char* name;
    bool is_there;
};

int failures = 0;
void expect(bool holds, const char* what, const char* level) {
    if (holds) return;
    std::printf("failed: %s, %s\n", what, level);
    ++failures;
}

} // namespace

int main() {
    constexpr std::size_t points = 300, handles = 30;
    const auto packed =
        made_up::packed_binding<float, 3>(cageform::WeightFormat::half, true, points, handles, 1);
    const auto pose = made_up::points<float, 3>(handles, 2);
    const auto clone = [&](const Level& level) {
        std::vector<float> out(3 * points);
        expect(
            level.clone(packed.bytes().data(), packed.bytes().size(), pose[0].v, handles, out.data(), points),
            "a clone", level.name);
        return out;
    };
    const bool has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
    const Level levels[] = {
        {clone_sse2, namespace_sse2(), true},
        {clone_avx, namespace_avx(), bool(__builtin_cpu_supports("avx"))},
        {clone_fma, namespace_fma(), __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")},
        {clone_avx512, namespace_avx512(), has_avx512 && __builtin_cpu_supports("fma")},
    };
    const auto lowest = clone(levels[0]);
    for (const Level& level : levels) {
        for (const Level& other : levels)
            expect(&level == &other || std::strcmp(level.name, other.name) != 0, "names that differ",
                   level.name);
        std::printf("%s %s\n", level.name, level.is_there ? "" : "is not of this processor");
        if (!level.is_there) continue;
        const auto out = clone(level);
        bool is_equal = true;
        for (std::size_t n = 0; n < out.size(); ++n) {
#if defined(CAGEFORM_DETERMINISTIC)
            is_equal = is_equal && std::memcmp(&out[n], &lowest[n], sizeof(float)) == 0;
#else
            // 30 products of numbers up to 8 · 1/30, each rounded once or twice, beside a place up to 4
            is_equal = is_equal && std::fabs(out[n] - lowest[n]) <= 64 * 8 * cageform::epsilon<float>;
#endif
        }
        expect(is_equal, "the clone of the lowest level", level.name);
    }
    return failures;
}
