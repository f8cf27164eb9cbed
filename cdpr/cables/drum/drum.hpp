// Motor with a cable drum. SPDX-License-Identifier: Apache-2.0
//
// I w' = r u - f(w) - r T; equations and source: the docstring of this package. `numbers`: radius r, m; inertia I, kg
// m^2; viscous friction, N m s; Coulomb friction, N m, and the speed, rad/s, at which it reaches 76 % of that.
#pragma once

#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

struct Drum {
    static constexpr int RADIUS = 0, INERTIA = 1, VISCOUS = 2, COULOMB = 3, COULOMB_SPEED = 4;

    // Return the friction torque, N m, at a drum speed, rad/s.
    template <class T> static CDPR_INLINE T friction(const T* numbers, T speed) {
        return numbers[VISCOUS] * speed + numbers[COULOMB] * hyperbolic_tangent(speed / numbers[COULOMB_SPEED]);
    }

    // Return the tension, N, at which the drum moves with a cable that does not stretch, and its inertia as a mass
    // along the cable, I / r^2, kg. The cable's length changes by `rate`, m/s, and, for a platform without
    // acceleration, by `length_acceleration`, m/s^2.
    template <class T>
    static CDPR_INLINE WinchTension<T> held(const T* numbers, T command, T rate, T length_acceleration) {
        const T radius = numbers[RADIUS];
        const T mass = numbers[INERTIA] / (radius * radius);
        return {command - friction(numbers, -rate / radius) / radius + mass * length_acceleration, mass};
    }

    // Return the acceleration of the drum, rad/s^2, under the tension of its cable, N.
    template <class T> static CDPR_INLINE T drum_acceleration(const T* numbers, T command, T tension, T speed) {
        return (numbers[RADIUS] * (command - tension) - friction(numbers, speed)) / numbers[INERTIA];
    }
};

}  // namespace cdpr::CDPR_TARGET
