"""Poles of linearised loops against models written here, and against runs."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT
from scipy.linalg import expm

import cdpr
from cdpr.base.errors import CdprError
from cdpr.plugins import Controller, SnapshotOfArrays
from cdpr.plugins.registry import registry
from cdpr.simulation import loop_problems as loop_problems_module
from cdpr.simulation.linearised import linearise
from cdpr.simulation.linearised_scenario import NotLinearisedError
from cdpr.simulation.loop_problems import loop_problems
from cdpr.simulation.poles import bandwidths, closed_loop, plant_poles, poles, verdict

SCENARIOS = ROOT / "scenarios"
HEIGHT, MASS, G = 3.0, 10.0, 9.81


def crane(control_step=0.004, physics_step=0.001, controller=None, cable=None, winch=None, below=False):
    """Return a platform that moves along z below one vertical cable, or between two."""
    ends = [HEIGHT, 0.0] if below else [HEIGHT]
    data = {
        "robot": {
            "name": "crane",
            "dof": ["z"],
            "platform": {"mass": MASS},
            "tension": {"min": 1.0 if below else 0.0, "max": 1e5},
            "home": {"position": [0.0, 0.0, 1.0]},
            "cables": [{"frame": [0.0, 0.0, end], "platform": [0.0, 0.0, 0.0]} for end in ends],
        },
        "simulation": {
            "backend": "reference",
            "duration": 1.0,
            "control_step": control_step,
            "physics_step": physics_step,
        },
        "trajectory": {"type": "hold"},
        "controller": controller or {"type": "computed_torque", "kp": 100.0, "kd": 10.0},
    }
    if cable:
        data["robot"] |= {"cable": cable, "winch": winch}
    return cdpr.load_scenario(data)


def at_start(scenario, **more):
    return linearise(scenario, scenario.initial.state()[:7], **more)


def same_poles(found, expected):
    """Compare two sets of poles, each with its nearest of the other."""
    ours = np.array([pole.value for pole in found])
    assert len(ours) == len(expected)
    for one in expected:
        k = int(np.argmin(np.abs(ours - one)))
        assert abs(ours[k] - one) <= 1e-6 * abs(one)
        ours = np.delete(ours, k)


@pytest.mark.parametrize("below", [False, True])
@pytest.mark.parametrize(("kp", "kd"), [(100.0, 10.0), (400.0, 6.0), (2500.0, 150.0)])
def test_computed_torque_on_ideal_cables(kp, kd, below):
    """The plant is a double integrator; its acceleration -kp e - kd e' is held over a control step."""
    h = 0.004
    loop = at_start(crane(h, controller={"type": "computed_torque", "kp": kp, "kd": kd}, below=below), response=True)
    held = np.array([[1.0, h], [0.0, 1.0]]) - np.array([[0.5 * h * h], [h]]) @ np.array([[kp, kd]])
    same_poles(poles(loop), np.log(np.linalg.eigvals(held).astype(complex)) / h)
    assert verdict(loop) == "stable"
    fast = at_start(crane(1e-4, 1e-4, controller={"type": "computed_torque", "kp": kp, "kd": kd}), response=True)
    for pole, exact in zip(poles(fast), sorted(np.roots([1.0, kd, kp]), key=lambda s: (-s.real, -s.imag)), strict=True):
        assert abs(pole.value - exact) <= 0.02 * abs(exact)  # those of s^2 + kd s + kp, for short steps
    ratio = kd / (2.0 * math.sqrt(kp))
    if ratio < 1.0:
        assert poles(fast)[0].damping == pytest.approx(ratio, abs=0.01)
        assert poles(fast)[0].frequency == pytest.approx(math.sqrt(kp) / (2.0 * math.pi), rel=0.01)
    a = 1.0 - 2.0 * ratio**2  # 3 dB below: (1 - x)^2 + (2 zeta)^2 x = 2, with x = (w / w0)^2
    band = math.sqrt(kp * (a + math.sqrt(a * a + 1.0))) / (2.0 * math.pi)
    assert bandwidths(fast)[0] == pytest.approx(band, rel=0.02)


