"""MuJoCo's servos on tendons as winches: their law, numbers by hand, and motions against MuJoCo itself."""

from __future__ import annotations

import numpy as np
import pytest

import cdpr
from cdpr.base.errors import FormatError
from cdpr.cables import commands_of
from cdpr.formats import import_file
from cdpr.formats.read.import_files import write

mujoco = pytest.importorskip("mujoco")

CORNERS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
POSITION = '<position tendon="c{k}" kp="600" kv="60" ctrlrange="0.05 3" forcerange="-80 0"/>'
VELOCITY = '<velocity tendon="c{k}" kv="60" ctrlrange="-2 1" forcerange="-80 0"/>'


def model(servo=POSITION, more="", tendon="", others=None):
    """Four cables above a box of 1 kg; `others` replaces the actuator of cable 0."""
    frame = "".join(f'<site name="a{k}" pos="{x} {y} 2"/>' for k, (x, y) in enumerate(CORNERS))
    ends = "".join(f'<site name="b{k}" pos="{x / 10} {y / 10} 0"/>' for k, (x, y) in enumerate(CORNERS))
    cables = "".join(
        f'\n<spatial name="c{k}" {tendon}><site site="a{k}"/><site site="b{k}"/></spatial>' for k in range(4)
    )
    pulls = "".join((others if others and k == 0 else servo).format(k=k) for k in range(4))
    return (
        f'<mujoco model="crane"><option timestep="0.001"/><worldbody>{frame}<body name="box" pos="0 0 1"><freejoint/>'
        f'<geom type="box" size="0.1 0.1 0.02" mass="1"/>{ends}</body></worldbody><tendon>{cables}</tendon>'
        f"<actuator>{pulls}{more}</actuator></mujoco>"
    )


def imported(tmp_path, text, **options):
    path = tmp_path / "model.xml"
    path.write_text(text)
    found = import_file(path, **options)
    return cdpr.load_robot(write(found, tmp_path / "out", force=True)[0]), "\n".join(found.warnings + found.left_out)


def test_gains_of_a_position_servo(tmp_path):
    robot, said = imported(tmp_path, model(tendon='armature="0.03" damping="2" frictionloss="0.5"'))
    assert commands_of(robot) == ["length"] * 4
    for cable in robot.cables:
        winch = cable.winch
        assert (winch.type, winch.drum_radius, winch.inertia) == ("position", 1.0, 0.03)
        own = {"position_gain": 10.0, "velocity_gain": 60.0, "torque_max": 80.0}  # kp / kv, kv, N at 1 m
        assert {key: winch.own[key] for key in own} == own
        assert (winch.viscous_friction, winch.coulomb_friction) == (2.0, 0.5)
    assert "4 tendons have servos ('c0', 'c1', 'c2', 'c3'), imported as winches of the type position" in said
    assert "ctrlrange of servos of length" in said
    assert "inertia" not in said
    # The cable is 100 times as stiff as the servo: 600 N/m over its length, sqrt(2 x 0.9^2 + 1) m.
    assert robot.cables[0].axial_stiffness == pytest.approx(60000 * np.sqrt(2.62), rel=0.05)


def test_a_servo_without_damping_keeps_its_stiffness(tmp_path):
    robot, said = imported(tmp_path, model(POSITION.replace('kv="60" ', "")))
    own = robot.cables[0].winch.own
    assert own["position_gain"] * own["velocity_gain"] == 600
    assert "velocity gains of servos without kv, so that position_gain is 20 1/s" in said


def test_the_damping_ratio_is_that_of_mujocos_compiler(tmp_path):
    text = model(POSITION.replace('kv="60"', 'dampratio="1"'))
    robot, _ = imported(tmp_path, text)
    kv = -mujoco.MjModel.from_xml_string(text).actuator_biasprm[:, 2]
    np.testing.assert_allclose([cable.winch.own["velocity_gain"] for cable in robot.cables], kv, rtol=1e-12)


def test_gains_of_velocity_servos(tmp_path):
    robot, _ = imported(tmp_path, model(VELOCITY))
    assert commands_of(robot) == ["rate"] * 4
    own = robot.cables[0].winch.own
    assert (own["velocity_gain"], own["speed_max"], own.get("integral_gain", 0)) == (60, 2, 0)
    text = '<intvelocity tendon="c{k}" kp="600" kv="60" actrange="0 3" forcerange="-80 0"/>'
    robot, _ = imported(tmp_path, model(text))
    own = robot.cables[0].winch.own
    assert (robot.cables[0].winch.type, own["velocity_gain"], own["integral_gain"]) == ("velocity", 60, 600)


