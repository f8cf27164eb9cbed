// Minimum of consecutive values, found in logarithmic time. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// Binary tree: node i has the index of the smaller value of nodes 2 i and 2 i + 1; node count + i is value i.
struct LeastTree {
    const double* values;  // (count)
    int64_t* nodes;        // (2 count)
    int64_t count;

    inline void grow() const;
    inline int64_t least(int64_t first, int64_t last) const;

  private:
    // Return the index of the smaller value, the first one if equal.
    CDPR_INLINE int64_t lesser(int64_t best, int64_t other) const {
        const double a = values[other], b = values[best];
        return a < b || (a == b && other < best) ? other : best;
    }
};

inline void LeastTree::grow() const {
    for (int64_t i = 0; i < count; i++) nodes[count + i] = i;
    for (int64_t i = count - 1; i > 0; i--) {
        const int64_t one = nodes[2 * i], other = nodes[2 * i + 1];
        nodes[i] = values[other] < values[one] ? other : one;
    }
}

// Return the index of the smallest value from `first` to `last`.
inline int64_t LeastTree::least(int64_t first, int64_t last) const {
    int64_t best = first, left = first + count, right = last + count + 1;
    for (; left < right; left /= 2, right /= 2) {
        if (left & 1) best = lesser(best, nodes[left++]);
        if (right & 1) best = lesser(best, nodes[--right]);
    }
    return best;
}

}  // namespace cdpr::CDPR_TARGET
