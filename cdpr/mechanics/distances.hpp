// Distances of many segments from each other, and from a solid. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/mechanics/solids.hpp>

namespace cdpr::CDPR_TARGET {

struct SegmentDistances {
    const double* first;   // (k, 6), both ends, m
    const double* second;  // (k, 6)
    double* distance;      // (k), m
    int64_t k;
    static constexpr char fields[] = "first(k, 6), second(k, 6), distance(k), k";
};

inline int segment_distances(SegmentDistances& pairs) {
    for (int64_t i = 0; i < pairs.k; i++) {
        const double *a = pairs.first + 6 * i, *b = pairs.second + 6 * i;
        pairs.distance[i] = between(vector(a), vector(a + 3), vector(b), vector(b + 3));
    }
    return 0;
}

struct SolidDistances {
    const double* solid;     // (s), s >= 11, as of solids.hpp
    const double* segments;  // (k, 6), both ends, m, world
    double* distance;        // (k), m, negative where a segment passes through the solid
    int64_t s;
    int64_t k;
    static constexpr char fields[] = "solid(s >= 11), segments(k, 6), distance(k), s, k";
};

inline int solid_distances(SolidDistances& asked) {
    for (int64_t i = 0; i < asked.k; i++) {
        const double* ends = asked.segments + 6 * i;
        asked.distance[i] = from_solid({asked.solid, asked.s}, vector(ends), vector(ends + 3));
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
