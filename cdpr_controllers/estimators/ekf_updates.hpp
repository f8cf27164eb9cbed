// Measurements of an error-state Kalman filter: ekf_updates.py. SPDX-License-Identifier: Apache-2.0
//
// One scalar after the other, so no matrix is inverted: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to
// Tracking and Navigation (2001), section 5.2.3 and, for uncorrelated components, 7.7.
#pragma once

#include <cdpr/sensing/markers.hpp>
#include <cdpr_controllers/estimators/ekf_stretch.hpp>

namespace cdpr::CDPR_TARGET {

enum FilteredSensor { POSE_MEASURED, TWIST_MEASURED, ENCODERS, RECEIVER, IMU, MARKERS, LOAD_CELLS };

// Least variance of the noise, as a share of that of the predicted measurement: far above the round-off of the
// subtraction, so that the covariance stays positive with sensors that are nearly exact.
constexpr double LEAST_NOISE = 1e-12;

// Row of a sensor: its kind; the places of its values, standard deviations and settings; the number of its values.
struct SensorRow {
    static constexpr int KIND = 0, VALUES = 1, DEVIATIONS = 2, SETTINGS = 3, COUNT = 4, WIDTH = 5;
};

// Sum of terms in two chains of additions, which run beside each other.
template <int begin, int end, class Term> CDPR_INLINE auto in_pairs(Term term) {
    static_assert(end - begin >= 2, "two chains");
    auto even = term(begin), odd = term(begin + 1);
    CDPR_UNROLL
    for (int j = begin + 2; j + 1 < end; j += 2) {
        even = even + term(j);
        odd = odd + term(j + 1);
    }
    if ((end - begin) % 2 == 1) even = even + term(end - 1);
    return even + odd;
}

// Covariance that scalar measurements reduce, and the correction of the error state that they give.
template <class T> struct Correction {
    T* covariance;      // (12, 12), symmetric; while measurements are used, all rows of the first six columns and the
                        // upper half of the others
    Truth<T> measured;  // where there is a measurement; elsewhere nothing changes
    T error[ERRORS] = {};
    TensionErrors<T> tensions = {};  // that of stretch, with load cells
    int64_t cable = -1;              // the value is the unwound length of this cable, which stretches
    T square = 0.0;                  // sum of the squared normalised innovations
    T count = 0.0;                   // their number

    // Begin with the errors of measured tensions.
    CDPR_INLINE void begin_tensions(TensionErrors<T> errors) {
        tensions = errors;
        for (int64_t j = 0; j < 2 * tensions.m; j++) tensions.correction()[j] = 0.0;
    }

    // Use a scalar measurement: `innovation` = row . error + noise, with a row that is 0 outside of [begin, end).
    template <int begin, int end> inline void use(Truth<T> where, const T* row, T innovation, T deviation) {
        where = where & measured;
        if (!any(where)) return;
        T gain[ERRORS], share[ERRORS];
        for (int k = 0; k < ERRORS; k += Strip<T>::COLUMNS)
            store(in_pairs<begin, end>([&](int j) { return row[j] * strip(covariance + ERRORS * j + k); }), gain + k);
        innovation = innovation - in_pairs<begin, end>([&](int j) { return row[j] * error[j]; });
        T known = 0.0;
        if (cable >= 0) {
            known = tensions.add_to_gain(cable, row, gain);
            innovation = innovation + tensions.correction()[2 * cable];
        }
        known = known + in_pairs<begin, end>([&](int j) { return row[j] * gain[j]; });
        const T variance = larger(known + deviation * deviation, known + LEAST_NOISE * known);
        const T precision = 1.0 / variance, scaled = innovation * precision;
        square = select(where, square + innovation * scaled, square);
        count = select(where, count + T(1.0), count);
        for (int j = 0; j < ERRORS; j++) {
            error[j] = select(where, error[j] + scaled * gain[j], error[j]);
            share[j] = precision * gain[j];
        }
        if (tensions.m > 0) tensions.correct(where, cable, row, share, scaled, precision);
        if (all(where))
            reduce<begin, end, true>(where, gain, share);
        else
            reduce<begin, end, false>(where, gain, share);
    }

    // Subtract the product of two vectors from the covariance: from all numbers of the rows that further measurements
    // of the sensor read, and from the upper half of others.
    template <int begin, int end, bool everywhere>
    CDPR_INLINE void reduce(Truth<T> where, const T* gain, const T* share) {
        constexpr int COLUMNS = Strip<T>::COLUMNS, whole = end <= VELOCITY_ERROR ? VELOCITY_ERROR : ERRORS;
        CDPR_UNROLL
        for (int j = 0; j < ERRORS; j++) {
            CDPR_UNROLL
            for (int k = j < whole ? 0 : j - j % COLUMNS; k < ERRORS; k += COLUMNS) {
                T* const own = covariance + ERRORS * j + k;
                const auto less = strip(own) - gain[j] * strip(share + k);
                store(everywhere ? less : select(where, less, strip(own)), own);
            }
        }
    }

    // Use a measured vector of which each component is one of the error state.
    template <int first> CDPR_INLINE void use_direct(Vector<T> innovation, const T* deviation) {
        T row[ERRORS] = {}, each[3];
        store(innovation, each);
        for (int j = 0; j < 3; j++) {
            row[first + j] = 1.0;
            use<first, first + 3>(true, row, each[j], deviation[j]);
            row[first + j] = 0.0;
        }
    }

    // Use a scalar with these derivatives by position, world axes, and by attitude, platform axes.
    CDPR_INLINE void use_pose(Truth<T> where, Vector<T> place, Vector<T> turn, T innovation, T deviation) {
        T row[ERRORS] = {};
        store(place, row);
        store(turn, row + TURN_ERROR);
        use<PLACE_ERROR, VELOCITY_ERROR>(where, row, innovation, deviation);
    }

    // Add the correction to a state (13), and complete the covariance.
    CDPR_INLINE void apply(T* state) {
        const Truth<T> some = count > T(0.0);
        if (!any(some)) return;
        T moved[13];
        store(vector(state) + vector(error), moved);
        const Quaternion<T> q = multiply(quaternion(state + 3), exponential(vector(error + TURN_ERROR)));
        const T scale = 1.0 / square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
        store(Quaternion<T>{scale * q.w, scale * q.x, scale * q.y, scale * q.z}, moved + 3);
        for (int j = 0; j < 6; j++) moved[7 + j] = state[7 + j] + error[VELOCITY_ERROR + j];
        for (int j = 0; j < 13; j++) state[j] = select(some, moved[j], state[j]);
        mirror(covariance);
    }
};

// Measured tensions up to this multiple of their standard deviation may be those of slack cables.
constexpr double NEARLY_SLACK = 3.0;

// Use measured unwound lengths, with these lengths per unwound length where `stretched`; not at the start, where
// encoders measure the lengths of the cables. The unwound lengths of slack cables are not known from their tensions, N.
template <class T> inline void use_encoders(const FilteredPlatform<T>& p, const T* state, const T* tension,
                                            Truth<T> stretched, const T* ratio, const T* measured, const T* deviation,
                                            Correction<T>& sum) {
    const int64_t m = p.m;
    const Quaternion<T> back = conjugate(quaternion(state + 3));
    Geometry<T> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    for (int64_t i = 0; i < m; i++) {
        T unwound = p.length[i];
        sum.cable = -1;
        Truth<T> known = true;
        if (any(stretched) && chain_row(p.chains, i).stretches()) {
            Truth<T> taut = ratio[i] == ratio[i];  // elsewhere no tension has been measured yet
            if (p.noisy) taut = taut & !(tension[i] <= T(NEARLY_SLACK) * square_root(sum.tensions.variance(i)));
            known = (!stretched) | taut;
            unwound = select(stretched, unwound / ratio[i], unwound);
            if (p.noisy) sum.cable = i;
        }
        const T share = -unwound / p.length[i];  // motion along the pull shortens a cable
        const Vector<T> u = {p.matrix[i], p.matrix[m + i], p.matrix[2 * m + i]};
        const Vector<T> moment = {p.matrix[3 * m + i], p.matrix[4 * m + i], p.matrix[5 * m + i]};
        sum.use_pose(known, share * u, share * rotate(back, moment), measured[i] - unwound, deviation[i]);
    }
    sum.cable = -1;
}

// Use the position of a point of the platform, platform axes.
template <class T>
inline void use_receiver(const T* state, const T* point, const T* measured, const T* deviation, Correction<T>& sum) {
    const Quaternion<T> q = quaternion(state + 3), back = conjugate(q);
    const Vector<T> b = vector(point);
    T each[3];
    store(vector(measured) - vector(state) - rotate(q, b), each);
    for (int j = 0; j < 3; j++) {  // R (e x b) along the world's axis j
        const Vector<T> axis = unit_vector<T>(j);
        sum.use_pose(true, axis, cross(b, rotate(back, axis)), each[j], deviation[j]);
    }
}

// Use an angular velocity along the platform's axes.
template <class T>
inline void use_turn_rate(const T* state, const T* measured, const T* deviation, Correction<T>& sum) {
    const Quaternion<T> q = quaternion(state + 3);
    const Vector<T> spin = rotate(conjugate(q), vector(state + 10));
    T each[3], row[ERRORS] = {};
    store(vector(measured) - spin, each);
    for (int j = 0; j < 3; j++) {  // R^T (omega + d) after the rotation e: spin + spin x e + R^T d
        const Vector<T> axis = unit_vector<T>(j);
        store(cross(axis, spin), row + TURN_ERROR);
        store(rotate(q, axis), row + SPIN_ERROR);
        sum.template use<TURN_ERROR, ERRORS>(true, row, each[j], deviation[j]);
    }
}

// Use the pixels of the markers that are seen. `settings`: pose of the camera in the axes of its body (7), focal
// lengths (2) and principal point (2), px, 1 if the platform carries the camera, places of the markers (k, 3), m.
template <class T> inline void use_markers(const T* state, const T* settings, int64_t k, const T* measured,
                                           const T* deviation, Correction<T>& sum) {
    const Quaternion<T> q = quaternion(state + 3);
    const PlacementOf<T> platform = {vector(state), q}, camera = {vector(settings), quaternion(settings + 3)};
    const Truth<T> carried = settings[11] != T(0.0);
    const T *focal = settings + 7, *middle = settings + 9;
    for (int64_t i = 0; i < k; i++) {
        const Truth<T> taken = measured[2 * k + i] == T(1.0);
        if (!any(taken)) continue;
        const Vector<T> marker = vector(settings + 12 + 3 * i);
        const Vector<T> own = select<T>(carried, platform.inwards(marker), marker);  // platform axes
        const Vector<T> x = camera.inwards(select<T>(carried, own, platform.outwards(marker)));
        const Truth<T> seen = taken & (x.z > T(0.0));  // a wrong estimate may have the marker behind the camera
        for (int j = 0; j < 2; j++) {
            const T along = j == 0 ? x.x : x.y, pixel = focal[j] * along / x.z + middle[j];
            const Vector<T> by_x = (focal[j] / x.z) * (unit_vector<T>(j) - (along / x.z) * unit_vector<T>(2));
            const Vector<T> by_body = rotate(camera.attitude, by_x);
            // Carried: own = R^T (marker - p) after the rotation e: own + own x e - R^T d. Else p + R b after it:
            // + R (e x b) + d.
            const Vector<T> place = select<T>(carried, T(-1.0) * rotate(q, by_body), by_body);
            const Vector<T> turn = select<T>(carried, cross(by_body, own), cross(own, rotate(conjugate(q), by_body)));
            sum.use_pose(seen, place, turn, measured[2 * i + j] - pixel, deviation[2 * i + j]);
        }
    }
}

// Use the measurement of a sensor.
template <class T> inline void use_sensor(const FilteredPlatform<T>& p, const int64_t* row, const T* state,
                                          const T* tension, Truth<T> stretched, const T* ratio, const T* values,
                                          const T* deviations, const T* settings, Correction<T>& sum) {
    const T *measured = values + row[SensorRow::VALUES], *deviation = deviations + row[SensorRow::DEVIATIONS];
    const T* own = settings + row[SensorRow::SETTINGS];
    const Quaternion<T> back = conjugate(quaternion(state + 3));
    switch (row[SensorRow::KIND]) {
        case POSE_MEASURED:
            sum.template use_direct<PLACE_ERROR>(vector(measured) - vector(state), deviation);
            sum.template use_direct<TURN_ERROR>(logarithm(multiply(back, quaternion(measured + 3))), deviation + 3);
            break;
        case TWIST_MEASURED:
            sum.template use_direct<VELOCITY_ERROR>(vector(measured) - vector(state + 7), deviation);
            sum.template use_direct<SPIN_ERROR>(vector(measured + 3) - vector(state + 10), deviation + 3);
            break;
        case ENCODERS:
            use_encoders(p, state, tension, stretched, ratio, measured, deviation, sum);
            break;
        case RECEIVER:
            use_receiver(state, own, measured, deviation, sum);
            break;
        case IMU:
            use_turn_rate(state, measured + 3, deviation + 3, sum);
            break;
        case MARKERS:
            use_markers(state, own, row[SensorRow::COUNT] / 3, measured, deviation, sum);
            break;
        default:
            break;
    }
}

}  // namespace cdpr::CDPR_TARGET
