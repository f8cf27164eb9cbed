// Frame in which rigid bodies are integrated, and the wrench on them. SPDX-License-Identifier: Apache-2.0
//
// See `cdpr.mechanics.body_frame`. A state (13): position, m; attitude w, x, y, z; velocity, m/s; angular velocity,
// rad/s; world axes. `offset` (7): position of the body frame's origin relative to the platform's, body axes (3), m,
// and attitude of the body frame relative to the platform (4).
#pragma once

#include <cdpr/mechanics/geometry.hpp>

namespace cdpr::CDPR_TARGET {

// Write the body state of a platform state.
template <class T> CDPR_INLINE void from_platform(const T* offset, const T* state, T* body) {
    const Quaternion<T> attitude = multiply(quaternion(state + 3), quaternion(offset + 3));
    const Vector<T> r = rotate(attitude, vector(offset)), omega = vector(state + 10);
    const Vector<T> position = vector(state) + r, velocity = vector(state + 7) + cross(omega, r);
    store(position, body);
    store(attitude, body + 3);
    store(velocity, body + 7);
    store(omega, body + 10);
}

// Write the platform state of a body state.
template <class T> CDPR_INLINE void to_platform(const T* offset, const T* body, T* state) {
    const Quaternion<T> q = quaternion(body + 3);
    const Vector<T> r = rotate(q, vector(offset)), omega = vector(body + 10);
    const Vector<T> position = vector(body) - r, velocity = vector(body + 7) - cross(omega, r);
    store(position, state);
    store(multiply(q, conjugate(quaternion(offset + 3))), state + 3);
    store(velocity, state + 7);
    store(omega, state + 10);
}

// Return the wrench of cables, `pull`, and of an external wrench at the platform's origin, about the origin of the body
// frame, for a body with attitude q. The platform's origin is at -r from there. World axes.
template <class T>
CDPR_INLINE Wrench<T> with_external(Wrench<T> pull, const T* offset, const T* external, Quaternion<T> q) {
    const Wrench<T> push = wrench(external);
    const Vector<T> lever = cross(rotate(q, vector(offset)), push.force);
    return {pull.force + push.force, pull.moment + push.moment - lever};
}

// Platform state to body state.
template <class T> struct BodyState {
    const T* offset;  // (7)
    const T* state;   // (13), of the platform
    T* body;          // (13)
    static constexpr char fields[] = "offset(7), state(13), body(13)";
};

template <class T> inline int body_state(BodyState<T>& frame) {
    from_platform(frame.offset, frame.state, frame.body);
    return 0;
}

// Body state to platform state.
template <class T> struct PlatformState {
    const T* offset;  // (7)
    const T* body;    // (13)
    T* state;         // (13), of the platform
    static constexpr char fields[] = "offset(7), body(13), state(13)";
};

template <class T> inline int platform_state(PlatformState<T>& frame) {
    to_platform(frame.offset, frame.body, frame.state);
    return 0;
}

// Wrench of the cables and of external loads on a body.
template <class T> struct AppliedWrench {
    const T* lines;     // (m, w), geometry.hpp, with B_i in the body frame
    const T* offset;    // (7)
    const T* tension;   // (m), N
    const T* external;  // (6), N and N m, at the platform's origin, world axes
    const T* body;      // (13)
    T* applied;         // (6), N and N m, about the body frame's origin, world axes
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "lines(m, w >= 6), offset(7), tension(m), external(6), body(13), applied(6), m, w";
};

template <class T> inline int applied_wrench(AppliedWrench<T>& body) {
    if (!has_anchors<T>(body.w)) return code(T(double(BAD_INPUT)));
    const Quaternion<T> q = quaternion(body.body + 3);
    const Vector<T> p = vector(body.body);
    const Wrench<T> pull = are_eight<T>(body.w, body.m)
                               ? pull_of_cables<true>(body.lines, body.w, body.m, body.tension, p, q)
                               : pull_of_cables(body.lines, body.w, body.m, body.tension, p, q);
    store(with_external(pull, body.offset, body.external, q), body.applied);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
