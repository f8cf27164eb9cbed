// Motion of an inertial measurement unit on the platform. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

struct InertialMotion {
    const double* state;     // (13), of the platform
    const double* point;     // (3), m, of the unit, platform axes
    const double* attitude;  // (4), of its axes, platform axes
    const double* gravity;   // (3), m/s^2, world axes
    double* before;          // (3), m/s, velocity of the point at the last measurement
    double* count;           // (1), control steps
    double* truth;           // (6), m/s^2 and rad/s, platform axes: mean specific force since then, turn rate
    double period;           // s, from one measurement to the next
    int64_t every;           // control steps in it
    static constexpr char fields[] =
        "state(13), point(3), attitude(4), gravity(3), both before(3), both count(1), truth(6), period, every >= 1";
};

// Write the mean specific force over a period, (v(t) - v(t - h)) / h - g, and the turn rate; as at rest at time 0.
inline int inertial_motion(InertialMotion& p, double time) {
    const bool first = !(time > 0.0);
    *p.count = first ? 0.0 : *p.count + 1.0;
    if (int64_t(*p.count) % p.every != 0) return 0;
    const Quaternion<double> back = conjugate(quaternion(p.state + 3));
    const Quaternion<double> mount = conjugate(quaternion(p.attitude));
    const Vector<double> spin = vector(p.state + 10);
    const Vector<double> velocity = vector(p.state + 7) + cross(spin, rotate(quaternion(p.state + 3), vector(p.point)));
    Vector<double> force = {-p.gravity[0], -p.gravity[1], -p.gravity[2]};
    if (!first) force = force + (velocity - vector(p.before)) / p.period;
    store(velocity, p.before);
    store(rotate(mount, rotate(back, force)), p.truth);
    store(rotate(mount, rotate(back, spin)), p.truth + 3);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
