// Comparison of arrays by their bits. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string.h>

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// Return whether `count` numbers of two arrays have the same bits, in all lanes.
template <class T> CDPR_INLINE bool same_bits(const T* one, const T* other, int64_t count) {
    const char *const a = reinterpret_cast<const char*>(one), *const b = reinterpret_cast<const char*>(other);
    uint64_t differing = 0;
    for (int64_t i = 0; i < count * int64_t(sizeof(T)); i += 8) {
        uint64_t x = 0, y = 0;
        memcpy(&x, a + i, 8);
        memcpy(&y, b + i, 8);
        differing |= x ^ y;
    }
    return differing == 0;
}

}  // namespace cdpr::CDPR_TARGET
