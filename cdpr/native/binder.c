/* Python module of the kernel library: tables and bound operations. SPDX-License-Identifier: Apache-2.0

   bind.py checks the arrays and packs the struct; what is bound here is called without arguments, or with the time. */
#ifdef CDPR_WITH_PYTHON_H
#define Py_LIMITED_API 0x030b0000
#include <Python.h>
#include <structmember.h>
#else
#include "stable_abi.h"
#endif
#include <string.h>

#ifndef CDPR_SOURCES /* digest of the sources, which CMakeLists.txt computes */
#define CDPR_SOURCES ""
#endif

#include "dispatch.h"

#ifdef __clang__
#define COMPILER __VERSION__
#else
#define COMPILER "GCC " __VERSION__
#endif

enum { MOST = 8, SIZE = 1024 }; /* of `on`: arrays, and bytes of the struct */
enum { FILLED = 64 };           /* of `fill`: arrays */

typedef struct {
    PyObject_HEAD
    cdpr_operation operation;
    const cdpr_entry *entry;
    const char *name;
    void *place; /* the struct; owned */
    int64_t size;
    PyObject *given;  /* the arguments by name */
    PyObject *arrays; /* kept alive, for the struct holds their addresses */
    Py_ssize_t
        known; /* of the arrays that `on` has replaced: how many, where they are in the struct, and their shapes */
    char positions[MOST];
    Py_buffer expected[MOST];
} Bound;

/* Return the operation at an address, NULL if this processor has no such one. */
static const cdpr_entry *entry_at(unsigned long long address) {
    const cdpr_table *found[CDPR_TARGETS];
    const int count = cdpr_tables(found);
    for (int i = 0; i < count; i++) {
        for (Py_ssize_t g = 0; g < found[i]->count; g++) {
            const cdpr_group *group = found[i]->groups[g];
            for (Py_ssize_t j = 0; j < group->count; j++) {
                if ((uintptr_t)group->entries[j].call == address) return &group->entries[j];
            }
        }
    }
    return NULL;
}

static PyObject *bound_new(PyTypeObject *type, PyObject *args, PyObject *named) {
    unsigned long long operation;
    char *words;
    Py_ssize_t size;
    PyObject *words_given, *given, *arrays;
    const cdpr_entry *entry;
    Bound *bound;
    if (named && PyDict_Size(named)) {
        PyErr_SetString(PyExc_TypeError, "Bound takes no keywords");
        return NULL;
    }
    if (!PyArg_ParseTuple(args, "KOOO", &operation, &words_given, &given, &arrays)) return NULL;
    if (PyBytes_AsStringAndSize(words_given, &words, &size) < 0) return NULL;
    entry = entry_at(operation);
    if (!entry) {
        PyErr_SetString(PyExc_ValueError, "Bound: no operation of this library has that address");
        return NULL;
    }
    if (size != 8 * (Py_ssize_t)entry->count) {
        PyErr_SetString(PyExc_ValueError, "Bound: the struct of that operation has another size");
        return NULL;
    }
    bound = (Bound *)PyType_GenericAlloc(type, 0);
    if (!bound) return NULL;
    Py_IncRef(given);
    Py_IncRef(arrays);
    bound->given = given;
    bound->arrays = arrays;
    bound->operation = entry->call;
    bound->entry = entry;
    bound->name = entry->name;
    bound->size = 8 * entry->count;
    bound->place = PyMem_Malloc((size_t)size);
    if (!bound->place) {
        PyErr_SetString(PyExc_MemoryError, "no memory for an operation's struct");
        Py_DecRef((PyObject *)bound);
        return NULL;
    }
    memcpy(bound->place, words, (size_t)size);
    return (PyObject *)bound;
}

/* Read the arguments of a call, which are the time [s] or nothing; return 0, or -1 with an exception. */
static int read_time(PyObject *args, PyObject *named, double *time) {
    const Py_ssize_t count = PyTuple_Size(args);
    *time = 0.0;
    if (count > 1 || (named && PyDict_Size(named))) {
        PyErr_SetString(PyExc_TypeError, "a bound operation takes at most the time [s]");
        return -1;
    }
    if (count == 1) *time = PyFloat_AsDouble(PyTuple_GetItem(args, 0));
    return *time == -1.0 && PyErr_Occurred() ? -1 : 0;
}

static PyObject *bound_call(PyObject *self, PyObject *args, PyObject *named) {
    Bound *bound = (Bound *)self;
    double time;
    if (read_time(args, named, &time) < 0) return NULL;
    return PyLong_FromLong(bound->operation(bound->place, time));
}

