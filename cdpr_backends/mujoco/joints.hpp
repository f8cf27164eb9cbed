// Body states of MuJoCo's joints. SPDX-License-Identifier: Apache-2.0
//
// A body state (13): position, m; attitude w, x, y, z; velocity, m/s; angular velocity, rad/s; world axes. Angular
// velocities of MuJoCo's joints are along body axes.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

struct MujocoFreeState {
    const double* coordinates;  // (7): position and attitude
    const double* rates;        // (6): velocity and angular velocity
    double* body;               // (13)
    static constexpr char fields[] = "coordinates(7), rates(6), body(13)";
};

inline int mujoco_free_state(MujocoFreeState& joint) {
    const Quaternion<double> q = quaternion(joint.coordinates + 3);
    store(vector(joint.coordinates), joint.body);
    store(q, joint.body + 3);
    store(vector(joint.rates), joint.body + 7);
    store(rotate(q, vector(joint.rates + 3)), joint.body + 10);
    return 0;
}

struct MujocoBallState {
    const double* home;         // (3), position of the ball
    const double* coordinates;  // (4): attitude
    const double* rates;        // (3): angular velocity
    double* body;               // (13)
    static constexpr char fields[] = "home(3), coordinates(4), rates(3), body(13)";
};

inline int mujoco_ball_state(MujocoBallState& joint) {
    const Quaternion<double> q = quaternion(joint.coordinates);
    store(vector(joint.home), joint.body);
    store(q, joint.body + 3);
    store(Vector<double>{0.0, 0.0, 0.0}, joint.body + 7);
    store(rotate(q, vector(joint.rates)), joint.body + 10);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
