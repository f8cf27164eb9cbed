// Tables of cable parts by kind. SPDX-License-Identifier: Apache-2.0
//
// A kind is a number in a row of a table, the same in all lanes. It is the position of the part in `cdpr.cables`, whose
// tests compare both. An unknown kind, or a row with too few numbers for its kind, gives NaN, which the checks detect.
#pragma once

#include <cdpr/cables/bent_cable.hpp>
#include <cdpr/cables/catenary/catenary.hpp>
#include <cdpr/cables/catenary/curve.hpp>
#include <cdpr/cables/catenary/rates.hpp>
#include <cdpr/cables/direct/direct.hpp>
#include <cdpr/cables/drum/drum.hpp>
#include <cdpr/cables/elastic/elastic.hpp>
#include <cdpr/cables/ideal_drive.hpp>
#include <cdpr/cables/pulley/pulley.hpp>
#include <cdpr/cables/servo.hpp>
#include <cdpr/cables/stepper.hpp>
#include <cdpr/cables/tabulated/tabulated.hpp>
#include <cdpr/cables/viscoelastic/viscoelastic.hpp>
#include <cdpr/cables/winch_tension.hpp>

namespace cdpr::CDPR_TARGET {

enum ExitKind { POINT, PULLEY };
constexpr int MOST_OF_EXIT = Pulley::COUNT_WITH_FRICTION;  // numbers of an exit

enum WinchKind { DIRECT, DRUM, IDEAL_DRIVE, POSITION_SERVO, VELOCITY_SERVO, STEPPER, STEPPER_MOTOR };
enum SpanKind { INEXTENSIBLE, ELASTIC, CATENARY, TABULATED, VISCOELASTIC };

template <class T> CDPR_INLINE bool is(T kind, int expected) { return first(kind) == expected; }

template <class T> CDPR_INLINE Vector<T> nowhere() { return {NOT_A_NUMBER, NOT_A_NUMBER, NOT_A_NUMBER}; }

// Return the exit point, m, world axes, for a cable to `tip`.
template <class T>
CDPR_INLINE Vector<T> exit_point(T kind, Vector<T> anchor, const T* numbers, int64_t count, Vector<T> tip) {
    if (is(kind, POINT)) return anchor;
    if (is(kind, PULLEY) && count >= Pulley::COUNT) return Pulley::leave(anchor, numbers, tip);
    return nowhere<T>();
}

// Return that point, and the length of cable on the exit, m.
template <class T>
CDPR_INLINE ExitResult<T> lead(T kind, Vector<T> anchor, const T* numbers, int64_t count, Vector<T> tip) {
    if (is(kind, POINT)) return {anchor, 0.0};
    if (is(kind, PULLEY) && count >= Pulley::COUNT) return Pulley::lead(anchor, numbers, tip);
    return {nowhere<T>(), NOT_A_NUMBER};
}

// Return the velocity of the exit point, m/s, while `tip` moves with V.
template <class T> CDPR_INLINE Vector<T> exit_velocity(T kind, Vector<T> anchor, const T* numbers, int64_t count,
                                                       Vector<T> tip, Vector<T> V) {
    if (is(kind, POINT)) return {0.0, 0.0, 0.0};
    if (is(kind, PULLEY) && count >= Pulley::COUNT) return Pulley::carry(anchor, numbers, tip, V);
    return nowhere<T>();
}

// Return whether cables lose tension on an exit with `count` numbers.
template <class T> CDPR_INLINE bool rubs(T kind, int64_t count) {
    return is(kind, PULLEY) && count >= Pulley::COUNT_WITH_FRICTION;
}

// Return the tension towards the winch per tension towards the platform, of a cable with this sine and cosine of its
// angle on the exit, that moves towards the platform at `speed`, m/s.
template <class T> CDPR_INLINE T exit_friction(T kind, const T* numbers, T sine, T cosine, T speed) {
    if (is(kind, PULLEY)) return Pulley::friction(numbers, sine, cosine, speed);
    return NOT_A_NUMBER;
}

// Return whether the tension of a winch depends on the acceleration of its cable.
template <class T> CDPR_INLINE bool is_heavy(T kind) { return !is(kind, DIRECT); }

// Return tension, N, and mass, kg, of a winch whose cable does not stretch; `own` are the winch's own state numbers.
template <class T> CDPR_INLINE WinchTension<T> held(T kind, const T* numbers, [[maybe_unused]] const T* own, T command,
                                                    T rate, T length_acceleration) {
    if (is(kind, DIRECT)) return Direct::held(numbers, command, rate, length_acceleration);
    if (is(kind, DRUM)) return Drum::held(numbers, command, rate, length_acceleration);
    return {NOT_A_NUMBER, NOT_A_NUMBER};
}

// Return whether a winch is a stepper motor. Its command is the rate at which its steps lead to a length.
template <class T> CDPR_INLINE bool is_stepper(T kind) { return is(kind, STEPPER) || is(kind, STEPPER_MOTOR); }
template <class T> CDPR_INLINE StepperNumbers<T> stepper_of(T kind, const T* numbers) {
    return stepper_numbers(numbers + (is(kind, STEPPER) ? Stepper::OWN : StepperMotor::OWN));
}

// Quantity that a winch takes as its command.
enum CommandKind { TENSION_COMMAND, LENGTH_COMMAND, RATE_COMMAND };

template <class T> CDPR_INLINE CommandKind command_of(T kind) {
    if (is(kind, POSITION_SERVO)) return LENGTH_COMMAND;
    if (is(kind, IDEAL_DRIVE) || is(kind, VELOCITY_SERVO) || is_stepper(kind)) return RATE_COMMAND;
    return TENSION_COMMAND;
}

// Return whether the command defines the speed of the winch at once, and that speed.
template <class T> CDPR_INLINE bool prescribes_speed(T kind) { return is(kind, IDEAL_DRIVE) || is(kind, STEPPER); }
template <class T> CDPR_INLINE T prescribed_speed(const T* numbers, T command) {
    return IdealDrive::speed(numbers, command);
}

// Return the speed of the drum, rad/s, that the position loop of a servo wants.
template <class T> CDPR_INLINE T wanted_speed(T kind, WinchMotion<T> motion) {
    return is(kind, POSITION_SERVO) ? PositionServo::wanted(motion) : VelocityServo::wanted(motion);
}

template <class T> CDPR_INLINE bool is_servo(T kind) { return is(kind, POSITION_SERVO) || is(kind, VELOCITY_SERVO); }

// Return the acceleration of the winch's coordinate.
template <class T> CDPR_INLINE T drum_acceleration(T kind, WinchMotion<T> motion) {
    const T *numbers = motion.numbers, command = motion.command, tension = motion.tension, speed = motion.speed;
    if (is(kind, DIRECT)) return Direct::drum_acceleration(numbers, command, tension, speed);
    if (is(kind, DRUM)) return Drum::drum_acceleration(numbers, command, tension, speed);
    if (prescribes_speed(kind)) return 0.0;
    if (is(kind, STEPPER_MOTOR)) return StepperMotor::acceleration(motion);
    if (is_servo(kind)) return Servo::acceleration(motion, wanted_speed(kind, motion));
    return NOT_A_NUMBER;
}

// Return whether the drum turns freely without its motor: its numbers begin with those of a drum.
template <class T> CDPR_INLINE bool turns_freely(T kind) {
    return is(kind, DRUM) || is_servo(kind) || is(kind, STEPPER_MOTOR);
}

// Return the torque of the motor about the drum's axis, N m; NaN for a winch without one.
template <class T> CDPR_INLINE T motor_torque(T kind, WinchMotion<T> motion) {
    if (is(kind, DRUM)) return motion.numbers[Drum::RADIUS] * motion.command;
    if (is(kind, STEPPER)) return motion.numbers[Stepper::RADIUS] * motion.tension;
    if (is(kind, STEPPER_MOTOR)) return StepperMotor::torque(motion);
    if (is_servo(kind)) return Servo::torque(motion, wanted_speed(kind, motion));
    return NOT_A_NUMBER;
}

// Write the `count` own state numbers of a winch at its start.
template <class T> CDPR_INLINE void own_start(T kind, WinchMotion<T> motion, T* own, int64_t count) {
    if (is_servo(kind)) return Servo::own_start(motion, own);
    if (is(kind, STEPPER_MOTOR)) return StepperMotor::own_start(motion, own);
    for (int64_t j = 0; j < count; j++) own[j] = NOT_A_NUMBER;
}

// Write their time derivatives.
template <class T> CDPR_INLINE void own_slopes(T kind, WinchMotion<T> motion, T* slope, int64_t count) {
    if (is_servo(kind)) return Servo::own_slopes(motion, wanted_speed(kind, motion), slope);
    if (is(kind, STEPPER_MOTOR)) return StepperMotor::own_slopes(motion, slope);
    for (int64_t j = 0; j < count; j++) slope[j] = NOT_A_NUMBER;
}

// Return the number of state numbers of a span.
template <class T> CDPR_INLINE int64_t span_states(T kind) { return is(kind, VISCOELASTIC) ? Viscoelastic::STATES : 0; }

// Return the tension of an elastic span without states, N; NaN if nothing is unwound.
template <class T> CDPR_INLINE T pull(T kind, const T* numbers, T length, T unwound, T stretching, T lowest) {
    T found = NOT_A_NUMBER;
    if (is(kind, ELASTIC)) found = Elastic::pull(numbers, length, unwound, stretching, lowest);
    if (is(kind, TABULATED)) found = Tabulated::pull(numbers, length, unwound, stretching, lowest);
    return select(unwound > T(0.0), found, T(NOT_A_NUMBER));
}

// Return the tension of an elastic span, N; NaN if nothing is unwound.
template <class T> CDPR_INLINE T pull(T kind, SpanMotion<T> motion, T lowest) {
    if (is(kind, VISCOELASTIC))
        return select(motion.unwound > T(0.0), Viscoelastic::pull(motion, lowest), T(NOT_A_NUMBER));
    return pull(kind, motion.numbers, motion.length, motion.unwound, motion.stretching, lowest);
}

// Return the tension, N, of an elastic span at rest; NaN if nothing is unwound.
template <class T> CDPR_INLINE T pull_at_rest(T kind, const T* numbers, T length, T unwound, T lowest) {
    if (is(kind, VISCOELASTIC))
        return select(unwound > T(0.0), Viscoelastic::pull_at_rest(numbers, length, unwound, lowest), T(NOT_A_NUMBER));
    return pull(kind, numbers, length, unwound, T(0.0), lowest);
}

// Write the state numbers of a span at its start, at rest.
template <class T>
CDPR_INLINE void span_start(T kind, const T* numbers, T length, T unwound, T lowest, [[maybe_unused]] T* own) {
    if (is(kind, VISCOELASTIC)) Viscoelastic::start(numbers, length, unwound, lowest, own);
}

// Write their time derivatives.
template <class T> CDPR_INLINE void span_slopes(T kind, SpanMotion<T> motion, T lowest, [[maybe_unused]] T* slope) {
    if (is(kind, VISCOELASTIC)) Viscoelastic::slopes(motion, lowest, slope);
}

// Return the unwound length, m, of an elastic span with this tension, N.
template <class T> CDPR_INLINE T rest(T kind, const T* numbers, T length, T tension) {
    if (is(kind, ELASTIC)) return Elastic::rest(numbers, length, tension);
    if (is(kind, TABULATED)) return Tabulated::rest(numbers, length, tension);
    if (is(kind, VISCOELASTIC)) return Viscoelastic::rest(numbers, length, tension);
    return NOT_A_NUMBER;
}

// Return the energy, J, of an elastic span at rest; NaN for spans whose tension four points integrate well.
inline double strain_energy(double kind, const double* numbers, double length, double unwound) {
    if (is(kind, TABULATED)) return unwound * Tabulated::energy(numbers, length / unwound - 1.0);
    return NOT_A_NUMBER;
}

// Return whether the force of an elastic span may have another direction than its chord. Such a span has `bent_pull`
// and `bent_rest` in place of `pull` and `rest`.
template <class T> CDPR_INLINE bool bends(T kind) { return is(kind, CATENARY); }

// Return force and tension, N, of a bent span with this unwound length, m, and rate of stretch, m/s; `lowest` as for
// `pull`.
template <class T> CDPR_INLINE BentCable<T> bent_pull(T kind, BentSpan<T> span, T unwound, T stretching, T lowest) {
    if (is(kind, CATENARY)) return Catenary::pull(span, unwound, stretching, lowest);
    return {nowhere<T>(), NOT_A_NUMBER};
}

// Return the unwound length, m, of a bent span with this tension, N, at its winch.
template <class T> CDPR_INLINE T bent_rest(T kind, BentSpan<T> span, T tension) {
    if (is(kind, CATENARY)) return Catenary::rest(span, tension);
    return NOT_A_NUMBER;
}

// Write the rates of force, N/s, and tension, N/s, of a bent span at rest for `count` motions.
inline void bent_rates(double kind, const BentSpan<double>& span, double unwound, const BentMotion* motions, int count,
                       BentCable<double>* rates) {
    if (is(kind, CATENARY)) return CatenaryRates(span, unwound).write(motions, count, rates);
    for (int j = 0; j < count; j++) rates[j] = {nowhere<double>(), NOT_A_NUMBER};
}

// Return the curve of a bent span at rest; NaN of another kind.
using BentCurve = CatenaryCurve;
inline BentCurve bent_curve(double kind, const BentSpan<double>& span, double unwound) {
    return BentCurve(span, is(kind, CATENARY) ? unwound : NOT_A_NUMBER);
}

// Return the potential energy, J, of a bent span at rest, with its anchor at height 0; with that of its winch if this
// keeps the tension constant.
inline double bent_energy(double kind, const BentSpan<double>& span, double unwound, bool constant_tension) {
    if (is(kind, CATENARY)) return catenary_energy(span, unwound, constant_tension);
    return NOT_A_NUMBER;
}

}  // namespace cdpr::CDPR_TARGET
