// Steps of the loop: operations called one after the other by their addresses. SPDX-License-Identifier: Apache-2.0
//
// `cdpr/simulation/pipeline.py` makes the table. An operation returns 0, or a code that another operation may handle,
// or else Python.
#pragma once

#include <cdpr/call_at.hpp>
#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

// Results beside the codes of operations, which are small.
enum { PYTHON = 1 << 29, REACHED = 1 << 30 };

// Calls of an operation: never, in each step, or at the sample at which an event is due.
enum When : int64_t { NEVER, ALWAYS, DUE };

// One row of the table.
struct ListedOperation {
    int64_t operation;  // 0: Python's turn; or one of the two below
    int64_t place;
    int64_t when;
    int64_t mends;  // handler, called with the operation's code as time if that is not 0; 0: Python
    int64_t mends_place;
    int64_t skip;  // number of operations to skip if `mends` returns 0

    static constexpr int64_t KEEP = 1;  // the sample is complete: keep its row
    static constexpr int64_t TICK = 2;  // the time of the next sample begins
};

// Position in the run.
struct Standing {
    int64_t sample, operation;     // the next ones
    int64_t last, last_operation;  // stop before these
    int64_t due;                   // sample at which an event is due
};

struct StepKernel {
    const int64_t* table;  // (operations, 6), rows as ListedOperation
    int64_t* place;        // (5), as Standing
    double* time;          // (1), of the sample, s
    const double* row;     // (w), the present sample
    double* rows;          // (n, v), v >= w: sample k goes to row k % n
    double period;         // s
    int64_t operations;
    int64_t w;
    int64_t n;
    int64_t v;
    static constexpr char fields[] =
        "table(operations, 6), both place(5), both time(1), row(w), both rows(n >= 1, v), period, operations, w, n, v";
};

// Call an operation; return its code, 0 if it was handled, and then add to `operation` the number of operations to
// skip.
CDPR_INLINE int call_listed(const ListedOperation& called, double time, int64_t& operation) {
    const int code = call_at(called.operation, called.place, time);
    if (code == 0) return 0;
    if (called.mends == 0 || call_at(called.mends, called.mends_place, double(code)) != 0) return code;
    operation += called.skip;
    return 0;
}

// Call operations from the present position on; return REACHED, PYTHON, or the code of the operation at which it
// stopped.
inline int step_kernel(StepKernel& loop) {
    const ListedOperation* const operations = reinterpret_cast<const ListedOperation*>(loop.table);
    Standing& standing = *reinterpret_cast<Standing*>(loop.place);
    int64_t sample = standing.sample, operation = standing.operation;
    int code = 0;
    while (true) {
        if (operation >= loop.operations) operation = 0;
        if (sample == standing.last && operation == standing.last_operation) {
            code = REACHED;
            break;
        }
        const ListedOperation& next = operations[operation];
        if (next.when == ALWAYS || (next.when == DUE && sample == standing.due)) {
            if (next.operation == ListedOperation::KEEP) {
                double* kept = loop.rows + (sample % loop.n) * loop.v;
                for (int64_t i = 0; i < loop.w; i++) kept[i] = loop.row[i];
                sample++;
            } else if (next.operation == ListedOperation::TICK) {
                *loop.time = double(sample) * loop.period;
            } else if (next.operation == 0) {
                code = PYTHON;
                break;
            } else {
                code = call_listed(next, *loop.time, operation);
                if (code != 0) break;
            }
        }
        operation++;
    }
    standing.sample = sample;
    standing.operation = operation;
    return code;
}

}  // namespace cdpr::CDPR_TARGET
