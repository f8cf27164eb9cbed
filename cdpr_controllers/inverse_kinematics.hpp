// Lengths and rates of the cables for the desired motion: cdpr_controllers/inverse_kinematics.py.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/winding.hpp>
#include <cdpr_controllers/holding.hpp>

namespace cdpr::CDPR_TARGET {

struct InverseKinematics {
    Holding holding;
    const double* chains;   // (m, 33), chain.hpp
    const int64_t* takes;   // (m), a CommandKind: the quantity that each winch takes
    const double* desired;  // (19): position, m; quaternion; velocity, m/s; angular velocity, rad/s; accelerations
    double* command;        // (m), N, m or m/s
    double* wanted;         // (2, m), work space: lengths, m, and rates, m/s, of the desired motion
    double* moving;         // (6, m), work space
    int64_t compensates;    // 1: the lengths are those of cables that hold the weight; 0: that have the pretension
    static constexpr auto fields =
        extended(Holding::fields.text,
                 "chains(m, 33), takes(m), desired(19), command(m), work wanted(2, m), work moving(6, m), compensates");
};

inline int inverse_kinematics(InverseKinematics& p) {
    const Holding& own = p.holding;
    if (!has_anchors<double>(own.w)) return BAD_INPUT;
    hold(own, p.desired);
    Geometry<double> wanted = {own.lines, p.desired, p.moving, p.wanted, p.wanted + own.m, own.m, own.w};
    geometry(wanted);
    const SeenCables cables = {p.chains, own.lines, p.desired, own.gravity, p.wanted, own.m, own.w};
    for (int64_t i = 0; i < own.m; i++) {
        const SeenCable cable = cables.at(i);
        const double unwound = cable.unwound_at(p.compensates ? own.feed[i] : own.pretension);
        if (p.takes[i] == TENSION_COMMAND)
            p.command[i] = own.feed[i];
        else if (p.takes[i] == LENGTH_COMMAND)
            p.command[i] = unwound;
        else
            p.command[i] = cables.rate(i) * unwound / cable.length;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
