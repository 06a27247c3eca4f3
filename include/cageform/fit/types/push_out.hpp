// The report of `push_out`.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

struct PushOutReport {
    Status status = Status::ok;
    std::size_t culprit = none; ///< index of the vertex or face that was refused
    std::size_t inside = 0;     ///< number of vertices inside the surface at the start
    std::size_t left = 0;       ///< number of vertices inside the surface at the end
    std::size_t moved = 0;      ///< number of vertices that moved by more than 1 % of the largest move
    double largest = 0;         ///< the largest move
    double mean = 0;            ///< the mean of the moves counted in `moved`
    std::size_t turned = 0;     ///< faces that the moves turned by more than 90°; their vertices went back
    std::size_t held = 0;       ///< vertices that went back, by halves, until no face was turned
    double seconds = 0;

    static constexpr std::size_t none = ~std::size_t{0};
};

} // namespace cageform::inline CAGEFORM_ABI
