// Chain of sections of a path without a stop. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/gcode/least_tree.hpp>
#include <cdpr/gcode/phases.hpp>

namespace cdpr::CDPR_TARGET {

// Change of speed, with the limits of acceleration and jerk of all its sections.
struct SpeedChange {
    double way, acceleration, jerk;  // m, m/s^2, m/s^3
};

struct SectionChain {
    const double* starts;         // (count + 1), m
    const double* accelerations;  // (count), m/s^2
    LeastTree caps;               // m/s
    LeastTree jerks;              // m/s^3; both limits are smallest in the same section

    CDPR_INLINE SpeedChange change(double slow, double fast, int64_t near, int64_t far) const {
        const int64_t strictest = jerks.least(near, far);
        const double acceleration = accelerations[strictest], jerk = jerks.values[strictest];
        return {ramp_way(slow, fast, acceleration, jerk), acceleration, jerk};
    }

    // Return the index of the last section from `low` to `high` that begins before a position.
    CDPR_INLINE int64_t last_before(double place, int64_t low, int64_t high) const {
        while (low < high) {
            const int64_t middle = (low + high + 1) / 2;
            if (starts[middle] < place)
                low = middle;
            else
                high = middle - 1;
        }
        return low;
    }

    // Return the index of the first section from `low` to `high` that ends after a position.
    CDPR_INLINE int64_t first_behind(double place, int64_t low, int64_t high) const {
        while (low < high) {
            const int64_t middle = (low + high) / 2;
            if (starts[middle + 1] > place)
                high = middle;
            else
                low = middle + 1;
        }
        return low;
    }

    inline SpeedChange change_after(double place, double slow, double fast, int64_t first, int64_t last) const;
    inline SpeedChange change_before(double place, double slow, double fast, int64_t first, int64_t last) const;
};

// Return the change of speed that begins at a position, the start of section `first`.
inline SpeedChange SectionChain::change_after(double place, double slow, double fast, int64_t first,
                                              int64_t last) const {
    for (int64_t far = first;;) {
        const SpeedChange found = change(slow, fast, first, far);
        if (far == last || place + found.way <= starts[far + 1]) return found;
        far = last_before(place + found.way, far + 1, last);
    }
}

// Return the change of speed that ends at a position, the end of section `last`.
inline SpeedChange SectionChain::change_before(double place, double slow, double fast, int64_t first,
                                               int64_t last) const {
    for (int64_t near = last;;) {
        const SpeedChange found = change(slow, fast, near, last);
        if (near == first || place - found.way >= starts[near]) return found;
        near = first_behind(place - found.way, first, near - 1);
    }
}

}  // namespace cdpr::CDPR_TARGET
