// The interface for multithreading: the caller passes a loop
//
//     parallel_for(count, grain, body)   calls body(begin, end) for ranges that together cover
//                                        [0, count) exactly once
//
// The ranges may run on any threads in any order; `grain` is the smallest range worth a task. Bodies
// write disjoint output per index, so results do not depend on the threads.
//
// Functions that run every frame (clone/) take such a loop as their last argument. Functions that may
// run long (binding/ and its dependencies) take a Running instead, which adds progress and
// cancellation. Running has its own header, parallel/running.hpp, which includes <functional>.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

/// The default loop: one call on the calling thread.
struct SerialFor {
    template <class Body>
    void operator()(std::size_t count, std::size_t /*grain*/, Body&& body) const {
        if (count > 0) body(std::size_t{0}, count);
    }
};

} // namespace cageform::inline CAGEFORM_ABI
