"""Values set from outside pass the same checks, and their problems name them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scenario_cases import BASE, HEAD, PLUGINS, QUINTIC, ROBOT, TAIL, changed, load, problem, problems

import cdpr
from cdpr.base.errors import CdprError, ScenarioError
from cdpr.scenario import load_robot, load_scenario
from cdpr.scenario.choices import CHOICES, typed
from cdpr.ui.gui.editor import Editor

pytestmark = pytest.mark.core


def value(scenario, path):
    for part in path.split("."):
        scenario = getattr(scenario, part)
    return scenario


@pytest.mark.parametrize(
    ("override", "path", "expected"),
    [
        ("simulation.duration=2", "simulation.duration", 2.0),
        ("simulation.duration = 2e-1 ", "simulation.duration", 0.2),
        ("world.gravity=[0, 0, -1.62]", "world.gravity", (0, 0, -1.62)),
        ("world.gravity[2]=-1.62", "world.gravity", (0, 0, -1.62)),
        ("world.gravity.2=-1.62", "world.gravity", (0, 0, -1.62)),
        ("name=other", "name", "other"),
        ("name='1e3'", "name", "1e3"),
        ("trajectory.to.position[0]=.5", "trajectory.to.position", (0.5, 0.5, 1.6)),
        ("trajectory={type: hold}", "trajectory.type", "hold"),
        ("controller.kp=[6,5,4,3,2,1]", "controller_options.kp", (6, 5, 4, 3, 2, 1)),
    ],
)
def test_values_are_set(override, path, expected):
    assert value(load(BASE, override), path) == expected


def test_the_robot_can_be_changed_by_either_way_of_writing_an_index():
    for key in ("robot.cables[1].frame[2]", "robot.cables.1.frame.2"):
        assert load(BASE, f"{key}=4.5").robot.cables[1].frame[2] == 4.5


def test_later_ones_win_and_build_on_earlier_ones():
    scenario = load(BASE, "trajectory={type: hold}", "trajectory.position=[1, 2, 3]", "trajectory.position[0]=4")
    assert scenario.trajectory.position == (4, 2, 3)


def test_a_section_that_is_not_there_is_made():
    text = changed(BASE, "world: {gravity: [0, 0, -9.81]}\n", "")
    assert load(text, "world.gravity=[0,0,-1]").world.gravity == (0, 0, -1)
    assert load(changed(BASE, "world: {gravity: [0, 0, -9.81]}", "world:"), "world.gravity=[0,0,-1]")
    assert load(BASE, "backend_options.plain={}", "backend_options.reference={}").name


@pytest.mark.parametrize(
    ("override", "rest"),
    [
        ("simulation.duration=abc", "simulation.duration: expected a number (s), got 'abc'"),
        ("simulation.duration=", "simulation.duration: expected a number (s), got null"),
        (
            "simulation.duration",
            "simulation.duration: expected key=value, such as simulation.duration=1.5",
        ),
        ("simulation.duration.x=3", "simulation.duration: 'x' does not exist in it: it is 4.0"),
        ("world.gravity.x=3", "world.gravity: 'x' does not exist in it: it is a list"),
        ("world.gravity[3]=3", "world.gravity: there is no item [3]: the list has the items [0] to [2]"),
        ("world[0]=3", "world: 0 does not exist in it: it is a mapping"),
        ("simulation.durration=3", "simulation.durration: unknown key 'durration': did you mean 'duration'?"),
        ("simulaton.duration=3", "simulaton: unknown key 'simulaton': did you mean 'simulation'?"),
        ("robot.cables[0].frame=[1,2]", "robot.cables[0].frame: expected 3 numbers (m), got 2"),
        (
            "robot.cables[7].frame[0]=1",
            "robot.cables: there is no item [7]: the list has the items [0] to [2]",
        ),
        ("robot.cables[0].diameter=null", "robot.cables[0].diameter: no value is given"),
        ("controller.kp=x", "controller.kp: expected a number or 6 numbers (1/s^2), got 'x'"),
        (
            "backend_options.tuned.tolerance=-1",
            "backend_options.tuned.tolerance: must be greater than 0, got -1",
        ),
        ("world={gravity: [0, 0, x]}", "world.gravity[2]: expected a number (m/s^2), got 'x'"),
        ("world=[", "world: not valid YAML"),
        ("world={gravity: 1, gravity: 2}", "world: gravity: given twice"),
        ("world=*a", "world: "),
        ("world=!!python/name:os.system x", "world: tags are not supported"),
        ("name=1\n---\n2", "name: a second document"),
        ("seed=1" + "1" * 400, "seed: a whole number of 401 digits"),
        ("=3", "expected a key such as simulation.duration"),
        ("a..b=3", "expected a key such as simulation.duration"),
        ("a b=3", "expected a key such as simulation.duration"),
        (".a=3", "expected a key such as simulation.duration"),
        ("[0]=3", "expected a key such as simulation.duration"),
        ("world.gravity[-1]=3", "expected a key such as simulation.duration"),
        ("", "expected a key such as simulation.duration"),
    ],
)
def test_problems_name_the_override(override, rest):
    line = problem(BASE, override)
    shown = " ".join(override.split())
    shown = shown if len(shown) <= 80 else shown[:77] + "..."
    assert line.startswith(f"--set {shown}: {rest}")


def test_the_rest_of_the_file_is_checked_too():
    found = problems(changed(BASE, "mass: 150", "mass: 0"), "simulation.seed=x")
    assert len(found) == 2
    assert found[0].startswith("--set simulation.seed=x: ")
    assert found[1].startswith("a.yaml:")


def test_an_override_repairs_the_file():
    text = changed(BASE, "mass: 150", "mass: heavy")
    assert load(text, "robot.platform.mass=3").robot.platform.mass == 3
    # The content of a replaced section is removed with its positions.
    text = changed(BASE, "gravity: [0, 0, -9.81]", "gravity: [0, 0, x]")
    assert problem(text, "world={gravity: [y, 0, 0]}").startswith("--set world={gravity: [y, 0, 0]}: world.gravity[0]:")


def test_python_values():
    overrides = {
        "simulation.duration": np.float64(2.0),
        "simulation.seed": np.int64(3),
        "world.gravity": np.array([0.0, 0.0, -1.0]),
        "trajectory": {"type": "hold", "position": (1, 2, 3)},
        "robot.cables[0].name": "first",
        "name": "1e3",
    }
    scenario = load_scenario("a.yaml", text=BASE, overrides=overrides, plugins=PLUGINS)
    assert scenario.simulation.duration == 2.0
    assert scenario.simulation.seed == 3
    assert scenario.world.gravity == (0, 0, -1)
    assert scenario.trajectory.position == (1, 2, 3)
    assert scenario.robot.cables[0].name == "first"
    assert scenario.name == "1e3"


@pytest.mark.parametrize(
    ("key", "wrong", "rest"),
    [
        ("simulation.duration", "2", "simulation.duration: expected a number (s), got '2'"),
        ("simulation.duration", float("nan"), "simulation.duration: expected a finite number (s), got nan"),
        ("simulation.duration", None, "simulation.duration: expected a number (s), got null"),
        ("simulation.duration", True, "simulation.duration: expected a number (s), got true"),
        (
            "simulation.duration",
            object,
            "simulation.duration: expected a number, a text, a list or a mapping, got type",
        ),
        (
            "simulation.duration",
            {1, 2},
            "simulation.duration: expected a number, a text, a list or a mapping, got set",
        ),
        pytest.param("simulation.seed", 10**5000, "simulation.seed: the whole number is too large", id="huge"),
        ("name", "\ud800", "name: expected a text of valid characters"),
        ("", 1, "expected a key such as simulation.duration or robot.cables[0].frame[2], got ''"),
        (1, 1, "expected a key such as simulation.duration or robot.cables[0].frame[2], got 1"),
    ],
)
def test_python_values_that_are_none(key, wrong, rest):
    line = problem_of_mapping({key: wrong})
    assert line.startswith(f"overrides: {rest}")  # not --set: it was not typed


def problem_of_mapping(overrides) -> str:
    with pytest.raises(ScenarioError) as caught:
        load_scenario("a.yaml", text=BASE, overrides=overrides, plugins=PLUGINS)
    (only,) = caught.value.problems
    return only


def test_a_list_that_holds_itself_ends():
    loop: list = []
    loop.append(loop)
    assert "nested more than 32 deep" in problem_of_mapping({"world": loop})


def test_one_text_alone_is_one_override():
    scenario = load_scenario("a.yaml", text=BASE, overrides="simulation.duration=2", plugins=PLUGINS)
    assert scenario.simulation.duration == 2


@pytest.fixture
def file(tmp_path) -> Path:
    (tmp_path / "r.yaml").write_text(ROBOT)
    (tmp_path / "other.yaml").write_text(changed(ROBOT, "name: tripod", "name: other"))
    (tmp_path / "a.yaml").write_text(HEAD + "robot: r.yaml\n" + QUINTIC + TAIL)
    return tmp_path / "a.yaml"


def test_they_reach_into_a_robot_file(file):
    scenario = load_scenario(file, overrides=["robot.cables[2].frame[0]=3.6", "robot.platform.mass=1"], plugins=PLUGINS)
    assert scenario.robot.cables[2].frame[0] == 3.6
    assert scenario.robot.platform.mass == 1
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file, overrides=["robot.cables[2].frame[0]=x"], plugins=PLUGINS)
    assert caught.value.problems == [
        "--set robot.cables[2].frame[0]=x: robot.cables[2].frame[0]: expected a number (m), got 'x'"
    ]


def test_another_robot_file_can_be_set_and_changed(file):
    for overrides in (
        ["robot=other.yaml", "robot.platform.mass=7"],
        {"robot": Path("other.yaml"), "robot.platform.mass": 7},
        ["robot.platform.mass=8", "robot=other.yaml", "robot.platform.mass=7"],
    ):
        robot = load_scenario(file, overrides=overrides, plugins=PLUGINS).robot
        assert (robot.name, robot.platform.mass) == ("other", 7)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file, overrides=["robot=otter.yaml", "robot.platform.mass=7"], plugins=PLUGINS)
    (only,) = caught.value.problems
    assert only.startswith("--set robot=otter.yaml: robot: there is no file")
    assert "did you mean 'other.yaml'?" in only


def test_a_robot_on_its_own_takes_them_too():
    assert load_robot("r.yaml", text=ROBOT, overrides=["platform.mass=3"]).platform.mass == 3
    with pytest.raises(ScenarioError, match=r"^--set platform.mas=3: platform.mas: unknown key 'mas'"):
        load_robot("r.yaml", text=ROBOT, overrides=["platform.mas=3"])


@pytest.mark.parametrize(
    ("override", "rest"),
    [
        ("robot.platform.inertia[1]=-3", "robot.platform.inertia: no rigid body has this inertia"),
        ("robot.platform.inertia.1=-3", "robot.platform.inertia: no rigid body has this inertia"),
        ("robot.dof[0]=y", "robot.dof: expected each of x, y, z, rx, ry, rz at most once"),
        ("trajectory.to.position[0]=1e7", "trajectory.to.position[0]: must lie between"),
    ],
)
def test_list_errors_are_reported_at_the_override(override, rest):
    assert any(line.startswith(f"--set {override}: {rest}") for line in problems(BASE, override))


def test_the_same_with_a_nominal_model():
    override = "believed.platform.inertia[1]=-3"
    assert problem(BASE, override).startswith(f"--set {override}: believed.platform.inertia: no rigid body")


def test_an_item_of_a_list_that_is_not_there_is_one_problem():
    override = "events[0].time=1"
    assert problem(BASE, override) == f"--set {override}: events: there is no item [0]: no list is given here"


CONTRADICTIONS = {
    "backend": {"simulation.backend": "mujoco"},
    "solver": {"solver": {"type": "lp"}},
    "controller": {"controller.type": "pid"},
}
CHOSEN = {"backend": "reference", "solver": "qp", "controller": "static"}


@pytest.mark.parametrize("role", CONTRADICTIONS)
@pytest.mark.parametrize("entry", ["load_scenario", "simulate", "rollout", "Batch", "Simulation", "with_changes"])
def test_an_argument_and_an_override_must_agree(role, entry):
    def call(overrides, chosen):
        given = {"overrides": overrides, role: chosen}
        if entry == "with_changes":
            return load_scenario("caroca").with_changes(**given)
        more = {"n": 1, "vary": {"initial.position[0]": [0.0]}} if entry == "rollout" else {}
        return getattr(cdpr, entry)("caroca", *((1,) if entry == "Batch" else ()), **given, **more)

    with pytest.raises(ScenarioError, match=rf"{role}='{CHOSEN[role]}': .*overrides; give one of the two"):
        call(CONTRADICTIONS[role], CHOSEN[role])
    if entry == "load_scenario":
        assert call({CHOICES[role]: CHOSEN[role]}, CHOSEN[role])


def test_a_section_without_a_plugin_leaves_the_choice_to_the_argument():
    found = load_scenario("caroca", backend="mujoco", overrides={"simulation": {"duration": 0.1}})
    assert (found.simulation.backend, found.simulation.duration) == ("mujoco", 0.1)
    found = load_scenario("caroca", controller="pid", overrides={"controller": {"kp": 3.0}})
    assert (found.controller.type, found.controller_options.kp) == ("pid", 3.0)
    typed_too = Editor("caroca", typed({"controller": "pid"}, ["controller={kp: 3.0}"])).scenario()
    assert (typed_too.controller.type, typed_too.controller_options.kp) == ("pid", 3.0)


def test_a_typed_choice_and_a_set_value_must_agree():
    given = typed({"backend": "mujoco"}, ["simulation.backend=reference"])
    with pytest.raises(ScenarioError) as told:
        load_scenario("caroca", overrides=given)
    (line,) = str(told.value).splitlines()
    assert line.startswith("--backend mujoco: simulation.backend: contradicts 'reference' of --set simulation.backend")
    with pytest.raises(ScenarioError, match="contradicts"):
        Editor("caroca", given)
    assert Editor("caroca", typed({"backend": "reference"}, ["simulation.backend=reference"]))


@pytest.mark.parametrize("entry", ["rollout", "Batch"])
def test_a_varied_key_and_an_argument_exclude_each_other(entry):
    with pytest.raises(ScenarioError, match=r"controller= sets controller\.type"):
        getattr(cdpr, entry)("caroca", 2, vary={"controller.type": ["pid", "static"]}, controller="pid")


@pytest.mark.parametrize("given", [{"vary": {}}, {"seed": -1, "vary": {"controller.kp": [1.0]}}])
@pytest.mark.parametrize("entry", ["rollout", "Batch"])
def test_a_message_names_the_function_that_was_called(entry, given):
    with pytest.raises(CdprError, match=f"^{entry}: "):
        getattr(cdpr, entry)("caroca", 1, **given)


@pytest.mark.parametrize("name", ["mocap", "pose"])
def test_names_of_items_lead_to_their_index(name):
    with pytest.raises(ScenarioError, match=r"it is a list; use the index of the item, \[0\]"):
        load_scenario("noisy_pose", overrides={f"sensors.{name}.delay": 0.0})
