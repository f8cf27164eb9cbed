"""Robots and states that many tests share."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from cdpr.formats.read import limits
from cdpr.model import Cable, Platform, Robot, rotations
from cdpr.model.robot import frozen_array
from cdpr.plugins.registry import registry

# Fixtures beside those of this file; a second conftest.py would take this one's name from those who import it.
pytest_plugins = ["browser_pages", "window_page"]

# The same examples each time, and more of them in CI; no deadline, for a busy machine takes long.
EXAMPLES = int(os.environ.get("CDPR_EXAMPLES", "10"))
if EXAMPLES <= 10:  # without constants of our sources among them: to read all sources takes each worker seconds
    providers.is_local_module_file = lambda path: False
settings.register_profile("cdpr", deadline=None, derandomize=True, max_examples=EXAMPLES)
settings.load_profile("cdpr")

# Tests send signals to what they start, which must not have inherited from a CI in the background that it ignores them.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


def pytest_configure(config: pytest.Config) -> None:
    """Let each worker import other tests first if it imports all: the others then find these files compiled."""
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker is not None and config.args == config.getini("testpaths"):
        of_files = [TESTS / file.relative_to(TESTS).parts[0] for file in sorted(TESTS.rglob("test_*.py"))]
        folders = [str(folder) for folder in dict.fromkeys(of_files)]
        begin = len(of_files) * int(worker.removeprefix("gw")) // int(os.environ["PYTEST_XDIST_WORKER_COUNT"])
        first = folders.index(str(of_files[begin]))
        config.args = [*folders[first:], *folders[:first]]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the cases of a test marked `usual` slow that no pattern names, if one is named; reject slow `core` tests.

    The order is that of the files, in each worker.
    """
    items.sort(key=lambda item: item.path.parts)
    tests: dict[tuple[Path, str], list[pytest.Function]] = {}
    for item in items:
        if isinstance(item, pytest.Function) and item.get_closest_marker("usual"):
            tests.setdefault((item.path, item.originalname), []).append(item)
    for cases in tests.values():
        rest = [case for case in cases if not named(case)]
        for case in rest if len(rest) < len(cases) else ():
            case.add_marker(pytest.mark.slow)
    for item in items:
        if item.get_closest_marker("core") and item.get_closest_marker("slow"):
            raise pytest.UsageError(f"{item.nodeid} is marked core and slow; remove one of the marks")


def named(case: pytest.Function) -> bool:
    """Return whether a pattern of its mark `usual` names a case of a test."""
    mark = case.get_closest_marker("usual")
    return mark is not None and any(fnmatchcase(case.callspec.id, pattern) for pattern in mark.args)


# A search for garbage during the collection of tests finds nothing and costs a quarter of it.
gc.disable()


def pytest_collection_finish() -> None:
    """Some tests collect garbage, by the dozen: what pytest and all modules hold till the end takes no part in it."""
    gc.freeze()
    gc.set_threshold(10_000, 10, 10)
    gc.enable()


# Child processes find compiled modules, also if the environment disables their cache.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

TESTS = Path(__file__).parent
ROOT = TESTS.parent
TRAPS = TESTS / "plugins" / "traps" / "installed"
FAULTY = TESTS / "plugins" / "faulty"
GRAVITY = np.array([0.0, 0.0, -9.81])


def make_robot(
    anchors: np.ndarray,
    *,
    mass: float = 50.0,
    inertia: np.ndarray | None = None,
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0),
    limits: tuple[float, float] = (1.0, 1000.0),
) -> Robot:
    """A robot from anchors (m, 6)."""
    platform = Platform(
        mass, frozen_array(np.diag([2.0, 3.0, 4.0]) if inertia is None else inertia), frozen_array(center_of_mass)
    )
    cables = tuple(Cable(row[:3], row[3:], *limits) for row in anchors)
    return Robot(platform, cables, name="test", unilateral=limits[0] >= 0.0)


def crossed_box(rng: np.random.Generator, m: int) -> np.ndarray:
    """Anchors (m, 6) of a redundantly held robot: corners of a 4 m cube, randomly moved, crossed to a small box."""
    corners = np.array([[x, y, z] for x in (-2, 2) for y in (-2, 2) for z in (0, 4)], dtype=float)
    anchors = np.empty((m, 6))
    for i in range(m):
        corner = corners[i % 8]
        anchors[i, :3] = corner + rng.uniform(-0.3, 0.3, 3)
        # On the far side in one direction: crossed cables can turn the platform both ways.
        sign = np.sign(corner - [0, 0, 2]) * ([-1, 1, 1] if i % 2 else [1, -1, -1])
        anchors[i, 3:] = sign * [0.25, 0.2, 0.15] + rng.uniform(-0.03, 0.03, 3)
    return anchors


def moved(state: np.ndarray, dt: float) -> np.ndarray:
    """The pose after `dt` at constant twist."""
    omega = state[10:13]
    angle = float(np.linalg.norm(omega)) * dt
    q = rotations.multiply(rotations.from_axis_angle(omega / np.linalg.norm(omega), angle), state[3:7])
    return np.concatenate([state[:3] + dt * state[7:10], q, state[7:]])


def random_state(rng: np.random.Generator, *, tilt: float = 0.3) -> np.ndarray:
    """A state (13,) near the middle of that cube, tilted by up to about `tilt` rad, moving."""
    v = rng.uniform(-tilt, tilt, 3)
    angle = float(np.linalg.norm(v))
    q = rotations.from_axis_angle(v / angle, angle)
    position = rng.uniform(-0.5, 0.5, 3) + np.array([0.0, 0.0, 2.0])
    return np.concatenate([position, q, rng.normal(size=3), rng.normal(size=3)])


@pytest.fixture(scope="session")
def offset_robot() -> Robot:
    """Eight cables, centre of mass off the origin, full inertia tensor."""
    rng = np.random.default_rng(7)
    R = rotations.matrix(rotations.from_rpy(0.4, -0.7, 1.1))
    inertia = R @ np.diag([2.0, 3.0, 4.0]) @ R.T
    return make_robot(crossed_box(rng, 8), inertia=(inertia + inertia.T) / 2, center_of_mass=(0.05, -0.03, 0.1))


@pytest.fixture(scope="module")
def faulty_plugin() -> Iterator[None]:
    """Installs for a file, here and in workers, a controller that raises, hangs, crashes, exits or is killed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FAULTY))
        registry.cache_clear()
        yield
    registry.cache_clear()


@pytest.fixture
def traps_plugin(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Installs, here and in workers, a backend that is another one with a fault."""
    monkeypatch.syspath_prepend(str(TRAPS))
    registry.cache_clear()
    yield
    registry.cache_clear()


@pytest.fixture(scope="module", autouse=True)
def _older_objects_are_no_garbage() -> None:
    """As `pytest_collection_finish`, of what earlier files left: a search then visits only a file's own objects."""
    gc.collect(1)
    gc.freeze()


@pytest.fixture(autouse=True)
def _imports_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Import without a process for each file, which `test_import_limits.py` tests."""
    monkeypatch.setattr(limits, "APART", False)
