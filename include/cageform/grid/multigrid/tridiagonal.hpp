// Solves the tridiagonal equations in one dimension by elimination (the Thomas algorithm).
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/equations.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

class TridiagonalSolver {
public:
    TridiagonalSolver() = default;
    explicit TridiagonalSolver(const Equations<1>& e) {
        double to_here = 0;
        for (std::uint32_t node = 0; node < e.nodes.count(); ++node) {
            const auto& a = e.stencil(node);
            const bool linked = node > 0 && e.nodes.index(node)[0] == e.nodes.index(node - 1)[0] + 1 &&
                                a[0] != 0 && e.stencil(node - 1)[2] != 0;
            const double inverse = 1 / (a[1] - (linked ? to_here : 0.0));
            to_here = inverse * -a[2];
            pivots_.push_back({inverse, to_here, linked});
        }
    }

    /// Replaces the right-hand side x by the solution, exact up to rounding.
    void solve(Buffer<NodeValues>& x) const noexcept {
        for (std::size_t n = 0; n < x.size(); ++n) {
            for (std::size_t k = 0; k < functions_together; ++k)
                x[n][k] = ((pivots_[n].linked ? x[n - 1][k] : 0.0) + x[n][k]) * pivots_[n].inverse;
        }
        for (std::size_t n = x.size(); n-- > 1;) {
            for (std::size_t k = 0; k < functions_together && pivots_[n].linked; ++k)
                x[n - 1][k] += pivots_[n - 1].to_next * x[n][k];
        }
    }
    std::size_t bytes() const noexcept { return pivots_.size() * sizeof(Pivot); }

private:
    struct Pivot {
        double inverse;
        double to_next; ///< the negated entry to the right, divided by the pivot
        bool linked;    ///< whether the node before is a neighbour, with the entry −1
    };
    Buffer<Pivot> pivots_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
