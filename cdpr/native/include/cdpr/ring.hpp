// Rings of rows: the place of each row follows from a step, which may differ between lanes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

// Return the place of the row of a step in a ring (slots, width); 0 before the first step.
CDPR_INLINE int64_t ring_place(double step, int64_t slots, int64_t width) {
    return step > 0.0 ? int64_t(step) % slots * width : 0;
}

// Row of a step in a ring (slots, width).
template <class T> struct RingRow {
    T* row;

    CDPR_INLINE RingRow(T* ring, int64_t slots, int64_t width, T step) : row(ring + ring_place(step, slots, width)) {}

    CDPR_INLINE T get(int64_t j) const { return row[j]; }
    CDPR_INLINE void put(int64_t j, T number, Truth<T> where) const {
        if (where) row[j] = number;
    }

    // Write `count` numbers from the first one on.
    CDPR_INLINE void write(int64_t first, int64_t count, const T* numbers, Truth<T> where) const {
        for (int64_t j = 0; where && j < count; j++) row[first + j] = numbers[j];
    }

    // Return the address of `count` numbers from the first one on, which may be copied to `copy` (count).
    CDPR_INLINE const T* read(int64_t first, int64_t, T*) const { return row + first; }
};

#ifdef CDPR_LANES
template <> struct RingRow<Lanes> {
    Lanes* ring;
    int64_t place[WIDTH];
    bool same = true;  // in all lanes

    CDPR_INLINE RingRow(Lanes* ring, int64_t slots, int64_t width, const Lanes& step) : ring(ring) {
        for (int lane = 0; lane < WIDTH; lane++) {
            place[lane] = ring_place(step.get(lane), slots, width);
            same = same && place[lane] == place[0];
        }
    }

    CDPR_INLINE Lanes get(int64_t j) const {
        if (same) return ring[place[0] + j];
        Lanes found = 0.0;
        for (int lane = 0; lane < WIDTH; lane++) found.set(lane, ring[place[lane] + j].get(lane));
        return found;
    }
    CDPR_INLINE void put(int64_t j, const Lanes& number, const Mask& where) const {
        if (same) {
            ring[place[0] + j] = select(where, number, ring[place[0] + j]);
            return;
        }
        for (int lane = 0; lane < WIDTH; lane++)
            if (where.get(lane)) ring[place[lane] + j].set(lane, number.get(lane));
    }
    CDPR_INLINE void write(int64_t first, int64_t count, const Lanes* numbers, const Mask& where) const {
        for (int64_t j = 0; j < count; j++) put(first + j, numbers[j], where);
    }
    CDPR_INLINE const Lanes* read(int64_t first, int64_t count, Lanes* copy) const {
        if (same) return ring + place[0] + first;
        for (int64_t j = 0; j < count; j++) copy[j] = get(first + j);
        return copy;
    }
};
#endif

}  // namespace cdpr::CDPR_TARGET
