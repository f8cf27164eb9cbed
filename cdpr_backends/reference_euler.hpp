// Scheme of the engines: semi-implicit Euler, first order, with cables evaluated once before each step.
// SPDX-License-Identifier: Apache-2.0
//
// First the velocities from the accelerations at the start of the step, then the pose from these velocities.
#pragma once

#include <cdpr/mechanics/attitude.hpp>
#include <cdpr/mechanics/guide.hpp>
#include <cdpr/mechanics/spherical.hpp>

namespace cdpr::CDPR_TARGET {

// Write attitude q exp(h w) and angular velocity after a step at w, rad/s, body axes, from the attitude q.
template <class T> CDPR_INLINE void turn(Quaternion<T> q, Vector<T> w, T* body, T h) {
    put_attitude(normalised(multiply(q, exponential(h * w))), body);
    store(rotate(quaternion(body + 3), w), body + 10);
}

// Step of a free body, whose frame lies at its centre of mass along its principal axes: in body axes w += h I^-1 (M - w
// x I w), then q <- q exp(h w); v += h (F / m + g), then x += h v.
template <class T> struct EulerFreeStep {
    const T* inertial;  // (4), mass, kg, and principal moments, kg m^2
    const T* gravity;   // (3), m/s^2
    const T* applied;   // (6), N and N m, about the body frame's origin, world axes
    T* body;            // (13)
    double step;        // s
    static constexpr char fields[] = "inertial(4), gravity(3), applied(6), both body(13), step";
};

template <class T> inline int euler_free_step(EulerFreeStep<T>& plant) {
    const T h = plant.step;
    const Wrench<T> applied = wrench(plant.applied);
    const Quaternion<T> q = quaternion(plant.body + 3);
    const Vector<T> w = rotate(conjugate(q), vector(plant.body + 10)), M = rotate(conjugate(q), applied.moment);
    const Vector<T> I = vector(plant.inertial + 1);
    const Vector<T> turned = {w.x + h * (M.x - (I.z - I.y) * w.y * w.z) / I.x,
                              w.y + h * (M.y - (I.x - I.z) * w.z * w.x) / I.y,
                              w.z + h * (M.z - (I.y - I.x) * w.x * w.y) / I.z};
    turn(q, turned, plant.body, h);
    const Vector<T> v = vector(plant.body + 7) + h * (applied.force / plant.inertial[0] + vector(plant.gravity));
    store(v, plant.body + 7);
    store(vector(plant.body) + h * v, plant.body);
    return 0;
}

// Step of a body that turns about its held origin: in body axes w += h J^-1 (M - w x J w), then q <- q exp(h w).
template <class T> struct EulerSphericalStep {
    const T* packed;   // (21), spherical.hpp
    const T* gravity;  // (3), m/s^2
    const T* applied;  // (6), N and N m, about the origin, world axes
    T* body;           // (13)
    double step;       // s
    static constexpr char fields[] = "packed(21), gravity(3), applied(6), both body(13), step";
};

template <class T> inline int euler_spherical_step(EulerSphericalStep<T>& plant) {
    const T h = plant.step;
    const Ball<T> ball = {plant.packed};
    const Quaternion<T> q = quaternion(plant.body + 3);
    const Vector<T> w = rotate(conjugate(q), vector(plant.body + 10));
    const Vector<T> moment = moment_about_ball(ball, vector(plant.gravity), q, vector(plant.applied + 3));
    const Vector<T> M = rotate(conjugate(q), moment);
    const Vector<T> a = product(ball.inverse(), M - cross(w, product(ball.inertia(), w)));
    turn(q, w + h * a, plant.body, h);
    return 0;
}

// Step of a platform on a guide: u += h u', then q += h u, for the guide's coordinates q.
template <class T> struct EulerGuidedStep {
    const T* guide;     // (6), guide.hpp
    const T* inertial;  // (13), guide.hpp
    const T* gravity;   // (3), m/s^2
    const T* applied;   // (6), N and N m, about the origin, world axes
    T* motion;          // (8): position, m; angle, rad; velocity, m/s; rate of the angle, rad/s
    T* body;            // (13), after the step
    double step;        // s
    static constexpr char fields[] = "guide(6), inertial(13), gravity(3), applied(6), both motion(8), body(13), step";
};

template <class T> inline int euler_guided_step(EulerGuidedStep<T>& plant) {
    const T h = plant.step;
    GuidedMotion<T> motion = guided_motion(plant.motion);
    const GuidedAcceleration<T> a = guided_acceleration(plant.guide, plant.inertial, vector(plant.gravity),
                                                        motion.angle, motion.spin, wrench(plant.applied));
    motion.velocity = motion.velocity + h * a.linear;
    motion.position = motion.position + h * motion.velocity;
    motion.spin += h * a.angular;
    motion.angle += h * motion.spin;
    store(motion, plant.motion);
    write_state(plant.guide, motion, plant.body);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
