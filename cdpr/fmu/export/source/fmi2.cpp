// Functions of FMI 2.0 for co-simulation; unsupported ones return an error. SPDX-License-Identifier: Apache-2.0
#include "fmi2Functions.h"

#include <math.h>
#include <stdlib.h>

#include "instance.h"

using namespace fmu;

static Instance* own(void* instance) { return static_cast<Instance*>(instance); }

#define ANY (INSTANTIATED | INITIALISING | STEPPING | TERMINATED)
#define REQUIRE(modes, function) \
    if (require(own(c), modes, function) != OK) return fmi2Error

static void say(const Instance* instance, Status status, const char* message) {
    const auto* host = static_cast<const fmi2CallbackFunctions*>(instance->host.callbacks);
    if (host->logger)
        host->logger(instance->host.environment, instance->name ? instance->name : instance->host.name,
                     (fmi2Status)status, category(status), "%s", message);
}

const char* fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char* fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    REQUIRE(ANY, "fmi2SetDebugLogging");
    return (fmi2Status)instance_tell(own(c), on != fmi2False, n, categories);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions* functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)visible;
    const unsigned told = logging ? TELL_ALL : TELL_STATUS;
    const Host host = {say, functions, functions->componentEnvironment, name, told};
    if (type != fmi2CoSimulation) {
        report(host, ERROR, "this FMU offers co-simulation only, no model exchange");
        return nullptr;
    }
    return instance_new(host, guid, resources);
}

void fmi2FreeInstance(fmi2Component c) { instance_free(own(c)); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    (void)has_tolerance, (void)tolerance;  // the step is fixed
    REQUIRE(INSTANTIATED, "fmi2SetupExperiment");
    Instance* instance = own(c);
    *instance->model.field[fmu::TIME] = start;
    instance->stop = has_stop ? stop : INFINITY;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    REQUIRE(INSTANTIATED, "fmi2EnterInitializationMode");
    Instance* instance = own(c);
    return (fmi2Status)instance_enter_initialisation(own(instance), *instance->model.field[fmu::TIME], instance->stop);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    REQUIRE(INITIALISING, "fmi2ExitInitializationMode");
    return (fmi2Status)instance_exit_initialisation(own(c));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    REQUIRE(STEPPING, "fmi2Terminate");
    own(c)->mode = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) { return (fmi2Status)instance_reset(own(c)); }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    return (fmi2Status)instance_get(own(c), vr, n, false, value, n);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    REQUIRE(INSTANTIATED | INITIALISING | STEPPING, "fmi2SetReal");
    return (fmi2Status)instance_set(own(c), vr, n, false, value, n);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t nu,
                                        const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[]) {
    REQUIRE(INITIALISING | STEPPING | TERMINATED, "fmi2GetDirectionalDerivative");
    return (fmi2Status)instance_differentiate(own(c), u, nu, k, nk, false, dk, nk, du, nu);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) { return (fmi2Status)instance_save(own(c), state); }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { return (fmi2Status)instance_restore(own(c), state); }

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    (void)c;
    free(*state);
    *state = nullptr;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    return (fmi2Status)instance_size(own(c), state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return (fmi2Status)instance_serialise(own(c), state, bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
    return (fmi2Status)instance_deserialise(own(c), bytes, size, state);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real duration, fmi2Boolean final) {
    (void) final;
    REQUIRE(STEPPING, "fmi2DoStep");
    return (fmi2Status)instance_step(own(c), time, duration);
}

// Steps are never pending.
fmi2Status fmi2CancelStep(fmi2Component c) { return (fmi2Status)require(own(c), 0, "fmi2CancelStep"); }

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = *own(c)->model.field[fmu::TIME];
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;  // this FMU never ends a simulation
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status* value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer* value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String* value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

// Unsupported: other types, derivatives, model exchange. Hosts look up all functions, so they must exist.
static fmi2Status refuse(fmi2Component c, const char* function) {
    return (fmi2Status)report(own(c), ERROR, "%s: this FMU does not offer it; all its variables are of type Real",
                              function);
}

#define UNUSED_TYPE(Type)                                                                                          \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2##Type value[]) {       \
        (void)vr, (void)value;                                                                                     \
        return n == 0 ? fmi2OK : refuse(c, "fmi2Get" #Type);                                                       \
    }                                                                                                              \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2##Type value[]) { \
        (void)vr, (void)value;                                                                                     \
        return n == 0 ? fmi2OK : refuse(c, "fmi2Set" #Type);                                                       \
    }

UNUSED_TYPE(Integer)
UNUSED_TYPE(Boolean)
UNUSED_TYPE(String)

#define REFUSED(name, ...) \
    fmi2Status name(fmi2Component c, __VA_ARGS__) { return refuse(c, #name); }

// Parameters of unsupported functions have no names.
#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
REFUSED(fmi2SetRealInputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], const fmi2Real v[])
REFUSED(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n, const fmi2Integer o[], fmi2Real v[])
REFUSED(fmi2NewDiscreteStates, fmi2EventInfo* info)
REFUSED(fmi2CompletedIntegratorStep, fmi2Boolean final, fmi2Boolean* event, fmi2Boolean* end)
REFUSED(fmi2SetTime, fmi2Real time)
REFUSED(fmi2SetContinuousStates, const fmi2Real x[], size_t n)
REFUSED(fmi2GetDerivatives, fmi2Real x[], size_t n)
REFUSED(fmi2GetEventIndicators, fmi2Real x[], size_t n)
REFUSED(fmi2GetContinuousStates, fmi2Real x[], size_t n)
REFUSED(fmi2GetNominalsOfContinuousStates, fmi2Real x[], size_t n)
fmi2Status fmi2EnterEventMode(fmi2Component c) { return refuse(c, "fmi2EnterEventMode"); }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return refuse(c, "fmi2EnterContinuousTimeMode"); }
