"""MJCF: export and import are inverses, and random models have MuJoCo's own forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mjcf_cases import ROBOTS, SAME, compiled, mujoco, random_states, robot_of

import cdpr
from cdpr.formats.write.export_model import begin, export
from cdpr.mechanics.kinematics import lengths, make_state, wrench_matrix
from cdpr.mechanics.properties import home_pose
from cdpr.model import rotations

WHOLE = ["caroca", "off_centre", "cogiro", "planar", "planar_point_mass", "spherical", "point_mass", "carriage", "nine"]


@pytest.mark.parametrize("name", WHOLE)
def test_export_and_import_are_inverses(tmp_path, name):
    subject = begin(cdpr.load_robot(ROBOTS / f"{name}.yaml"))
    first = subject.robot
    if first.n in (3, 6) and first.dof[-1] == "rz":
        state = subject.state.copy()
        state[3:7] = rotations.from_rpy(0.1, -0.2, 0.3)
        subject = replace(subject, state=state)
    again = robot_of(tmp_path, export(subject, "mjcf"))
    assert (again.name, again.dof, again.unilateral) == (first.name, first.dof, first.unilateral)
    assert [cable.name for cable in again.cables] == [cable.name for cable in first.cables]
    assert [cable.diameter for cable in again.cables] == [cable.diameter for cable in first.cables]
    assert again.tension_min.tolist() == first.tension_min.tolist()
    assert again.tension_max.tolist() == first.tension_max.tolist()
    assert np.allclose(home_pose(again)[0][:3], subject.state[:3], atol=SAME)
    assert np.allclose(home_pose(again)[0][3:], subject.state[3:7], atol=SAME)
    assert np.allclose(again.inertial, first.inertial, rtol=SAME, atol=SAME)
    for state in random_states(100):
        assert np.abs(wrench_matrix(again, state) - wrench_matrix(first, state)).max() <= SAME
    once_more = robot_of(tmp_path, export(begin(again), "mjcf"))
    for state in random_states(100):
        assert np.abs(wrench_matrix(once_more, state) - wrench_matrix(first, state)).max() <= SAME


FREE = ["<freejoint/>", '<joint type="ball" pos="{}"/>', '<joint type="slide" axis="0 1 0"/>']
HINGED = (
    '<joint type="slide" axis="1 0 0" ref="0.3"/><joint type="slide" axis="0 0 -1"/>'
    '<joint type="hinge" axis="0 -1 0" pos="{}" ref="0.4"/>'
)
WIDTHS = [7, 4, 1, 3]  # of a pose of each


@pytest.mark.parametrize("seed", range(20))
def test_models_at_random(tmp_path, seed):
    """Turned frames, bodies on bodies, all kinds of joints: lengths, centre of mass and accelerations are MuJoCo's."""
    rng = np.random.default_rng(seed)

    def numbers(count=3, size=1.0):
        return " ".join(map(repr, (size * rng.normal(size=count)).tolist()))

    cables, kind = int(rng.integers(1, 9)), seed % 4
    joints = [*FREE, HINGED][kind].format(numbers())
    turned = f'quat="{numbers(4)}"' if kind < 2 else ""
    named = f'<site name="platform" pos="{numbers()}" quat="{numbers(4)}"/>' if seed % 3 else ""
    fixed = "".join(f'<site name="f{k}" pos="{numbers(size=3.0)}"/>' for k in range(cables))
    moving = "".join(f'<site name="b{k}" pos="{numbers()}"/>' for k in range(cables))
    pairs = [(f"f{k}", f"b{k}")[:: 1 - 2 * (k % 2)] for k in range(cables)]
    text = f"""<mujoco><compiler angle="radian" eulerseq="ZYX"/><option gravity="0 0 0"/><worldbody>
      <frame pos="{numbers()}" quat="{numbers(4)}"><body pos="{numbers()}" euler="{numbers()}">{fixed}</body></frame>
      <body name="load" pos="{numbers()}" {turned}>{joints}{named}
        <geom type="box" size="0.3 0.2 0.1" pos="{numbers()}" quat="{numbers(4)}"/>
        <geom type="capsule" size="0.1" fromto="{numbers(6)}" mass="2"/>
        <body pos="{numbers()}" quat="{numbers(4)}"><geom type="ellipsoid" size="0.1 0.2 0.3"/>{moving}</body>
      </body></worldbody>
    <tendon>{"".join(f'<spatial><site site="{a}"/><site site="{b}"/></spatial>' for a, b in pairs)}</tendon>
    <actuator>{"".join(f'<motor tendon="t{k}" gear="-1" ctrlrange="0 99"/>' for k in range(cables))}</actuator>
    <keyframe><key qpos="{numbers(WIDTHS[kind], 0.3)}"/></keyframe></mujoco>"""
    for k in range(cables):
        text = text.replace("<spatial>", f'<spatial name="t{k}">', 1)
    robot = robot_of(tmp_path, text)
    model, data = compiled(text)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = tension = rng.uniform(0.0, 99.0, cables)
    mujoco.mj_forward(model, data)
    state, R = make_state(robot.home[:3], robot.home[3:]), rotations.matrix(robot.home[3:])
    body, c = data.body("load"), R @ robot.platform.center_of_mass
    assert np.allclose(lengths(robot, state), data.ten_length, atol=SAME)
    assert np.allclose(robot.home[:3] + c, body.subtree_com, atol=SAME)
    if kind == 0:
        wrench = wrench_matrix(robot, state) @ tension
        turning = np.linalg.solve(R @ robot.platform.inertia @ R.T, wrench[3:] - np.cross(c, wrench[:3]))
        assert np.allclose(body.xmat.reshape(3, 3) @ data.qacc[3:], turning, rtol=1e-9, atol=1e-9)