static PyObject *bound_unlocked(PyObject *self, PyObject *args) {
    Bound *bound = (Bound *)self;
    double time;
    int status;
    if (read_time(args, NULL, &time) < 0) return NULL;
    PyThreadState *state = PyEval_SaveThread();
    status = bound->operation(bound->place, time);
    PyEval_RestoreThread(state);
    return PyLong_FromLong(status);
}

static int is_array(const char *type) { return strchr(type, '*') != NULL; }

/* Return the array that a field is bound to; NULL with an exception if it has none. */
static PyObject *array_of(const Bound *bound, const cdpr_entry *entry, Py_ssize_t position) {
    Py_ssize_t before = 0;
    if (position >= entry->count || !is_array(entry->types[position])) {
        PyErr_SetString(PyExc_ValueError, "on: no array at that position");
        return NULL;
    }
    for (Py_ssize_t i = 0; i < position; i++) before += is_array(entry->types[i]);
    return PyTuple_GetItem(bound->arrays, before);
}

/* Return whether an array has the type and the shape of another one, and is aligned. */
static int is_like(const Py_buffer *array, const Py_buffer *other) {
    if (array->ndim != other->ndim || strcmp(array->format, other->format)) return 0;
    for (int i = 0; i < array->ndim; i++)
        if (array->shape[i] != other->shape[i]) return 0;
    return (uintptr_t)array->buf % 8 == 0;
}

/* Return whether arrays that are written, a bit each, share no memory with others. */
static int are_apart(const Py_buffer *arrays, Py_ssize_t count, uint64_t written) {
    for (Py_ssize_t i = 0; i < count; i++) {
        const char *start = arrays[i].buf, *end = start + arrays[i].len;
        if (!(written >> i & 1) || start == end) continue;
        for (Py_ssize_t j = 0; j < count; j++) {
            const char *other = arrays[j].buf;
            if (j != i && arrays[j].len && start < other + arrays[j].len && other < end) return 0;
        }
    }
    return 1;
}

static void forget_expected(Bound *bound) {
    while (bound->known > 0) PyBuffer_Release(&bound->expected[--bound->known]);
}

static void bound_dealloc(PyObject *self) {
    Bound *bound = (Bound *)self;
    PyObject *type = (PyObject *)Py_TYPE(self), *given = bound->given, *arrays = bound->arrays;
    forget_expected(bound);
    PyMem_Free(bound->place);
    PyObject_Free(self);
    if (given) Py_DecRef(given);
    if (arrays) Py_DecRef(arrays);
    Py_DecRef(type);
}

/* Look up types and shapes of the arrays at these positions, once; return 0, or -1 with an exception. */
static int expect(Bound *bound, const char *positions, Py_ssize_t count) {
    if (bound->known == count && !memcmp(bound->positions, positions, (size_t)count)) return 0;
    forget_expected(bound);
    memcpy(bound->positions, positions, (size_t)count);
    while (bound->known < count) {
        PyObject *array = array_of(bound, bound->entry, (unsigned char)positions[bound->known]);
        if (!array ||
            PyObject_GetBuffer(array, &bound->expected[bound->known], PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) < 0) {
            forget_expected(bound);
            return -1;
        }
        bound->known++;
    }
    return 0;
}

/* Get the memory of an array that may stand for another one; return 0, or -1 with an exception. */
static int get_like(PyObject *array, const Py_buffer *expected, int writes, Py_buffer *view) {
    const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (writes ? PyBUF_WRITABLE : 0);
    if (Py_TYPE(array) == Py_TYPE(expected->obj)) { /* a masked array has a buffer, too */
        if (PyObject_GetBuffer(array, view, flags) < 0) return -1;
        if (is_like(view, expected)) return 0;
        PyBuffer_Release(view);
    }
    PyErr_SetString(PyExc_ValueError, "on: an array differs in type or shape from the one that is bound");
    return -1;
}

/* Call it on other arrays: their positions among the fields as bytes, then the arrays, which share no memory with
   those that stay. */
static PyObject *bound_on(PyObject *self, PyObject *const *args, Py_ssize_t given_args) {
    Bound *bound = (Bound *)self;
    const Py_ssize_t count = given_args - 1;
    uint64_t words[SIZE / 8];
    Py_buffer views[MOST];
    Py_ssize_t given, got = 0;
    uint64_t written = 0;
    char *positions;
    PyObject *status = NULL;
    if (count < 0 || PyBytes_AsStringAndSize(args[0], &positions, &given) < 0) {
        PyErr_SetString(PyExc_TypeError, "on: expected positions as bytes, then arrays");
        return NULL;
    }
    if (given != count || count > MOST || bound->size > SIZE) {
        PyErr_SetString(PyExc_ValueError, "on: expected as many positions as arrays, at most 8");
        return NULL;
    }
    if (expect(bound, positions, count) < 0) return NULL;
    memcpy(words, bound->place, (size_t)bound->size);
    while (got < count) {
        const unsigned char position = (unsigned char)positions[got];
        const int writes = strncmp(bound->entry->types[position], "const", 5) != 0;
        if (get_like(args[got + 1], &bound->expected[got], writes, &views[got]) < 0) break;
        words[position] = (uintptr_t)views[got].buf;
        written |= (uint64_t)writes << got++;
    }
    if (got == count && are_apart(views, count, written))
        status = PyLong_FromLong(bound->operation(words, 0.0));
    else if (got == count)
        PyErr_SetString(PyExc_ValueError, "on: an array that is written shares memory with another one");
    for (Py_ssize_t i = 0; i < got; i++) PyBuffer_Release(&views[i]);
    return status;
}

