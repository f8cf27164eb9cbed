// One segment of a motion: position and rotation vector are quintics of time. SPDX-License-Identifier: Apache-2.0
//
// Attitude: R(t) = R_0 exp(phi(t)), phi in the axes of the segment's beginning; cdpr.trajectory.trajectory.
#pragma once

#include <cdpr/rotation.hpp>
#include <cdpr/trajectory/body_rates.hpp>

namespace cdpr::CDPR_TARGET {

// Row of a table of segments: start, s; duration, s; quintics of position, m, and of the rotation vector, rad; initial
// attitude.
struct Segment {
    static constexpr int NUMBERS = 42, START = 0, DURATION = 1, POSITION = 2, ROTATION = 20, ATTITUDE = 38;
    static constexpr int COEFFICIENTS = 6;  // of a quintic in the share of the duration, lowest power first
};

// Sample of a motion, world axes: position, m; quaternion; velocity, m/s; angular velocity, rad/s; acceleration, m/s^2;
// angular acceleration, rad/s^2.
struct MotionSample {
    static constexpr int NUMBERS = 19, ATTITUDE = 3, VELOCITY = 7, SPIN = 10, ACCELERATION = 13, SPIN_RATE = 16;
};

// Tolerance, s, of the end of a segment: times are k * step, ends are sums, and both are rounded.
constexpr double END_SLACK = 1e-9;

// Three quintics at a share of the duration, and their time derivatives.
struct Quintics {
    Vector<double> value, rate, second;
};

// Value and derivatives of a quintic with respect to the share, coefficients lowest power first.
CDPR_INLINE void evaluate(const double* c, double s, double& value, double& rate, double& second) {
    value = c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))));
    rate = c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * (4.0 * c[4] + s * 5.0 * c[5])));
    second = 2.0 * c[2] + s * (6.0 * c[3] + s * (12.0 * c[4] + s * 20.0 * c[5]));
}

CDPR_INLINE Quintics quintics(const double* c, double s, double duration) {
    Quintics found;
    evaluate(c, s, found.value.x, found.rate.x, found.second.x);
    evaluate(c + Segment::COEFFICIENTS, s, found.value.y, found.rate.y, found.second.y);
    evaluate(c + 2 * Segment::COEFFICIENTS, s, found.value.z, found.rate.z, found.second.z);
    found.rate = found.rate / duration;
    found.second = found.second / (duration * duration);
    return found;
}

// Write the sample (19) at a time, s: at rest before the segment begins and after it ends.
inline void sample_segment(const double* segment, double time, double* desired) {
    const double duration = segment[Segment::DURATION], elapsed = time - segment[Segment::START];
    const double s = smaller(larger(elapsed / duration, 0.0), 1.0);
    const Quintics p = quintics(segment + Segment::POSITION, s, duration);
    const Quintics phi = quintics(segment + Segment::ROTATION, s, duration);
    const Quaternion<double> q = multiply(quaternion(segment + Segment::ATTITUDE), exponential(phi.value));
    store(p.value, desired);
    store(q, desired + MotionSample::ATTITUDE);
    if (elapsed < 0.0 || elapsed > duration + END_SLACK) {
        for (int i = MotionSample::VELOCITY; i < MotionSample::NUMBERS; i++) desired[i] = 0.0;
        return;
    }
    const BodyRates rates = body_rates(phi.value, phi.rate, phi.second);
    store(p.rate, desired + MotionSample::VELOCITY);
    store(rotate(q, rates.omega), desired + MotionSample::SPIN);
    store(p.second, desired + MotionSample::ACCELERATION);
    store(rotate(q, rates.alpha), desired + MotionSample::SPIN_RATE);
}

// Return the last of `count` segments that has begun, or the first one.
inline const double* segment_at(const double* segments, int64_t count, double time) {
    int64_t low = 0, high = count - 1;
    while (low < high) {
        const int64_t middle = (low + high + 1) / 2;
        if (segments[middle * Segment::NUMBERS + Segment::START] <= time)
            low = middle;
        else
            high = middle - 1;
    }
    return segments + low * Segment::NUMBERS;
}

}  // namespace cdpr::CDPR_TARGET
