// The run-time headers where min and max are macros: what they would spoil is spoilt when a header is read, so one call is
// enough.
#include <cageform/animate/clip.hpp>
#include <cageform/animate/quantised_cubic.hpp>
#include <cageform/binding/blob.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/glsl.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/fwd.hpp>

#if !(defined(min) && defined(max))
#error "a standard header has undefined the macros: this file checks nothing"
#endif

int main() {
    const cageform::Binding<float, 3> nothing;
    std::vector<cageform::Vec<float, 3>> none;
    return cageform::clone(nothing, none, none) == cageform::Status::ok ? 0 : 1;
}
