/* Python module of the kernel library: tables, and structs of arrays. SPDX-License-Identifier: Apache-2.0 */
#include "bound.h"

#ifndef CDPR_SOURCES /* digest of the sources, which CMakeLists.txt computes */
#define CDPR_SOURCES ""
#endif

#ifdef __clang__
#define COMPILER __VERSION__
#else
#define COMPILER "GCC " __VERSION__
#endif

enum { FILLED = 64 }; /* of `fill`: arrays */

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
    PyObject *type = PyType_FromSpec(&cdpr_bound);
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

/* Return whether an array has a type, elements of 8 bytes (floats or integers), and a shape. */
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
