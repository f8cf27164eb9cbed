// Drums at given lengths or angles, without the other parts of a cable. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/transmission.hpp>

namespace cdpr::CDPR_TARGET {

// A row of `drums` holds the radius at the home pose, m, and the numbers of transmission.hpp.
constexpr int DRUM_WIDTH = 1 + Transmission::COUNT;

// Motion of drums with that of their cables.
struct DrumMotions {
    const double* drums;         // (m, 7)
    const double* unwound;       // (k, m), m
    const double* rate;          // (k, m), m/s
    const double* acceleration;  // (k, m), m/s^2
    double* angle;               // (k, m), rad, 0 at the home pose
    double* per_turn;            // (k, m), m/rad
    double* speed;               // (k, m), rad/s
    double* turning;             // (k, m), rad/s^2
    double* load;                // (k, m), torque that moves the cable relative to that without losses
    int64_t k;
    int64_t m;
    static constexpr char fields[] =
        "drums(m, 7), unwound(k, m), rate(k, m), acceleration(k, m), angle(k, m), per_turn(k, m), speed(k, m), "
        "turning(k, m), load(k, m), k, m";
};

inline int drum_motions(DrumMotions& p) {
    for (int64_t i = 0; i < p.k * p.m; i++) {
        const double *drum = p.drums + i % p.m * DRUM_WIDTH, *line = drum + 1, rate = p.rate[i];
        const double per_turn = Transmission::per_turn(line, drum[0], p.unwound[i]);
        const double quickening = Transmission::quickening(line, per_turn);
        p.angle[i] = Transmission::angle(line, drum[0], p.unwound[i]);
        p.per_turn[i] = per_turn;
        p.speed[i] = -rate / per_turn;
        p.turning[i] = -(p.acceleration[i] + quickening * rate * rate) / per_turn;
        p.load[i] = Transmission::load(line, p.speed[i]);
    }
    return 0;
}

// Unwound lengths at angles of drums.
struct DrumLengths {
    const double* drums;  // (m, 7)
    const double* angle;  // (k, m), rad
    double* unwound;      // (k, m), m; NaN beyond the end of the cable
    int64_t k;
    int64_t m;
    static constexpr char fields[] = "drums(m, 7), angle(k, m), unwound(k, m), k, m";
};

inline int drum_lengths(DrumLengths& p) {
    for (int64_t i = 0; i < p.k * p.m; i++) {
        const double* drum = p.drums + i % p.m * DRUM_WIDTH;
        p.unwound[i] = Transmission::unwound_at(drum + 1, drum[0], p.angle[i]);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
