// Frame in which a platform is integrated, as in cdpr.mechanics.body_frame. SPDX-License-Identifier: Apache-2.0
//
// For a free platform it lies at the centre of mass along the principal axes; for a guided one at its origin along its
// own axes. Attitudes between the stages of a step are not exactly of unit length, so another frame would give other
// numbers, by the order of the scheme.
#include <math.h>
#include <string.h>
#include <cdpr/rotation.hpp>

#include "model.h"

namespace fmu {

using Vector = cdpr::Vector<double>;
using cdpr::cross;
using cdpr::dot;
using cdpr::vector;

static const double DIAGONAL = 1e-14;          // share of the trace below which an off-diagonal entry is round-off
static const double DEFINITE = 1e-12;          // lower limit of each principal moment, as a share of the trace
static const Vector SIDE = {1.0, 0.59, 0.37};  // direction of principal axes, which determines their signs
static const double IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

// One rotation of Jacobi's method: eliminate A[i][j], A symmetric, and rotate the columns of the axes.
static void annihilate(double A[3][3], double axes[3][3], int i, int j) {
    if (A[i][j] == 0.0) return;
    const double theta = (A[j][j] - A[i][i]) / (2.0 * A[i][j]);
    const double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
    const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int k = 0; k < 3; k++) {
        const double a = A[k][i], b = A[k][j], u = axes[k][i], v = axes[k][j];
        A[k][i] = c * a - s * b, A[k][j] = s * a + c * b;
        axes[k][i] = c * u - s * v, axes[k][j] = s * u + c * v;
    }
    for (int k = 0; k < 3; k++) {
        const double a = A[i][k], b = A[j][k];
        A[i][k] = c * a - s * b, A[j][k] = s * a + c * b;
    }
    A[i][j] = A[j][i] = 0.0;
}

static void exchange(double moments[3], double axes[3][3], int i, int j) {
    if (moments[i] <= moments[j]) return;
    const double moment = moments[i];
    moments[i] = moments[j], moments[j] = moment;
    for (int k = 0; k < 3; k++) {
        const double entry = axes[k][i];
        axes[k][i] = axes[k][j], axes[k][j] = entry;
    }
}

// Principal moments in ascending order and axes, the columns of a rotation; a diagonal tensor is unchanged.
static void principal_axes(const double* inertia, double moments[3], double axes[3][3]) {
    double A[3][3];
    memcpy(A, inertia, sizeof A);
    memcpy(axes, IDENTITY, sizeof IDENTITY);
    const double largest = fmax(fabs(A[0][1]), fmax(fabs(A[0][2]), fabs(A[1][2])));
    const bool diagonal = largest <= DIAGONAL * (A[0][0] + A[1][1] + A[2][2]);
    for (int sweep = 0; sweep < 12 && !diagonal; sweep++) {  // converges quadratically: 5 are enough
        annihilate(A, axes, 0, 1);
        annihilate(A, axes, 0, 2);
        annihilate(A, axes, 1, 2);
    }
    for (int i = 0; i < 3; i++) moments[i] = A[i][i];
    if (diagonal) return;
    exchange(moments, axes, 0, 1);
    exchange(moments, axes, 1, 2);
    exchange(moments, axes, 0, 1);
    Vector axis[3];
    for (int i = 0; i < 3; i++) {
        axis[i] = {axes[0][i], axes[1][i], axes[2][i]};
        if (dot(SIDE, axis[i]) < 0.0) axis[i] = -1.0 * axis[i];
    }
    if (dot(axis[0], cross(axis[1], axis[2])) < 0.0) axis[0] = -1.0 * axis[0];
    for (int i = 0; i < 3; i++) axes[0][i] = axis[i].x, axes[1][i] = axis[i].y, axes[2][i] = axis[i].z;
}

// Write the unit quaternion with w >= 0 of a rotation (Shepperd's method).
static void write_attitude(double R[3][3], double* q) {
    const double trace = R[0][0] + R[1][1] + R[2][2];
    double largest = trace;
    int k = 0;
    for (int i = 0; i < 3; i++)
        if (R[i][i] > largest) largest = R[i][i], k = i + 1;
    q[k] = 0.5 * sqrt(1.0 + 2.0 * largest - trace);
    const double f = 0.25 / q[k];
    if (k == 0) {
        q[1] = f * (R[2][1] - R[1][2]), q[2] = f * (R[0][2] - R[2][0]), q[3] = f * (R[1][0] - R[0][1]);
    } else {
        const int i = k - 1, j = k % 3, l = (k + 1) % 3;
        q[0] = f * (R[l][j] - R[j][l]), q[1 + j] = f * (R[j][i] + R[i][j]), q[1 + l] = f * (R[l][i] + R[i][l]);
    }
    const double sign = q[0] < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 4; i++) q[i] = sign * q[i];
}

