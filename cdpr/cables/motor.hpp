// Current, voltage and electrical power of DC motors. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// Numbers of a motor; equations: the docstring of `cdpr.cables.motor`. NaN for winches without such a motor.
struct Motor {
    static constexpr int CONSTANT = 0, RESISTANCE = 1, COUNT = 2;  // N m/A about the drum's axis; ohm
};

// Electrical quantities of the motors at torques and speeds of their drums.
struct MotorReading {
    const double* motors;  // (m, 2), Motor
    const double* torque;  // (k, m), N m, of the motor about the drum's axis
    const double* speed;   // (k, m), rad/s, of the drum
    double* current;       // (k, m), A
    double* voltage;       // (k, m), V
    double* power;         // (k, m), W
    int64_t k;
    int64_t m;
    static constexpr char fields[] =
        "motors(m, 2), torque(k, m), speed(k, m), current(k, m), voltage(k, m), power(k, m), k, m";
};

inline int read_motors(MotorReading& p) {
    for (int64_t i = 0; i < p.k * p.m; i++) {
        const double* motor = p.motors + i % p.m * Motor::COUNT;
        p.current[i] = p.torque[i] / motor[Motor::CONSTANT];
        p.voltage[i] = motor[Motor::RESISTANCE] * p.current[i] + motor[Motor::CONSTANT] * p.speed[i];
        p.power[i] = p.voltage[i] * p.current[i];
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
