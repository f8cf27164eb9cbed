/* A controller of a point mass as a small FMU, in FMI 2 or 3 as FMI says: proportional, damping, gravity compensation.
   All its variables are scalars, and the value reference is the place among x. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POSITION, VELOCITY = 3, TO_POSITION = 6, TO_VELOCITY = 9, WRENCH = 12, MASS = 18, GRAVITY, KP = 22, KD, MODE, SIZE };
enum { SOUND, ENDS, STANDS_STILL }; /* what MODE says; ENDS after three steps */

typedef struct { double x[SIZE]; int steps; } Controller;

static void compute(Controller *c) {
    for (int i = 0; i < 3; i++) {
        double e = c->x[TO_POSITION + i] - c->x[POSITION + i], de = c->x[TO_VELOCITY + i] - c->x[VELOCITY + i];
        c->x[WRENCH + i] = c->x[MASS] * (c->x[KP] * e + c->x[KD] * de) - c->x[MASS] * c->x[GRAVITY + i];
    }
}
static void start(Controller *c) {
    memset(c, 0, sizeof *c);
    c->x[MASS] = 1.0;
}
static void get(Controller *c, const unsigned *vr, size_t n, double *value) {
    for (size_t i = 0; i < n; i++) value[i] = c->x[vr[i]];
}
static void set(Controller *c, const unsigned *vr, size_t n, const double *value) {
    for (size_t i = 0; i < n; i++) c->x[vr[i]] = value[i];
}

#if FMI == 2
#include "fmi2Functions.h"
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    Controller *c = malloc(sizeof *c);
    start(c);
    functions->logger(functions->componentEnvironment, name, fmi2OK, "", "%s made at %d", name, 7);
    return c;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { start(c); return fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const unsigned *vr, size_t n, double *value) { get(c, vr, n, value); return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const unsigned *vr, size_t n, const double *value) { set(c, vr, n, value); return fmi2OK; }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = kind == fmi2Terminated;
    return fmi2OK;
}
#ifndef WITHOUT_STEP
fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    Controller *c = component;
    compute(c);
    return c->x[MODE] == ENDS && ++c->steps == 3 ? fmi2Discard : fmi2OK;
}
#endif
#else
#include "fmi3Functions.h"
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference *needed, size_t n, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    Controller *c = malloc(sizeof *c);
    start(c);
    log(environment, fmi3OK, "", "made");
    return c;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 d, fmi3Boolean e, fmi3Float64 f) { return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) { start(c); return fmi3OK; }
fmi3Status fmi3GetFloat64(fmi3Instance c, const unsigned *vr, size_t n, double *value, size_t m) { get(c, vr, n, value); return fmi3OK; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const unsigned *vr, size_t n, const double *value, size_t m) { set(c, vr, n, value); return fmi3OK; }
#ifndef WITHOUT_STEP
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    Controller *c = instance;
    compute(c);
    *event = *early = false;
    *terminate = c->x[MODE] == ENDS && ++c->steps == 3;
    *reached = c->x[MODE] == STANDS_STILL ? time : time + step;
    return fmi3OK;
}
#endif
#endif
