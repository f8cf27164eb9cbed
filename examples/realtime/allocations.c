/* Count of allocations, by the linker's option --wrap. SPDX-License-Identifier: Apache-2.0 */
#include <stddef.h>

#include "cycle.h"

#ifdef COUNT_ALLOCATIONS

static long count;

long allocations(void) { return count; }

#define WRAP(result, name, parameters, arguments) \
    result __real_##name parameters;              \
    result __wrap_##name parameters;              \
    result __wrap_##name parameters {             \
        count++;                                  \
        return __real_##name arguments;           \
    }

WRAP(void *, malloc, (size_t size), (size))
WRAP(void *, calloc, (size_t number, size_t size), (number, size))
WRAP(void *, realloc, (void *old, size_t size), (old, size))
WRAP(void *, aligned_alloc, (size_t alignment, size_t size), (alignment, size))
WRAP(int, posix_memalign, (void **place, size_t alignment, size_t size), (place, alignment, size))

/* operator new and operator new[]; resolved only in programs that use them */
__attribute__((weak)) void *__real__Znwm(size_t size);
__attribute__((weak)) void *__real__Znam(size_t size);
void *__wrap__Znwm(size_t size);
void *__wrap__Znam(size_t size);
void *__wrap__Znwm(size_t size) { return count++, __real__Znwm(size); }
void *__wrap__Znam(size_t size) { return count++, __real__Znam(size); }

#else

long allocations(void) { return -1; }

#endif
