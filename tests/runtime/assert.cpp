// An engine's own assert: defined before the first include it is told of a broken promise, and nothing else
// is.
namespace {
int failed_asserts = 0;
const char* last_reason = "";
} // namespace
#define CAGEFORM_ASSERT(condition, why)                                                                      \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            ++failed_asserts;                                                                                \
            last_reason = why;                                                                               \
        }                                                                                                    \
    } while (false)

#include "made_up.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/normals.hpp>

#include <cstdio>

#if defined(assert)
#error "an assert of one's own, and <cassert> all the same"
#endif

int main() {
    int failures = 0;
    const auto expect = [&failures](bool condition, const char* what) {
        if (condition) return;
        std::printf("failed: %s\n", what);
        ++failures;
    };
    const auto binding = made_up::binding<float, 3>(20, 4, 1);
    const auto pose = made_up::points<float, 3>(4, 2);
    std::vector<cageform::Vec<float, 3>> out(20);
    expect(cageform::clone(binding, pose, out) == cageform::Status::ok, "clone");
    expect(cageform::clone(binding, out, out) == cageform::Status::pose_size_differs,
           "a bad input is a status");
    expect(failed_asserts == 0, "and no broken promise");

    const cageform::Binding<float, 3> too_short(std::vector<cageform::Lanes<float>>(1), {}, pose, 0);
    expect(failed_asserts == 1 && std::strcmp(last_reason, "one row per handle") == 0,
           "rows that are missing");
    const auto tangents = made_up::packed_binding<float, 3>(cageform::WeightFormat::half, true, 20, 4, 3);
    expect(cageform::clone_normals(std::array{tangents.view(), tangents.view().in_order()}, pose, out) ==
                   cageform::Status::bindings_differ &&
               failed_asserts == 1,
           "tangents and bitangents in different orders: a status, not an assertion");
    if (failures == 0) std::printf("ok\n");
    return failures;
}
