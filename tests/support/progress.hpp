// The law of what functions tell of their progress.
#pragma once

#include "../catch.hpp"

#include <cageform/parallel/running.hpp>
#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <vector>

namespace cageform_tests {

using cageform::Running;
using cageform::Status;

/// The status of a result, wherever it is.
template <class R>
Status status_of(const R& result) {
    if constexpr (requires { result.report.status; })
        return result.report.status;
    else if constexpr (requires { result.bound.status; })
        return result.bound.status != Status::ok ? result.bound.status : result.packed.status;
    else
        return result.status;
}

/// f(running) is ok, and what it tells never falls and ends with 1; it is cancelled where it is told to
/// stop there.
template <class F>
void check_progress(const char* what, const F& f) {
    CAPTURE(what);
    for (const unsigned threads : {1u, 3u}) {
        CAPTURE(threads);
        std::vector<double> told;
        Running running;
        running.parallel = cageform::ThreadedFor{threads};
        running.progress = [&told](double done) {
            told.push_back(done);
            return true;
        };
        CHECK(status_of(f(running)) == Status::ok);
        CHECK(std::is_sorted(told.begin(), told.end()));
        REQUIRE(!told.empty());
        CHECK(told.front() >= 0);
        CHECK(told.back() == 1);
        running.progress = [](double done) { return done < 1; };
        CHECK(status_of(f(running)) == Status::cancelled);
    }
}

} // namespace cageform_tests
