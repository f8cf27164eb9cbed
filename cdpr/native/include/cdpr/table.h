/* Table of compiled operations: C interface between kernels and their callers. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_TABLE_H
#define CDPR_TABLE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { CDPR_DIMENSIONS = 4 };

/* One member of an operation's struct; every member takes 8 bytes, in the order of the table.
   type:  "double", "int64" (values), "double*", "int64*", "lanes*" (addresses; lanes: groups of 8 doubles)
   role:  "in", "out", "both" (read and written), "work" (scratch space), "size", "value"
   shape: up to CDPR_DIMENSIONS dimensions, then NULL; each a sum of products of sizes and integers: "2*m + 1", or a
   size with its least value: "w >= 6" */
typedef struct {
    const char *name, *type, *role;
    const char* shape[CDPR_DIMENSIONS + 1];
} cdpr_field;

/* Run an operation on its struct at a simulation time [s]; return its status code. */
typedef int (*cdpr_operation)(void* place, double time);

typedef struct {
    const char* name;
    cdpr_operation call;
    int64_t size; /* of the struct, bytes */
    const cdpr_field* fields;
    int64_t count;
} cdpr_entry;

typedef struct {
    const cdpr_entry* entries;
    int64_t count;
} cdpr_group;

typedef struct {
    const char* target; /* instruction set, such as "x86-64-v3" */
    const cdpr_group* const* groups;
    int64_t count;
} cdpr_table;

#ifdef __cplusplus
}
#endif
#endif
