// The run-time headers as an engine uses them: no exceptions, no RTTI, no dependency, no bind-time header.
// The same program also runs under -ffast-math.
#include <cageform/clone/clone.hpp>
#include <cageform/fwd.hpp>

#include <array>
#include <bit>
#include <cstdio>

bool second_file_agrees(const cageform::BindingView<float, 3>& binding);
bool clip_plays();

namespace {

using cageform::Status;

int failures = 0;

void expect(bool condition, const char* what) {
    if (condition) return;
    std::printf("failed: %s\n", what);
    ++failures;
}

} // namespace

int main() {
    // Twenty points of a bar, half way between two handles on the left and two on the right.
    constexpr std::size_t points = 20;
    constexpr std::size_t handles = 4;
    using Lanes = cageform::Lanes<float>;
    const std::array<cageform::Vec<float, 3>, handles> rest_handles{
        {{0, 0, 0}, {0, 1, 0}, {10, 0, 0}, {10, 1, 0}}};
    std::array<Lanes, cageform::block_count<float>(points) * handles> weights;
    std::array<Lanes, cageform::block_count<float>(points) * 3> rest;
    const cageform::BlockView<float> weight_view{weights.data(), handles, points};
    const cageform::BlockView<float> rest_view{rest.data(), 3, points};
    for (std::size_t i = 0; i < points; ++i) {
        const float along = float(i) / float(points - 1);
        const std::array<float, handles> w{(1 - along) / 2, (1 - along) / 2, along / 2, along / 2};
        for (std::size_t h = 0; h < handles; ++h) weight_view(i, h) = w[h];
        const std::array<float, 3> p{10 * along, 0.5f, 0.1f};
        for (std::size_t k = 0; k < 3; ++k) rest_view(i, k) = p[k];
    }
    const cageform::BindingView<float, 3> binding{weight_view, rest_view, rest_handles.data()};

    std::array<std::array<float, 3>, points> out{};
    expect(cageform::clone(binding, rest_handles, out) == Status::ok, "clone of the rest pose");
    for (std::size_t i = 0; i < points; ++i) {
        for (std::size_t k = 0; k < 3; ++k) expect(out[i][k] == rest_view(i, k), "rest pose bit for bit");
    }

    auto pose = rest_handles;
    pose[2][2] = pose[3][2] = 4;
    expect(cageform::clone(binding, pose, out) == Status::ok, "clone of a pose");
    expect(out[0][2] == 0.1f && out[points - 1][2] > 4.0f, "only the right end rises");

    const auto before = out;
    pose[0][0] = std::bit_cast<float>(0x7f800000u); // an infinity that -ffast-math does not deny
    expect(cageform::clone(binding, pose, out) == Status::pose_not_finite, "an infinite pose is refused");
    expect(out == before, "and leaves the output alone");
    expect(second_file_agrees(binding), "two files with the same headers link and agree");
    expect(clip_plays(), "a clip plays and goes round");
    if (failures == 0) std::printf("ok\n");
    return failures;
}
