// Opening of files on any platform. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdio.h>

namespace fmu {

constexpr size_t PATH = 4096;  // largest length of a path, bytes

// Open a file for reading by its path in UTF-8; nullptr if that fails.
FILE* open_file(const char* path);

}  // namespace fmu
