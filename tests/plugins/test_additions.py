"""What is added most often takes one new file and one line in a table: done here to a copy of the program."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from mcap.reader import make_reader

from cdpr.log.reader import load_run

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

from cdpr.cables.chain import Span

SPRING = Span(needs=("axial_stiffness",), kernels="cdpr.cables.spring.kernels", numbers=lambda c: [c.axial_stiffness])
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
    assert "one of sprung, ideal, rigid, elastic expected" in unknown.stderr
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
