// A debugger prints these objects, stopped in `look`. With a natvis file the program says whether that
// knows their types.
#include "../runtime/made_up.hpp"

#include <cageform/cage/polygon.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/types/buffer.hpp>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

namespace {

template <class... X>
__attribute__((noinline)) void look(const X&... x) {
    const volatile void* places[] = {&x...};
    (void)places;
}

#define CAGEFORM_TEST_TEXT_OF_EXPANDED(x) #x
#define CAGEFORM_TEST_TEXT_OF(x) CAGEFORM_TEST_TEXT_OF_EXPANDED(x)

/// Whether a natvis file knows the types of this program, by their whole names.
bool is_known_to(const char* natvis) {
    std::ifstream file(natvis);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    for (const char* type :
         {"Vec&lt;*,2", "Vec&lt;*,3", "Buffer&lt;*", "Binding&lt;*,*", "BindingView&lt;*,*",
          "PackedBindingView&lt;*,*", "Polygon&lt;*", "TriangleMesh&lt;*"}) {
        const std::string name =
            std::string("\"cageform::" CAGEFORM_TEST_TEXT_OF(CAGEFORM_ABI) "::") + type + "&gt;\"";
        if (text.find(name) == std::string::npos) return std::printf("%s is missing\n", name.c_str()), false;
    }
    return true;
}

} // namespace

int main(int count, char** arguments) {
    if (count > 1) return is_known_to(arguments[1]) ? 0 : 1;
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
