// A graph: nodes, and links with conductances.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

struct GraphLink {
    std::uint32_t a, b;
    double conductance;
};

/// A graph; `a` and `b` of a link are below `nodes`. The conductances of repeated links are summed.
struct Graph {
    std::size_t nodes;
    std::span<const GraphLink> links;
};

} // namespace cageform::inline CAGEFORM_ABI
