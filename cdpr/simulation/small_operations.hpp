// Operations of the loop that belong to no part. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/status.hpp>
#include <cdpr/sum.hpp>

namespace cdpr::CDPR_TARGET {

// An engine's clock is a sum of steps: after 1e8 of them its error may reach this share. A reset causes a larger one.
constexpr double CLOCK_TOLERANCE = 1e-6;

template <class T> struct Copy {
    const T* source;  // (n)
    T* target;        // (n)
    int64_t n;
    static constexpr char fields[] = "source(n), target(n), n";
};

template <class T> inline int copy(Copy<T>& arrays) {
    for (int64_t i = 0; i < arrays.n; i++) arrays.target[i] = arrays.source[i];
    return 0;
}

struct Stamp {
    double* row;  // (width), of the log; its first number is the time, s
    int64_t width;
    static constexpr char fields[] = "both row(width >= 1), width";
};

// Write the time, s, of a sample into its row.
inline int stamp(Stamp& sample, double time) {
    sample.row[0] = time;
    return 0;
}

template <class T> struct Values {
    const T* values;  // (n)
    int64_t n;
    static constexpr char fields[] = "values(n), n";
};

// Return 1 if a value is infinite or NaN; for lanes, the bits of these.
template <class T> inline int not_finite(Values<T>& array) {
    const T zero = sum(T(0.0), 0, array.n, [&](int64_t i) { return 0.0 * array.values[i]; });
    return code(select(zero == T(0.0), T(0.0), T(1.0)));
}

// External command, and the record of all commands.
struct GivenCommand {
    const double* given;      // (n), from the caller
    double* values;           // (n), read by the loop
    double* record;           // (rows, n + 2): first sample, number of steps, values
    int64_t* used;            // (1), rows of the record
    const int64_t* standing;  // (5), of the loop, whose first number is the present sample
    const int64_t* steps;     // (1), number of steps of this command
    int64_t n;
    int64_t rows;
    static constexpr char fields[] =
        "given(n), values(n), both record(rows, n + 2), both used(1), standing(5), steps(1), n, rows";
};

// Take and record a command. Do nothing and return 1 if a value is infinite or NaN, 2 if the record is full.
inline int record_command(GivenCommand& command) {
    Values<double> values = {command.given, command.n};
    if (not_finite(values)) return 1;
    if (!(command.used[0] >= 0 && command.used[0] < command.rows)) return 2;
    double* const row = command.record + command.used[0]++ * (command.n + 2);
    row[0] = double(command.standing[0]);
    row[1] = double(command.steps[0]);
    for (int64_t i = 0; i < command.n; i++) command.values[i] = row[2 + i] = command.given[i];
    return 0;
}

struct SampleTime {
    const double* time;  // (1), s
    static constexpr char fields[] = "time(1)";
};

// Return 1 after the first sample, which is at time 0.
inline int later_sample(SampleTime& sample) { return sample.time[0] > 0.0; }

struct Clock {
    const double* clock;  // (1), of an engine, s
    static constexpr char fields[] = "clock(1)";
};

// Return 1 if an engine's clock differs from the time, s, of the sample, or is NaN.
inline int clock_differs(Clock& engine, double time) {
    return !(absolute(engine.clock[0] - time) <= CLOCK_TOLERANCE * time);
}

// Wrench and status without power: no wrench is required.
template <class T> struct PowerOff {
    T* wrench;  // (6), N and N m
    T* status;  // (n), status and number of cables at a limit
    int64_t n;
    static constexpr char fields[] = "wrench(6), status(n), n";
};

template <class T> inline int power_off(PowerOff<T>& sample) {
    for (int i = 0; i < 6; i++) sample.wrench[i] = 0.0;
    for (int64_t i = 0; i < sample.n; i++) sample.status[i] = 0.0;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
