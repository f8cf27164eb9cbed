/* The part of CPython's stable ABI (3.11) that binder.c and bound.c use. SPDX-License-Identifier: Apache-2.0

   Declared here so that the library is built without Python.h, which Debian and others package apart from Python.
   tests/native/test_declarations.py compares these declarations with Python.h: included after it, this file gives
   the functions only, and the compiler rejects a difference. Free-threaded builds have another layout;
   build_backend.py rejects them. */
#ifndef CDPR_STABLE_ABI_H
#define CDPR_STABLE_ABI_H

#include <stddef.h>
#include <stdint.h>

/* clang-format off */
#ifndef Py_PYTHON_H
typedef intptr_t Py_ssize_t;
typedef struct PyObject { Py_ssize_t ob_refcnt; struct PyObject *ob_type; } PyObject;
typedef PyObject PyTypeObject;
typedef PyObject *(*PyCFunction)(PyObject *, PyObject *);

typedef struct { const char *ml_name; PyCFunction ml_meth; int ml_flags; const char *ml_doc; } PyMethodDef;
typedef struct { const char *name; int type; Py_ssize_t offset; int flags; const char *doc; } PyMemberDef;
typedef struct {
    const char *name;
    PyObject *(*get)(PyObject *, void *);
    int (*set)(PyObject *, PyObject *, void *);
    const char *doc;
    void *closure;
} PyGetSetDef;
typedef struct PyThreadState PyThreadState;
typedef struct {
    void *buf;
    PyObject *obj;
    Py_ssize_t len, itemsize;
    int readonly, ndim;
    char *format;
    Py_ssize_t *shape, *strides, *suboffsets;
    void *internal;
} Py_buffer;
typedef struct { int slot; void *pfunc; } PyType_Slot;
typedef struct { const char *name; int basicsize, itemsize; unsigned flags; PyType_Slot *slots; } PyType_Spec;
typedef struct { int slot; void *value; } PyModuleDef_Slot;
typedef struct { PyObject ob_base; PyObject *(*m_init)(void); Py_ssize_t m_index; PyObject *m_copy; } PyModuleDef_Base;
typedef struct {
    PyModuleDef_Base m_base;
    const char *m_name, *m_doc;
    Py_ssize_t m_size;
    PyMethodDef *m_methods;
    PyModuleDef_Slot *m_slots;
    void *m_traverse, *m_clear, *m_free;
} PyModuleDef;

#define PyObject_HEAD PyObject ob_base;
#define PyModuleDef_HEAD_INIT {{1, 0}, 0, 0, 0}
#define Py_TYPE(object) ((object)->ob_type)
#define PyMODINIT_FUNC __attribute__((visibility("default"))) PyObject *

enum { PyBUF_WRITABLE = 0x1, PyBUF_FORMAT = 0x4, PyBUF_C_CONTIGUOUS = 0x38 };
enum { METH_VARARGS = 1, METH_NOARGS = 4, METH_FASTCALL = 0x80, T_STRING = 5, T_OBJECT_EX = 16, T_ULONGLONG = 18, READONLY = 1, Py_TPFLAGS_DEFAULT = 0 };
enum { Py_mod_exec = 2, Py_tp_call = 50, Py_tp_dealloc = 52, Py_tp_doc = 56, Py_tp_methods = 64, Py_tp_new = 65 };
enum { Py_tp_members = 72, Py_tp_getset = 73 };
#endif

extern PyObject *PyExc_TypeError, *PyExc_ValueError, *PyExc_MemoryError;
PyObject *PyType_GenericAlloc(PyTypeObject *, Py_ssize_t), *PyType_FromSpec(PyType_Spec *);
PyObject *PyModuleDef_Init(PyModuleDef *), *Py_BuildValue(const char *, ...);
PyObject *PyTuple_New(Py_ssize_t), *PyLong_FromLong(long), *PyTuple_GetItem(PyObject *, Py_ssize_t), *PyErr_Occurred(void);
Py_ssize_t PyTuple_Size(PyObject *), PyDict_Size(PyObject *);
int PyTuple_SetItem(PyObject *, Py_ssize_t, PyObject *), PyArg_ParseTuple(PyObject *, const char *, ...);
int PyBytes_AsStringAndSize(PyObject *, char **, Py_ssize_t *);
PyObject *PyBytes_FromStringAndSize(const char *, Py_ssize_t);
int PyObject_GetBuffer(PyObject *, Py_buffer *, int);
void PyBuffer_Release(Py_buffer *);
PyThreadState *PyEval_SaveThread(void);
void PyEval_RestoreThread(PyThreadState *);
int PyModule_AddObjectRef(PyObject *, const char *, PyObject *), PyModule_AddStringConstant(PyObject *, const char *, const char *);
double PyFloat_AsDouble(PyObject *);
void PyErr_SetString(PyObject *, const char *), PyErr_Clear(void), Py_IncRef(PyObject *), Py_DecRef(PyObject *), PyObject_Free(void *);
void *PyMem_Malloc(size_t), PyMem_Free(void *);

#endif
