// Common part of FMI 2 and FMI 3. SPDX-License-Identifier: Apache-2.0
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

namespace fmu {

static const double CLOCK = 1e-6;  // share of a step by which host and plant may disagree on the time: round-off

static const double MOST_STEPS = 1e9;  // in one step of the host, which would take hours: a typing error in the step

static const char* const CATEGORIES[] = {"logStatusWarning", "logStatusError", "logEvents"};

static int category_of(Status status) { return status == OK ? 2 : status == WARNING ? 0 : 1; }

const char* category(Status status) { return CATEGORIES[category_of(status)]; }

static bool wanted(const Host& host, Status status) { return host.log && (host.told >> category_of(status) & 1); }

Status report(const Instance* instance, Status status, const char* format, ...) {
    char message[2 * MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (wanted(instance->host, status)) instance->host.log(instance, status, message);
    return status;
}

void report(const Host& host, Status status, const char* message) {
    Instance instance = {};
    instance.host = host;
    if (wanted(host, status)) host.log(&instance, status, message);
}

Status require(const Instance* instance, int modes, const char* function) {
    if (instance->mode & modes) return OK;
    return report(instance, ERROR, "%s must not be called now: see the state machine of the FMI standard", function);
}

Status instance_tell(Instance* instance, bool on, size_t n, const char* const categories[]) {
    if (!categories) n = 0;
    unsigned told = on && n > 0 ? 0 : on ? TELL_ALL : TELL_STATUS;
    for (size_t k = 0; on && k < n; k++) {
        unsigned i = 0;
        const char* name = categories[k] ? categories[k] : "";
        while (i < 3 && strcmp(name, CATEGORIES[i]) != 0) i++;
        if (i == 3 && strcmp(name, "logAll") != 0)
            return report(instance, ERROR,
                          "there is no category '%.99s' of messages: see LogCategories in "
                          "modelDescription.xml",
                          name);
        told |= i == 3 ? unsigned(TELL_ALL) : 1u << i;
    }
    instance->host.told = told;
    return OK;
}

static int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

// Write the path of the configuration. FMI 2 passes its folder as a percent-encoded URI, FMI 3 as a path.
static bool locate(const char* resources, char* path) {
    const bool uri = strncmp(resources, "file:", 5) == 0;
    const char* end = "/plant.cfg";
    size_t n = 0;
    if (uri) {
        resources += 5;
        if (strncmp(resources, "//", 2) == 0) {  // a host follows, usually empty, up to the next slash
            resources = strchr(resources + 2, '/');
            if (!resources) return false;
        }
        if (resources[0] == '/' && resources[1] && resources[2] == ':') resources++;  // /C:/...
    }
    for (const char* c = resources; *c; c++) {
        const bool code = uri && c[0] == '%' && digit(c[1]) >= 0 && digit(c[2]) >= 0;
        if (n + strlen(end) + 1 >= PATH) return false;
        path[n++] = code ? (char)(16 * digit(c[1]) + digit(c[2])) : *c;
        if (code) c += 2;
    }
    while (n > 0 && (path[n - 1] == '/' || path[n - 1] == '\\')) n--;
    strcpy(path + n, end);
    return true;
}

static bool configure(Instance* instance, const char* token, const char* resources) {
    char path[PATH], message[MESSAGE];
    if (!resources || !locate(resources, path))
        return report(instance, ERROR, "the host gives no folder with the resources of this FMU") == OK;
    FILE* file = open_file(path);
    if (!file) return report(instance, ERROR, "cannot open %s", path) == OK;
    const bool loaded = load(instance->model, file, message);
    fclose(file);
    if (!loaded) return report(instance, ERROR, "%s", message) == OK;
    if (!token || strcmp(token, instance->model.token) != 0)
        return report(instance, ERROR, "modelDescription.xml and resources/plant.cfg are of different FMUs") == OK;
    if (!start(instance->model, message)) return report(instance, ERROR, "%s", message) == OK;
    return true;
}

Instance* instance_new(const Host& host, const char* token, const char* resources) {
    Instance* instance = static_cast<Instance*>(calloc(1, sizeof(Instance)));
    if (!instance) return nullptr;
    instance->host = host;
    instance->mode = INSTANTIATED;
    instance->stop = INFINITY;
    const char* name = host.name ? host.name : "";
    instance->name = static_cast<char*>(malloc(strlen(name) + 1));
    if (instance->name) {
        strcpy(instance->name, name);
        instance->host.name = instance->name;
    }
    if (instance->name && configure(instance, token, resources)) {
        const size_t bytes = instance->model.count * sizeof(double);
        instance->defaults = static_cast<double*>(malloc(bytes));
        if (instance->defaults) {
            memcpy(instance->defaults, instance->model.number, bytes);
            return instance;
        }
    }
    instance_free(instance);
    return nullptr;
}

void instance_free(Instance* instance) {
    if (!instance) return;
    free_model(instance->model);
    free(instance->defaults);
    free(instance->name);
    free(instance);
}

// Recompute after changes: before the first step the initial state, then outputs.
static Status refresh(Instance* instance) {
    char message[MESSAGE];
    if (!instance->stale) return OK;
    const bool begun = instance->mode & (STEPPING | TERMINATED);
    if (begun && !(instance->stale & RETUNED))
        publish(instance->model);
    else if (begun) {
        if (!retune(instance->model, message)) return report(instance, ERROR, "%s", message);
        report(instance, OK, "other parameters from %.9g s on", *instance->model.field[TIME]);
    } else if (!start(instance->model, message))
        return report(instance, ERROR, "%s", message);
    instance->stale = 0;
    return OK;
}

Status instance_enter_initialisation(Instance* instance, double start, double stop) {
    *instance->model.field[TIME] = start;
    instance->stop = stop;
    instance->mode = INITIALISING;
    return OK;
}

Status instance_exit_initialisation(Instance* instance) {
    const Status status = refresh(instance);
    if (status == OK) instance->mode = STEPPING;
    return status;
}

// WARNING with a message in the first step with commands that require cables to push.
static Status warn_of_pushing(Instance* instance) {
    const Model& model = instance->model;
    const size_t i = fmu::pushed(model);
    const bool pushed = i < model.cables, before = instance->pushed;
    instance->pushed = pushed;
    if (!pushed || before) return OK;
    return report(instance, WARNING,
                  "%s[%zu] is %g N at %.9g s: a cable cannot push, so 0 N acts; no further warning until all "
                  "tensions are at least 0",
                  name_of(model.has_winches() ? COMMAND : CABLE_TENSION), i + 1, model.asked()[i], *model.field[TIME]);
}

// WARNING with a message in the first step in which the cables do not exert the controller's wrench.
static Status warn_of_other_wrench(Instance* instance) {
    const bool now = !answered(instance->model), before = instance->pushed;
    instance->pushed = now;
    if (!now || before) return OK;
    return report(instance, WARNING,
                  "found no tensions within the limits for the controller's wrench before %.9g s; the cables exert "
                  "another wrench; no further warning until tensions are found",
                  *instance->model.field[TIME]);
}

Status instance_step(Instance* instance, double from, double duration) {
    double* time = instance->model.field[TIME];
    const double tolerance = CLOCK * duration;
    if (!(duration > 0.0 && isfinite(duration)))
        return report(instance, ERROR, "a step of %g s was requested: it must be greater than 0", duration);
    if (!(fabs(from - *time) <= tolerance))
        return report(instance, ERROR, "a step from %.17g s was requested, but the plant is at %.17g s", from, *time);
    if (from + duration > instance->stop + tolerance)
        return report(instance, ERROR, "a step to %.17g s goes beyond the stop time %.17g s", from + duration,
                      instance->stop);
    for (int i = 0; i < 2; i++) {
        const Name field = i == 0 ? PHYSICS_STEP : CONTROL_STEP;
        const double* step = instance->model.field[field];
        if (step && duration > MOST_STEPS * *step)
            return report(instance, ERROR, "a step of %g s takes more than %g steps of %s, %g s", duration, MOST_STEPS,
                          name_of(field), *step);
    }
#ifdef CDPR_FAULTS
    Status status;
    if (misbehaves(instance, from, duration, &status)) return status;
#endif
    if ((instance->stale & RETUNED) && refresh(instance) != OK) return ERROR;
    const bool decides = instance->model.decides();
    const Status told = decides ? OK : warn_of_pushing(instance);
    char message[MESSAGE];
    if (!decides) {
        command_drives(instance->model, duration);
        if (!move(instance->model, *time, duration, message)) return report(instance, ERROR, "%s", message);
        count_steps(instance->model);
    } else if (!control(instance->model, *time, duration, message)) {
        return report(instance, ERROR, "%s", message);
    }
    instance->stale = 0;
    *time = from + duration;
    if (!sound(instance->model))
        return report(instance, ERROR,
                      "the state is not finite at %.17g s: an input is not, or a cable has no length, "
                      "or the loop diverges",
                      *time);
    return decides ? warn_of_other_wrench(instance) : told;
}

Status instance_reset(Instance* instance) {
    memcpy(instance->model.number, instance->defaults, instance->model.count * sizeof(double));
    instance->mode = INSTANTIATED;
    instance->stale = 0;
    instance->pushed = false;
    instance->stop = INFINITY;
    return OK;
}

// Variable of a value reference; nullptr with a message if there is none.
static const Variable* find(const Instance* instance, unsigned reference, bool whole) {
    const Model& model = instance->model;
    if (reference < model.scalars) {
        const Variable* variable = model.variable + model.owner[reference];
        if (variable->role != CONSTANT && (!whole || variable->offset == reference)) return variable;
    }
    report(instance, ERROR, "there is no variable with value reference %u", reference);
    return nullptr;
}

Status instance_get(Instance* instance, const unsigned* reference, size_t n, bool whole, double* value, size_t count) {
    size_t done = 0;
    if (refresh(instance) != OK) return ERROR;
    for (size_t i = 0; i < n; i++) {
        const Variable* variable = find(instance, reference[i], whole);
        if (!variable) return ERROR;
        const size_t size = whole ? variable->size : 1;
        if (size > count - done) break;
        memcpy(value + done, instance->model.number + reference[i], size * sizeof *value);
        done += size;
    }
    return done == count
               ? OK
               : report(instance, ERROR, "%zu values were requested, which is not the number of the variables", count);
}

Status instance_set(Instance* instance, const unsigned* reference, size_t n, bool whole, const double* value,
                    size_t count) {
    size_t done = 0;
    for (size_t i = 0; i < n; i++) {
        const Variable* variable = find(instance, reference[i], whole);
        if (!variable) return ERROR;
        const bool now = instance->mode != STEPPING;
        if (variable->role != INPUT && variable->role != PARAMETER && (variable->role != FIXED || !now))
            return report(instance, ERROR,
                          "%s cannot be set now: only inputs and tunable parameters can, and before the "
                          "end of initialization all parameters",
                          variable->name);
        const size_t size = whole ? variable->size : 1;
        if (size > count - done) break;
        memcpy(instance->model.number + reference[i], value + done, size * sizeof *value);
        instance->stale |= variable->role == INPUT ? WRITTEN : RETUNED;
        done += size;
    }
    return done == count
               ? OK
               : report(instance, ERROR, "%zu values were given, which is not the number of the variables", count);
}

// Return whether the standard allows a derivative with respect to a variable, or one of its numbers, now.
static bool known_now(const Instance* instance, const Variable* variable) {
    return variable->role == INPUT || ((instance->mode & (INSTANTIATED | INITIALISING)) &&
                                       (variable->role == PARAMETER || variable->role == FIXED) &&
                                       strcmp(variable->name, name_of(PHYSICS_STEP)) != 0);
}

Status instance_differentiate(Instance* instance, const unsigned* unknown, size_t n_unknown, const unsigned* known,
                              size_t n_known, bool whole, const double* seed, size_t n_seed, double* slope,
                              size_t n_slope) {
    Model& model = instance->model;
    double *along = model.tangent, *result = along + model.scalars;
    size_t given = 0, asked = 0;
    if (!model.has_platform() || model.has_winches() || model.decides() || model.field[LOAD_MASS])
        return report(instance, ERROR, "there are no directional derivatives of winches, controllers and loads");
    if (refresh(instance) != OK) return ERROR;
    memset(along, 0, 2 * model.scalars * sizeof *along);
    for (size_t i = 0; i < n_known; i++) {
        const Variable* variable = find(instance, known[i], whole);
        if (!variable) return ERROR;
        if (!known_now(instance, variable))
            return report(instance, ERROR,
                          "nothing is differentiated with respect to %s now: only with respect to inputs, "
                          "and before the end of initialization parameters",
                          variable->name);
        const size_t size = whole ? variable->size : 1;
        for (size_t k = 0; k < size && given + k < n_seed; k++) along[known[i] + k] += seed[given + k];
        given += size;
    }
    differentiate(model, along, result);
    for (size_t i = 0; i < n_unknown; i++) {
        const Variable* variable = find(instance, unknown[i], whole);
        if (!variable) return ERROR;
        if (variable->role != OUTPUT)
            return report(instance, ERROR, "only outputs are differentiated, not %s", variable->name);
        const size_t size = whole ? variable->size : 1;
        for (size_t k = 0; k < size && asked + k < n_slope; k++) slope[asked + k] = result[unknown[i] + k];
        asked += size;
    }
    if (given == n_seed && asked == n_slope) return OK;
    return report(instance, ERROR, "%zu numbers were given and %zu requested, but the variables have %zu and %zu",
                  n_seed, n_slope, given, asked);
}

static size_t snapshot_size(const Instance* instance) {
    return sizeof(Snapshot) + instance->model.count * sizeof(double);
}

static Status check(const Instance* instance, const Snapshot* snapshot) {
    if (snapshot && memcmp(snapshot->token, instance->model.token, LABEL) == 0) return OK;
    return report(instance, ERROR, "this is not a snapshot of this FMU");
}

Status instance_save(const Instance* instance, void** snapshot) {
    Snapshot* saved =
        static_cast<Snapshot*>(*snapshot);  // the standard allows a host to pass an earlier one to be overwritten
    if (saved && check(instance, saved) != OK) return ERROR;
    if (!saved) saved = static_cast<Snapshot*>(calloc(1, snapshot_size(instance)));
    if (!saved) return report(instance, ERROR, "no memory for a snapshot");
    memcpy(saved->token, instance->model.token, LABEL);
    saved->mode = instance->mode;
    saved->stale = instance->stale;
    saved->pushed = instance->pushed;
    saved->stop = instance->stop;
    memcpy(saved->numbers(), instance->model.number, instance->model.count * sizeof(double));
    *snapshot = saved;
    return OK;
}

Status instance_restore(Instance* instance, const void* snapshot) {
    const Snapshot* saved = static_cast<const Snapshot*>(snapshot);
    if (check(instance, saved) != OK) return ERROR;
    instance->mode = Mode(saved->mode);
    instance->stale = saved->stale;
    instance->pushed = saved->pushed;
    instance->stop = saved->stop;
    memcpy(instance->model.number, saved->numbers(), instance->model.count * sizeof(double));
    return OK;
}

Status instance_size(const Instance* instance, const void* snapshot, size_t* size) {
    *size = snapshot_size(instance);
    return check(instance, static_cast<const Snapshot*>(snapshot));
}

Status instance_serialise(const Instance* instance, const void* snapshot, char* bytes, size_t size) {
    if (check(instance, static_cast<const Snapshot*>(snapshot)) != OK) return ERROR;
    if (size < snapshot_size(instance))
        return report(instance, ERROR, "a snapshot needs more room than %zu bytes", size);
    memcpy(bytes, snapshot, snapshot_size(instance));
    return OK;
}

Status instance_deserialise(const Instance* instance, const char* bytes, size_t size, void** snapshot) {
    // The bytes may have another alignment than a Snapshot; its token comes first.
    if (size != snapshot_size(instance) || memcmp(bytes, instance->model.token, LABEL) != 0)
        return report(instance, ERROR, "these %zu bytes are not a snapshot of this FMU", size);
    *snapshot = malloc(size);
    if (!*snapshot) return report(instance, ERROR, "no memory for a snapshot");
    memcpy(*snapshot, bytes, size);
    return OK;
}

}  // namespace fmu
