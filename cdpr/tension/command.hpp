// Tensions commanded by a controller. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/tension/imposed.hpp>

namespace cdpr::CDPR_TARGET {

// Write the wrench (6) of the tensions, W t, and the report except its status; the residual is 0: no wrench was
// required.
template <class T>
CDPR_INLINE void account(Limits<T> limits, const T* matrix, const T* tension, const T* held, T* wrench, T* report) {
    for (int64_t j = 0; j < 6; j++)
        wrench[j] = sum(T(0.0), 0, limits.m, [&](int64_t i) { return matrix[j * limits.m + i] * tension[i]; });
    const Margin<T> margin = margin_of(limits, tension, held, LIMIT_TOLERANCE * newton(limits));
    report[1] = 0.0;
    report[2] = margin.least;
    report[3] = margin.at_limit;
}

// Return whether a command, N, of cable i is beyond its limits; that of a locked cable, whose limits are equal, is not.
inline bool beyond(const Limits<double>& limits, int64_t i, double command, double tolerance) {
    const double low = limits.low[i], high = limits.high[i];
    return low < high && !(low - tolerance <= command && command <= high + tolerance);
}

struct Command {
    const double* command;  // (m), N; ignored for a locked cable, whose limits are equal
    const double* limits;   // (2, m), N
    const double* matrix;   // (6, m), moments in N m per N
    double* tension;        // (m), N
    double* wrench;         // (6), N and N m
    double* report;         // (4): status; 0; margin, N; number of cables at a limit
    int64_t stop;           // whether the status reports a command beyond the limits
    int64_t m;
    static constexpr char fields[] =
        "command(m), limits(2, m), matrix(6, m), both tension(m), both wrench(6), both report(4), stop, m";
};

// Clip the command to the limits. Return BAD_INPUT, and write nothing, if it is not finite; NOT_FOUND if it is beyond
// the limits and that stops the run; else OK.
inline int take_command(Command& p) {
    for (int64_t i = 0; i < p.m; i++)
        if (!finite(p.command[i])) return BAD_INPUT;
    const Limits<double> limits = {p.limits, p.limits + p.m, p.m};
    const double tolerance = LIMIT_TOLERANCE * newton(limits);
    int status = OK;
    for (int64_t i = 0; i < p.m; i++) {
        if (beyond(limits, i, p.command[i], tolerance)) status = NOT_FOUND;
        p.tension[i] = smaller(larger(p.command[i], limits.low[i]), limits.high[i]);
    }
    p.report[0] = double(status);
    account<double>(limits, p.matrix, p.tension, nullptr, p.wrench, p.report);
    return p.stop ? status : int(OK);
}

template <class T> struct ImposedCommand {
    const T* held;    // (m), N, NaN for free cables
    const T* limits;  // (2, m), N
    const T* matrix;  // (6, m), moments in N m per N
    T* tension;       // (m), N
    T* wrench;        // (6), N and N m
    T* report;        // (4), as in Command; its status does not change
    int64_t m;
    static constexpr char fields[] =
        "held(m), limits(2, m), matrix(6, m), both tension(m), wrench(6), both report(4), m";
};

// Set held tensions, and write the wrench of all tensions.
template <class T> inline int impose_command(ImposedCommand<T>& p) {
    hold(p.held, p.tension, p.m);
    const Limits<T> limits = {p.limits, p.limits + p.m, p.m};
    account(limits, p.matrix, p.tension, p.held, p.wrench, p.report);
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
