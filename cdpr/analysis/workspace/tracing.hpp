// Intervals of parallel rays with a clearance above a limit. SPDX-License-Identifier: Apache-2.0
//
// A clearance changes by no more than the platform moves: a clearance of c cannot change its sign within c. A ray is
// followed in such steps (sphere tracing: Hart, Visual Computer 12, 1996), and changes of sign are bisected. Missed
// intervals are shorter than SHORT.
#pragma once

#include <cdpr/mechanics/clearance.hpp>

namespace cdpr::CDPR_TARGET {

struct RaySearch {
    static constexpr double SHORT = 1e-6;  // m: shorter free or blocked intervals may be missed
    static constexpr int HALVINGS = 40;    // of a step, a metre at most, to a billionth of a millimetre
    static constexpr int MOST = 64;        // ends of intervals along one ray

    Bodies bodies;
    const double* positions;  // (count, 3), m, of the platform at the start of the rays; the entry of `axis` is ignored
    const double* orientations;  // (attitudes, 4), unit quaternions
    double* ends;                // (count, 64), m, starts and ends of free intervals, alternating
    int64_t* counts;             // (count), number of these; -1 for a ray with too many
    double* cables;              // (m, 6), work space
    double* pose;                // (7), work space
    double low;                  // m, start of all rays
    double high;                 // m, end of all rays
    double edge;                 // m, the clearance between free and blocked
    int64_t axis;                // 0, 1 or 2
    int64_t over_all;            // whether all attitudes must be free; else one is enough
    int64_t count;
    int64_t attitudes;
    static constexpr auto fields =
        extended(Bodies::fields,
                 "positions(count, 3), orientations(attitudes, 4), ends(count, 64), counts(count), work cables(m, 6), "
                 "work pose(7), low, high, edge, axis, over_all, count, attitudes");

    inline double above_edge(double at) const;
    inline double boundary(double from, double to, bool free) const;
    inline void follow(int64_t ray) const;
};

// Return the clearance at a position of the present ray, less the limit, m.
inline double RaySearch::above_edge(double at) const {
    pose[axis] = at;
    double found = 0.0;
    for (int64_t k = 0; k < attitudes; k++) {
        for (int i = 0; i < 4; i++) pose[3 + i] = orientations[4 * k + i];
        const double here = nearest(bodies, pose, cables).clearance;
        if (k == 0 || (here < found) == (over_all != 0)) found = here;
    }
    return found - edge;
}

// Return the last position of a step with the state of its start, free or blocked.
inline double RaySearch::boundary(double from, double to, bool free) const {
    double low_end = from, high_end = to;
    for (int k = 0; k < HALVINGS; k++) {
        const double middle = 0.5 * (low_end + high_end);
        if ((above_edge(middle) > 0.0) == free)
            low_end = middle;
        else
            high_end = middle;
    }
    return free ? low_end : high_end;
}

// Write the ends of the free intervals of a ray, and their number.
inline void RaySearch::follow(int64_t ray) const {
    double* found = ends + MOST * ray;
    for (int i = 0; i < 3; i++) pose[i] = positions[3 * ray + i];
    int64_t number = 0;
    double at = low, here = above_edge(at);
    if (here > 0.0) found[number++] = at;
    while (at < high && number < MOST - 1) {
        const double ahead = smaller(at + larger(absolute(here), SHORT), high), there = above_edge(ahead);
        if ((there > 0.0) != (here > 0.0)) found[number++] = boundary(at, ahead, here > 0.0);
        at = ahead;
        here = there;
    }
    if (number % 2 == 1) found[number++] = high;
    counts[ray] = at >= high ? number : -1;
}

inline int search_rays(RaySearch& search) {
    if (search.axis < 0 || search.axis > 2 || !has_anchors<double>(search.bodies.w)) return BAD_INPUT;
    for (int64_t ray = 0; ray < search.count; ray++) search.follow(ray);
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
