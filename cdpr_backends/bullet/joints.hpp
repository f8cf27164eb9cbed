// Body states of Bullet's joints. SPDX-License-Identifier: Apache-2.0
//
// A body state (13): position, m; attitude w, x, y, z; velocity, m/s; angular velocity, rad/s; world axes. Bullet's
// quaternions are x, y, z, w.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/mechanics/attitude.hpp>

namespace cdpr::CDPR_TARGET {

CDPR_INLINE Quaternion<double> quaternion_of_bullet(const double* q) { return {q[3], q[0], q[1], q[2]}; }

struct BulletBaseState {
    const double* base;  // (13): position, quaternion, velocity, angular velocity
    double* body;        // (13); the sign of its attitude is read
    static constexpr char fields[] = "base(13), both body(13)";
};

inline int bullet_base_state(BulletBaseState& plant) {
    put_attitude(quaternion_of_bullet(plant.base + 3), plant.body);
    store(vector(plant.base), plant.body);
    store(vector(plant.base + 7), plant.body + 7);
    store(vector(plant.base + 10), plant.body + 10);
    return 0;
}

struct BulletBallState {
    const double* home;   // (3), position of the ball
    const double* axes;   // (4), attitude of the principal axes in the platform, w, x, y, z: those of a link
    const double* joint;  // (7): quaternion, and angular velocity along the link's axes
    double* body;         // (13); the sign of its attitude is read
    static constexpr char fields[] = "home(3), axes(4), joint(7), both body(13)";
};

inline int bullet_ball_state(BulletBallState& plant) {
    const Quaternion<double> axes = quaternion(plant.axes);
    const Quaternion<double> link = multiply(axes, quaternion_of_bullet(plant.joint));
    put_attitude(multiply(link, conjugate(axes)), plant.body);
    store(rotate(link, vector(plant.joint + 4)), plant.body + 10);
    store(vector(plant.home), plant.body);
    store(Vector<double>{0.0, 0.0, 0.0}, plant.body + 7);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
