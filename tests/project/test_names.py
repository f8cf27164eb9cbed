"""Names of frequent additions occur only in their own file and one table."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib.util import find_spec
from typing import NamedTuple

import pytest
from conftest import ROOT
from imports import PACKAGES, modules

import cdpr.cables
import cdpr_backends
import cdpr_controllers
import cdpr_solvers
from cdpr.cables.chain import Part
from cdpr.scenario.events import EVENTS
from cdpr.scenario.motions import MOTIONS
from cdpr.sensing import SENSORS

BACKENDS = cdpr_backends.cdpr_backends()
PLUGINS = [*BACKENDS, *cdpr_solvers.cdpr_solvers(), *cdpr_controllers.cdpr_controllers()]
TABLES = {
    "cdpr_backends",
    "cdpr_controllers",
    "cdpr_solvers",
    "cdpr.cables",
    "cdpr.scenario.events",
    "cdpr.scenario.motions",
    "cdpr.base.defaults",
}


class Other(NamedTuple):
    """A string that is such a name and means something else, in the module or package `where`, or EVERYWHERE."""

    name: str
    where: str
    meaning: str


EVERYWHERE = ""

OTHERS = [
    Other("wrench", EVERYWHERE, "the quantity: a column, a signal of an FMU, an argument, what a controller puts out"),
    Other("cable_length", EVERYWHERE, "the quantity: a signal of an FMU"),
    Other("best_effort", EVERYWHERE, "the policy for a wrench that is infeasible, a key of the section `solver`"),
    Other("exact", EVERYWHERE, "the property that a solver declares; in an FMU's description a kind of start value"),
    Other("limits", "cdpr.simulation.live", "a method, and its argument"),
    Other("limits", "cdpr.ui.report.text.distributions", "the heading of a row"),
    Other("limits", "cdpr.scenario.events.target", "its key, as that of the motion `jerk_limited`"),
    Other("limits", "cdpr.scenario.motions.gcode", "its key, as that of the motion `jerk_limited`"),
    Other("limits", "cdpr.scenario.schema", "a key of scenarios"),
    Other("target", "cdpr.simulation.live", "a method"),
    Other("target", "cdpr_controllers.estimators.length_fit", "measured lengths"),
    Other("direct", "cdpr.simulation.estimation", "a property of estimators"),
    Other("direct", "cdpr_controllers.estimators", "likewise"),
    Other("set", "cdpr.simulation.live", "a method"),
    Other("payload", "cdpr.ui.live.received_messages", "a request, named as the method of live simulations"),
    Other("elastic", "cdpr_controllers.estimators.ekf_prediction", "a field of its kernel: if a cable stretches"),
    Other("set", "cdpr.ui.gui.editor.fields", "a kind of field: several of a few"),
    Other("limits", "cdpr.ui.gui", "limits of the cables that the window shows, requested by the name of the method"),
    Other("csv", "cdpr.log.export", "the ending of a file"),
    Other("csv", "cdpr.ui.cli.export", "the ending of a file"),
    Other("hold", "cdpr.trajectory", "a function"),
    Other("hold", "cdpr.simulation.linearised_scenario", "the motion at rest, about which a loop is linear"),
    Other("pulley", "cdpr.formats.read.cdpyr", "a key of other files"),
    Other("ideal", "cdpr.ui.report.text.description", "a drive without inertia"),
    Other("circle", "cdpr.trajectory", "a function"),
    Other("fmu", "cdpr.ui.cli", "a command"),
    Other("fmu", "cdpr.fmu.export.cache", "a folder of the user's cache"),
    Other("fmu", "cdpr.fmu.read.options", "the constant by which scenarios, logs and tables call what is an FMU"),
    Other("remote", "cdpr.link.options", "the constant by which scenarios and logs call what is in another process"),
    Other("daqp", "cdpr.analysis.bench.benchmark", "the library, which the oracle asks, too"),
    Other("daqp", "cdpr_solvers.options", "the library, as qpsolvers calls it"),
    Other("daqp", "cdpr_solvers.qpsolvers", "the library, as qpsolvers calls it"),
    Other("reference", "cdpr_solvers.qp", "an option: the tensions to keep close to"),
    Other("static", "cdpr.ui.cli.workspace", "a kind of workspace"),
    Other("static", "cdpr.analysis.workspace.kinds", "likewise"),
    Other("target", "cdpr.ui.live.received_messages", "what is asked for of a live simulation"),
    Other("wrench", "cdpr.ui.live.received_messages", "likewise"),
    Other("set", "cdpr.ui.live.sender", "likewise"),
    Other("payload", "cdpr.ui.cli.workspace", "a kind of workspace"),
    Other("payload", "cdpr.analysis.workspace", "likewise"),
    Other("static", "cdpr.formats.write.sdf", "an element of SDF"),
    Other("mujoco", "cdpr.formats.write.mjcf", "the root element of MJCF"),
    Other("mujoco", "cdpr.formats.read.mjcf", "likewise"),
    Other("mujoco", "cdpr.formats.read.mjcf_text", "likewise"),
    Other("mujoco", "cdpr.formats.read.mjcf_used", "likewise"),
    Other("contact", "cdpr.scenario.run_checks", "a key of the section `world`"),
    Other("contact", "cdpr.scenario.schema", "likewise"),
    Other("contact", "cdpr.formats.read.mjcf_text", "an element of MJCF"),
    Other("contact", "cdpr.formats.read.mjcf_used", "an attribute of MJCF"),
    Other("lp", "cdpr.ui.cli.workspace_compare", "an oracle: linear programs"),
    Other("point", "cdpr.formats.read.caspr_splines", "an element of CASPR"),
    Other("point", "cdpr.analysis.workspace", "a function"),
    Other("point", "cdpr.analysis.workspace.required", "the name of its argument"),
    Other("limits", "cdpr.analysis.distribution.batch", "the name of an operation's argument"),
    Other("limits", "cdpr.mechanics.reach", "the name of an operation's argument"),
    Other("limits", "cdpr.tension", "the name of an operation's argument"),
    Other("point", "cdpr.tension.active_set", "the name of an operation's argument"),
    Other("limits", "cdpr_controllers.cable_length", "the name of an operation's argument"),
    Other("mujoco", "cdpr.sensing", "the renderer of images, and its library"),
    Other("bullet", "cdpr.sensing", "likewise"),
    Other("pybullet", "cdpr.sensing", "likewise"),
    Other("point", "cdpr.sensing", "a field of a ROS message, and an argument of kernels"),
    Other("ideal", "cdpr.model.robot", "a function"),
    Other("ideal", "cdpr.model.cable", "the constant for a robot that names no cable model, below the table"),
    Other("ideal", "cdpr.analysis.compare.engines", "the constant for a backend that declares no cables of its own"),
]

# Attributes that hold such names and nothing else: no string is compared with them, whatever else it may mean.
HOLDERS = {"type", "backend", "cable_model"}


class Found(NamedTuple):
    """A name as a string."""

    name: str
    line: int
    compared: bool


def homes() -> dict[str, set[str]]:
    """Return the modules, or packages with all their modules, that may contain each name."""
    found: dict[str, set[str]] = {name: set() for name in cdpr.cables.MODELS}
    for row in PLUGINS:
        libraries = row.requires if row in BACKENDS else ()  # engines are also known by these
        for name in (row.name, *row.aliases, *libraries):
            found.setdefault(name, set()).add(row.factory.partition(":")[0])
    for kinds in (EVENTS, MOTIONS, cdpr.cables.EXITS):
        for name, kind in kinds.items():
            found.setdefault(name, set()).add(kind.__module__)
    for name, part in vars(cdpr.cables).items():
        if isinstance(part, Part):
            # the header is beside the module, or in the package, of its name
            words = (part.header or f"cdpr/cables/{name.lower()}").removesuffix(".hpp").split("/")
            home = ".".join(words[:-1] if words[-1] == words[-2] else words)
            found.setdefault(name.lower(), set()).add(home)
    return found


def strings(text: str, names: set[str]) -> Iterator[Found]:
    """Yield names that are a whole string in a Python file; docstrings and messages are longer."""
    nodes = list(ast.walk(ast.parse(text)))
    compared = {
        id(inner)
        for node in nodes
        if isinstance(node, ast.Compare)
        and any(isinstance(side, ast.Attribute) and side.attr in HOLDERS for side in (node.left, *node.comparators))
        for inner in ast.walk(node)
    }
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in names:
            yield Found(node.value, node.lineno, id(node) in compared)


def within(module: str, package: str) -> bool:
    return package in (EVERYWHERE, module) or module.startswith(f"{package}.")


@pytest.fixture(scope="module")
def found():
    """Return all names in strings outside their own files and the tables, by module."""
    known = homes()
    return [
        (module, one)
        for module, file in modules(ROOT, PACKAGES).items()
        for one in strings(file.read_text(), set(known))
        if module not in TABLES and not any(within(module, home) for home in known[one.name])
    ]


def excepted(module: str, one: Found) -> bool:
    return not one.compared and any(one.name == other.name and within(module, other.where) for other in OTHERS)


@pytest.mark.slow
def test_names_occur_only_in_their_files_and_tables(found):
    """Query a declared property instead; a default belongs in `cdpr.base.defaults`."""
    wrong = [f"{module}, line {one.line}: '{one.name}'" for module, one in found if not excepted(module, one)]
    assert wrong == []


def sensors_named(text: str) -> Iterator[int]:
    """Yield the lines of a Python file that compare the type of something with the name of a sensor."""

    def is_type(node: ast.AST) -> bool:
        if isinstance(node, ast.Call):
            return isinstance(node.func, ast.Attribute) and node.func.attr == "kind"
        if isinstance(node, ast.Subscript):
            return isinstance(node.slice, ast.Constant) and node.slice.value == "type"
        if isinstance(node, ast.Tuple):
            return any(map(is_type, node.elts))
        return isinstance(node, ast.Attribute) and node.attr == "type"

    mentioned = any(f'"{name}"' in text or f"'{name}'" in text for name in SENSORS.homes)
    for node in ast.walk(ast.parse(text)) if mentioned else ():  # few files, to save time
        sides: list[ast.AST] = []
        if isinstance(node, ast.Compare) and any(map(is_type, (node.left, *node.comparators))):
            sides = [node.left, *node.comparators]
        elif isinstance(node, ast.Match) and is_type(node.subject):
            sides = [case.pattern for case in node.cases]
        constants = (each for side in sides for each in ast.walk(side) if isinstance(each, ast.Constant))
        if any(each.value in SENSORS.homes for each in constants if isinstance(each.value, str)):
            yield node.lineno


def test_types_of_sensors_are_not_compared():
    """A sensor declares its drawing, message, measurement model and recorded truth: `cdpr.sensing.Sensor`."""
    found = {module: list(sensors_named(file.read_text())) for module, file in modules(ROOT, PACKAGES).items()}
    assert {module: lines for module, lines in found.items() if lines} == {}


@pytest.mark.parametrize(
    "text",
    [
        'sensor.type == "imu"',
        'sensor["type"] in ("range", "scan")',
        'if sensor.kind() != "camera": pass',
        'match sensor["type"], key:\n    case ("markers", "pixel"): pass',
    ],
)
def test_comparisons_with_types_of_sensors_are_found(text):
    assert list(sensors_named(text)) == [1]
    assert list(sensors_named(text.replace("sensor", "winch").replace("type", "name").replace("kind", "title"))) == []


def test_all_kinds_are_known():
    """One of each, so that the test above looks for them."""
    known = homes()
    assert known["mujoco"] == {"cdpr_backends.mujoco"}
    assert known["pybullet"] == {"cdpr_backends.bullet"}
    assert known["fmu"] == {"cdpr_backends.fmu", "cdpr_controllers.fmu"}
    assert known["qp"] == {"cdpr_solvers.qp"}
    assert known["2-norm"] == {"cdpr_solvers.qp"}
    assert known["computed_torque"] == {"cdpr_controllers.computed_torque"}
    assert known["rigid"] == set()
    assert known["elastic"] == {"cdpr.cables.elastic"}
    assert known["drum"] == {"cdpr.cables.drum"}
    assert known["pulley"] == {"cdpr.cables.pulley"}
    assert known["quintic"] == {"cdpr.scenario.motions.quintic"}
    assert known["cable_break"] == {"cdpr.scenario.events.faults"}
    for home in set().union(*known.values()) | TABLES:
        assert find_spec(home) is not None, home


@pytest.mark.slow
def test_exceptions_are_still_there(found):
    """Remove a name from the list after correcting it."""
    gone = [
        (other.name, other.where)
        for other in OTHERS
        if not any(one.name == other.name and within(module, other.where) for module, one in found)
    ]
    assert gone == []


@pytest.mark.parametrize(
    ("line", "compared"),
    [
        ('return scenario.backend == "wrench"', True),
        ('ok = event.type in ("other", "wrench")', True),
        ('kinds = {"wrench": 1}', False),
        ('kind: Literal["wrench"] = None', False),
    ],
)
def test_search_finds_known_words(line, compared):
    text = f'"""Of a wrench."""\n\n\ndef f(scenario, event):\n    """wrench"""\n    print("no wrench")\n    {line}\n'
    assert [one for one in strings(text, {"wrench"}) if one.line > 5] == [Found("wrench", 7, compared)]
