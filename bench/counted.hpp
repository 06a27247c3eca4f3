// Counts instructions of a benchmark's loop under callgrind with --instr-atstart=no and --collect-atstart=no
// (bench/run.sh --count).
#pragma once

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#else
#define CALLGRIND_START_INSTRUMENTATION
#define CALLGRIND_STOP_INSTRUMENTATION
#define CALLGRIND_TOGGLE_COLLECT
#endif

namespace cageform_bench {

/// Counts the instructions executed during its lifetime under callgrind; otherwise without effect or cost.
struct Counted {
    Counted() {
        CALLGRIND_START_INSTRUMENTATION;
        CALLGRIND_TOGGLE_COLLECT;
    }
    ~Counted() {
        CALLGRIND_TOGGLE_COLLECT;
        CALLGRIND_STOP_INSTRUMENTATION;
    }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
};

} // namespace cageform_bench
