// Keys of tracks in one line.
#pragma once

#include <cageform/animate/curves/key.hpp>

namespace cageform_tests {

inline cageform::Key key(double time, double value, cageform::KeyKind kind = cageform::KeyKind::automatic) {
    cageform::Key result;
    result.time = time;
    result.value = value;
    result.kind = kind;
    return result;
}

} // namespace cageform_tests
