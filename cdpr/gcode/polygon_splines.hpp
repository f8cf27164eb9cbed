// Smooth curves along polygons: see cdpr.gcode.polygon_splines. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/gcode/spline_fit.hpp>

namespace cdpr::CDPR_TARGET {

// Polynomials of splines along polygons, whose vertices are consecutive in the arrays.
struct PolygonSplines {
    const double* points;     // (m, 3), m, vertices of all
    const double* turn;       // (m), change of direction, as the norm of the difference of unit vectors
    const double* tolerance;  // (m), m, of the chord after each
    const double* missing;    // (m), m, largest distance of the curve from each vertex
    const int64_t* parted;    // (m), whether a piece has to end there
    const int64_t* runs;      // (r + 1), first vertex of each polygon, and m
    double* way;              // (m), m, length of the chord before each; replaced by the polygon's length up to there
    double* wanted;           // (m), m, desired size of each corner for the speed; 0 at ends; changed
    double* allowed;          // (m), m, largest size of each corner; changed
    double* pieces;    // (7 m, 16): begin and end, m; position, first and second derivative there; second derivative
                       // at the end; nearest chord within its polygon; length of its span, m
    int64_t* rows;     // (r + 1), first piece of each polygon, and their number; some may have none
    double* factor;    // (m), work space
    double* knots;     // (6 longest), work space
    double* controls;  // (6 longest + 3, 7), work space
    int64_t m;
    int64_t r;
    int64_t longest;  // most vertices of a polygon
    static constexpr char fields[] =
        "points(m, 3), turn(m), tolerance(m), missing(m), parted(m), runs(r + 1), both way(m), both wanted(m), "
        "both allowed(m), pieces(7*m, 16), rows(r + 1), work factor(m), work knots(6*longest), "
        "work controls(6*longest + 3, 7), m, r, longest";
};

constexpr int SPLINE_PIECE = 16;

// Write the part of a span from x to y, which begins at a position of the polygon.
inline void write_piece(const Span& span, double place, double begin, double end, int64_t chord, double* piece) {
    const double x = begin - place, y = end - place;
    piece[0] = begin;
    piece[1] = end;
    for (int axis = 0; axis < 3; axis++) {
        const double* c = span.c[axis];
        const double third = (c[3] - c[2]) / span.length;
        piece[2 + axis] = c[0] + x * (c[1] + x * (0.5 * c[2] + x * third / 6.0));
        piece[5 + axis] = c[1] + x * (c[2] + 0.5 * x * third);
        piece[8 + axis] = c[2] + x * third;
        piece[11 + axis] = c[2] + y * third;
    }
    piece[14] = double(chord);
    piece[15] = span.length;
}

// Write the pieces of a spline, span by span, split at required ends; return their number.
inline int64_t write_pieces(const Polyline& polygon, const int64_t* parted, const Knots& knots, ControlPoints controls,
                            double* pieces) {
    const double* way = polygon.way;
    int64_t count = 0, k = 0;
    for (int64_t j = 0; j < knots.spans; j++) {
        const Span span = span_at(knots, controls, j);
        double begin = knots.places[j];
        while (begin < knots.places[j + 1]) {
            double end = knots.places[j + 1];
            while (k < polygon.last && (way[k] <= begin || !parted[k]) && way[k] < end) k++;
            if (begin < way[k] && way[k] < end && parted[k]) end = way[k];
            write_piece(span, knots.places[j], begin, end, k - 1, pieces + SPLINE_PIECE * count++);
            begin = end;
        }
    }
    return count;
}

inline int polygon_splines(PolygonSplines& all) {
    int64_t row = 0;
    for (int64_t i = 0; i < all.r; i++) {
        all.rows[i] = row;
        const int64_t first = all.runs[i], last = all.runs[i + 1] - 1 - first;
        double* way = all.way + first;
        way[0] = 0.0;
        for (int64_t k = 1; k <= last; k++) way[k] += way[k - 1];
        widen(way, all.wanted + first, last);
        const Polyline polygon = {all.points + 3 * first, way, last};
        const SplineCorners corners = {all.turn + first,    all.wanted + first,  all.tolerance + first,
                                       all.missing + first, all.allowed + first, all.factor + first};
        const ControlPoints controls = {all.controls};
        const Knots knots = fit(polygon, corners, all.knots, controls);
        row += write_pieces(polygon, all.parted + first, knots, controls, all.pieces + SPLINE_PIECE * row);
    }
    all.rows[all.r] = row;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
