"""Check of a backend with anchors that move (entry `moving_anchors` of the property `features`)."""

from __future__ import annotations

import ctypes

import numpy as np

from cdpr.mechanics.anchors import Anchors
from cdpr.native.foreign import Foreign
from cdpr.testing import samples
from cdpr.testing.check import Check, expect_close, needs
from cdpr.testing.subjects import BackendSubject

STEPS = 100
STEP = 1e-3  # s
VELOCITY = np.array([0.5, -0.3, 0.2])  # m/s, of the frame

# In the state after these steps. A semi-implicit scheme computes the cables with the anchors at the start of the
# physics step. With the anchors of another time of the step, the error exceeds 1e-5.
ROUND_OFF = 1e-9

MOTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)


def uniform_motion_changes_nothing(subject: BackendSubject) -> None:
    """If the same constant velocity is added to frame and platform, their relative motion does not change.

    The kit moves the anchors on the frame at a constant velocity, and adds the same velocity to the platform. The
    motion of the platform relative to these anchors must be the same as without this velocity. Skipped if the backend
    does not declare `moving_anchors`.
    """
    features = subject.properties.get("features", ())
    needs(isinstance(features, tuple | list) and "moving_anchors" in features, "it does not declare moving_anchors")
    robot, start = samples.free(), samples.state(np.random.default_rng(73), tilt=0.3)
    anchors = Anchors(robot)
    rest = anchors.position.copy()

    def carry(_: int, time: float) -> int:
        anchors.position[:] = rest + time * VELOCITY
        anchors.velocity[:] = VELOCITY
        return 0

    anchors.move(Foreign(MOTION(carry), anchors.values))
    still, carried = subject.make(start), subject.make(start)
    still.command[:] = carried.command[:] = np.linspace(200.0, 900.0, robot.m)
    still.step(STEPS)
    moved = start.copy()
    moved[7:10] += VELOCITY
    carried.follow(anchors)
    for run in ("first run", "run after a reset"):
        carried.reset(moved)
        carried.step(STEPS)
        relative = carried.state.copy()
        relative[:3] -= STEPS * STEP * VELOCITY
        relative[7:10] -= VELOCITY
        expect_close(samples.distance(relative, still.state), 0.0, ROUND_OFF, f"state relative to the frame, {run}")


CHECKS = [Check(uniform_motion_changes_nothing)]
