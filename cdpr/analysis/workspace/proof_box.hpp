// Enclosed wrench matrix of a box of positions; work space of the proofs. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/analysis/workspace/assess.hpp>
#include <cdpr/analysis/workspace/enclosure.hpp>

namespace cdpr::CDPR_TARGET {

// Work space for n directions and m cables.
struct BoxSpace {
    static constexpr char SIZE[] = "6*m*n + n*n + m*m + 11*m + 6*n + 31";

    double* columns;       // (m, n, 5), models of the columns of W
    double* parts;         // (6, 5), of one column
    double* Y;             // (m, n), approximation of W^+
    double* gram;          // (n, n)
    double* barrier;       // (m + 1, m + 1)
    double *t, *base;      // (m), N
    double* T;             // (m, 3), changes of t from the middle of the box to its sides
    double* G;             // (n, 3), of c likewise
    double *a, *b, *step;  // (m + n)
    double* need;          // (m)
};

inline BoxSpace box_space(double* memory, int64_t n, int64_t m) {
    Memory<double> space = {memory};
    BoxSpace found;
    found.columns = space.reserve(5 * m * n);
    found.parts = space.reserve(30);
    found.Y = space.reserve(m * n);
    found.gram = space.reserve(n * n);
    found.barrier = space.reserve((m + 1) * (m + 1));
    found.t = space.reserve(m);
    found.base = space.reserve(m);
    found.T = space.reserve(3 * m);
    found.G = space.reserve(3 * n);
    found.a = space.reserve(m + n);
    found.b = space.reserve(m + n);
    found.step = space.reserve(m + n);
    found.need = space.reserve(m);
    return found;
}

// Box about an evaluated pose.
struct Box {
    PoseQuestion<double> asked;
    PoseSpace<double> at_middle;
    BoxSpace space;
    const int64_t* free;  // cables with tensions that their limits do not determine
    int64_t* chosen;      // (m)
    int64_t count;        // of the free cables

    CDPR_INLINE int64_t n() const { return asked.n; }
    CDPR_INLINE int64_t m() const { return asked.m; }
    CDPR_INLINE const double* low() const { return asked.tension_min; }
    CDPR_INLINE const double* high() const { return asked.tension_max; }
    CDPR_INLINE Matrix<double> W() const { return {at_middle.matrix, asked.m}; }
    CDPR_INLINE Matrix<double> N() const { return {at_middle.basis, asked.m}; }
    CDPR_INLINE Matrix<double> L() const { return {space.gram, asked.n}; }
    CDPR_INLINE Matrix<double> Y() const { return {space.Y, asked.n}; }
    CDPR_INLINE Matrix<double> T() const { return {space.T, 3}; }
    CDPR_INLINE Matrix<double> G() const { return {space.G, 3}; }
    CDPR_INLINE double* entry(int64_t i, int64_t j) const { return space.columns + 5 * (i * asked.n + j); }
    CDPR_INLINE Model part(int64_t row) const { return model(space.parts + 5 * row); }

    inline bool enclose(const double* pose, const double* half, double error) const;
    inline void enclose_column(int64_t i, Vector<double> v, Vector<double> b, Vector<double> h, const Model& s,
                               double error) const;
};

// Write the models of column i: direction v / |v| and moment b x v / |v|, of which s is 1 / |v|.
inline void Box::enclose_column(int64_t i, Vector<double> v, Vector<double> b, Vector<double> h, const Model& s,
                                double error) const {
    const double lever[] = {b.x, b.y, b.z};
    store(Model{v.x, -h.x, 0.0, 0.0, error} * s, space.parts);
    store(Model{v.y, 0.0, -h.y, 0.0, error} * s, space.parts + 5);
    store(Model{v.z, 0.0, 0.0, -h.z, error} * s, space.parts + 10);
    for (int k = 0; k < 3; k++) {
        const int j = (k + 1) % 3, o = (k + 2) % 3;
        const Model first = Model{lever[j], 0.0, 0.0, 0.0, error} * part(o);
        store(first + Model{-lever[o], 0.0, 0.0, 0.0, error} * part(j), space.parts + 15 + 5 * k);
    }
    for (int64_t j = 0; j < n(); j++) store(asked.weights[j] * part(asked.rows[j]), entry(i, j));
}

// Write models of the columns of W; return whether the anchors of each cable are surely apart.
inline bool Box::enclose(const double* pose, const double* half, double error) const {
    const Vector<double> p = vector(pose), h = vector(half);
    const Quaternion<double> q = quaternion(pose + 3);
    for (int64_t i = 0; i < m(); i++) {
        const Line<double> cable = line(asked.lines, asked.w, i, p, q);
        const Vector<double> v = cable.chord(cable.anchor());
        const Model s = inverse_distance(v, h, error);
        if (!(s.r < INFINITE)) return false;
        enclose_column(i, v, cable.lever, h, s, error);
    }
    return true;
}

}  // namespace cdpr::CDPR_TARGET
