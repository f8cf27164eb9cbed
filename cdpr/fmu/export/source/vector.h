/* Vectors and quaternions (w, x, y, z), operation by operation those of cdpr/model/kernels.py.
   SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_VECTOR_H
#define CDPR_VECTOR_H

typedef struct {
    double x, y, z;
} Vector;

typedef struct {
    double w, x, y, z;
} Quaternion;

static inline Vector vector(const double *a) { return (Vector){a[0], a[1], a[2]}; }
static inline Quaternion quaternion(const double *a) { return (Quaternion){a[0], a[1], a[2], a[3]}; }
static inline void store(Vector v, double *a) { a[0] = v.x, a[1] = v.y, a[2] = v.z; }
static inline void store_quaternion(Quaternion q, double *a) { a[0] = q.w, a[1] = q.x, a[2] = q.y, a[3] = q.z; }
static inline Vector add(Vector a, Vector b) { return (Vector){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline Vector subtract(Vector a, Vector b) { return (Vector){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline Vector scale(double s, Vector v) { return (Vector){s * v.x, s * v.y, s * v.z}; }
static inline Vector divide(Vector v, double s) { return (Vector){v.x / s, v.y / s, v.z / s}; }
static inline Vector along(Vector a, Vector b) { return (Vector){a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline Vector cross(Vector a, Vector b) {
    return (Vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline Quaternion conjugate(Quaternion q) { return (Quaternion){q.w, -q.x, -q.y, -q.z}; }

static inline Quaternion multiply(Quaternion a, Quaternion b) {
    return (Quaternion){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                        a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}

/* R(q) v */
static inline Vector rotate(Quaternion q, Vector v) {
    const Vector axis = {q.x, q.y, q.z};
    const Vector t = scale(2.0, cross(axis, v));
    return add(add(v, scale(q.w, t)), cross(axis, t));
}

/* A v, A being 3 x 3, row by row. */
static inline Vector product(const double *A, Vector v) {
    return (Vector){A[0] * v.x + A[1] * v.y + A[2] * v.z, A[3] * v.x + A[4] * v.y + A[5] * v.z,
                    A[6] * v.x + A[7] * v.y + A[8] * v.z};
}

/* R(q) A R(q)^T v */
static inline Vector turned_product(const double *A, Quaternion q, Vector v) {
    return rotate(q, product(A, rotate(conjugate(q), v)));
}

/* Slope of an attitude that turns at w: half the quaternion (0, w) times q. */
static inline Quaternion spin(Vector w, Quaternion q) {
    return (Quaternion){-0.5 * (w.x * q.x + w.y * q.y + w.z * q.z), 0.5 * (w.x * q.w + w.y * q.z - w.z * q.y),
                        0.5 * (w.y * q.w + w.z * q.x - w.x * q.z), 0.5 * (w.z * q.w + w.x * q.y - w.y * q.x)};
}

#endif
