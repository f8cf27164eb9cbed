"""DART worlds and chains of links."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import dartpy
import numpy as np

from cdpr.model import rotations
from cdpr.model.robot import Array
from cdpr.plugins.inertia import Inertia
from cdpr_backends import DART_RANGE

TITLE = "DART"
SLIMMEST = DART_RANGE["slimmest"]

# Links between joints have no mass, but DART warns about values below some limit. The first sum rounds this value away.
NO_MASS = 1e-100


def make_world(gravity: Array, step: float) -> Any:
    """Return an empty world without deactivation of bodies at rest."""
    world = dartpy.simulation.World()
    world.setGravity(gravity)
    world.setTimeStep(step)
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = False
    world.setDeactivationOptions(sleep)
    return world


def chain(skeleton: Any, kinds: Sequence[str], directions: Array, mass: float, center: Array, inertia: Array) -> Any:
    """Add one link per joint and return the last one, which has mass, centre and inertia."""
    link: Any = None
    for kind, axis in zip(kinds, directions, strict=True):
        add = getattr(skeleton, f"create{kind}JointAndBodyNodePair")
        joint, link = add() if link is None else add(link)
        joint.setAxis(axis)
        link.setInertia(dartpy.dynamics.Inertia(NO_MASS, np.zeros(3), NO_MASS * np.eye(3)))
    set_inertia(link, mass, center, inertia)
    return link


def set_inertia(link: Any, mass: float, center: Array, inertia: Array) -> None:
    """Set mass, centre of mass (3,) and inertia (3, 3) about it of a link."""
    link.setInertia(dartpy.dynamics.Inertia(mass, center, (inertia + inertia.T) / 2))


def held(link: Any, axes: Array) -> Inertia:
    """Return the inertia in DART of a link whose axes are rotated by `axes`, w, x, y, z, in the body frame."""
    R, inertia = rotations.matrix(axes), link.getInertia()
    return Inertia(inertia.getMass(), R @ inertia.getMoment() @ R.T, R @ inertia.getLocalCOM())


def put_root(skeleton: Any, position: Array) -> None:
    """Place the first joint of a skeleton at a position (3,) in the world frame."""
    place = dartpy.math.Isometry3()
    place.set_translation(position)
    skeleton.getRootJoint().setTransformFromParentBodyNode(place)


def set_motion(skeleton: Any, q: Array, u: Array) -> None:
    """Set joint coordinates and rates, and clear all forces."""
    skeleton.resetAccelerations()
    skeleton.clearExternalForces()
    skeleton.resetGeneralizedForces()
    skeleton.setPositions(q)
    skeleton.setVelocities(u)