// Write mass times centre, inertia about the origin (Steiner) and its inverse, as cdpr.mechanics.spherical does.
static void write_ball(double mass, const double* J, const double* c, double* packed) {
    const double x = c[0], y = c[1], z = c[2];
    const double Jxx = J[0] + mass * (y * y + z * z), Jyy = J[4] + mass * (x * x + z * z);
    const double Jzz = J[8] + mass * (x * x + y * y), Jxy = J[1] - mass * (x * y);
    const double Jxz = J[2] - mass * (x * z), Jyz = J[5] - mass * (y * z);
    const double xx = Jyy * Jzz - Jyz * Jyz, xy = Jxz * Jyz - Jxy * Jzz, xz = Jxy * Jyz - Jxz * Jyy;
    const double yy = Jxx * Jzz - Jxz * Jxz, yz = Jxy * Jxz - Jxx * Jyz, zz = Jxx * Jyy - Jxy * Jxy;
    const double det = Jxx * xx + Jxy * xy + Jxz * xz;
    const double own[21] = {mass * x, mass * y, mass * z, Jxx,      Jxy,      Jxz,      Jxy,
                            Jyy,      Jyz,      Jxz,      Jyz,      Jzz,      xx / det, xy / det,
                            xz / det, xy / det, yy / det, yz / det, xz / det, yz / det, zz / det};
    memcpy(packed, own, sizeof own);
}

static void write_lines(const Model& model, const double* turned, Vector from) {
    for (size_t i = 0; i < model.cables; i++) {
        double* row = model.platform.lines + i * model.width;
        memcpy(row, model.lines + i * model.width, model.width * sizeof *row);
        store(cdpr::product(turned, vector(row + 3) - from), row + 3);
    }
}

bool build_body(Model& model) {
    const Platform& platform = model.platform;
    double own[13];
    own[0] = *model.field[MASS];
    memcpy(own + 1, model.field[CENTER_OF_MASS], 3 * sizeof *own);
    memcpy(own + 4, model.field[INERTIA], 9 * sizeof *own);
    add_loads(model, own, false, platform.total);
    const double *J = platform.total + 4, *center = platform.total + 1, mass = platform.total[0];
    const bool guided = model.guided();
    double moments[3], axes[3][3];
    principal_axes(J, moments, axes);
    const double least = DEFINITE * (J[0] + J[4] + J[8]);
    if (fabs(J[1] - J[3]) + fabs(J[2] - J[6]) + fabs(J[5] - J[7]) > least) return false;
    if (!(moments[0] > least && moments[1] > least && moments[2] > least)) return false;
    if (guided) memcpy(axes, IDENTITY, sizeof IDENTITY);
    const double turned[9] = {axes[0][0], axes[1][0], axes[2][0], axes[0][1], axes[1][1],
                              axes[2][1], axes[0][2], axes[1][2], axes[2][2]};
    const double diagonal[9] = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
    const Vector zero = {0.0, 0.0, 0.0}, from = guided ? zero : vector(center);
    platform.moments[0] = platform.inertial[0] = mass;
    memcpy(platform.moments + 1, moments, sizeof moments);
    store(guided ? vector(center) : zero, platform.inertial + 1);
    memcpy(platform.inertial + 4, guided ? J : diagonal, 9 * sizeof *J);
    write_ball(mass, J, center, platform.packed);
    store(cdpr::product(turned, from), platform.offset);
    write_attitude(axes, platform.offset + 3);
    write_lines(model, turned, from);
    for (int i = 0; i < 6; i++) platform.free[i] = guided ? model.field[GUIDE][i] : 1.0;
    return true;
}

size_t impossible_load(const Model& model, size_t count) {
    size_t k = 0;
    for (; k < count; k++) {
        const double* J = model.field[LOAD_INERTIA] + 9 * k;
        double moments[3], axes[3][3];
        principal_axes(J, moments, axes);
        const double least = DEFINITE * fabs(J[0] + J[4] + J[8]);
        const double skew = fabs(J[1] - J[3]) + fabs(J[2] - J[6]) + fabs(J[5] - J[7]);
        if (!(model.field[LOAD_MASS][k] >= 0.0) || !(skew <= least)) break;
        if (!(moments[0] >= -least && moments[1] >= -least && moments[2] >= -least)) break;
    }
    return k;
}

static bool is_output(const Model& model, const Link& link) {
    return model.variable[model.owner[link.from]].role == OUTPUT;
}

void read_arrays(Model& model) {
    for (size_t k = 0; k < model.links; k++) {
        const Link& link = model.link[k];
        const double* from = model.array[link.array].data + link.to;
        if (is_output(model, link)) memcpy(model.number + link.from, from, link.size * sizeof *from);
    }
}

void fill_arrays(Model& model) {
    for (size_t k = 0; k < model.links; k++) {
        const Link& link = model.link[k];
        if (is_output(model, link)) continue;
        const double *from = model.number + link.from, factor = link.per_step ? *model.field[CONTROL_STEP] : 1.0;
        double* to = model.array[link.array].data + link.to;
        for (size_t i = 0; i < link.size; i++) to[i] = from[i] * factor;
    }
}

}  // namespace fmu
