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
    double* beside;         // (6), work space: wrench of cables that sag less that of their tensions along the chords
    int64_t compensates;    // 1: the lengths are those of cables that hold the weight; 0: that have the pretension
    static constexpr auto fields = extended(
        Holding::fields.text,
        "chains(m, 33), takes(m), desired(19), command(m), work wanted(2, m), work moving(6, m), work beside(6), "
        "compensates");

    NominalCables cables() const {
        return {chains, holding.lines, desired, holding.gravity, wanted, holding.m, holding.w};
    }
};

// Repetitions of the holding tensions for cables that sag, whose wrench changes little with them.
constexpr int SAG_STEPS = 5;

// Write the wrench of cables that sag with the holding tensions at their winches; return whether there are any.
inline bool write_beside(InverseKinematics& p) {
    const Holding& own = p.holding;
    const NominalCables cables = p.cables();
    Vector<double> force = no_vector<double>(), moment = force;
    bool some = false;
    for (int64_t i = 0; i < own.m; i++) {
        const NominalCable cable = cables.at(i);
        const double kind = cable.chain.span_kind(), tension = own.feed[i];
        if (!bends(kind)) continue;
        some = true;
        const BentCable<double> end = bent_pull(kind, cable.span, cable.unwound_at(tension), 0.0, cable.chain.lowest());
        const Vector<double> f = end.force - (tension / length(cable.span.chord)) * cable.span.chord;
        const Line<double> path = line(own.lines, own.w, i, vector(p.desired), quaternion(p.desired + 3));
        if (!finite(dot(f, f))) continue;  // no equilibrium with so little tension: its length is not finite, either
        force = force + f;
        moment = moment + cross(path.lever, f);
    }
    store(force, p.beside);
    store(moment, p.beside + 3);
    return some;
}

inline int inverse_kinematics(InverseKinematics& p) {
    const Holding& own = p.holding;
    if (!has_anchors<double>(own.w)) return BAD_INPUT;
    hold(own, p.desired);
    Geometry<double> wanted = {own.lines, p.desired, p.moving, p.wanted, p.wanted + own.m, own.m, own.w};
    geometry(wanted);
    for (int k = 0; k < SAG_STEPS && write_beside(p); k++) hold(own, p.desired, p.beside);
    const NominalCables cables = p.cables();
    for (int64_t i = 0; i < own.m; i++) {
        const NominalCable cable = cables.at(i);
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
