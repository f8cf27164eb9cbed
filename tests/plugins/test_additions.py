"""Frequent additions need one new file and one line in a table: tested on a copy of the program.

Parts of cables: `test_added_parts.py`.
"""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from additions import copy_of_program
from conftest import ROOT
from mcap.reader import make_reader

from cdpr.base.errors import CdprError
from cdpr.log.reader import load_run

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
from typing import ClassVar, Literal

from pydantic import Field

from cdpr.log.event import Event
from cdpr.scenario.events.event import ScenarioEvent, WrenchProfile, first_sample
from cdpr.base.fields import Positive, unit
from cdpr.base.needs import Needs, of_event


class Gust(ScenarioEvent):
    """Wind along x, from its time on."""

    needs: ClassVar[Needs] = of_event()
    type: Literal["gust"] = Field(description="wind along x")
    speed: Positive = Field(description="speed of the air", json_schema_extra=unit("m/s"))

    def check_steps(self, step: float) -> Iterator[tuple[str, str]]:
        if self.speed > 60.0:
            yield "speed", f"must be at most 60 (m/s), got {self.speed:g}"

    def wrench_profile(self, step: float) -> WrenchProfile:
        force = 0.5 * 1.2 * self.speed**2
        amplitude = (force, 0.0, 0.0, 0.0, 0.0, 0.0)
        return WrenchProfile(first_sample(self.time, step), math.inf, 0.0, 0.5 * math.pi, amplitude)

    def event_log(self, step: float, samples: int, tension: Mapping[str, float]) -> Iterator[Event]:
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

from typing import ClassVar, Literal, Self

from pydantic import Field

from cdpr import trajectory
from cdpr.base.fields import Positive, unit
from cdpr.base.needs import Needs, of_motion
from cdpr.scenario.initial import Initial
from cdpr.scenario.motions.guide import Guide, Posed
from cdpr.scenario.motions.motion import Motion, Pose, Report, pose, posed
from cdpr.base.problems import Path


class Rise(Motion):
    """Straight up, and then held."""

    needs: ClassVar[Needs] = of_motion()
    type: Literal["rise"] = Field(description="straight up")
    height: Positive = Field(description="how far", json_schema_extra=unit("m"))
    at: Pose = Field(Pose(), description="where it begins")

    def poses(self) -> list[tuple[Path, Posed]]:
        return [(("at",), self.at)]

    def stay(self, guide: Guide, report: Report) -> None:
        if guide.held[2]:
            report.add_problem(("height",), f"{guide.free}, so it cannot rise")

    def complete(self, initial: Initial) -> Self:
        return self.model_copy(update={"at": posed(self.at, initial)})

    def make(self) -> trajectory.Trajectory:
        position, attitude = pose(self.at)
        top = trajectory.Knot(1.0, position + [0, 0, self.height], attitude)
        return trajectory.through([trajectory.Knot(0.0, position, attitude), top])
'''


COLUMN = """    Column("speed", 1, "m/s", "Speed of the origin"),
"""

MEASURED = """
        speed, velocity = self.view("speed"), self.view("velocity")

        def measure() -> None:
            speed[0] = np.sqrt(velocity @ velocity)

        operations.append(Operation("geometry", measure))
"""


REFLECTOR = '''\
"""Reflector that a laser tracker follows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from cdpr.base.column import WORLD
from cdpr.base.needs import Needs, of_sensor
from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.scene.sensors import SensorDrawing
from cdpr.sensing.errors import Errors
from cdpr.sensing.message import Message, quantity
from cdpr.sensing.records import Records
from cdpr.sensing.sensor import Quantity, Sensor, Sources, Truth
from cdpr.tension.operations import Operation


class Reflector(Sensor):
    """Position of a reflector above the platform's origin."""

    needs: ClassVar[Needs] = of_sensor()
    quantities: ClassVar[tuple[Quantity, ...]] = (Quantity("place", 3, "m", "Position of the reflector", WORLD),)
    measurement: ClassVar[str] = "receiver"

    type: Literal["reflector"] = Field("reflector", description="laser tracker")
    height: float = Field(0.0, description="height above the origin")
    place: Errors = Field(Errors(), description="errors of the position")

    @property
    def arm(self) -> Array:
        return np.array([0.0, 0.0, self.height])

    def truth(self, sources: Sources) -> Truth:
        values = np.zeros(3)
        write = bind("point_on_platform", state=sources.state, point=self.arm, position=values)
        return Truth(values, (Operation("sensors", write, timed=True),), (values,))

    def measurement_numbers(self) -> list[float]:
        return self.arm.tolist()

    def drawing(self, extent: float) -> SensorDrawing:
        return SensorDrawing(self.title, True, self.arm)

    def message(self, cables: Sequence[str]) -> Message:
        return Message("geometry_msgs/PointStamped", {"point": quantity("place")}, {})

    def recorded_truth(self, key: str, records: Records) -> Array:
        return records.position + records.to_world(self.arm)
