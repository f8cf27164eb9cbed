"""API for plugin authors: the hook marker, PluginInfo, and the interfaces of all roles.

A plugin package declares an entry point in the group `cdpr` that names a light module. That module implements one or
more of the hooks `cdpr_backends`, `cdpr_controllers`, `cdpr_solvers`, `cdpr_estimators`, each returning `PluginInfo`
rows.

The factory is imported only when the plugin is used.

Example:
    >>> from cdpr.plugins import PluginInfo, hookimpl
    >>> @hookimpl
    ... def cdpr_solvers():
    ...     return [PluginInfo(name="mine", factory="my_package.solver:Mine", summary="one line")]
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cdpr.base.column import CABLES, Column
from cdpr.plugins.info import INTERFACE_VERSION, FileName, PluginInfo, PluginOptions, hookimpl

_INTERFACES = {
    "Backend": "cdpr.plugins.backend",
    "CompiledSolver": "cdpr.plugins.solver",
    "Controller": "cdpr.plugins.controller",
    "ControllerInputs": "cdpr.plugins.inputs",
    "Environment": "cdpr.plugins.environment",
    "Estimator": "cdpr.plugins.estimator",
    "EstimatorInputs": "cdpr.plugins.estimator",
    "RigidBodyBackend": "cdpr.plugins.rigid_body",
    "SensorModel": "cdpr.plugins.estimator",
    "SnapshotOfArrays": "cdpr.plugins.snapshots",
    "TensionSolver": "cdpr.plugins.solver",
}

if TYPE_CHECKING:
    from cdpr.plugins.backend import Backend
    from cdpr.plugins.controller import Controller
    from cdpr.plugins.environment import Environment
    from cdpr.plugins.estimator import Estimator, EstimatorInputs, SensorModel
    from cdpr.plugins.inputs import ControllerInputs
    from cdpr.plugins.rigid_body import RigidBodyBackend
    from cdpr.plugins.snapshots import SnapshotOfArrays
    from cdpr.plugins.solver import CompiledSolver, TensionSolver
else:  # interfaces are imported when first used, so that plugin rows stay light
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, _INTERFACES)

__all__ = [
    "CABLES",
    "INTERFACE_VERSION",
    "Backend",
    "Column",
    "CompiledSolver",
    "Controller",
    "ControllerInputs",
    "Environment",
    "Estimator",
    "EstimatorInputs",
    "FileName",
    "PluginInfo",
    "PluginOptions",
    "RigidBodyBackend",
    "SensorModel",
    "SnapshotOfArrays",
    "TensionSolver",
    "hookimpl",
]
