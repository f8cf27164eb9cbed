/* Controller in a periodic cycle, in C: replays a run's log. SPDX-License-Identifier: Apache-2.0

   realtime_c ROBOT.BIN RUN.CSV [TENSIONS.BIN]      with --fast first: without waiting for the clock */
#include <stdio.h>
#include <string.h>

#include "cycle.h"
#include "table.h"

static cdpr_robot robot; /* static memory: nothing is allocated */
static unsigned char numbers[CDPR_FILE_BYTES];

/* Run one cycle: desired motion, state, controller and distribution, check of the result. Return the status. */
static int run_cycle(const row *sample, double *tensions) {
    double desired[CDPR_DESIRED];
    int status = cdpr_desired(&robot, sample->time, desired);
    /* On a robot: read the state from sensors here. */
    if (status == CDPR_OK) status = cdpr_step(&robot, sample->time, sample->state, desired, tensions);
    /* On a robot: send the tensions to the drives; if the status is above CDPR_REPLACED, stop safely. */
    return status;
}

/* Run all cycles. Return the worst status. */
static int run(table *log, int waits) {
    cycle timing;
    cycle_begin(&timing, CDPR_CONTROL_STEP, waits);
    const long before = allocations();
    int worst = CDPR_OK;
    size_t k = 0;
    for (; k < log->count && worst <= CDPR_REPLACED; k++) {
        cycle_wait(&timing);
        const int status = run_cycle(&log->rows[k], &log->tensions[k * CDPR_CABLES]);
        if (status > worst) worst = status;
        cycle_end(&timing);
    }
    const long during = allocations() - before;
    printf("status %d\ncycles %zu\nallocations_before %ld\nallocations %ld\noverruns %lld\nlongest_us %.1f\n", worst, k,
           before, before < 0 ? -1 : during, (long long)timing.overruns, (double)timing.longest / 1e3);
    return before >= 0 && during != 0 ? -1 : worst;
}

int main(int count, char **arguments) {
    const int fast = count > 1 && strcmp(arguments[1], "--fast") == 0;
    char **files = arguments + 1 + fast;
    if (count - fast < 3) return fprintf(stderr, "usage: realtime_c [--fast] ROBOT.BIN RUN.CSV [TENSIONS.BIN]\n"), 2;
    table log;
    if (file_read(files[0], numbers, sizeof numbers) != 0 || table_read(&log, files[1]) != 0) return 2;
    const int begun = cdpr_begin(&robot, numbers, sizeof numbers);
    if (begun != CDPR_OK) return fprintf(stderr, "%s: status %d of robot.h\n", files[0], begun), 2;
    const int worst = run(&log, !fast);
    const size_t differences = table_differences(&log);
    printf("differences %zu\n", differences);
    const int unwritten = count - fast > 3 && table_write(&log, files[2]) != 0;
    table_free(&log);
    return worst < 0 || worst > CDPR_REPLACED || differences || unwritten;
}
