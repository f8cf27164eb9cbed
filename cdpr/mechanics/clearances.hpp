// Smallest clearances at many poses. SPDX-License-Identifier: Apache-2.0
//
// If all exits are points, eight poses are evaluated at a time, each with the bits of a single one.
#pragma once

#include <cdpr/alone.hpp>
#include <cdpr/mechanics/clearance.hpp>

#ifdef CDPR_LANES
namespace cdpr::CDPR_TARGET {

struct Clearances {
    Bodies bodies;
    const double* poses;  // (count, 7), position, m, and quaternion
    double* clearance;    // (count), m
    int64_t* which;       // (count), pair, as in Nearest
    double* ends;         // (m, 6), work space
    Lanes* eight_poses;   // (7), work space
    Lanes* eight_ends;    // (m, 6), work space
    int64_t count;
    static constexpr auto fields =
        extended(Bodies::fields,
                 "poses(count, 7), clearance(count), which(count), work ends(m, 6), work eight_poses(7), "
                 "work eight_ends(m, 6), count");

    CDPR_INLINE void write(int64_t k, Nearest<double> found) const {
        clearance[k] = found.clearance;
        which[k] = static_cast<int64_t>(found.which);
    }
};

// Write the results for poses first to first + 7.
inline void look_at_eight(const Clearances& asked, int64_t first) {
    const Bodies& bodies = asked.bodies;
    for (int lane = 0; lane < WIDTH; lane++) put(asked.poses + 7 * (first + lane), asked.eight_poses, lane, 7);
    const Nearest<Lanes> cables =
        nearest_cables(bodies, vector(asked.eight_poses), quaternion(asked.eight_poses + 3), asked.eight_ends);
    for (int lane = 0; lane < WIDTH; lane++) {
        const int64_t k = first + lane;
        Nearest<double> found = {cables.clearance.get(lane), cables.which.get(lane)};
        if (bodies.p + bodies.k > 0) {
            for (int64_t i = 0; i < 6 * bodies.m; i++) asked.ends[i] = asked.eight_ends[i].get(lane);
            const double* pose = asked.poses + 7 * k;
            found = nearest_solids(bodies, vector(pose), quaternion(pose + 3), asked.ends, found);
        }
        asked.write(k, found);
    }
}

inline int clearances(Clearances& asked) {
    if (!has_anchors<double>(asked.bodies.w)) return BAD_INPUT;
    int64_t k = 0;
    if (asked.bodies.w == Line<double>::EXIT)
        for (; k + WIDTH <= asked.count; k += WIDTH) look_at_eight(asked, k);
    for (; k < asked.count; k++) asked.write(k, nearest(asked.bodies, asked.poses + 7 * k, asked.ends));
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
#endif
