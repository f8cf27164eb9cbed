/* SPDX-License-Identifier: Apache-2.0 */
#include "table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE = 65536, COLUMNS = sizeof(row) / sizeof(double), TENSION = COLUMNS - CDPR_CABLES };

static int fail(const char *path, const char *message) {
    fprintf(stderr, "%s: %s\n", path, message);
    return -1;
}

/* Check that the columns are those of a row. */
static int check_heading(char *line) {
    size_t column = 0;
    for (char *name = strtok(line, ",\r\n"); name; name = strtok(NULL, ",\r\n"), column++) {
        const char *expected = column == 0    ? "t"
                               : column == 1  ? "position_x"
                               : column == 14 ? "desired_position_x"
                                              : "";
        if (column >= TENSION && column < COLUMNS) expected = "tension_";
        if (column == COLUMNS) expected = "length_";
        if (strncmp(name, expected, strlen(expected)) != 0) return -1;
    }
    return column >= COLUMNS ? 0 : -1;
}

static int parse_row(const char *line, row *parsed) {
    double values[COLUMNS];
    for (size_t column = 0; column < COLUMNS; column++) {
        char *end;
        values[column] = strtod(line, &end);
        if (end == line || (*end != ',' && column + 1 < COLUMNS)) return -1;
        line = end + 1;
    }
    memcpy(parsed, values, sizeof values);
    return 0;
}

static int append(table *read, size_t *room, const row *appended) {
    if (read->count == *room) {
        *room = *room ? 2 * *room : 1024;
        row *grown = realloc(read->rows, *room * sizeof *grown);
        if (!grown) return -1;
        read->rows = grown;
    }
    read->rows[read->count++] = *appended;
    return 0;
}

int table_read(table *read, const char *path) {
    static char line[LINE];
    memset(read, 0, sizeof *read);
    FILE *file = fopen(path, "r");
    if (!file) return fail(path, "cannot be opened");
    int failed = !fgets(line, sizeof line, file) || check_heading(line) != 0;
    if (failed) fail(path, "expected the columns of a run of this robot (cdpr export RUN --to csv)");
    size_t room = 0;
    row parsed;
    while (!failed && fgets(line, sizeof line, file)) {
        failed = parse_row(line, &parsed) != 0 || append(read, &room, &parsed) != 0;
        if (failed) fail(path, "expected numbers in each row");
    }
    fclose(file);
    read->tensions = calloc(read->count ? read->count : 1, CDPR_CABLES * sizeof(double));
    if (failed || !read->tensions) table_free(read);
    return read->rows ? 0 : -1;
}

int table_write(const table *written, const char *path) {
    const size_t count = written->count * CDPR_CABLES;
    FILE *file = fopen(path, "wb");
    if (!file) return fail(path, "cannot be opened");
    const int whole = fwrite(written->tensions, sizeof(double), count, file) == count;
    return fclose(file) == 0 && whole ? 0 : fail(path, "cannot be written");
}

size_t table_differences(const table *compared) {
    size_t differences = 0;
    for (size_t k = 0; k < compared->count; k++)
        for (size_t i = 0; i < CDPR_CABLES; i++)
            differences += memcmp(&compared->tensions[k * CDPR_CABLES + i], &compared->rows[k].tensions[i], 8) != 0;
    return differences;
}

void table_free(table *freed) {
    free(freed->rows);
    free(freed->tensions);
    memset(freed, 0, sizeof *freed);
}

int file_read(const char *path, void *buffer, size_t bytes) {
    FILE *file = fopen(path, "rb");
    if (!file) return fail(path, "cannot be opened");
    const size_t found = fread(buffer, 1, bytes, file);
    const int longer = fgetc(file) != EOF;
    fclose(file);
    return found == bytes && !longer ? 0 : fail(path, "is not of the size in robot.h");
}
