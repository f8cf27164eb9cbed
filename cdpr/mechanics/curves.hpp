// Axes of cables, straight or curved, and their distances. SPDX-License-Identifier: Apache-2.0
//
// A sagging cable is a plane, convex curve. A piece of it lies in the triangle of its chord and of its tangents at both
// ends, so the height of this triangle is an upper limit of the distance between piece and chord. A distance that
// changes by at most the displacement of a point is bounded by that of the chord and by these heights: `least_distance`
// bisects pieces that may be nearest, until their heights add up to less than CURVE_ERROR.
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/mechanics/geometry.hpp>
#include <cdpr/mechanics/segments.hpp>

namespace cdpr::CDPR_TARGET {

// Largest error of a distance of curves, m: far below the tolerance of any cable.
constexpr double CURVE_ERROR = 1e-6;

// Axis of a cable at a pose of the platform: a row of AXIS numbers.
constexpr int AXIS = 7 + BentCurve::NUMBERS;

struct CableAxis {
    Vector<double> exit, tip;  // m, world
    bool curved;
    BentCurve curve;

    inline explicit CableAxis(const double* row)
        : exit(vector(row)), tip(vector(row + 3)), curved(row[6] != 0.0), curve(row + 7) {}

    // Return the point at a share of the unstretched length from the platform, m, world.
    CDPR_INLINE Vector<double> point(double share) const {
        if (share <= 0.0) return tip;
        if (share >= 1.0) return exit;
        return curved ? tip + curve.point(share * curve.span) : tip + share * (exit - tip);
    }
    // Return a vector along the cable towards the exit.
    CDPR_INLINE Vector<double> along(double share) const {
        return curved ? curve.tension(share * curve.span) : exit - tip;
    }
};

// Write the axis of a cable with an unwound length, m: the chord if it does not bend or has no equilibrium.
inline void write_axis(const Line<double>& cable, ChainRow<double> chain, Vector<double> gravity, double unwound,
                       double* row) {
    const ExitResult<double> exit = cable.lead();
    store(exit.point, row), store(cable.tip, row + 3);
    row[6] = 0.0;
    for (int j = 7; j < AXIS; j++) row[j] = 0.0;
    if (!bends(chain.span_kind())) return;
    const BentCurve curve = bent_curve(chain.span_kind(), cable.span(exit, chain.span(), gravity), unwound);
    if (!curve.sags() || !(absolute(curve.miss.x) + absolute(curve.miss.y) + absolute(curve.miss.z) < INFINITE)) return;
    row[6] = 1.0;
    curve.write(row + 7);
}

// Piece of an axis between two shares of its length, and the largest distance between it and its chord, m.
struct AxisPiece {
    double from, to;
    Vector<double> start, end;
    double height;
};

inline double height_of(const CableAxis& axis, const AxisPiece& piece) {
    if (!axis.curved) return 0.0;
    const Vector<double> chord = piece.end - piece.start, a = axis.along(piece.from), b = axis.along(piece.to);
    const double most = larger(length(a), length(b)), L = (piece.to - piece.from) * axis.curve.span;
    const double half = 0.5 * L * (1.0 + axis.curve.stretch * most), u = dot(a, chord), v = dot(b, chord);
    if (!(u > 0.0 && v > 0.0)) return half;  // no point is farther from both ends
    const double first = length(cross(a, chord)) / u, last = length(cross(b, chord)) / v, both = first + last;
    return both > 0.0 ? smaller(half, length(chord) * first * last / both) : 0.0;
}

inline AxisPiece piece_of(const CableAxis& axis, double from, double to, Vector<double> start, Vector<double> end) {
    AxisPiece piece = {from, to, start, end, 0.0};
    piece.height = height_of(axis, piece);
    return piece;
}

// Return the smallest distance of two axes if it is below `limit`, else `limit`. `distance` returns that of two pieces'
// chords; it changes by no more than the displacement of a point.
template <class Distance>
inline double least_distance(const CableAxis& first, const CableAxis& second, double limit, Distance distance) {
    struct Pair {
        AxisPiece one, other;
        double found;
    };
    constexpr int MOST = 160;  // pairs that wait: one per bisection, of either piece
    Pair waiting[MOST];
    const auto whole = [](const CableAxis& axis) { return piece_of(axis, 0.0, 1.0, axis.tip, axis.exit); };
    waiting[0] = {whole(first), whole(second), 0.0};
    waiting[0].found = distance(waiting[0].one, waiting[0].other);
    double best = limit;
    for (int count = 1; count > 0;) {
        const Pair now = waiting[--count];
        const double loose = now.one.height + now.other.height;
        if (!(now.found - loose < best)) continue;
        if (loose <= CURVE_ERROR || count + 2 > MOST) {
            best = smaller(best, now.found);
            continue;
        }
        best = smaller(best, now.found + loose);
        const bool split_one = now.one.height >= now.other.height;
        const CableAxis& axis = split_one ? first : second;
        const AxisPiece& whole_piece = split_one ? now.one : now.other;
        const double middle = 0.5 * (whole_piece.from + whole_piece.to);
        const Vector<double> at = axis.point(middle);
        Pair halves[2] = {now, now};
        (split_one ? halves[0].one : halves[0].other) = piece_of(axis, whole_piece.from, middle, whole_piece.start, at);
        (split_one ? halves[1].one : halves[1].other) = piece_of(axis, middle, whole_piece.to, at, whole_piece.end);
        for (Pair& half : halves) half.found = distance(half.one, half.other);
        const bool near = halves[0].found <= halves[1].found;  // the nearer one next
        waiting[count++] = near ? halves[1] : halves[0];
        waiting[count++] = near ? halves[0] : halves[1];
    }
    return best;
}

// Return the smallest distance of an axis from something fixed if it is below `limit`, else `limit`; `distance` returns
// that of a piece's chord.
template <class Distance> inline double least_distance(const CableAxis& axis, double limit, Distance distance) {
    CableAxis fixed = axis;
    fixed.curved = false;
    return least_distance(axis, fixed, limit,
                          [&](const AxisPiece& piece, const AxisPiece&) { return distance(piece.end, piece.start); });
}

// Axes of cables at poses, for drawings.
struct CableCurves {
    const double* lines;    // (m, w), as in Geometry
    const double* chains;   // (m, 33), as in ChainRow
    const double* gravity;  // (3), m/s^2, world
    const double* poses;    // (k, 7): position, m, and quaternion
    const double* unwound;  // (k, m), m
    double* points;         // (k, m, n, 3), m, world, from the exit to the platform, at equal unstretched lengths
    double* axis;           // (20), work space
    int64_t k;
    int64_t m;
    int64_t w;
    int64_t n;
    static constexpr char fields[] =
        "lines(m, w >= 6), chains(m, 33), gravity(3), poses(k, 7), unwound(k, m), points(k, m, n >= 2, 3), work "
        "axis(20), k, m, w, n";
};

inline int cable_curves(CableCurves& asked) {
    static_assert(AXIS == 20);
    if (!has_anchors<double>(asked.w)) return BAD_INPUT;
    for (int64_t k = 0; k < asked.k; k++) {
        const double* pose = asked.poses + 7 * k;
        for (int64_t i = 0; i < asked.m; i++) {
            const Line<double> cable = line(asked.lines, asked.w, i, vector(pose), quaternion(pose + 3));
            const double unwound = asked.unwound[k * asked.m + i];
            write_axis(cable, chain_row(asked.chains, i), vector(asked.gravity), unwound, asked.axis);
            const CableAxis axis(asked.axis);
            double* points = asked.points + 3 * asked.n * (k * asked.m + i);
            for (int64_t j = 0; j < asked.n; j++)
                store(axis.point(double(asked.n - 1 - j) / double(asked.n - 1)), points + 3 * j);
        }
    }
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
