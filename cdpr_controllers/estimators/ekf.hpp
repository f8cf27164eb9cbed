// Error-state Kalman filter of the platform's state: ekf.py. SPDX-License-Identifier: Apache-2.0
//
// Measurements that arrive late are used at the control step at which they were taken: `history` has the estimates,
// commands and measurements of the last steps, from which the filter is then repeated up to the present. The result is
// that of a filter which had all these measurements in time.
#pragma once

#include <cdpr_controllers/estimators/ekf_updates.hpp>

namespace cdpr::CDPR_TARGET {

// Numbers of a step in the history.
struct FilteredStep {
    static constexpr int STATE = 0, COVARIANCE = 13, TENSION = COVARIANCE + ERRORS * ERRORS;

    double* row;
    int64_t m;
    int64_t n;

    CDPR_INLINE double* state() const { return row + STATE; }
    CDPR_INLINE double* covariance() const { return row + COVARIANCE; }
    CDPR_INLINE double* tension() const { return row + TENSION; }  // (m), N, that led to this step
    CDPR_INLINE CableStretch stretch() const { return {tension() + m, tension() + 2 * m}; }  // (m) of each
    CDPR_INLINE double* values() const { return tension() + 3 * m; }  // (n), of all sensors, taken at this step
    CDPR_INLINE double* use() const { return values() + n; }       // (k), a MeasurementUse of each sensor
    static CDPR_INLINE int64_t width(int64_t m, int64_t n, int64_t k) { return TENSION + 3 * m + n + k; }
};

// Measurement of one sensor, as it arrives.
struct ArrivingMeasurement {
    const double* measured;  // (n)
    const double* fresh;     // (1), 1 if it arrives in this step
    const double* age;       // (1), s
    double* values;          // (n), the last one that has arrived
    double* arrival;         // (2), as in KalmanFilter
    int64_t n;
    static constexpr char fields[] = "measured(n), fresh(1), age(1), both values(n), arrival(2), n";
};

inline int take_measurement(ArrivingMeasurement& sensor) {
    sensor.arrival[0] = *sensor.fresh;
    sensor.arrival[1] = *sensor.age;
    for (int64_t j = 0; *sensor.fresh == 1.0 && j < sensor.n; j++) sensor.values[j] = sensor.measured[j];
    return 0;
}

enum MeasurementUse { NOT_MEASURED, USED, ARRIVED };

struct KalmanFilter {
    FilteredPlatform platform;
    const double* start;       // (13), estimate at time 0
    const double* deviation;   // (12), standard deviations of its errors
    const double* command;     // (m), N, tensions as sent for the control period that ends
    const int64_t* sensors;    // (k, 5), a SensorRow of each
    const double* values;      // (n), last measurements of all
    const double* arrivals;    // (k, 2): 1 if a measurement has arrived in this step, and its age, s
    const double* deviations;  // (d), of the noise of all components
    const double* settings;    // (q), of the sensors
    double* history;           // (slots, h), a FilteredStep of each control step, in a ring
    double* count;             // (1), control steps since the start
    double* state;             // (13), estimate
    double* covariance;        // (12, 12), of its errors
    double* innovation;        // (2), normalised innovation squared, and number of values; NaN and 0 without new ones
    int64_t k;
    int64_t n;
    int64_t d;
    int64_t q;
    int64_t slots;
    int64_t h;
    static constexpr auto fields = extended(
        FilteredPlatform::fields,
        "start(13), deviation(12), command(m), sensors(k, 5), values(n), arrivals(k, 2), deviations(d), settings(q), "
        "both history(slots, h), both count(1), state(13), covariance(12, 12), innovation(2), k, n, d, q, slots >= 2, "
        "h");

