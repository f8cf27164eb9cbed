/* Tables of the library, one per instruction set. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_DISPATCH_H
#define CDPR_DISPATCH_H

#include "include/cdpr/table.h"

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
