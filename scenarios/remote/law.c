/* A controller in C, without cdpr: the weight is carried, and position is held by a spring and a damper.
 * cc -O2 -o law law.c; then `program: remote/law`, with its checksum. A little-endian machine is taken for granted. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KP 100.0 /* 1/s^2 */
#define KD 20.0  /* 1/s */

/* The number, or the first of a list, behind a key of the greeting. */
static double number(const char *line, const char *key, int skip) {
    const char *at = strstr(line, key);
    if (!at) exit(2);
    at += strcspn(at, ":") + 1;
    for (; skip; skip--) at += strcspn(at, ",") + 1;
    return strtod(at + strspn(at, " ["), NULL);
}

int main(void) {
    static char line[1 << 20];
    double in[1024], out[7] = {0};
    if (!fgets(line, sizeof line, stdin)) return 1;
    double mass = number(line, "\"mass\"", 0);
    size_t count = (size_t)number(line, "\"sends\"", 0);
    puts("{\"cdpr\": 1}");
    fflush(stdout);
    while (count <= 1024 && fread(in, sizeof *in, count, stdin) == count) {
        const double *now = in + 2, *desired = in + 15; /* behind the sequence and the time, 13 and 19 numbers */
        out[0] = in[0];
        for (int i = 0; i < 3; i++)
            out[1 + i] = mass * (desired[13 + i] + KP * (desired[i] - now[i]) + KD * (desired[7 + i] - now[7 + i]) -
                                 number(line, "\"gravity\"", i));
        fwrite(out, sizeof *out, 7, stdout);
        fflush(stdout);
    }
    return 0;
}
