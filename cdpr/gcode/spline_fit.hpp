// Spline within the tolerance of a polygon. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/gcode/spline_curve.hpp>

namespace cdpr::CDPR_TARGET {

// Points of each span at which its distance from the polygon is computed; between two it exceeds that of both ends by
// at most an eighth of the second derivative times their squared distance.
constexpr int CHECKED_PLACES = 8;

// Sizes shrink by one of these factors if the curve misses its polygon by more than FAR_OFF tolerances, or less.
constexpr double FAR_OFF = 4.0, SHRINK_MUCH = 0.5, SHRINK_LITTLE = 0.9;
constexpr int FIT_ROUNDS = 60;  // rounds; then each vertex is rounded alone, within halves of its chords

constexpr double WIDE_TURN = 0.2;  // rad, largest rotation of a span wider than chords: beyond, bounds are looser

// A single corner of size h, rounded from h before it to h behind, is missed by h / CORNER_MISSES times its change of
// direction; MISSES of cdpr.gcode.rounding_gain.
constexpr double CORNER_MISSES = 6.0;

constexpr double ALONE_SIZE =
    0.8;  // of the size of a single corner at its tolerance, so that merged knots keep it, too

// Data of a polygon's vertices.
struct SplineCorners {
    const double* turn;       // change of direction, as the norm of the difference of unit vectors
    const double* wanted;     // m, desired size for the speed
    const double* tolerance;  // m, of the chord after each
    const double* missing;    // m, largest distance of the curve from each
    double* size;             // m
    double* factor;           // factors for the sizes
};

// Return the largest distance of a span from its polygon, in tolerances, including points in between; k, the chord at
// the span's start, becomes the chord at its end.
inline double worst_miss(const Polyline& polygon, const double* tolerance, const Span& span, double begin, double bend,
                         int64_t& k) {
    const double part = span.length / CHECKED_PLACES;
    const double between = bend * (part * part) / 8.0;
    double worst = 0.0;
    for (int place = 0; place <= CHECKED_PLACES; place++) {
        const double x = span.length * place / CHECKED_PLACES;
        while (k < polygon.last - 1 && polygon.way[k + 1] < begin + x) {
            k++;
            const double away = span.missed(polygon.way[k] - begin, polygon, k, 0.0);
            worst = larger(worst, (away + between) / smaller(tolerance[k - 1], tolerance[k]));
        }
        const double share = (begin + x - polygon.way[k]) / polygon.chord(k);
        worst = larger(worst, (span.missed(x, polygon, k, share) + between) / tolerance[k]);
    }
    return worst;
}

// Shrink the sizes of the nearest vertices that influence span j; chord k is near it.
inline void shrink(const Polyline& polygon, const Knots& knots, double* factor, int64_t j, int64_t k, double by) {
    const double* way = polygon.way;
    int64_t low = k, high = k, reach = 1;
    for (; reach < 3; reach++) {
        low = high = k;
        while (low > 0 && way[low] >= knots(j - reach)) low--;
        while (high < polygon.last && way[high] <= knots(j + 1 + reach)) high++;
        if (high - low > 1) break;
    }
    const double begin = knots(j - reach), end = knots(j + 1 + reach);
    for (int64_t other = low; other <= high; other++)
        if (begin <= way[other] && way[other] <= end) factor[other] = smaller(factor[other], by);
}

// Return whether the curve keeps the tolerance of each chord, in spans that are not too wide; else write the factors.
inline bool keeps_tolerance(const Polyline& polygon, const SplineCorners& corners, const Knots& knots,
                            ControlPoints controls) {
    for (int64_t k = 0; k <= polygon.last; k++) corners.factor[k] = 1.0;
    bool kept = true;
    int64_t k = 0;
    for (int64_t j = 0; j < knots.spans; j++) {
        const int64_t before = k;
        const Span span = span_at(knots, controls, j);
        const double bend = span.bend(), turn = bend * span.length;
        double worst = worst_miss(polygon, corners.tolerance, span, knots.places[j], bend, k);
        if (k > before + 1 && turn > WIDE_TURN && controls.moved(j + 1) && controls.moved(j + 2))
            worst = larger(worst, turn / WIDE_TURN);
        if (worst <= 1.0) continue;
        kept = false;
        shrink(polygon, knots, corners.factor, j, k, worst > FAR_OFF ? SHRINK_MUCH : SHRINK_LITTLE);
    }
    return kept;
}

// Reduce sizes so that each corner is rounded within halves of its chords.
inline void separate(const Polyline& polygon, const SplineCorners& corners) {
    for (int64_t k = 1; k < polygon.last; k++) {
        const double chord = smaller(polygon.chord(k - 1), polygon.chord(k));
        const double alone = ALONE_SIZE * CORNER_MISSES * corners.missing[k] / larger(corners.turn[k], 1e-300);
        corners.size[k] = smaller(smaller(corners.size[k], 0.5 * chord), alone);
    }
}

// Find knots and control points; return the number of spans: none if chords are so short that corners cannot be rounded
// separately.
inline Knots fit(const Polyline& polygon, const SplineCorners& corners, double* places, ControlPoints controls) {
    const double whole = polygon.way[polygon.last] - polygon.way[0];
    double* size = corners.size;
    for (int64_t k = 0; k <= polygon.last; k++) size[k] = smaller(smaller(size[k], corners.wanted[k]), whole);
    for (int round = 0; round <= FIT_ROUNDS; round++) {
        if (round == FIT_ROUNDS) separate(polygon, corners);
        grade(polygon.way, size, polygon.last);
        const Knots knots = place_knots(polygon.way, size, polygon.last, places);
        place_controls(polygon, knots, controls);
        if (keeps_tolerance(polygon, corners, knots, controls)) return knots;
        for (int64_t k = 0; k <= polygon.last; k++) size[k] *= corners.factor[k];
    }
    return {places, 0};
}

}  // namespace cdpr::CDPR_TARGET
