/* A host without Python: loads the library of an exported FMU, steps it under fixed tensions and prints the state.

   host LIBRARY TOKEN RESOURCES FMI STEPS STEP CABLES TENSION FORCE POSITION
   The last three are value references, in FMI 3 of arrays; the moment follows the force. */
#ifdef _WIN32
#include <windows.h>
#define dlopen(path, flags) ((void *)LoadLibraryA(path))
#define dlsym(handle, name) ((void *)GetProcAddress(handle, name))
#define dlclose(handle) FreeLibrary(handle)
#define dlerror() "the library or one of its functions is missing"
#else
#include <dlfcn.h>
#endif
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

static void *library;

static void *find(const char *name) {
    void *found = dlsym(library, name);
    if (!found) fprintf(stderr, "%s\n", dlerror()), exit(1);
    return found;
}

static void require(int status, const char *what) {
    if (status != 0) fprintf(stderr, "%s returns %d\n", what, status), exit(1);
}

static void say2(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String format, ...) {
    (void)e, (void)n, (void)s, (void)c;
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void say3(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String message) {
    (void)e, (void)s, (void)c;
    fprintf(stderr, "%s\n", message);
}

#define CALL(name) (*(name##TYPE *)find(#name))
#define MOST 64

static double inputs[MOST], state[13];
static unsigned reference[MOST];

static void print(void) {
    for (int i = 0; i < 13; i++) printf("%.17g\n", state[i]);
}

static void run2(char **a, int steps, double h, unsigned m, unsigned tension, unsigned wrench, unsigned position) {
    fmi2CallbackFunctions callbacks = {say2, calloc, free, NULL, NULL};
    fmi2Component c = CALL(fmi2Instantiate)("host", fmi2CoSimulation, a[2], a[3], &callbacks, 0, 1);
    if (!c) exit(2);
    require(CALL(fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0), "setup");
    require(CALL(fmi2EnterInitializationMode)(c), "enter");
    require(CALL(fmi2ExitInitializationMode)(c), "exit");
    for (unsigned i = 0; i < m; i++) reference[i] = tension + i;
    for (unsigned i = 0; i < 6; i++) reference[m + i] = wrench + i;
    fmi2FMUstate saved = NULL;
    for (int k = 0; k < steps; k++) {
        if (k == steps / 2) require(CALL(fmi2GetFMUstate)(c, &saved), "save");
        require(CALL(fmi2SetReal)(c, reference, m + 6, inputs), "set");
        require(CALL(fmi2DoStep)(c, k * h, h, 1), "step");
    }
    size_t size = 0;
    require(CALL(fmi2SerializedFMUstateSize)(c, saved, &size), "size");
    char *bytes = malloc(size + 1); /* and not aligned */
    require(CALL(fmi2SerializeFMUstate)(c, saved, bytes + 1, size), "serialise");
    require(CALL(fmi2FreeFMUstate)(c, &saved), "free");
    require(CALL(fmi2DeSerializeFMUstate)(c, bytes + 1, size, &saved), "deserialise");
    require(CALL(fmi2SetFMUstate)(c, saved), "restore");
    require(CALL(fmi2FreeFMUstate)(c, &saved), "free");
    free(bytes);
    for (int k = steps / 2; k < steps; k++) require(CALL(fmi2DoStep)(c, k * h, h, 1), "step");
    for (unsigned i = 0; i < 13; i++) reference[i] = position + i; /* the outputs of a state stand side by side */
    require(CALL(fmi2GetReal)(c, reference, 13, state), "get");
    print();
    require(CALL(fmi2Terminate)(c), "terminate");
    require(CALL(fmi2Reset)(c), "reset");
    CALL(fmi2FreeInstance)(c);
}

static void run3(char **a, int steps, double h, unsigned m, unsigned tension, unsigned wrench, unsigned position) {
    fmi3Instance c = CALL(fmi3InstantiateCoSimulation)("host", a[2], a[3], false, true, false, false, NULL, 0, NULL, say3,
                                                       NULL);
    if (!c) exit(2);
    require(CALL(fmi3EnterInitializationMode)(c, false, 0.0, 0.0, false, 0.0), "enter");
    require(CALL(fmi3ExitInitializationMode)(c), "exit");
    const unsigned in[] = {tension, wrench, wrench + 3}, out[] = {position, position + 3, position + 7, position + 10};
    fmi3FMUState saved = NULL;
    bool event, end, early;
    double last;
    for (int k = 0; k < steps; k++) {
        if (k == steps / 2) require(CALL(fmi3GetFMUState)(c, &saved), "save");
        require(CALL(fmi3SetFloat64)(c, in, 3, inputs, m + 6), "set");
        require(CALL(fmi3DoStep)(c, k * h, h, true, &event, &end, &early, &last), "step");
    }
    require(CALL(fmi3SetFMUState)(c, saved), "restore");
    require(CALL(fmi3FreeFMUState)(c, &saved), "free");
    for (int k = steps / 2; k < steps; k++)
        require(CALL(fmi3DoStep)(c, k * h, h, true, &event, &end, &early, &last), "step");
    if (fabs(last - steps * h) > 1e-9) exit(3);
    require(CALL(fmi3GetFloat64)(c, out, 4, state, 13), "get");
    print();
    /* What is wrong must be told, not followed. */
    const unsigned beyond[] = {4000000000u};
    if (CALL(fmi3GetFloat64)(c, beyond, 1, state, 1) != fmi3Error) exit(4);
    if (CALL(fmi3GetFloat64)(c, out, 4, state, 12) != fmi3Error) exit(5);
    if (CALL(fmi3SetFloat64)(c, out, 1, state, 3) != fmi3Error) exit(6);
    require(CALL(fmi3Terminate)(c), "terminate");
    CALL(fmi3FreeInstance)(c);
}

int main(int n, char **a) {
    if (n != 11) return 1;
    library = dlopen(a[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 1;
    const unsigned m = (unsigned)atoi(a[7]);
    if (m + 6 > MOST) return 1;
    for (unsigned i = 0; i < m; i++) inputs[i] = 200.0 + 10.0 * i;
    for (unsigned i = 0; i < 6; i++) inputs[m + i] = 1.0 + i;
    (strcmp(a[4], "2") == 0 ? run2 : run3)(a, atoi(a[5]), atof(a[6]), m, (unsigned)atoi(a[8]), (unsigned)atoi(a[9]),
                                           (unsigned)atoi(a[10]));
    dlclose(library);
    return 0;
}
