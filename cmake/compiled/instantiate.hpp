// Lists the scalars and dimensions of the compiled library. Each list calls a macro, which
// instantiates functions for one of them.
#pragma once

#if !defined(CAGEFORM_COMPILED)
#error "these files are for the CMake target cageform_compiled"
#endif

// Function templates of the library have no constraints: clang from 18 on encodes these in the names of
// symbols, g++ 12 does not, and a program by one could not link a library by the other.

// Every instantiation is part of the interface of a shared library; all else is hidden.
#if defined(__GNUC__)
#define CAGEFORM_COMPILE template __attribute__((visibility("default")))
#else
#define CAGEFORM_COMPILE template
#endif

#define CAGEFORM_FOR_SCALARS(instantiate) instantiate(float) instantiate(double)
#define CAGEFORM_FOR_SPACES(instantiate)                                                                     \
    instantiate(float, 1) instantiate(float, 2) instantiate(float, 3) instantiate(double, 1)                 \
        instantiate(double, 2) instantiate(double, 3)

// The functions of the class X that compute weights, with the scalar T.
#define CAGEFORM_EVALUATION(X, T)                                                                            \
    CAGEFORM_COMPILE Evaluation X::evaluate(BlockView<const T>, BlockView<T>, std::span<PointState>,         \
                                            const Running&) const;                                           \
    CAGEFORM_COMPILE Evaluation X::evaluate_gradients(BlockView<const T>, BlockView<T>,                      \
                                                      std::span<PointState>, const Running&) const;
#define CAGEFORM_MEAN_VALUE(Cage, T)                                                                         \
    CAGEFORM_EVALUATION(detail::MeanValueEvaluation<Cage>, T)                                                \
    CAGEFORM_COMPILE void detail::MeanValueEvaluation<Cage>::prepare();
#define CAGEFORM_HARMONIC(T, D)                                                                              \
    CAGEFORM_COMPILE Status detail::make_adaptive(std::shared_ptr<const PlacedCage<D>>, SolverReport&,       \
                                                  std::shared_ptr<CageFunctions<T, D>>&, const Running&);    \
    CAGEFORM_COMPILE Status detail::make_uniform(std::shared_ptr<const PlacedCage<D>>, SolverReport&,        \
                                                 std::shared_ptr<CageFunctions<T, D>>&, const Running&);
