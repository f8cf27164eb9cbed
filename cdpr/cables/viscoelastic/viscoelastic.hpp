// Cable that creeps and has hysteresis. SPDX-License-Identifier: Apache-2.0
//
// T = Q + H + d (l' - l0'), Q = E A (e - c_1 - c_2 - c_3), H = K (e - p); see the docstring of this package. `numbers`:
// E A, N; damping d, N s/m; creep coefficients; retardation times, s, 0 for unused elements; stiffness K and largest
// tension S of the hysteresis, N; progress of the creep at the start and at rest. Own states: strains c_1 to c_3 of the
// creep, and strain p of the slip.
#pragma once

#include <cdpr/cables/span_motion.hpp>

namespace cdpr::CDPR_TARGET {

struct Viscoelastic {
    static constexpr int STIFFNESS = 0, DAMPING = 1, COEFFICIENT = 2, TIME = 5, FRICTION_STIFFNESS = 8,
                         FRICTION_TENSION = 9, PROGRESS = 10;
    static constexpr int ELEMENTS = 3, SLIP = ELEMENTS, STATES = ELEMENTS + 1;

    template <class T> static CDPR_INLINE Truth<T> creeps(const T* numbers, int k) {
        return numbers[TIME + k] > T(0.0);
    }

    // Return the strain of the spring E A.
    template <class T> static CDPR_INLINE T spring_strain(const T* own, T strain) {
        T found = strain;
        for (int k = 0; k < ELEMENTS; k++) found = found - own[k];
        return found;
    }

    // Return H, N, at most S in size: the slip lags behind within long steps.
    template <class T> static CDPR_INLINE T friction(const T* numbers, const T* own, T strain) {
        const T most = numbers[FRICTION_TENSION];
        const T held = smaller(larger(numbers[FRICTION_STIFFNESS] * (strain - own[SLIP]), -most), most);
        return select(most > T(0.0), held, T(0.0));
    }

    // Return the tension without damping, N; not positive for a slack cable.
    template <class T> static CDPR_INLINE T still(const T* numbers, const T* own, T strain) {
        return numbers[STIFFNESS] * spring_strain(own, strain) + friction(numbers, own, strain);
    }

    // Return the tension, N, as of the elastic cable.
    template <class T> static CDPR_INLINE T pull(SpanMotion<T> motion, T lowest) {
        const T at_rest = still(motion.numbers, motion.own, motion.strain());
        const T tension = at_rest + motion.numbers[DAMPING] * motion.stretching;
        const Truth<T> slack = (at_rest <= T(0.0)) & (lowest == T(0.0));
        return select(slack, T(0.0), select(tension < lowest, lowest, tension));
    }

    // Return the strain per tension at rest, 1/N, with this progress of the creep, in the middle of the hysteresis.
    template <class T> static CDPR_INLINE T compliance(const T* numbers) {
        T total = 0.0;
        for (int k = 0; k < ELEMENTS; k++) total = total + select(creeps(numbers, k), numbers[COEFFICIENT + k], T(0.0));
        return (1.0 + numbers[PROGRESS] * total) / numbers[STIFFNESS];
    }
    template <class T> static CDPR_INLINE T pull_at_rest(const T* numbers, T length, T unwound, T lowest) {
        const T tension = (length - unwound) / unwound / compliance(numbers);
        return select(tension < lowest, lowest, tension);
    }
    template <class T> static CDPR_INLINE T rest(const T* numbers, T length, T tension) {
        return length / (1.0 + tension * compliance(numbers));
    }

    // Write the states of a cable at rest.
    template <class T> static CDPR_INLINE void start(const T* numbers, T length, T unwound, T lowest, T* own) {
        const T tension = pull_at_rest(numbers, length, unwound, lowest);
        for (int k = 0; k < ELEMENTS; k++) {
            const T share = numbers[PROGRESS] * numbers[COEFFICIENT + k] * tension / numbers[STIFFNESS];
            own[k] = select(creeps(numbers, k), share, T(0.0));
        }
        own[SLIP] = tension * compliance(numbers);
    }

    // Write the time derivatives of the states.
    template <class T> static CDPR_INLINE void slopes(SpanMotion<T> motion, T lowest, T* slope) {
        const T *numbers = motion.numbers, *own = motion.own, strain = motion.strain();
        const Truth<T> slack = (still(numbers, own, strain) <= T(0.0)) & (lowest == T(0.0));
        const T loaded = select(slack, T(0.0), spring_strain(own, strain));
        for (int k = 0; k < ELEMENTS; k++) {
            const T time = select(creeps(numbers, k), numbers[TIME + k], T(1.0));
            slope[k] = select(creeps(numbers, k), (numbers[COEFFICIENT + k] * loaded - own[k]) / time, T(0.0));
        }
        const T held = friction(numbers, own, strain), most = numbers[FRICTION_TENSION], rate = motion.strain_rate();
        const Truth<T> slips = (held * rate > T(0.0)) & !slack;
        slope[SLIP] = select(slips, rate * absolute(held) / select(most > T(0.0), most, T(1.0)), T(0.0));
    }
};

}  // namespace cdpr::CDPR_TARGET
