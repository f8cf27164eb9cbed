"""Validation of the motion: its own values, its guide, and rest where it starts and ends."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
from pydantic import TypeAdapter, ValidationError

from cdpr.base import tolerances
from cdpr.base.fields import DEFERRED
from cdpr.config.problems import exact
from cdpr.scenario.checks import Checks
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions import MOTIONS, Motion
from cdpr.scenario.motions.guide import Guide
from cdpr.scenario.report import SectionReport
from cdpr.scenario.robot_schema import Tools

ROOT = "trajectory"

TOOLS: TypeAdapter[Tools] = TypeAdapter(Tools, config=DEFERRED)


class MotionChecks(Checks):
    """Checks of the desired motion and of the directions that the guide leaves free.

    Attributes:
        motion: the section with its file loaded; None if it is invalid.
    """

    motion: Motion | None = None

    def load(self) -> None:
        """Load the section and its file."""
        if ROOT not in self.document.data:
            return
        try:
            motion = MOTIONS.read(self.document.get((ROOT,)))
        except ValidationError:
            return
        self.motion = motion.load(SectionReport(self, (ROOT,)))

    def check(self, initial: Initial | None, duration: float | None) -> None:
        """Report problems for a run of `duration` s."""
        motion, report = self.motion, SectionReport(self, (ROOT,))
        if motion is None:
            return
        motion.check(report)
        tools = self._tools()
        if motion.tool is not None and tools is not None and motion.tool not in tools:
            known = (
                f"allowed are {', '.join(tools)}"
                if tools
                else "the robot has none; define them in robot.platform.tools"
            )
            self.add_problem((ROOT, "tool"), f"the platform has no tool '{motion.tool}': {known}")
        begins = self._begins(initial)
        if begins:
            motion.complete(begins).check_completed(report)
        if duration:
            self._rest_outside(motion, duration, report)

    def guided(self, initial: Initial | None) -> None:
        """Report violations of the guide: by the initial state, the motion and the controlled directions."""
        dof = self.directions(("robot", "dof"))
        if dof and self.document.get(("controlled",)) is not None:
            controlled = self.directions(("controlled",))
            if controlled and (held := [name for name in controlled if name not in dof]):
                text = f"the robot does not move along {', '.join(held)}; allowed: {', '.join(dof)}"
                self.add_problem(("controlled",), text)
        if not dof or not initial:
            return
        guide = Guide(dof, initial.position, self.add_problem)
        if not guide.held.any():
            return
        if ("initial", "orientation") not in self.document.filled:  # problems of the home are reported there
            guide.attitude(("initial", "orientation"), initial.orientation)
        guide.rates(("initial",), initial)
        begins = self._begins(initial)
        if self.motion and begins:
            if self.motion.tool is not None and not guide.keeps(np.subtract(begins.position, initial.position)):
                text = f"{guide.free}: this tool would leave the guide when the platform rotates; remove `tool`"
                self.add_problem((ROOT, "tool"), text)
                return
            guide = Guide(dof, begins.position, self.add_problem, self.motion.tool)
            for path, point in self.motion.poses():
                guide.check((ROOT, *path), point)
            self.motion.stay(guide, SectionReport(self, (ROOT,)))

    def _tools(self) -> Mapping[str, Sequence[float]] | None:
        """Return the platform's tools, even if other parts of it are invalid; None if unknown."""
        platform = self.document.get(("robot", "platform"))
        if not isinstance(platform, dict):
            return None
        try:
            return TOOLS.validate_json(json.dumps(platform.get("tools", {})))
        except ValidationError:
            return None

    def _begins(self, initial: Initial | None) -> Initial | None:
        """Return the initial state of the moved point; None if unknown."""
        motion, tools = self.motion, self._tools()
        if motion is None or motion.tool is None or initial is None:
            return initial
        return motion.begins(initial, tools) if tools and motion.tool in tools else None

    def _rest_outside(self, motion: Motion, duration: float, report: SectionReport) -> None:
        """Report a motion that is not at rest where a constant pose precedes or follows it."""
        start, end = motion.span()
        if start is not None and start > 0:
            text = f"the pose is held until {exact(start)} s, so the motion must start at rest"
            motion.check_rest(0, text, report)
        if end is not None and end < duration * (1.0 - tolerances.TIME):
            text = (
                f"the motion ends at {exact(end)} s and the run at {exact(duration)} s, so the motion must end at rest"
            )
            motion.check_rest(-1, text, report)
