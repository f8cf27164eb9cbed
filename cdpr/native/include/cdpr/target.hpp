// Namespace of the instruction set for which the headers are compiled. SPDX-License-Identifier: Apache-2.0
#pragma once

// Each instruction set has a namespace of its own: the linker merges functions of one name, and would keep any of them.
#ifndef CDPR_TARGET
#define CDPR_TARGET portable
#endif

// Small functions are inlined even without optimisation, so that no copy of one can be merged.
#define CDPR_INLINE inline __attribute__((always_inline))

// No fused multiply-add: the same bits on every processor, also where compiler options do not arrive.
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#pragma GCC diagnostic ignored "-Wpsabi"  // of vectors as arguments: these functions are inlined
#endif
