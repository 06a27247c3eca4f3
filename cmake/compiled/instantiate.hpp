// Macros for the sources of the compiled library. Each source instantiates float and double, which share most code
// because solvers compute in double. CMake compiles the sources once per dimension CAGEFORM_D.
#pragma once

#if !defined(CAGEFORM_COMPILED)
#error "these files are for the CMake target cageform_compiled"
#endif

// The instantiated function templates have no constraints. clang >= 18 encodes constraints in symbol names
// and g++ 12 does not, so their objects would not link.

// Exports instantiations from the shared library; everything else is hidden.
#if defined(__GNUC__)
#define CAGEFORM_COMPILE template __attribute__((visibility("default")))
#else
#define CAGEFORM_COMPILE template
#endif

// Calls a macro for each scalar type and the dimension D.
#define CAGEFORM_FOR_SCALARS(instantiate, D) instantiate(double, D) instantiate(float, D)

// Functions of a coordinate class that compute weights for the scalar T.
#define CAGEFORM_EVALUATION(T, ...)                                                                          \
    CAGEFORM_COMPILE Evaluation __VA_ARGS__::evaluate(BlockView<const T>, BlockView<T>,                      \
                                                      std::span<PointState>, const Running&) const;          \
    CAGEFORM_COMPILE Evaluation __VA_ARGS__::evaluate_gradients(                                             \
        BlockView<const T>, BlockView<T>, std::span<PointState>, const Running&) const;

// Calls a macro for each kind of boundary of the dimension.
#if CAGEFORM_D == 2
#define CAGEFORM_FOR_CAGES(instantiate)                                                                      \
    instantiate(Polygon<double>, double, 2) instantiate(Polygon<float>, float, 2)
#else
#define CAGEFORM_FOR_CAGES(instantiate)                                                                      \
    instantiate(TriangleMesh<double>, double, 3) instantiate(TriangleMesh<float>, float, 3)                  \
        instantiate(PolyhedralMesh<double>, double, 3) instantiate(PolyhedralMesh<float>, float, 3)
#endif
