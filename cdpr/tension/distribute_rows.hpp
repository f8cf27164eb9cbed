// Distribution of many wrenches at many poses, one by one or eight side by side. SPDX-License-Identifier: Apache-2.0
//
// Each row is independent: pose, wrench matrix, wrench, solver, checks of its answer and, if they fail, the tensions
// with the nearest wrench.
#pragma once

#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/inverse_dynamics.hpp>
#include <cdpr/tension/checks.hpp>
#include <cdpr/tension/policy.hpp>
#include <cdpr/tension/select_rows.hpp>

namespace cdpr::CDPR_TARGET {

// Rows, which are doubles, and the problem of the present one, or of eight.
template <class T> struct Rows {
    const T* lines;          // (m, w), geometry.hpp
    const int64_t* freedom;  // (n), balanced rows of a wrench
    const T* inertial;       // (13), inverse_dynamics.hpp
    const T* gravity;        // (3), m/s^2, world
    const T* weights;        // (n), 1 for forces, 1 / characteristic length, 1/m, for moments
    const double* limits;    // (given_limits, 2, m), N: of each row, or of all
    const double* poses;     // (count, 7): position, m, and quaternion of any length
    const double* wrenches;  // (given_wrenches, 6), N and N m: of each row; without any, static equilibrium
    double* tensions;        // (count, m), N; NaN for bad input
    double* reports;         // (count, 4), as in Acceptance
    int64_t* done;           // (count): finished rows, which are skipped
    T* matrix;               // (n, m), the problem bound to the solver, and so on
    T* wrench;               // (n), N and N m
    T* bounds;               // (2, m), N
    T* answer;               // (m), N
    T* state;                // (13), work space, and so on
    T* full_matrix;          // (6, m)
    T* full_wrench;          // (6)
    T* geometry;             // (2, m)
    int64_t solver;          // address of the solver's operation
    int64_t solver_place;    // address of its struct
    int64_t n;
    int64_t m;
    int64_t w;
    int64_t count;
    int64_t given_limits;
    int64_t given_wrenches;
    static constexpr char fields[] =
        "lines(m, w >= 6), freedom(n), inertial(13), gravity(3), weights(n), limits(given_limits >= 1, 2, m), "
        "poses(count, 7), wrenches(given_wrenches, 6), both tensions(count, m), both reports(count, 4), "
        "both done(count), matrix(n, m), wrench(n), bounds(2, m), answer(m), work state(13), work full_matrix(6, m), "
        "work full_wrench(6), work geometry(2, m), solver, solver_place, n, m, w, count, given_limits, given_wrenches";

    CDPR_INLINE bool well_formed() const {
        return (given_limits == 1 || given_limits == count) && (given_wrenches == 0 || given_wrenches == count);
    }
    CDPR_INLINE const double* limits_of(int64_t row) const { return limits + (given_limits > 1 ? row : 0) * 2 * m; }
    CDPR_INLINE int solve() const {
        return reinterpret_cast<cdpr_operation>(solver)(reinterpret_cast<void*>(solver_place), 0.0);
    }
};

CDPR_INLINE void set(double* place, int, double number) { *place = number; }

// Write pose, wrench and limits of a row.
template <class T> inline void load(const Rows<T>& p, int64_t row, int lane) {
    for (int i = 0; i < 7; i++) set(p.state + i, lane, p.poses[7 * row + i]);
    if (p.given_wrenches > 0)
        for (int i = 0; i < 6; i++) set(p.full_wrench + i, lane, p.wrenches[6 * row + i]);
    const double* limits = p.limits_of(row);
    for (int64_t i = 0; i < 2 * p.m; i++) set(p.bounds + i, lane, limits[i]);
}

// Write the problem at the pose, with the normalised quaternion. Return whether the limits are valid.
template <class T> inline Truth<T> pose_problem(const Rows<T>& p) {
    const Quaternion<T> q = quaternion(p.state + 3);
    const T length = square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    for (int i = 3; i < 7; i++) p.state[i] = p.state[i] / length;
    for (int i = 7; i < 13; i++) p.state[i] = 0.0;
    Geometry<T> cables = {p.lines, p.state, p.full_matrix, p.geometry, p.geometry + p.m, p.m, p.w};
    geometry(cables);
    if (p.given_wrenches == 0) {
        const Vector<T> still = {0.0, 0.0, 0.0};
        store(inverse_dynamics<T>({p.inertial}, vector(p.gravity), quaternion(p.state + 3), still, still, still),
              p.full_wrench);
    }
    Selection<T> chosen = {p.freedom, p.full_matrix, p.full_wrench, p.matrix, p.wrench, p.n, p.m};
    select_rows(chosen);
    Truth<T> ordered = true;
    for (int64_t i = 0; i < p.m; i++) {
        p.answer[i] = NOT_A_NUMBER;
        ordered = ordered & (p.bounds[i] <= p.bounds[p.m + i]);
    }
    return ordered;
}

struct DistributedRows {
    Rows<double> all;
    double* steps;  // (1), work space
    BoxLeastSquaresSpace space;
    int64_t action;  // an Action: for an answer that fails the checks
    static constexpr auto fields =
        extended(Rows<double>::fields, "work steps(1), ", BoxLeastSquaresSpace::fields, ", action");

