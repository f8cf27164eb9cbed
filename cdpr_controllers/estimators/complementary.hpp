// Complementary filter of an inertial measurement unit and a pose: cdpr_controllers/estimators/complementary.py.
// SPDX-License-Identifier: Apache-2.0
//
// Attitude: passive filter with bias, R. Mahony, T. Hamel, J.-M. Pflimlin, Nonlinear complementary filters on the
// special orthogonal group, IEEE Transactions on Automatic Control 53(5), 2008, 1203-1218, eq. 47 to 49 in discrete
// time. Position and velocity: a Luenberger observer with two equal poles.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

struct ComplementaryFilter {
    const double* inertial;   // (6), mean specific force, m/s^2, and angular velocity, rad/s, platform axes
    const double* moved;      // (1), 1 if it has arrived at this control step
    const double* moved_age;  // (1), s
    const double* pose;       // (7), measured or fitted position, m, and quaternion
    const double* valid;      // (1), 1 if the pose is valid
    const double* corrects;   // (1), 1 if it has arrived at this control step
    const double* pose_age;   // (1), s
    const double* start;      // (13), state at time 0
    const double* point;      // (3), m, place of the unit, platform axes
    const double* gravity;    // (3), m/s^2, world
    const double* gains;      // (3): bandwidth, rad/s; k_P, 1/s; k_I, 1/s^2
    double* memory;           // (18): position and velocity of the unit; quaternion; bias; last angular velocity;
                              // times of the last inertial measurement and of the last pose, s
    double* estimate;         // (13)
    static constexpr char fields[] =
        "inertial(6), moved(1), moved_age(1), pose(7), valid(1), corrects(1), pose_age(1), start(13), point(3), "
        "gravity(3), gains(3), both memory(18), both estimate(13)";
};

struct InertialState {
    Vector<double> position, velocity;
    Quaternion<double> q;
    Vector<double> bias, turning;
};

CDPR_INLINE Quaternion<double> unit(Quaternion<double> q) {
    const double norm = square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

// Integrate the inertial measurement: the attitude by the mean of two angular velocities, then the velocity.
CDPR_INLINE void integrate(const ComplementaryFilter& p, InertialState& s, double elapsed) {
    const Vector<double> turning = vector(p.inertial + 3);
    s.q = unit(multiply(s.q, exponential(elapsed * (0.5 * (s.turning + turning) - s.bias))));
    s.turning = turning;
    const Vector<double> before = s.velocity;
    s.velocity = s.velocity + elapsed * (rotate(s.q, vector(p.inertial)) + vector(p.gravity));
    s.position = s.position + (0.5 * elapsed) * (before + s.velocity);
}

// Largest gain times the time between two poses. After a longer time, such as an occlusion, a correction overshoots.
constexpr double LARGEST_SHARE = 0.5;

// Correct by the pose, `elapsed` (s) after the last correction, or a shorter time that keeps the filter stable.
CDPR_INLINE void correct(const ComplementaryFilter& p, InertialState& s, double elapsed) {
    const double bandwidth = p.gains[0], span = smaller(elapsed, LARGEST_SHARE / bandwidth);
    const double turning = smaller(elapsed, LARGEST_SHARE / p.gains[1]);
    const Quaternion<double> q = quaternion(p.pose + 3);
    const Vector<double> apart = vector(p.pose) + rotate(q, vector(p.point)) - s.position;
    s.position = s.position + (2.0 * bandwidth * span) * apart;
    s.velocity = s.velocity + (bandwidth * bandwidth * span) * apart;
    const Quaternion<double> error = multiply(conjugate(s.q), q);
    const Vector<double> tilt = (2.0 * error.w) * Vector<double>{error.x, error.y, error.z};
    s.q = unit(multiply(s.q, exponential((p.gains[1] * turning) * tilt)));
    s.bias = s.bias - (p.gains[2] * turning) * tilt;
}

inline int complementary_filter(ComplementaryFilter& p, double time) {
    double* const m = p.memory;
    const bool first = !(time > 0.0);
    if (first) {
        const Quaternion<double> q = quaternion(p.start + 3);
        const Vector<double> reach = rotate(q, vector(p.point));
        store(vector(p.start) + reach, m);
        store(vector(p.start + 7) + cross(vector(p.start + 10), reach), m + 3);
        store(q, m + 6);
        store(Vector<double>{0.0, 0.0, 0.0}, m + 10);
        store(rotate(conjugate(q), vector(p.start + 10)), m + 13);
        m[16] = m[17] = 0.0;
    }
    InertialState s = {vector(m), vector(m + 3), quaternion(m + 6), vector(m + 10), vector(m + 13)};
    if (*p.moved != 0.0 && !first) {
        const double taken = time - *p.moved_age;
        if (taken > m[16]) integrate(p, s, taken - m[16]);
        m[16] = taken;
    }
    if (*p.corrects != 0.0 && *p.valid != 0.0 && !first) {
        const double taken = time - *p.pose_age;
        if (taken > m[17]) correct(p, s, taken - m[17]);
        m[17] = taken;
    }
    store(s.position, m);
    store(s.velocity, m + 3);
    store(s.q, m + 6);
    store(s.bias, m + 10);
    store(s.turning, m + 13);
    const Vector<double> reach = rotate(s.q, vector(p.point)), omega = rotate(s.q, s.turning - s.bias);
    store(s.position - reach, p.estimate);
    store(s.q, p.estimate + 3);
    store(s.velocity - cross(omega, reach), p.estimate + 7);
    store(omega, p.estimate + 10);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
