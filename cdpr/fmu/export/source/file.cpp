// SPDX-License-Identifier: Apache-2.0
#include "file.h"

#ifdef _WIN32  // a path without conversion would be in the system's code page
#include <windows.h>

FILE* fmu::open_file(const char* path) {
    wchar_t wide[PATH];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, PATH) ? _wfopen(wide, L"r") : nullptr;
}
#else
FILE* fmu::open_file(const char* path) { return fopen(path, "r"); }
#endif
