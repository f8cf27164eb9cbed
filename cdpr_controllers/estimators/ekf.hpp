// Error-state Kalman filter of the platform's state: ekf.py. SPDX-License-Identifier: Apache-2.0
//
// Measurements that arrive late are used at the control step at which they were taken: `history` has the estimates,
// commands and measurements of the last steps, from which the filter is then repeated up to the present. The result is
// that of a filter which had all these measurements in time.
#pragma once

#include <cdpr/ring.hpp>
#include <cdpr_controllers/estimators/ekf_updates.hpp>

namespace cdpr::CDPR_TARGET {

// Measurement of one sensor, as it arrives.
template <class T> struct ArrivingMeasurement {
    const T* measured;  // (n)
    const T* fresh;     // (1), 1 if it arrives in this step
    const T* age;       // (1), s
    T* values;          // (n), the last one that has arrived
    T* arrival;         // (2), as in KalmanFilter
    int64_t n;
    static constexpr char fields[] = "measured(n), fresh(1), age(1), both values(n), arrival(2), n";
};

template <class T> inline int take_measurement(ArrivingMeasurement<T>& sensor) {
    const Truth<T> arrives = *sensor.fresh == T(1.0);
    sensor.arrival[0] = *sensor.fresh;
    sensor.arrival[1] = *sensor.age;
    for (int64_t j = 0; any(arrives) && j < sensor.n; j++)
        sensor.values[j] = select(arrives, sensor.measured[j], sensor.values[j]);
    return 0;
}

// Use of a measurement, as a number of the history.
constexpr double NOT_MEASURED = 0.0, USED = 1.0, ARRIVED = 2.0;

template <class T> struct KalmanFilter {
    FilteredPlatform<T> platform;
    const T* time;           // (1), s
    const T* start;          // (13), estimate at time 0
    const T* deviation;      // (12), standard deviations of its errors
    const T* command;        // (m), N, tensions as sent for the control period that ends
    const int64_t* sensors;  // (k, 5), a SensorRow of each
    const T* values;         // (n), last measurements of all
    const T* arrivals;       // (k, 2): 1 if a measurement has arrived in this step, and its age, s
    const T* deviations;     // (d), of the noise of all components
    const T* settings;       // (q), of the sensors
    T* history;  // (slots, h), of each control step, in a ring: state, covariance, tensions (m), N, that led
                 // to it, ratios and states of stretch (m), values (n) of all sensors, taken at it, and the use (k) of
                 // each sensor; with load cells also the variance, N^2, which a held tension gains in a step,
                 // TensionErrors::keeps of the step that ends with the tensions, and TensionErrors::kept
    T* count;    // (1), control steps since the start
    T* state;    // (13), estimate
    T* covariance;    // (12, 12), of its errors
    T* innovation;    // (2), normalised innovation squared, and number of values; NaN and 0 without new ones
    T* taken;         // (n), work space
    T* stretch;       // (4, m), work space: ratios and states of stretch, then those of the step before
    T* tension;       // (2, m), N, work space: at the begin and at the end of a control period
    T* kept;          // (h), work space, of TensionErrors
    T* terms;         // (20, m), work space, of TensionErrors
    int64_t every;    // control steps from one measurement of load cells to the next
    int64_t overdue;  // control steps after which nothing is known of the change of held tensions
    int64_t k;
    int64_t n;
    int64_t d;
    int64_t q;
    int64_t slots;
    int64_t h;
    static constexpr auto fields = extended(
        FilteredPlatform<T>::fields,
        "time(1), start(13), deviation(12), command(m), sensors(k, 5), values(n), arrivals(k, 2), deviations(d), "
        "settings(q), both history(slots, h), both count(1), state(13), covariance(12, 12), innovation(2), work "
        "taken(n), work stretch(4, m), work tension(2, m), work kept(h), work terms(20, m), every >= 1, overdue >= 1, "
        "k, n, d, q, "
        "slots >= 2, h");

    static constexpr int64_t STATE = 0, COVARIANCE = 13, TENSION = COVARIANCE + ERRORS * ERRORS;  // places in a row

    CDPR_INLINE int64_t of_stretch() const { return TENSION + platform.m; }
    CDPR_INLINE int64_t of_values() const { return TENSION + 3 * platform.m; }
    CDPR_INLINE CableStretch<T> stretch_now() const { return {stretch, stretch + platform.m}; }
    CDPR_INLINE CableStretch<T> stretch_before() const { return {stretch + 2 * platform.m, stretch + 3 * platform.m}; }
    CDPR_INLINE int64_t of_use() const { return of_values() + n; }
    CDPR_INLINE int64_t of_change() const { return of_use() + k; }
    CDPR_INLINE int64_t of_keeps() const { return of_change() + 1; }
    CDPR_INLINE int64_t of_errors() const { return of_keeps() + 1; }
    CDPR_INLINE TensionErrors<T> errors() const { return {kept, terms, platform.noisy ? platform.m : 0}; }
    CDPR_INLINE int64_t numbers() const { return platform.noisy ? of_errors() + errors().stored() : of_change(); }
    CDPR_INLINE RingRow<T> step(T at) const { return {history, slots, h, at}; }
    CDPR_INLINE const int64_t* sensor(int64_t i) const { return sensors + SensorRow::WIDTH * i; }

    // Return whether encoders are used one step later, when load cells have measured the tension that stretches cables.
    CDPR_INLINE bool waits() const { return platform.noisy && platform.elastic; }
};

CDPR_INLINE double largest(double number) { return number; }
#ifdef CDPR_LANES
CDPR_INLINE double largest(const Lanes& lanes) {
    double found = lanes.get(0);
    for (int lane = 1; lane < WIDTH; lane++) found = larger(found, lanes.get(lane));
    return found;
}
#endif

constexpr double REMEMBERED = 4.0;   // holding times of tensions, for which a larger change is remembered
constexpr double SIGNIFICANT = 3.0;  // standard deviations: larger changes are not noise

// Return the variance, N^2, which tensions gain in each of some steps if nothing is known of their change: the square
// of the weight per cable in that time.
template <class T> inline T unknown_change(const KalmanFilter<T>& p, T steps) {
    const Vector<T> g = vector(p.platform.gravity);
    const T m = double(p.platform.m), mass = Inertial<T>{p.platform.inertial}.mass();
    return mass * mass * dot(g, g) / m / (m * steps);
}

// Return for how many control steps the tensions are held; NaN before the first measurement.
template <class T> inline T held_steps(const KalmanFilter<T>& p) {
    for (int64_t i = 0; i < p.k; i++)
        if (p.sensor(i)[SensorRow::KIND] == LOAD_CELLS) return p.arrivals[2 * i + 1] / T(p.platform.period);
    return NOT_A_NUMBER;
}

// Return the variance, N^2, which tensions gain in a step while a measurement is held: that of their change in such a
// time before it was taken, without the noise; an unknown one at the start.
template <class T> inline T change_in_hold(const KalmanFilter<T>& p, T taken, T late, const T* tension) {
    const T zero = 0.0, one = 1.0, every = double(p.every), held = late + every;
    const RingRow<T> at = p.step(taken - held), last = p.step(taken - one);
    const T m = double(p.platform.m);
    const Truth<T> known = (taken > held) & (at.get(KalmanFilter<T>::TENSION) == at.get(KalmanFilter<T>::TENSION));
    T square = 0.0, noise = 0.0;
    for (int64_t i = 0; i < p.platform.m; i++) {
        const T change = tension[i] - at.get(KalmanFilter<T>::TENSION + i), own = p.platform.cells[i];
        square = square + change * change;
        noise = noise + T(2.0) * own * own;
    }
    const T largest_noise = noise * (one + T(SIGNIFICANT) * square_root(T(2.0) / m));  // m squared normal numbers
    const T found = select(square > largest_noise, square - noise, zero) / (m * held);
    const T remembered = (one - every / (T(REMEMBERED) * held)) * last.get(p.of_change());
    const T before = select(taken - every > held, remembered, zero);
    return select(known, larger(found, before), unknown_change(p, held));
}

// Interpolate the tensions between a measurement of load cells, sensor i, and the one before; return the control steps
// between them, 1 without one. The errors of interpolated tensions are those of a first-order Gauss-Markov process with
// the same variance and density: its correlation decays by exp(-2) between the measurements.
template <class T>
inline T interpolate_tensions(const KalmanFilter<T>& p, T taken, T late, int64_t i, T change, Truth<T> acts) {
    constexpr int64_t TENSION = KalmanFilter<T>::TENSION;
    const T zero = 0.0, one = 1.0, most = T(double(p.slots - 2)) - late;
    T gap = zero;
    for (T back = one;; back = back + one) {
        const Truth<T> searched = acts & (gap == zero) & (back <= most);
        if (!any(searched)) break;
        gap = select(searched & (p.step(taken - back).get(p.of_use() + i) != T(NOT_MEASURED)), back, gap);
    }
    gap = select(taken > gap, larger(gap, one), one);
    const RingRow<T> begin = p.step(taken - gap), end = p.step(taken);
    for (T back = one; any(back < gap); back = back + one) {
        const RingRow<T> at = p.step(taken - back);
        for (int64_t j = TENSION; j < TENSION + p.platform.m; j++)
            at.put(j, end.get(j) + back / gap * (begin.get(j) - end.get(j)), back < gap);
        at.put(p.of_change(), change, back < gap);
        at.put(p.of_keeps(), (gap - one) / (gap + one), back < gap);
    }
    end.put(p.of_keeps(), (gap - one) / (gap + one), acts);
    return gap;
}

// Store the new measurement of a sensor at the step at which it was taken; return how many steps ago it changes the
// filter, 0 without one.
template <class T> inline T store_measurement(const KalmanFilter<T>& p, T now, int64_t i) {
    const T zero = 0.0, arrives = p.arrivals[2 * i], age = p.arrivals[2 * i + 1];
    if (!any(arrives == T(1.0))) return zero;
    const T late = truncated(smaller(age / T(p.platform.period) + T(0.5), T(double(p.slots))));
    // Others are later than the sensor's delay and jitter.
    const Truth<T> stored = (arrives == T(1.0)) & (late <= now) & (late <= T(double(p.slots - 2)));
    const RingRow<T> taken = p.step(now - late);
    const int64_t *row = p.sensor(i), place = row[SensorRow::VALUES];
    taken.put(p.of_use() + i, ARRIVED, stored);
    taken.write(p.of_values() + place, row[SensorRow::COUNT], p.values + place, stored);
    const T ago = select(stored, late, zero);
    if (row[SensorRow::KIND] != LOAD_CELLS) return ago;
    const Truth<T> acts = stored & (now - late > zero);  // no tensions act before the start
    const T change = change_in_hold(p, now - late, late, p.values + place);
    for (int64_t before = int64_t(largest(ago)); before >= 0; before--) {
        const RingRow<T> at = p.step(now - T(double(before)));
        const Truth<T> held = acts & (ago >= T(double(before)));
        at.write(KalmanFilter<T>::TENSION, p.platform.m, p.values + place, held);
        at.put(p.of_change(), change, held);
        at.put(p.of_keeps(), T(1.0), held);
    }
    // Repeat from the step that ends with the first tensions that change.
    const T gap = interpolate_tensions(p, now - late, late, i, change, acts);
    return select(acts & (late + gap < now), ago + gap, ago);
}

// Store the inputs of the present step, and the new measurements; return how many steps ago the first step to filter
// was.
template <class T> inline T store_inputs(const KalmanFilter<T>& p, T now) {
    constexpr int64_t TENSION = KalmanFilter<T>::TENSION;
    const Truth<T> always = true, later = now > T(0.0);
    const RingRow<T> present = p.step(now), before = p.step(now - T(1.0));
    for (int64_t i = 0; i < p.k; i++) present.put(p.of_use() + i, NOT_MEASURED, always);
    for (int64_t i = 0; i < p.platform.m; i++) {
        const T held = p.platform.noisy ? select(later, before.get(TENSION + i), T(NOT_A_NUMBER)) : p.command[i];
        present.put(TENSION + i, held, always);
    }
    if (p.platform.noisy) {
        const T kept = select(later, before.get(p.of_change()), T(0.0)), steps = held_steps(p);
        const Truth<T> late = steps > T(double(p.overdue));
        present.put(p.of_change(), select(late, larger(kept, unknown_change(p, steps)), kept), always);
        present.put(p.of_keeps(), T(1.0), always);
    }
    T ago = select(Truth<T>(p.waits()) & (now > T(1.0)), T(1.0), T(0.0));
    for (int64_t i = 0; i < p.k; i++) ago = larger(ago, store_measurement(p, now, i));
    return ago;
}

// Copy numbers of a step from the first one on.
template <class T> CDPR_INLINE void load(const RingRow<T>& step, int64_t first, int64_t count, T* numbers) {
    for (int64_t j = 0; j < count; j++) numbers[j] = step.get(first + j);
}

// Load the tensions at the begin and at the end of a step `late` steps ago: load cells measure the latter one step
// later.
template <class T> inline void load_tensions(const KalmanFilter<T>& p, T at, double late) {
    const int64_t m = p.platform.m;
    load(p.step(at), KalmanFilter<T>::TENSION, m, p.tension);
    load(p.step(p.platform.noisy && late > 0.0 ? at + T(1.0) : at), KalmanFilter<T>::TENSION, m, p.tension + m);
}

// Return the errors of tensions and stretch at the begin of a step `late` steps ago, and correct its tensions, which
// are those of the period where `acts`.
template <class T> inline TensionErrors<T> load_errors(const KalmanFilter<T>& p, T at, double late, Truth<T> acts) {
    TensionErrors<T> errors = p.errors();
    errors.keeps = 1.0;
    const int64_t m = errors.m;
    const RingRow<T> end = p.step(late > 0.0 ? at + T(1.0) : at);
    const T one = 1.0, change = end.get(p.of_change());
    if (late > 0.0) errors.keeps = end.get(p.of_keeps());
    const T keeps = errors.keeps, renewed = one - keeps * keeps;
    // Interpolated tensions have a sixth of the variance gained between the measurements: that of a random walk between
    // two known ends.
    const T gained = select(keeps == one, change, change * keeps * (one + keeps) / T(3.0));
    load(p.step(at - T(1.0)), p.of_errors(), errors.stored(), errors.kept);
    for (int64_t i = 0; i < m; i++) {
        const T square = p.platform.cells[i] * p.platform.cells[i];
        T& first = errors.variance(i);  // of the first tension
        first = select(acts & (first == T(0.0)), square, first);
        errors.added(i) = renewed * square + gained;
        p.tension[i] = p.tension[i] + errors.estimate(i);
        errors.estimate(i) = errors.keeps * errors.estimate(i);
        p.tension[m + i] = p.tension[m + i] + errors.estimate(i);
    }
    return errors;
}

// Write state and covariance of a step before its measurements.
template <class T> inline void begin_step(const KalmanFilter<T>& p, T at, double late) {
    using Filter = KalmanFilter<T>;
    const Truth<T> starts = !(at > T(0.0));
    const int64_t m = p.platform.m;
    if (!all(starts)) {
        const RingRow<T> before = p.step(at - T(1.0));
        const T* const state = before.read(Filter::STATE, 13, p.state);
        T* const tension = p.platform.forces;
        const Truth<T> acts = p.tension[0] == p.tension[0];
        const TensionErrors<T> errors = p.platform.noisy ? load_errors(p, at, late, acts) : p.errors();
        for (int64_t i = 0; i < m; i++) tension[i] = T(0.5) * (p.tension[i] + p.tension[m + i]);
        if (p.platform.elastic) load(before, p.of_stretch(), 2 * m, p.stretch_before().ratio);
        advance_drums(p.platform, state, p.stretch_before(), tension, p.stretch_now());
        predict(p.platform, state, before.read(Filter::COVARIANCE, ERRORS * ERRORS, p.covariance), tension, errors,
                p.state, p.covariance);
        if (p.platform.elastic)
            write_stretch(p.platform, p.state, p.tension, p.tension + m, p.stretch_before(), p.stretch_now(), errors);
        if (p.platform.noisy) advance_tension_errors(acts, errors);
    }
    if (!any(starts)) return;
    for (int64_t i = 0; p.platform.elastic && i < 2 * m; i++)
        p.stretch[i] = select(starts, T(NOT_A_NUMBER), p.stretch[i]);
    for (int64_t i = 0; p.platform.noisy && i < p.errors().stored(); i++) p.kept[i] = select(starts, T(0.0), p.kept[i]);
    for (int j = 0; j < 13; j++) p.state[j] = select(starts, p.start[j], p.state[j]);
    for (int j = 0; j < ERRORS * ERRORS; j++) {
        const T own = p.deviation[j / ERRORS];
        p.covariance[j] = select(starts, j % (ERRORS + 1) == 0 ? own * own : T(0.0), p.covariance[j]);
    }
}

// Add the corrections of tensions and stretch.
template <class T> inline void correct_tensions(const KalmanFilter<T>& p) {
    const TensionErrors<T> errors = p.errors();
    const CableStretch<T> stretch = p.stretch_now();
    for (int64_t i = 0; i < errors.m; i++) {
        const T more = errors.correction()[2 * i], tension = errors.correction()[2 * i + 1];
        errors.estimate(i) = errors.estimate(i) + tension;
        p.tension[errors.m + i] = p.tension[errors.m + i] + tension;
        if (!p.platform.elastic) continue;
        const T length = p.platform.length[i], ratio = stretch.ratio[i];
        stretch.state[i] = stretch.state[i] + more;
        stretch.ratio[i] = select(more != T(0.0), length / (length / ratio - more), ratio);
    }
}

// Use the measurements of a step, where it is one of those to filter, and store its estimate there.
template <class T> inline void complete_step(const KalmanFilter<T>& p, T at, double late, Truth<T> filtered) {
    using Filter = KalmanFilter<T>;
    const RingRow<T> present = p.step(at);
    const Truth<T> later = at > T(0.0);
    const T *const tension = p.tension + p.platform.m, *const ratio = p.stretch_now().ratio;
    const T* const values = present.read(p.of_values(), p.n, p.taken);
    for (int64_t i = 0; i < p.k; i++) {
        const T use = present.get(p.of_use() + i);
        Truth<T> measured = filtered & (use != T(NOT_MEASURED));
        if (p.waits() && late == 0.0 && p.sensor(i)[SensorRow::KIND] == ENCODERS) measured = measured & !later;
        if (!any(measured)) continue;
        Correction<T> sum = {p.covariance, measured};
        if (p.platform.noisy) sum.begin_tensions(p.errors());
        use_sensor(p.platform, p.sensor(i), p.state, tension, later, ratio, values, p.deviations, p.settings, sum);
        sum.apply(p.state);
        if (p.platform.noisy) correct_tensions(p);
        const Truth<T> counts = measured & (use == T(ARRIVED)) & (sum.count > T(0.0));
        T &square = p.innovation[0], &count = p.innovation[1];
        square = select(counts, select(count > T(0.0), square, T(0.0)) + sum.square, square);
        count = select(counts, count + sum.count, count);
        present.put(p.of_use() + i, USED, measured);
    }
    if (p.platform.noisy) present.write(p.of_errors(), p.errors().stored(), p.kept, filtered);
    if (p.platform.elastic) present.write(p.of_stretch(), 2 * p.platform.m, p.stretch, filtered);
    present.write(Filter::STATE, 13, p.state, filtered);
    present.write(Filter::COVARIANCE, ERRORS * ERRORS, p.covariance, filtered);
}

// Filter the present control step. At time 0 the filter starts.
template <class T> inline int kalman_filter(KalmanFilter<T>& p) {
    if (!has_anchors<T>(p.platform.w) || p.h < p.numbers()) return code(T(double(BAD_INPUT)));
    const T now = select(*p.time > T(0.0), *p.count + T(1.0), T(0.0));
    *p.count = now;
    p.innovation[0] = NOT_A_NUMBER;
    p.innovation[1] = 0.0;
    const T ago = store_inputs(p, now);
    for (int64_t k = int64_t(largest(ago)); k >= 0; k--) {
        const double late = double(k);
        const T at = now - T(late);
        load_tensions(p, at, late);
        begin_step(p, at, late);
        complete_step(p, at, late, ago >= T(late));
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
