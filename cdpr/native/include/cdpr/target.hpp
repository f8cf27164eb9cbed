// Namespace of the instruction set for which the headers are compiled. SPDX-License-Identifier: Apache-2.0
#pragma once

// Each instruction set has its own namespace: the linker merges functions of the same name, and would keep any of them.
#ifndef CDPR_TARGET
#define CDPR_TARGET portable
#endif
namespace cdpr {
inline namespace CDPR_TARGET {}  // namespace CDPR_TARGET
}  // namespace cdpr
#ifdef __clang__
#pragma clang diagnostic ignored "-Winline-namespace-reopened-noninline"
#endif

// g++ and clang have the vector types for lanes. Other compilers, and these with CDPR_PLAIN, compile the kernels for
// doubles alone.
#if defined(__GNUC__) && !defined(CDPR_PLAIN)
#define CDPR_LANES
#endif

// Small functions are inlined even without optimisation, so that the linker cannot merge copies.
#if defined(CDPR_LANES)
#define CDPR_INLINE inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define CDPR_INLINE __forceinline
#else
#define CDPR_INLINE inline
#endif

// Kernels recognise NaN and infinity, and round each operation as written.
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__)
#error "cdpr: its kernels need IEEE arithmetic; remove -ffast-math, -Ofast and the like from the compiler options"
#endif
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0
#error "cdpr: its kernels need doubles without excess precision; remove -mfpmath=387 from the compiler options"
#endif

// No fused multiply-add: the same bits for every instruction set, except for functions of the C library (sin, cos,
// tanh, atan2), which selects them by the processor. The pragma also works without compiler options.
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#pragma GCC diagnostic ignored "-Wpsabi"  // about vectors as arguments: these functions are inlined
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#pragma float_control(precise, on)
#endif
