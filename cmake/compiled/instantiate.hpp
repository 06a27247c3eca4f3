// Macros of the sources of the compiled library. A source has code for float and double, since the two share most
// of their code: solvers calculate in double. CMake compiles the sources of this folder once for each dimension,
// CAGEFORM_D. A program in the plane then compiles no code for space.
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

// Calls a macro with each scalar and the dimension D.
#define CAGEFORM_FOR_SCALARS(instantiate, D) instantiate(double, D) instantiate(float, D)

// The functions of a class that compute weights, with the scalar T.
#define CAGEFORM_EVALUATION(T, ...)                                                                          \
    CAGEFORM_COMPILE Evaluation __VA_ARGS__::evaluate(BlockView<const T>, BlockView<T>,                      \
                                                      std::span<PointState>, const Running&) const;          \
    CAGEFORM_COMPILE Evaluation __VA_ARGS__::evaluate_gradients(                                             \
        BlockView<const T>, BlockView<T>, std::span<PointState>, const Running&) const;

// Calls a macro with every kind of boundary of the dimension.
#if CAGEFORM_D == 2
#define CAGEFORM_FOR_CAGES(instantiate)                                                                      \
    instantiate(Polygon<double>, double, 2) instantiate(Polygon<float>, float, 2)
#else
#define CAGEFORM_FOR_CAGES(instantiate)                                                                      \
    instantiate(TriangleMesh<double>, double, 3) instantiate(TriangleMesh<float>, float, 3)                  \
        instantiate(PolyhedralMesh<double>, double, 3) instantiate(PolyhedralMesh<float>, float, 3)
#endif