def test_too_long_control_steps_are_unstable():
    """A damping gain is stable up to kd h = 2 without kp."""
    for kd, expected in ((480.0, "stable"), (520.0, "unstable")):
        scenario = crane(0.004, controller={"type": "computed_torque", "kp": 100.0, "kd": kd})
        assert verdict(at_start(scenario)) == expected
    known, found = loop_problems(scenario)
    assert known == "unstable"
    path, text = found[0]
    assert path == ("controller",)
    assert "controller.kp 25 and controller.kd 260" in text
    assert "simulation.control_step 0.002" in text


EA, DAMPING, RADIUS, INERTIA, FRICTION = 2e4, 50.0, 0.05, 0.002, 0.01


def drum_model(kp, kd, h, damping=DAMPING):
    """Return poles of platform, drum and spring: z, v, l0, w, with the command held over h; independent of cdpr."""
    length = HEIGHT - 1.0
    l0 = length / (1.0 + MASS * G / EA)
    k, k0 = EA / l0, EA * length / l0**2
    pull = np.array([-k, -damping, -k0, damping * RADIUS])  # change of the tension
    A = np.zeros((4, 4))
    A[0, 1], A[1], A[2, 3] = 1.0, pull / MASS, -RADIUS
    A[3] = -RADIUS * pull / INERTIA
    A[3, 3] -= FRICTION / INERTIA
    both = np.zeros((5, 5))
    both[:4, :4], both[3, 4] = A, RADIUS / INERTIA
    step = expm(both * h)
    gains = MASS * np.array([kp, kd, 0.0, 0.0])
    return np.log(
        np.linalg.eigvals(step[:4, :4] - np.outer(step[:4, 4], gains)).astype(complex)
    ) / h, np.linalg.eigvals(A)


@pytest.mark.parametrize(("kp", "kd"), [(100.0, 10.0), (25.0, 10.0), (900.0, 60.0)])
def test_drum_and_spring(kp, kd):
    h = 0.002
    scenario = crane(
        h,
        1e-4,
        controller={"type": "computed_torque", "kp": kp, "kd": kd},
        cable={"model": "elastic", "axial_stiffness": EA, "damping": DAMPING},
        winch={"drum_radius": RADIUS, "inertia": INERTIA, "viscous_friction": FRICTION},
    )
    loop = at_start(scenario)
    expected, plant = drum_model(kp, kd, h)
    same_poles(poles(loop), expected)
    growing = expected.real.max() > 0.0
    assert verdict(loop) == ("unstable" if growing else "stable")
    ours = plant_poles(loop)  # platform and winch also have neutral motions, which are badly conditioned
    fastest = max(plant, key=abs)
    assert min(abs(ours - fastest)) <= 1e-6 * abs(fastest)


def test_pid_and_its_integral():
    h, kp, kd, ki = 0.004, 100.0, 15.0, 200.0
    loop = at_start(crane(h, controller={"type": "pid", "kp": kp, "kd": kd, "ki": ki}))
    # z, v, and the sum of -ki h z, which includes the present sample
    feed = np.array([-kp - ki * h, -kd, 1.0])
    held = np.array([[1.0, h, 0.0], [0.0, 1.0, 0.0], [-ki * h, 0.0, 1.0]])
    held[:2] += np.outer([0.5 * h * h, h], feed)
    same_poles(poles(loop), np.log(np.linalg.eigvals(held).astype(complex)) / h)


def test_poles_are_those_of_small_differences_of_runs():
    """Errors of a run near rest are the powers of the linear map."""
    scenario = cdpr.load_scenario(SCENARIOS / "cogiro.yaml", overrides={"trajectory": {"type": "hold"}})
    loop = at_start(scenario)
    pushed = {"initial.velocity": [1e-5, 2e-5, -1e-5], "simulation.duration": 0.05}
    still = {"simulation.duration": 0.05}
    runs = [cdpr.simulate(scenario, overrides=changes) for changes in (pushed, still)]
    moved = runs[0].position - runs[1].position
    x = np.zeros(12)
    x[6:9] = np.array([1e-5, 2e-5, -1e-5]) / loop.scale[6:9]
    power = np.linalg.matrix_power(loop.A, len(moved) - 1) @ x
    assert moved[-1] == pytest.approx(power[:3] * loop.scale[:3], rel=1e-4)


