/* Tables of the library, one per instruction set. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_DISPATCH_H
#define CDPR_DISPATCH_H

#include "include/cdpr/table.h"

#if defined(__x86_64__) && !defined(CDPR_ONE_TARGET) && defined(__SSE3__)
#error \
    "cdpr: what selects the instruction set must run on every processor; remove options such as -mavx from CFLAGS and CXXFLAGS"
#endif

enum { CDPR_TARGETS = 3 };

#ifdef __cplusplus
extern "C" {
#endif

/* Write the tables that this processor can run, the fastest last; return how many. */
int cdpr_tables(const cdpr_table* tables[CDPR_TARGETS]);

#ifdef __cplusplus
}
#endif
#endif
