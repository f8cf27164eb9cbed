"""Nominal platform of an extended Kalman filter: the arguments of its prediction."""

from __future__ import annotations

from typing import Any

import numpy as np

from cdpr.cables import TENSION, chain_of, commands_of
from cdpr.cables.tables import chain_table, line_table
from cdpr.model import Robot
from cdpr.model.robot import Array
from cdpr_controllers.estimators.ekf_covariance import densities
from cdpr_controllers.estimators.ekf_stretch import drums_are_resolved, inverse_mass_matrix


def platform_arguments(robot: Robot, gravity: Array, step: float, options: Any, cells: Array | None) -> dict[str, Any]:
    """Return the arguments of the prediction, by name: `FilteredPlatform` in ekf_prediction.hpp.

    Args:
        robot: nominal robot.
        gravity: (3,), m/s^2, world.
        step: control period, s.
        options: options of the filter.
        cells: standard deviations of measured tensions (m,), N; None without load cells.
    """
    chains = chain_table(robot)
    free = np.zeros(6)
    free[robot.rows] = 1.0
    takes_tensions = set(commands_of(robot)) == {TENSION}
    measured = cells is not None and not takes_tensions
    return {
        "lines": np.array(line_table(robot)),
        "chains": np.array(chains),
        "inertial": robot.inertial.copy(),
        "inverse": inverse_mass_matrix(robot.inertial),
        "gravity": np.array(gravity, dtype=np.float64),
        "free": free,
        "noise": densities(robot, options),
        "cells": cells if cells is not None and measured else np.zeros(robot.m),
        "period": step,
        "driven": int(takes_tensions or measured),
        "rotates": int(robot.n == 6 and (measured or not chains[:, 0].any())),
        "elastic": int(any(chain_of(robot, cable).stretches for cable in robot.cables)),
        "drums": int(takes_tensions and drums_are_resolved(robot, step)),
        "noisy": int(measured),
    }
