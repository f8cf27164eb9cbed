// Eight closed loops side by side: their acts in lanes, step after step. SPDX-License-Identifier: Apache-2.0
//
// The arrays of the cases stand in one block (M, 8), a lane each. Where an act has not served a case, that case's own
// program does it on the case's own arrays, up to where the others wait for it.
#pragma once

#include <cdpr/simulation/proceed.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int CASES = 8;

// How an act is done: by Python; in lanes, which returns the bits of those that it has not served; by each case's own
// program; the desired motion; and the ends of samples.
enum Way : int64_t { BY_PYTHON, IN_LANES, ALONE, MOTION, COMPLETE, NEXT };

// One row of the table of acts.
struct CommonAct {
    int64_t way;
    int64_t operation, place;  // in lanes
    int64_t when;
    int64_t together;  // so many acts, this one included, before cases that were not served join the others again
};

// Position of the cases, written at the end.
struct CommonStanding {
    int64_t sample, act;  // the next ones
    int64_t stop;         // stop before this sample
    int64_t due;          // the sample at which an event is due
    int64_t alive;        // bits of the lanes that count
    int64_t left;         // bits of those that Python must serve: they stand by themselves, before the act
};

// An array of one case and its first row in the block.
struct CaseArray {
    int64_t address, size, first;
};

// Program of one case.
struct CaseProgram {
    int64_t operation, place;  // of `proceed`
    int64_t standing, time;    // addresses of its position and time
};

struct Advance {
    const int64_t* table;     // (acts, 5), rows as CommonAct
    int64_t* place;           // (6), as CommonStanding
    double* time;             // (1), of the sample, s
    const int64_t* programs;  // (8, 4), rows as CaseProgram
    const int64_t* arrays;    // (8, r, 3), rows as CaseArray: the arrays that steps change
    const int64_t* motions;   // (k, 2), operations that write the desired motion: one for all, or eight
    const int64_t* desired;   // (8, 3), rows as CaseArray: where that is written
    const int64_t* counting;  // (2), operation that looks at each complete sample, in lanes
    const int64_t* columns;   // (w), kept columns, as rows of the block
    double* rows;             // (8, n, w), kept rows
    double* block;            // (M, 8)
    double period;            // s
    int64_t every;            // samples from one that is kept to the next
    int64_t acts;
    int64_t r;
    int64_t k;
    int64_t w;
    int64_t n;
    int64_t M;
    static constexpr Field fields[] = {in<int64_t>("table", "acts", "5"),
                                       both<int64_t>("place", "6"),
                                       both("time", "1"),
                                       in<int64_t>("programs", "8", "4"),
                                       in<int64_t>("arrays", "8", "r", "3"),
                                       in<int64_t>("motions", "k", "2"),
                                       in<int64_t>("desired", "8", "3"),
                                       in<int64_t>("counting", "2"),
                                       in<int64_t>("columns", "w"),
                                       both("rows", "8", "n", "w"),
                                       both("block", "M", "8"),
                                       value("period"),
                                       value<int64_t>("every"),
                                       size("acts"),
                                       size("r"),
                                       size("k"),
                                       size("w"),
                                       size("n"),
                                       size("M")};
};

CDPR_INLINE double* numbers_at(int64_t address) { return reinterpret_cast<double*>(address); }

// Copy arrays of one case into its lane of the block.
CDPR_INLINE void gather(const CaseArray* arrays, int64_t count, double* block, int lane) {
    for (int64_t k = 0; k < count; k++) {
        const double* one = numbers_at(arrays[k].address);
        double* first = block + CASES * arrays[k].first + lane;
        for (int64_t i = 0; i < arrays[k].size; i++) first[CASES * i] = one[i];
    }
}

// Copy them back.
CDPR_INLINE void scatter(const CaseArray* arrays, int64_t count, const double* block, int lane) {
    for (int64_t k = 0; k < count; k++) {
        double* one = numbers_at(arrays[k].address);
        const double* first = block + CASES * arrays[k].first + lane;
        for (int64_t i = 0; i < arrays[k].size; i++) one[i] = first[CASES * i];
    }
}

struct Lane {
    const int64_t* arrays;  // (r, 3)
    int64_t r;
    double* block;  // (M, 8)
    int64_t into;   // 1: into the block; 0: from there
    int64_t lane;
    int64_t M;
    static constexpr Field fields[] = {in<int64_t>("arrays", "r", "3"), size("r"),
                                       both("block", "M", "8"),         value<int64_t>("into"),
                                       value<int64_t>("lane"),          size("M")};
};

