// Attitude of a rotating body, for integrators. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

// Rate of the attitude q of a body with angular velocity w, rad/s, world axes: w q / 2.
template <class T> CDPR_INLINE Quaternion<T> turning(Quaternion<T> q, Vector<T> w) {
    return {-0.5 * (w.x * q.x + w.y * q.y + w.z * q.z), 0.5 * (w.x * q.w + w.y * q.z - w.z * q.y),
            0.5 * (w.y * q.w + w.z * q.x - w.x * q.z), 0.5 * (w.z * q.w + w.x * q.y - w.y * q.x)};
}

// q / |q|.
template <class T> CDPR_INLINE Quaternion<T> normalised(Quaternion<T> q) {
    const T norm = square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

// Write an attitude into a body state (13), with the sign that is nearer to the last one: engines choose the sign
// freely, and change it during rotation.
template <class T> CDPR_INLINE void put_attitude(Quaternion<T> q, T* body) {
    const T sign = select(q.w * body[3] + q.x * body[4] + q.y * body[5] + q.z * body[6] >= T(0.0), T(1.0), T(-1.0));
    store(Quaternion<T>{sign * q.w, sign * q.x, sign * q.y, sign * q.z}, body + 3);
}

}  // namespace cdpr::CDPR_TARGET
