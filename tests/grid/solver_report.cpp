// Tests reports of solvers: sums and maxima over parts, and reasons in words.
#include "../catch.hpp"

#include <cageform/grid/types/solver_report.hpp>

#include <set>
#include <string>

namespace evaluation_tests {

using cageform::SizeReason;
using cageform::SolverReport;

TEST_CASE("a report of several parts has their sums, and the worst of them", "[grid][report]") {
    SolverReport small, large;
    small.cells = 3;
    small.solves = 2;
    small.multigrid.cycles = 4;
    small.multigrid.convergence_factor = 0.1;
    small.multigrid.error_estimate = 1e-7;
    small.multigrid.error_bound = 1e-5;
    small.tree.finest_size = 0.5;
    small.tree.finest_reason = SizeReason::facet;
    small.relaxation.sweeps = 6;
    small.tree.grid_errors = {0.1F, 0.4F};
    large.cells = 10;
    large.solves = 7;
    large.multigrid.cycles = 9;
    large.multigrid.convergence_factor = 0.2;
    large.multigrid.error_estimate = 1e-6;
    large.multigrid.error_bound = 1e-4;
    large.tree.finest_size = 0.25;
    large.tree.finest_reason = SizeReason::bone;
    large.relaxation.sweeps = 8;
    large.tree.grid_errors = {0.3F, 0.2F};
    for (const bool turned : {false, true}) {
        SolverReport sum;
        sum.add(turned ? large : small);
        sum.add(turned ? small : large);
        CHECK(sum.cells == 13);
        CHECK(sum.solves == 9);
        CHECK(sum.relaxation.sweeps == 14);
        CHECK(sum.multigrid.cycles == 9);
        CHECK(sum.multigrid.convergence_factor == 0.2);
        CHECK(sum.multigrid.error_estimate == 1e-6);
        CHECK(sum.multigrid.error_bound == 1e-4);
        CHECK(sum.tree.finest_size == 0.25);
        CHECK(sum.tree.finest_reason == SizeReason::bone);
        CHECK(sum.tree.grid_errors == std::vector<float>{0.3F, 0.4F});
        CHECK(sum.grid_error() == Approx(0.4));
    }
}

TEST_CASE("every reason for small cells has words of its own", "[grid][report]") {
    std::set<std::string> words;
    for (int n = 0; n < 6; ++n) words.insert(cageform::to_string(SizeReason(n)));
    CHECK(words.size() == 6);
    CHECK(words.count("unknown") == 0);
    CHECK(cageform::to_string(SizeReason(6)) == std::string("unknown"));
}

} // namespace evaluation_tests
