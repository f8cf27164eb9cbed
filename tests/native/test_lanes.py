"""Kernels of controllers and of the loop in the kernel library: eight lanes have the bits of eight doubles."""

from __future__ import annotations

import numpy as np
import pytest
from kernel_cases import assert_same_bits, numbers, run, run_lanes

from cdpr.cables import Pulley
from cdpr.simulation.faults import FAULTS, JUMPED, NO_LENGTH, NOT_FINITE, TOO_FAST

PULLEY = Pulley(type="pulley", radius=0.1, axis=(0.3, -0.2, 0.9))
EACH = 240


def states(rng, count, width):
    """States or desired states, a third of them with unit quaternions."""
    found = numbers(rng, count, width)
    found[::3, 3:7] /= np.linalg.norm(found[::3, 3:7], axis=1)[:, None]
    return found


def same(name, inputs, shapes, before=None, **values):
    """Compare both, and return the status codes."""
    found, codes = run(name, inputs, shapes, before, **values)
    lanes, groups = run_lanes(name, inputs, shapes, before, **values)
    assert [group >> lane & 1 for group in groups for lane in range(8)] == (codes != 0).astype(int).tolist()
    for key, value in found.items():
        assert_same_bits(lanes[key], value)
    return codes


# Arrays of controllers: gains, other inputs, results, and memory.
CONTROLLERS = {
    "computed_torque": ((12,), {}, {}, {}),
    "static": ((12,), {}, {}, {}),
    "pid": ((12,), {"per_step": (2, 6)}, {}, {"integral": (6,)}),
    "sliding_mode": ((3, 2), {}, {"surface": (3,), "spin_surface": (3,)}, {}),
    "adaptive": ((2,), {"rates": (2,), "range": (3,)}, {"mass": (1,), "center": (3,)}, {"deviation": (4,)}),
}


@pytest.mark.parametrize("name", list(CONTROLLERS))
def test_controllers(name):
    rng, (gains, more, results, memory) = np.random.default_rng(1), CONTROLLERS[name]
    inputs = {
        "gains": np.abs(numbers(rng, EACH, *gains)),
        "inertial": numbers(rng, EACH, 13),
        "gravity": numbers(rng, EACH, 3),
        "state": states(rng, EACH, 13),
        "desired": states(rng, EACH, 19),
    }
    inputs |= {key: np.abs(numbers(rng, EACH, *shape)) for key, shape in more.items()}
    if memory:
        inputs["report"] = numbers(rng, EACH, 4)
        inputs["report"][::2, 0] = 0.0
    before = {key: numbers(rng, EACH, *shape) for key, shape in memory.items()} or None
    shapes = {"wrench": (6,)} | results | memory
    assert not same(name, inputs, shapes, before).any()


@pytest.mark.parametrize("pulleys", [False, True])
@pytest.mark.parametrize("period", [1e-3, 0.0])
def test_observation(pulleys, period):
    rng, m = np.random.default_rng(2), 8
    lines = numbers(rng, EACH, m, 14 if pulleys else 6)
    if pulleys:
        lines[..., 6], lines[..., 7:] = np.arange(m) % 2, PULLEY.numbers()
    live, before = states(rng, EACH, 13), states(rng, EACH, 13)
    before[::3] = live[::3]
    live[::3, 7:], before[::3, 7:] = 0.1 * live[::3, 7:], 0.1 * before[::3, 7:]
    before[::3, :3] -= period * live[::3, 7:10]
    live[::6, 7] *= 1e4
    before[3::6, 0] += 1.0
    lines[2::30, 0, 3:6], lines[2::30, 0, :3] = 0.0, live[2::30, :3]
    bounds = np.abs(numbers(rng, EACH, 7))
    bounds[:, 6] = rng.random(EACH) < 0.5
    inputs = {
        "lines": lines,
        "inertial": numbers(rng, EACH, 13),
        "gravity": numbers(rng, EACH, 3),
        "bounds": bounds,
        "live": live,
        "external": numbers(rng, EACH, 6),
        "highest": numbers(rng, EACH, m),
    }
    held = {"state": before, "length": numbers(rng, EACH, m), "energies": numbers(rng, EACH, 4)}
    unread = {"matrix": numbers(rng, EACH, 6, m), "rate": numbers(rng, EACH, m)}
    shapes = {key: value.shape[1:] for key, value in (held | unread).items()}
    found, codes = run("observe", inputs, shapes, held | unread, period=period)
    seen = {NOT_FINITE, NO_LENGTH, TOO_FAST, *([JUMPED] if period else [])}
    assert seen <= set(codes.tolist()) <= {0, *FAULTS}
    lanes, groups = run_lanes("observe", inputs, shapes, held | unread, period=period)
    assert [group >> lane & 1 for group in groups for lane in range(8)] == (codes != 0).astype(int).tolist()
    known = codes != NOT_FINITE  # of others, wrench matrix and rates are rubbish that is not read
    for key in shapes:
        each = known if key in unread else slice(None)
        assert_same_bits(lanes[key][each], found[key][each])
    lengths = {"matrix": (6, m), "length": (m,), "rate": (m,)}
    assert same("observe_nominal", {"lines": lines, "state": live}, lengths).any()


def test_small_operations():
    rng = np.random.default_rng(3)
    matrix, tension = numbers(rng, EACH, 6, 8), numbers(rng, EACH, 8)
    same("exert", {"matrix": matrix, "tension": tension}, {"wrench": (6,)})
    same("copy", {"source": tension}, {"target": (8,)})
    codes = same("not_finite", {"values": tension}, {})
    assert codes.tolist() == (~np.isfinite(tension).all(axis=1)).astype(int).tolist()
