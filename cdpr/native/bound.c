/* Type of bound operations: an operation with its arrays. SPDX-License-Identifier: Apache-2.0

   bind.py checks the arrays and packs the struct; a bound operation is called without arguments, or with the time. */
#include "bound.h"

enum { MOST = 8, SIZE = 1024 }; /* of `on`: arrays, and bytes of the struct */

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

PyType_Spec cdpr_bound = {"cdpr.native.library.Bound", sizeof(Bound), 0, Py_TPFLAGS_DEFAULT, bound_slots};
