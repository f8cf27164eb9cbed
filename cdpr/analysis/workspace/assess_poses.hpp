// Wrenches that the cables of a robot can exert at many poses. SPDX-License-Identifier: Apache-2.0
//
// With two redundant cables, eight poses are evaluated at a time in lanes, each with the bits of a single one;
// rank-deficient poses are evaluated alone.
#pragma once

#include <cdpr/analysis/workspace/assess.hpp>
#include <cdpr/lanes.hpp>

namespace cdpr::CDPR_TARGET {

struct Assess {
    PoseQuestion<double> asked;
    const double* poses;    // (K, 7): position, m, and unit quaternion
    double* value;          // (K): margin, N; closure; or payload, kg
    double* scale;          // (K), of the value: times MARGIN_ROUNDING, its round-off
    double* direction;      // (K, n), unit vector of the smallest margin; else NaN
    int64_t* status;        // (K), PoseStatus
    int64_t* limit;         // (K), largest entry of the direction: twice its number, 1 more if negative; or -1
    double* space;          // work space for one pose
    int64_t* cables;        // (n + m), work space
    Lanes* eight;           // work space for eight poses
    Lanes* eight_question;  // the question in lanes
    int64_t count;          // K
    static constexpr auto fields =
        extended(PoseQuestion<double>::fields,
                 "poses(count, 7), value(count), scale(count), direction(count, n), status(count), limit(count), "
                 "work space(",
                 PoseSpace<double>::SIZE, "), work cables(n + m), work eight(", PoseSpace<Lanes>::SIZE,
                 "), work eight_question(m*w + 2*m + n + 6*k + 16), count");

    inline bool serves_lanes() const;
    inline PoseQuestion<Lanes> question_in_lanes() const;
    inline void assess_alone(int64_t number);
    inline void assess_together(int64_t first, const PoseQuestion<Lanes>& question, const PoseSpace<Lanes>& found);
};

// Return twice the number of the largest entry, and 1 more if that is negative; -1 if an entry is not finite.
CDPR_INLINE int64_t widest(const double* direction, int64_t n) {
    int64_t found = -1;
    double size = -1.0;
    for (int64_t j = 0; j < n; j++) {
        if (!finite(direction[j])) return -1;
        if (!(absolute(direction[j]) > size)) continue;
        found = 2 * j + (direction[j] < 0.0);
        size = absolute(direction[j]);
    }
    return found;
}

// Return whether most poses can be evaluated in lanes.
inline bool Assess::serves_lanes() const {
    bool free = true;
    for (int64_t i = 0; i < asked.m; i++) free = free && asked.tension_min[i] < asked.tension_max[i];
    return free && asked.m - asked.n == TWO && asked.n > 3 && asked.mode != PAYLOAD;
}

CDPR_INLINE const Lanes* in_lanes(const double* numbers, int64_t count, Memory<Lanes>& memory) {
    Lanes* copy = memory.reserve(count);
    for (int64_t i = 0; i < count; i++) copy[i] = numbers[i];
    return copy;
}

inline PoseQuestion<Lanes> Assess::question_in_lanes() const {
    Memory<Lanes> memory = {eight_question};
    const int64_t n = asked.n, m = asked.m, w = asked.w, k = asked.k;
    const Lanes* lines = in_lanes(asked.lines, m * w, memory);
    const Lanes *low = in_lanes(asked.tension_min, m, memory), *high = in_lanes(asked.tension_max, m, memory);
    const Lanes *weights = in_lanes(asked.weights, n, memory), *inertial = in_lanes(asked.inertial, 13, memory);
    const Lanes *gravity = in_lanes(asked.gravity, 3, memory), *vectors = in_lanes(asked.vectors, 6 * k, memory);
    return {lines,   low,        high,       asked.rows,          weights, inertial, gravity,
            vectors, asked.mode, asked.form, asked.accelerations, n,       m,        w,
            k};
}

inline void Assess::assess_alone(int64_t number) {
    const int64_t n = asked.n;
    const PoseSpace<double> found = pose_space(space, n, asked.m, asked.k);
    status[number] = assess_pose(asked, poses + 7 * number, found, cables);
    value[number] = found.value[0];
    scale[number] = found.value[1];
    for (int64_t j = 0; j < n; j++) direction[number * n + j] = found.best[j];
    limit[number] = widest(direction + number * n, n);
}

// Evaluate eight poses, from number `first` on.
inline void Assess::assess_together(int64_t first, const PoseQuestion<Lanes>& question, const PoseSpace<Lanes>& found) {
    const int64_t n = asked.n;
    Lanes pose[7];
    for (int lane = 0; lane < WIDTH; lane++)
        for (int i = 0; i < 7; i++) pose[i].set(lane, poses[7 * (first + lane) + i]);
    set_up(question, pose, found);
    const TensionProblem<Lanes> problem = tension_problem(question, found);
    const int64_t r = reduce(problem);
    int answered = 0;
    if (r == TWO) answered = bits(common(problem, r) & value_of_two(question, found));
    for (int lane = 0; lane < WIDTH; lane++) {
        const int64_t number = first + lane;
        if ((answered >> lane & 1) == 0) {
            assess_alone(number);
            continue;
        }
        status[number] = REGULAR;
        value[number] = found.value[0].get(lane);
        scale[number] = found.value[1].get(lane);
        for (int64_t j = 0; j < n; j++) direction[number * n + j] = found.best[j].get(lane);
        limit[number] = widest(direction + number * n, n);
    }
}

// Evaluate all poses; return BAD_INPUT if lines lack an anchor, or a row is invalid.
inline int assess(Assess& poses) {
    if (!sound(poses.asked)) return BAD_INPUT;
    int64_t next = 0;
#ifndef CDPR_ALONE
    if (poses.count >= WIDTH && poses.serves_lanes()) {
        const PoseQuestion<Lanes> question = poses.question_in_lanes();
        const PoseSpace<Lanes> found = pose_space(poses.eight, poses.asked.n, poses.asked.m, poses.asked.k);
        for (; next + WIDTH <= poses.count; next += WIDTH) poses.assess_together(next, question, found);
    }
#endif
    for (; next < poses.count; next++) poses.assess_alone(next);
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
