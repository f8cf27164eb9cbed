// Closed loops side by side: their operations in lanes, step after step. SPDX-License-Identifier: Apache-2.0
//
// The arrays of the cases are the lanes of one block (M, 8). Each case has its own sample, time and events. An
// operation without a vector form, or one that does not serve a case, is run by that case's own pipeline on its own
// arrays, up to the operation before which it rejoins the others.
#pragma once

#include <cdpr/simulation/step_kernel.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int CASES = 8;

// Kinds of operations: in lanes, with the bits of the unserved lanes as result; by each case's own pipeline; the
// desired motion; the time of a sample; the end of a sample; the next time; events.
enum Way : int64_t { IN_LANES, ALONE, MOTION, TIME, COMPLETE, NEXT, EVENTS };

// Row of the table of operations.
struct SharedOperation {
    int64_t way;
    int64_t operation, place;  // in lanes
    int64_t lanes;             // bits of the lanes that need it
    int64_t together;          // an unserved case rejoins after this number of operations, this one included
};

// Progress of the block.
struct CommonStanding {
    int64_t steps;  // number of steps
    int64_t alive;  // bits of the participating lanes; at the end, of those that still participate
    int64_t left;   // bits of the cases that Python must serve: their pipelines are before the operation in question
};

// Array of a case and its first row in the block.
struct CaseArray {
    int64_t address, size, first;
};

// Pipeline of a case.
struct CasePipeline {
    int64_t operation, place;  // of `step_kernel`
    int64_t standing, time;    // addresses of its position and time
};

struct Advance {
    const int64_t* table;      // (operations, 5), rows as SharedOperation
    int64_t* place;            // (3), as CommonStanding
    const int64_t* pipelines;  // (8, 4), rows as CasePipeline
    const int64_t* arrays;     // (8, r, 3), rows as CaseArray: the arrays that steps change
    const int64_t* motions;    // (8, 2), operations that write the desired motions
    const int64_t* desired;    // (8, 3), rows as CaseArray: outputs of these operations
    const int64_t* counting;   // (2), operation that evaluates each complete sample, in lanes
    const int64_t* columns;    // (w), kept columns, as rows of the block
    const int64_t* kept;       // (8), addresses of the kept rows (n, w)
    const int64_t* alike;      // (1), 1 if the cases have the same motion
    double* block;             // (M, 8); its first row is the time of the sample, s
    double period;             // s
    int64_t every;             // distance of kept samples; 0: none
    int64_t n;
    int64_t operations;
    int64_t r;
    int64_t w;
    int64_t M;
    static constexpr char fields[] =
        "table(operations, 5), both place(3), pipelines(8, 4), arrays(8, r, 3), motions(8, 2), desired(8, 3), "
        "counting(2), "
        "columns(w), kept(8), alike(1), both block(M >= 1, 8), period, every, n, operations, r, w, M";

    CDPR_INLINE const CasePipeline& pipeline(int lane) const {
        return reinterpret_cast<const CasePipeline*>(pipelines)[lane];
    }
    CDPR_INLINE const CaseArray* memory(int lane) const {
        return reinterpret_cast<const CaseArray*>(arrays) + r * lane;
    }
    CDPR_INLINE Standing& standing(int lane) const { return *reinterpret_cast<Standing*>(pipeline(lane).standing); }
    CDPR_INLINE double& time(int lane) const { return *reinterpret_cast<double*>(pipeline(lane).time); }
};

CDPR_INLINE double* numbers_at(int64_t address) { return reinterpret_cast<double*>(address); }

// Call do(lane) for each lane whose bit is set.
template <class F> CDPR_INLINE void each_lane(int64_t bits, F&& run) {
    for (int lane = 0; lane < CASES; lane++)
        if (bits >> lane & 1) run(lane);
}

// Copy arrays of a case into its lane of the block.
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
    const int64_t* arrays;  // (r, 3), rows as CaseArray
    const int64_t* moved;   // (3): the lane, 1 for into the block or 0 for out of it, and the number of arrays
    double* block;          // (M, 8)
    int64_t r;
    int64_t M;
    static constexpr char fields[] = "arrays(r, 3), moved(3), both block(M, 8), r, M";
};

// Copy the first arrays of a case into a lane of the block, or back; return 1 if there is no such lane or array.
inline int move_lane(Lane& moving) {
    const CaseArray* arrays = reinterpret_cast<const CaseArray*>(moving.arrays);
    const int64_t lane = moving.moved[0], count = moving.moved[2];
    if (lane < 0 || lane >= CASES || count > moving.r) return 1;
    if (moving.moved[1] != 0)
        gather(arrays, count, moving.block, int(lane));
    else
        scatter(arrays, count, moving.block, int(lane));
    return 0;
}