// Copy the arrays of one case into a lane of the block, or from there.
inline int move_lane(Lane& moved) {
    const CaseArray* arrays = reinterpret_cast<const CaseArray*>(moved.arrays);
    if (moved.into != 0)
        gather(arrays, moved.r, moved.block, int(moved.lane));
    else
        scatter(arrays, moved.r, moved.block, int(moved.lane));
    return 0;
}

// Let a case's own program do the acts of a sample up to `until`; return whether it came there.
CDPR_INLINE bool step_alone(const CaseProgram& program, int64_t sample, int64_t act, int64_t until, double time) {
    Standing& standing = *reinterpret_cast<Standing*>(program.standing);
    standing.sample = sample;
    standing.act = act;
    standing.last = sample;
    standing.last_act = until;
    *numbers_at(program.time) = time;
    if (call_at(program.operation, program.place, 0.0) == REACHED) return true;
    standing.sample = sample;
    standing.act = act;
    return false;
}

// Write the desired motion of all lanes.
CDPR_INLINE void follow(const Advance& cases, double time) {
    const CaseArray* desired = reinterpret_cast<const CaseArray*>(cases.desired);
    for (int64_t lane = 0; lane < cases.k; lane++) {
        call_at(cases.motions[2 * lane], cases.motions[2 * lane + 1], time);
        const double* one = numbers_at(desired[lane].address);
        double* first = cases.block + CASES * desired[lane].first;
        for (int64_t i = 0; i < desired[lane].size; i++) {
            if (cases.k > 1)
                first[CASES * i + lane] = one[i];
            else
                for (int other = 0; other < CASES; other++) first[CASES * i + other] = one[i];
        }
    }
}

// Keep columns of a complete sample.
CDPR_INLINE void keep(const Advance& cases, int64_t sample, int64_t alive) {
    if (sample % cases.every != 0) return;
    for (int lane = 0; lane < CASES; lane++) {
        if ((alive >> lane & 1) == 0) continue;
        double* kept = cases.rows + (lane * cases.n + sample / cases.every) * cases.w;
        for (int64_t i = 0; i < cases.w; i++) kept[i] = cases.block[CASES * cases.columns[i] + lane];
    }
}

// Go on from the present position until `stop`, or until Python has to go on: return REACHED or 0.
inline int advance(Advance& cases) {
    const CommonAct* const acts = reinterpret_cast<const CommonAct*>(cases.table);
    const CaseProgram* const programs = reinterpret_cast<const CaseProgram*>(cases.programs);
    CommonStanding& standing = *reinterpret_cast<CommonStanding*>(cases.place);
    int64_t sample = standing.sample, act = standing.act, join = -1;
    int64_t waiting = 0, left = 0;  // bits of cases
    int code = 0;
    const auto arrays = [&cases](int lane) {
        return reinterpret_cast<const CaseArray*>(cases.arrays) + cases.r * lane;
    };
    while (true) {
        if (act == join) {
            for (int lane = 0; lane < CASES; lane++)
                if (waiting >> lane & 1) gather(arrays(lane), cases.r, cases.block, lane);
            waiting = 0;
            join = -1;
            if (left != 0) break;
        }
        if (act == cases.acts) act = 0;
        if (act == 0 && sample == standing.stop) {
            code = REACHED;
            break;
        }
        const CommonAct& next = acts[act];
        if (next.when == ALWAYS || (next.when == DUE && sample == standing.due)) {
            int64_t missing = 0;  // bits of cases that were not served
            if (next.way == IN_LANES) {
                missing = call_at(next.operation, next.place, *cases.time);
            } else if (next.way == ALONE) {
                missing = -1;
            } else if (next.way == MOTION) {
                follow(cases, *cases.time);
            } else if (next.way == COMPLETE) {
                call_at(cases.counting[0], cases.counting[1], 0.0);
                keep(cases, sample, standing.alive);
                sample++;
            } else if (next.way == NEXT) {
                *cases.time = double(sample) * cases.period;
            } else {
                break;
            }
            missing &= standing.alive & ~waiting & ~left;
            if (missing != 0 && join < 0) join = act + next.together;
            for (int lane = 0; missing != 0 && lane < CASES; lane++) {
                if ((missing >> lane & 1) == 0) continue;
                scatter(arrays(lane), cases.r, cases.block, lane);
                if (step_alone(programs[lane], sample, act, join % cases.acts, *cases.time)) {
                    waiting |= int64_t(1) << lane;
                } else {
                    scatter(arrays(lane), cases.r, cases.block, lane);
                    left |= int64_t(1) << lane;
                }
            }
        }
        act++;
    }
    standing.sample = sample;
    standing.act = act;
    standing.left = left;
    return code;
}

}  // namespace cdpr::CDPR_TARGET
