// Work space of lanes, used for a single lane. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/lanes.hpp>

#ifdef CDPR_LANES
namespace cdpr::CDPR_TARGET {

// The same memory as doubles, which are eight times as many.
CDPR_INLINE double* doubles(Lanes* space) { return reinterpret_cast<double*>(space); }

// Memory for successive arrays.
struct Space {
    double* place;
    int lane;

    CDPR_INLINE double* reserve(int64_t count) {
        double* begin = place;
        place += count;
        return begin;
    }

    // Copy the numbers of the lane from an array.
    CDPR_INLINE double* copied(const Lanes* array, int64_t count) {
        double* copy = reserve(count);
        for (int64_t i = 0; i < count; i++) copy[i] = array[i].get(lane);
        return copy;
    }
};

// Write the numbers of the lane into an array.
CDPR_INLINE void put(const double* array, Lanes* eight, int lane, int64_t count) {
    for (int64_t i = 0; i < count; i++) eight[i].set(lane, array[i]);
}

}  // namespace cdpr::CDPR_TARGET
#endif
