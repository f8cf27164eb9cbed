// Work space of lanes, for one of them alone. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/lanes.hpp>

#ifdef CDPR_LANES
namespace cdpr::CDPR_TARGET {

// The same memory as doubles, of which there are eight times as many.
CDPR_INLINE double* doubles(Lanes* space) { return reinterpret_cast<double*>(space); }

// Memory that is given out piece by piece.
struct Space {
    double* place;
    int lane;

    CDPR_INLINE double* reserve(int64_t count) {
        double* begin = place;
        place += count;
        return begin;
    }

    // Copy what an array holds of the lane.
    CDPR_INLINE double* copied(const Lanes* array, int64_t count) {
        double* copy = reserve(count);
        for (int64_t i = 0; i < count; i++) copy[i] = array[i].get(lane);
        return copy;
    }
};

// Write an array of the lane.
CDPR_INLINE void put(const double* array, Lanes* eight, int lane, int64_t count) {
    for (int64_t i = 0; i < count; i++) eight[i].set(lane, array[i]);
}

}  // namespace cdpr::CDPR_TARGET
#endif
