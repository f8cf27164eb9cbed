// Exchange of signals with the values of an FMU. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

constexpr double EXACT_SQUARE = 1e-12;  // of a quaternion's length: nearer to 1, the FMU has normalised it

// signals[place] = values[index] * scale + offset, and back.
struct Signals {
    const int64_t* place;  // (k), each less than s
    const int64_t* index;  // (k), each less than v
    const double* scale;   // (k), unit of the signal per unit of the FMU
    const double* offset;  // (k), unit of the signal
    double* values;        // (v), units of the FMU
    double* signals;       // (s), SI units
    int64_t k;
    int64_t v;
    int64_t s;
    static constexpr char fields[] =
        "place(k), index(k), scale(k), offset(k), both values(v), both signals(s), k, v, s";
};

inline int gather_signals(Signals& fmu) {
    for (int64_t k = 0; k < fmu.k; k++)
        fmu.signals[fmu.place[k]] = fmu.values[fmu.index[k]] * fmu.scale[k] + fmu.offset[k];
    return 0;
}

inline int scatter_signals(Signals& fmu) {
    for (int64_t k = 0; k < fmu.k; k++)
        fmu.values[fmu.index[k]] = (fmu.signals[fmu.place[k]] - fmu.offset[k]) / fmu.scale[k];
    return 0;
}

// Normalise the quaternion of a state if its length is near 1.
struct NormaliseAttitude {
    double* state;  // (13)
    double near;    // allowed difference of its squared length from 1
    static constexpr char fields[] = "both state(13), near";
};

inline int normalise_attitude(NormaliseAttitude& problem) {
    double* q = problem.state + 3;
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    const double error = absolute(square - 1.0);
    if (!(EXACT_SQUARE < error && error < problem.near)) return 0;
    const double norm = square_root(square);
    for (int i = 0; i < 4; i++) q[i] = q[i] / norm;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
