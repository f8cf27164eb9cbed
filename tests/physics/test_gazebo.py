"""Exported worlds in Gazebo's physics library, where the system has it: what is pushed moves as a rigid body does."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.formats.write.export_model import Options, begin, export
from cdpr.model import rotations

LIBRARIES = ["ignition-physics5-sdf", "ignition-physics5", "ignition-plugin1-loader", "sdformat12"]
ENGINE = "libignition-physics5-dartsim-plugin.so"
SECONDS = 1.0

# Its steps of 1 ms are of first order: 1e-3 s of the speeds that are reached here, about 1 m/s and 2 rad/s; m, rad.
FIRST_ORDER = 3e-3


def package(*words):
    """Return the flags of pkg-config for the libraries, None if they are missing."""
    if shutil.which("pkg-config") is None or shutil.which("c++") is None:
        return None
    done = subprocess.run(["pkg-config", *words], capture_output=True, text=True, check=False)
    return done.stdout.split() if done.returncode == 0 else None


FLAGS = package("--cflags", "--libs", *LIBRARIES)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(FLAGS is None, reason="needs Gazebo's physics library (Debian: libignition-physics-dev)"),
]


@pytest.fixture(scope="module")
def stepped(tmp_path_factory):
    """Step a world and return where a link is then: place and quaternion, (7,)."""
    folder = tmp_path_factory.mktemp("gazebo")
    source = Path(__file__).parents[1] / "gazebo" / "step.cc"
    subprocess.run(["c++", "-std=c++17", str(source), "-o", str(folder / "step"), *FLAGS], check=True)
    (where,) = package("--variable=libdir", LIBRARIES[1])
    engine = Path(where).resolve() / ENGINE
    if not engine.exists():
        pytest.skip(f"needs {ENGINE} (Debian: libignition-physics5-dartsim-plugin5)")

    def step(subject, wrench, steps):
        (folder / "world.sdf").write_text(export(subject, "sdf", Options()))
        names = [subject.robot.name, "platform", str(steps), *(repr(float(part)) for part in wrench)]
        command = [str(folder / "step"), str(engine), str(folder / "world.sdf"), *names]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return np.array(done.stdout.split(), dtype=float)

    return step


def moved(subject, wrench, seconds, count=2000):
    """Return the pose of the platform's origin under a constant wrench: Newton-Euler by Runge-Kutta, (7,)."""
    body = subject.robot.platform

    def rate(y):
        q, omega = y[6:10] / np.linalg.norm(y[6:10]), y[10:]
        R = rotations.matrix(q)
        tensor = R @ body.inertia @ R.T
        moment = wrench[3:] - np.cross(R @ body.center_of_mass, wrench[:3])
        turning = np.linalg.solve(tensor, moment - np.cross(omega, tensor @ omega))
        spin = 0.5 * np.array([-omega @ q[1:], *(q[0] * omega + np.cross(omega, q[1:]))])
        return np.concatenate([y[3:6], wrench[:3] / body.mass + subject.gravity, spin, turning])

    place, q = subject.state[:3], subject.state[3:7]
    y = np.concatenate([place + rotations.matrix(q) @ body.center_of_mass, np.zeros(3), q, np.zeros(3)])
    h = seconds / count
    for _ in range(count):
        a = rate(y)
        b = rate(y + 0.5 * h * a)
        c = rate(y + 0.5 * h * b)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(y + h * c))
    q = y[6:10] / np.linalg.norm(y[6:10])
    return np.concatenate([y[:3] - rotations.matrix(q) @ body.center_of_mass, q])


@pytest.mark.parametrize(
    ("name", "push"),
    [("caroca", [90.0, -60.0, 120.0, 10.0, -5.0, 8.0]), ("off_centre_mass", [200.0, 100.0, 150.0, 40.0, 30.0, 20.0])],
)
def test_the_platform_moves_according_to_its_wrench(stepped, name, push):
    """Also where its centre of mass is elsewhere: the wrench is that at its origin, as W t is."""
    subject = begin(cdpr.load_scenario(ROOT / "scenarios" / f"{name}.yaml"))
    wrench = np.array(push)
    wrench[:3] -= subject.robot.platform.mass * subject.gravity
    steps = round(SECONDS / subject.step)
    found, wanted = stepped(subject, wrench, steps), moved(subject, wrench, SECONDS)
    found[3:] *= np.sign(found[3:] @ wanted[3:])
    assert np.linalg.norm(wanted[:3] - subject.state[:3]) > 0.2
    np.testing.assert_allclose(found, wanted, atol=FIRST_ORDER)
    np.testing.assert_allclose(stepped(subject, wrench, 0)[:3], subject.state[:3], atol=1e-12)


def test_a_guide_holds_what_it_holds(stepped):
    """A planar robot pushed in all directions moves in its plane alone."""
    subject = begin(cdpr.load_scenario(ROOT / "scenarios/planar.yaml"))
    free = np.isin(["x", "y", "z", "rx", "ry", "rz"], subject.robot.dof)
    wrench = np.array([2.0, 3.0, 1.0, 0.1, 0.02, 0.1])
    wrench[:3] -= subject.robot.platform.mass * subject.gravity
    found = stepped(subject, wrench, round(SECONDS / subject.step))
    wanted = moved(subject, wrench * free, SECONDS)
    assert np.linalg.norm(wanted[:3] - subject.state[:3]) > 0.05
    np.testing.assert_allclose(found * np.sign(found[3]), wanted * np.sign(wanted[3]), atol=FIRST_ORDER)
