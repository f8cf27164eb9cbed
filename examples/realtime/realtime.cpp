// Controller in a periodic cycle, in C++: replays a run's log. SPDX-License-Identifier: Apache-2.0
//
// realtime ROBOT.BIN RUN.CSV [TENSIONS.BIN]      with --fast first: without waiting for the clock
#include <stdio.h>
#include <string.h>

#include "cycle.h"
#include "table.h"

namespace {

// Controller of the robot.
class Robot {
  public:
    // Load the numbers; return the status of cdpr_begin, or -1 if the file cannot be read.
    int load(const char* path) {
        unsigned char numbers[CDPR_FILE_BYTES];
        return file_read(path, numbers, sizeof numbers) != 0 ? -1 : cdpr_begin(&robot_, numbers, sizeof numbers);
    }

    // Run one cycle: desired motion, state, controller and distribution, check of the result. Return the status.
    int cycle(const row& sample, double* tensions) {
        double desired[CDPR_DESIRED];
        const int status = cdpr_desired(&robot_, sample.time, desired);
        if (status != CDPR_OK) return status;
        // On a robot: read the state from sensors here.
        return cdpr_step(&robot_, sample.time, sample.state, desired, tensions);
        // On a robot: send the tensions to the drives; if the status is above CDPR_REPLACED, stop safely.
    }

  private:
    cdpr_robot robot_ = {};
};

// Run all cycles. Return the worst status; -1 if something was allocated.
int run(Robot& robot, table& log, bool waits) {
    cycle timing;
    cycle_begin(&timing, CDPR_CONTROL_STEP, waits);
    const long before = allocations();
    int worst = CDPR_OK;
    size_t k = 0;
    for (; k < log.count && worst <= CDPR_REPLACED; k++) {
        cycle_wait(&timing);
        const int status = robot.cycle(log.rows[k], log.tensions + k * CDPR_CABLES);
        if (status > worst) worst = status;
        cycle_end(&timing);
    }
    const long during = allocations() - before;
    printf("status %d\ncycles %zu\nallocations_before %ld\nallocations %ld\noverruns %lld\nlongest_us %.1f\n", worst, k,
           before, before < 0 ? -1 : during, static_cast<long long>(timing.overruns), double(timing.longest) / 1e3);
    return before >= 0 && during != 0 ? -1 : worst;
}

Robot robot;  // static memory: nothing is allocated

}  // namespace

int main(int count, char** arguments) {
    const bool fast = count > 1 && strcmp(arguments[1], "--fast") == 0;
    char** files = arguments + 1 + fast;
    if (count - fast < 3) return fprintf(stderr, "usage: realtime [--fast] ROBOT.BIN RUN.CSV [TENSIONS.BIN]\n"), 2;
    table log;
    if (const int begun = robot.load(files[0])) return fprintf(stderr, "%s: status %d\n", files[0], begun), 2;
    if (table_read(&log, files[1]) != 0) return 2;
    const int worst = run(robot, log, !fast);
    const size_t differences = table_differences(&log);
    printf("differences %zu\n", differences);
    const bool unwritten = count - fast > 3 && table_write(&log, files[2]) != 0;
    table_free(&log);
    return worst < 0 || worst > CDPR_REPLACED || differences || unwritten;
}
