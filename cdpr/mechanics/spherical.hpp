// Platforms on a ball joint at their origin. SPDX-License-Identifier: Apache-2.0
//
// See `cdpr.mechanics.spherical`, whose `pack` makes `packed` (21): mass times centre of mass (3), kg m; inertia about
// the origin (3, 3), kg m^2; its inverse (3, 3); platform axes.
#pragma once

#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

template <class T> struct Ball {
    const T* packed;

    CDPR_INLINE const T* held() const { return packed; }
    CDPR_INLINE const T* inertia() const { return packed + 3; }
    CDPR_INLINE const T* inverse() const { return packed + 12; }
};

// Return the moment about the origin, N m, world axes, of the weight of a platform with attitude q and of other loads.
template <class T>
CDPR_INLINE Vector<T> moment_about_ball(Ball<T> ball, Vector<T> gravity, Quaternion<T> q, Vector<T> moment) {
    return moment + cross(rotate(q, vector(ball.held())), gravity);
}

// Return R A R^T v, world axes; A is 3 x 3, platform axes.
template <class T> CDPR_INLINE Vector<T> turned_product(const T* A, Quaternion<T> q, Vector<T> v) {
    return rotate(q, product(A, rotate(conjugate(q), v)));
}

}  // namespace cdpr::CDPR_TARGET