def test_camera_robot_rests_below_its_target():
    figures = closed_loop(scenario := cdpr.load_scenario(SCENARIOS / "camera_robot.yaml"), scenario.initial.state()[:7])
    run = cdpr.simulate(scenario, overrides={"trajectory": {"type": "hold"}, "simulation.duration": 10.0})
    assert figures["verdict"] == "stable"
    assert figures["rest_offset_m"] == pytest.approx(
        np.linalg.norm(run.position[-1] - run.desired_position[-1]), abs=1e-6
    )


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("remote_controller", "controller 'remote'"),
        ("remote_plant", "backend 'remote'"),
        ("winch_fmu", "actuator FMUs"),
        ("thesis", "no tensions within their limits"),
    ],
)
def test_loops_without_a_linearisation_report_the_reason(name, reason):
    scenario = cdpr.load_scenario(SCENARIOS / f"{name}.yaml")
    with pytest.raises(NotLinearisedError, match=reason):
        at_start(scenario)
    assert reason in closed_loop(scenario, scenario.initial.state()[:7])["problem"]
    known, found = loop_problems(scenario)
    assert known.startswith("not computed: ")
    assert not found


class Filtered(SnapshotOfArrays, Controller):
    """Damping with a filter of first order, whose value is in an array."""

    def __init__(self, robot, gravity, control_step, options):
        super().__init__(robot, gravity, control_step, options)
        self.filtered = np.zeros(1)
        self.arrays = (self.filtered,)

    def control(self, time, state, desired, out):
        self.filtered += 0.1 * (state[9] - self.filtered)
        out[:] = 0.0
        out[2] = MASS * (G - 100.0 * (state[2] - desired[2]) - 10.0 * self.filtered[0])

    def reset(self):
        self.filtered[:] = 0.0


class Slow(Filtered):
    period = 3


class Hidden(Controller):
    def control(self, time, state, desired, out):
        out[:] = [0.0, 0.0, MASS * G, 0.0, 0.0, 0.0]


class Broken(Filtered):
    def control(self, time, state, desired, out):
        raise ValueError("no data")


def with_class(kind):
    plugins, name = registry().with_class("controller", kind)
    return crane().with_changes({}, controller=name, plugins=plugins)


@pytest.mark.parametrize("kind", [Filtered, Slow])
def test_controllers_in_python(kind):
    """State z, v, f: f grows by (v - f) / 10 in each call, and the command is held over `period` control steps."""
    h = 0.004 * kind.period
    memory = np.array([0.0, 0.1, 0.9])
    feed = np.array([-100.0, 0.0, 0.0]) - 10.0 * memory
    held = np.vstack([[1.0, h, 0.0], [0.0, 1.0, 0.0], memory])
    held[:2] += np.outer([0.5 * h * h, h], feed)
    same_poles(poles(at_start(with_class(kind))), np.log(np.linalg.eigvals(held).astype(complex)) / h)


def test_controllers_with_hidden_states_and_errors_are_reported():
    with pytest.raises(NotLinearisedError, match="the states of the controller 'Hidden' are not known"):
        at_start(with_class(Hidden))
    with pytest.raises(NotLinearisedError, match="a plugin raised ValueError: no data"):
        at_start(with_class(Broken))


