"""Every wrong value is refused, with its line, its key, its unit, and nothing else beside it."""

from __future__ import annotations

import re

import pytest
from scenario_cases import (
    BASE,
    HEAD,
    PLUGINS,
    QUINTIC,
    ROBOT,
    TAIL,
    TEXTS,
    changed,
    line_of,
    load,
    problem,
    problems,
)
from spread import spread

from cdpr.base.errors import ScenarioError
from cdpr.base.problems import dotted
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.scenario import load_robot, load_scenario

BAD = [
    ".nan",
    ".inf",
    "-.inf",
    "1e309",
    '"x"',
    "x",
    "true",
    "null",
    "[]",
    "{}",
    "1:30",
    "010",
    "'1'",
    "1" * 400,
]


def numbers(text):
    """Path and place of the numbers of a text: of a list, the last one only."""
    document = parse(text, "a.yaml", Problems())
    found = {}
    for path, mark in document.values.items():
        value = document.get(path)
        if isinstance(value, int | float) and not isinstance(value, bool):
            key = path[:-1] if isinstance(path[-1], int) else path
            found[key] = (path, mark)
    return found.values()


def replaced(text, mark, value):
    """Put `value` in place of the scalar at `mark`."""
    lines = text.split("\n")
    line = lines[mark.line - 1]
    end = re.compile(r"[^,\]}\s]+").match(line, mark.column - 1).end()
    lines[mark.line - 1] = line[: mark.column - 1] + value + line[end:]
    return "\n".join(lines)


CASES = {dotted(path): (text, path, mark) for text in TEXTS.values() for path, mark in numbers(text)}


def test_the_cases_cover_the_schema():
    assert len(CASES) > 60


@spread("case, third", list(CASES), range(3))
@pytest.mark.usual("*-0")
def test_a_wrong_value_for_a_number(case, third):
    text, path, mark = CASES[case]
    for value in BAD[third::3]:
        if value in (".inf", "1e309") and "max" in path and "tension" in path:
            continue  # no upper limit
        line = problem(replaced(text, mark, value))
        assert line.startswith(f"{mark}: {dotted(path)}: "), value


@pytest.mark.parametrize(
    ("old", "new", "key", "what"),
    [
        ("mass: 150", "mass: -5", "robot.platform.mass", "must be greater than 0 (kg), got -5"),
        ("mass: 150", "mass: 1e13", "robot.platform.mass", "must lie between -1e+12 and 1e+12"),
        ("mass: 150", "mass: x", "robot.platform.mass", "expected a number (kg), got 'x'"),
        ("mass: 150", "mass: .nan", "robot.platform.mass", "expected a finite number (kg), got nan"),
        ("mass: 150", "mass: no", "robot.platform.mass", "expected a number (kg), got 'no'"),
        ("mass: 150", "mass: [1]", "robot.platform.mass", "expected a number (kg), got a list of 1"),
        ("duration: 4.0", "duration: 0", "simulation.duration", "must be greater than 0 (s), got 0"),
        ("seed: 7", "seed: 7.5", "simulation.seed", "expected a whole number, got 7.5"),
        ("seed: 7", "seed: -1", "simulation.seed", "must be at least 0, got -1"),
        ("seed: 7", f"seed: {2**63}", "simulation.seed", "must be at most"),
        ("unilateral: true", "unilateral: yes", "robot.unilateral", "expected true or false, got 'yes'"),
        ("unilateral: true", "unilateral: 1", "robot.unilateral", "expected true or false, got 1"),
        ("name: every-key", "name: 5", "name", "expected a text, got 5"),
        ("name: every-key", "name: a b", "name", "a name of at most 64 letters"),
        ("name: every-key", "name: ../x", "name", "a name of at most 64 letters"),
        ("[0, 0, -9.81]", "[0, -9.81]", "world.gravity", "expected 3 numbers (m/s^2), got 2"),
        ("[0, 0, -9.81]", "[0, 0, 0, -9.81]", "world.gravity", "expected 3 numbers (m/s^2), got 4"),
        ("[0, 0, -9.81]", "-9.81", "world.gravity", "expected 3 numbers (m/s^2), got -9.81"),
        ("[0, 0, -9.81]", "", "world.gravity", "expected 3 numbers (m/s^2), got null"),
        ("{gravity: [0, 0, -9.81]}", "5", "world", "expected a mapping (gravity, obstacles, contact), got 5"),
        (
            "infeasible: stop",
            "infeasible: stopp",
            "solver.infeasible",
            "expected one of best_effort, hold_tension, stop, got 'stopp'; did",
        ),
        (
            "infeasible: stop",
            "infeasible: 5",
            "solver.infeasible",
            "expected one of best_effort, hold_tension, stop",
        ),
        (
            "type: quintic",
            "type: quintc",
            "trajectory.type",
            "unknown type 'quintc': did you mean 'quintic'? allowed: hold,",
        ),
        ("type: quintic", "type: 5", "trajectory.type", "unknown type 5: allowed: hold, quintic, waypoints"),
        (
            "inertia: [6.5, 20.0, 22.5, 0.1, 0.2, 0.3]",
            "inertia: [1, 1, 1]",
            "robot.platform.inertia",
            "expected 6 numbers (kg m^2): ixx, iyy, izz, ixy, ixz, iyz about the centre of mass",
        ),
        ("kp: 100", "kp: [1, 2]", "controller.kp", "expected 6 numbers (1/s^2), got 2"),
        ("kp: 100", "kp: {}", "controller.kp", "expected a number or 6 numbers (1/s^2), got a mapping"),
        (
            "integrator: euler",
            "integrator: rk5",
            "backend_options.tuned.integrator",
            "expected one of euler, rk4, got 'rk5'",
        ),
        (
            "tolerance: 1e-6",
            "tolerance: 0",
            "backend_options.tuned.tolerance",
            "must be greater than 0, got 0",
        ),
        ("name: left", "name: cable_2", "robot.cables[1].name", "'cable_2' is the name of cables[0] too"),
        ("diameter: 0.006", "diameter: null", "robot.cables[0].diameter", "no value is given"),
        (
            "max: [10000, 9000, 8000]",
            "max: x",
            "robot.tension.max",
            "expected a number or a list of numbers (N), got 'x'",
        ),
        ("order: XYZ", "order: XYx", "trajectory.to.orientation.euler.order", "expected three axes"),
        ("order: XYZ", "order: xxy", "trajectory.to.orientation.euler.order", "expected three axes"),
        ("order: XYZ", "order: XY", "trajectory.to.orientation.euler.order", "expected three axes"),
    ],
)
def test_messages(old, new, key, what):
    text = changed(BASE, old, new)
    line = problem(text)
    assert f": {key}: " in line
    assert what in line


