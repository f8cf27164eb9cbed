// External engines: conversion between their joints, or their values, and our states. SPDX-License-Identifier:
// Apache-2.0
#include <cdpr/fmu/run/signals.hpp>
#include <cdpr/group.hpp>
#include <cdpr_backends/bullet/joints.hpp>
#include <cdpr_backends/dart/joints.hpp>
#include <cdpr_backends/mujoco/direct.hpp>
#include <cdpr_backends/mujoco/joints.hpp>

namespace cdpr::CDPR_TARGET {

static constexpr cdpr_entry entries[] = {
    entry<MujocoFreeState, mujoco_free_state>("mujoco_free_state"),
    entry<MujocoBallState, mujoco_ball_state>("mujoco_ball_state"),
    entry<MujocoStep, mujoco_step>("mujoco_step"),
    entry<MujocoClock, mujoco_clock>("mujoco_clock"),
    entry<BulletBaseState, bullet_base_state>("bullet_base_state"),
    entry<BulletBallState, bullet_ball_state>("bullet_ball_state"),
    entry<DartFreeForces, dart_free_forces>("dart_free_forces"),
    entry<DartBallForces, dart_ball_forces>("dart_ball_forces"),
    entry<DartGuideForces, dart_guide_forces>("dart_guide_forces"),
    entry<DartFollowFree, dart_follow_free>("dart_follow_free"),
    entry<DartFollowBall, dart_follow_ball>("dart_follow_ball"),
    entry<Signals, gather_signals>("gather_signals"),
    entry<Signals, scatter_signals>("scatter_signals"),
    entry<NormaliseAttitude, normalise_attitude>("normalise_attitude"),
};

extern const cdpr_group engines = group(entries);

}  // namespace cdpr::CDPR_TARGET
