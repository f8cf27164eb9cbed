"""Pose-independent display data of a robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from cdpr.model import Robot, rotations
from cdpr.model.robot import Array, CableExit
from cdpr.scene.sensors import SensorDrawing


@dataclass(frozen=True, eq=False)
class Subject:
    """Robot with m cables."""

    cables: tuple[str, ...]  # names
    anchors: Array  # (m, 6): A_i in the world, B_i on the platform, m
    tension_min: Array  # (m,), N
    tension_max: Array  # (m,), N
    shape: dict[str, Any] | None  # as in `Platform.outline`
    frame: Array  # (k, 6), edges with two ends each, m; empty if unknown
    colours: dict[str, str]  # "#rrggbb" of "platform" and "frame", if given
    exits: tuple[CableExit | None, ...] = ()  # cable exits; empty if all cables leave the frame at their anchors
    broken: tuple[tuple[int, float], ...] = ()  # index and time (s) of cables that break
    tools: dict[str, tuple[float, ...]] = field(default_factory=dict)  # points (3,) in the platform's axes, m
    spans: tuple[dict[str, Any] | None, ...] = ()  # spans of cables that sag; empty if none does
    gravity: tuple[float, ...] = (0.0, 0.0, 0.0)  # (3,), m/s^2, for their curves
    sensors: tuple[SensorDrawing, ...] = ()  # those with a place
    led: str = ""  # guided tool, whose path is drawn; "" for the platform's origin

    @classmethod
    def of_robot(cls, robot: Robot) -> Subject:
        """Return the display data of a robot."""
        from cdpr.cables import exits_of, spans_of  # takes long to import

        return cls(
            cables=tuple(cable.name for cable in robot.cables),
            anchors=robot.anchors,
            tension_min=robot.tension_min,
            tension_max=robot.tension_max,
            shape=robot.platform.outline,
            frame=np.empty((0, 6)) if robot.frame is None else robot.frame.edges,
            colours=robot.colours,
            exits=tuple(cable.exit for cable in robot.cables) if exits_of(robot) else (),
            spans=spans_of(robot),
            tools={name: tuple(point.tolist()) for name, point in robot.platform.tools.items()},
        )

    def led_at(self, position: Array, orientation: Array) -> Array:
        """Return the positions of the guided point, (n, 3), m, world frame, at poses (n, 3) and (n, 4)."""
        if not self.led:
            return position
        with np.errstate(all="ignore"):
            return np.asarray(position + rotations.rotate(orientation, np.array(self.tools[self.led])))

    def ends(self, position: Array, orientation: Array) -> Array:
        """Return the ends of the cables on frame and platform, (n, m, 2, 3), at poses (n, 3) and (n, 4).

        Non-finite poses give non-finite ends, so that diverged runs can be drawn.
        """
        out = np.empty((len(position), len(self.cables), 2, 3))
        with np.errstate(all="ignore"):
            R = rotations.matrix(np.asarray(orientation))  # (n, 3, 3)
            out[:, :, 1] = np.asarray(position)[:, None]
            for j in range(3):  # R @ B_i without matmul, whose rounding depends on the machine
                out[:, :, 1] += R[:, None, :, j] * self.anchors[:, None, 3 + j]
        if self._lines is None:
            out[:, :, 0] = self.anchors[:, :3]
        else:
            from cdpr.cables.tables import exits

            lines = np.tile(self._lines, (len(out), 1))
            out[:, :, 0] = exits(lines, out[:, :, 1].reshape(-1, 3))[0].reshape(-1, len(self.cables), 3)
        return out

    def curves(self, position: Array, orientation: Array, unwound: Array, count: int) -> Array:
        """Return points of the cables from frame to platform.

        Args:
            position: (n, 3) m.
            orientation: (n, 4) quaternions w, x, y, z.
            unwound: (n, m) unwound lengths, m.
            count: points of a cable, at least 2.

        Returns:
            (n, m, count, 3) m, world frame, at equal unstretched lengths. Straight for cables that do not sag.
        """
        from cdpr.cables.tables import line_rows, span_table
        from cdpr.mechanics.curves import cable_curves

        lines = line_rows(self.anchors, self.exits or [None] * len(self.cables))
        poses = np.concatenate([position, orientation], axis=1)
        return cable_curves(lines, span_table(self.spans), self.gravity, poses, unwound, count)

    def exit_lines(self, ends: Array) -> list[Array]:
        """Return lines (k, 3), m, that show the exits of cables with these ends (m, 2, 3)."""
        anchors = self.anchors[:, :3].tolist()
        shapes = [
            np.array(each.outline(anchor, end[0].tolist()))
            for each, anchor, end in zip(self.exits, anchors, ends, strict=False)
            if each is not None
        ]
        return [shape for shape in shapes if len(shape)]

    def broken_by(self, time: float) -> frozenset[str]:
        """Return the names of cables that are broken at a time, s."""
        return frozenset(self.cables[i] for i, since in self.broken if since <= time)

    @cached_property
    def _lines(self) -> Array | None:
        """Anchors and exits as in `cdpr.cables.tables.line_table`; None if all cables leave at their anchors."""
        if not self.exits:
            return None
        from cdpr.cables.tables import line_rows

        return line_rows(self.anchors, self.exits)