def test_the_place_is_that_of_the_value():
    text = changed(BASE, "mass: 150", "mass: -5")
    line = line_of(text, "mass: -5")
    assert problem(text) == f"a.yaml:{line}:11: robot.platform.mass: must be greater than 0 (kg), got -5"


@pytest.mark.parametrize(
    ("text", "key", "what", "at"),
    [
        (
            BASE.replace("  duration: 3.0\n", ""),
            "trajectory.duration",
            "required but not given: duration of",
            "trajectory:",
        ),
        (
            BASE.replace("    mass: 150\n", ""),
            "robot.platform.mass",
            "not given: mass of the platform (kg)",
            "platform:",
        ),
        (
            BASE.replace("platform: [-0.6, -0.3, 0.2]", ""),
            "robot.cables[1].platform",
            "required",
            "- {frame: [3.5, -2",
        ),
        (BASE.replace("duration: 4.0, ", ""), "simulation.duration", "required", "simulation:"),
        (
            BASE.replace("type: quintic\n", "start: 0\n").replace("  start: 0.5\n", ""),
            "trajectory.type",
            "allowed: hold",
            "trajectory:",
        ),
        (
            BASE.replace("rpy: [0, 0, 0.3]", ""),
            "trajectory.from.orientation",
            "exactly one of rpy, rpy_deg, quaternion, euler",
            "{}",
        ),
    ],
)
def test_missing_keys_are_placed_at_the_section(text, key, what, at):
    line = problem(text)
    assert f": {key}: " in line
    assert what in line
    assert line.startswith(f"a.yaml:{line_of(text, at)}:")


def test_missing_sections_are_all_named():
    found = problems("name: nothing\n")
    assert [line.split(": ")[1] for line in found] == ["initial", "robot", "simulation"]
    assert all(line.startswith("a.yaml:1:1: ") for line in found)


def test_the_problems_of_all_phases_come_at_once_in_the_order_of_the_file():
    text = BASE
    for old, new in [
        ("seed: 7", "sead: 7"),  # schema
        ("duration: 4.0", "duration: 4.0001"),  # steps
        ("mass: 150", "mass: 0\n    mass: 0"),  # YAML and schema
        ("platform: [-0.6, -0.3, 0.2]", "platform: [-0.6, -0.3]"),  # schema, in a list
        ("min: 40", "min: 40000"),  # physics
        ("acceleration: [0, 0, 0.5]", "acceleration: [0, 0, x]"),
        ("type: simple", "type: simpel"),  # plugins
        ("kp: 100", "kp: x"),  # a plugin's options
    ]:
        text = changed(text, old, new)
    found = problems(text)
    keys = [line.split(": ")[1] for line in found]
    assert keys == [
        "simulation.duration",
        "simulation.sead",
        "robot.platform.mass",
        "robot.platform.mass",
        "robot.cables[0].tension.min",
        "robot.cables[1].platform",
        "trajectory.from.acceleration[2]",
        "controller.kp",
        "solver.type",
    ]
    lines = [int(line.split(":")[1]) for line in found]
    assert lines == sorted(lines)