    CDPR_INLINE FilteredStep step(int64_t at) const { return {history + h * (at % slots), platform.m, n}; }
    CDPR_INLINE const int64_t* sensor(int64_t i) const { return sensors + SensorRow::WIDTH * i; }
};

// Store the inputs of the present step, and the new measurements at the steps at which they were taken; return the
// first step to filter.
inline int64_t store_inputs(const KalmanFilter& p, int64_t now) {
    const FilteredStep present = p.step(now);
    for (int64_t i = 0; i < p.k; i++) present.use()[i] = NOT_MEASURED;
    const FilteredStep before = p.step(now > 0 ? now - 1 : now);
    for (int64_t i = 0; i < p.platform.m; i++)
        present.tension()[i] = !p.platform.noisy ? p.command[i] : now > 0 ? before.tension()[i] : NOT_A_NUMBER;
    int64_t first = now;
    for (int64_t i = 0; i < p.k; i++) {
        if (p.arrivals[2 * i] != 1.0) continue;
        const int64_t late = int64_t(smaller(p.arrivals[2 * i + 1] / p.platform.period + 0.5, double(p.slots)));
        if (late > now || late > p.slots - 2) continue;  // later than the sensor's delay and jitter
        const FilteredStep taken = p.step(now - late);
        const int64_t *row = p.sensor(i), place = row[SensorRow::VALUES];
        taken.use()[i] = ARRIVED;
        for (int64_t j = 0; j < row[SensorRow::COUNT]; j++) taken.values()[place + j] = p.values[place + j];
        const bool tensions = row[SensorRow::KIND] == LOAD_CELLS && now - late > 0;  // none act before the start
        for (int64_t at = now - late; tensions && at <= now; at++)
            for (int64_t j = 0; j < p.platform.m; j++) p.step(at).tension()[j] = p.values[place + j];
        first = now - late < first ? now - late : first;
    }
    return first;
}

// Write state and covariance of a step before its measurements.
inline void begin_step(const KalmanFilter& p, int64_t at) {
    const FilteredStep present = p.step(at);
    if (at > 0) {
        const FilteredStep before = p.step(at - 1);
        double* const tension = p.platform.forces;
        for (int64_t i = 0; i < p.platform.m; i++) tension[i] = present.tension()[i];
        advance_drums(p.platform, before.state(), before.stretch(), tension, present.stretch());
        predict(p.platform, before.state(), before.covariance(), tension, present.state(), present.covariance());
        if (p.platform.elastic)
            write_stretch(p.platform, present.state(), present.tension(), before.stretch(), present.stretch());
        return;
    }
    for (int64_t i = 0; i < p.platform.m; i++) present.stretch().ratio[i] = present.stretch().rate[i] = NOT_A_NUMBER;
    for (int j = 0; j < 13; j++) present.state()[j] = p.start[j];
    for (int j = 0; j < ERRORS * ERRORS; j++) present.covariance()[j] = 0.0;
    for (int j = 0; j < ERRORS; j++) present.covariance()[(ERRORS + 1) * j] = p.deviation[j] * p.deviation[j];
}

// Use the measurements of a step.
inline void use_measurements(const KalmanFilter& p, int64_t at) {
    const FilteredStep present = p.step(at);
    for (int64_t i = 0; i < p.k; i++) {
        if (present.use()[i] == NOT_MEASURED) continue;
        Correction sum = {present.covariance()};
        use_sensor(p.platform, p.sensor(i), present.state(), present.tension(), at > 0 ? present.stretch().ratio : nullptr,
                   present.values(), p.deviations, p.settings, sum);
        sum.apply(present.state());
        if (present.use()[i] == ARRIVED && sum.count > 0) {
            p.innovation[0] = (p.innovation[1] > 0.0 ? p.innovation[0] : 0.0) + sum.square;
            p.innovation[1] += double(sum.count);
        }
        present.use()[i] = USED;
    }
}

// Filter the present control step. At time 0 the filter starts.
inline int kalman_filter(KalmanFilter& p, double time) {
    if (!has_anchors<double>(p.platform.w) || p.h < FilteredStep::width(p.platform.m, p.n, p.k)) return BAD_INPUT;
    const int64_t now = time > 0.0 ? int64_t(*p.count) + 1 : 0;
    *p.count = double(now);
    p.innovation[0] = NOT_A_NUMBER;
    p.innovation[1] = 0.0;
    for (int64_t at = store_inputs(p, now); at <= now; at++) {
        begin_step(p, at);
        use_measurements(p, at);
    }
    const FilteredStep present = p.step(now);
    for (int j = 0; j < 13; j++) p.state[j] = present.state()[j];
    for (int j = 0; j < ERRORS * ERRORS; j += ERRORS) store(twelve(present.covariance() + j), p.covariance + j);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
