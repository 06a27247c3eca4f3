// Binding: contents and memory layout.
#include "catch.hpp"
#include "support/weights.hpp"

#include <cageform/figure/binding.hpp>

namespace binding_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::block_count;
using cageform::lane_count;
using cageform::Lanes;

namespace {

/// Weights and coordinates that encode their indices.
template <class T>
T weight_of(std::size_t point, std::size_t handle) {
    return T(1000 * handle + point);
}
template <class T>
T coordinate_of(std::size_t point, std::size_t axis) {
    return T(point) + T(axis) / 4;
}

template <class T, std::size_t D>
Binding<T, D> numbered(std::size_t points, std::size_t handles) {
    constexpr std::size_t lanes = lane_count<T>;
    std::vector<Lanes<T>> weights(block_count<T>(points) * handles), rest(block_count<T>(points) * D);
    for (std::size_t i = 0; i < block_count<T>(points) * lanes; ++i) {
        for (std::size_t h = 0; h < handles; ++h)
            weights[(i / lanes) * handles + h][i % lanes] = weight_of<T>(i, h);
        for (std::size_t k = 0; k < D; ++k) rest[(i / lanes) * D + k][i % lanes] = coordinate_of<T>(i, k);
    }
    std::vector<Vec<T, D>> rest_handles(handles);
    for (std::size_t h = 0; h < handles; ++h) rest_handles[h][0] = T(h);
    return {std::move(weights), std::move(rest), std::move(rest_handles), points};
}

} // namespace

TEST_CASE("an empty binding has no handles and points", "[binding]") {
    const Binding<double, 2> binding;
    CHECK(binding.point_count() == 0);
    CHECK(binding.handle_count() == 0);
    CHECK(binding.view().point_count() == 0);
    CHECK(binding.view().handle_count() == 0);
    CHECK(binding.view().weights.blocks() == 0);
}

TEMPLATE_TEST_CASE("a binding returns its contents", "[binding]", CAGEFORM_SCALARS) {
    using T = TestType;
    const std::size_t points = GENERATE(0u, 1u, 7u, 8u, 9u, 15u, 16u, 17u, 100u);
    const std::size_t handles = GENERATE(1u, 3u, 40u);
    CAPTURE(points, handles);
    const auto binding = numbered<T, 3>(points, handles);
    REQUIRE(binding.point_count() == points);
    REQUIRE(binding.handle_count() == handles);
    const auto view = binding.view();
    CHECK(view.point_count() == points);
    CHECK(view.handle_count() == handles);
    for (std::size_t h = 0; h < handles; ++h) {
        CHECK(binding.rest_handle(h)[0] == T(h));
        CHECK(&view.rest_handles[h] == &binding.rest_handle(h)); // refers to it
    }
    bool same = true;
    for (std::size_t i = 0; i < points; ++i) {
        for (std::size_t h = 0; h < handles; ++h) {
            same = same && binding.weight(i, h) == weight_of<T>(i, h) &&
                   view.weights(i, h) == binding.weight(i, h);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            same = same && binding.rest_point(i)[k] == coordinate_of<T>(i, k) &&
                   view.rest(i, k) == coordinate_of<T>(i, k);
        }
    }
    CHECK(same);
}

TEST_CASE("a binding uses one cache line per row", "[binding]") {
    const auto binding = numbered<float, 2>(33, 5);
    const auto view = binding.view();
    STATIC_REQUIRE(sizeof(Lanes<float>) == 64);
    STATIC_REQUIRE(sizeof(Lanes<double>) == 64);
    CHECK(view.weights.blocks() == 3);
    CHECK(view.weights.block(2) - view.weights.block(0) == 10);
    CHECK(view.rest.block(1) - view.rest.block(0) == 2);
    CHECK(reinterpret_cast<std::uintptr_t>(view.weights.data) % 64 == 0);
    CHECK(reinterpret_cast<std::uintptr_t>(view.rest.data) % 64 == 0);
}

TEST_CASE("copies and moves of bindings are complete", "[binding]") {
    auto binding = numbered<double, 2>(20, 4);
    const auto copy = binding;
    CHECK(copy.weight(19, 3) == binding.weight(19, 3));
    CHECK(copy.view().weights.data != binding.view().weights.data);
    const auto* const data = binding.view().weights.data;
    const auto moved = std::move(binding);
    CHECK(moved.view().weights.data == data);
    CHECK(moved.weight(19, 3) == copy.weight(19, 3));
    auto given = Binding<double, 2>(copy);
    const auto memory = std::move(given).release();
    CHECK(memory.weights.size() == 3 * 4);
    CHECK(memory.rest.size() == 3 * 2);
    STATIC_REQUIRE(std::is_nothrow_move_constructible_v<Binding<double, 2>>);
}

TEST_CASE("a moved-from or released binding is empty", "[binding]") {
    auto binding = numbered<double, 2>(20, 3);
    const auto moved = std::move(binding);
    CHECK(moved.point_count() == 20);
    CHECK(moved.handle_count() == 3);
    CHECK(binding.point_count() == 0); // NOLINT(bugprone-use-after-move): what is tested
    CHECK(binding.handle_count() == 0);
    binding = numbered<double, 2>(20, 3);
    const auto memory = std::move(binding).release();
    CHECK(memory.weights.size() == block_count<double>(20) * 3);
    CHECK(binding.point_count() == 0); // NOLINT(bugprone-use-after-move): what is tested
    CHECK(binding.view().handle_count() == 0);
}

} // namespace binding_tests
