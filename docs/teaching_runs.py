"""Runs, commands and results that the experiments of teaching.md share."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import cdpr
from cdpr.base.errors import SimulationStopped
from cdpr.log.run import Run

SCENARIOS = Path(__file__).parent.parent / "scenarios"
RESULTS = Path(__file__).parent / "teaching.json"
LINE = 116  # letters of a command, and " \\"

Figures = Mapping[str, Any]


def simulate(scenario: str, changes: Mapping[str, Any], **choice: str) -> Run:
    """Run a scenario; a run that diverged is a result."""
    try:
        return cdpr.simulate(SCENARIOS / scenario, overrides=changes, **choice)
    except SimulationStopped as stop:
        return cast("Run", stop.run)


def number(value: float | None) -> str:
    """Three digits; powers of ten for what is very small."""
    return "diverged" if value is None else f"{value:.2g}" if value < 0.01 else f"{value:.3g}"


def results() -> Figures:
    """Return the content of teaching.json."""
    return json.loads(RESULTS.read_text())  # type: ignore[no-any-return]


def command(verb: str, scenario: str, changes: Mapping[str, Any], **options: str) -> str:
    """A command as a reader types it, with an argument that needs the room on a line of its own."""
    words = [f"$ cdpr {verb} scenarios/{scenario}", *(f"--{name} {value}" for name, value in options.items())]
    for key, value in changes.items():
        words.append("--set " + shlex.quote(f"{key}={value if isinstance(value, str) else json.dumps(value)}"))
    lines = [words[0]]
    for word in words[1:]:
        if len(lines[-1]) + len(word) < LINE:
            lines[-1] += " " + word
        else:
            lines[-1] += " \\"
            lines.append("    " + word)
    return "\n".join(["```console", *lines, "```"])