'''

TRACKED = """
robot: caroca.yaml
simulation: {duration: 0.02}
initial: {position: [0, 0, 1.2]}
sensors: [{type: reflector, height: 0.5}]
estimator: {type: ekf}
"""

SHOWN = """
from cdpr.log.reader import load_run
from cdpr.ui.report.plots.sensors import sensors

run = load_run("tracked")
assert abs(run["reflector_place"] - run.position - [0, 0, 0.5]).max() < 1e-12
assert (run["nis_size"] == 3.0).all()
(drawing,) = run.header.subject.sensors
_, error = sensors(run)
print(drawing.name, drawing.at[2], error.name, abs(error.curves[0].points.values).max())
"""

STILL = '''"""Estimate that remains at the start."""

from cdpr.plugins import Estimator, SnapshotOfArrays


class Still(SnapshotOfArrays, Estimator):
    """Initial state."""

    arrays = ()

    def connect(self, inputs):
        self._start = inputs.start

    def estimate(self, time, out):
        out[:] = self._start
'''

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
    """A copy of the program, and what changes and calls it."""
    return copy_of_program(tmp_path_factory.mktemp("tree"))


@pytest.mark.slow
def test_an_event(tree):
    folder, add, run = tree
    add(
        "cdpr/scenario/events/gust.py",
        EVENT,
        "cdpr/scenario/events/__init__.py",
        named=('\n        "gust": "cdpr.scenario.events.gust:Gust",', "EVENTS: Kinds[ScenarioEvent] = Kinds(\n    {"),
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


@pytest.mark.slow
def test_a_motion(tree):
    folder, add, run = tree
    add(
        "cdpr/scenario/motions/rise.py",
        MOTION,
        "cdpr/scenario/motions/__init__.py",
        named=('\n        "rise": "cdpr.scenario.motions.rise:Rise",', "MOTIONS: Kinds[Motion] = Kinds(\n    {"),
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


@pytest.mark.slow
def test_a_column(tree):
    """A line in the table, and the lines that compute it."""
    folder, add, run = tree
    add(None, "", "cdpr/base/columns.py", named=("\n" + COLUMN, "LATER: tuple[Column, ...] = ("))
    place = "            operations += self._exerting()\n"  # what completes a sample
    add(None, "", "cdpr/simulation/sample.py", written=(MEASURED, place))
    scenario = ROOT / "scenarios" / "caroca.yaml"
    short = ("--set", "simulation.duration=0.02", "--no-report")
    # The table is among the sources of kernels, as plugins import it: not to compile them anew for twenty steps.
    done = run("run", scenario, *short, "--out", folder / "speedy")
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
def test_a_solver_a_controller_and_a_backend(tree):
    """A file each, and a row in the list of its package. Solver and backend equal those of third parties."""
    folder, add, run = tree
    strangers = ROOT / "tests" / "plugins"
    solver = (strangers / "weighted_solver" / "cdpr_weighted" / "solver.py").read_text()
    backend = (strangers / "drag_backend" / "cdpr_drag" / "backend.py").read_text()
    for role, name, made, text, place in (
        ("solver", "weighted", "Weighted", solver.replace("self.options.power", "1.0"), "sets of the kernel library"),
        ("controller", "spring", "Spring", SPRING_LAW, "Return the built-in controllers"),
        ("backend", "drag", "DragBackend", backend.replace("self.options.area", "0.5"), "Return the built-in backends"),
    ):
        package = f"cdpr_{role}s"
        row = f'        PluginInfo(name="{name}", factory="{package}.{name}:{made}", summary="added"),\n'
        add(f"{package}/{name}.py", text, f"{package}/__init__.py", listed=(row, f'{place}."""\n    return [\n'))
    chosen = ("--solver", "weighted", "--controller", "spring", "--backend", "drag")
    short = ("--set", "simulation.duration=0.02", "--no-report", "--out", folder / "plugins")
    done = run("run", ROOT / "scenarios" / "caroca.yaml", *chosen, *short)
    assert done.returncode == 0, done.stderr
    told = load_run(folder / "plugins")
    assert (told.header.solver, told.header.controller, told.header.backend) == ("weighted", "spring", "drag")
    asked = 5000.0 * (told.desired_position - told.position)[:, :2]
    np.testing.assert_allclose(told.wrench[:, :2], asked, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_an_estimator(tree):
    """A file, and a row in the list of its package; the kit checks it, too."""
    folder, add, run = tree
    package = "cdpr_controllers.estimators"
    place = 'Return the built-in estimators."""\n    return [\n'
    row = (
        f'        PluginInfo(name="still", factory="{package}.still:Still", summary="added", '
        'properties={"sensors": ()}),\n'
    )
    add("cdpr_controllers/estimators/still.py", STILL, "cdpr_controllers/estimators/__init__.py", listed=(row, place))
    short = ("--set", "estimator.type=still", "--set", "simulation.duration=0.02", "--no-report")
    done = run("run", ROOT / "scenarios" / "caroca.yaml", *short, "--out", folder / "still")
    assert done.returncode == 0, done.stderr
    found = load_run(folder / "still")
    np.testing.assert_array_equal(found["estimated_position"], np.tile(found.position[0], (21, 1)))
    done = run("check", "estimator", "still")
    assert done.returncode == 7  # it forgets no wrong start
    assert "passed  reset_forgets" in done.stdout


@pytest.mark.slow
def test_a_sensor(tree):
    """A file, and a line in the table: the filter uses it; log and viewers show it."""
    folder, add, run = tree
    table = "cdpr/sensing/__init__.py"
    line = '        "reflector": "cdpr.sensing.reflector:Reflector",\n'
    add("cdpr/sensing/reflector.py", REFLECTOR, table, listed=(line, "Kinds[Sensor] = Kinds(\n    {\n"))
    scenario = folder / "tracked.yaml"
    shutil.copy(ROOT / "scenarios" / "robots" / "caroca.yaml", folder)
    scenario.write_text(TRACKED)
    done = run("run", scenario, "--out", folder / "tracked", "--no-report")
    assert done.returncode == 0, done.stderr
    with pytest.raises(CdprError, match="another version of cdpr: sensor 'reflector' of the type reflector: unknown"):
        load_run(folder / "tracked")
    with (folder / "tracked" / "log.mcap").open("rb") as file:
        channels = make_reader(file).get_summary().channels.values()
    assert "/cdpr/sensors/reflector" in {channel.topic for channel in channels}
    shown = run("-c", SHOWN)
    assert shown.stdout.split() == ["reflector", "0.5", "reflector_place_error", "0.0"], shown.stderr


@pytest.mark.slow
def test_a_command(tree):
    _, add, run = tree
    line = '    "cables": "Name the cables of a robot.",\n'
    add("cdpr/ui/cli/cables.py", COMMAND, "cdpr/ui/cli/__init__.py", listed=(line, "COMMANDS = {\n"))
    assert "Name the cables of a robot." in run("--help").stdout
    done = run("cables", ROOT / "scenarios" / "robots" / "planar_point_mass.yaml")
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split(", ")) == 3
