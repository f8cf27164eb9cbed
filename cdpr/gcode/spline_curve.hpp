// Cubic B-spline along a polygon, span by span. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/gcode/spline_knots.hpp>
#include <cdpr/vector.hpp>

namespace cdpr::CDPR_TARGET {

// Polygonal line with last + 1 vertices.
struct Polyline {
    const double* points;  // (last + 1, 3), m
    const double* way;     // (last + 1), m, its length up to each vertex
    int64_t last;

    CDPR_INLINE double chord(int64_t k) const { return way[k + 1] - way[k]; }
    CDPR_INLINE double at(int64_t k, int axis) const { return points[3 * k + axis]; }
    CDPR_INLINE double step(int64_t k, int axis) const { return points[3 * (k + 1) + axis] - points[3 * k + axis]; }
};

// Control points (spans + 3, 7): position, m; position along the polygon, m; point of the polygon there, m.
struct ControlPoints {
    static constexpr int NUMBERS = 7, PLACE = 3, POLYGON = 4;

    double* rows;

    CDPR_INLINE double* operator[](int64_t i) const { return rows + NUMBERS * i; }
    CDPR_INLINE double place(int64_t i) const { return rows[NUMBERS * i + PLACE]; }

    // Return whether a control point is off the polygon.
    CDPR_INLINE bool moved(int64_t i) const {
        const double* row = rows + NUMBERS * i;
        return row[0] != row[POLYGON] || row[1] != row[POLYGON + 1] || row[2] != row[POLYGON + 2];
    }

    // Return the second derivative, 1/m, of a parabola through the polygon at a control point and its two neighbours.
    CDPR_INLINE Vector<double> curvature(int64_t i) const {
        const double *here = (*this)[i] + POLYGON, *next = here + NUMBERS, *prior = here - NUMBERS;
        const double before = place(i) - place(i - 1), after = place(i + 1) - place(i);
        const Vector<double> point = vector(here);
        const Vector<double> turn = (vector(next) - point) / after - (point - vector(prior)) / before;
        return 2.0 / (before + after) * turn;
    }
};

// Write the control points at the means of three knots each.
inline void place_on_polygon(const Polyline& polygon, const Knots& knots, ControlPoints controls) {
    int64_t k = 0;
    for (int64_t i = 0; i < knots.spans + 3; i++) {
        double s = (knots(i - 2) + knots(i - 1) + knots(i)) / 3.0;
        if (i == 0) s = knots.places[0];
        if (i == knots.spans + 2) s = knots.end();
        while (k < polygon.last - 1 && polygon.way[k + 1] < s) k++;
        const double share = (s - polygon.way[k]) / polygon.chord(k);
        double* row = controls[i];
        row[ControlPoints::PLACE] = s;
        for (int axis = 0; axis < 3; axis++) {
            row[axis] = polygon.at(k, axis) + share * polygon.step(k, axis);
            row[ControlPoints::POLYGON + axis] = row[axis];
        }
    }
}

// Return the smallest curvature of the polygon, 1/m, at a control point and its neighbours; 0 if its direction changes
// there.
CDPR_INLINE double common_curvature(const ControlPoints& controls, int64_t i, int64_t last, Vector<double> curvature) {
    double least = length(curvature);
    const int64_t beside[] = {i > 1 ? i - 1 : 1, i < last ? i + 1 : last};
    for (const int64_t other : beside) {
        const Vector<double> c = controls.curvature(other);
        least = dot(curvature, c) > 0.0 ? smaller(least, length(c)) : 0.0;
    }
    return least;
}

// Write the control points. Points on the polygon would make arcs smaller, by a sixth of a span squared over the
// radius. If the polygon turns equally before and after them, they are moved outward, as for a parabola of the smallest
// of these curvatures.
inline void place_controls(const Polyline& polygon, const Knots& knots, ControlPoints controls) {
    place_on_polygon(polygon, knots, controls);
    const int64_t last = knots.spans + 1;
    for (int64_t i = 1; i <= last; i++) {
        const Vector<double> curvature = controls.curvature(i);
        const double least = common_curvature(controls, i, last, curvature);
        if (!(least > 0.0)) continue;
        const double before = knots(i - 2), middle = knots(i - 1), after = knots(i);
        const double first = middle - before, second = after - middle, both = after - before;
        const double spread = first * first + second * second + both * both;
        const double outward = least / length(curvature) * spread / 36.0;
        store(vector(controls[i]) - outward * curvature, controls[i]);
    }
}

// Span: for each coordinate its value, slope, and second derivative at both ends.
struct Span {
    double length;  // m
    double c[3][4];

    CDPR_INLINE double at(int axis, double x) const {
        const double* p = c[axis];
        return p[0] + x * (p[1] + x * (0.5 * p[2] + x * (p[3] - p[2]) / (6.0 * length)));
    }

    // Return the largest norm of the second derivative, 1/m: it is linear.
    CDPR_INLINE double bend() const {
        double found = 0.0;
        for (int end = 2; end < 4; end++)
            found = larger(found, square_root(c[0][end] * c[0][end] + c[1][end] * c[1][end] + c[2][end] * c[2][end]));
        return found;
    }

    // Return the distance, m, at x from the point of the polygon at a share of chord k.
    CDPR_INLINE double missed(double x, const Polyline& polygon, int64_t k, double share) const {
        double square = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            const double away = at(axis, x) - polygon.at(k, axis) - share * polygon.step(k, axis);
            square += away * away;
        }
        return square_root(square);
    }
};

// Return span j by de Boor's algorithm (de Boor 1978, chapter X).
inline Span span_at(const Knots& knots, ControlPoints controls, int64_t j) {
    const double here = knots.places[j], after = knots.places[j + 1];
    const double before2 = knots(j - 2), before = knots(j - 1), after2 = knots(j + 2);
    const double a0 = (here - before2) / (after - before2), a1 = (here - before) / (after2 - before);
    const double a2 = (here - before) / (after - before);
    const double h1 = controls.place(j + 1) - controls.place(j), h2 = controls.place(j + 2) - controls.place(j + 1);
    const double h3 = controls.place(j + 3) - controls.place(j + 2);
    Span span;
    span.length = after - here;
    for (int axis = 0; axis < 3; axis++) {
        const double p0 = controls[j][axis], p1 = controls[j + 1][axis];
        const double p2 = controls[j + 2][axis], p3 = controls[j + 3][axis];
        const double x0 = p0 + a0 * (p1 - p0), x1 = p1 + a1 * (p2 - p1);
        const double d1 = (p1 - p0) / h1, d2 = (p2 - p1) / h2, d3 = (p3 - p2) / h3;
        double* c = span.c[axis];
        c[0] = x0 + a2 * (x1 - x0);
        c[1] = d1 + a2 * (d2 - d1);
        c[2] = 2.0 * (d2 - d1) / (after - before);
        c[3] = 2.0 * (d3 - d2) / (after2 - here);
    }
    return span;
}

}  // namespace cdpr::CDPR_TARGET
