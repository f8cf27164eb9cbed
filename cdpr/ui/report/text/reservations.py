"""Warnings about completed runs: missing tensions, limit violations, lost platforms."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from cdpr.log.limit_violations import KINDS, TENSIONS
from cdpr.log.run import Run
from cdpr.log.singular import PASSED
from cdpr.mechanics.contacts import passing
from cdpr.tension.command import BEYOND
from cdpr.tension.policy import CLIPPED, FALLBACK

# Of the samples: above this, the run shows the behaviour of the fallback rather than that of the solver.
LARGE_SHARE = 0.1

# Periods of a sensor: random losses are hardly ever this long (a chance of 1e-6 if every second measurement is lost).
SILENT = 20.0

# Mean NEES per value above which errors are, on average, more than twice as large as the covariance states.
DECEIVED = 4.0


def reservations(run: Run) -> Iterator[str]:
    """Yield the warnings as parts of a sentence, first those on lost sensors and steps."""
    figures = run.summary()
    total = figures["samples"]
    yield from silent(run)
    if bad := figures.get("estimate", {}).get("unfitted_samples"):
        yield f"the measured lengths fit no pose at {bad} of {total} samples"
    yield from deceived(figures)
    if bad := figures.get("lost_steps"):
        yield f"the steppers lost {bad} full steps"
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
    for kind in KINDS:
        if bad := beyond.get(kind.name):
            yield f"{bad} of {total} samples had {kind.words} than allowed"
    if (bad := figures.get("slack_samples")) and not run.header.ideal_cables:
        yield f"{bad} of {total} samples had slack cables"
    if passed := figures.get(PASSED):
        yield f"{passed}, where its force reverses within a step: results are not reliable"
    if (gap := figures.get("clearance_min_m", 0.0)) < 0.0:
        yield passing(names := figures["clearance_min_by"], gap) or f"{names} touched"


def silent(run: Run) -> Iterator[str]:
    """Yield the sensors without measurements at the end of a run, for much longer than their period and delay."""
    if not len(run.rows):
        return
    last = np.asarray(run.rows[-1:])[0]
    columns = run.header.layout.columns
    for sensor in run.header.sensors:
        name, step = sensor["name"], run.header.control_step
        if f"{name}_age" not in columns:  # a camera
            continue
        age, end = float(last[columns[f"{name}_age"]][0]), float(last[columns["time"]][0])
        late = float(sensor.get("delay", 0.0)) + float(sensor.get("jitter", 0.0))
        if age > late + SILENT * max(float(sensor["period"]), step):
            yield f"sensor '{name}' took no measurement after {end - age:.6g} s"
        elif f"{name}_seen" in columns and not last[columns[f"{name}_seen"]].any():
            yield f"sensor '{name}' sees no marker at the end"


def deceived(figures: dict[str, Any]) -> Iterator[str]:
    """Yield a warning if the errors of the estimate are much larger than its covariance."""
    nees = (figures.get("estimate", {}).get("nees") or {}).get("mean_per_value", 0.0)
    if nees > DECEIVED:
        times = f"{math.sqrt(nees):.3g} times"
        yield f"the estimate's errors are {times} its standard deviations (NEES {nees:.3g} per value)"


def overstrained(run: Run) -> Iterator[str]:
    """Yield the violations of the limits by the true tensions."""
    words = tuple(kind.words for kind in TENSIONS)
    yield from (event.text for event in run.events if event.kind == "limit" and event.text.startswith(words))


def fallback(run: Run) -> Iterator[str]:
    """Yield a warning if a large share of the tensions came from the fallback instead of the solver."""
    figures = run.summary()
    bad, total = figures["infeasible_steps"] + figures["unanswered_steps"], figures["samples"]
    used = [text for text in (*FALLBACK.values(), CLIPPED) if any(f"; {text}" in f"; {one.text}" for one in run.events)]
    if used and bad >= LARGE_SHARE * total:
        share = f"all {total}" if bad == total else f"{bad} of {total}"
        yield f"the tensions at {share} samples come from the fallback: {' and '.join(used)}"


def lost(run: Run) -> Iterator[str]:
    """Yield a warning if the platform was farther from its desired position than the robot's size."""
    if not len(run.rows):
        return
    anchors = np.array(run.header.anchors)[:, :3]
    # The rows of a long run remain on disk: only these two are read, the rest comes from the summary.
    first, last = (Run(run.header, np.asarray(run.rows[k : k + 1])) for k in (0, len(run.rows) - 1))
    corners = np.vstack([anchors, first.position])  # all anchors may coincide
    size, final = (float(np.linalg.norm(each)) for each in (np.ptp(corners, axis=0), last.position_error))
    most = run.summary()["position_error_m"]["max"]
    if not final <= size:
        yield f"the platform ends {final:.4g} m from its desired position: more than the robot's size, {size:.4g} m"
    elif not most <= size:
        yield f"the platform was up to {most:.4g} m from its desired position: more than the robot's size, {size:.4g} m"
