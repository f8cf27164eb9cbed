// Wrenches that the cables of a robot can exert at a pose. SPDX-License-Identifier: Apache-2.0
//
// Capacity margin, wrench closure or payload, from the facets of the set of wrenches (facets.hpp). Moments are divided
// by the characteristic length.
#pragma once

#include <cdpr/analysis/workspace/redundancy_two.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/tension/null_space.hpp>

namespace cdpr::CDPR_TARGET {

// Results for a pose: it has a value; W is rank-deficient, so the cables exert nothing in some direction; numbers are
// not finite, for example if both anchors of a cable coincide.
enum PoseStatus { REGULAR, LACKS_RANK, NO_NUMBERS };

// Data of all poses.
template <class T> struct PoseQuestion {
    const T* lines;         // (m, w), as of geometry.hpp
    const T* tension_min;   // (m), N
    const T* tension_max;   // (m), N
    const int64_t* rows;    // (n), degrees of freedom: rows of a wrench, 0 to 5
    const T* weights;       // (n), 1 for forces, 1 / characteristic length, 1/m, for moments
    const T* inertial;      // (13), as of `Robot.inertial`
    const T* gravity;       // (3), m/s^2, world
    const T* vectors;       // (k, 6), of the required set: N and N m, or m/s^2 and rad/s^2
    int64_t mode;           // Mode
    int64_t form;           // Required
    int64_t accelerations;  // whether the vectors are accelerations
    int64_t n;
    int64_t m;
    int64_t w;
    int64_t k;
    static constexpr char fields[] =
        "lines(m, w >= 6), tension_min(m), tension_max(m), rows(n), weights(n), inertial(13), gravity(3), "
        "vectors(k, 6), mode, form, accelerations, n, m, w, k";
};

template <class T> CDPR_INLINE bool sound(const PoseQuestion<T>& asked) {
    bool found = has_anchors<T>(asked.w);
    for (int64_t j = 0; j < asked.n; j++) found = found && 0 <= asked.rows[j] && asked.rows[j] < 6;
    return found;
}

// Memory for successive arrays.
template <class T> struct Memory {
    T* next;

    CDPR_INLINE T* reserve(int64_t count) {
        T* begin = next;
        next += count;
        return begin;
    }
};

// Work space for one pose, or for eight in lanes, and the results.
template <class T> struct PoseSpace {
    static constexpr char SIZE[] =
        "3*n*n + 3*n*m + n*k + m*k + 2*m*m + 10*n + 12*m + 2";  // numbers that `pose_space` allocates

    T *matrix, *wrench, *load, *required;  // (n, m), (n), (n), (k, n)
    T *basis, *box, *factors;              // of null_space.hpp
    T *gram, *Y, *G, *Z, *off, *half;      // of redundancy_two.hpp
    T *A, *x, *p, *c;                      // of facets.hpp
    T* best;                               // (n), direction with the smallest margin, a unit vector; else NaN
    T* value;                              // (2), value, and the largest term of its difference
};

template <class T> CDPR_INLINE PoseSpace<T> pose_space(T* memory, int64_t n, int64_t m, int64_t k) {
    Memory<T> space = {memory};
    PoseSpace<T> found;
    found.matrix = space.reserve(n * m);
    found.wrench = space.reserve(n);
    found.load = space.reserve(n);
    found.required = space.reserve(k * n);
    found.basis = space.reserve(m * m);
    found.box = space.reserve(4 * m);
    found.factors = space.reserve((n + 5) * (n + m));
    found.gram = space.reserve(n * n);
    found.Y = space.reserve(n * m);
    found.G = space.reserve(m * m);
    found.Z = space.reserve(k * m);
    found.off = space.reserve(m);
    found.half = space.reserve(m);
    found.A = space.reserve(n * n);
    found.x = space.reserve(n);
    found.p = space.reserve(m);
    found.c = space.reserve(n);
    found.best = space.reserve(n);
    found.value = space.reserve(2);
    return found;
}

template <class T>
CDPR_INLINE TensionProblem<T> tension_problem(const PoseQuestion<T>& asked, const PoseSpace<T>& space) {
    return {space.matrix, space.wrench, asked.tension_min, asked.tension_max, nullptr, nullptr,
            space.basis,  space.box,    space.factors,     asked.n,           asked.m};
}

// Write W, the wrench of the weight at rest, and the vectors of the required set in the pose's attitude.
template <class T> inline void set_up(const PoseQuestion<T>& asked, const T* pose, const PoseSpace<T>& space) {
    const Vector<T> position = vector(pose), none = {0.0, 0.0, 0.0};
    const Quaternion<T> attitude = quaternion(pose + 3);
    const int64_t n = asked.n, m = asked.m;
    T six[6];
    for (int64_t i = 0; i < m; i++) {
        const Line<T> cable = line(asked.lines, asked.w, i, position, attitude);
        const Vector<T> l = cable.chord(cable.lead().point);
        const Vector<T> u = l / length(l);
        store(u, six);
        store(cross(cable.lever, u), six + 3);
        for (int64_t j = 0; j < n; j++) space.matrix[j * m + i] = asked.weights[j] * six[asked.rows[j]];
    }
    const Inertial<T> body = {asked.inertial};
    store(inverse_dynamics(body, vector(asked.gravity), attitude, none, none, none), six);
    for (int64_t j = 0; j < n; j++) space.wrench[j] = asked.weights[j] * six[asked.rows[j]];
    for (int64_t v = 0; v < asked.k; v++) {
        const T* given = asked.vectors + 6 * v;
        for (int i = 0; i < 6; i++) six[i] = given[i];
        if (asked.accelerations)
            store(inverse_dynamics(body, none, attitude, none, vector(given), vector(given + 3)), six);
        for (int64_t j = 0; j < n; j++) space.required[v * n + j] = asked.weights[j] * six[asked.rows[j]];
    }
}

template <class T> CDPR_INLINE TwoMore<T> two_more(const PoseQuestion<T>& asked, const PoseSpace<T>& space) {
    const int64_t n = asked.n, m = asked.m;
    return {asked.form,
            n,
            m,
            asked.k,
            {space.matrix, m},
            {space.basis, m},
            {space.required, n},
            space.box,
            asked.tension_min,
            asked.tension_max,
            {space.gram, n},
            {space.Y, m},
            {space.G, m},
            {space.Z, m},
            space.off,
            space.half,
            space.best};
}

// Write the value for two redundant cables; return whether there is one.
template <class T> CDPR_INLINE Truth<T> value_of_two(const PoseQuestion<T>& asked, const PoseSpace<T>& space) {
    if (asked.mode != CLOSURE) return margin_of_two(two_more(asked, space), space.value);
    space.value[0] = closure_of_two<T>({space.basis, asked.m}, asked.m);
    space.value[1] = 1.0;
    for (int64_t j = 0; j < asked.n; j++) space.best[j] = NOT_A_NUMBER;
    return true;
}

// Write Y = (W W^T)^-1 W of the free cables; return whether that is possible.
inline bool project_free(const PoseQuestion<double>& asked, const PoseSpace<double>& space, const int64_t* free,
                         int64_t count) {
    const int64_t n = asked.n, m = asked.m;
    const Matrix<double> W = {space.matrix, m}, L = {space.gram, n}, Y = {space.Y, m};
    for (int64_t j = 0; j < n; j++)
        for (int64_t k = 0; k <= j; k++)
            L(j, k) = sum(0.0, 0, count, [&](int64_t i) { return W(j, free[i]) * W(k, free[i]); });
    if (!factorise(L, n, 0.0)) return false;
    for (int64_t i = 0; i < count; i++) {
        for (int64_t j = 0; j < n; j++) space.c[j] = W(j, free[i]);
        solve(L, space.c, space.p, n);
        for (int64_t j = 0; j < n; j++) Y(j, i) = space.p[j];
    }
    return true;
}

// Write the value of one pose from all facets; return whether there is one.
inline bool value_of_facets(const PoseQuestion<double>& asked, const PoseSpace<double>& space, int64_t* cables,
                            int64_t count, int64_t r) {
    const int64_t n = asked.n, m = asked.m, *free = cables;
    if (asked.mode != CLOSURE && r < n - 1 && !project_free(asked, space, free, count)) return false;
    FacetSearch search = {asked.mode,
                          asked.form,
                          n,
                          m,
                          asked.k,
                          r,
                          {space.matrix, m},
                          {space.basis, m},
                          {space.required, n},
                          space.box,
                          asked.tension_min,
                          asked.tension_max,
                          space.load,
                          free,
                          count,
                          cables + m,
                          {space.Y, m},
                          {space.A, n},
                          space.x,
                          space.p,
                          space.c,
                          space.best};
    search.run();
    space.value[0] = search.least;
    space.value[1] = search.scale;
    return true;
}

// Write value, scale and direction of one pose (7), and into `cables` (n + m) those with tensions that their limits do
// not determine.
inline PoseStatus assess_pose(const PoseQuestion<double>& asked, const double* pose, const PoseSpace<double>& space,
                              int64_t* cables) {
    const int64_t n = asked.n, m = asked.m;
    set_up(asked, pose, space);
    for (int64_t j = 0; j < n; j++) {
        space.best[j] = NOT_A_NUMBER;
        space.load[j] = space.wrench[j] / asked.inertial[Inertial<double>::MASS];  // of 1 kg at the centre of mass
    }
    space.value[0] = NOT_A_NUMBER;
    space.value[1] = 1.0;
    const int64_t r = reduce(tension_problem(asked, space));
    if (r == -INFEASIBLE || r == -NOT_FOUND) return LACKS_RANK;
    if (r < 0) return NO_NUMBERS;
    int64_t count = 0;
    for (int64_t i = 0; i < m; i++)
        if (asked.tension_min[i] < asked.tension_max[i]) cables[count++] = i;
    if (count - r < n) return LACKS_RANK;
    if (r == TWO && n > 3 && count == m && asked.mode != PAYLOAD) {
        if (value_of_two(asked, space)) return REGULAR;
        for (int64_t j = 0; j < n; j++) space.best[j] = NOT_A_NUMBER;
        return LACKS_RANK;
    }
    return value_of_facets(asked, space, cables, count, r) ? REGULAR : LACKS_RANK;
}

}  // namespace cdpr::CDPR_TARGET
