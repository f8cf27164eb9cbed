// Definitions of the exported controller. SPDX-License-Identifier: Apache-2.0
#define CDPR_IMPLEMENTATION
#include <robot.h>
