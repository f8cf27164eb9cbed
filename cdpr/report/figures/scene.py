"""What `cdpr.report.figures.sketch` draws: a robot at one or more poses, of a run or of no run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cdpr.cables import exits_of, read_exits
from cdpr.log.run import Run
from cdpr.model import Robot, rotations
from cdpr.model.robot import Array, CableExit


@dataclass(frozen=True, eq=False)
class Scene:
    """A robot with m cables at K poses, world axes."""

    cables: tuple[str, ...]  # names
    anchors: Array  # (m, 6): A_i in the world, B_i on the platform, m
    shape: dict[str, Any] | None  # as `Platform.outline`
    time: Array  # (K,), s
    position: Array  # (K, 3), m
    orientation: Array  # (K, 4), quaternion w, x, y, z
    frame: Array  # (k, 6), edges: two ends each, m; none where no frame is known
    colours: dict[str, str]  # "#rrggbb" of "platform" and "frame", where they are given
    desired: Array | None = None  # (K, 3), m, positions, where they are something else
    broken: frozenset[str] = frozenset()  # cables that are no more at the end
    exits: tuple[CableExit | None, ...] = ()  # where cables leave the frame, where not all do at their anchors

    def ways(self, k: int) -> tuple[Array, Array, list[Array]]:
        """Ends of the cables at pose k, on the frame and on the platform (m, 3), m, and lines that show the exits."""
        tips = self.position[k] + self.anchors[:, 3:] @ rotations.matrix(self.orientation[k]).T
        if not self.exits:
            return self.anchors[:, :3], tips, []
        from cdpr.cables.lines import rows
        from cdpr.mechanics.geometry import leaving

        points = np.empty((1, *tips.shape))
        leaving(rows(self.anchors, self.exits), np.ascontiguousarray(tips)[None], points)
        frame = zip(self.exits, self.anchors[:, :3].tolist(), points[0].tolist(), strict=True)
        shapes = [np.array(each.outline(A, E)) for each, A, E in frame if each is not None]
        return points[0], tips, [shape for shape in shapes if len(shape)]

    @classmethod
    def of_run(cls, run: Run) -> Scene:
        """Return what there is to draw of a run."""
        head = run.header
        return cls(
            cables=head.cables,
            anchors=np.array(head.anchors),
            shape=head.shape,
            time=run.time,
            position=run.position,
            orientation=run.orientation,
            frame=np.array(head.frame).reshape(-1, 6),
            colours=head.colours,
            desired=run.desired_position,
            exits=tuple(read_exits(head.exits)),
            broken=frozenset(head.cables[i] for i, since in head.broken if len(run.time) and since <= run.time[-1]),
        )

    @classmethod
    def of_robot(cls, robot: Robot, time: Array, pose: Array) -> Scene:
        """Return a robot at poses (K, 7), position (m) and quaternion, at the times (K,), s."""
        names = tuple(cable.name for cable in robot.cables)
        frame = np.empty((0, 6)) if robot.frame is None else robot.frame.edges
        exits = tuple(cable.exit for cable in robot.cables) if exits_of(robot) else ()
        shape = robot.platform.outline
        return cls(names, robot.anchors, shape, time, pose[:, :3], pose[:, 3:7], frame, robot.colours, exits=exits)
