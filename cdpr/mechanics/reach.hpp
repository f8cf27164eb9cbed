// Limits of cables, such as lengths and winding speeds: counts of samples with violations, for logs and the loop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

// Limits of k kinds for m cables, c tables of them: the first fields of both operations.
struct CableLimits {
    enum Column { START, UPPER, MAGNITUDE, ROOM, COLUMNS };

    const int64_t* time;       // (1), column of the time, s
    const int64_t* kinds;      // (k, 4): first column of a row; whether it is an upper limit; whether the sign of the
                               // value is ignored; first column of the distance to the limits, or -1
    const double* since;       // (c), s, start of each table, increasing
    const double* limits;      // (c, k, m), infinite without limit
    const double* tolerances;  // (k, m)
    const double* until;       // (m), s, times at which cables break; INFINITE for others
    int64_t k;
    int64_t m;
    int64_t c;
    static constexpr char fields[] =
        "time(1), kinds(k, 4), since(c >= 1), limits(c, k, m), tolerances(k, m), until(m), k, m, c";

    // Return whether all columns are in rows of this width.
    inline bool fits(int64_t width) const {
        bool inside = time[0] >= 0 && time[0] < width;
        for (int64_t i = 0; i < k; i++) {
            const int64_t *kind = kinds + COLUMNS * i, start = kind[START], room = kind[ROOM];
            inside = inside && start >= 0 && start + m <= width && room + m <= width;
        }
        return inside;
    }

    // Return the limits (k, m) at the time of a row.
    CDPR_INLINE const double* present(const double* row) const {
        int64_t table = 0;
        while (table + 1 < c && since[table + 1] <= row[time[0]]) table++;
        return limits + table * k * m;
    }
};

// Excess of a cable over its limit, 0 within it, and the value.
struct CableExcess {
    double beyond, value;
};

// Return that of cable j and its limit of kind i.
CDPR_INLINE CableExcess excess(const CableLimits& cables, const double* now, const double* row, int64_t i, int64_t j) {
    const int64_t* kind = cables.kinds + CableLimits::COLUMNS * i;
    const int64_t room = kind[CableLimits::ROOM], place = i * cables.m + j;
    double value = row[kind[CableLimits::START] + j];
    if (kind[CableLimits::MAGNITUDE] != 0) value = absolute(value);
    double beyond = kind[CableLimits::UPPER] != 0 ? value - now[place] : now[place] - value;
    if (room >= 0 && beyond > 0.0) beyond = -row[room + j];
    if (row[cables.time[0]] < cables.until[j] && beyond > cables.tolerances[place]) return {beyond, value};
    return {0.0, value};
}

// Check whether a live sample is beyond a limit.
struct BeyondLimits {
    CableLimits cables;
    const double* row;  // (width)
    int64_t width;
    static constexpr auto fields = extended(CableLimits::fields, "row(width), width");
};

// Return 1 if it is, else 0; -1 if a column is outside the row.
inline int beyond_limits(BeyondLimits& sample) {
    const CableLimits& cables = sample.cables;
    if (!cables.fits(sample.width)) return -1;
    const double* now = cables.present(sample.row);
    for (int64_t i = 0; i < cables.k; i++)
        for (int64_t j = 0; j < cables.m; j++)
            if (excess(cables, now, sample.row, i, j).beyond > 0.0) return 1;
    return 0;
}

// Count of samples beyond limits, and the worst excess.
struct LimitViolations {
    CableLimits cables;
    const double* sizes;  // (k, m), scales of the excesses for comparison
    const double* rows;   // (n, width), samples
    double* worst;        // (k, m), the largest scaled excess so far; 0 at first
    double* worst_value;  // (k, m), the value there
    double* worst_limit;  // (k, m), the limit there
    double* samples;      // (2, k), number of samples beyond, and the number of the first
    int64_t counted;      // samples before these
    int64_t n;
    int64_t width;
    static constexpr auto fields =
        extended(CableLimits::fields,
                 "sizes(k, m), rows(n, width), both worst(k, m), both worst_value(k, m), both worst_limit(k, m), "
                 "both samples(2, k), counted, n, width");

    inline bool count_kind(const double* now, const double* row, int64_t i) const;
};

// Update the worst of kind i; return whether a cable is beyond its limit.
inline bool LimitViolations::count_kind(const double* now, const double* row, int64_t i) const {
    bool found = false;
    for (int64_t j = 0; j < cables.m; j++) {
        const int64_t place = i * cables.m + j;
        const CableExcess here = excess(cables, now, row, i, j);
        if (!(here.beyond > 0.0)) continue;
        found = true;
        const double share = here.beyond / sizes[place];
        if (!(share > worst[place])) continue;
        worst[place] = share;
        worst_value[place] = here.value;
        worst_limit[place] = now[place];
    }
    return found;
}

// Return 1 if one of the samples is beyond a limit, else 0; -1 if a column is outside the rows.
inline int limit_violations(LimitViolations& counter) {
    const CableLimits& cables = counter.cables;
    if (!cables.fits(counter.width)) return -1;
    int found = 0;
    for (int64_t r = 0; r < counter.n; r++) {
        const double* row = counter.rows + r * counter.width;
        const double* now = cables.present(row);
        for (int64_t i = 0; i < cables.k; i++) {
            if (!counter.count_kind(now, row, i)) continue;
            found = 1;
            if (counter.samples[i] == 0.0) counter.samples[cables.k + i] = double(counter.counted + r);
            counter.samples[i] += 1.0;
        }
    }
    return found;
}

}  // namespace cdpr::CDPR_TARGET
