// Functions of FMI 3.0 for co-simulation; unsupported ones return an error. SPDX-License-Identifier: Apache-2.0
#include "fmi3Functions.h"

#include <math.h>
#include <stdlib.h>

#include "instance.h"

using namespace fmu;

static Instance* own(void* instance) { return static_cast<Instance*>(instance); }

#define ANY (INSTANTIATED | INITIALISING | STEPPING | TERMINATED)
#define REQUIRE(modes, function) \
    if (require(own(instance), modes, function) != OK) return fmi3Error

static void say(const Instance* instance, Status status, const char* message) {
    const auto log = reinterpret_cast<fmi3LogMessageCallback>(const_cast<void*>(instance->host.callbacks));
    if (log) log(instance->host.environment, (fmi3Status)status, category(status), message);
}

const char* fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    REQUIRE(ANY, "fmi3SetDebugLogging");
    return (fmi3Status)instance_tell(own(instance), on, n, categories);
}

static const void* callback(fmi3LogMessageCallback log) { return reinterpret_cast<const void*>(log); }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[], size_t n_intermediate,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)visible, (void)early_return, (void)intermediate, (void)n_intermediate, (void)update;
    const unsigned told = logging ? TELL_ALL : TELL_STATUS;
    const Host host = {say, callback(log), environment, name, told};
    if (event_mode) {
        report(host, ERROR, "this FMU has no event mode: instantiate it with eventModeUsed = false");
        return nullptr;
    }
    return instance_new(host, token, resources);
}

