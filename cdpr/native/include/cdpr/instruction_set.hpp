// Check that the compiler uses no instruction beyond the requested set. SPDX-License-Identifier: Apache-2.0
//
// An option such as -mavx512f in CXXFLAGS takes precedence over -march=x86-64. `portable` accepts any set.
#pragma once

#include <cdpr/target.hpp>

#define CDPR_LEVEL_portable 4
#define CDPR_LEVEL_x86_64 1
#define CDPR_LEVEL_x86_64_v3 3
#define CDPR_LEVEL_x86_64_v4 4
#define CDPR_JOINED(a, b) a##b
#define CDPR_JOIN(a, b) CDPR_JOINED(a, b)
#define CDPR_LEVEL CDPR_JOIN(CDPR_LEVEL_, CDPR_TARGET)

#if (CDPR_LEVEL < 3 && (defined(__SSE3__) || defined(__AVX__))) || (CDPR_LEVEL < 4 && defined(__AVX512F__))
#error "cdpr: instructions beyond the set that is compiled; remove options such as -mavx512f from CFLAGS and CXXFLAGS"
#endif
