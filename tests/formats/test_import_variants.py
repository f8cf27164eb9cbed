"""Servos, grippers, mocap anchors and included files of MJCF; random WireX files against numpy."""

from __future__ import annotations

import math
import os

import numpy as np
import plugin_cases
import pytest
from scipy.spatial.transform import Rotation

import cdpr
from cdpr.base.errors import FormatError
from cdpr.formats import import_file
from cdpr.formats.read.import_files import write

COUNT = int(os.environ.get("CDPR_WIREX", "10"))
SERVO = """<mujoco model="m"><compiler autolimits="true"/><worldbody>{more}<site name="a0" pos="1 1 2"/>
<site name="a1" pos="-1 0 2"/><body name="p" pos="0 0 1"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/>
<site name="b0" pos=".1 0 0"/><site name="b1" pos="-.1 0 0"/>{on}</body></worldbody>
<tendon><spatial name="c0"><site site="a0"/><site site="b0"/></spatial>
<spatial name="c1"><site site="a1"/><site site="b1"/></spatial></tendon>
<actuator><position tendon="c0" kp="600" forcerange="-80 0"/>
<velocity tendon="c1" kv="9" forcerange="-70 -5"/></actuator>
{end}</mujoco>"""
GRIPPER = '<body name="g"><joint name="j" type="slide"/><geom size=".1" mass="2"/></body>'
CUBE = '<body name="cube" pos="5 0 0"><freejoint/><geom size=".1" mass="7"/></body>'
WELDS = '<equality><joint joint1="j"/><weld body1="cube"/></equality><keyframe><key qpos="{qpos}"/></keyframe>'


def imported(folder, text, name="m.xml"):
    (folder / name).write_text(text)
    taken = import_file(folder / name)
    return cdpr.load_robot(write(taken, folder / "out", force=True)[0]), taken


def test_servos_of_tendons_have_the_limits_of_their_forces(tmp_path):
    pytest.importorskip("mujoco")
    robot, taken = imported(tmp_path, SERVO.format(more="", on="", end=""))
    assert robot.tension_min.tolist() == [0.0, 5.0]
    assert robot.tension_max.tolist() == [80.0, 70.0]
    assert [
        text for text in taken.warnings if "2 tendons have servos ('c0', 'c1'), imported as winches of the type" in text
    ]


def test_grippers_are_fixed_and_other_bodies_left_out(tmp_path):
    pytest.importorskip("mujoco")
    qpos = "5 0 0 1 0 0 0 .1 .2 1.3 1 0 0 0 0"  # of the cube, which comes first, the platform and the gripper
    text = SERVO.format(more=CUBE, on=GRIPPER, end=WELDS.format(qpos=qpos))
    robot, taken = imported(tmp_path, text)
    assert robot.platform.mass == 3.0
    assert robot.home[:3].tolist() == [0.1, 0.2, 1.3]
    assert [
        text for text in taken.warnings if "body 'g' moves on its own (j): fixed at its position in the model" in text
    ]
    assert [text for text in taken.left_out if "body 'cube' moves on its own" in text]
    assert [text for text in taken.left_out if "<weld> '': between bodies without cables" in text]
    held = text.replace('<weld body1="cube"/>', '<weld body1="p" body2="cube"/>')
    with pytest.raises(
        FormatError,
        match=r"m\.xml:\d+: <weld> '' \(body1 'p', body2 'cube'\): only joints and cables can hold a platform",
    ):
        imported(tmp_path, held)


def test_anchors_on_mocap_bodies_are_reported(tmp_path):
    pytest.importorskip("mujoco")
    drone = '<body name="d" mocap="true"><site name="a2" pos="1 1 2"/></body>'
    text = SERVO.format(more=drone, on="", end="").replace('site="a0"', 'site="a2"')
    _, taken = imported(tmp_path, text)
    assert [text for text in taken.warnings if "body 'd' is a mocap body" in text]


def test_included_files_are_read_in_the_folder_alone(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "g.xml").write_text(f"<mujocoinclude>{GRIPPER}</mujocoinclude>")
    text = SERVO.format(more="", on='<include file="in/g.xml"/>', end="")
    robot, taken = imported(tmp_path, text)
    assert robot.platform.mass == 3.0
    assert [text for text in taken.warnings if "in/g.xml:1: body 'g' moves on its own" in text]
    (tmp_path / "in" / "g.xml").write_text('<mujocoinclude><include file="in/g.xml"/></mujocoinclude>')
    with pytest.raises(FormatError, match="is included twice"):
        imported(tmp_path, text)
    (tmp_path / "in" / "l.xml").symlink_to("/etc/passwd")
    for other in ("../x.xml", "/etc/passwd", "in/l.xml"):
        with pytest.raises(FormatError, match="is outside the folder of the model"):
            imported(tmp_path, text.replace("in/g.xml", other))
    (tmp_path / "in" / "c.xml").symlink_to("c.xml")
    with pytest.raises(FormatError, match="Too many levels of symbolic links"):
        imported(tmp_path, text.replace("in/g.xml", "in/c.xml"))