def scaled(robot, factor):
    """A robot of another size and mass, whose numbers are no short decimals; names may be so, or of other alphabets."""
    names = ["Zug", "łańcuch", "索", "1e30", "cable.5", "_6", "inf", "8th"]
    third = factor / 3.0
    cables = [
        replace(
            cable,
            name=name,
            frame=third * cable.frame,
            platform=third * cable.platform,
            tension_min=third * cable.tension_min,
            tension_max=third * cable.tension_max,
            diameter=third * 0.01,
            length_max=third * 20.0,
        )
        for cable, name in zip(robot.cables, names, strict=True)
    ]
    home = np.concatenate([third * home_pose(robot)[0][:3], rotations.from_rpy(0.1, -0.2, 0.3)])
    body = robot.platform
    platform = replace(
        body, mass=third * body.mass, inertia=third**3 * body.inertia, center_of_mass=third * body.center_of_mass
    )
    return replace(robot, name="nan", cables=tuple(cables), platform=platform, home=home, frame=None)


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e3])
def test_robots_of_any_size_and_name_come_back(tmp_path, factor):
    """W to the same share whether a robot is of millimetres or kilometres; what is not turned comes back to the bit."""
    robot = scaled(cdpr.load_robot(ROBOTS / "off_centre.yaml"), factor)
    back = robot_of(tmp_path, export(begin(robot), "mjcf"))
    size = min(1.0, float(np.abs(robot.anchors).max()))
    for state in random_states(100):
        state[:3] *= size
        apart = (wrench_matrix(back, state) - wrench_matrix(robot, state)) / np.repeat([1.0, size], 3)[:, None]
        assert np.abs(apart).max() <= SAME
    assert (back.name, back.platform.mass) == (robot.name, robot.platform.mass)
    for ours, theirs in zip(robot.cables, back.cables, strict=True):
        for what in ("name", "tension_min", "tension_max", "diameter", "length_min", "length_max"):
            assert getattr(ours, what) == getattr(theirs, what), what
