"""What is asked of a worker process and what it answers: plain data, light to import."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cdpr.errors import ExitCode
from cdpr.plugins.classes import PluginFile
from cdpr.plugins.registry import plugin_files

BEGUN = "begun"  # said once a case: imported and built, the run begins


@dataclass(frozen=True)
class Case:
    """One run in a process of its own."""

    key: str  # unique, names the case in messages
    scenario: str  # path of the scenario file
    changes: Mapping[str, Any] = field(default_factory=dict)  # values by dotted key, as simulate(overrides=...)
    out: str | None = None  # run folder, new or empty; without one only the outcome is kept
    text: str | None = None  # the scenario, where it is not what the file holds
    plugins: tuple[PluginFile, ...] = field(default_factory=plugin_files)  # that are used besides the installed ones


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    "finished", "infeasible", "unanswered", "beyond_limits", "touched" and "diverged" are results. "failed" is an error,
    which the message tells; "died" means that the process ended under it and "hung" that it took too long, both with
    what the process printed last.
    """

    key: str
    status: str
    message: str
    folder: str
    summary: Mapping[str, Any] = field(default_factory=dict)  # as Run.summary(), where there is a run
    versions: Mapping[str, str] = field(default_factory=dict)  # of all that computed it
    timings: Mapping[str, float] = field(default_factory=dict)  # s of wall time; "case_s" is all of it in the worker
    code: ExitCode = ExitCode.OK  # that `cdpr run` would end with

    @property
    def reason(self) -> str:
        """The first line of the message, which says it all."""
        return self.message.partition("\n")[0]
