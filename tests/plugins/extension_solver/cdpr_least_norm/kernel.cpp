// Python module with the address of the kernel.
#define Py_LIMITED_API 0x030b0000
#include <Python.h>

#include "least_norm.hpp"

static int kernel(void* place, double) { return least_norm::solve(*static_cast<least_norm::Problem*>(place)); }

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "kernel", nullptr, -1, nullptr, nullptr, nullptr, nullptr, nullptr};

PyMODINIT_FUNC PyInit_kernel() {
    PyObject* module = PyModule_Create(&definition);
    PyObject* address = PyLong_FromVoidPtr(reinterpret_cast<void*>(kernel));
    if (module != nullptr && PyModule_AddObjectRef(module, "address", address) < 0) Py_CLEAR(module);
    Py_XDECREF(address);
    return module;
}
