"""What is added most often takes one new file and one line in a table: done here to a copy of the program."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from fmu.driver import Driver
from mcap.reader import make_reader
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from cdpr.log.reader import load_run
from cdpr.scenario import load_scenario

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")

SCENARIO = """
robot: caroca.yaml
simulation: {duration: 0.02}
initial: {position: [0, 0, 1.2]}
events:
- {type: gust, time: 0.005, speed: 12}
"""

EVENT = '''\
"""Wind."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Literal

from pydantic import Field

from cdpr.log.event import Event
from cdpr.scenario.events.event import ScenarioEvent, Swing, first_sample
from cdpr.fields import Positive, unit


class Gust(ScenarioEvent):
    """Wind along x, from its time on."""

    type: Literal["gust"] = Field(description="wind along x")
    speed: Positive = Field(description="speed of the air", json_schema_extra=unit("m/s"))

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        if self.speed > 60.0:
            yield "speed", f"must be at most 60 (m/s), got {self.speed:g}"

    def swing(self, step: float) -> Swing:
        force = 0.5 * 1.2 * self.speed**2
        return Swing(first_sample(self.time, step), math.inf, 0.0, 0.5 * math.pi, (force, 0.0, 0.0, 0.0, 0.0, 0.0))

    def tell(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
        yield Event(first_sample(self.time, step) * step, self.type, f"wind of {self.speed:g} m/s")
'''

RISE = """
robot: {}.yaml
simulation: {{duration: 1.1}}
initial: {{position: {}}}
trajectory: {{type: rise, height: 0.1}}
"""

MOTION = '''\
"""Straight and even, from one end to the other."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field

from cdpr import trajectory
from cdpr.fields import Positive, unit
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Pose, Report, pose, posed
from cdpr.scenario.problems import Path


class Rise(Motion):
    """Straight up, and then held."""

    type: Literal["rise"] = Field(description="straight up")
    height: Positive = Field(description="how far", json_schema_extra=unit("m"))
    at: Pose = Field(Pose(), description="where it begins")

    def poses(self) -> list[tuple[Path, Posed]]:
        return [(("at",), self.at)]

    def stay(self, guide: Guide, report: Report) -> None:
        if guide.held[2]:
            report.say(("height",), f"{guide.free}, so it cannot rise")

    def complete(self, initial: Initial) -> Self:
        return self.model_copy(update={"at": posed(self.at, initial)})

    def make(self) -> trajectory.Trajectory:
        position, attitude = pose(self.at)
        top = trajectory.Knot(1.0, position + [0, 0, self.height], attitude)
        return trajectory.through([trajectory.Knot(0.0, position, attitude), top])
'''


RING = '''\
"""A ring that slides without friction on a straight rail: the cable is always square to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.cables.exit import Exit
from cdpr.fields import Vector3


class Ring(Exit):
    """A ring on a rail along x, y or z."""

    kernels: ClassVar[str] = "cdpr.cables.ring.kernels"
    type: Literal["ring"] = Field(description="a ring that slides on a rail")
    rail: Vector3 = Field(description="direction of the rail, of length 1")

    def numbers(self) -> Sequence[float]:
        return self.rail

    def outline(self, frame: Sequence[float], leaving: Sequence[float]) -> list[list[float]]:
        return [list(frame), list(leaving)]
'''

RING_KERNELS = """\
from cdpr.cables.lines import NUMBERS
from cdpr.model.jit import kernel
from cdpr.model.kernels import dot, vector


@kernel
def leave(row, P):
    rail = vector(row, NUMBERS)
    s = dot(rail, (P[0] - row[0], P[1] - row[1], P[2] - row[2]))
    return (row[0] + s * rail[0], row[1] + s * rail[1], row[2] + s * rail[2])


@kernel
def lead(row, P):
    E = leave(row, P)
    return (E[0], E[1], E[2], 0.0)


@kernel
def carry(row, P, V):
    rail = vector(row, NUMBERS)
    s = dot(rail, V)
    return (s * rail[0], s * rail[1], s * rail[2])
"""

SPRING = '''\
"""A spring of constant stiffness in each cable."""

from cdpr.cables.chain import Number, Span

STIFFNESS = Number("cable.axial_stiffness", "N", "stiffness", positive=True)
SPRING = Span(needs=("axial_stiffness",), kernels="cdpr.cables.spring.kernels", numbers=(STIFFNESS,))
'''

SPRING_KERNELS = """\
from cdpr.model.jit import kernel


@kernel
def pull(numbers, length, unwound, stretching, lowest):
    tension = numbers[0] * (length - unwound)
    return lowest if tension < lowest else tension


@kernel
def rest(numbers, length, tension):
    return length - tension / numbers[0]
"""

SPRING_IN_C = """\
#include "parts.h"

double spring_pull(const double *numbers, double length, double unwound, double stretching, double lowest) {
    const double tension = numbers[0] * (length - unwound);
    (void)stretching;
    return tension < lowest ? lowest : tension;
}

double spring_rest(const double *numbers, double length, double tension) { return length - tension / numbers[0]; }
"""

HEAVY = '''\
"""An elastic cable that sags a little, as a parabola: its chord's tension, and half of its weight at each end."""

from cdpr.cables.chain import Number, Span

NUMBERS = (Number("cable.axial_stiffness", "N", "stiffness"), Number("cable.linear_density", "kg/m", "mass"))
NEEDS = ("axial_stiffness", "linear_density")
HEAVY = Span(needs=NEEDS, kernels="cdpr.cables.heavy.kernels", numbers=NUMBERS, bends=True)
'''

HEAVY_KERNELS = """\
import math

from cdpr.model.jit import kernel


@kernel
def pull(numbers, chord, wound, unwound, stretching, lowest, gravity):
    reach = math.sqrt(chord[0] * chord[0] + chord[1] * chord[1] + chord[2] * chord[2])
    along = max(lowest, numbers[0] * (reach + wound - unwound) / unwound) / reach
    half = 0.5 * numbers[1] * unwound
    down = (half * gravity[0], half * gravity[1], half * gravity[2])
    up = (along * chord[0] - down[0], along * chord[1] - down[1], along * chord[2] - down[2])
    at_winch = math.sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2])
    return (along * chord[0] + down[0], along * chord[1] + down[1], along * chord[2] + down[2], at_winch)


@kernel
def rest(numbers, chord, wound, tension, gravity):
    reach = math.sqrt(chord[0] * chord[0] + chord[1] * chord[1] + chord[2] * chord[2])
    return (reach + wound) / (1.0 + tension / numbers[0])
"""

# What the backend `reference` makes of a robot on such cables, by both schemes with two steps each: pose, twist,
# tensions and the work of the cables.
HEAVY_MOVES = """\
import json
import sys

from cdpr.plugins.registry import registry
from cdpr.scenario import load_scenario

told = []
for scheme in ("rk4", "semi_implicit_euler"):
    for step in (1e-3, 5e-4):
        changes = json.loads(sys.argv[2]) | {"backend_options.reference.scheme": scheme}
        scenario = load_scenario(sys.argv[1], overrides=changes)
        entry = registry().get("backend", "reference")
        backend = entry.make(scenario.robot, scenario.gravity, step, scenario.backend_options("reference"))
        backend.reset(scenario.initial.state())
        backend.command[:], backend.external[:] = json.loads(sys.argv[3])
        backend.step(round(float(sys.argv[4]) / step))
        tension = 0.0 * backend.command
        backend.read_tension(tension)
        told.append([*backend.state, *tension, backend.cable_work()])
print(json.dumps(told))
"""
HEAVY_TIME = 0.03  # s, of it

COLUMN = """    Column("speed", 1, "m/s", "Speed of the origin"),
"""

MEASURED = """
        speed, velocity, distribute_only = self.view("speed"), self.view("velocity"), distribute

        def measure_and_distribute() -> None:
            speed[0] = np.sqrt(velocity @ velocity)
            distribute_only()

        distribute = measure_and_distribute
"""


SPRING_LAW = """\
from cdpr.plugins import Controller


class Spring(Controller):
    def control(self, time, state, desired, wrench):
        wrench[:] = 0.0
        wrench[:3] = 5000.0 * (desired[:3] - state[:3]) - self.robot.platform.mass * self.gravity
"""

COMMAND = '''\
"""`cdpr cables`."""

import click


@click.command("cables")
@click.argument("file")
def command(file: str) -> None:
    """Name the cables of a robot."""
    from cdpr import load_robot

    click.echo(", ".join(cable.name for cable in load_robot(file).cables))
'''


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the program, a function that adds to it, and one that calls its command line."""
    folder = tmp_path_factory.mktemp("tree")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))

    def add(file, text, table, **lines):
        """Write the file, and into the table what follows on certain words."""
        if file is not None:
            (folder / file).write_text(text)
        content = (folder / table).read_text()
        for what, after in lines.values():
            assert content.count(after) == 1
            content = content.replace(after, after + what)
        (folder / table).write_text(content)

    def run(*arguments, **environment):
        return subprocess.run(
            [sys.executable, "-m", "cdpr", *map(str, arguments)],
            env={**os.environ, "PYTHONPATH": str(folder), **environment},
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=300,
        )

    return folder, add, run


def test_an_event(tree):
    folder, add, run = tree
    add(
        "cdpr/scenario/events/gust.py",
        EVENT,
        "cdpr/scenario/events/__init__.py",
        imported=("from cdpr.scenario.events.gust import Gust\n", "import CableBreak, CableJam\n"),
        named=("Gust | ", "AnyEvent = Annotated["),
    )
    scenario = folder / "gust.yaml"
    scenario.write_text(SCENARIO)
    shutil.copy(ROOT / "scenarios" / "robots" / "caroca.yaml", folder)
    wrong = run("validate", scenario, "--set", "events[0].speed=99")
    assert wrong.returncode == 2
    assert "events[0].speed: must be at most 60 (m/s), got 99" in wrong.stderr
    unknown = run("validate", scenario, "--set", "events[0].type=gist")
    assert "did you mean 'gust'?" in unknown.stderr
    done = run("run", scenario, "--no-report", "--out", folder / "run")
    assert done.returncode == 0, done.stderr
    assert "wind of 12 m/s" in done.stdout
    told = load_run(folder / "run")
    assert [(event.time, event.kind) for event in told.events] == [(0.005, "gust")]
    np.testing.assert_allclose(told.external[[4, 5], 0], [0.0, 86.4])


def test_a_motion(tree):
    folder, add, run = tree
    add(
        "cdpr/scenario/motions/rise.py",
        MOTION,
        "cdpr/scenario/motions/__init__.py",
        imported=("from cdpr.scenario.motions.rise import Rise\n", "import Knot, Quintic\n"),
        named=("Rise | ", "AnyMotion = Annotated[\n    "),
    )
    for robot, position in (("caroca", [0, 0, 1.2]), ("carriage", [0, 0, 0.5])):
        shutil.copy(ROOT / "scenarios" / "robots" / f"{robot}.yaml", folder)
        (folder / f"rise_{robot}.yaml").write_text(RISE.format(robot, position))
    wrong = run("validate", folder / "rise_carriage.yaml")
    assert wrong.returncode == 2
    assert "trajectory.height: the robot moves along" in wrong.stderr
    done = run("run", folder / "rise_caroca.yaml", "--no-report", "--out", folder / "rise")
    assert done.returncode == 0, done.stderr
    np.testing.assert_allclose(load_run(folder / "rise").desired_position[-1], [0.0, 0.0, 1.3])


def test_a_column(tree):
    """A line in the table, and the lines that compute it."""
    folder, add, run = tree
    add(None, "", "cdpr/columns.py", named=("\n" + COLUMN, "LATER: tuple[Column, ...] = ("))
    place = "            distribute = self._exerting(distribute)\n"  # what completes a sample
    add(None, "", "cdpr/simulation/sample.py", written=(MEASURED, place))
    scenario = ROOT / "scenarios" / "caroca.yaml"
    short = ("--set", "simulation.duration=0.02", "--no-report")
    # The table is among the sources of kernels, as plugins import it: not to compile them anew for twenty steps.
    done = run("run", scenario, *short, "--out", folder / "speedy", NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    told = load_run(folder / "speedy")  # by this version, whose table has no such line
    np.testing.assert_allclose(told["speed"], np.linalg.norm(told.velocity, axis=1), rtol=1e-15)
    done = run("export", folder / "speedy", "--to", "csv", "--out", folder / "speedy.csv")
    assert done.returncode == 0, done.stderr
    names, *lines = (folder / "speedy.csv").read_text().splitlines()
    assert names.split(",")[-1] == "speed_m_per_s"
    assert [float(line.split(",")[-1]) for line in lines] == told["speed"].tolist()
    with (folder / "speedy" / "log.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert "/cdpr/speed" in {channel.topic for channel in summary.channels.values()}


@pytest.mark.slow
def test_parts_of_cables(tree):
    """A folder each, which holds the part and its kernels, and a line in the table."""
    folder, add, run = tree
    for name, text, kernels in (("ring", RING, RING_KERNELS), ("spring", SPRING, SPRING_KERNELS)):
        (folder / "cdpr" / "cables" / name).mkdir()
        (folder / "cdpr" / "cables" / name / "__init__.py").write_text(text)
        (folder / "cdpr" / "cables" / name / "kernels.py").write_text(kernels)
    add(
        None,
        "",
        "cdpr/cables/__init__.py",
        ring=("from cdpr.cables.ring import Ring\n", "from cdpr.cables.pulley import Pulley\n"),
        spring=("from cdpr.cables.spring import SPRING\n", "from cdpr.cables.point import Point\n"),
        named=("Ring | ", "AnyExit = Annotated["),
        model=('    "sprung": Chain(DRUM, SPRING),\n', "MODELS = {\n"),
    )
    ring, sprung = "robot.cables[0].exit={type: ring, rail: [1.0, 0.0, 0.0]}", "robot.cable.model=sprung"
    winch = ROOT / "scenarios" / "winch.yaml"
    unknown = run("validate", winch, "--set", "robot.cable.model=spring")
    assert "one of sprung, " in unknown.stderr
    assert "ideal, rigid, elastic expected, got 'spring'" in unknown.stderr
    lacking = run("validate", ROOT / "scenarios" / "caroca.yaml", "--set", sprung)
    assert "cable.model sprung needs the axial stiffness (N) of each cable" in lacking.stderr
    short = ("--set", "simulation.duration=0.02", "--no-report", "--out", folder / "parts")
    done = run("run", winch, "--set", ring, "--set", sprung, *short, NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    told = load_run(folder / "parts")
    tips = told.position + np.array([0.6, -0.3, -0.2])  # it hardly turns in so short a time
    np.testing.assert_allclose(told.length[:, 0], np.hypot(tips[:, 1] + 2.0, tips[:, 2] - 3.5), atol=1e-6)
    assert told.header.cable_model == "sprung"
    assert (told.cable_tension > 50.0).all()

    # Neither has C. An FMU is not made of less than the robot; with its C beside it, the part is in it.
    fmu = ("fmu", "export", winch, "-o", folder / "parts.fmu", "--force", "--with-winch", "--json")
    refused = run(*fmu, "--set", ring, NUMBA_DISABLE_JIT="1")
    assert refused.returncode == 2
    assert "cable 'cable_1': the exit ring has no C (ring.c beside its kernels)" in refused.stderr
    refused = run(*fmu, "--set", sprung, NUMBA_DISABLE_JIT="1")
    assert refused.returncode == 2
    assert "cable 'cable_1': the span of model sprung has no C (spring.c beside its kernels)" in refused.stderr
    (folder / "cdpr" / "cables" / "spring" / "spring.c").write_text(SPRING_IN_C)
    done = run(*fmu, "--set", sprung, NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    with Driver(folder / "parts.fmu") as driver:
        driver.set("command", np.full(8, 300.0))
        stretch = driver.get("cable_length") - driver.get("unstretched_length")
        np.testing.assert_allclose(driver.get("cable_tension"), 1e5 * stretch, rtol=1e-9)
        np.testing.assert_allclose(driver.get("cable_tension"), 300.0, rtol=1e-9)


def heavy_oracle(robot, state, gravity, command, external):
    """The same by scipy, from the equations: elastic chords, half of a cable's weight at each end, drums, Euler."""
    A, B, m = robot.anchors[:, :3], robot.anchors[:, 3:], robot.m
    winch, EA = robot.cables[0].winch, robot.cables[0].axial_stiffness
    density = np.array([cable.linear_density for cable in robot.cables])
    inertia, mass, r = robot.platform.inertia, robot.platform.mass, winch.drum_radius

    def cables(y):
        R = Rotation.from_quat(y[3:7], scalar_first=True).as_matrix()
        arms = B @ R.T
        line = A - y[:3] - arms
        length, unwound = np.linalg.norm(line, axis=1), y[13 : 13 + m]
        chord = (np.maximum(EA * (length / unwound - 1.0), 0.0) / length)[:, None] * line
        half = 0.5 * (density * unwound)[:, None] * gravity
        return R, arms, line, length, chord + half, np.linalg.norm(chord - half, axis=1)

    def slope(t, y):
        R, arms, _, _, force, tension = cables(y)
        w, speed = y[10:13], y[13 + m : 13 + 2 * m]
        moment = np.cross(arms, force).sum(axis=0) + external[3:]
        about = R @ inertia @ R.T
        friction = winch.viscous_friction * speed + winch.coulomb_friction * np.tanh(speed / winch.coulomb_speed)
        turning = 0.5 * np.array([-w @ y[4:7], *(y[3] * w + np.cross(w, y[4:7]))])
        acceleration = (force.sum(axis=0) + external[:3]) / mass + gravity
        spin = np.linalg.solve(about, moment - np.cross(w, about @ w))
        power = np.sum(force * (y[7:10] + np.cross(w, arms)))
        drums = (r * (command - tension) - friction) / winch.inertia
        return np.concatenate([y[7:10], turning, acceleration, spin, -r * speed, drums, [power]])

    y = np.concatenate([state, np.ones(m), np.zeros(m + 1)])
    _, arms, line, length, _, _ = cables(y)
    y[13 : 13 + m] = length / (1.0 + command / EA)
    y[13 + m : 13 + 2 * m] = np.sum(line / length[:, None] * (state[7:10] + np.cross(state[10:], arms)), axis=1) / r
    y = solve_ivp(slope, (0.0, HEAVY_TIME), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return np.concatenate([y[:13], cables(y)[-1], y[-1:]])


@pytest.mark.slow
def test_a_span_that_bends(tree):
    """Its force on the platform is not along its chord: a folder and a line, and the robot moves as it must."""
    folder, add, run = tree
    (folder / "cdpr" / "cables" / "heavy").mkdir()
    (folder / "cdpr" / "cables" / "heavy" / "kernels.py").write_text(HEAVY_KERNELS)
    add(
        "cdpr/cables/heavy/__init__.py",
        HEAVY,
        "cdpr/cables/__init__.py",
        heavy=("from cdpr.cables.heavy import HEAVY\n", "from cdpr.cables.exit import Exit\n"),
        model=('    "heavy": Chain(DRUM, HEAVY),\n', "MODELS = {\n"),
    )
    winch, own = ROOT / "scenarios" / "winch.yaml", {"robot.cable.damping": 0.0, "robot.winch.coulomb_friction": 0.0}
    own |= {f"robot.cables[{i}].linear_density": 1.5 + 0.2 * i for i in range(8)}  # kg/m
    at = {"initial.velocity": [0.1, -0.2, 0.3], "initial.angular_velocity": [0.3, 0.2, -0.4]}
    given = [(300.0 + 20.0 * np.arange(8)).tolist(), [50.0, -30.0, 20.0, 15.0, -10.0, 25.0]]
    changes = json.dumps({"robot.cable.model": "heavy", **own, **at})
    done = subprocess.run(
        [sys.executable, "-c", HEAVY_MOVES, winch, changes, json.dumps(given), str(HEAVY_TIME)],
        env={**os.environ, "PYTHONPATH": str(folder), "NUMBA_DISABLE_JIT": "1"},
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    scenario = load_scenario(winch, overrides={**own, **at})
    start = scenario.initial.state()
    truth = heavy_oracle(scenario.robot, start, scenario.gravity, *map(np.array, given))
    coarse, fine, euler, finer_euler = (np.abs(np.array(row) - truth) for row in json.loads(done.stdout))
    for part in (slice(7), slice(7, 13), slice(13, 21), slice(21, 22)):  # pose, twist, tensions, work
        assert 12.0 < coarse[part].max() / fine[part].max() < 30.0  # order four
        assert 1.8 < euler[part].max() / finer_euler[part].max() < 2.4  # order one
    assert fine[:13].max() < 1e-8
    assert fine[13:].max() < 1e-3 < 1.0 < np.ptp(truth[13:21])

    heavy = [f"--set={key}={value}" for key, value in own.items()] + ["--set=robot.cable.model=heavy"]
    short = ("--set", "simulation.duration=0.02", "--no-report", "--json", "--out", folder / "heavy")
    done = run("run", winch, *heavy, *short, NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    refused = run("fmu", "export", winch, "-o", folder / "heavy.fmu", "--with-winch", *heavy, NUMBA_DISABLE_JIT="1")
    assert refused.returncode == 2
    assert "the span of model heavy has no C" in refused.stderr


def test_a_solver_a_controller_and_a_backend(tree):
    """A file each, and a row in the list of its package. Solver and backend are those that strangers bring, too."""
    folder, add, run = tree
    strangers = ROOT / "tests" / "plugins"
    solver = (strangers / "weighted_solver" / "cdpr_weighted" / "solver.py").read_text()
    backend = (strangers / "drag_backend" / "cdpr_drag" / "backend.py").read_text()
    for role, name, made, text, place in (
        ("solver", "weighted", "Weighted", solver.replace("self.options.power", "1.0"), "null space and active sets"),
        ("controller", "spring", "Spring", SPRING_LAW, "Return the built-in controllers"),
        ("backend", "drag", "DragBackend", backend.replace("self.options.area", "0.5"), "Return the built-in backends"),
    ):
        package = f"cdpr_{role}s"
        row = f'        PluginInfo(name="{name}", factory="{package}.{name}:{made}", summary="added"),\n'
        add(f"{package}/{name}.py", text, f"{package}/__init__.py", listed=(row, f'{place}."""\n    return [\n'))
    chosen = ("--solver", "weighted", "--controller", "spring", "--backend", "drag")
    short = ("--set", "simulation.duration=0.02", "--no-report", "--out", folder / "plugins")
    done = run("run", ROOT / "scenarios" / "caroca.yaml", *chosen, *short, NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    told = load_run(folder / "plugins")
    assert (told.header.solver, told.header.controller, told.header.backend) == ("weighted", "spring", "drag")
    asked = 5000.0 * (told.desired_position - told.position)[:, :2]
    np.testing.assert_allclose(told.wrench[:, :2], asked, rtol=0.0, atol=1e-9)


def test_a_command(tree):
    _, add, run = tree
    line = '    "cables": "Name the cables of a robot.",\n'
    add("cdpr/cli/cables.py", COMMAND, "cdpr/cli/__init__.py", listed=(line, "COMMANDS = {\n"))
    assert "Name the cables of a robot." in run("--help").stdout
    done = run("cables", ROOT / "scenarios" / "robots" / "planar_point_mass.yaml")
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split(", ")) == 3