static PyObject *bound_words(PyObject *self, void *unused) {
    Bound *bound = (Bound *)self;
    (void)unused;
    return PyBytes_FromStringAndSize(bound->place, (Py_ssize_t)bound->size);
}

static PyMethodDef bound_methods[] = {
    {"on", (PyCFunction)(void (*)(void))bound_on, METH_FASTCALL,
     "Call it on other arrays of the same types and shapes, once."},
    {"unlocked", bound_unlocked, METH_VARARGS, "Call it while other threads of Python run."},
    {NULL, NULL, 0, NULL},
};

static PyGetSetDef bound_properties[] = {
    {"words", bound_words, NULL, "Content of the struct, 8 bytes per field.", NULL},
    {NULL, NULL, NULL, NULL, NULL},
};

static PyMemberDef bound_members[] = {
    {"operation", T_ULONGLONG, offsetof(Bound, operation), READONLY, "Address of int f(void *place, double time)."},
    {"place", T_ULONGLONG, offsetof(Bound, place), READONLY, "Address of the struct."},
    {"name", T_STRING, offsetof(Bound, name), READONLY, "Name of the operation."},
    {"given", T_OBJECT_EX, offsetof(Bound, given), READONLY, "Arguments by name."},
    {"arrays", T_OBJECT_EX, offsetof(Bound, arrays), READONLY, "Arrays whose addresses the struct holds."},
    {NULL, 0, 0, 0, NULL},
};

static PyType_Slot bound_slots[] = {
    {Py_tp_doc, "Operation with its arrays: bound() or bound(time) returns the status code."},
    {Py_tp_new, bound_new},
    {Py_tp_call, bound_call},
    {Py_tp_dealloc, bound_dealloc},
    {Py_tp_members, bound_members},
    {Py_tp_methods, bound_methods},
    {Py_tp_getset, bound_properties},
    {0, NULL},
};

static PyType_Spec bound_spec = {"cdpr.native.library.Bound", sizeof(Bound), 0, Py_TPFLAGS_DEFAULT, bound_slots};

/* Set an item of a new tuple. Return the tuple; NULL, without the tuple, where there is no item for lack of memory. */
static PyObject *with_item(PyObject *tuple, Py_ssize_t i, PyObject *item) {
    if (item && PyTuple_SetItem(tuple, i, item) == 0) return tuple;
    Py_DecRef(tuple);
    return NULL;
}

static PyObject *types_of(const cdpr_entry *entry) {
    PyObject *types = PyTuple_New(entry->count);
    for (Py_ssize_t i = 0; types && i < entry->count; i++)
        types = with_item(types, i, Py_BuildValue("s", entry->types[i]));
    return types;
}

static PyObject *entries_of(const cdpr_table *table) {
    Py_ssize_t count = 0, next = 0;
    for (Py_ssize_t g = 0; g < table->count; g++) count += table->groups[g]->count;
    PyObject *entries = PyTuple_New(count);
    for (Py_ssize_t g = 0; g < table->count; g++) {
        for (Py_ssize_t i = 0; entries && i < table->groups[g]->count; i++) {
            const cdpr_entry *entry = &table->groups[g]->entries[i];
            const unsigned long long address = (uintptr_t)entry->call;
            PyObject *types = types_of(entry);
            PyObject *row = types ? Py_BuildValue("sKsN", entry->name, address, entry->fields, types) : NULL;
            entries = with_item(entries, next++, row);
        }
    }
    return entries;
}

static PyObject *tables(PyObject *module, PyObject *none) {
    const cdpr_table *found[CDPR_TARGETS];
    const int count = cdpr_tables(found);
    PyObject *all = PyTuple_New(count);
    (void)module;
    (void)none;
    for (Py_ssize_t i = 0; all && i < count; i++) {
        PyObject *entries = entries_of(found[i]);
        all = with_item(all, i, entries ? Py_BuildValue("sN", found[i]->target, entries) : NULL);
    }
    return all;
}

