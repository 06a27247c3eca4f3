// The macros of the library, and their effects.
//
//   CAGEFORM_ASSERT(condition, why)  checks a precondition. Default: the standard assert, which
//                                    NDEBUG removes. To use an engine's assert, define the macro
//                                    before the first include.
//   CAGEFORM_REGISTER_BYTES          width of the vector registers that the kernels use: 16, 32 or
//                                    64. Default: set by the compiler's target flags. 0 means plain
//                                    scalars, as on x86 without SSE2.
//   CAGEFORM_DETERMINISTIC           if defined, clones and clips have the same bits for every
//                                    compiler, optimisation level and register width. Every product
//                                    and every sum is rounded separately, and sums have one order.
//                                    Supported: GNU and clang; x86-64, ARM and WebAssembly. Not
//                                    supported: -ffast-math; WebAssembly's relaxed SIMD; NEON
//                                    registers on 32-bit ARM, which treat denormal numbers as zero
//                                    (compile for VFP, -mfpu=vfpv4-d16, or set
//                                    CAGEFORM_REGISTER_BYTES to 0). Clones take no more time if the
//                                    weights are in a cache, else up to a third more; clips take up
//                                    to twice the time. Not covered: binding, normals, and the
//                                    angles and rotations of a RigidMotion, because these use sines
//                                    of the standard library.
//   CAGEFORM_COMPILED                defined by the CMake target cageform::compiled: `clone`, `bind`,
//                                    `pack`, `make_cage`, `fit_skeleton` and solvers are in a library, and
//                                    a file that calls them does not compile them.
//
// All of these change the generated code, and so do -fno-exceptions, -ffast-math and fused multiply-add
// (-mfma). The name of the inline namespace CAGEFORM_ABI therefore encodes all of them. Of CAGEFORM_ASSERT it
// encodes only whether the assert is standard, removed by NDEBUG, or user-defined. Files with different
// settings thus have different symbol names, and a linker cannot mix their functions. No macro reveals
// -ffp-contract: it must be the same in all files.
//
// With CAGEFORM_COMPILED the name does not encode asserts and exceptions: a debug build of a game may link a
// release build of the library. The name still encodes registers, fused multiply-add and the mode of
// arithmetic: a program that is compiled for another processor than its library does not link.
//
// To make one program for processors from SSE2 to AVX-512, put the calls of cageform that run every frame
// into a separate file. Compile this file once per level (without flags, with -mavx2 -mfma, with -mavx512f
// -mavx512dq -mfma) and choose a level at startup by __builtin_cpu_supports. The interface between these
// files and the rest must not use types of this namespace or classes with inline functions. Pass pointers and
// sizes: the coordinates of poses and points, and the bytes of a packed binding or figure. These bytes are
// the same on all levels. Inline functions outside this namespace, such as those of the standard library,
// have the same name on all levels, and a linker keeps only the first copy. Therefore link the lowest level
// first, and compile with optimisation.
// Results differ in bits between levels unless CAGEFORM_DETERMINISTIC is defined. tests/levels is an example.
//
// There is no macro for allocation. Functions called every frame (clones, samples of clips, normals) do not
// allocate. Classes that own memory (Binding, PackedBinding, PiecewiseCubic, CageClip and their cursors) use
// the global operator new, which an engine can replace. Views of bindings need no operator new: BindingView
// and PackedBindingView read the caller's memory, and open_blob finds a view in the bytes of a file.
#pragma once

#include <cageform/version.hpp>

#if !defined(CAGEFORM_ASSERT)
#include <cassert>
#define CAGEFORM_ASSERT(condition, why) assert((condition) && (why))
#if defined(NDEBUG)
#define CAGEFORM_DETAIL_ASSERT_TAG n
#else
#define CAGEFORM_DETAIL_ASSERT_TAG a
#endif
#else
#define CAGEFORM_DETAIL_ASSERT_TAG c
#endif

#if !defined(CAGEFORM_REGISTER_BYTES)
#if !defined(__GNUC__) || (defined(__i386__) && !defined(__SSE2__))
#define CAGEFORM_REGISTER_BYTES 0
#elif defined(__AVX512F__) && defined(__AVX512DQ__)
#define CAGEFORM_REGISTER_BYTES 64
#elif defined(__AVX__)
#define CAGEFORM_REGISTER_BYTES 32
#else
#define CAGEFORM_REGISTER_BYTES 16
#endif
#endif

#if defined(CAGEFORM_COMPILED)
#undef CAGEFORM_DETAIL_ASSERT_TAG
#define CAGEFORM_DETAIL_ASSERT_TAG l
#define CAGEFORM_DETAIL_EXCEPTIONS_TAG
#elif defined(__cpp_exceptions)
#define CAGEFORM_DETAIL_EXCEPTIONS_TAG e
#else
#define CAGEFORM_DETAIL_EXCEPTIONS_TAG x
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#define CAGEFORM_DETAIL_MATH_TAG f
#elif defined(CAGEFORM_DETERMINISTIC)
#define CAGEFORM_DETAIL_MATH_TAG d
#else
#define CAGEFORM_DETAIL_MATH_TAG s
#endif

#if defined(CAGEFORM_DETERMINISTIC)
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) ||               \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "CAGEFORM_DETERMINISTIC and -ffast-math contradict each other"
#endif
#if defined(__arm__) && defined(__ARM_NEON) && CAGEFORM_REGISTER_BYTES != 0
#error "CAGEFORM_DETERMINISTIC on 32-bit ARM: use -mfpu=vfpv4-d16, or set CAGEFORM_REGISTER_BYTES to 0"
#endif
#if defined(__wasm_relaxed_simd__)
#error "CAGEFORM_DETERMINISTIC and WebAssembly's relaxed SIMD contradict each other"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#error                                                                                                       \
    "CAGEFORM_DETERMINISTIC needs results rounded to the type of their operands (i386: -msse2 -mfpmath=sse)"
#endif
#endif

#if defined(__FMA__) || defined(__FMA4__) || defined(__aarch64__) || defined(__ARM_FEATURE_FMA) ||           \
    defined(__FP_FAST_FMA) || defined(__FP_FAST_FMAF)
#define CAGEFORM_DETAIL_FUSED
#define CAGEFORM_DETAIL_FUSED_TAG _fma
#else
#define CAGEFORM_DETAIL_FUSED_TAG
#endif

#define CAGEFORM_DETAIL_JOIN_EXPANDED(major, minor, assert_tag, exceptions_tag, math_tag, bytes, fused_tag)  \
    v##major##_##minor##_##assert_tag##exceptions_tag##math_tag##bytes##fused_tag
#define CAGEFORM_DETAIL_JOIN(...) CAGEFORM_DETAIL_JOIN_EXPANDED(__VA_ARGS__)
#define CAGEFORM_ABI                                                                                         \
    CAGEFORM_DETAIL_JOIN(CAGEFORM_VERSION_MAJOR, CAGEFORM_VERSION_MINOR, CAGEFORM_DETAIL_ASSERT_TAG,         \
                         CAGEFORM_DETAIL_EXCEPTIONS_TAG, CAGEFORM_DETAIL_MATH_TAG, CAGEFORM_REGISTER_BYTES,  \
                         CAGEFORM_DETAIL_FUSED_TAG)
