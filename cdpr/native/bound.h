/* Declarations that binder.c and bound.c share. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_BOUND_H
#define CDPR_BOUND_H

#ifdef CDPR_WITH_PYTHON_H
#define Py_LIMITED_API 0x030b0000
#include <Python.h>
#include <structmember.h>
#else
#include "stable_abi.h"
#endif
#include <string.h>

#include "dispatch.h"

extern PyType_Spec cdpr_bound; /* type of bound operations */

/* Return whether arrays that are written, a bit each, share no memory with others. */
static inline int are_apart(const Py_buffer* arrays, Py_ssize_t count, uint64_t written) {
    for (Py_ssize_t i = 0; i < count; i++) {
        const char *start = arrays[i].buf, *end = start + arrays[i].len;
        if (!(written >> i & 1) || start == end) continue;
        for (Py_ssize_t j = 0; j < count; j++) {
            const char* other = arrays[j].buf;
            if (j != i && arrays[j].len && start < other + arrays[j].len && other < end) return 0;
        }
    }
    return 1;
}

#endif
