// Harmonic functions on triangle meshes, with values given at some vertices.
#pragma once

#include <cageform/core/types/scalar_range.hpp>
#include <cageform/fields/cotangent.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Solves for the unknown vertices i of any number of fields: Σ w_ij (u_i − u_j) = 0.
///
///   weights  made by `cotangent_weights`
///   given    #vertices; 0 if the value is unknown
///   values   fields of #vertices each, one after the other; reads given values and writes unknown ones,
///            only if the status is ok. Vertices without a face are skipped. Results lie between the
///            smallest and the largest given value, unless SurfaceReport::negative_weights is positive.
///            Linear functions on flat regions are reproduced
///   cost     as solve_graph: one factorisation for all fields
///   fails    input_malformed (not one mark per vertex, or incomplete fields; also if `cotangent_weights`
///            failed); value_not_finite (SolverReport::culprit is the index in `values`); cells_unreached
///            (the first vertex of a component without a given one); not_converged; cancelled; out_of_memory
template <MutableScalarRange V>
Evaluation solve_surface(const CotangentWeights& weights, std::span<const std::uint8_t> given, V&& values,
                         const Running& running = {}) {
    using T = detail::element_t<V>;
    const std::span<T> fields(values);
    const std::size_t size = weights.vertices;
    if (given.size() != size || (size == 0 ? !fields.empty() : fields.size() % size != 0))
        return {Status::input_malformed, {}};
    const GraphOptions options{.allow_negative = weights.has_negative};
    return detail::guarded_evaluation([&](SolverReport& report) {
        // Vertices without a face are given in the graph, with an arbitrary value.
        std::vector<std::uint8_t> marks(given.begin(), given.end());
        std::vector<T> solved(fields.begin(), fields.end());
        for (std::size_t i = 0; i < size; ++i) {
            if (weights.unused[i] == 0) continue;
            marks[i] = 1;
            for (std::size_t at = i; at < solved.size(); at += size) solved[at] = 0;
        }
        const Evaluation evaluation =
            solve_graph(weights.graph(), marks, std::span<T>(solved), options, running);
        report = evaluation.solver;
        if (evaluation.status != Status::ok) return evaluation.status;
        for (std::size_t field = 0; field < solved.size(); field += size) {
            for (std::size_t i = 0; i < size; ++i) {
                if (marks[i] == 0) fields[field + i] = solved[field + i];
            }
        }
        return Status::ok;
    });
}

} // namespace cageform::inline CAGEFORM_ABI
