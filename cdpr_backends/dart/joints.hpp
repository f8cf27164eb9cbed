// Forces of DART's joints, and corrections of DART's attitude. SPDX-License-Identifier: Apache-2.0
//
// See `cdpr_backends.dart.joints`. `kept` begins with the attitude of DART's body axes in ours, w, x, y, z. A body
// state (13): position, m; attitude w, x, y, z; velocity, m/s; angular velocity, rad/s; world axes.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

// DART ignores forces that are not finite; after an overflow it prints endless warnings and continues with zeros. Above
// this force, N or N m, or speed, m/s or rad/s, it must not step: the state becomes NaN.
constexpr double DART_SANE = 1e12;

// DART truncates the exponential of a rotation vector below 1e-3 rad after its second power, with an error of a sixth
// of the third: 2e-10 rad. It uses it for a joint's attitude and for the rotation of each step. So its body axes are
// rotated relative to ours, and again if a joint's rotation vector gets nearer to zero than this, rad.
constexpr double DART_NEAR = 0.2;

// Write NaN for the first force if DART cannot step with this motion and wrench.
CDPR_INLINE void reject_insane(const double* body, const double* applied, double* forces) {
    double largest = 0.0;
    for (int i = 0; i < 6; i++) largest = largest + (absolute(applied[i]) + absolute(body[7 + i]));
    if (!(largest < DART_SANE)) forces[0] = NOT_A_NUMBER;
}

CDPR_INLINE Quaternion<double> dart_attitude(const double* kept, const double* body) {
    return multiply(quaternion(body + 3), quaternion(kept));
}

// Forces of a free joint.
struct DartFreeForces {
    const double* body;     // (13)
    const double* applied;  // (6), N and N m, about the body's origin, world axes
    double* forces;         // (6), moment and force, world axes; the first NaN if DART must not step
    static constexpr char fields[] = "body(13), applied(6), forces(6)";
};

inline int dart_free_forces(DartFreeForces& joint) {
    store(vector(joint.applied + 3), joint.forces);
    store(vector(joint.applied), joint.forces + 3);
    reject_insane(joint.body, joint.applied, joint.forces);
    return 0;
}

// Moment of a ball joint.
struct DartBallForces {
    const double* kept;     // (7)
    const double* body;     // (13)
    const double* applied;  // (6), as in DartFreeForces
    double* forces;         // (3), moment along DART's body axes; the first NaN if DART must not step
    static constexpr char fields[] = "kept(7), body(13), applied(6), forces(3)";
};

inline int dart_ball_forces(DartBallForces& joint) {
    const Quaternion<double> q = dart_attitude(joint.kept, joint.body);
    store(rotate(conjugate(q), vector(joint.applied + 3)), joint.forces);
    reject_insane(joint.body, joint.applied, joint.forces);
    return 0;
}

// Forces along the joints of a guide.
struct DartGuideForces {
    const int64_t* rows;    // (n), rows of a wrench of the joints, each 0 to 5
    const double* body;     // (13)
    const double* applied;  // (6), as in DartFreeForces
    double* forces;         // (n), N and N m; the first NaN if DART must not step
    int64_t n;
    static constexpr char fields[] = "rows(n >= 1), body(13), applied(6), forces(n >= 1), n";
};

inline int dart_guide_forces(DartGuideForces& joints) {
    for (int64_t k = 0; k < joints.n; k++) joints.forces[k] = joints.applied[joints.rows[k]];
    reject_insane(joints.body, joints.applied, joints.forces);
    return 0;
}

// Rotate the attitude of a body to the end of DART's step of `step` s, at the angular velocity w there, world axes, and
// write the rotation vector of DART's axes. Return whether that is too near to zero for DART's next step.
CDPR_INLINE bool follow_turn(const double* kept, double step, Vector<double> w, double* rotation, double* body) {
    const Quaternion<double> a = multiply(exponential(step * w), quaternion(body + 3));
    const double scale = 1.0 / square_root(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z);  // limits round-off
    store(Quaternion<double>{scale * a.w, scale * a.x, scale * a.y, scale * a.z}, body + 3);
    store(w, body + 10);
    const Vector<double> turned = logarithm(dart_attitude(kept, body));
    store(turned, rotation);
    return dot(turned, turned) < DART_NEAR * DART_NEAR;
}

// Body state after a step of DART's free joint. Returns 1 if DART's axes must be rotated again.
struct DartFollowFree {
    const double* kept;   // (4)
    const double* rates;  // (6), angular velocity and velocity, world axes
    double* coordinates;  // (6), rotation vector, which is corrected, and position
    double* body;         // (13)
    double step;          // s
    static constexpr char fields[] = "kept(4), rates(6), both coordinates(6), both body(13), step";
};

inline int dart_follow_free(DartFollowFree& joint) {
    store(vector(joint.coordinates + 3), joint.body);
    store(vector(joint.rates + 3), joint.body + 7);
    return follow_turn(joint.kept, joint.step, vector(joint.rates), joint.coordinates, joint.body);
}

// The same for a ball joint, whose angular velocity is along DART's body axes; a rotation does not change its own axis.
struct DartFollowBall {
    const double* kept;   // (7)
    const double* rates;  // (3), angular velocity
    double* coordinates;  // (3), rotation vector
    double* body;         // (13)
    double step;          // s
    static constexpr char fields[] = "kept(7), rates(3), both coordinates(3), both body(13), step";
};

inline int dart_follow_ball(DartFollowBall& joint) {
    const Vector<double> w = rotate(dart_attitude(joint.kept, joint.body), vector(joint.rates));
    return follow_turn(joint.kept, joint.step, w, joint.coordinates, joint.body);
}

}  // namespace cdpr::CDPR_TARGET
