// Stretch of cables in an error-state Kalman filter: ekf_stretch.py. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr_controllers/estimators/ekf_prediction.hpp>

namespace cdpr::CDPR_TARGET {

// Stretch of a cable. It hardly depends on the pose, so it keeps its value while measurements correct the pose.
template <class T> struct CableStretch {
    T* ratio;  // length per unwound length; NaN before the first tension acts
    T* state;  // on a drum with a state: rate of the length minus that of the unwound length, m/s; with load cells: the
               // length minus the unwound length, m
};

// Drum and span of a cable whose length changes at a constant rate.
template <class T> struct StretchedCable {
    ChainRow<T> chain;
    T command;  // N
    T length;   // m
    T rate;     // m/s

    static constexpr double LENGTH_STEP = 1e-6;  // m, of numerical derivatives: far above round-off
    static constexpr int SUBSTEPS = 4;  // of a control period: drums on stiff cables vibrate at some hundred rad/s

    // Return the tension, N, at an unwound length, m, with a rate of the stretch, m/s.
    CDPR_INLINE T tension(T unwound, T stretching) const {
        return pull(chain.span_kind(), chain.span(), length, unwound, stretching, chain.lowest());
    }

    // Return the acceleration of the drum, rad/s^2, at an unwound length, m, and its speed, rad/s; write the tension,
    // N.
    CDPR_INLINE T turn(T unwound, T speed, T& tension_now) const {
        const T own[MOST_STATES] = {};
        T present[ChainRow<T>::NUMBERS];
        const T* numbers = chain.winch(unwound, present);
        tension_now = tension(unwound, rate + numbers[0] * speed);
        const T load = chain.load(tension_now, speed);
        return drum_acceleration(chain.winch_kind(),
                                 WinchMotion<T>{numbers, own, command, load, unwound, speed, chain.transmission()});
    }

    // Advance the drum by a control period, s, by the linearised implicit midpoint rule; return its mean tension, N.
    inline T advance_drum(double period, T& unwound, T& speed) {
        const double step = period / SUBSTEPS;
        const T h = step, half = 0.5 * step, quarter = 0.25 * step;
        T total = 0.0, ignored = 0.0;
        length = length + half * rate;
        for (int k = 0; k < SUBSTEPS; k++, length = length + h * rate) {
            const T per_turn = chain.per_turn(unwound), middle = unwound - half * per_turn * speed;
            const T now = turn(middle, speed, ignored);
            const T by_length = (turn(middle + T(LENGTH_STEP), speed, ignored) - now) / T(LENGTH_STEP);
            const T by_speed = (turn(middle, speed + T(SPEED_STEP), ignored) - now) / T(SPEED_STEP);
            const T gain = h * now / (T(1.0) - half * (by_speed - half * per_turn * by_length));
            T mean = 0.0;
            turn(middle - quarter * per_turn * gain, speed + T(0.5) * gain, mean);
            total = total + mean;
            unwound = unwound - h * per_turn * (speed + T(0.5) * gain);
            speed = speed + gain;
        }
        return total / T(double(SUBSTEPS));
    }

    // Return the stretch, m, a control period, s, after the given one, while the tension, N, changes evenly: the
    // damping d of a cable delays the stretch behind the tension. That of a linear differential equation with the
    // exponential exp(-h k / d) as 1 / (1 + x + x^2 / 2), x = h k / d. A slack cable takes the stretch at rest. Write
    // its response (3) to errors, as in TensionErrors.
    CDPR_INLINE T follow_tension(double period, T begin, T end, T stretch, T* response) const {
        const T zero = 0.0, half = 0.5, unwound = length - stretch, held = tension(unwound, zero);
        const T d = tension(unwound, T(1.0)) - held;
        const T stiffness = (tension(unwound - T(LENGTH_STEP), zero) - held) / T(LENGTH_STEP);
        const T hk = T(period) * stiffness, whole = d * d + d * hk + half * hk * hk;
        const T more = (d + half * hk) * hk * (begin - held) + half * (d + hk) * hk * (end - begin);
        const T at_rest = length - rest(chain.span_kind(), chain.span(), length, end);
        const T scale = hk / (whole * stiffness),
                taut[3] = {T(1.0) - (d + half * hk) * scale * stiffness, half * d * scale, half * (d + hk) * scale};
        for (int j = 0; j < 3; j++) response[j] = select(stiffness > zero, taut[j], response[j]);
        return select(stiffness > zero, stretch + more / (whole * stiffness), at_rest);
    }
};

// Replace the commands of drums on cables that stretch, N, by the mean tensions of the coming period, and advance the
// drums; `after` then has their unwound lengths, m, and speeds, rad/s. Cables keep the rates of the start.
template <class T> inline void advance_drums(const FilteredPlatform<T>& p, const T* state, CableStretch<T> before,
                                             T* tension, CableStretch<T> after) {
    const Truth<T> acts = tension[0] == tension[0];
    if (!p.drums || !any(acts)) return;
    Geometry<T> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<T> chain = chain_row(p.chains, i);
        if (!on_drum(p, chain)) continue;
        StretchedCable<T> cable = {chain, tension[i], p.length[i], p.rate[i]};
        const Truth<T> starts = before.ratio[i] != before.ratio[i];  // at the first tension, with constant stretch
        T unwound = select(starts, rest(chain.span_kind(), chain.span(), p.length[i], tension[i]),
                           p.length[i] / before.ratio[i]);
        T speed = (select(starts, T(0.0), before.state[i]) - p.rate[i]) / chain.per_turn(unwound);
        tension[i] = select(acts, cable.advance_drum(p.period, unwound, speed), tension[i]);
        after.ratio[i] = unwound;
        after.state[i] = speed;
    }
}

