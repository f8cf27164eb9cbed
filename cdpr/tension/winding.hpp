// Commands of winches that take lengths or rates. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/cables/line.hpp>
#include <cdpr/tension/command.hpp>

namespace cdpr::CDPR_TARGET {

constexpr double MAX_UNWOUND = 1e9;  // m, as in `cdpr.base.fields`

// One cable of the nominal robot at the state that the controller sees.
struct NominalCable {
    ChainRow<double> chain;
    BentSpan<double> span;
    double length;  // m

    CommandKind kernel_takes() const { return command_of(chain.winch_kind()); }

    // Return the unwound length, m, with this tension, N, if the cable lengthens by a distance, m.
    double unwound_at(double tension, double distance = 0.0) const {
        const double later = length + distance;
        BentSpan<double> moved = span;
        moved.chord = (later / length) * span.chord;
        return unwound_length(chain, moved, later, tension);
    }

    // Return the tension, N, with this unwound length, m, at rest.
    double tension_at(double unwound) const { return cdpr::tension_at(chain, span, length, unwound); }
};

struct NominalCables {
    const double* chains;   // (m, 33), chain.hpp
    const double* lines;    // (m, w), as in Geometry
    const double* state;    // (13)
    const double* gravity;  // (3), m/s^2
    const double* sensed;   // (2, m): lengths, m, and rates, m/s
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "chains(m, 33), lines(m, w >= 6), state(13), gravity(3), sensed(2, m), m, w";

    NominalCable at(int64_t i) const {
        const ChainRow<double> chain = chain_row(chains, i);
        const Line<double> cable = line(lines, w, i, vector(state), quaternion(state + 3));
        const ExitResult<double> exit = cable.lead();
        return {chain, cable.span(exit, chain.span(), vector(gravity)), sensed[i]};
    }
    double rate(int64_t i) const { return sensed[m + i]; }
};

// Winches that take lengths or rates as their commands.
struct Drives {
    NominalCables cables;
    const int64_t* takes;   // (m), a CommandKind: the quantity that the winch takes
    const double* unwound;  // (m), m, of the plant; NaN before its start
    double* command;        // (m), N, m or m/s, of the winches
    double* drive;          // (m), the same for their kernels
    double period;          // s, of control
    static constexpr auto fields =
        extended(NominalCables::fields, "takes(m), unwound(m), command(m), drive(m), period");

    bool started(int64_t i) const { return unwound[i] == unwound[i]; }

    // Command winch i to have unwound a length, m: an ideal drive at the end of the period, which is its start length
    // before the start.
    void unwind_to(int64_t i, double length) const {
        const bool by_rate = cables.at(i).kernel_takes() == RATE_COMMAND && started(i);
        drive[i] = by_rate ? (length - unwound[i]) / period : length;
        command[i] = takes[i] == RATE_COMMAND ? (started(i) ? drive[i] : 0.0) : length;
    }
};

// Conversion of commanded tensions into the commands of winches.
struct Winding {
    Drives drives;
    const double* tension;  // (m), N
    static constexpr auto fields = extended(Drives::fields, "tension(m)");
};

// Write the command that produces each tension: itself; or the unwound length, for an ideal drive that of the cable at
// the end of the period.
inline int wind(Winding& p) {
    const Drives& drives = p.drives;
    for (int64_t i = 0; i < drives.cables.m; i++) {
        if (drives.takes[i] == TENSION_COMMAND) {
            drives.command[i] = drives.drive[i] = p.tension[i];
            continue;
        }
        const NominalCable cable = drives.cables.at(i);
        const bool ahead = drives.started(i) && cable.kernel_takes() == RATE_COMMAND;
        drives.unwind_to(i, cable.unwound_at(p.tension[i], ahead ? drives.period * drives.cables.rate(i) : 0.0));
    }
    return 0;
}

// Commands that imperfect drives apply.
struct AppliedCommands {
    Drives drives;
    const double* applied;  // (m), N, m or m/s
    static constexpr auto fields = extended(Drives::fields, "applied(m)");
};

// Write the commands of the kernels for the applied ones, except the start lengths of winches that take rates.
inline int drive_winches(AppliedCommands& p) {
    const Drives& drives = p.drives;
    for (int64_t i = 0; i < drives.cables.m; i++) {
        const double kind = chain_row(drives.cables.chains, i).winch_kind();
        if (!drives.started(i) && drives.takes[i] == RATE_COMMAND) continue;
        const bool winds = drives.started(i) && drives.takes[i] == LENGTH_COMMAND && command_of(kind) == RATE_COMMAND;
        drives.drive[i] = winds ? (p.applied[i] - drives.unwound[i]) / drives.period : p.applied[i];
    }
    return 0;
}

// Commands of a controller in the units of the winches.
struct WinchCommand {
    Drives drives;
    const double* given;   // (m), N, m or m/s
    const double* start;   // (m), N, tensions before the start of winches that take rates
    const double* limits;  // (2, m), N
    const double* matrix;  // (6, m), moments in N m per N
    double* tension;       // (m), N
    double* wrench;        // (6), N and N m
    double* report;        // (4), as in Command
    int64_t stop;          // as in Command
    static constexpr auto fields = extended(
        Drives::fields,
        "given(m), start(m), limits(2, m), matrix(6, m), both tension(m), both wrench(6), both report(4), stop");
};

// Write the commands, and the tensions that the nominal robot then has at rest: commanded tensions are clipped to the
// limits. Return as `take_command`, and BAD_INPUT for a length that no cable can have.
inline int take_winch_command(WinchCommand& p) {
    const Drives& drives = p.drives;
    const int64_t m = drives.cables.m;
    for (int64_t i = 0; i < m; i++) {
        if (!finite(p.given[i])) return BAD_INPUT;
        const bool possible = p.given[i] > 0.0 && p.given[i] <= MAX_UNWOUND;
        if (drives.takes[i] == LENGTH_COMMAND && !possible) return BAD_INPUT;
    }
    const Limits<double> limits = {p.limits, p.limits + m, m};
    const double tolerance = LIMIT_TOLERANCE * newton(limits);
    int status = OK;
    for (int64_t i = 0; i < m; i++) {
        const NominalCable cable = drives.cables.at(i);
        const double given = p.given[i];
        if (drives.takes[i] == TENSION_COMMAND) {
            if (beyond(limits, i, given, tolerance)) status = NOT_FOUND;
            p.tension[i] = smaller(larger(given, limits.low[i]), limits.high[i]);
            drives.command[i] = drives.drive[i] = p.tension[i];
        } else if (drives.takes[i] == LENGTH_COMMAND) {
            drives.unwind_to(i, given);
            p.tension[i] = cable.tension_at(given);
        } else {
            drives.command[i] = given;
            drives.drive[i] = drives.started(i) ? given : cable.unwound_at(p.start[i]);
            p.tension[i] = drives.started(i) ? cable.tension_at(drives.unwound[i]) : p.start[i];
        }
    }
    p.report[0] = double(status);
    account<double>(limits, p.matrix, p.tension, nullptr, p.wrench, p.report);
    return p.stop ? status : int(OK);
}

}  // namespace cdpr::CDPR_TARGET
