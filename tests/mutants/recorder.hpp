// Writes a line for each test case to the file that MUTANTS_RECORD names: its name, its seconds, whether it
// passed, and the mutants that it reached.
#pragma once

#include "../catch.hpp"
#include "mutant.hpp"

#include <cstdio>
#include <cstring>
#include <ctime>

struct MutantRecorder : Catch::TestEventListenerBase {
    using TestEventListenerBase::TestEventListenerBase;
    std::clock_t start = 0;

    void testCaseStarting(const Catch::TestCaseInfo& info) override {
        TestEventListenerBase::testCaseStarting(info);
        std::memset(cageform_mutants_reached, 0, sizeof cageform_mutants_reached);
        start = std::clock();
    }
    void testCaseEnded(const Catch::TestCaseStats& stats) override {
        const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
        TestEventListenerBase::testCaseEnded(stats);
        const char* path = std::getenv("MUTANTS_RECORD");
        std::FILE* file = path ? std::fopen(path, "a") : nullptr;
        if (!file) return;
        std::fprintf(file, "%s\t%g\t%d\t", stats.testInfo.name.c_str(), seconds,
                     stats.totals.assertions.allOk());
        for (std::size_t k = 0; k < sizeof cageform_mutants_reached; ++k) {
            if (cageform_mutants_reached[k]) std::fprintf(file, "%zu ", k);
        }
        std::fprintf(file, "\n");
        std::fclose(file);
    }
};
CATCH_REGISTER_LISTENER(MutantRecorder)
