// Proofs that the cables balance wrenches at each position of a box, or at none. SPDX-License-Identifier: Apache-2.0
//
// With W(d), the wrench matrix at a distance d of the platform from the middle of the box, enclosed (enclosure.hpp):
//
// - Inside (proof_inside.hpp): the tensions t(d) = t0 + T d, T = -Y dW t0, satisfy W(d) t(d) = w except for a
//   second-order remainder. With W(d) Y = 1 + E(d), |E| < 1, there is a y with W(d) (t(d) + Y y) = w, no larger than
//   that remainder / (1 - |E|). So a wrench is feasible if t0, |T d| and |Y y| together stay within the limits.
// - Outside (proof_outside.hpp): c(d) . w > sum max(c(d) . W_i(d) t_i) of the limits of each t_i (Farkas). c0 is normal
//   to a facet, and c(d) = c0 + G d keeps the products with its cables constant to first order: with a constant c each
//   of them would add its largest tension times the rotation of W_i.
//
// The idea is that of Gouttefarde, Daney and Merlet (IEEE T-RO 27(1), 2011), who solve interval linear systems instead.
#pragma once

#include <cdpr/analysis/workspace/proof_inside.hpp>
#include <cdpr/analysis/workspace/proof_outside.hpp>

namespace cdpr::CDPR_TARGET {

enum Proof { PROVED_OUTSIDE = -1, UNDECIDED = 0, PROVED_INSIDE = 1 };

struct ProveBoxes {
    PoseQuestion<double> asked;  // mode MARGIN, cables from points
    const double* poses;         // (count, 7), of the middles
    const double* halves;        // (count, 3), half sides, m
    const double* wrenches;      // (wrenches, n), all required; moments divided by the characteristic length
    const double* errors;        // (2), round-off of lengths, m, and of the wrenches
    int64_t* proved;             // (count), a Proof
    double* pose_space;          // work space of assess_pose
    double* box_space;           // work space
    int64_t* cables;             // (n + m), work space
    int64_t* chosen;             // (m), work space
    int64_t count;
    int64_t wrench_count;
    static constexpr auto fields =
        extended(PoseQuestion<double>::fields,
                 "poses(count, 7), halves(count, 3), wrenches(wrench_count, n), errors(2), proved(count), "
                 "work pose_space(",
                 PoseSpace<double>::SIZE, "), work box_space(", BoxSpace::SIZE,
                 "), work cables(n + m), work chosen(m), count, wrench_count");
};

// Return the result for one box.
inline Proof prove_box(const ProveBoxes& boxes, const Box& box, const double* pose, const double* half) {
    if (assess_pose(box.asked, pose, box.at_middle, boxes.cables) != REGULAR) return UNDECIDED;
    if (!box.enclose(pose, half, boxes.errors[0])) return UNDECIDED;
    if (box.at_middle.value[0] < 0.0)
        return proved_outside(box, boxes.wrenches, boxes.wrench_count, boxes.errors[1]) ? PROVED_OUTSIDE : UNDECIDED;
    return proved_inside(box, boxes.wrenches, boxes.wrench_count, boxes.errors[1]) ? PROVED_INSIDE : UNDECIDED;
}

inline int prove(ProveBoxes& boxes) {
    const PoseQuestion<double>& asked = boxes.asked;
    if (!sound(asked) || asked.mode != MARGIN) return BAD_INPUT;
    int64_t free = 0;
    for (int64_t i = 0; i < asked.m; i++) free += asked.tension_min[i] < asked.tension_max[i];
    const Box box = {asked,
                     pose_space(boxes.pose_space, asked.n, asked.m, asked.k),
                     box_space(boxes.box_space, asked.n, asked.m),
                     boxes.cables,
                     boxes.chosen,
                     free};
    for (int64_t b = 0; b < boxes.count; b++)
        boxes.proved[b] = prove_box(boxes, box, boxes.poses + 7 * b, boxes.halves + 3 * b);
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
