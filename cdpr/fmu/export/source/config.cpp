// Reader of resources/plant.cfg, which the exporter writes. SPDX-License-Identifier: Apache-2.0
//
// A header, then one line for each variable, array, link and operation:
//
//   role name unit reference size numbers...
//   name constant|memory|work size words...          (none for work)
//   reference size array offset positive per_step
//   name in_order vital skip repair count members...  (a member: "value word" or "array index offset")
//
// A number is 16 hexadecimal digits, the bits of its IEEE 754 representation: exact in any locale. So is a word, which
// may also be an integer.
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cdpr/mechanics/plant.hpp>

#include "model.h"

namespace cdpr::CDPR_TARGET {
extern const cdpr_group operations;  // operations.cpp
}  // namespace cdpr::CDPR_TARGET

namespace fmu {

static const char* const ROLES[] = {"independent", "parameter", "fixed", "input", "output", "constant"};

bool fails(char* message, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, MESSAGE, format, arguments);
    va_end(arguments);
    return false;
}

bool broken(char* message, const char* what, const char* name) {
    return fails(message, "resources/plant.cfg: %s '%.99s'; it belongs to another version of this library", what, name);
}

// Zeroed memory; nullptr if there is none.
template <class T> static T* allocate(size_t count) { return static_cast<T*>(calloc(count ? count : 1, sizeof(T))); }

static bool read_word(FILE* file, void* word) {
    uint64_t bits;
    if (fscanf(file, "%" SCNx64, &bits) != 1) return false;
    memcpy(word, &bits, sizeof bits);
    return true;
}

static bool read_words(FILE* file, double* words, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!read_word(file, words + i)) return false;
    return true;
}

// Return whether a variable has this name, or is the first of variables for its numbers, such as command[1].
static bool is_named(const char* variable, const char* name) {
    const size_t length = strlen(name);
    return strncmp(variable, name, length) == 0 && (!variable[length] || strcmp(variable + length, "[1]") == 0);
}

static Name find_name(const char* name) {
    int found = 0;
    while (found < NAMES && !is_named(name, name_of(Name(found)))) found++;
    return Name(found);
}

// Read one line; its numbers begin at `next`, which is advanced.
static bool read_variable(Model& model, FILE* file, size_t index, size_t& next, char* message) {
    Variable& variable = model.variable[index];
    char role[16] = "";
    if (fscanf(file, "%15s %63s %63s %zu %zu", role, variable.name, variable.unit, &variable.offset, &variable.size) !=
        5)
        return broken(message, "broken after", index ? model.variable[index - 1].name : "its head");
    int found = 0;
    while (found <= CONSTANT && strcmp(role, ROLES[found]) != 0) found++;
    if (found > CONSTANT) return broken(message, "unknown role", role);
    variable.role = Role(found);
    if (variable.offset != next || variable.size > model.scalars - next)
        return broken(message, "wrong place of", variable.name);
    const Name name = find_name(variable.name);
    if (name < NAMES) {
        if (model.field[name]) return broken(message, "repeated variable", variable.name);
        model.field[name] = model.number + next;
    }
    for (size_t i = 0; i < variable.size; i++) model.owner[next + i] = index;
    if (!read_words(file, model.number + next, variable.size)) return broken(message, "no value of", variable.name);
    next += variable.size;
    return true;
}

// Read one line; its numbers begin at `next` or, for work space, at `spare`.
static bool read_array(Model& model, FILE* file, Array& array, size_t& next, size_t& spare, char* message) {
    char kind[16] = "";
    if (fscanf(file, "%63s %15s %zu", array.name, kind, &array.size) != 3) return broken(message, "broken", "arrays");
    const bool work = strcmp(kind, "work") == 0;
    size_t& place = work ? spare : next;
    if (array.size > (work ? model.work_count : model.count) - place)
        return broken(message, "wrong size of", array.name);
    array.data = (work ? model.work : model.number) + place;
    place += array.size;
    if (!work && !read_words(file, array.data, array.size)) return broken(message, "no value of", array.name);
    return true;
}

