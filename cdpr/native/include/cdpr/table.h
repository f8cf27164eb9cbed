/* Table of compiled operations: C interface between kernels and their callers. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_TABLE_H
#define CDPR_TABLE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Run an operation on its struct at a simulation time [s]; return its status code. */
typedef int (*cdpr_operation)(void* place, double time);

/* Operation; each member of its struct takes 8 bytes.
   fields: their names and dimensions, "matrix(n, m), both tension(m), n, m, step" (field.hpp)
   types:  of each "double", "int64", "double*", "int64*" or "lanes*" (groups of 8 doubles), or an address with "const"
 */
typedef struct {
    const char* name;
    cdpr_operation call;
    int64_t count; /* of the members */
    const char* fields;
    const char* const* types;
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
