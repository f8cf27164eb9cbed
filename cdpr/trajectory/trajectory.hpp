// Desired motion at a time: the loop's operations, and samples of many segments. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/trajectory/segment.hpp>

namespace cdpr::CDPR_TARGET {

// Sample of a motion, at rest before its first segment and after its last.
struct DesiredMotion {
    const double* segments;  // (k, 42), k >= 1, by their start
    double* desired;         // (19)
    int64_t k;
    static constexpr char fields[] = "segments(k >= 1, 42), desired(19), k";
};

inline int desired_motion(DesiredMotion& motion, double time) {
    sample_segment(segment_at(motion.segments, motion.k, time), time, motion.desired);
    return 0;
}

// The same motion, slowed down to rest along its path. Its time runs at the rate 1 - 3 s^2 + 2 s^3, with s the share of
// the duration: this and its first derivative, and so velocity and acceleration, are continuous.
struct StoppingMotion {
    DesiredMotion motion;
    double begin;     // s
    double duration;  // s, until rest
    static constexpr auto fields = extended(DesiredMotion::fields, "begin, duration");
};

inline int stopping_motion(StoppingMotion& stop, double time) {
    const double begin = stop.begin, duration = stop.duration;
    const double s = smaller(larger((time - begin) / duration, 0.0), 1.0);
    const double pace = 1.0 - s * s * (3.0 - 2.0 * s);
    const double change = -6.0 * s * (1.0 - s) / duration;
    desired_motion(stop.motion, smaller(time, begin) + duration * s * (1.0 - s * s * (1.0 - 0.5 * s)));
    double* rates = stop.motion.desired + MotionSample::VELOCITY;
    double* seconds = stop.motion.desired + MotionSample::ACCELERATION;
    for (int i = 0; i < 6; i++) {
        const double rate = rates[i];
        rates[i] = pace * rate;
        seconds[i] = pace * pace * seconds[i] + change * rate;
    }
    return 0;
}

// Samples of segments, each at its own time.
struct SegmentSamples {
    const double* segments;  // (n, 42)
    const int64_t* which;    // (k), rows of segments
    const double* times;     // (k), s
    double* desired;         // (k, 19)
    int64_t n;
    int64_t k;
    static constexpr char fields[] = "segments(n, 42), which(k), times(k), desired(k, 19), n, k";
};

inline int segment_samples(SegmentSamples& samples) {
    for (int64_t i = 0; i < samples.k; i++)
        sample_segment(samples.segments + samples.which[i] * Segment::NUMBERS, samples.times[i],
                       samples.desired + i * MotionSample::NUMBERS);
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
