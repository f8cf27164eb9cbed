"""New robots of any proportions: six degrees of freedom, held at home, and free of interference.

Distances come from a closed form of this file, and cables inside the platform from points along them: neither shares
code with `cdpr.mechanics`. CDPR_TEMPLATE_CASES sets the number of random proportions of each layout.
"""

from __future__ import annotations

import itertools
import json
import os
import re

import numpy as np
import pytest
from click.testing import CliRunner
from spread import sampled

from cdpr.analysis.workspace import measure
from cdpr.base.errors import CdprError
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.template import Sizes, crowded, robot_data
from cdpr.ui.cli import cli

CASES = int(os.environ.get("CDPR_TEMPLATE_CASES", "1"))
DIAMETER = 0.01  # m
FREE = 0.8
CELLS = 7 if CASES > 1 else 5
ROUNDED = 1e-5  # m: anchors in files are rounded to 1e-6
UPRIGHT = [1.0, 0.0, 0.0, 0.0]

LAYOUTS = {
    "eight": {},
    "eight straight": {"crossed": False},
    "eight suspended": {"suspended": True},
    "eight suspended straight": {"suspended": True, "crossed": False},
    "seven": {"cables": 7},
    "seven straight": {"cables": 7, "crossed": False},
    "six": {"cables": 6},
    "four": {"cables": 4},
    "three": {"cables": 3},
    "planar": {"planar": True},
    "planar straight": {"planar": True, "crossed": False},
}
# Crossed suspended cables touch above flat platforms, as on any robot with this layout: the warning states it.
MAY_WARN = {"eight suspended"}


def proportions(count, seed):
    """Yield boxes of a frame of 1 to 10 m, at most four times as long as wide, and of a platform of 5 to 40 % of it."""
    rng = np.random.default_rng(seed)
    found = 0
    while found < count:
        frame = np.exp(rng.uniform(0.0, np.log(10.0), 3))
        if frame.max() <= 4.0 * frame.min():
            found += 1
            yield frame, frame * rng.uniform(0.05, 0.4, 3)


def between(P, Q, R, S):
    """Distance of segments PQ and RS, (K,), from points (K, 3): of their lines where within both, or of ends."""
    u, v, w = Q - P, S - R, P - R
    a, b, c = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    d, e = (u * w).sum(1), (v * w).sum(1)
    det = a * c - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = (b * e - c * d) / det, (a * e - b * d) / det
    within = (det > 1e-12 * a * c) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    inner = np.linalg.norm(w + np.where(within, s, 0)[:, None] * u - np.where(within, t, 0)[:, None] * v, axis=1)

    def to_end(X, A, along, square):
        share = np.clip(((X - A) * along).sum(1) / square, 0, 1)
        return np.linalg.norm(X - A - share[:, None] * along, axis=1)

    ends = np.minimum(to_end(P, R, v, c), to_end(Q, R, v, c))
    ends = np.minimum(ends, np.minimum(to_end(R, P, u, a), to_end(S, P, u, a)))
    return np.where(within, np.minimum(inner, ends), ends)


def free(data, positions):
    """Return True if no cable touches another or the platform, (K,), upright. Cables may share a common end."""
    A, B = (np.array([cable[side] for cable in data["cables"]]) for side in ("frame", "platform"))
    half = 0.5 * np.array(data["platform"]["shape"]["box"])
    tips = positions[:, None] + B
    good = np.ones(len(positions), dtype=bool)
    for i, j in itertools.combinations(range(len(A)), 2):
        if np.array_equal(B[i], B[j]):
            assert data["dof"] == ["x", "y", "z"]  # a point is where all cables end
            continue
        whole = np.zeros_like(positions)
        good &= between(A[i] + whole, tips[:, i], A[j] + whole, tips[:, j]) > DIAMETER
    along = np.concatenate([np.geomspace(1e-6, 1e-2, 9), np.linspace(0.02, 1.0, 50)])
    for i in range(len(A)):
        points = B[i] + along[:, None] * (A[i] - tips[:, i])[:, None]
        good &= ~(np.abs(points) < half - ROUNDED).all(axis=2).any(axis=1)
    return good


def grid(frame, platform, planar):
    middles = (np.arange(CELLS) + 0.5) / CELLS - 0.5
    sides = [middles * (a - b) for a, b in zip(frame, platform, strict=True)]
    if planar:
        sides[1] = np.zeros(1)
    positions = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.asarray(positions + np.array([0.0, 0.0, 0.5 * frame[2]]))


def made(sizes):
    data = robot_data(sizes, "new")
    return data, RobotSection.model_validate_json(json.dumps(data)).to_robot()


@sampled(2, "name", [pytest.param(name, marks=pytest.mark.slow if "straight" in name else ()) for name in LAYOUTS])
def test_templates_of_random_proportions(name):
    planar, failures = "planar" in name, []
    for frame, platform in proportions(CASES, seed=len(name)):
        if planar and platform[1] < 3 * DIAMETER:
            platform[1] = 3 * DIAMETER
        sizes = Sizes(frame=tuple(frame), platform=tuple(platform), **LAYOUTS[name])
        data, robot = made(sizes)
        poses = np.vstack([robot.home[:3], grid(frame, platform, planar)])
        static = measure(robot, np.hstack([poses, np.tile(UPRIGHT, (len(poses), 1))])).value >= 0.0
        good = free(data, poses)
        assert static[0], (frame, platform)
        assert good[0], (frame, platform)
        chords = robot.anchors[:, :3] - robot.home[:3] - robot.anchors[:, 3:]
        units = chords / np.linalg.norm(chords, axis=1)[:, None]
        rows = np.hstack([units, np.cross(robot.anchors[:, 3:], units) / robot.characteristic_length]).T[robot.rows]
        assert np.linalg.matrix_rank(rows, tol=1e-4) == robot.n
        if good[static].mean() < FREE and crowded(sizes) is None:
            failures.append((frame, platform, good[static].mean()))
        if crowded(sizes) is not None:
            assert name in MAY_WARN, (frame, platform)
    assert not failures


@pytest.mark.slow
def test_a_crowded_template_is_reported_with_numbers(tmp_path):
    words = ["new", "robot", str(tmp_path / "r.yaml"), "--suspended", "--platform", "0.4,0.3,0.02"]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0
    told = re.search(
        r"cables of 10 mm touch each other or the platform at (\d+) of the (\d+) upright poses", done.stderr
    )
    assert 0.2 < int(told[1]) / int(told[2]) < 1.0
    assert "or straight cables (--straight)" in done.stderr
    assert (
        "touch" not in CliRunner().invoke(cli, [*words[:2], str(tmp_path / "s.yaml"), *words[3:], "--straight"]).stderr
    )
    thin = CliRunner().invoke(cli, ["new", "robot", "-", "--planar", "--platform", "0.4,0.005,0.2"])
    assert "touch each other or the platform at home, and at" in thin.stderr


@pytest.mark.parametrize("count", [0, 1, 2, 5, 9])
def test_other_numbers_of_cables_are_refused(count):
    with pytest.raises(CdprError, match=rf"suspended \(--suspended\), 8 or 6 .*; got {count};"):
        robot_data(Sizes(cables=count), "new")
    with pytest.raises(CdprError, match="got 7 suspended"):
        robot_data(Sizes(cables=7, suspended=True), "new")
