// Knots of a spline along a polygon, at distances of the sizes of its corners. SPDX-License-Identifier: Apache-2.0
//
// Vertices are 0 to `last`; way (last + 1) is the length of the polygon up to each, m; size (last + 1), m, is the
// distance from a vertex at which the spline begins to round it.
#pragma once

#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

// Knots on both sides of a vertex merge into one, or none, if vertices are nearer to each other than this share of its
// size.
constexpr double NEAR_SIZE = 0.5;

constexpr double KNOT_GAP =
    1e-6;  // m, between knots: at this distance, second derivatives are still precise to 1e-4 / m

// A vertex is a knot if its size is at most this multiple of its longer chord: with slightly fewer knots than vertices
// the curvature would oscillate.
constexpr double OWN_SIZE = 1.5;

constexpr double SIZE_SLOPE = 0.1;  // largest change of sizes along the polygon

// Positions on a polygon; those before the first and after the last one coincide.
struct Knots {
    double* places;
    int64_t spans;

    CDPR_INLINE double operator()(int64_t j) const { return places[j < 0 ? 0 : j > spans ? spans : j]; }
    CDPR_INLINE double end() const { return places[spans]; }
    CDPR_INLINE void add(double place) { places[++spans] = place; }
};

// Limit the difference of the vertices' sizes to a share of their distance: reduce the larger ones.
inline void grade(const double* way, double* size, int64_t last) {
    for (int64_t k = 1; k <= last; k++) size[k] = smaller(size[k], size[k - 1] + SIZE_SLOPE * (way[k] - way[k - 1]));
    for (int64_t k = last - 1; k >= 0; k--)
        size[k] = smaller(size[k], size[k + 1] + SIZE_SLOPE * (way[k + 1] - way[k]));
}

// Do the same by enlarging the smaller ones.
inline void widen(const double* way, double* size, int64_t last) {
    for (int64_t k = 1; k <= last; k++) size[k] = larger(size[k], size[k - 1] - SIZE_SLOPE * (way[k] - way[k - 1]));
    for (int64_t k = last - 1; k >= 0; k--) size[k] = larger(size[k], size[k + 1] - SIZE_SLOPE * (way[k + 1] - way[k]));
}

// Return the number of spans for a sum of chords in sizes: 1 to `most`.
CDPR_INLINE int64_t span_count(double total, int64_t most) {
    return int64_t(smaller(larger(1.0, total + 0.5), double(most)));
}

// Append a knot at `end`, and before it the number of knots that the sizes require, evenly in sizes. The search begins
// at vertex `first`.
inline void fill(const double* way, const double* size, int64_t first, int64_t last, Knots& knots, double end) {
    const double begin = knots.end();
    int64_t k = first;
    while (k < last - 1 && way[k + 1] <= begin) k++;
    double total = 0.0, place = begin;
    int64_t chord = k;
    for (; place < end; chord++) {
        const double next = smaller(way[chord + 1], end);
        total += 2.0 * (next - place) / (size[chord] + size[chord + 1]);
        place = next;
    }
    const int64_t count = span_count(total, 2 * (chord - k));  // sizes are wider than most chords
    double reached = 0.0;
    place = begin;
    for (int64_t i = 1; i < count; i++) {
        const double wanted = total * double(i) / double(count);
        double across = 0.0;
        for (;;) {
            across = 0.5 * (size[k] + size[k + 1]);
            const double left = (way[k + 1] - place) / across;
            if (reached + left >= wanted || k == last - 1) break;
            reached += left;
            place = way[++k];
        }
        knots.add(place + (wanted - reached) * across);
    }
    knots.add(end);
}

// State of the placement: knots since vertex `filled` may have been skipped, and are then added later.
struct KnotPlacement {
    const double* way;
    const double* size;
    int64_t last;
    Knots knots;
    int64_t filled;
    bool skipped;

    inline void place(int64_t k);

    // Append a knot, and those that were skipped before it.
    CDPR_INLINE void add(double at) {
        if (skipped)
            fill(way, size, filled, last, knots, at);
        else
            knots.add(at);
    }
};

// Place the knots of chord k. A vertex has its own knot, and one on both sides at its size, if that is no more than a
// chord. Between these, with sizes larger than chords, knots are independent of vertices, at distances of sizes.
inline void KnotPlacement::place(int64_t k) {
    const double begin = way[k], end = way[k + 1], before = size[k], after = size[k + 1];
    const bool own = k == 0 || before <= OWN_SIZE * larger(end - begin, begin - way[k - 1]);
    if (own && way[last] - begin > KNOT_GAP) {
        if (begin > knots.end() + KNOT_GAP) add(begin);
        filled = k;
        skipped = false;
    }
    skipped = skipped || !own;
    const bool owns = k + 1 == last || after <= OWN_SIZE * larger(end - begin, way[k + 2] - end);
    double left = begin + before;
    const double right = end - after;
    const bool has_left =
        own && larger(begin, knots.end()) + KNOT_GAP < left && left < end - larger(NEAR_SIZE * after, KNOT_GAP);
    bool has_right = owns && begin + larger(NEAR_SIZE * before, KNOT_GAP) < right && right < end - KNOT_GAP;
    if (has_left && has_right && right - left < NEAR_SIZE * smaller(before, after)) {
        left = 0.5 * (left + right);
        has_right = false;
    }
    if (has_left) knots.add(left);
    if (has_right && right > knots.end() + KNOT_GAP) {
        add(right);
        filled = k;
        skipped = false;
    }
}

// Place knots from the first to the last vertex.
inline Knots place_knots(const double* way, const double* size, int64_t last, double* places) {
    KnotPlacement placement = {way, size, last, {places, 0}, 0, false};
    places[0] = way[0];
    for (int64_t k = 0; k < last; k++) placement.place(k);
    placement.add(way[last]);
    return placement.knots;
}

}  // namespace cdpr::CDPR_TARGET
