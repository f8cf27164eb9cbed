"""Passages of cables by their anchors and swivel axes: found before a run, and not judged after it."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from cdpr import load_scenario, simulate
from cdpr.model import rotations
from cdpr.scenario.plausible.passages import NEAR, passages
from cdpr.trajectory import Knot, Trajectory, through
from cdpr.ui.report.pages.run import write_report

MOTIONS = int(os.environ.get("CDPR_TEST_CASES", "10"))  # random ones

SCENARIO = """
robot:
  name: pass
  dof: [x, y, z]
  platform: {mass: 5}
  tension: {min: 0, max: 300}
  home: {position: [0, 0, 1.0]}
  cables:
  - {frame: [-2, -2, 3], platform: [0, 0, 0]}
  - {frame: [2, -2, 3], platform: [0, 0, 0]}
  - {frame: [0, 2, 3], platform: [0, 0, 0]}
  - {frame: [0.5, 0, HEIGHT], platform: [0, 0, 0]EXIT}
simulation: {backend: reference, duration: 1.2, control_step: 0.002}
trajectory: {type: quintic, duration: 2, to: {position: [END, 0, 1.0]}}
"""
PULLEY = ", exit: {type: pulley, radius: 0.05, axis: [0, 0, -1]}"


def written(height=1.0, exit="", end=1.0):
    return SCENARIO.replace("HEIGHT", str(height)).replace("EXIT", exit).replace("END", str(end))


@pytest.mark.parametrize(
    ("text", "where"),
    [(written(), "anchor"), (written(3.0, PULLEY), "swivel axis")],
)
def test_a_passage_is_reported_before_the_run_and_leaves_no_energy_balance(tmp_path, text, where):
    scenario = load_scenario(tmp_path / "s.yaml", text=text)
    (warning,) = [each.text for each in scenario.warnings if "passes" in each.text]
    assert warning.startswith(f"cable 'cable_4' passes its {where} at 1 s")
    run = simulate(scenario)
    figures = run.summary()
    assert figures["passed"].startswith(f"cable 'cable_4' passes its {where} at 1")
    assert not figures["energy_J"]["balanced"]
    write_report(run, tmp_path / "report.html", {})
    page = (tmp_path / "report.html").read_text()
    assert "not judged, cable" in page
    assert "out of balance" not in page


@pytest.mark.parametrize("text", [written(1.0, end=0.45), written(3.0), written(3.0, PULLEY, end=0.45)])
def test_other_motions_are_not(tmp_path, text):
    scenario = load_scenario(tmp_path / "s.yaml", text=text)
    assert not [each for each in scenario.warnings if "passes" in each.text]
    assert "passed" not in simulate(scenario).summary()


def test_a_motion_along_the_axis_passes_nothing():
    knots = [Knot(t, np.array([0.5, 0.0, z]), np.array([1.0, 0, 0, 0])) for t, z in ((0.0, 1.0), (1.0, 2.0))]
    anchors = np.array([[0.5, 0.0, 3.0, 0.0, 0.0, 0.0]])
    assert passages(through(knots).segments, anchors, np.array([[0.0, 0.0, 1.0]])) == []


def test_a_motion_that_ends_right_behind_the_axis_passes_it():
    knots = [Knot(t, np.array([x, 0.0, 1.0]), np.array([1.0, 0, 0, 0])) for t, x in ((0.0, 0.0), (1.0, 0.501))]
    anchors, axes = np.array([[0.5, 0.0, 3.0, 0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    (found,) = passages(through(knots).segments, anchors, axes)
    assert found.axis
    assert found.distance < 1e-6
    knots[1] = replace(knots[1], position=np.array([0.5, 0.0, 1.0]))
    assert passages(through(knots).segments, anchors, axes) == []


def _random(rng, axis):
    """Return a motion, anchors (1, 6), the axis and the time of a passage in a random segment."""
    count = int(rng.integers(2, 6))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 3.0, count))])
    knots = []
    for time in times:
        q = rng.normal(size=4)
        knots.append(Knot(float(time), rng.uniform(-2.0, 2.0, 3), q / np.linalg.norm(q)))
    motion: Trajectory = through(knots)
    arm = rng.uniform(-0.5, 0.5, 3)
    k = int(rng.integers(count))
    time = float(times[k] + (times[k + 1] - times[k]) * rng.uniform(0.1, 0.9))
    at = motion.sample(time)
    tip = at[:3] + rotations.matrix(at[3:7]) @ arm
    direction = rng.normal(size=3)
    direction = direction / np.linalg.norm(direction) if axis else np.zeros(3)
    frame = tip + rng.uniform(0.5, 2.0) * direction
    return motion, np.concatenate([frame, arm])[None], direction[None], time


@pytest.mark.parametrize("axis", [False, True])
@pytest.mark.usual("True")
def test_random_passages_are_found_whenever_they_are(axis):
    rng = np.random.default_rng(int(os.environ.get("CDPR_TEST_SEED", "5")))
    for _ in range(MOTIONS):
        motion, anchors, axes, time = _random(rng, axis)
        found = passages(motion.segments, anchors, axes)
        assert min(abs(one.time - time) for one in found) < 1e-3
        # A search of many samples finds no more, and a motion that misses by more than is near none.
        samples = np.array([motion.sample(t) for t in np.linspace(0.0, motion.end, 2000)])
        tips = np.array([s[:3] + rotations.matrix(s[3:7]) @ anchors[0, 3:] for s in samples]) - anchors[0, :3]
        length = np.linalg.norm(tips, axis=1).max()
        tips -= (tips @ axes[0])[:, None] * axes[0]
        far = np.linalg.norm(tips, axis=1)
        for one in found:
            near = np.abs(np.linspace(0.0, motion.end, 2000) - one.time) <= motion.end / 1999
            assert far[near].min() <= one.distance + np.abs(np.diff(far)).max() + NEAR * length
            assert one.distance <= 1.001 * NEAR * length  # of the samples
        apart = np.flatnonzero(np.diff((far < 0.5 * NEAR * far.max()).astype(int)) == 1) + 1
        assert axis or all(min(abs(one.time - t) for one in found) < 0.1 for t in apart * motion.end / 1999)