// Run the operations of a sample up to `until` by a case's own pipeline; return whether it got there.
CDPR_INLINE bool step_alone(const Advance& cases, int lane, int64_t operation, int64_t until) {
    const CasePipeline& pipeline = cases.pipeline(lane);
    Standing& standing = cases.standing(lane);
    const int64_t sample = standing.sample;
    standing.operation = operation;
    standing.last = sample;
    standing.last_operation = until;
    if (call_at(pipeline.operation, pipeline.place, 0.0) == REACHED) return true;
    standing.sample = sample;
    standing.operation = operation;
    return false;
}

// Write the desired motions; the same motion at the same time is computed once.
CDPR_INLINE void follow(const Advance& cases, int64_t here) {
    const CaseArray* desired = reinterpret_cast<const CaseArray*>(cases.desired);
    const auto compute = [&cases](int lane) {
        call_at(cases.motions[2 * lane], cases.motions[2 * lane + 1], cases.time(lane));
    };
    int first = -1;
    bool once = *cases.alike != 0;
    each_lane(here, [&](int lane) {
        if (first < 0) first = lane;
        once &= cases.time(lane) == cases.time(first);
    });
    if (first < 0) return;
    double* rows = cases.block + CASES * desired[first].first;
    if (once) {
        compute(first);
        const double* one = numbers_at(desired[first].address);
        for (int64_t i = 0; i < desired[first].size; i++)
            for (int lane = 0; lane < CASES; lane++) rows[CASES * i + lane] = one[i];
        return;
    }
    each_lane(here, [&](int lane) {
        compute(lane);
        const double* one = numbers_at(desired[lane].address);
        for (int64_t i = 0; i < desired[lane].size; i++) rows[CASES * i + lane] = one[i];
    });
}

// Evaluate a complete sample of each lane, and keep columns of some.
CDPR_INLINE void complete(const Advance& cases, int64_t here) {
    call_at(cases.counting[0], cases.counting[1], 0.0);
    each_lane(here, [&](int lane) {
        const int64_t sample = cases.standing(lane).sample++;
        if (cases.every < 1 || sample % cases.every != 0 || sample / cases.every >= cases.n) return;
        double* kept = numbers_at(cases.kept[lane]) + (sample / cases.every) * cases.w;
        for (int64_t i = 0; i < cases.w; i++) kept[i] = cases.block[CASES * cases.columns[i] + lane];
    });
}

// Take the participating lanes `steps` steps further, or fewer if a case needs Python: then to the end of that step.
inline int advance(Advance& cases) {
    const SharedOperation* const operations = reinterpret_cast<const SharedOperation*>(cases.table);
    CommonStanding& common = *reinterpret_cast<CommonStanding*>(cases.place);
    int64_t here = common.alive, waiting = 0, left = 0;  // bits of lanes
    const auto leave = [&](int lane, int64_t operation) {
        scatter(cases.memory(lane), cases.r, cases.block, lane);
        cases.standing(lane).operation = operation;
        here &= ~(int64_t(1) << lane);
    };
    for (; common.steps > 0 && left == 0 && here != 0; common.steps--) {
        int64_t join = -1;
        for (int64_t operation = 0; operation <= cases.operations; operation++) {
            if (operation == join) {
                each_lane(waiting, [&](int lane) { gather(cases.memory(lane), cases.r, cases.block, lane); });
                here |= waiting;
                waiting = 0;
                join = -1;
            }
            if (operation == cases.operations) break;
            const SharedOperation& next = operations[operation];
            const int64_t asked = next.lanes & here;
            if (asked == 0) continue;
            int64_t missing = 0;  // bits of unserved lanes
            if (next.way == IN_LANES) {
                missing = asked == here ? call_at(next.operation, next.place, 0.0) & asked : asked;
            } else if (next.way == ALONE) {
                missing = asked;
            } else if (next.way == MOTION) {
                follow(cases, here);
            } else if (next.way == TIME) {
                each_lane(here, [&](int lane) { cases.block[lane] = cases.time(lane); });
            } else if (next.way == COMPLETE) {
                complete(cases, here);
            } else if (next.way == NEXT) {
                each_lane(here,
                          [&](int lane) { cases.time(lane) = double(cases.standing(lane).sample) * cases.period; });
            } else if (next.way == EVENTS) {
                each_lane(here, [&](int lane) {
                    if (cases.standing(lane).sample != cases.standing(lane).due) return;
                    leave(lane, operation);
                    left |= int64_t(1) << lane;
                });
            }
            if (missing != 0 && join < 0) join = operation + next.together;
            each_lane(missing, [&](int lane) {
                leave(lane, operation);
                if (step_alone(cases, lane, operation, join % cases.operations)) {
                    waiting |= int64_t(1) << lane;
                } else {
                    scatter(cases.memory(lane), cases.r, cases.block, lane);
                    left |= int64_t(1) << lane;
                }
            });
        }
    }
    each_lane(here, [&](int lane) { cases.standing(lane).operation = 0; });
    common.alive = here;
    common.left = left;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