def test_wrong_sections_do_not_hide_the_checks_of_the_others():
    """The simulation is wrong, so its steps are not judged; the start is right and is."""
    text = changed(BASE, "seed: 7", "seed: x")
    text = changed(text, "position: [0.0, 0.1, 1.2]", "position: [-4.1, -1.7, 3.7]")  # A_1 - B_1
    found = problems(text)
    assert len(found) == 2
    assert "simulation.seed" in found[0]
    assert "initial.position: cable 'left' has no length here" in found[1]


def test_a_file_of_garbage_prints_no_more_than_anyone_reads():
    found = problems(BASE + "".join(f"junk_{i}: 1\n" for i in range(120)))
    assert len(found) == 101
    assert found[-1] == "and 20 more problems"


@pytest.mark.parametrize(
    ("quaternion", "what"),
    [
        (
            "[1, 1, 0, 0]",
            "expected a quaternion of norm 1, got norm 1.41421; normalised, it is [0.707107, 0.707107, 0, 0]",
        ),
        ("[0.998, 0, 0, 0]", "normalised, it is [1, 0, 0, 0]"),
        ("[0, 0, 0, 0]", "the quaternion is zero"),
        ("[1, 0, 0]", "expected 4 numbers, got 3"),
    ],
)
def test_quaternions_that_are_none(quaternion, what):
    assert what in problem(changed(BASE, "{quaternion: [1, 0, 0, 0]}", f"{{quaternion: {quaternion}}}"))


def test_two_forms_of_an_orientation_contradict():
    line = problem(changed(BASE, "{rpy: [0, 0, 0.3]}", "{rpy: [0, 0, 0.3], quaternion: [1, 0, 0, 0]}"))
    assert "expected exactly one of rpy, rpy_deg, quaternion, euler, got rpy and quaternion" in line


def test_the_problems_of_a_robot_file_name_that_file(tmp_path):
    (tmp_path / "parts").mkdir()
    bad = changed(changed(ROBOT, "mass: 150", "mass: -1"), "name: left", "nam: left")
    (tmp_path / "parts" / "robot.yaml").write_text(bad)
    scenario = tmp_path / "a.yaml"
    scenario.write_text(changed(HEAD, "seed: 7", "seed: x") + "robot: parts/robot.yaml\n" + QUINTIC + TAIL)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(scenario, plugins=PLUGINS)
    own, mass, name = caught.value.problems
    assert own.startswith(f"{scenario}:3:")
    assert "simulation.seed" in own
    robot = tmp_path / "parts" / "robot.yaml"
    assert mass == f"{robot}:5:9: robot.platform.mass: must be greater than 0 (kg), got -1"
    assert name.startswith(f"{robot}:{line_of(bad, 'nam: left')}:3: robot.cables[0].nam: unknown key 'nam'")


def test_missing_keys_are_reported_in_the_robot_file(tmp_path):
    (tmp_path / "robot.yaml").write_text(changed(ROBOT, "tension: {min: 50, max: [10000, 9000, 8000]}\n", ""))
    text = HEAD + "robot: robot.yaml\n" + QUINTIC + TAIL
    with pytest.raises(ScenarioError, match=r"robot.yaml:1:1: robot.tension: required but not given") as caught:
        load_scenario(tmp_path / "a.yaml", text=text, plugins=PLUGINS)
    assert len(caught.value.problems) == 1


def test_problems_of_a_robot_on_its_own(tmp_path):
    with pytest.raises(ScenarioError) as caught:
        load_robot("r.yaml", text=changed(changed(ROBOT, "mass: 150", "mass: x"), "min: 40", "min: -1"))
    assert [line.split(": ")[1] for line in caught.value.problems] == [
        "platform.mass",
        "cables[0].tension.min",
    ]


def test_input_is_quoted_briefly():
    assert len(problem(changed(BASE, "mass: 150", "mass: " + "x" * 50_000))) < 200
    found = problems(changed(BASE, "mass:", "m" * 900 + ":"))
    assert all(len(line) < 300 for line in found)


def test_foreign_characters_stay_within_their_line():
    line = problem(changed(BASE, "seed: 7", 'seed: 7, "a\\n\\e[31m": 1'))
    assert line.isprintable()
    assert "unknown key 'a\\n\\x1b[31m'" in line
    assert problem(changed(BASE, "name: every-key", 'name: "a\\nb"')).isprintable()
    with pytest.raises(ScenarioError, match=r"there is no file 'a\\n\\x1b\[31m.yaml'"):
        load(HEAD + 'robot: "a\\n\\e[31m.yaml"\n' + QUINTIC + TAIL)


def test_no_null_anywhere_but_where_a_plugin_takes_it():
    assert "no value is given" in problem(changed(BASE, "length: {min: 0.5, max: 12}", "length:"))
    assert "a mapping" in problem(changed(BASE, "world: {gravity: [0, 0, -9.81]}", "world:"))
    assert load(changed(BASE, "kp: 100", "limit: null")).controller_options.limit is None
