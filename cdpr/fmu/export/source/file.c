/* SPDX-License-Identifier: Apache-2.0 */
#include "file.h"

#ifdef _WIN32 /* which takes a plain path for one in its code page */
#include <windows.h>

FILE *open_file(const char *path) {
    wchar_t wide[PATH];
    return MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, PATH) ? _wfopen(wide, L"r") : NULL;
}
#else
FILE *open_file(const char *path) { return fopen(path, "r"); }
#endif
