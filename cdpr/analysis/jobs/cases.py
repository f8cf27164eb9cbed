"""Requests to worker processes and their results: plain data, light to import."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cdpr.base.errors import ExitCode
from cdpr.plugins.classes import PluginFile
from cdpr.plugins.registry import plugin_files

BEGUN = "begun"  # sent once per case: imports and setup are done, the run begins


def _parts() -> tuple[str, ...]:
    from cdpr.simulation.loop_parts import entries  # slow to import, and not needed to read outcomes

    return entries()


@dataclass(frozen=True)
class Case:
    """One run in its own process."""

    key: str  # unique, names the case in messages
    scenario: str  # path of the scenario file
    changes: Mapping[str, Any] = field(default_factory=dict)  # values by dotted key, as simulate(overrides=...)
    out: str | None = None  # run folder, new or empty; without one only the outcome is kept
    text: str | None = None  # text of the scenario, if it differs from the file
    plugins: tuple[PluginFile, ...] = field(default_factory=plugin_files)  # plugin files, besides installed plugins
    parts: tuple[str, ...] = field(default_factory=_parts)  # of the loop, which the worker must have, too


@dataclass(frozen=True)
class Outcome:
    """Outcome of a case.

    "finished", "infeasible", "unanswered", "beyond_limits", "touched" and "diverged" are results. "failed" is an error
    with its message. "died" means that the process ended during the case, and "hung" that the case exceeded its time
    limit; the message of both includes the last output of the process.
    """

    key: str
    status: str
    message: str
    folder: str
    summary: Mapping[str, Any] = field(default_factory=dict)  # as Run.summary(), if there is a run
    versions: Mapping[str, str] = field(default_factory=dict)  # of all software that computed it
    timings: Mapping[str, float] = field(default_factory=dict)  # s of wall time; "case_s" is the total in the worker
    code: ExitCode = ExitCode.OK  # exit code of `cdpr run` for this case

    @property
    def reason(self) -> str:
        """First line of the message."""
        return self.message.partition("\n")[0]