    CDPR_INLINE Fallback fallback(int64_t* known, double* tension, double* report, bool answered) const {
        return {all.matrix,
                all.wrench,
                all.weights,
                all.bounds,
                known,
                all.answer,
                tension,
                report,
                steps,
                space,
                answered ? action : int64_t(NEAREST),
                answered,
                all.n,
                all.m};
    }
};

// Distribute a row.
inline void distribute_row(const DistributedRows& p, int64_t row) {
    const Rows<double>& all = p.all;
    double *tension = all.tensions + row * all.m, *report = all.reports + 4 * row;
    load(all, row, 0);
    const bool ordered = pose_problem(all);
    int status = ordered ? all.solve() : int(BAD_INPUT);
    const bool answered = status == OK;
    if (answered) {
        Acceptance<double> problem = {all.matrix, all.wrench, all.weights, all.bounds, all.answer,
                                      tension,    report,     all.n,       all.m};
        status = accept(problem);
        if (status == OK) return;
    }
    int64_t known[2];
    if (ordered && fall_back(p.fallback(known, tension, report, answered), double(status))) return;
    report[0] = BAD_INPUT;
    for (int i = 1; i < 4; i++) report[i] = NOT_A_NUMBER;
    for (int64_t i = 0; i < all.m; i++) tension[i] = NOT_A_NUMBER;
}

// Distribute all unfinished rows.
inline int distribute_rows(DistributedRows& p) {
    if (!p.all.well_formed()) return BAD_INPUT;
    for (int64_t row = 0; row < p.all.count; row++) {
        if (p.all.done[row]) continue;
        distribute_row(p, row);
        p.all.done[row] = 1;
    }
    return OK;
}

#ifdef CDPR_LANES
// Number of rows of eight below which an attempt costs more than it saves.
constexpr int WORTHWHILE = 4;

CDPR_INLINE void set(Lanes* place, int lane, double number) { place->set(lane, number); }

// Rows by an operation NAME_lanes.
struct RowsSideBySide {
    Rows<Lanes> all;
    Lanes* accepted;  // (m), work space, N
    Lanes* report;    // (4), work space
    static constexpr auto fields = extended(Rows<Lanes>::fields, "work accepted(m), work report(4)");
};

// Distribute eight rows from one on; return the number of those that passed the checks: these are finished.
inline int distribute_eight(const RowsSideBySide& p, int64_t first) {
    const Rows<Lanes>& all = p.all;
    for (int lane = 0; lane < WIDTH; lane++) load(all, first + lane, lane);
    const Mask ordered = pose_problem(all);
    int found = ~all.solve() & bits(ordered);
    if (found == 0) return 0;
    for (int64_t i = 0; i < all.m; i++) p.accepted[i] = 0.0;
    for (int i = 0; i < 4; i++) p.report[i] = 0.0;
    Acceptance<Lanes> problem = {all.matrix, all.wrench, all.weights, all.bounds, all.answer,
                                 p.accepted, p.report,   all.n,       all.m};
    found &= ~accept(problem);
    int count = 0;
    for (int lane = 0; lane < WIDTH; lane++) {
        if ((found >> lane & 1) == 0) continue;
        const int64_t row = first + lane;
        for (int64_t i = 0; i < all.m; i++) all.tensions[row * all.m + i] = p.accepted[i].get(lane);
        for (int i = 0; i < 4; i++) all.reports[4 * row + i] = p.report[i].get(lane);
        all.done[row] = 1;
        count++;
    }
    return count;
}

// Distribute rows, and mark the finished ones. After unsuccessful attempts, ever more rows are skipped before the next
// one.
inline int distribute_rows_side_by_side(RowsSideBySide& p) {
    if (!p.all.well_formed()) return BAD_INPUT;
    int64_t first = 0, pause = 1;
    while (first + WIDTH <= p.all.count) {
        if (distribute_eight(p, first) >= WORTHWHILE) {
            pause = 1;
            first += WIDTH;
        } else {
            first += WIDTH * (1 + pause);
            pause *= 2;
        }
    }
    return OK;
}
#endif

}  // namespace cdpr::CDPR_TARGET
