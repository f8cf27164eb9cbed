// Stepper motors with a drum. SPDX-License-Identifier: Apache-2.0
//
// Equations and source: the docstring of `cdpr.cables.stepper`. `numbers` of a stepper without inertia: radius, m, and
// the `StepperNumbers`; with inertia: those of a drum (drum.hpp) and the `StepperNumbers`. Own state of the latter:
// unwound length to which the steps so far lead, m.
#pragma once

#include <cdpr/cables/drum/drum.hpp>
#include <cdpr/cables/transmission.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct StepperNumbers {
    static constexpr double PERIOD = 4.0;  // full steps in a period of the torque
    static constexpr double TURN = 6.283185307179586, QUARTER = 1.5707963267948966;  // rad

    T steps_per_turn;
    T microsteps;    // in a full step
    T stall_torque;  // N m
    T speed_max;     // rad/s
    T gear_ratio;

    CDPR_INLINE T full_step() const { return TURN / (steps_per_turn * gear_ratio); }  // rad, of the drum
    CDPR_INLINE T microstep() const { return full_step() / microsteps; }
};

template <class T> CDPR_INLINE StepperNumbers<T> stepper_numbers(const T* first) {
    return {first[0], first[1], first[2], first[3], first[4]};
}

// Stepper without inertia: its drum turns as its steps.
struct Stepper {
    static constexpr int RADIUS = 0, OWN = 1;
};

// Stepper whose rotor has an inertia.
struct StepperMotor {
    static constexpr int OWN = 5;
    static constexpr int REFERENCE = 0;

    template <class T> static CDPR_INLINE T torque(WinchMotion<T> motion) {
        const StepperNumbers<T> own = stepper_numbers(motion.numbers + OWN);
        const T per_turn = motion.numbers[Drum::RADIUS];
        const T behind = Transmission::turned(motion.transmission, per_turn, motion.unwound, motion.own[REFERENCE]);
        return own.stall_torque * sine(behind / own.full_step() * StepperNumbers<T>::QUARTER);
    }

    // Return the acceleration of the drum, rad/s^2.
    template <class T> static CDPR_INLINE T acceleration(WinchMotion<T> motion) {
        const T* n = motion.numbers;
        const T load = n[Drum::RADIUS] * motion.tension + Drum::friction(n, motion.speed);
        return (torque(motion) - load) / n[Drum::INERTIA];
    }

    // At the start the motor holds the load, if it can.
    template <class T> static CDPR_INLINE void own_start(WinchMotion<T> motion, T* own) {
        const StepperNumbers<T> numbers = stepper_numbers(motion.numbers + OWN);
        const T radius = motion.numbers[Drum::RADIUS];
        const T load = radius * motion.tension + Drum::friction(motion.numbers, motion.speed);
        const T share = smaller(larger(load / numbers.stall_torque, T(-1.0)), T(1.0));
        const T lag = angle_of(share, square_root(T(1.0) - share * share));
        const T angle = numbers.full_step() * lag / StepperNumbers<T>::QUARTER;
        const T mean = Transmission::mean_per_turn(motion.transmission, radius, angle);
        own[REFERENCE] = motion.unwound - mean * numbers.full_step() * lag / StepperNumbers<T>::QUARTER;
    }

    // The steps of a control period are spread evenly over it.
    template <class T> static CDPR_INLINE void own_slopes(WinchMotion<T> motion, T* slope) {
        slope[REFERENCE] = motion.command;
    }
};

}  // namespace cdpr::CDPR_TARGET