def test_a_cable_id_that_is_no_number(tmp_path):
    text = plugin_cases.wirex().replace("<chain ", '<chain cable_id="x" ')
    text = text.replace("<cable ", '<cable id="7" name="other"/><cable id="8" ', 1)
    with pytest.raises(FormatError, match=r"cable_id 'x': no such <cable>"):
        imported(tmp_path, text, "r.wcrfx")


def test_limits_given_to_the_import_replace_missing_ones_of_wirex(tmp_path):
    """In a WireX file, inf is a number that is not given."""
    path = tmp_path / "r.wcrfx"
    text = plugin_cases.wirex(f_max="unread", **{'breaking_load="9000"': 'breaking_load="inf"'})
    path.write_text(text)
    with pytest.raises(FormatError, match=r"expected a largest tension above 0 N .*\(--tension MIN,MAX\)"):
        import_file(path)
    found = import_file(path, tension=(7.0, 600.0))
    robot = cdpr.load_robot(write(found, tmp_path / "out", force=True)[0])
    assert (robot.tension_min.tolist(), robot.tension_max.tolist()) == ([7.0] * 4, [600.0] * 4)
    assert any("of chains '1', '2', '3', '4': 600 N is the one given" in warning for warning in found.warnings)
    path.write_text(text.replace("</robot>", '<application min_cable_load="9"/></robot>'))
    robot = cdpr.load_robot(write(import_file(path, tension=(7.0, 600.0)), tmp_path / "out", force=True)[0])
    assert (robot.tension_min.tolist(), robot.tension_max.tolist()) == ([9.0] * 4, [600.0] * 4)
    with pytest.raises(FormatError, match="expected a largest tension above 9 N"):
        import_file(path, tension=(7.0, 8.0))


@pytest.mark.parametrize("seed", range(COUNT))
def test_random_files_of_wirex(tmp_path, seed):
    rng = np.random.default_rng(seed)
    m, first = int(rng.integers(3, 9)), int(rng.integers(0, 2))  # ids count from 0 or 1, chains from 1
    by_name = bool(rng.integers(2))
    A, B = rng.uniform(-3, 3, (m, 3)), rng.uniform(-0.3, 0.3, (m, 3))
    turns = Rotation.random(m, random_state=seed)
    of, data = rng.permutation(m), rng.uniform(1e-3, 5e-3, (m, 4))
    chains = []
    for k in range(m):
        q, way = turns[k].as_quat(), turns[k].as_rotvec()
        angle = float(np.linalg.norm(way))
        R = turns[k].as_matrix()
        ways = [
            dict(zip(("q0", "q1", "q2", "q3"), (q[3], *q[:3]), strict=True)),
            dict(zip(("ux", "uy", "uz", "beta"), (*(way / angle), angle), strict=True)),
            {f"a{i + 1}{j + 1}": R[i, j] for i in range(3) for j in range(3)},
        ]
        turned = " ".join(f'{key}="{float(value)!r}"' for key, value in ways[rng.integers(3)].items())
        cable = f'cable_type="n{of[k]}"' if by_name else f'cable_id="{of[k] + 1}"'
        places = [" ".join(f'{x}="{float(v)!r}"' for x, v in zip("xyz", of_, strict=True)) for of_ in (A[k], B[k])]
        chains.append(
            f'<chain id="{k}" {cable}><base {places[0]} {turned} radius="0.05"/><platform {places[1]}/></chain>'
        )
    rows = [
        f'<cable id="{k + first}" name="n{k}" radius="{float(r)!r}" elasticity="{float(e * 1e12)!r}" '
        f'weight="{float(w)!r}" breaking_load="{float(b * 1e6)!r}" max_length="inf"/>'
        for k, (r, e, w, b) in enumerate(data)
    ]
    text = (
        f'<models><robot name="r" motion_pattern="3R3T"><geometry>{"".join(chains)}</geometry><end_effector mass="5">'
        f'<inertia Ixx="1" Iyy="2" Izz="2.5"/><centre_of_gravity x="0" y="0.1" z="0"/></end_effector></robot>'
        f"{''.join(rows)}</models>"
    )
    robot, _ = imported(tmp_path, text, "r.wcrfx")
    assert np.array_equal(robot.anchors, np.hstack([A, B]))
    assert robot.platform.center_of_mass.tolist() == [0.0, 0.1, 0.0]
    assert np.diag(robot.platform.inertia).tolist() == [1.0, 2.0, 2.5]
    for k, cable in enumerate(robot.cables):
        r, e, w, b = data[of[k]]
        assert np.allclose(cable.exit.axis, turns[k].as_matrix()[:, 2], atol=1e-12)
        assert cable.diameter == pytest.approx(2 * r)
        assert cable.axial_stiffness == pytest.approx(e * 1e12 * math.pi * r**2)
        assert cable.linear_density == pytest.approx(w)
        assert cable.tension_max == pytest.approx(b * 1e6)
