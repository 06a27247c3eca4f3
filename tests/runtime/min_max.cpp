// The run-time headers where min and max are macros: what they would spoil is spoilt when a header is read, so one call is
// enough.
#include <cageform/fwd.hpp>
#include <cageform/runtime.hpp>

#if !(defined(min) && defined(max))
#error "a standard header has undefined the macros: this file checks nothing"
#endif

int main() {
    const cageform::Binding<float, 3> nothing;
    std::vector<cageform::Vec<float, 3>> none;
    return cageform::clone(nothing, none, none) == cageform::Status::ok ? 0 : 1;
}
