// Motor, drum and control loops of a servo drive. SPDX-License-Identifier: Apache-2.0
//
// Equations: the docstring of `cdpr.cables.servo`. `numbers`: radius r, m; inertia I, kg m^2; viscous friction, N m s;
// Coulomb friction, N m, and its speed, rad/s; velocity gain, N m s; integral gain, N m; largest speed, rad/s,
// acceleration, rad/s^2, and torque, N m; time constant of the torque, s; of a position servo the position gain, 1/s.
// Own states: integral, N m; torque, N m.
#pragma once

#include <cdpr/cables/drum/drum.hpp>

namespace cdpr::CDPR_TARGET {

struct Servo {
    static constexpr int VELOCITY_GAIN = 5, INTEGRAL_GAIN = 6, SPEED_MAX = 7, ACCELERATION_MAX = 8, TORQUE_MAX = 9,
                         LAG = 10, POSITION_GAIN = 11;
    static constexpr int INTEGRAL = 0, TORQUE = 1;

    template <class T> static CDPR_INLINE T within(T value, T most) { return smaller(larger(value, -most), most); }

    // Return the torque that the velocity loop demands for a speed, rad/s, and whether its limit cuts it off.
    template <class T> struct Demand {
        T torque, error;
        Truth<T> limited;
    };
    template <class T> static CDPR_INLINE Demand<T> demand(WinchMotion<T> motion, T wanted) {
        const T* n = motion.numbers;
        const T error = within(wanted, n[SPEED_MAX]) - motion.speed;
        const T most = n[Drum::INERTIA] * n[ACCELERATION_MAX];
        const T free = within(n[VELOCITY_GAIN] * error, most) + motion.own[INTEGRAL];
        const T torque = within(free, n[TORQUE_MAX]);
        return {torque, error, torque != free};
    }

    // Return the torque of the motor, N m.
    template <class T> static CDPR_INLINE T torque(WinchMotion<T> motion, T wanted) {
        return select(motion.numbers[LAG] > T(0.0), motion.own[TORQUE], demand(motion, wanted).torque);
    }

    // Return the acceleration of the drum, rad/s^2.
    template <class T> static CDPR_INLINE T acceleration(WinchMotion<T> motion, T wanted) {
        const T* n = motion.numbers;
        const T load = n[Drum::RADIUS] * motion.tension + Drum::friction(n, motion.speed);
        return (torque(motion, wanted) - load) / n[Drum::INERTIA];
    }

    // At the start the motor holds the tension at the speed of the drum.
    template <class T> static CDPR_INLINE void own_start(WinchMotion<T> motion, T* own) {
        const T* n = motion.numbers;
        own[INTEGRAL] = n[Drum::RADIUS] * motion.tension + Drum::friction(n, motion.speed);
        own[TORQUE] = own[INTEGRAL];
    }

    // The integral stops while a limit of the torque acts in its direction.
    template <class T> static CDPR_INLINE void own_slopes(WinchMotion<T> motion, T wanted, T* slope) {
        const T* n = motion.numbers;
        const Demand<T> now = demand(motion, wanted);
        const Truth<T> winds_up = now.limited & (now.torque * now.error > T(0.0));
        slope[INTEGRAL] = select(winds_up, T(0.0), n[INTEGRAL_GAIN] * now.error);
        const Truth<T> lags = n[LAG] > T(0.0);
        slope[TORQUE] = select(lags, (now.torque - motion.own[TORQUE]) / select(lags, n[LAG], T(1.0)), T(0.0));
    }
};

// Servo whose command is the unwound length, m.
struct PositionServo {
    template <class T> static CDPR_INLINE T wanted(WinchMotion<T> motion) {
        const T* n = motion.numbers;
        return n[Servo::POSITION_GAIN] * (motion.unwound - motion.command) / n[Drum::RADIUS];
    }
};

// Servo whose command is the rate of the unwound length, m/s.
struct VelocityServo {
    template <class T> static CDPR_INLINE T wanted(WinchMotion<T> motion) {
        return -motion.command / motion.numbers[Drum::RADIUS];
    }
};

}  // namespace cdpr::CDPR_TARGET
