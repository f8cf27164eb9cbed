/* States, desired motion and tensions of a run's log, as `cdpr export RUN --to csv` writes them.
   SPDX-License-Identifier: Apache-2.0 */
#ifndef TABLE_H
#define TABLE_H

#include <robot.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double time;
    double state[CDPR_STATE];
    double desired[CDPR_DESIRED]; /* not read by the programs, which compute it */
    double wrench[6];
    double tensions[CDPR_CABLES];
} row;

typedef struct {
    row* rows;
    double* tensions; /* (count, CDPR_CABLES), for the program's own */
    size_t count;
} table;

/* Read a CSV file; allocates, so call it before the cycle. Return 0, or -1 after a message. */
int table_read(table* read, const char* path);

/* Write the program's tensions as raw doubles. Return 0, or -1 after a message. */
int table_write(const table* written, const char* path);

/* Return the number of tensions whose bits differ from the log's. */
size_t table_differences(const table* compared);

void table_free(table* freed);

/* Read a file of `bytes` bytes into a buffer. Return 0, or -1 after a message. */
int file_read(const char* path, void* buffer, size_t bytes);

#ifdef __cplusplus
}
#endif
#endif
