"""What must be said of a run that ended well: where its tensions were none, or its cables left their limits."""

from __future__ import annotations

from collections.abc import Iterator

from cdpr.log.run import Run
from cdpr.model.reach import EXCEEDED
from cdpr.tension.command import BEYOND


def reservations(run: Run) -> Iterator[str]:
    """Yield them as parts of a sentence."""
    figures = run.summary()
    total = figures["samples"]
    if bad := figures["infeasible_steps"]:
        yield f"{bad} of {total} samples had no admissible tensions"
    if bad := figures["unanswered_steps"]:
        commanded = any(event.text.startswith(BEYOND) for event in run.events)
        yield (
            f"at {bad} of {total} samples the commands were beyond the limits"
            if commanded
            else f"at {bad} of {total} samples solver {run.header.solver} gave no valid answer"
        )
    beyond = figures.get("beyond_limits_steps", {})
    for name, words, _ in EXCEEDED:
        if bad := beyond.get(name):
            yield f"{bad} of {total} samples had {words} than allowed"
