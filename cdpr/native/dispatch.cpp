// Instruction sets of this library that the processor supports, by cpuid. SPDX-License-Identifier: Apache-2.0
//
// __builtin_cpu_supports is not used: compiled by zig, it always returns false.
#include "dispatch.h"

#if defined(__x86_64__) && !defined(CDPR_ONE_TARGET)
#include <cpuid.h>

namespace cdpr {
namespace x86_64 {
extern const cdpr_table table;
}
namespace x86_64_v3 {
extern const cdpr_table table;
}
namespace x86_64_v4 {
extern const cdpr_table table;
}
}  // namespace cdpr

namespace {

struct Registers {
    unsigned a, b, c, d;
};

bool has(unsigned word, unsigned bits) { return (word & bits) == bits; }

// Register states that the operating system saves (XCR0).
unsigned saved_states() {
    unsigned low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

// Level of the x86-64 psABI, 1 to 4 (2 counts as 1): its table 3.1 lists the features.
int level() {
    Registers basic, extended, more;
    if (!__get_cpuid(1, &basic.a, &basic.b, &basic.c, &basic.d)) return 1;
    if (!__get_cpuid_count(7, 0, &extended.a, &extended.b, &extended.c, &extended.d)) return 1;
    if (!__get_cpuid(0x80000001, &more.a, &more.b, &more.c, &more.d)) return 1;
    const bool v3 = has(basic.c, bit_FMA | bit_MOVBE | bit_OSXSAVE | bit_AVX | bit_F16C) &&
                    has(extended.b, bit_BMI | bit_AVX2 | bit_BMI2) && has(more.c, bit_LZCNT);
    if (!v3 || !has(saved_states(), 0x6)) return 1;
    const bool v4 = has(extended.b, bit_AVX512F | bit_AVX512DQ | bit_AVX512CD | bit_AVX512BW | bit_AVX512VL);
    return v4 && has(saved_states(), 0xe6) ? 4 : 3;
}

}  // namespace

int cdpr_tables(const cdpr_table* tables[CDPR_TARGETS]) {
    const int found = level();
    tables[0] = &cdpr::x86_64::table;
    tables[1] = &cdpr::x86_64_v3::table;
    tables[2] = &cdpr::x86_64_v4::table;
    return found < 3 ? 1 : found - 1;
}

#else

namespace cdpr::portable {
extern const cdpr_table table;
}

int cdpr_tables(const cdpr_table* tables[CDPR_TARGETS]) {
    tables[0] = &cdpr::portable::table;
    return 1;
}

#endif