def test_soft_cables_with_fast_servos_have_a_state_of_rest():
    """The stiffness of the cables is small against that of the servos' integral parts."""
    frame = [[x, y, 4.0] for x, y in ((-4.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-4.0, 3.0))]
    scenario = cdpr.Scenario(
        robot={
            "dof": ["x", "y", "z"],
            "platform": {"mass": 6.0},
            "tension": {"min": 1.0, "max": 200.0},
            "home": {"position": [0.0, 0.0, 2.0]},
            "cable": {"model": "elastic", "axial_stiffness": 8000.0, "damping": 50.0},
            "winch": {
                "type": "position",
                "drum_radius": 0.04,
                "inertia": 0.002,
                "position_gain": 40.0,
                "velocity_gain": 1.0,
                "integral_gain": 20.0,
            },
            "cables": [{"frame": place, "platform": [0.0, 0.0, 0.0]} for place in frame],
        },
        simulation={"duration": 1.0, "control_step": 0.002, "physics_step": 0.001},
        controller={"type": "inverse_kinematics"},
    )
    figures = closed_loop(scenario, np.array([1.0, 0.5, 2.2, 1.0, 0.0, 0.0, 0.0]))
    assert figures["verdict"] == "stable"


def test_slack_cables_are_reported():
    """Above the upper anchor's reach, the lower cable hangs loose."""
    cable = {"model": "elastic", "axial_stiffness": EA, "damping": DAMPING}
    winch = {"type": "position"}
    scenario = crane(controller={"type": "inverse_kinematics", "pretension": 1.0}, cable=cable, winch=winch, below=True)
    loop = at_start(scenario)
    assert loop.notes == ("slack at rest, without stiffness: cable_2",)


def test_the_physics_step_and_the_control_step_are_checked():
    cable = {"model": "elastic", "axial_stiffness": 2e5, "damping": 5.0}
    winch = {"drum_radius": RADIUS, "inertia": 2e-4}
    scenario = crane(
        0.02, 0.001, controller={"type": "computed_torque", "kp": 1.0, "kd": 2.0}, cable=cable, winch=winch
    )
    found = dict(loop_problems(scenario)[1])
    assert "less than twice in a period" in found["simulation", "control_step"]
    sensors = [{"type": "imu"}, {"type": "pose", "period": 0.02}, {"type": "twist", "period": 0.002}]
    found = dict(loop_problems(scenario.with_changes({"simulation.control_step": 0.001, "sensors": sensors}))[1])
    assert "0.02 s samples a vibration" in found["sensors", 1, "period"]
    assert ("simulation", "control_step") not in found
    stiff = {"type": "velocity", "drum_radius": RADIUS, "inertia": 2e-3, "velocity_gain": 4.0}
    scenario = crane(0.02, 0.001, controller={"type": "inverse_kinematics"}, cable=cable, winch=stiff)
    found = dict(loop_problems(scenario)[1])
    assert list(found) == [("simulation", "physics_step")]
    assert "lower gains of the servos" in found["simulation", "physics_step"]


def test_lower_gains_of_servos_are_a_remedy():
    cable = {"model": "elastic", "axial_stiffness": 2e5, "damping": 500.0}
    servo = {"type": "position", "drum_radius": RADIUS, "inertia": 2e-3, "position_gain": 40.0, "velocity_gain": 0.5}
    servo |= {"integral_gain": 50.0}
    scenario = crane(0.004, 2e-4, controller={"type": "inverse_kinematics"}, cable=cable, winch=servo)
    known, found = loop_problems(scenario)
    assert known == "unstable"
    assert "it is stable with robot.winch.position_gain 20" in dict(found)["controller",]
    assert verdict(at_start(scenario.with_changes({"robot.winch.position_gain": 20.0}))) == "stable"


@pytest.mark.parametrize("drives", [{"rate_max": 1e6}, {"delay": 0.02}])
def test_drives_do_not_hide_the_steps_that_are_too_long(drives):
    """Only the modes of a delay have no warning of the control step."""
    cable = {"model": "elastic", "axial_stiffness": 2e5, "damping": 5.0}
    winch = {"drum_radius": RADIUS, "inertia": 2e-4}
    gains = {"type": "computed_torque", "kp": 1.0, "kd": 2.0}
    scenario = crane(0.02, 0.001, controller=gains, cable=cable, winch=winch).with_changes({"drives": drives})
    assert ("simulation", "physics_step") in dict(loop_problems(scenario)[1])
    gains = {"type": "computed_torque", "kp": 2500.0, "kd": 50.0}
    scenario = crane(0.02, controller=gains)
    assert ("simulation", "control_step") in dict(loop_problems(scenario)[1])
    found = dict(loop_problems(scenario.with_changes({"drives": drives}))[1])
    assert (("simulation", "control_step") in found) == ("delay" not in drives)


