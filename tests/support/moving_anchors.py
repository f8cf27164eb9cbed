"""A part of the loop that carries the whole frame along a straight line, and the motion alone for backends."""

from __future__ import annotations

import ctypes

import numpy as np

from cdpr.mechanics.anchors import Anchors
from cdpr.native.foreign import Foreign
from cdpr.simulation.loop_part import LoopPart

OPERATION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)


def carrying(anchors, velocity, acceleration):
    """The operation that moves all anchors with these (3,), at time 0 from rest positions."""
    rest = anchors.position.copy()

    @OPERATION
    def carry(_, time):
        anchors.position[:] = rest + time * velocity + 0.5 * time**2 * acceleration
        anchors.velocity[:] = velocity + time * acceleration
        anchors.acceleration[:] = acceleration
        return 0

    return Foreign(carry, anchors.values)


def moving(robot, velocity, acceleration):
    """Anchors of a robot, moved like this."""
    anchors = Anchors(robot)
    anchors.move(carrying(anchors, velocity, acceleration))
    return anchors


class Carriage(LoopPart):
    """Carries the frame."""

    name = "carriage"
    moves_anchors = True

    def __init__(self, velocity=(0.0, 0.0, 0.0), acceleration=(0.0, 0.0, 0.0)):
        self.velocity, self.acceleration = np.array(velocity), np.array(acceleration)

    def anchor_motion(self, anchors):
        self.anchors = anchors
        return carrying(anchors, self.velocity, self.acceleration)


class Broken(Carriage):
    """Fails from 0.02 s on."""

    def anchor_motion(self, anchors):
        good = super().anchor_motion(anchors)

        @OPERATION
        def fail(_, time):
            return 7 if time > 0.02 else good(time)

        self.kept = good
        return Foreign(fail)


class Spoiling(Carriage):
    """Writes a bad number into an array of the third anchor from a time on."""

    of, bad, after = "position", np.nan, 0.02

    def anchor_motion(self, anchors):
        good = super().anchor_motion(anchors)

        @OPERATION
        def spoil(_, time):
            good(time)
            if time > self.after:
                getattr(anchors, self.of)[2, 1] = self.bad
            return 0

        self.kept = good
        return Foreign(spoil, anchors.values)
