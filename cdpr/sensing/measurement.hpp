// Measurements of a sensor: errors, rate, delay, jitter and losses. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/random_numbers.hpp>
#include <cdpr/ring.hpp>
#include <cdpr/rotation.hpp>

namespace cdpr::CDPR_TARGET {

// Numbers of the errors of a component.
enum ErrorNumber { GAIN, BIAS, NOISE, DRIFT, RESOLUTION, ERROR_NUMBERS };

template <class T> struct Measurement {
    const T* truth;    // (n), true values
    const T* errors;   // (k, 5), of each component, by ErrorNumber; an attitude has three components
    const T* time;     // (1), s
    T* stream;         // (6), random stream of the sensor
    T* walk;           // (k), drift and bumps so far
    T* previous;       // (d), values of the last measurement from which rates follow
    T* pending;        // (slots, w), ring of measurements that have not arrived: control step of the arrival, control
                       // step at which it was taken, values; w = n + 2
    T* held;           // (w), likewise, the last one that has arrived
    T* count;          // (4): control steps, measurements sent and received; number of events that lose measurements
    T* measured;       // (n), values that are held
    T* age;            // (1), s, time since they were taken
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
        "truth(n), errors(k, 5), time(1), both stream(6), both walk(k), both previous(d), both pending(slots, w), "
        "both held(w), both count(4), measured(n), age(1), step, dropout, limit, every >= 1, delay >= 0, "
        "jitter >= 0, attitude >= 0, n, k, d, slots >= 1, w";

    CDPR_INLINE RingRow<T> sent_as(T number) const { return {pending, slots, w, number}; }
};

// Return the next uniform number of a stream; streams of other lanes do not advance.
template <class T> CDPR_INLINE T uniform_where(Truth<T> draws, RandomState<T>& stream) {
    RandomState<T> state = stream;
    const T number = next_uniform(state);
    stream = select(draws, state, stream);
    return number;
}
template <class T> CDPR_INLINE T uniform_where(Truth<T> draws, T* stream) {
    RandomState<T> state = random_state(stream);
    const T number = uniform_where(draws, state);
    store(state, stream);
    return number;
}

// Normal numbers for the errors of the next components, drawn in the order of single draws.
template <class T> struct ErrorDraws {
    static constexpr int64_t MOST = 8;  // components

    T drift[MOST], noise[MOST];
    int64_t next = MOST, drawn = 0;  // the next component here, and all so far

    void draw(const Measurement<T>& p, Truth<T> due) {
        bool drifts = false, varies = false;
        RandomState<T> stream = random_state(p.stream);
        for (next = 0; next < MOST; next++, drawn++) {
            drift[next] = noise[next] = 0.5;  // of which the normal number is 0
            if (drawn >= p.k) continue;
            const T* const error = p.errors + ERROR_NUMBERS * drawn;
            const Truth<T> walks = due & (error[DRIFT] > T(0.0)), noisy = due & (error[NOISE] > T(0.0));
            if (any(walks)) drift[next] = uniform_where(walks, stream);
            if (any(noisy)) noise[next] = uniform_where(noisy, stream);
            drifts = drifts || any(walks);
            varies = varies || any(noisy);
        }
        store(stream, p.stream);
        if (drifts) normal_quantiles(drift);
        if (varies) normal_quantiles(noise);
        next = 0;
    }
};

// Value with the errors of component i, `elapsed` (s) after the last one, where a measurement is due. Errors of 0 draw
// no number and change no bit.
template <class T>
CDPR_INLINE T with_errors(Measurement<T>& p, ErrorDraws<T>& draws, Truth<T> due, int64_t i, T value, T elapsed) {
    const T* const error = p.errors + ERROR_NUMBERS * i;
    const T zero = 0.0;
    if (draws.next == draws.MOST) draws.draw(p, due);
    const T drift = draws.drift[draws.next], noise = draws.noise[draws.next++];
    const Truth<T> drifts = due & (error[DRIFT] > zero), noisy = due & (error[NOISE] > zero);
    p.walk[i] = select(drifts, p.walk[i] + error[DRIFT] * square_root(elapsed) * drift, p.walk[i]);
    const T offset = error[BIAS] + p.walk[i];
    value = value * error[GAIN];
    value = select(offset != zero, value + offset, value);
    value = select(noisy, value + error[NOISE] * noise, value);
    const Truth<T> rounds = error[RESOLUTION] > zero;
    return any(rounds) ? select(rounds, nearest_multiple(value, error[RESOLUTION]), value) : value;
}

template <class T> CDPR_INLINE Quaternion<T> turned_where(Quaternion<T> q, Vector<T> turn) {
    const Truth<T> turns = dot(turn, turn) > T(0.0);
    if (!any(turns)) return q;
    const Quaternion<T> found = multiply(q, exponential(turn));
    return {select(turns, found.w, q.w), select(turns, found.x, q.x), select(turns, found.y, q.y),
            select(turns, found.z, q.z)};
}

// Write the values of a measurement where one is due; rates are true at the first two, because values at time 0 may
// have another origin.
template <class T> inline void take(Measurement<T>& p, Truth<T> due, T elapsed, const RingRow<T>& own) {
    constexpr int VALUES = 2;
    const int64_t rates = p.n - p.d;
    ErrorDraws<T> draws;
    int64_t i = 0;
    for (int64_t j = 0; j < rates; j++) {
        if (j != p.attitude) {
            const T truth = p.truth[j], value = with_errors(p, draws, due, i++, truth, elapsed);
            own.put(VALUES + j, select(truth < T(p.limit), value, truth), due);
            continue;
        }
        Vector<T> turn;  // in axes of the platform
        turn.x = with_errors(p, draws, due, i++, T(0.0), elapsed);
        turn.y = with_errors(p, draws, due, i++, T(0.0), elapsed);
        turn.z = with_errors(p, draws, due, i++, T(0.0), elapsed);
        T attitude[4];
        store(turned_where(quaternion(p.truth + j), turn), attitude);
        own.write(VALUES + j, 4, attitude, due);
        j += 3;
    }
    const Truth<T> differs = (elapsed > T(0.0)) & (p.count[0] > T(double(p.every)));
    for (int64_t j = 0; j < p.d; j++) {
        const T now = own.get(VALUES + rates - p.d + j);
        own.put(VALUES + rates + j, select(differs, (now - p.previous[j]) / elapsed, p.truth[rates + j]), due);
        p.previous[j] = select(due, now, p.previous[j]);
    }
}

// Take a measurement where one is due, and send it unless it is lost; `first`: where it is the first one.
template <class T> inline void send(Measurement<T>& p, Truth<T> due, Truth<T> first) {
    const T zero = 0.0, steps = p.count[0], sent = p.count[1];
    const RingRow<T> own = p.sent_as(sent);
    take(p, due, select(first, zero, T(double(p.every) * p.step)), own);
    Truth<T> lost = p.count[3] > zero;
    if (p.dropout > 0.0) lost = lost | (uniform_where(due, p.stream) < T(p.dropout));
    T late = double(p.delay);
    if (p.jitter > 0) late = late + truncated(uniform_where(due, p.stream) * T(double(p.jitter + 1)));
    const T before = select(sent > zero, p.sent_as(sent - T(1.0)).get(0), zero);
    own.put(0, select(first, zero, larger(steps + late, before)), due);  // none overtakes another
    own.put(1, steps, due);
    p.count[1] = select(due & (first | (!lost)), sent + T(1.0), sent);
}

// Take a measurement if one is due, and write the last one that has arrived. The one at time 0 arrives at once.
template <class T> inline int measure(Measurement<T>& p) {
    T& steps = p.count[0];
    T& sent = p.count[1];
    T& received = p.count[2];
    const T zero = 0.0, one = 1.0;
    const Truth<T> first = !(*p.time > zero);
    for (int64_t i = 0; any(first) && i < p.k; i++) p.walk[i] = select(first, zero, p.walk[i]);
    steps = select(first, zero, steps + one);
    sent = select(first, zero, sent);
    received = select(first, zero, received);
    const Truth<T> due = p.every == 1 ? Truth<T>(true) : remainder_of(steps, p.every) == zero;
    if (any(due)) send(p, due, first);
    while (any(received < sent)) {
        const RingRow<T> next = p.sent_as(received);
        const Truth<T> arrives = (received < sent) & (next.get(0) <= steps);
        if (!any(arrives)) break;
        for (int64_t j = 0; j < p.w; j++) p.held[j] = select(arrives, next.get(j), p.held[j]);
        received = select(arrives, received + one, received);
    }
    for (int64_t j = 0; j < p.n; j++) p.measured[j] = p.held[2 + j];
    *p.age = (steps - p.held[1]) * T(p.step);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
