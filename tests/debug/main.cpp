// What a debugger is asked to print, stopped in `look`.
#include "../runtime/made_up.hpp"

#include <cageform/cage/polygon.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/buffer.hpp>

namespace {

template <class... X>
__attribute__((noinline)) void look(const X&... x) {
    const volatile void* places[] = {&x...};
    (void)places;
}

} // namespace

int main() {
    const cageform::Vec<double, 3> vec{1, 2.5, -3};
    const cageform::Status status = cageform::Status::cage_not_closed;
    cageform::Buffer<int> buffer;
    buffer.push_back(7);
    buffer.push_back(8);
    const auto binding = made_up::binding<float, 2>(20, 4, 1);
    const auto packed = made_up::packed_binding<float, 2>(cageform::WeightFormat::half, true, 300, 30, 1);
    const auto view = packed.view();
    const std::vector<cageform::Vec<double, 2>> vertices{{0, 0}, {2, 0}, {0, 1}};
    const cageform::Polygon<double> polygon(vertices);
    const std::vector<cageform::Vec<double, 3>> corners{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
    const std::vector<std::array<std::uint32_t, 3>> faces{{0, 1, 2}};
    const cageform::TriangleMesh<double> mesh(corners, faces);
    const cageform::StridedPoints<const double, 2> points(vertices[0].v, 2);
    look(vec, status, buffer, binding, view, polygon, mesh, points);
}
