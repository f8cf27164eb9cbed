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

// Covariance that scalar measurements reduce, and the correction of the error state that they give.
struct Correction {
    double* covariance;  // (12, 12), symmetric
    double error[ERRORS] = {};
    double square = 0.0;  // sum of the squared normalised innovations
    int64_t count = 0;    // their number

    // Use a scalar measurement: `innovation` = row . error + noise, with a row that is 0 outside of [begin, end). The
    // covariance is reduced by a product of a vector with itself, which keeps it symmetric to the bit.
    template <int begin, int end> inline void use(const double* row, double innovation, double deviation) {
        Twelve gain = row[begin] * twelve(covariance + ERRORS * begin);
        CDPR_UNROLL
        for (int j = begin + 1; j < end; j++) gain = gain + row[j] * twelve(covariance + ERRORS * j);
        double factors[ERRORS], known = 0.0;
        store(gain, factors);
        CDPR_UNROLL
        for (int j = begin; j < end; j++) {
            innovation -= row[j] * error[j];
            known += row[j] * factors[j];
        }
        const double variance = known + larger(deviation * deviation, LEAST_NOISE * known);
        const double precision = 1.0 / variance, scaled = innovation * precision;
        square += innovation * scaled;
        count++;
        store(twelve(error) + scaled * gain, error);
        CDPR_UNROLL
        for (int j = 0; j < ERRORS; j++) {
            double* const own = covariance + ERRORS * j;
            store(twelve(own) - precision * (factors[j] * gain), own);
        }
    }

    // Use a measured vector of which each component is one of the error state.
    template <int first> CDPR_INLINE void use_direct(Vector<double> innovation, const double* deviation) {
        double row[ERRORS] = {}, each[3];
        store(innovation, each);
        for (int j = 0; j < 3; j++) {
            row[first + j] = 1.0;
            use<first, first + 3>(row, each[j], deviation[j]);
            row[first + j] = 0.0;
        }
    }

    // Use a scalar with these derivatives by position, world axes, and by attitude, platform axes.
    CDPR_INLINE void use_pose(Vector<double> place, Vector<double> turn, double innovation, double deviation) {
        double row[ERRORS] = {};
        store(place, row);
        store(turn, row + TURN_ERROR);
        use<PLACE_ERROR, VELOCITY_ERROR>(row, innovation, deviation);
    }

    // Add the correction to a state (13), and begin the next one.
    CDPR_INLINE void apply(double* state) {
        store(vector(state) + vector(error), state);
        Quaternion<double> q = multiply(quaternion(state + 3), exponential(vector(error + TURN_ERROR)));
        const double scale = 1.0 / square_root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
        store(Quaternion<double>{scale * q.w, scale * q.x, scale * q.y, scale * q.z}, state + 3);
        for (int j = 0; j < 6; j++) state[7 + j] += error[VELOCITY_ERROR + j];
        for (int j = 0; j < ERRORS; j++) error[j] = 0.0;
    }
};

// Measured tensions up to this multiple of their standard deviation may be those of slack cables.
constexpr double SLACK = 3.0;

// Use measured unwound lengths, with these lengths per unwound length; null at the start, where encoders measure the
// lengths of the cables. The unwound lengths of slack cables are not known from their tensions, N.
inline void use_encoders(const FilteredPlatform& p, const double* state, const double* tension, const double* ratio,
                         const double* measured, const double* deviation, Correction& sum) {
    const int64_t m = p.m;
    const Quaternion<double> back = conjugate(quaternion(state + 3));
    Geometry<double> cables = {p.lines, state, p.matrix, p.length, p.rate, p.m, p.w};
    geometry(cables);
    for (int64_t i = 0; i < m; i++) {
        double unwound = p.length[i], noise = deviation[i];
        if (ratio != nullptr && chain_row(p.chains, i).stretches()) {
            if (ratio[i] != ratio[i]) continue;  // no tension has been measured yet
            if (p.noisy && tension[i] <= SLACK * p.cells[i]) continue;
            unwound /= ratio[i];
            if (p.noisy) {
                const double rest = unwound_at(p, state, tension[i], i);
                noise = hypotenuse(noise, unwound_at(p, state, tension[i] + p.cells[i], i) - rest);
            }
        }
        const double share = -unwound / p.length[i];  // motion along the pull shortens a cable
        const Vector<double> u = {p.matrix[i], p.matrix[m + i], p.matrix[2 * m + i]};
        const Vector<double> moment = {p.matrix[3 * m + i], p.matrix[4 * m + i], p.matrix[5 * m + i]};
        sum.use_pose(share * u, share * rotate(back, moment), measured[i] - unwound, noise);
    }
}

