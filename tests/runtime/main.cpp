// The run-time headers as an engine uses them: no exceptions, no RTTI, no dependency, no bind-time header.
// This program also runs under -ffast-math.
#include "made_up.hpp"

#include <cageform/clone/clone_transposed.hpp>
#include <cageform/runtime.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>

bool second_file_agrees(const cageform::BindingView<float, 3>& binding);
bool clip_plays();

namespace {

using cageform::Status;
using cageform::Vec;
using cageform::WeightFormat;

int failures = 0;

void expect(bool condition, const char* what) {
    if (condition) return;
    std::printf("failed: %s\n", what);
    ++failures;
}

template <class T, std::size_t D>
double stored_weight(const cageform::PackedBindingView<T, D>& view, std::size_t n) {
    const auto read = [&]<class X>(X x) {
        std::memcpy(&x, view.weights + n * sizeof(X), sizeof(X));
        return x;
    };
    switch (view.format) {
    case WeightFormat::scalar: return double(read(T{}));
    case WeightFormat::int16: return read(std::int16_t{});
    case WeightFormat::int8: return read(std::int8_t{});
    case WeightFormat::half: break;
    }
    const auto half = read(std::uint16_t{});
    const double size = std::ldexp(1024 + (half & 1023), ((half >> 10) & 31) - 25);
    return half & 0x8000 ? -size : size;
}

/// Point `place` of a packed clone, by its definition.
template <class T, std::size_t D>
Vec<double, D> by_definition(const cageform::PackedBindingView<T, D>& view,
                             const std::vector<Vec<T, D>>& pose, std::size_t place) {
    constexpr std::size_t lanes = cageform::lane_count<T>;
    const std::size_t block = place / lanes, lane = place % lanes;
    const auto d = [&](std::size_t h) {
        return cageform::vec_cast<double>(pose[h]) - cageform::vec_cast<double>(view.rest_handles[h]);
    };
    Vec<double, D> p{};
    for (std::size_t k = 0; k < D; ++k) p[k] = double(view.rest[block * D + k][lane]);
    for (std::size_t row = view.first_row(block); row < view.first_row(block + 1); ++row) {
        const double scale = view.scale != nullptr ? double(view.scale[block]) : 1;
        p = p + scale * stored_weight(view, row * lanes + lane) * d(view.handle_of_row(block, row));
    }
    for (std::size_t h = 0; view.residual != nullptr && h < view.handles; ++h) {
        for (std::size_t r = 0; r <= D; ++r)
            p = p + double(view.residual[block * (D + 1) + r][lane]) * double(view.affine_fit[h][r]) * d(h);
    }
    return p;
}

/// The clone of displacements times gradients is the displacements times the transposed clone of gradients.
template <class T, std::size_t D>
void check_transposed(const cageform::PackedBindingView<T, D>& view, const std::vector<Vec<T, D>>& pose,
                      const std::vector<Vec<T, D>>& gradients, const std::vector<T>& mask) {
    std::vector<Vec<T, D>> pulled(view.handles), moved(view.points, Vec<T, D>{});
    cageform::CloneOptions<T> options{{mask.data(), view.points}, cageform::CloneMode::add};
    expect(cageform::clone(view, pose, moved, options) == Status::ok, "displacements");
    options.mode = cageform::CloneMode::replace;
    expect(cageform::clone_transposed(view, gradients, pulled, options, made_up::Backwards{}) == Status::ok,
           "a transposed clone");
    double of_points = 0, of_handles = 0;
    for (std::size_t k = 0; k < D; ++k) {
        for (std::size_t i = 0; i < view.points; ++i)
            of_points += double(moved[i][k]) * double(gradients[i][k]);
        for (std::size_t h = 0; h < view.handles; ++h)
            of_handles += double(pulled[h][k]) * double(pose[h][k] - view.rest_handles[h][k]);
    }
    expect(std::fabs(of_points - of_handles) < 20000 * double(cageform::epsilon<T>),
           "a transposed clone is the adjoint of the clone");
}

/// Blobs opened from memory, cloned onto the rest and onto the output, with a mask, in ranges cut anywhere.
template <class T, std::size_t D>
void check_blobs() {
    using cageform::CloneMode;
    constexpr std::size_t points = 100, handles = 11;
    const auto pose = made_up::points<T, D>(handles, 2);
    const auto from = made_up::points<T, D>(points, 3);
    std::vector<T> mask(points);
    for (std::size_t i = 0; i < points; ++i) mask[i] = T(i % 3) / 2;
    for (const auto format :
         {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
        for (const bool sparse : {false, true}) {
            const auto packed = made_up::packed_binding<T, D>(format, sparse, points, handles, 1);
            const auto opened = cageform::open_blob<T, D>(packed.bytes());
            expect(opened.status() == Status::ok, "a blob opens");
            if (opened.status() != Status::ok) continue;
            const auto& view = opened.value;
            std::vector<Vec<T, D>> out(points), masked(from);
            expect(cageform::clone(view, pose, out) == Status::ok, "clone of a packed binding");
            const cageform::CloneOptions<T> options{{mask.data(), points}, CloneMode::add};
            expect(cageform::clone(view, pose, masked, options, made_up::Backwards{}) == Status::ok,
                   "with a mask");
            for (std::size_t place = 0; place < points; ++place) {
                const std::size_t i = view.order != nullptr ? view.order[place] : place;
                const auto p = by_definition(view, pose, place);
                for (std::size_t k = 0; k < D; ++k) {
                    const double moved = p[k] - double(view.rest[place / cageform::lane_count<T> * D + k]
                                                                [place % cageform::lane_count<T>]);
                    const double tolerance = 200 * double(cageform::epsilon<T>);
                    expect(std::fabs(double(out[i][k]) - p[k]) < tolerance,
                           "a packed clone is its definition");
                    expect(std::fabs(double(masked[i][k]) - double(from[i][k]) - double(mask[i]) * moved) <
                               tolerance,
                           "a mask multiplies what is added to the output");
                }
            }
            check_transposed(view, pose, from, mask);
        }
    }
}

/// Blobs that are refused, each for its reason.
void check_refusals() {
    const auto packed = made_up::packed_binding<double, 2>(WeightFormat::int8, true, 40, 5, 4);
    std::vector<cageform::Lanes<double>> memory(packed.bytes().size() / 64);
    std::memcpy(memory.data(), packed.bytes().data(), packed.bytes().size());
    const auto bytes = std::as_writable_bytes(std::span(memory));
    const auto status = [](std::span<const std::byte> of) {
        return cageform::open_blob<double, 2>(of).status();
    };
    expect(status(bytes) == Status::ok, "copied bytes");
    expect(status(bytes.first(bytes.size() - 64)) == Status::blob_truncated, "a blob cut off");
    expect(cageform::open_blob<double, 3>(bytes).status() == Status::blob_kind_differs,
           "a blob of the plane");
    bytes[bytes.size() - 64] ^= std::byte{1};
    expect(status(bytes) == Status::blob_corrupt, "a bit that differs");
    const auto pose = made_up::points<double, 2>(5, 5);
    std::vector<Vec<double, 2>> out(40);
    const std::vector<double> mask(39);
    expect(cageform::clone(packed.view(), pose, out, {{mask.data(), 39}}) == Status::mask_too_small,
           "a mask that is too short");
}

/// A figure does in one call what its parts do in several.
void check_figures() {
    constexpr std::size_t points = 50, handles = 7;
    const auto packed = made_up::figure<float>(WeightFormat::int16, true, points, handles, 12);
    const auto opened = cageform::open<float, 3>(packed.bytes());
    expect(opened.status() == Status::ok, "a figure opens");
    const auto& figure = opened.value;
    expect(figure.label(2) == "C" && figure.find_handle("F") == 5, "labels of handles");
    const auto pose = made_up::points<float, 3>(handles, 13);
    std::vector<Vec<float, 3>> out(points), normals(points), tangents(points), alone(points), along(points);
    std::vector<std::array<float, 4>> signed_tangents(points);
    expect(clone(figure, pose, cageform::FigureOutput{out, normals, signed_tangents}, made_up::Backwards{}) ==
               Status::ok,
           "a figure is cloned");
    expect(clone(figure.points, pose, alone) == Status::ok && alone == out, "points of a figure");
    expect(clone_tangent_frames(figure.tangents, pose, alone, along) == Status::ok && alone == normals,
           "normals of a figure");
    for (std::size_t i = 0; i < points; ++i) {
        const auto& [x, y, z, sign] = signed_tangents[i];
        expect(Vec<float, 3>{x, y, z} == along[i] && sign == (i % 3 == 0 ? -1.0f : 1.0f),
               "tangents of a figure");
    }
    expect(cageform::open<float, 3>(packed.bytes().first(1000)).status() == Status::blob_truncated,
           "a figure cut off");
    expect(cageform::open<double, 3>(packed.bytes()).status() == Status::blob_kind_differs,
           "a figure of float");
}

/// A dense binding gives the same bits however its blocks are shared out.
template <class T, std::size_t D>
void check_ranges() {
    const auto binding = made_up::binding<T, D>(1000, 30, 6);
    const auto pose = made_up::points<T, D>(30, 7);
    std::vector<Vec<T, D>> at_once(1000), in_pieces(1000);
    expect(cageform::clone(binding, pose, at_once) == Status::ok, "clone at once");
    for (const std::size_t longest : {1u, 7u, 40u}) {
        expect(cageform::clone(binding, pose, in_pieces, {}, made_up::Backwards{longest}) == Status::ok,
               "in pieces");
        expect(in_pieces == at_once, "ranges cut anywhere give the same bits");
    }
}

/// Tangents along x and y, bound to be turned by one handle each.
void check_normals() {
    constexpr std::size_t points = 33;
    const auto vectors = [](std::size_t axis) {
        std::vector<cageform::Lanes<float>> weights(cageform::block_count<float>(points) * 3),
            rest(cageform::block_count<float>(points) * 3);
        for (std::size_t n = 0; n < rest.size(); ++n) {
            for (float& x : rest[n].v) x = n % 3 == axis ? 2.0f : 0.0f;
            for (float& w : weights[n].v) w = n % 3 == axis ? 1.0f : 0.0f;
        }
        return cageform::Binding<float, 3>(std::move(weights), std::move(rest), std::vector<Vec<float, 3>>(3),
                                           points);
    };
    const std::array<cageform::Binding<float, 3>, 3> axes{vectors(0), vectors(1), vectors(2)};
    // x becomes (2, 0, 2), y stays.
    const std::array<Vec<float, 3>, 3> pose{{{0, 0, 2}, {0, 0, 0}, {0, 0, 0}}};
    std::vector<Vec<float, 3>> normals(points), tangents(points);
    const std::array along_x_and_y{axes[0], axes[1]};
    expect(cageform::clone_normals(along_x_and_y, pose, normals) == Status::ok, "normals");
    const auto near = [](float a, float b) { return std::fabs(a - b) < 1e-6f; };
    const float part = std::sqrt(0.5f);
    for (const auto& n : normals)
        expect(near(n[0], -part) && near(n[1], 0) && near(n[2], part),
               "a normal of unit length across the tangents");
    expect(cageform::clone_tangent_frames(along_x_and_y, pose, normals, tangents) == Status::ok, "frames");
    for (const auto& t : tangents)
        expect(near(t[0], part) && near(t[1], 0) && near(t[2], part), "a unit tangent");
    std::vector<float> numbers(points * 9);
    const cageform::StridedMatrices<float, 3> jacobians(numbers.data(), points);
    expect(cageform::clone_jacobians(axes, pose, jacobians) == Status::ok, "jacobians");
    expect(numbers[0] == 2 && numbers[2] == 2 && numbers[4] == 2 && numbers[8] == 2, "columns of a jacobian");
}

void check_displacements() {
    const auto packed = made_up::packed_binding<float, 3>(WeightFormat::half, true, 50, 7, 8);
    const auto pose = made_up::points<float, 3>(7, 9);
    std::vector<std::array<float, 4>> out(cageform::displacement_count(packed.view()));
    expect(cageform::write_displacements(packed.view(), pose, out) == Status::ok,
           "displacements for a shader");
    expect(out[2][1] == pose[2][1] - packed.view().rest_handles[2][1], "the displacement of a handle");
    expect(cageform::glsl::blob[0] != 0 && cageform::glsl::compute[0] != 0, "the text of the shaders");
}

/// A triangle's three corners and the vector of its face.
void check_pose_handles() {
    const std::array<Vec<float, 3>, 3> corners{{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}};
    const std::array<Vec<float, 3>, 4> rest{corners[0], corners[1], corners[2],
                                            cageform::detail::face_handle(corners, corners)};
    const std::array<cageform::HandleKind, 4> kinds{{{}, {}, {}, cageform::HandleKind::vector}};
    const cageform::HandleFace<3> face{0, 1, 2};
    cageform::BindingView<float, 3> binding;
    binding.weights.rows = 4;
    binding.rest_handles = rest.data();
    binding.handle_kinds = kinds.data();
    binding.handle_faces = &face;
    std::array<Vec<float, 3>, 4> handles{};
    expect(cageform::pose_handles(binding, corners, handles).status == Status::ok, "the rest pose");
    expect(handles == rest, "the rest pose of all handles bit for bit");
    const std::array<Vec<float, 3>, 3> turned{{{0, 0, 0}, {0, 4, 0}, {0, 0, 4}}}; // and twice as large
    expect(cageform::pose_handles(binding, turned, handles).status == Status::ok, "a similarity");
    expect(handles[3][0] > 2.828f && handles[3][0] < 2.829f && handles[3][1] == 0, "takes the normal along");
    auto bad = turned;
    bad[1][2] = std::bit_cast<float>(0x7fc00000u); // not a number
    const auto before = handles;
    expect(cageform::pose_handles(binding, bad, handles).status == Status::pose_not_finite, "NaN is refused");
    expect(handles == before, "and leaves the handles alone");
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
    check_blobs<float, 1>();
    check_blobs<double, 2>();
    check_blobs<float, 3>();
    check_refusals();
    check_ranges<double, 2>();
    check_ranges<float, 3>();
    check_normals();
    check_figures();
    check_displacements();
    check_pose_handles();
    if (failures == 0) std::printf("ok\n");
    return failures;
}
