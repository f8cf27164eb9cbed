// All operations, compiled once per instruction set. SPDX-License-Identifier: Apache-2.0
//
// NAME takes doubles; NAME_lanes takes eight problems side by side (lanes.hpp). One file of tables/ for each group.
#include <cdpr/table.h>
#include <cdpr/instruction_set.hpp>

namespace cdpr::CDPR_TARGET {

// clang-format off
extern const cdpr_group mathematics;
extern const cdpr_group mechanics;
extern const cdpr_group cables;
extern const cdpr_group tension;
extern const cdpr_group solvers;
extern const cdpr_group controllers;
extern const cdpr_group estimators;
extern const cdpr_group backends;
extern const cdpr_group winches;
extern const cdpr_group anchors;
extern const cdpr_group engines;
extern const cdpr_group simulation;
extern const cdpr_group sensing;
extern const cdpr_group trajectory;
extern const cdpr_group gcode;
extern const cdpr_group workspace;
extern const cdpr_group loop;
extern const cdpr_group proofs;
extern const cdpr_group log;

static const cdpr_group* const groups[] = {
    &mathematics,
    &mechanics,
    &cables,
    &tension,
    &solvers,
    &controllers,
    &estimators,
    &backends,
    &winches,
    &anchors,
    &engines,
    &simulation,
    &sensing,
    &trajectory,
    &gcode,
    &workspace,
    &loop,
    &proofs,
    &log,
};
// clang-format on

extern const cdpr_table table;
const cdpr_table table = {CDPR_TARGET_NAME, groups, sizeof(groups) / sizeof(groups[0])};

}  // namespace cdpr::CDPR_TARGET
