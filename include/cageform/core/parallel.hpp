// Where the library may use several threads it asks the caller for a loop:
//
//     parallel_for(count, grain, body)   calls body(begin, end) for ranges that cover [0, count)
//                                        once
//
// The ranges may run on any threads in any order; `grain` is the least worthwhile length. Every
// user of such a loop writes disjoint output per index, so results do not depend on the threads.
//
// What runs every frame (clone/) takes such a loop as its last argument. What may take long
// (binding/ and left of it) takes a Running there, which adds progress and cancel: core/running.hpp
// includes <functional>, which is too heavy for run time.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

/// The default: one call on the calling thread.
struct SerialFor {
    template <class Body>
    void operator()(std::size_t count, std::size_t /*grain*/, Body&& body) const {
        if (count > 0) body(std::size_t{0}, count);
    }
};

} // namespace cageform::inline CAGEFORM_ABI
