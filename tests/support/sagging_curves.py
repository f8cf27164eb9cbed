"""Curves of cables that sag, by integration of their differential equation."""

from __future__ import annotations

import numpy as np

from cdpr.cables.tables import chain_table
from cdpr.model.rotations import matrix
from cdpr.native.bind import bind

GRAVITY = np.array([0.0, 0.0, -9.81])
PIECES, NODES = 1600, 6  # of the integration along a cable
REACHED = 1e-8  # m: the integrated curve ends at the exit, with the error of 15 m of integrated cable


def integrated(robot, pose, unwound):
    """Return unstretched lengths and points of each cable, by integration from its force on the platform."""
    tips = pose[:3] + robot.anchors[:, 3:] @ matrix(pose[3:]).T
    chord, m = robot.anchors[:, :3] - tips, robot.m
    force = np.empty((m, 3))
    bind(
        "bent_cables",
        chains=chain_table(robot),
        gravity=GRAVITY,
        chord=chord,
        exit_to_anchor=np.zeros((m, 3)),
        wrapped_length=np.zeros(m),
        unwound=unwound,
        stretching=np.zeros(m),
        force=force,
        tension=np.empty(m),
    )()
    node, share = np.polynomial.legendre.leggauss(NODES)
    found = []
    for i, cable in enumerate(robot.cables):
        edges = np.linspace(0.0, unwound[i], PIECES + 1)
        step = edges[1]
        s = edges[:-1, None] + 0.5 * step * (1.0 + node)
        T = force[i] - cable.linear_density * GRAVITY * s[..., None]
        size = np.linalg.norm(T, axis=-1, keepdims=True)
        slope = T * (1.0 / size + 1.0 / cable.axial_stiffness)
        points = np.concatenate(
            [np.zeros((1, 3)), np.cumsum((slope * share[:, None]).sum(axis=1) * 0.5 * step, axis=0)]
        )
        assert np.abs(points[-1] - chord[i]).max() < REACHED
        found.append((edges, tips[i] + points))
    return found
