// cageform: every macro of the library, and what it changes.
//
//   CAGEFORM_ASSERT(condition, why)  checks a promise of the caller. Define it before the first
//                                    include to hand failures to an engine's own assert; by default
//                                    it is the standard assert, so NDEBUG removes it.
//   CAGEFORM_REGISTER_BYTES          width of the vector register the kernels are written for: 16,
//                                    32 or 64; follows the compiler's target flags, 0 means plain
//                                    scalars, as on x86 without SSE2.
//   CAGEFORM_DETERMINISTIC           if defined, clones and clips come out the same to the bit
//                                    whatever the compiler, its level of optimisation and the
//                                    registers: every product and every sum is rounded by itself,
//                                    and sums are taken in one order. GNU and clang, x86-64 and
//                                    64-bit ARM, not with -ffast-math. Clones from caches take as
//                                    long, from memory up to a third longer, clips up to twice as
//                                    long. Left out: what is bound, normals, and angles and
//                                    rotations of a RigidMotion, which take sines from the standard
//                                    library.
//
// All change code, and so do -fno-exceptions and -ffast-math. All are part of the inline namespace
// CAGEFORM_ABI (of an assert of one's own, only that it is one): two files compiled with different
// settings have different names for everything instead of one name for two things.
//
// There is no macro for allocation. Nothing called every frame allocates: clones, samples of clips,
// normals. What owns memory (Binding, PackedBinding, PiecewiseCubic, CageClip and their cursors)
// has it from the global operator new, which an engine replaces, or needs not at all for figures:
// BindingView and PackedBindingView are read from memory of the caller, open_blob finds one in the
// bytes of a file.
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

#if defined(__cpp_exceptions)
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
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#error                                                                                                       \
    "CAGEFORM_DETERMINISTIC needs arithmetic in the precision of its operands (on i386: -msse2 -mfpmath=sse)"
#endif
#endif

#define CAGEFORM_DETAIL_JOIN_EXPANDED(major, minor, assert_tag, exceptions_tag, math_tag, bytes)             \
    v##major##_##minor##_##assert_tag##exceptions_tag##math_tag##bytes
#define CAGEFORM_DETAIL_JOIN(...) CAGEFORM_DETAIL_JOIN_EXPANDED(__VA_ARGS__)
#define CAGEFORM_ABI                                                                                         \
    CAGEFORM_DETAIL_JOIN(CAGEFORM_VERSION_MAJOR, CAGEFORM_VERSION_MINOR, CAGEFORM_DETAIL_ASSERT_TAG,         \
                         CAGEFORM_DETAIL_EXCEPTIONS_TAG, CAGEFORM_DETAIL_MATH_TAG, CAGEFORM_REGISTER_BYTES)