void fmi3FreeInstance(fmi3Instance instance) { instance_free(own(instance)); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    (void)has_tolerance, (void)tolerance;  // the step is fixed
    REQUIRE(INSTANTIATED, "fmi3EnterInitializationMode");
    return (fmi3Status)instance_enter_initialisation(own(instance), start, has_stop ? stop : INFINITY);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    REQUIRE(INITIALISING, "fmi3ExitInitializationMode");
    return (fmi3Status)instance_exit_initialisation(own(instance));
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    REQUIRE(STEPPING, "fmi3Terminate");
    own(instance)->mode = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance) { return (fmi3Status)instance_reset(own(instance)); }

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                          size_t count) {
    return (fmi3Status)instance_get(own(instance), vr, n, true, values, count);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t count) {
    REQUIRE(INSTANTIATED | INITIALISING | STEPPING, "fmi3SetFloat64");
    return (fmi3Status)instance_set(own(instance), vr, n, true, values, count);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference u[], size_t nu,
                                        const fmi3ValueReference k[], size_t nk, const fmi3Float64 seed[], size_t ns,
                                        fmi3Float64 sensitivity[], size_t n) {
    REQUIRE(INITIALISING | STEPPING | TERMINATED, "fmi3GetDirectionalDerivative");
    return (fmi3Status)instance_differentiate(own(instance), u, nu, k, nk, true, seed, ns, sensitivity, n);
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
    return (fmi3Status)instance_save(own(instance), state);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    return (fmi3Status)instance_restore(own(instance), state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
    (void)instance;
    free(*state);
    *state = nullptr;
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
    return (fmi3Status)instance_size(own(instance), state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return (fmi3Status)instance_serialise(own(instance), state, (char*)bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
    return (fmi3Status)instance_deserialise(own(instance), (const char*)bytes, size, state);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 duration, fmi3Boolean final,
                      fmi3Boolean* event, fmi3Boolean* end, fmi3Boolean* early, fmi3Float64* last) {
    (void) final;
    REQUIRE(STEPPING, "fmi3DoStep");
    const Status status = instance_step(own(instance), time, duration);
    *event = *end = *early = fmi3False;
    *last = *own(instance)->model.field[fmu::TIME];
    return (fmi3Status)status;
}

// Unsupported: other types, derivatives, clocks, other interfaces. Hosts look up all functions, so they must exist.
static fmi3Status refuse(fmi3Instance instance, const char* function) {
    return (fmi3Status)report(own(instance), ERROR,
                              "%s: this FMU does not offer it; it has variables of type Float64 only", function);
}

#define UNUSED_TYPE(Type)                                                                                         \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3##Type values[], \
                             size_t count) {                                                                      \
        (void)vr, (void)values, (void)count;                                                                      \
        return n == 0 ? fmi3OK : refuse(instance, "fmi3Get" #Type);                                               \
    }                                                                                                             \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,                      \
                             const fmi3##Type values[], size_t count) {                                           \
        (void)vr, (void)values, (void)count;                                                                      \
        return n == 0 ? fmi3OK : refuse(instance, "fmi3Set" #Type);                                               \
    }

UNUSED_TYPE(Float32)
UNUSED_TYPE(Int8)
UNUSED_TYPE(UInt8)
UNUSED_TYPE(Int16)
UNUSED_TYPE(UInt16)
UNUSED_TYPE(Int32)
UNUSED_TYPE(UInt32)
UNUSED_TYPE(Int64)
UNUSED_TYPE(UInt64)
UNUSED_TYPE(Boolean)
UNUSED_TYPE(String)

#define REFUSED(name, ...) \
    fmi3Status name(fmi3Instance instance, __VA_ARGS__) { return refuse(instance, #name); }
#define REFUSED_PLAIN(name) \
    fmi3Status name(fmi3Instance instance) { return refuse(instance, #name); }
#define REFUSED_INSTANCE(name, ...)                                                                     \
    fmi3Instance name(fmi3String instance, fmi3String token, fmi3String resources, fmi3Boolean visible, \
                      fmi3Boolean logging, fmi3InstanceEnvironment environment, __VA_ARGS__) {          \
        return nullptr;                                                                                 \
    }

#ifdef __GNUC__  // unsupported functions use no parameters
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
typedef const fmi3ValueReference* References;
typedef fmi3Boolean* Booleans;
typedef const fmi3Float64* Constants;

REFUSED_INSTANCE(fmi3InstantiateModelExchange, fmi3LogMessageCallback log)
REFUSED_INSTANCE(fmi3InstantiateScheduledExecution, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                 fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
REFUSED(fmi3GetBinary, References vr, size_t n, size_t sizes[], fmi3Binary values[], size_t count)
REFUSED(fmi3SetBinary, References vr, size_t n, const size_t sizes[], const fmi3Binary values[], size_t count)
REFUSED(fmi3GetClock, References vr, size_t n, fmi3Clock values[])
REFUSED(fmi3SetClock, References vr, size_t n, const fmi3Clock values[])
REFUSED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t* n)
REFUSED(fmi3GetVariableDependencies, fmi3ValueReference vr, size_t element[], fmi3ValueReference independent[],
        size_t elements[], fmi3DependencyKind kinds[], size_t n)
REFUSED(fmi3GetAdjointDerivative, References u, size_t nu, References k, size_t nk, Constants seed, size_t ns,
        fmi3Float64 sensitivity[], size_t n)
REFUSED(fmi3GetIntervalDecimal, References vr, size_t n, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
REFUSED(fmi3GetIntervalFraction, References vr, size_t n, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
        fmi3IntervalQualifier qualifiers[])
REFUSED(fmi3GetShiftDecimal, References vr, size_t n, fmi3Float64 shifts[])
REFUSED(fmi3GetShiftFraction, References vr, size_t n, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSED(fmi3SetIntervalDecimal, References vr, size_t n, Constants intervals)
REFUSED(fmi3SetIntervalFraction, References vr, size_t n, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSED(fmi3SetShiftDecimal, References vr, size_t n, Constants shifts)
REFUSED(fmi3SetShiftFraction, References vr, size_t n, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSED(fmi3UpdateDiscreteStates, Booleans again, Booleans end, Booleans nominals, Booleans values, Booleans next,
        fmi3Float64* time)
REFUSED(fmi3CompletedIntegratorStep, fmi3Boolean final, Booleans event, Booleans end)
REFUSED(fmi3SetTime, fmi3Float64 time)
REFUSED(fmi3SetContinuousStates, Constants x, size_t n)
REFUSED(fmi3GetContinuousStateDerivatives, fmi3Float64 x[], size_t n)
REFUSED(fmi3GetEventIndicators, fmi3Float64 x[], size_t n)
REFUSED(fmi3GetContinuousStates, fmi3Float64 x[], size_t n)
REFUSED(fmi3GetNominalsOfContinuousStates, fmi3Float64 x[], size_t n)
REFUSED(fmi3GetNumberOfEventIndicators, size_t* n)
REFUSED(fmi3GetNumberOfContinuousStates, size_t* n)
REFUSED(fmi3GetOutputDerivatives, References vr, size_t n, const fmi3Int32 orders[], fmi3Float64 values[], size_t count)
REFUSED(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
REFUSED_PLAIN(fmi3EnterConfigurationMode)
REFUSED_PLAIN(fmi3ExitConfigurationMode)
REFUSED_PLAIN(fmi3EnterEventMode)
REFUSED_PLAIN(fmi3EnterContinuousTimeMode)
REFUSED_PLAIN(fmi3EnterStepMode)
REFUSED_PLAIN(fmi3EvaluateDiscreteStates)
