// Derivatives and energy of the elastic, heavy cable. SPDX-License-Identifier: Apache-2.0
//
// Symbols: the docstring of this package, and V = (V_0 + V_1) / 2, k = 1 / EA. The flexibility of the span at constant
// L, from the derivatives of Irvine's equations, with D = S^2 - 4 V^2:
//
//     dl/dH = l / H - L D / (2 S T_0 T_1),   dz/dV = k L + L D / (2 S T_0 T_1),
//     dl/dV = dz/dH = -2 H V L / (S T_0 T_1).
#pragma once

#include <cdpr/cables/catenary/catenary.hpp>

namespace cdpr::CDPR_TARGET {

// Equilibrium of a cable.
struct CatenaryState {
    Catenary::Frame<double> at;
    double wrapped, rise_of_anchor, k, w, L, S, pull, H, V, strain, T0, T1, winch;

    inline CatenaryState(const BentSpan<double>& span, double unwound) : at(span) {
        const Catenary::Shape<double> shape =
            Catenary::hang(at.level, at.rise, at.chord, at.weight, at.compliance, unwound, span.wrapped_length, false);
        wrapped = span.wrapped_length, rise_of_anchor = dot(span.exit_to_anchor, at.up);
        k = 2.0 * at.compliance, w = at.weight, L = shape.span, S = shape.sum, pull = shape.pull;
        H = pull * at.level, V = shape.middle, strain = shape.strain;
        const double difference = S > 0.0 ? w * V * L / S : 0.0;
        T0 = 0.5 * S - difference, T1 = 0.5 * S + difference;
        winch = at.carried(T1, at.climb);
    }
    CDPR_INLINE double V0() const { return V - 0.5 * w * L; }
    CDPR_INLINE double V1() const { return V + 0.5 * w * L; }
};

struct CatenaryRates : CatenaryState {
    Vector<double> level;  // horizontal unit vector; 0 if the cable is vertical
    double kll, klz, kzz;  // N/m, stiffness in the plane of the cable
    double l_by_length, z_by_length, sum_by_length, start, end;

    inline CatenaryRates(const BentSpan<double>& span, double unwound) : CatenaryState(span, unwound) {
        const Vector<double> none = {0.0, 0.0, 0.0};
        level = at.level > 0.0 ? (1.0 / at.level) * at.across : none;
        start = T0 > 0.0 ? 1.0 / T0 : 0.0, end = T1 > 0.0 ? 1.0 / T1 : 0.0;
        const double vertical = V0() * V1(), both = T0 * T1;
        const double apart =
            vertical > 0.0 ? H * H * (H * H + V0() * V0() + V1() * V1()) / (both + vertical) : both - vertical;
        const double share = 0.5 * L * (2.0 * (H * H + apart)) / S * (start * end);
        const double mixed = -2.0 * H * V * L / S * (start * end), upright = k * L + share;
        kll = 1.0 / ((1.0 / pull - share) - mixed * mixed / upright);
        klz = -mixed / upright * kll;
        kzz = 1.0 / upright - mixed / upright * klz;
        if (!(S > 0.0)) kll = klz = kzz = 0.0;  // slack without weight
        l_by_length = H * (k + 0.5 * S * start * end);
        z_by_length = k * V + 0.5 * (V1() * end + V0() * start);
        sum_by_length = sum_rate(strains(none, 1.0), 1.0);
    }

    // Rates of H and V.
    struct Forces {
        double H, V;
    };

    inline Forces strains(Vector<double> chord, double length) const {
        const double l = dot(level, chord) - l_by_length * length, z = dot(at.up, chord) - z_by_length * length;
        return {kll * l + klz * z, klz * l + kzz * z};
    }
    inline double sum_rate(Forces rate, double length) const {
        const double half = 0.5 * w * length;
        return (H * rate.H + V0() * (rate.V - half)) * start + (H * rate.H + V1() * (rate.V + half)) * end;
    }

    inline BentCable<double> of(const BentMotion& motion) const {
        const double grown = 1.0 + strain, still = 0.0, share = 0.5 * k * wrapped / (grown * grown);
        const double paid = motion.unwound - motion.wrapped_length / grown;
        const double stretched = share * sum_rate(strains(motion.chord, still), still);
        const double length = (paid + stretched) / (1.0 - share * sum_by_length), half = 0.5 * w * length;
        const Forces rate = strains(motion.chord, length);
        const Vector<double> aside = motion.chord - dot(at.up, motion.chord) * at.up - dot(level, motion.chord) * level;
        const double at_exit = (H * rate.H + V1() * (rate.V + half)) * end;
        const double climbing = wrapped > 0.0 ? w * dot(motion.exit_to_anchor, at.up) : 0.0;
        const double tension = ((1.0 + k * T1) * at_exit + climbing) / (1.0 + k * winch);
        return {rate.H * level + pull * aside + (rate.V - half) * at.up, tension};
    }

    inline void write(const BentMotion* motions, int count, BentCable<double>* rates) const {
        for (int j = 0; j < count; j++) rates[j] = of(motions[j]);
    }
};

// Return the energy, J, of strain and weight, with the anchor at height 0. The part on the exit has the mean strain,
// and its weight in the middle. With `constant_tension`, that of the winch is added, whose force along the unstretched
// cable is T + T^2 / (2 EA).
inline double catenary_energy(const BentSpan<double>& span, double unwound, bool constant_tension) {
    const CatenaryState at(span, unwound);
    const double heavy = at.w * at.L, carried = at.wrapped / (1.0 + at.strain);
    const double winch = constant_tension ? at.winch * (1.0 + 0.5 * at.k * at.winch) * unwound : 0.0;
    if (!(at.S > 0.0)) return at.S == 0.0 ? winch : at.S;
    const double strain = 0.5 * at.k * at.L * (at.H * at.H + at.V * at.V + heavy * heavy / 12.0);
    const double risen = at.L * (at.V * at.V + heavy * at.V) / at.S - 0.25 * at.L * at.S +
                         0.5 * at.H * (at.at.level - at.k * at.H * at.L) +
                         0.5 * at.k * heavy * at.L * (at.V0() + heavy / 3.0);
    const double below = heavy * (at.at.rise + at.rise_of_anchor) + 0.5 * at.w * carried * at.rise_of_anchor;
    return strain + risen - below + 0.125 * at.k * carried * at.S * at.S + winch;
}

}  // namespace cdpr::CDPR_TARGET