static bool read_link(const Model& model, FILE* file, Link& link, char* message) {
    int positive, per_step;
    if (fscanf(file, "%zu %zu %zu %zu %d %d", &link.from, &link.size, &link.array, &link.to, &positive, &per_step) != 6)
        return broken(message, "broken", "links");
    link.positive = positive != 0;
    link.per_step = per_step != 0;
    if (link.from > model.scalars || link.size > model.scalars - link.from || link.array >= model.arrays)
        return broken(message, "wrong source of", "a link");
    const Array& array = model.array[link.array];
    if (link.to > array.size || link.size > array.size - link.to) return broken(message, "wrong target of", "a link");
    return true;
}

static const cdpr_entry* find_entry(const char* name) {
    const cdpr_group& known = cdpr::operations;
    for (int64_t i = 0; i < known.count; i++)
        if (strcmp(known.entries[i].name, name) == 0) return known.entries + i;
    return nullptr;
}

// Read one member of an operation's struct.
static bool read_member(const Model& model, FILE* file, char* member) {
    char kind[16] = "";
    size_t index, offset;
    if (fscanf(file, "%15s", kind) != 1) return false;
    if (strcmp(kind, "value") == 0) return read_word(file, member);
    if (fscanf(file, "%zu %zu", &index, &offset) != 2) return false;
    if (index >= model.arrays || offset > model.array[index].size) return false;
    const int64_t address = int64_t(intptr_t(model.array[index].data + offset));
    memcpy(member, &address, sizeof address);
    return true;
}

static bool read_operation(const Model& model, FILE* file, cdpr::Call& operation, char* message) {
    char name[LABEL] = "";
    int in_order, vital;
    size_t count;
    if (fscanf(file, "%63s %d %d %zu %d %zu", name, &in_order, &vital, &operation.skip, &operation.repair, &count) != 6)
        return broken(message, "broken", "operations");
    const cdpr_entry* entry = find_entry(name);
    if (!entry || int64_t(count) != entry->count) return broken(message, "unknown operation", name);
    if (operation.repair >= int(model.operations)) return broken(message, "wrong repair of", name);
    operation.operation = entry->call;
    operation.in_order = in_order != 0;
    operation.vital = cdpr::Vital(vital);
    char* place = allocate<char>(8 * count);
    operation.place = place;
    if (!place) return broken(message, "no memory for", name);
    for (size_t i = 0; i < count; i++)
        if (!read_member(model, file, place + 8 * i)) return broken(message, "broken operation", name);
    return true;
}

// Parts of one block of memory; without memory, only their sizes are added.
struct Block {
    double* start;
    size_t used;

    double* take(size_t count) {
        double* place = start ? start + used : nullptr;
        used += count;
        return place;
    }
};

static void lay_out(Model& model, Block& numbers, Block& work) {
    const size_t m = model.cables;
    Platform& platform = model.platform;
    Scratch& scratch = model.scratch;
    model.decisions = numbers.take(1);
    model.began = numbers.take(1);
    model.winch = platform.winch = numbers.take(model.states);
    platform.offset = numbers.take(7);
    platform.moments = numbers.take(4);
    platform.inertial = numbers.take(13);
    platform.packed = numbers.take(21);
    platform.free = numbers.take(6);
    platform.lines = numbers.take(m * model.width);
    platform.command = numbers.take(m);
    platform.external = numbers.take(6);
    platform.body = numbers.take(13);
    platform.momentum = numbers.take(3);
    platform.motion = numbers.take(8);
    platform.state = numbers.take(13);
    platform.tension = numbers.take(m);
    platform.highest = numbers.take(m);
    platform.length = numbers.take(m);
    platform.cable_work = numbers.take(1);
    platform.beside = numbers.take(6);
    platform.place = numbers.take(7);
    platform.rates = numbers.take(m);
    platform.period = numbers.take(1);
    platform.counted = numbers.take(m);
    platform.issued = numbers.take(m);
    platform.lost = numbers.take(m);
    platform.powered = numbers.take(m);
    platform.total = numbers.take(13);
    platform.loaded_at = numbers.take(1);
    model.nominal = numbers.take(13);
    scratch.rate = work.take(m);
    scratch.matrix = work.take(6 * m);
    scratch.at_winch = work.take(m);
    scratch.runs = work.take(size_t(cdpr::CableRun<double>::COUNT) * m);
    scratch.light = work.take(m);
    scratch.mass = work.take(m);
    scratch.pulls = work.take(m);
    scratch.points = work.take(4 * (model.states + 14));
    scratch.applied = work.take(6);
    scratch.chains = work.take(size_t(cdpr::ChainRow<double>::WIDTH) * m);
    scratch.unwound = work.take(m);
    scratch.unwinding = work.take(m);
    scratch.torque = work.take(m);
    scratch.body = work.take(13);
    scratch.winch = work.take(model.states);
    scratch.tension = work.take(m);
    scratch.highest = work.take(m);
    scratch.length = work.take(m);
    scratch.cable_work = work.take(1);
    scratch.beside = work.take(6);
    scratch.place = work.take(7);
}