// Use the position of a point of the platform, platform axes.
inline void use_receiver(const double* state, const double* point, const double* measured, const double* deviation,
                         Correction& sum) {
    const Quaternion<double> q = quaternion(state + 3), back = conjugate(q);
    const Vector<double> b = vector(point);
    double each[3];
    store(vector(measured) - vector(state) - rotate(q, b), each);
    for (int j = 0; j < 3; j++)  // R (e x b) along the world's axis j
        sum.use_pose(unit_vector(j), cross(b, rotate(back, unit_vector(j))), each[j], deviation[j]);
}

// Use an angular velocity along the platform's axes.
inline void use_turn_rate(const double* state, const double* measured, const double* deviation, Correction& sum) {
    const Quaternion<double> q = quaternion(state + 3);
    const Vector<double> spin = rotate(conjugate(q), vector(state + 10));
    double each[3], row[ERRORS] = {};
    store(vector(measured) - spin, each);
    for (int j = 0; j < 3; j++) {  // R^T (omega + d) after the rotation e: spin + spin x e + R^T d
        store(cross(unit_vector(j), spin), row + TURN_ERROR);
        store(rotate(q, unit_vector(j)), row + SPIN_ERROR);
        sum.use<TURN_ERROR, ERRORS>(row, each[j], deviation[j]);
    }
}

// Use the pixels of the markers that are seen. `settings`: pose of the camera in the axes of its body (7), focal
// lengths (2) and principal point (2), px, 1 if the platform carries the camera, places of the markers (k, 3), m.
inline void use_markers(const double* state, const double* settings, int64_t k, const double* measured,
                        const double* deviation, Correction& sum) {
    const Quaternion<double> q = quaternion(state + 3);
    const Placement platform = {vector(state), q}, camera = {vector(settings), quaternion(settings + 3)};
    const bool carried = settings[11] != 0.0;
    const double *focal = settings + 7, *middle = settings + 9;
    for (int64_t i = 0; i < k; i++) {
        if (measured[2 * k + i] != 1.0) continue;
        const Vector<double> marker = vector(settings + 12 + 3 * i);
        const Vector<double> own = carried ? platform.inwards(marker) : marker;  // platform axes
        const Vector<double> x = camera.inwards(carried ? own : platform.outwards(marker));
        if (!(x.z > 0.0)) continue;  // the estimate is so wrong that it has the marker behind the camera
        for (int j = 0; j < 2; j++) {
            const double along = j == 0 ? x.x : x.y, pixel = focal[j] * along / x.z + middle[j];
            const Vector<double> by_x = (focal[j] / x.z) * (unit_vector(j) - (along / x.z) * unit_vector(2));
            const Vector<double> by_body = rotate(camera.attitude, by_x);
            Vector<double> place = by_body, turn;
            if (carried) {  // own = R^T (marker - p) after the rotation e: own + own x e - R^T d
                place = -1.0 * rotate(q, by_body);
                turn = cross(by_body, own);
            } else {  // p + R b after it: + R (e x b) + d
                turn = cross(own, rotate(conjugate(q), by_body));
            }
            sum.use_pose(place, turn, measured[2 * i + j] - pixel, deviation[2 * i + j]);
        }
    }
}

// Use the measurement of a sensor.
inline void use_sensor(const FilteredPlatform& p, const int64_t* row, const double* state, const double* tension,
                       const double* ratio, const double* values, const double* deviations, const double* settings,
                       Correction& sum) {
    const double *measured = values + row[SensorRow::VALUES], *deviation = deviations + row[SensorRow::DEVIATIONS];
    const double* own = settings + row[SensorRow::SETTINGS];
    const Quaternion<double> back = conjugate(quaternion(state + 3));
    switch (row[SensorRow::KIND]) {
        case POSE_MEASURED:
            sum.use_direct<PLACE_ERROR>(vector(measured) - vector(state), deviation);
            sum.use_direct<TURN_ERROR>(logarithm(multiply(back, quaternion(measured + 3))), deviation + 3);
            break;
        case TWIST_MEASURED:
            sum.use_direct<VELOCITY_ERROR>(vector(measured) - vector(state + 7), deviation);
            sum.use_direct<SPIN_ERROR>(vector(measured + 3) - vector(state + 10), deviation + 3);
            break;
        case ENCODERS:
            use_encoders(p, state, tension, ratio, measured, deviation, sum);
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
