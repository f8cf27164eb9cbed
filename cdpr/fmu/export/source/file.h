/* Opens files on any platform. SPDX-License-Identifier: Apache-2.0 */
#ifndef CDPR_FILE_H
#define CDPR_FILE_H

#include <stdio.h>

#define PATH 4096 /* bytes of a path at most */

/* Open a file for reading by its path in UTF-8; NULL where that fails. */
FILE *open_file(const char *path);

#endif
