// Macros of the sources of the compiled library. CMake compiles each source once for every scalar and
// dimension: CAGEFORM_T is float or double, CAGEFORM_D is 2 or 3. A program in the plane then compiles no
// code for space.
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

// The functions of the class X that compute weights, with the scalar T.
#define CAGEFORM_EVALUATION(X, T)                                                                            \
    CAGEFORM_COMPILE Evaluation X::evaluate(BlockView<const T>, BlockView<T>, std::span<PointState>,         \
                                            const Running&) const;                                           \
    CAGEFORM_COMPILE Evaluation X::evaluate_gradients(BlockView<const T>, BlockView<T>,                      \
                                                      std::span<PointState>, const Running&) const;

// Calls a macro with every kind of boundary of the dimension.
#if CAGEFORM_D == 2
#define CAGEFORM_FOR_CAGES(instantiate, T) instantiate(Polygon<T>, T, 2)
#else
#define CAGEFORM_FOR_CAGES(instantiate, T)                                                                   \
    instantiate(TriangleMesh<T>, T, 3) instantiate(PolyhedralMesh<T>, T, 3)
#endif
