// Transmission between the motor of a winch and its cable. SPDX-License-Identifier: Apache-2.0
//
// Equations: the docstring of `cdpr.cables.transmission`. `numbers`: efficiency; drum speed at which the losses reach
// 76 %, rad/s; growth of the squared radius per length wound, m; lines side by side; falls of a block and tackle;
// length of the cable's path at the home pose, m, NaN without a drum.
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

struct Transmission {
    static constexpr int EFFICIENCY = 0, COULOMB_SPEED = 1, GROWTH = 2, LINES = 3, REEVING = 4, HOME = 5, COUNT = 6;

    // Return the growth of the squared radius per length by which the cable between frame and platform shortens, m.
    template <class T> static CDPR_INLINE T growth(const T* numbers) {
        return numbers[GROWTH] * numbers[LINES] * numbers[REEVING];
    }

    // Return whether the cable per radian may differ from the radius at the home pose.
    template <class T> static CDPR_INLINE bool converts(const T* numbers) {
        return any(numbers[GROWTH] != T(0.0)) || any(numbers[REEVING] != T(1.0));
    }

    // Return the radius, m, with an unwound length, m; `home_radius` is that at the home pose.
    template <class T> static CDPR_INLINE T radius(const T* numbers, T home_radius, T unwound) {
        const T grown = growth(numbers) * (numbers[HOME] - unwound);
        return select(numbers[GROWTH] == T(0.0), home_radius, square_root(home_radius * home_radius + grown));
    }

    // Return the length by which the cable between frame and platform shortens per radian, m.
    template <class T> static CDPR_INLINE T per_turn(const T* numbers, T home_radius, T unwound) {
        return radius(numbers, home_radius, unwound) / numbers[REEVING];
    }

    // Return the acceleration of the length, m/s^2, that corresponds to that of the drum at a constant rate of 1 m/s.
    template <class T> static CDPR_INLINE T quickening(const T* numbers, T per_turn) {
        return numbers[GROWTH] * numbers[LINES] / (2.0 * numbers[REEVING] * per_turn * per_turn);
    }

    // Return the angle of the drum, rad, with an unwound length, m: 0 at the home pose, positive after winding in.
    template <class T> static CDPR_INLINE T angle(const T* numbers, T home_radius, T unwound) {
        const T both = home_radius + radius(numbers, home_radius, unwound);
        return 2.0 * numbers[REEVING] * (numbers[HOME] - unwound) / both;
    }

    // Return the unwound length, m, at an angle of the drum, rad.
    template <class T> static CDPR_INLINE T unwound_at(const T* numbers, T home_radius, T angle) {
        const T turned = home_radius + 0.5 * numbers[GROWTH] * numbers[LINES] * angle;
        const T length = numbers[HOME] - angle * (0.5 * (home_radius + turned)) / numbers[REEVING];
        return select(turned > T(0.0), length, T(NOT_A_NUMBER));
    }

    // Return the torque that moves the cable at a drum speed, rad/s, relative to that without losses.
    template <class T> static CDPR_INLINE T load(const T* numbers, T speed) {
        const T one = 1.0, efficiency = numbers[EFFICIENCY];
        if (!any(efficiency != one)) return one;
        const T lost = (one - efficiency) * hyperbolic_tangent(speed / numbers[COULOMB_SPEED]);
        return (one + efficiency + lost) / (one + efficiency - lost);
    }
};

}  // namespace cdpr::CDPR_TARGET