def test_the_verdict_is_the_worse_of_both_poses(monkeypatch):
    motion = {"type": "quintic", "duration": 0.5, "to": {"position": [0.0, 0.0, 1.2]}}
    scenario = crane().with_changes({"trajectory": motion})
    for both in (["undecided", "undamped"], ["undamped", "undecided"]):
        answers = iter(both)
        monkeypatch.setattr(loop_problems_module, "verdict", lambda loop, answers=answers: next(answers))
        assert loop_problems(scenario)[0] == "undecided"


def test_engines_have_the_scheme_of_their_backend():
    """Drums with friction, whose differences need small steps: almost the loop of the reference."""
    scenario = cdpr.load_scenario(SCENARIOS / "winch.yaml")
    here, there = (
        bandwidths(at_start(each, response=True))
        for each in (scenario, scenario.with_changes({"simulation.backend": "mujoco"}))
    )
    assert here == pytest.approx(there, rel=0.01)
    assert here != there


def test_commands_report_poles(tmp_path):
    (tmp_path / "s.yaml").write_text(
        crane(controller={"type": "computed_torque", "kp": 1.0, "kd": 520.0}).resolved_yaml()
    )
    checked = cdpr_here("validate", "s.yaml", cwd=tmp_path)
    assert "s.yaml: ok" in checked.stdout
    assert "controller: the closed loop is unstable at rest at the initial pose" in checked.stderr
    shown = cdpr_here("info", "s.yaml", cwd=tmp_path).stdout
    assert "verdict              UNSTABLE: a mode grows" in shown


@pytest.mark.slow  # tests of light commands import it, too
def test_validate_loads_no_engine():
    slow = ("scipy", "matplotlib", "mujoco", "pybullet", "dartpy")
    code = (
        "import atexit, sys; from cdpr.ui.cli import main;"
        f"atexit.register(lambda: print([*{set(slow)!r} & set(sys.modules)], file=sys.stderr)); main()"
    )
    words = ["validate", str(SCENARIOS / "caroca.yaml"), "--set", "simulation.backend=mujoco"]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
    assert done.stderr.endswith("[]\n")


def test_errors_are_those_of_cdpr():
    assert issubclass(NotLinearisedError, CdprError)


@pytest.mark.parametrize("late", [1, 5, 20])
def test_late_commands_wait_in_the_drives(late):
    """Closed form: the acceleration of the feedback acts `late` control periods later, and is held for one."""
    step, kp, kd = 0.004, 100.0, 10.0
    scenario = crane().with_changes({"drives": {"delay": late * step, "rate_max": 1e6}})
    expected = np.zeros((2 + late, 2 + late))  # height, speed, and the accelerations that wait, the oldest last
    expected[:2, :2] = [[1.0, step], [0.0, 1.0]]
    expected[:2, -1] = step**2 / 2.0, step
    expected[2, :2] = -kp, -kd
    expected[3:, 2:-1] = np.eye(late - 1)
    found, wanted = (np.linalg.eigvals(each) for each in (at_start(scenario).A, expected))
    found, wanted = (each[np.abs(each) > 1e-3] for each in (found, wanted))
    assert len(found) == len(wanted)
    assert max(np.abs(found - z).min() for z in wanted) < 1e-6
    assert verdict(at_start(scenario)) == ("stable" if np.abs(wanted).max() < 1.0 else "unstable")
    assert (late < 20) == (np.abs(wanted).max() < 1.0)


def test_drives_that_are_not_linear_have_no_poles():
    for drives in ({"resolution": 0.1}, {"cables": {"cable_1": {"backlash": 0.1}}}):
        with pytest.raises(NotLinearisedError, match="the resolution or the backlash of the drives is not linear"):
            at_start(crane().with_changes({"drives": drives}))
