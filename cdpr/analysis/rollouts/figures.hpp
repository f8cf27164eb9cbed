// Figures of a case, accumulated over all its samples. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/rotation.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

// In the order of FIGURES of figures.py: largest, sum of squares and last of the errors of position, m, and of
// orientation, rad; least and largest tension, N; numbers of samples.
enum Figure { POSITION = 0, ORIENTATION = 3, LOWEST = 6, HIGHEST, INFEASIBLE_SAMPLES, UNANSWERED_SAMPLES };

// First columns of the evaluated values in a row, in the order of AT of figures.py.
enum { POSITION_AT, DESIRED_POSITION_AT, ORIENTATION_AT, DESIRED_ORIENTATION_AT, TENSION_AT, STATUS_AT };

template <class T> struct CountSample {
    const T* row;       // (w), a sample; its first number is the time, s
    const T* since;     // (m), s: time from which a cable's tension is ignored
    const int64_t* at;  // (6), the columns above
    T* figures;         // (10), as Figure
    int64_t w;
    int64_t m;
    static constexpr char fields[] = "row(w), since(m), at(6), both figures(10), w, m";
};

template <class T> CDPR_INLINE void count_error(T square, T* figures) {
    const T error = square_root(square);
    figures[0] = select((error > figures[0]) | (error != error), error, figures[0]);
    figures[1] += square;
    figures[2] = error;
}

// Add a sample to the figures; a NaN stays.
template <class T> CDPR_INLINE void count(const T* row, const T* since, const int64_t* at, int64_t m, T* figures) {
    T square = 0.0;
    for (int i = 0; i < 3; i++) {
        const T miss = row[at[DESIRED_POSITION_AT] + i] - row[at[POSITION_AT] + i];
        square += miss * miss;
    }
    const Quaternion<T> reached = quaternion(row + at[ORIENTATION_AT]);
    const Vector<T> turn = logarithm(multiply(quaternion(row + at[DESIRED_ORIENTATION_AT]), conjugate(reached)));
    count_error(square, figures + POSITION);
    count_error(dot(turn, turn), figures + ORIENTATION);
    for (int64_t i = 0; i < m; i++) {
        const T tension = row[at[TENSION_AT] + i], low = figures[LOWEST], high = figures[HIGHEST];
        const Truth<T> counts = row[0] < since[i], poisoned = tension != tension;
        figures[LOWEST] = select(counts & ((tension < low) | poisoned), tension, low);
        figures[HIGHEST] = select(counts & ((tension > high) | poisoned), tension, high);
    }
    const T status = row[at[STATUS_AT]];
    const Truth<T> infeasible = status == T(double(INFEASIBLE));
    figures[INFEASIBLE_SAMPLES] += select(infeasible, T(1.0), T(0.0));
    figures[UNANSWERED_SAMPLES] += select(infeasible | (status == T(double(OK))), T(0.0), T(1.0));
}

template <class T> inline int count_sample(CountSample<T>& sample) {
    count(sample.row, sample.since, sample.at, sample.m, sample.figures);
    return 0;
}

struct CountSamples {
    const double* rows;      // (k, w), consecutive samples
    const double* since;     // (m), s
    const int64_t* at;       // (6)
    const int64_t* columns;  // (c), kept ones
    double* figures;         // (10)
    double* kept;            // (n, c), columns of each `every`th sample
    int64_t first;           // number of the first sample, 0 or more
    int64_t every;           // distance of kept samples
    int64_t k;
    int64_t w;
    int64_t m;
    int64_t c;
    int64_t n;
    static constexpr char fields[] =
        "rows(k, w), since(m), at(6), columns(c), both figures(10), both kept(n, c), first, every >= 1, k, w, m, c, n";
};

// Evaluate samples, and keep columns of some.
inline int count_samples(CountSamples& samples) {
    for (int64_t i = 0; i < samples.k; i++) {
        const double* row = samples.rows + i * samples.w;
        count(row, samples.since, samples.at, samples.m, samples.figures);
        const int64_t sample = samples.first + i;
        if (samples.every < 1 || sample < 0 || sample % samples.every != 0) continue;
        if (sample / samples.every >= samples.n) continue;
        double* kept = samples.kept + (sample / samples.every) * samples.c;
        for (int64_t j = 0; j < samples.c; j++) kept[j] = row[samples.columns[j]];
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
