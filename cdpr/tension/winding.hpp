// Commands of winches that take lengths or rates. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/cables/chain.hpp>
#include <cdpr/cables/line.hpp>
#include <cdpr/tension/command.hpp>

namespace cdpr::CDPR_TARGET {

// One cable of the nominal robot at the state that the controller sees.
struct SeenCable {
    ChainRow<double> chain;
    BentSpan<double> span;
    double length;  // m

    // Return the unwound length, m, with this tension, N.
    double unwound_at(double tension) const {
        const double kind = chain.span_kind();
        return bends(kind) ? bent_rest(kind, span, tension) : rest(kind, chain.span(), length, tension);
    }

    // Return the same while the cable stretches at a rate, m/s, which damping resists. The damping is that of the
    // positive rate, at which no cable becomes slack.
    double unwound_at(double tension, double stretching) const {
        const double still = unwound_at(tension);
        const double damping = tension_at(still, absolute(stretching)) - tension;
        return unwound_at(stretching < 0.0 ? tension + damping : tension - damping);
    }

    // Return the tension, N, with this unwound length, m, and rate of stretch, m/s.
    double tension_at(double unwound, double stretching) const {
        const double kind = chain.span_kind(), low = chain.lowest();
        if (bends(kind)) return bent_pull(kind, span, unwound, stretching, low).tension;
        return pull(kind, chain.span(), length, unwound, stretching, low);
    }
};

struct SeenCables {
    const double* chains;   // (m, 27), chain.hpp
    const double* lines;    // (m, w), as in Geometry
    const double* state;    // (13)
    const double* gravity;  // (3), m/s^2
    const double* sensed;   // (2, m): lengths, m, and rates, m/s
    int64_t m;
    int64_t w;
    static constexpr char fields[] = "chains(m, 27), lines(m, w >= 6), state(13), gravity(3), sensed(2, m), m, w";

    SeenCable at(int64_t i) const {
        const ChainRow<double> chain = chain_row(chains, i);
        const Line<double> cable = line(lines, w, i, vector(state), quaternion(state + 3));
        const ExitResult<double> exit = cable.lead();
        const BentSpan<double> span = {chain.span(), cable.chord(exit.point), exit.wrapped_length, vector(gravity)};
        return {chain, span, sensed[i]};
    }
    double rate(int64_t i) const { return sensed[m + i]; }
};

// Conversion of commanded tensions into the commands of winches.
struct Winding {
    SeenCables cables;
    const double* tension;    // (m), N
    const double* unwound;    // (m), m, of the plant; NaN before its start
    double* command;          // (m), N, m or m/s
    const double* unwinding;  // (m), m/s, of the plant
    double period;            // s, of control
    static constexpr auto fields =
        extended(SeenCables::fields, "tension(m), unwound(m), command(m), unwinding(m), period");
};

// Write the command that produces each tension: itself; the unwound length at the present rate of stretch; or the rate
// at which the length at rest is reached at the end of a period, before the start that length itself.
inline int wind(Winding& p) {
    for (int64_t i = 0; i < p.cables.m; i++) {
        const CommandKind takes = command_of(p.cables.at(i).chain.winch_kind());
        p.command[i] = p.tension[i];
        if (takes == TENSION_COMMAND) continue;
        const SeenCable cable = p.cables.at(i);
        const bool started = p.unwound[i] == p.unwound[i];
        if (!started)
            p.command[i] = cable.unwound_at(p.tension[i]);
        else if (takes == LENGTH_COMMAND)
            p.command[i] = cable.unwound_at(p.tension[i], p.cables.rate(i) - p.unwinding[i]);
        else
            p.command[i] = (cable.unwound_at(p.tension[i]) - p.unwound[i]) / p.period;
    }
    return 0;
}

// Commands of a controller in the units of the winches.
struct WinchCommand {
    SeenCables cables;
    const double* given;    // (m), N, m or m/s
    const double* start;    // (m), N, tensions before the start of winches that take rates
    const double* unwound;  // (m), m, of the plant; NaN before its start
    const double* limits;   // (2, m), N
    const double* matrix;   // (6, m), moments in N m per N
    double* tension;        // (m), N
    double* command;        // (m), N, m or m/s
    double* wrench;         // (6), N and N m
    double* report;         // (4), as in Command
    static constexpr auto fields =
        extended(SeenCables::fields,
                 "given(m), start(m), unwound(m), limits(2, m), matrix(6, m), both tension(m), command(m), "
                 "both wrench(6), both report(4)");
};

// Write the commands, and the tensions that the nominal robot then has: tensions are clipped to the limits. Return
// BAD_INPUT, and write nothing, for a command that is not finite.
inline int take_winch_command(WinchCommand& p) {
    const int64_t m = p.cables.m;
    for (int64_t i = 0; i < m; i++)
        if (!finite(p.given[i])) return BAD_INPUT;
    for (int64_t i = 0; i < m; i++) {
        const SeenCable cable = p.cables.at(i);
        const CommandKind takes = command_of(cable.chain.winch_kind());
        const double given = p.given[i], unwound = p.unwound[i];
        p.command[i] = given;
        if (takes == TENSION_COMMAND) {
            p.tension[i] = p.command[i] = smaller(larger(given, p.limits[i]), p.limits[m + i]);
        } else if (takes == LENGTH_COMMAND) {
            p.tension[i] = cable.tension_at(given, p.cables.rate(i));
        } else if (unwound == unwound) {
            p.tension[i] = cable.tension_at(unwound, p.cables.rate(i) - given);
        } else {
            p.tension[i] = p.start[i];
            p.command[i] = cable.unwound_at(p.start[i]);
        }
    }
    p.report[0] = double(OK);
    account<double>({p.limits, p.limits + m, m}, p.matrix, p.tension, nullptr, p.wrench, p.report);
    return OK;
}

}  // namespace cdpr::CDPR_TARGET
