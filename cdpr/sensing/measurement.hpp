// Measurements of a sensor: errors, rate, delay, jitter and losses. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/random_numbers.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

// Numbers of the errors of a component.
enum ErrorNumber { GAIN, BIAS, NOISE, DRIFT, RESOLUTION, ERROR_NUMBERS };

struct Measurement {
    const double* truth;   // (n), true values
    const double* errors;  // (k, 5), of each component, by ErrorNumber; an attitude has three components
    double* stream;        // (6), random stream of the sensor
    double* walk;          // (k), drift and bumps so far
    double* previous;      // (d), values of the last measurement from which rates follow
    double* pending;   // (slots, w), ring of measurements that have not arrived: control step of the arrival, control
                       // step at which it was taken, values; w = n + 2
    double* held;      // (w), likewise, the last one that has arrived
    double* count;     // (4): control steps, measurements sent and received; number of events that lose measurements
    double* measured;  // (n), values that are held
    double* age;       // (1), s, time since they were taken
    double step;       // s, control period
    double dropout;    // probability that a measurement is lost
    double limit;      // true value without an object to measure, which has no errors; may be infinite
    int64_t every;     // control steps from one measurement to the next
    int64_t delay;     // control steps
    int64_t jitter;    // control steps, largest additional delay
    int64_t attitude;  // index of the four values that are an attitude; n without one
    int64_t n;
    int64_t k;
    int64_t d;  // number of rates, which are the last values: differences of as many values before them
    int64_t slots;
    int64_t w;
    static constexpr char fields[] =
        "truth(n), errors(k, 5), both stream(6), both walk(k), both previous(d), both pending(slots, w), both held(w), "
        "both count(4), measured(n), age(1), step, dropout, limit, every >= 1, delay >= 0, jitter >= 0, attitude >= 0, "
        "n, k, d, slots >= 1, w";
};

CDPR_INLINE double normal_number(double* stream) { return normal_quantile(next_uniform(stream)); }

// Value with the errors of component i, `elapsed` (s) after the last one. Errors of 0 draw no number and change no bit.
CDPR_INLINE double with_errors(Measurement& p, int64_t i, double value, double elapsed) {
    const double* const error = p.errors + ERROR_NUMBERS * i;
    if (error[DRIFT] > 0.0) p.walk[i] += error[DRIFT] * square_root(elapsed) * normal_number(p.stream);
    const double offset = error[BIAS] + p.walk[i];
    if (error[GAIN] != 1.0) value *= error[GAIN];
    if (offset != 0.0) value += offset;
    if (error[NOISE] > 0.0) value += error[NOISE] * normal_number(p.stream);
    return error[RESOLUTION] > 0.0 ? nearest_multiple(value, error[RESOLUTION]) : value;
}

// Write the values of a measurement; rates are true at the first two, because values at time 0 may have another origin.
inline void take(Measurement& p, double elapsed, double* values) {
    const int64_t rates = p.n - p.d;
    int64_t i = 0;
    for (int64_t j = 0; j < rates; j++) {
        if (j != p.attitude) {
            const double value = with_errors(p, i++, p.truth[j], elapsed);
            values[j] = p.truth[j] < p.limit ? value : p.truth[j];
            continue;
        }
        Vector<double> turn;  // in axes of the platform
        turn.x = with_errors(p, i++, 0.0, elapsed);
        turn.y = with_errors(p, i++, 0.0, elapsed);
        turn.z = with_errors(p, i++, 0.0, elapsed);
        const Quaternion<double> q = quaternion(p.truth + j);
        store(dot(turn, turn) > 0.0 ? multiply(q, exponential(turn)) : q, values + j);
        j += 3;
    }
    for (int64_t j = 0; j < p.d; j++) {
        const double now = values[rates - p.d + j];
        values[rates + j] =
            elapsed > 0.0 && p.count[0] > double(p.every) ? (now - p.previous[j]) / elapsed : p.truth[rates + j];
        p.previous[j] = now;
    }
}

// Take a measurement if one is due, and write the last one that has arrived. The one at time 0 arrives at once.
inline int measure(Measurement& p, double time) {
    double& steps = p.count[0];
    double& sent = p.count[1];
    double& received = p.count[2];
    const bool first = !(time > 0.0);
    if (first) {
        for (int64_t i = 0; i < p.k; i++) p.walk[i] = 0.0;
        steps = sent = received = 0.0;
    } else {
        steps += 1.0;
    }
    if (int64_t(steps) % p.every == 0) {
        double* const own = p.pending + p.w * (int64_t(sent) % p.slots);
        take(p, first ? 0.0 : double(p.every) * p.step, own + 2);
        const bool lost = p.dropout > 0.0 && next_uniform(p.stream) < p.dropout;
        const double late = p.jitter > 0 ? double(int64_t(next_uniform(p.stream) * double(p.jitter + 1))) : 0.0;
        const double before = sent > 0.0 ? p.pending[p.w * (int64_t(sent - 1.0) % p.slots)] : 0.0;
        own[0] = first ? 0.0 : larger(steps + double(p.delay) + late, before);  // none overtakes another
        own[1] = steps;
        if (first || !(lost || p.count[3] > 0.0)) sent += 1.0;
    }
    while (received < sent && p.pending[p.w * (int64_t(received) % p.slots)] <= steps) {
        const double* const own = p.pending + p.w * (int64_t(received) % p.slots);
        for (int64_t j = 0; j < p.w; j++) p.held[j] = own[j];
        received += 1.0;
    }
    for (int64_t j = 0; j < p.n; j++) p.measured[j] = p.held[2 + j];
    *p.age = (steps - p.held[1]) * p.step;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