static int execute(PyObject *module) {
    PyObject *type = PyType_FromSpec(&bound_spec);
    int added;
    if (!type) return -1;
    added = PyModule_AddObjectRef(module, "Bound", type);
    Py_DecRef(type);
    if (added < 0) return -1;
    if (PyModule_AddStringConstant(module, "sources", CDPR_SOURCES) < 0) return -1;
    return PyModule_AddStringConstant(module, "compiler", COMPILER);
}

static PyObject *address(PyObject *module, PyObject *args) {
    PyObject *array;
    Py_buffer view;
    unsigned long long start;
    (void)module;
    if (!PyArg_ParseTuple(args, "O", &array) || PyObject_GetBuffer(array, &view, PyBUF_C_CONTIGUOUS) < 0) return NULL;
    start = (uintptr_t)view.buf;
    PyBuffer_Release(&view);
    return Py_BuildValue("K", start);
}

/* Whether an array is of a type, with elements of 8 bytes, floats or integers, and of a shape. */
static int fits(const Py_buffer *array, const char *about, const int64_t *shape) {
    const char *format = array->format;
    if (array->ndim != about[3] || array->itemsize != 8 || (uintptr_t)array->buf % 8 || format[1]) return 0;
    if (about[0] ? format[0] != 'l' && format[0] != 'q' : format[0] != 'd') return 0;
    for (int i = 0; i < array->ndim; i++)
        if (array->shape[i] != shape[i]) return 0;
    return 1;
}

/* Return a struct with the addresses of arrays; None where they are not as described: bind.py then finds out why.

   The arguments are the type of arrays, the struct without addresses, four bytes for each array (whether its elements
   are integers, whether it is written, its position in the struct, its dimensions), all shapes, and the arrays. */
static PyObject *fill(PyObject *module, PyObject *const *args, Py_ssize_t given) {
    Py_buffer views[FILLED];
    char *content, *about, *shapes, *words;
    Py_ssize_t size, described, lengths, count, got = 0;
    PyObject *filled = NULL;
    (void)module;
    if (given != 5 || PyBytes_AsStringAndSize(args[1], &content, &size) < 0 ||
        PyBytes_AsStringAndSize(args[2], &about, &described) < 0 ||
        PyBytes_AsStringAndSize(args[3], &shapes, &lengths) < 0 || (count = PyTuple_Size(args[4])) < 0) {
        if (!PyErr_Occurred()) PyErr_SetString(PyExc_TypeError, "fill: expected five arguments");
        return NULL;
    }
    uint64_t written = 0;
    const int64_t *shape = (const int64_t *)shapes, *const last = shape + lengths / 8;
    if (count > FILLED || described != 4 * count) return Py_BuildValue("");
    for (; got < count; got++) {
        const char *each = about + 4 * got;
        PyObject *array = PyTuple_GetItem(args[4], got);
        const int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (each[1] ? PyBUF_WRITABLE : 0);
        if ((PyObject *)Py_TYPE(array) != args[0] || last - shape < each[3] || 8 * (unsigned char)each[2] + 8 > size)
            break;
        if (PyObject_GetBuffer(array, &views[got], flags) < 0) {
            PyErr_Clear();
            break;
        }
        if (!fits(&views[got], each, shape)) {
            PyBuffer_Release(&views[got]);
            break;
        }
        shape += each[3];
        written |= (uint64_t)(each[1] != 0) << got;
    }
    if (got == count && are_apart(views, count, written)) {
        filled = PyBytes_FromStringAndSize(content, size);
        if (filled && PyBytes_AsStringAndSize(filled, &words, &size) == 0) {
            for (Py_ssize_t i = 0; i < count; i++) {
                const uint64_t start = (uintptr_t)views[i].buf;
                memcpy(words + 8 * (unsigned char)about[4 * i + 2], &start, 8);
            }
        }
    } else {
        filled = Py_BuildValue("");
    }
    for (Py_ssize_t i = 0; i < got; i++) PyBuffer_Release(&views[i]);
    return filled;
}

static PyMethodDef methods[] = {
    {"fill", (PyCFunction)(void (*)(void))fill, METH_FASTCALL,
     "Return a struct with the addresses of arrays, or None."},
    {"address", address, METH_VARARGS, "Return the address of an array's first element."},
    {"tables", tables, METH_NOARGS, "Return (target, entries) of each instruction set that this processor can run."},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef_Slot slots[] = {{Py_mod_exec, execute}, {0, NULL}};

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "cdpr.native.library", "Compiled kernels.", 0, methods, slots, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit_library(void);
PyMODINIT_FUNC PyInit_library(void) { return PyModuleDef_Init(&definition); }