def test_gears_and_scales(tmp_path):
    # T = -2 (50 c - 5 - 100 x 2 l - 10 x 2 l'): kp = 400, kv = 40, L = (50 c - 5) / 200.
    servo = (
        '<general tendon="c{k}" gear="2" gaintype="fixed" gainprm="50" biastype="affine" biasprm="-5 -100 -10" '
        'forcerange="-30 0"/>'
    )
    robot, said = imported(tmp_path, model(servo))
    own = robot.cables[0].winch.own
    assert (own["position_gain"], own["velocity_gain"], robot.tension_max[0]) == (10, 40, 60)
    assert "tendon 'c0': a control of c is a length of 0.25 c -0.025 there; commands here are lengths" in said


def test_motors_beside_servos_stay_ideal(tmp_path):
    motor = '<motor tendon="c{k}" gear="-1" ctrllimited="true" ctrlrange="1 90"/>'
    robot, said = imported(tmp_path, model(others=motor))
    assert [cable.model for cable in robot.cables] == ["ideal", None, None, None]
    assert commands_of(robot) == ["tension", "length", "length", "length"]
    assert "3 tendons have servos ('c1', 'c2', 'c3')" in said


def test_filters_are_reported(tmp_path):
    _, said = imported(tmp_path, model(POSITION.replace("kp=", 'timeconst="0.1" kp=')))
    assert "timeconst of servos: commands here act at once ('c0', 'c1', 'c2', 'c3')" in said


@pytest.mark.parametrize(
    "bias", ["0 100 -10", "0 -100 10", "5 0 0"], ids=["negative stiffness", "negative damping", "constant"]
)
def test_other_laws_are_rejected(tmp_path, bias):
    servo = f'<general tendon="c{{k}}" gainprm="50" biastype="affine" biasprm="{bias}" forcerange="-30 0"/>'
    with pytest.raises(FormatError, match=r"model\.xml:2: tendon 'c0': its actuator has its own gain, bias or"):
        imported(tmp_path, model(servo))


def simulated(robot, **more):
    scenario = {
        "robot": robot,
        "simulation": {"backend": "reference", "duration": 0.5, "control_step": 0.001, "physics_step": 0.00025},
        "controller": {"type": "inverse_kinematics"},
    }
    return cdpr.simulate(cdpr.Scenario(**scenario, **more))


def heights_in_mujoco(text, commands):
    there = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(there)
    heights = []
    for command in commands:
        heights.append(data.qpos[2])
        data.ctrl[:] = command
        mujoco.mj_step(there, data)
    return np.array(heights)


def test_a_position_servo_falls_as_in_mujoco(tmp_path):
    """The box falls into its servos, which hold the lengths of the start."""
    text = model(tendon='armature="0.02"')
    robot, _ = imported(tmp_path, text)
    fall = 1.0 - heights_in_mujoco(text, [np.sqrt(2.62)] * 500)
    run = simulated(robot)
    assert fall[-1] > 5e-3
    # Apart from the stretch of the cables, a percent of that of the servos, and half a step of MuJoCo's.
    np.testing.assert_allclose(1.0 - run.position[:500, 2], fall, atol=0.02 * fall[-1])


def test_a_velocity_servo_rises_as_in_mujoco(tmp_path):
    """At the start a servo of ours holds the load; MuJoCo's does this with a constant bias."""
    robot, _ = imported(tmp_path, model(VELOCITY, tendon='armature="0.02"'))
    load = 9.81 / 4 * np.sqrt(2.62)  # N, of each cable
    held = (
        f'<general tendon="c{{k}}" gainprm="60" biastype="affine" biasprm="{-load} 0 -60" forcerange="-80 0" '
        'ctrlrange="-2 1"/>'
    )
    run = simulated(robot, trajectory={"type": "quintic", "duration": 0.5, "to": {"position": [0, 0, 1.1]}})
    rise = heights_in_mujoco(model(held, tendon='armature="0.02"'), run.winch_command[:500]) - 1.0
    assert 0.05 < rise[-1] < 0.1
    np.testing.assert_allclose(run.position[:500, 2] - 1.0, rise, atol=0.02 * rise[-1])
