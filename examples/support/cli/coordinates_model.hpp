#pragma once

// The coordinate types with every solver: for the files that compile them.

#include "cli/coordinates.hpp"

#include <cageform/coordinates/harmonic/tree_solver.hpp>
#include <cageform/papers/pyramid_solver.hpp>

namespace cageform_examples {

/// Every solver that there is for a kind of cage.
template <class C>
struct EverySolver {
    using Options = cageform::HarmonicOptions;

    template <class Use>
    static cageform::Status choose(const Options& options, const Use& use) {
        using T = typename C::scalar;
        if constexpr (std::is_same_v<C, cageform::Polygon<T>> || std::is_same_v<C, cageform::TriangleMesh<T>>)
            return cageform::WithAveragingPyramid<C>::choose(options, use);
        else
            return cageform::HarmonicSolverChoice<C>::choose(options, use);
    }
};
template <class C>
using Harmonic = cageform::HarmonicCoordinates<typename C::scalar, C::dimension, C, EverySolver<C>>;

} // namespace cageform_examples
