// Acceleration of a platform with its cables' drums. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cholesky.hpp>
#include <cdpr/mechanics/plant.hpp>

namespace cdpr::CDPR_TARGET {

// Mass matrix M and wrench c of the platform alone, about the body's origin, world axes: M twist' + c = applied, c with
// the weight. In directions blocked by a guide M is the identity.
template <class T> struct PlatformDynamics {
    T mass_matrix[36];  // its lower half
    T bias[6];
    bool balanced;       // free, and the centre of mass is the body's origin: M has two blocks
    bool known = false;  // whether all this is computed

    PlatformDynamics() {}

    CDPR_INLINE void compute(const Plant<T>& plant) {
        if (known) return;
        const Inertial<T> inertial = {plant.inertial};
        const Quaternion<T> q = plant.attitude();
        const Vector<T> r = inertial.lever(q);
        balanced = true;
        for (int64_t j = 0; j < 3; j++) balanced = balanced && all(inertial.numbers[inertial.CENTER + j] == T(0.0));
        for (int64_t j = 0; j < 6; j++) balanced = balanced && all(plant.free[j] == T(1.0));
        write_mass_matrix(inertial, q, r, plant.free);
        write_bias(inertial, q, r, vector(plant.body + 10), vector(plant.gravity));
        known = true;
    }

    // The columns are the inverse dynamics of unit accelerations, without terms that are 0.
    CDPR_INLINE void write_mass_matrix(Inertial<T> inertial, Quaternion<T> q, Vector<T> r, const T* free) {
        const Vector<T> none = {0.0, 0.0, 0.0};
        for (int64_t k = 0; k < 6; k++) {
            T unit[6], column[6];
            for (int64_t j = 0; j < 6; j++) unit[j] = j == k ? 1.0 : 0.0;
            const Vector<T> a = vector(unit), alpha = vector(unit + 3);
            const Vector<T> force = inertial.mass() * (k < 3 ? a : none + cross(alpha, r));
            const Vector<T> moment = (k < 3 ? none : inertial.turned_times(q, alpha) + none) + cross(r, force);
            store(force, column);
            store(moment, column + 3);
            for (int64_t j = k; j < 6; j++) mass_matrix[6 * j + k] = column[j] * free[j] * free[k];
            mass_matrix[6 * k + k] = select(free[k] == T(0.0), T(1.0), mass_matrix[6 * k + k]);
        }
    }

    // The inverse dynamics without acceleration.
    CDPR_INLINE void write_bias(Inertial<T> inertial, Quaternion<T> q, Vector<T> r, Vector<T> omega,
                                Vector<T> gravity) {
        const Vector<T> none = {0.0, 0.0, 0.0};
        const Vector<T> force = inertial.mass() * (none + cross(omega, cross(omega, r)) - gravity);
        store(force, bias);
        store(none + cross(omega, inertial.turned_times(q, omega)) + cross(r, force), bias + 3);
    }
};

// Replace the lower half of M (6, 6), which has two blocks, by its factor; return whether it is regular.
template <class T> CDPR_INLINE Truth<T> factorise_blocks(Matrix<T> M) {
    const Matrix<T> linear = M, angular = {&M(3, 3), M.stride};
    const Truth<T> regular = linear(0, 0) > SINGULAR * linear(0, 0);
    const T root = square_root(linear(0, 0));
    for (int64_t k = 0; k < 3; k++) linear(k, k) = root;
    return regular & factorise(angular, 3, T(0.0));
}

// Write the platform's acceleration (6), linear of the body's origin and angular, under `applied`; NaN for a singular
// mass matrix. `system` (6, 6), whose lower half is the mass matrix, is overwritten.
template <class T> CDPR_INLINE void accelerate(const Plant<T>& plant, const PlatformDynamics<T>& dynamics, T* system,
                                               bool blocks, T* acceleration) {
    const Matrix<T> M = {system, 6};
    T rest[6];
    for (int64_t j = 0; j < 6; j++) rest[j] = (plant.applied[j] - dynamics.bias[j]) * plant.free[j];
    const Truth<T> regular = blocks ? factorise_blocks(M) : factorise(M, 6, T(0.0));
    if (any(regular)) solve(M, rest, acceleration, 6);
    for (int64_t j = 0; j < 6; j++)
        acceleration[j] = any(regular) ? select(regular, acceleration[j], T(NOT_A_NUMBER)) : T(NOT_A_NUMBER);
}

// Write the acceleration of the platform without its cables' drums.
template <class T>
CDPR_INLINE void accelerate(const Plant<T>& plant, const PlatformDynamics<T>& dynamics, T* acceleration) {
    T system[36];
    for (int64_t k = 0; k < 36; k++) system[k] = dynamics.mass_matrix[k];
    accelerate(plant, dynamics, system, dynamics.balanced, acceleration);
}

// Write the acceleration of the platform with the drums of taut cables: M + sum of m_i w_i w_i^T.
template <class T>
inline void accelerate_with_drums(const Plant<T>& plant, const PlatformDynamics<T>& dynamics, T* acceleration) {
    const Matrix<T> W = plant.W();
    T system[36], w[6];
    for (int64_t k = 0; k < 36; k++) system[k] = dynamics.mass_matrix[k];
    for (int64_t i = 0; i < plant.m; i++) {
        const T reflected = plant.pulls[i] * plant.mass[i];
        for (int64_t j = 0; j < 6; j++) w[j] = W(j, i) * plant.free[j];
        for (int64_t j = 0; j < 6; j++)
            for (int64_t k = 0; k <= j; k++) system[6 * j + k] = system[6 * j + k] + reflected * w[j] * w[k];
    }
    accelerate(plant, dynamics, system, false, acceleration);
}

// Subtract from the tensions the force that accelerates the drums.
//
// T = max(0, t - m w . twist') with t the tension without inertia, m the drum's inertia as a mass along the cable and w
// the cable's column of W. The set of taut cables is found by iteration: the acceleration with the last set determines
// the next one. One iteration is enough if all cables are taut.
template <class T> inline void share_inertia(Plant<T>& plant, PlatformDynamics<T>& dynamics) {
    dynamics.compute(plant);
    const Matrix<T> W = plant.W();
    const int64_t m = plant.m;
    Truth<T> active = true;
    T acceleration[6];
    for (int64_t i = 0; i < m; i++) plant.pulls[i] = 1.0;
    for (int64_t turn = 0; turn < 2 * m + 2 && any(active); turn++) {
        for (int64_t i = 0; i < m; i++)
            plant.tension[i] = select(active, plant.pulls[i] * plant.light[i], plant.tension[i]);
        apply(plant);
        accelerate_with_drums(plant, dynamics, acceleration);
        Truth<T> changed = false;
        for (int64_t i = 0; i < m; i++) {
            const T along = sum(T(0.0), 0, 6, [&](int64_t j) { return W(j, i) * acceleration[j]; });
            const T own = plant.light[i] - plant.mass[i] * along;
            const Truth<T> heavy = plant.mass[i] != T(0.0), pulled = plant.pulls[i] == T(1.0);
            const Truth<T> slack = own < plant.chain(i).lowest();
            changed = changed | (heavy & ((slack & pulled) | ((!slack) & (!pulled))));
            const T tension = select(heavy, select(slack, T(0.0), own), plant.light[i]);
            plant.tension[i] = select(active, tension, plant.tension[i]);
            plant.pulls[i] = select(active & heavy, select(slack, T(0.0), T(1.0)), plant.pulls[i]);
        }
        active = active & changed;
    }
}

}  // namespace cdpr::CDPR_TARGET
