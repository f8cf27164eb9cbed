// Speed along a path of many sections: see cdpr.gcode.pace. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/gcode/section_chain.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int SPEED_HALVINGS = 200;  // of an interval of speeds: more than the digits of a double

// Plan of each chain of sections from rest to rest, with limited jerk, and no section faster than its cap.
struct Pace {
    const double* starts;         // (n + 1), m, starts of sections, and the end of the last one; increasing
    const double* caps;           // (n), m/s, largest speeds
    const double* accelerations;  // (n), m/s^2, largest along the path
    const double* jerks;          // (n), m/s^3, likewise; both are smallest in the same section
    const int64_t* chains;        // (c + 1), first section of each chain, and n
    double* phases;               // (8 n + 7 c, 5): `Phases`
    int64_t* rows;                // (c + 1), first phase of each chain, and the number of phases
    int64_t* trees;               // (2, 2 n), work space
    double* stack;                // (2 n + 8, 9), work space: `PathPiece`
    int64_t n;
    int64_t c;
    static constexpr char fields[] =
        "starts(n + 1), caps(n), accelerations(n), jerks(n), chains(c + 1), phases(8*n + 7*c, 5), rows(c + 1), "
        "work trees(2, 2*n), work stack(2*n + 8, 9), n, c";
};

// Part of a chain: a stretch to be planned, one at constant speed, or a change of speed.
enum PathPieceKind { STRETCH, CRUISE, RAMP };

struct PathPiece {
    static constexpr int NUMBERS = 9;

    PathPieceKind kind;
    double begin, end;    // m
    double v0, v1;        // m/s, at begin and end
    int64_t first, last;  // sections of a stretch
    double a, j;          // m/s^2, m/s^3, of a change of speed
};

// Stack of pieces to be planned.
struct PathPieces {
    double* rows;
    int64_t count;

    CDPR_INLINE void push(const PathPiece& p) {
        double* row = rows + count++ * PathPiece::NUMBERS;
        const double numbers[] = {double(p.kind),  p.begin,        p.end, p.v0, p.v1,
                                  double(p.first), double(p.last), p.a,   p.j};
        for (int i = 0; i < PathPiece::NUMBERS; i++) row[i] = numbers[i];
    }
    CDPR_INLINE PathPiece pop() {
        const double* r = rows + --count * PathPiece::NUMBERS;
        return {PathPieceKind(int(r[0])), r[1], r[2], r[3], r[4], int64_t(r[5]), int64_t(r[6]), r[7], r[8]};
    }
};

// Plan a stretch that does not reach its cap: rise to the largest speed from which it can fall again.
inline void plan_peak(const SectionChain& chain, const PathPiece& p, double cap, Phases& phases) {
    const double way = p.end - p.begin;
    const auto up = [&](double v) { return chain.change_after(p.begin, p.v0, v, p.first, p.last); };
    const auto down = [&](double v) { return chain.change_before(p.end, p.v1, v, p.first, p.last); };
    double low = larger(p.v0, p.v1), high = cap;
    for (int i = 0; i < SPEED_HALVINGS; i++) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high) break;
        if (up(middle).way + down(middle).way > way)
            high = middle;
        else
            low = middle;
    }
    const SpeedChange rise = up(low), fall = down(low);
    phases.add_ramp(p.begin, p.v0, low, rise.acceleration, rise.jerk);
    if (low > 0.0) phases.add((way - rise.way - fall.way) / low, p.begin + rise.way, low, 0.0, 0.0);
    phases.add_ramp(p.end - fall.way, low, p.v1, fall.acceleration, fall.jerk);
}

// Plan a stretch at the smallest cap of its sections. If that is reached, its section has this constant speed, and the
// parts before and after are planned again, without this section: their caps are higher.
inline void plan_stretch(const SectionChain& chain, const PathPiece& p, PathPieces& left, Phases& phases) {
    const int64_t section = chain.caps.least(p.first, p.last);
    const double cap = larger(larger(chain.caps.values[section], p.v0), p.v1);
    const SpeedChange rise = chain.change_after(p.begin, p.v0, cap, p.first, p.last);
    const SpeedChange fall = chain.change_before(p.end, p.v1, cap, p.first, p.last);
    if (rise.way + fall.way >= p.end - p.begin) {
        plan_peak(chain, p, cap, phases);
        return;
    }
    const double there = p.begin + rise.way, back = p.end - fall.way;
    const double x = smaller(larger(chain.starts[section], there), back);
    const double y = smaller(larger(chain.starts[section + 1], there), back);
    const PathPieceKind after = y < back && section < p.last ? STRETCH : RAMP;
    const PathPieceKind before = x > there && section > p.first ? STRETCH : RAMP;
    left.push({after, y, p.end, cap, p.v1, section + 1, p.last, fall.acceleration, fall.jerk});
    left.push({CRUISE, x, y, cap, cap, 0, 0, 0.0, 0.0});
    left.push({before, p.begin, x, p.v0, cap, p.first, section - 1, rise.acceleration, rise.jerk});
}

inline void plan_chain(const SectionChain& chain, double* stack, Phases& phases) {
    const int64_t count = chain.caps.count;
    PathPieces left = {stack, 0};
    left.push({STRETCH, chain.starts[0], chain.starts[count], 0.0, 0.0, 0, count - 1, 0.0, 0.0});
    while (left.count > 0) {
        const PathPiece p = left.pop();
        if (p.kind == CRUISE)
            phases.add((p.end - p.begin) / p.v0, p.begin, p.v0, 0.0, 0.0);
        else if (p.kind == RAMP)
            phases.add_ramp(p.begin, p.v0, p.v1, p.a, p.j);
        else
            plan_stretch(chain, p, left, phases);
    }
}

inline int pace(Pace& path) {
    Phases phases = {path.phases, 0};
    for (int64_t i = 0; i < path.c; i++) {
        path.rows[i] = phases.count;
        const int64_t base = path.chains[i], count = path.chains[i + 1] - base;
        const LeastTree caps = {path.caps + base, path.trees + 2 * base, count};
        const LeastTree jerks = {path.jerks + base, path.trees + 2 * (path.n + base), count};
        caps.grow();
        jerks.grow();
        plan_chain({path.starts + base, path.accelerations + base, caps, jerks}, path.stack, phases);
    }
    path.rows[path.c] = phases.count;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
