// Stretch of cables in an error-state Kalman filter: ekf_stretch.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr_controllers/estimators/ekf_prediction.hpp>

namespace cdpr::CDPR_TARGET {

// Stretch of a cable. It hardly depends on the pose, so it keeps its value while measurements correct the pose.
struct CableStretch {
    double* ratio;  // length per unwound length; NaN before the first tension acts
    double* rate;   // m/s, rate of the length minus that of the unwound length
};

// Drum and span of a cable whose length changes at a constant rate.
struct StretchedCable {
    ChainRow<double> chain;
    double command;  // N
    double length;   // m
    double rate;     // m/s

    static constexpr double LENGTH_STEP = 1e-6;  // m, of numerical derivatives: far above round-off
    static constexpr int SUBSTEPS = 4;  // of a control period: drums on stiff cables vibrate at some hundred rad/s

    // Return the tension, N, at an unwound length, m, with a rate of the stretch, m/s.
    CDPR_INLINE double tension(double unwound, double stretching) const {
        return pull(chain.span_kind(), chain.span(), length, unwound, stretching, chain.lowest());
    }

    // Return the acceleration of the drum, rad/s^2, at an unwound length, m, and its speed, rad/s; write the tension, N.
    CDPR_INLINE double turn(double unwound, double speed, double& tension_now) const {
        const double own[MOST_STATES] = {};
        double present[ChainRow<double>::NUMBERS];
        const double* numbers = chain.winch(unwound, present);
        tension_now = tension(unwound, rate + numbers[0] * speed);
        const double load = chain.load(tension_now, speed);
        return drum_acceleration(chain.winch_kind(),
                                 WinchMotion<double>{numbers, own, command, load, unwound, speed, chain.transmission()});
    }

    // Advance the drum by a control period, s, by the linearised implicit midpoint rule; return its mean tension, N.
    inline double advance_drum(double period, double& unwound, double& speed) {
        const double h = period / SUBSTEPS;
        double total = 0.0, ignored;
        length += 0.5 * h * rate;
        for (int k = 0; k < SUBSTEPS; k++, length += h * rate) {
            const double per_turn = chain.per_turn(unwound), middle = unwound - 0.5 * h * per_turn * speed;
            const double now = turn(middle, speed, ignored);
            const double by_length = (turn(middle + LENGTH_STEP, speed, ignored) - now) / LENGTH_STEP;
            const double by_speed = (turn(middle, speed + SPEED_STEP, ignored) - now) / SPEED_STEP;
            const double gain = h * now / (1.0 - 0.5 * h * (by_speed - 0.5 * h * per_turn * by_length));
            double mean;
            turn(middle - 0.25 * h * per_turn * gain, speed + 0.5 * gain, mean);
            total += mean;
            unwound -= h * per_turn * (speed + 0.5 * gain);
            speed += gain;
        }
        return total / SUBSTEPS;
    }

    // Advance the stretch by a control period, s, under a measured tension, N, by the linearised backward Euler rule:
    // the damping of a cable delays the stretch behind the tension. Cables without tension take the stretch at rest.
    inline void follow_tension(double period, double measured, double& ratio) const {
        const double unwound = length / ratio, held = tension(unwound, 0.0), damping = tension(unwound, 1.0) - held;
        const double stiffness = (tension(unwound - LENGTH_STEP, 0.0) - held) / LENGTH_STEP;
        const double resistance = damping + period * stiffness;
        if (!(resistance > 0.0)) {
            ratio = length / rest(chain.span_kind(), chain.span(), length, measured);
            return;
        }
        const double more = period * (measured - held) / resistance;
        ratio = length / (unwound - more);
    }
};

// Replace the commands of drums on cables that stretch, N, by the mean tensions of the coming period, and advance the
// drums; `after` then has their unwound lengths, m, and speeds, rad/s. Cables keep the rates of the start.
inline void advance_drums(const FilteredPlatform& p, const double* state, CableStretch before, double* tension,
                          CableStretch after) {
    if (!p.drums || tension[0] != tension[0]) return;
    Geometry<double> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<double> chain = chain_row(p.chains, i);
        if (!on_drum(p, chain)) continue;
        StretchedCable cable = {chain, tension[i], p.length[i], p.rate[i]};
        const bool starts = before.ratio[i] != before.ratio[i];  // at the first tension, with constant stretch
        double unwound = starts ? rest(chain.span_kind(), chain.span(), p.length[i], tension[i])
                                : p.length[i] / before.ratio[i];
        double speed = ((starts ? 0.0 : before.rate[i]) - p.rate[i]) / chain.per_turn(unwound);
        tension[i] = cable.advance_drum(p.period, unwound, speed);
        after.ratio[i] = unwound;
        after.rate[i] = speed;
    }
}

// Return the unwound length of cable i, m, at rest with a tension, N, at a pose for which `geometry` has been called.
inline double unwound_at(const FilteredPlatform& p, const double* state, double tension, int64_t i) {
    const ChainRow<double> chain = chain_row(p.chains, i);
    const Line<double> cable = line(p.lines, p.w, i, vector(state), quaternion(state + 3));
    const BentSpan<double> span = cable.span(cable.lead(), chain.span(), vector(p.gravity));
    return unwound_length(chain, span, p.length[i], tension);
}

// Write the stretch of cables at a predicted state: that of their drums, that which follows a measured tension, or that
// at rest under the tension of a winch that moves with its cable. `tension`: N, commands or measured.
inline void write_stretch(const FilteredPlatform& p, const double* state, const double* tension, CableStretch before,
                          CableStretch after) {
    const bool driven = p.driven && tension[0] == tension[0];
    Geometry<double> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<double> chain = chain_row(p.chains, i);
        if (driven && on_drum(p, chain)) {
            after.rate[i] = p.rate[i] + chain.per_turn(after.ratio[i]) * after.rate[i];
            after.ratio[i] = p.length[i] / after.ratio[i];
            continue;
        }
        after.rate[i] = 0.0;
        after.ratio[i] = before.ratio[i];
        if (!driven || !chain.stretches()) continue;
        if (p.noisy && has_stretch_state(chain) && before.ratio[i] == before.ratio[i]) {
            const StretchedCable cable = {chain, 0.0, p.length[i], p.rate[i]};
            cable.follow_tension(p.period, tension[i], after.ratio[i]);
            continue;
        }
        const double own[MOST_STATES] = {};
        const double pull =
            p.noisy ? tension[i] : chain.held(own, tension[i], p.length[i], p.rate[i], 0.0).tension;
        after.ratio[i] = p.length[i] / unwound_at(p, state, pull, i);
    }
}

}  // namespace cdpr::CDPR_TARGET