// Return the unwound length of cable i, m, at rest with a tension, N, at a pose for which `geometry` has been called.
template <class T> CDPR_INLINE T unwound_at(const FilteredPlatform<T>& p, T tension, int64_t i) {
    const ChainRow<T> chain = chain_row(p.chains, i);
    return rest(chain.span_kind(), chain.span(), p.length[i], tension);
}

// Write the stretch of cables at a predicted state: that of their drums, that which follows a measured tension, or that
// at rest under the tension of a winch that moves with its cable. `begin` and `end` of the period: commands or measured
// tensions, N. With load cells, also write the response of the stretch to errors.
template <class T> inline void write_stretch(const FilteredPlatform<T>& p, const T* state, const T* begin, const T* end,
                                             CableStretch<T> before, CableStretch<T> after,
                                             const TensionErrors<T>& errors) {
    const Truth<T> driven = Truth<T>(p.driven != 0) & (begin[0] == begin[0]);
    Geometry<T> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    for (int64_t i = 0; i < p.m; i++) {
        const ChainRow<T> chain = chain_row(p.chains, i);
        const T length = p.length[i], old = before.state[i];
        T ratio = before.ratio[i], own_state = old;
        if (on_drum(p, chain)) {
            own_state = p.rate[i] + chain.per_turn(after.ratio[i]) * after.state[i];
            ratio = length / after.ratio[i];
        } else if (chain.stretches()) {
            const T own[MOST_STATES] = {};
            const T pull = p.noisy ? end[i] : chain.held(own, end[i], length, p.rate[i], T(0.0)).tension;
            const T unwound = unwound_at(p, pull, i);
            own_state = length - unwound;
            ratio = length / unwound;
            if (!p.noisy) {
                after.ratio[i] = select(driven, ratio, before.ratio[i]);
                after.state[i] = select(driven, own_state, old);
                continue;
            }
            T* const response = errors.response(i);
            response[0] = response[1] = 0.0;
            response[2] = (unwound - unwound_at(p, end[i] + p.cells[i], i)) / p.cells[i];
            if (has_stretch_state(chain)) {
                const StretchedCable<T> cable = {chain, T(0.0), length, p.rate[i]};
                const Truth<T> known = old == old;
                const T found = cable.follow_tension(p.period, begin[i], end[i], old, response);
                own_state = select(known, found, own_state);
                ratio = select(known, length / (length - found), ratio);
            }
        }
        after.ratio[i] = select(driven, ratio, before.ratio[i]);
        after.state[i] = select(driven, own_state, old);
    }
}

}  // namespace cdpr::CDPR_TARGET