static bool allocate_all(Model& model, size_t array_numbers, size_t array_work) {
    Block numbers = {nullptr, 0}, work = {nullptr, 0};
    lay_out(model, numbers, work);
    model.count = model.scalars + array_numbers + numbers.used;
    model.work_count = array_work + work.used;
    model.variable = allocate<Variable>(model.variables);
    model.owner = allocate<size_t>(model.scalars);
    model.array = allocate<Array>(model.arrays);
    model.link = allocate<Link>(model.links);
    model.operation = allocate<cdpr::Call>(model.operations);
    model.number = allocate<double>(model.count);
    model.work = allocate<double>(model.work_count);
    model.kinds = allocate<int64_t>(3 * model.cables);
    model.takes = allocate<int64_t>(model.cables);
    model.places = allocate<int64_t>(model.cables + 1);
    model.tangent = allocate<double>(2 * model.scalars);
    model.dual = allocate<double>(dual_size(model));
    if (!model.variable || !model.owner || !model.array || !model.link || !model.operation || !model.number ||
        !model.work || !model.kinds || !model.takes || !model.places || !model.tangent || !model.dual)
        return false;
    numbers = {model.number + model.scalars + array_numbers, 0};
    work = {model.work + array_work, 0};
    lay_out(model, numbers, work);
    return true;
}

bool load(Model& model, FILE* file, char* message) {
    const size_t most = 4000000;  // numbers: far above 256 cables
    size_t array_numbers, array_work;
    memset(static_cast<void*>(&model), 0, sizeof model);
    if (fscanf(file,
               "cdpr-plant 3 token %63s cables %zu width %zu states %zu variables %zu numbers %zu arrays %zu %zu %zu "
               "links %zu operations %zu",
               model.token, &model.cables, &model.width, &model.states, &model.variables, &model.scalars, &model.arrays,
               &array_numbers, &array_work, &model.links, &model.operations) != 11)
        return broken(message, "wrong head, token", model.token);
    const size_t sizes[] = {model.cables,  model.states, model.variables, model.scalars,   model.arrays,
                            array_numbers, array_work,   model.links,     model.operations};
    for (size_t size : sizes)
        if (size > most || model.width > 100) return broken(message, "wrong head, token", model.token);
    if (model.cables == 0 || model.scalars == 0) return broken(message, "wrong head, token", model.token);
    if (!allocate_all(model, array_numbers, array_work)) return broken(message, "no memory for", "numbers");
    size_t next = 0, spare = 0;
    for (size_t i = 0; i < model.variables; i++)
        if (!read_variable(model, file, i, next, message)) return false;
    if (next != model.scalars) return broken(message, "fewer values than", "numbers");
    for (size_t i = 0; i < model.arrays; i++)
        if (!read_array(model, file, model.array[i], next, spare, message)) return false;
    if (next != model.scalars + array_numbers || spare != array_work)
        return broken(message, "other values than", "arrays");
    for (size_t i = 0; i < model.links; i++)
        if (!read_link(model, file, model.link[i], message)) return false;
    for (size_t i = 0; i < model.operations; i++)
        if (!read_operation(model, file, model.operation[i], message)) return false;
    return complete(model, message);
}

void free_model(Model& model) {
    for (size_t i = 0; model.operation && i < model.operations; i++) free(model.operation[i].place);
    free(model.variable);
    free(model.owner);
    free(model.array);
    free(model.link);
    free(model.operation);
    free(model.number);
    free(model.work);
    free(model.kinds);
    free(model.takes);
    free(model.places);
    free(model.tangent);
    free(model.dual);
    memset(static_cast<void*>(&model), 0, sizeof model);
}

}  // namespace fmu
