"""Random robots of any size, mass and name, exported to MuJoCo and imported: positions and masses."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

import cdpr
from cdpr.formats import import_file
from cdpr.formats.write.export_model import begin, export
from cdpr.mechanics.kinematics import lengths, make_state, wrench_matrix
from cdpr.model import rotations

SAME = 1e-12  # of the robot's size, its inertia, and entries of wrench matrices: what a dozen roundings make
NAMES = [f"{first}{rest}" for first in "a_1äЖ索" for rest in ("", "-2", ".b", "_platform", "_frame", "x" * 60)]
GUIDES = [["x"], ["x", "z", "ry"], ["y", "z", "rx"], ["x", "y", "z"], ["x", "y", "z", "rz"], ["rx", "ry", "rz"]]


def unit(rng):
    q = rng.normal(size=4)
    return (q / np.linalg.norm(q)).tolist()


@st.composite
def robots(draw):
    """A robot file: numbers of no short decimals, of sizes from a millimetre to a kilometre."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    size, mass = 10.0 ** draw(st.floats(-3, 3)), 10.0 ** draw(st.floats(-3, 5))
    dof = draw(st.sampled_from([None, None, None, *GUIDES]))
    names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=12, unique=True))
    points = 0.1 * size * rng.normal(size=(10, 3))
    points -= points.mean(axis=0)
    inertia = mass / 10.0 * (np.sum(points**2) * np.eye(3) - points.T @ points)
    home = {"position": (0.3 * size * rng.normal(size=3)).tolist()}
    robot = {
        "name": names[0],
        "platform": {
            "mass": mass,
            "inertia": [float(inertia[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
            "center_of_mass": (draw(st.sampled_from([0.0, 0.1])) * size * rng.normal(size=3)).tolist(),
            "tools": {"tip": (0.1 * size * rng.normal(size=3)).tolist()},
        },
        "tension": {"min": float(rng.uniform(0.0, 10.0)), "max": float(rng.uniform(20.0, 1000.0))},
        "home": home,
        "cables": [
            {
                "name": name,
                "frame": (size * rng.normal(size=3)).tolist(),
                "platform": (0.2 * size * rng.normal(size=3)).tolist(),
            }
            for name in names
        ],
    }
    if dof is None or dof == GUIDES[-1]:
        home["orientation"] = {"quaternion": unit(rng)}
    if dof is None:
        robot["frame"] = {"position": (size * rng.normal(size=3)).tolist(), "orientation": {"quaternion": unit(rng)}}
    else:
        robot["dof"] = dof
    return robot, size, rng


@pytest.mark.slow
@given(robots())
def test_round_trip_of_any_robot_through_mujoco(tmp_path_factory, drawn):
    mujoco = pytest.importorskip("mujoco")
    given_, size, rng = drawn
    robot = cdpr.load_robot("robot.yaml", text=yaml.safe_dump(given_, allow_unicode=True))
    subject = begin(robot)
    text = export(subject, "mjcf")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    far = SAME * max(size, float(np.abs(robot.anchors).max()), float(np.abs(subject.state[:3]).max()))
    R, p, body = rotations.matrix(subject.state[3:7]), subject.state[:3], model.body("platform").id
    assert np.allclose(data.site("platform").xpos, p, rtol=0.0, atol=far)
    assert np.allclose(data.site("platform").xmat.reshape(3, 3), R, rtol=0.0, atol=SAME)
    assert np.allclose(data.xipos[body], p + R @ robot.platform.center_of_mass, rtol=0.0, atol=far)
    assert np.allclose(data.ten_length, lengths(robot, subject.state), rtol=0.0, atol=far)
    axes = data.ximat[body].reshape(3, 3)
    inertia = R @ robot.platform.inertia @ R.T
    assert np.allclose(axes * model.body_inertia[body] @ axes.T, inertia, rtol=0.0, atol=SAME * np.trace(inertia))
    assert (model.body_mass[body], model.nv) == (robot.platform.mass, robot.n)
    file = tmp_path_factory.mktemp("mjcf") / "robot.xml"
    file.write_text(text, encoding="utf-8")
    back = cdpr.load_robot("back.yaml", text=next(iter(import_file(file).files.values())))
    assert [cable.name for cable in back.cables] == [cable.name for cable in robot.cables]
    tip = robot.platform.tools["tip"]
    assert np.allclose(data.site("tip").xpos, p + R @ tip, rtol=0.0, atol=far)
    assert np.allclose(back.platform.tools["tip"], tip, rtol=0.0, atol=far)
    unit_of_length = np.repeat([1.0, max(size, float(np.abs(robot.anchors[:, 3:]).max()))], 3)[:, None]
    for _ in range(5):
        state = make_state(p + 0.3 * size * rng.normal(size=3), np.array(unit(rng)))
        if lengths(robot, state).min() > 0.01 * size:
            apart = (wrench_matrix(back, state) - wrench_matrix(robot, state)) / unit_of_length
            assert np.abs(apart).max() <= 100.0 * SAME
