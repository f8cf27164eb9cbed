// Instance of the model behind both versions of FMI: modes, variables by value reference, snapshots, messages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model.h"

namespace fmu {

enum Status { OK, WARNING, DISCARD, ERROR, FATAL };  // numbered as fmi2Status and fmi3Status

enum { WRITTEN = 1, RETUNED = 2 };

// Categories of messages, with the names of the standard. All except debugging are enabled initially.
enum { TELL_WARNING = 1, TELL_ERROR = 2, TELL_EVENTS = 4, TELL_ALL = 7, TELL_STATUS = TELL_WARNING | TELL_ERROR };

enum Mode { INSTANTIATED = 1, INITIALISING = 2, STEPPING = 4, TERMINATED = 8 };

struct Instance;
typedef void Logger(const Instance* instance, Status status, const char* message);

// The host's part of an instance.
struct Host {
    Logger* log;
    const void* callbacks;  // for `log`
    void* environment;
    const char* name;
    unsigned told;  // enabled categories of messages: bits, as in CATEGORIES
};

struct Instance {
    Host host;
    Model model;
    Mode mode;
    int stale;    // bits: changes since the last computation of the outputs, WRITTEN variables or RETUNED parameters
    bool pushed;  // a cable was required to push in the last step, which is reported once until none is
    double stop;
    double* defaults;  // (model.count) configured numbers, for reset
    char* name;
};

// Complete state of an instance; the numbers (model.count) follow.
struct Snapshot {
    char token[LABEL];  // of its FMU
    int mode, stale, pushed;
    double stop;

    double* numbers() { return reinterpret_cast<double*>(this + 1); }
    const double* numbers() const { return reinterpret_cast<const double*>(this + 1); }
};

// Make an instance from the configuration in the folder `resources`, a path or a file URI. Return nullptr with a
// message on failure or if the model description is of another export.
Instance* instance_new(const Host& host, const char* token, const char* resources);
void instance_free(Instance* instance);

// Category of the standard for messages of a status.
const char* category(Status status);

// Send a message to the host and return the status.
Status report(const Instance* instance, Status status, const char* format, ...);
void report(const Host& host, Status status, const char* message);  // before there is an instance

// Choose the enabled messages: all if no categories are given; those of statuses if logging is off.
Status instance_tell(Instance* instance, bool on, size_t n, const char* const categories[]);

// Return ERROR with a message unless the instance is in one of the modes.
Status require(const Instance* instance, int modes, const char* function);

Status instance_enter_initialisation(Instance* instance, double start, double stop);
Status instance_exit_initialisation(Instance* instance);
Status instance_step(Instance* instance, double from, double duration);
Status instance_reset(Instance* instance);

// Values by value reference: of whole variables one after the other, or one number for each reference.
Status instance_get(Instance* instance, const unsigned* reference, size_t n, bool whole, double* value, size_t count);
Status instance_set(Instance* instance, const unsigned* reference, size_t n, bool whole, const double* value,
                    size_t count);

// Derivatives of outputs along `seed`, one number for each known, as for `instance_get` and `instance_set`.
Status instance_differentiate(Instance* instance, const unsigned* unknown, size_t n_unknown, const unsigned* known,
                              size_t n_known, bool whole, const double* seed, size_t n_seed, double* slope,
                              size_t n_slope);

Status instance_save(const Instance* instance, void** snapshot);
Status instance_restore(Instance* instance, const void* snapshot);
Status instance_size(const Instance* instance, const void* snapshot, size_t* size);
Status instance_serialise(const Instance* instance, const void* snapshot, char* bytes, size_t size);
Status instance_deserialise(const Instance* instance, const char* bytes, size_t size, void** snapshot);

#ifdef CDPR_FAULTS
// Only for tests: return whether the step is done here, with `status`, because the parameter `fault` requires
// misbehaviour.
bool misbehaves(Instance* instance, double from, double duration, Status* status);
#endif

}  // namespace fmu
