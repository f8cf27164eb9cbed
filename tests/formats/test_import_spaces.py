"""Trajectories of CASPR in operational space: a point of the platform follows y while the platform rotates."""

from __future__ import annotations

import numpy as np
import pytest
from caspr_cases import HEAD, JOINTS, bodies, model, numbers

import cdpr
from cdpr.formats import import_file
from cdpr.formats.read.import_files import write
from cdpr.model import rotations

OFFSET = (0.1, -0.2, -0.4)
PARENT = (0.1, 0.2, 0.3)
TABLE = 1e-7  # m and rad, of what a table at a hundredth of a second misses between its rows
LINEAR, QUINTIC = "linear_spline_trajectory", "quintic_spline_trajectory"


def space(kind="position", axes="xyz", offset=OFFSET, name="tip", link=1):
    said = "" if kind == "orientation_euler_xyz" else f"<offset>{numbers(offset)}</offset>"
    return f'<{kind} marker_id="1" name="{name}"><link>{link}</link>{said}<axes active_axes="{axes}"/></{kind}>'


def spaces(*sets, default="a"):
    """Sets that are called a, b ..."""
    each = zip("abc", sets, strict=False)
    text = "".join(f'<operational_set id="{name}">\n{inner}</operational_set>' for name, inner in each)
    return f'<operational_spaces default_operational_set="{default}">{text}</operational_spaces>'


def trajectory(y, rates=None, kind=QUINTIC):
    points = ""
    for k, at in enumerate(y):
        rate = np.zeros(len(at)) if rates is None else rates[k]
        more = f"<y_dot>{numbers(rate)}</y_dot><y_ddot>{numbers(np.zeros(len(at)))}</y_ddot>"
        time = ' time="2"' if k else ""
        points += f"<point{time}><y>{numbers(at)}</y>{more if kind == QUINTIC else ''}</point>"
    head = f'<{kind} id="one" time_definition="relative" time_step="0.01">'
    inner = f"{head}<points>{points}</points></{kind}>"
    return HEAD.format(root="trajectories") + (
        f"<trajectories><operational_trajectories>{inner}</operational_trajectories></trajectories>"
    )


def taken_of(folder, joint, spaces_, text, q=None):
    return import_file(model(folder, bodies_=bodies(joint, q, parent=PARENT), trajectories=text, spaces=spaces_))


def imported(folder, joint, spaces_, text, q=None):
    taken = taken_of(folder, joint, spaces_, text, q)
    written = write(taken, folder / "out", force=True)
    assert len(written) >= 2, taken.left_out
    return cdpr.load_scenario(next(name for name in written if name.name == "robot_one.yaml")), taken


def smooth(s):
    return 10 * s**3 - 15 * s**4 + 6 * s**5


def point(scenario, time, offset=OFFSET):
    """Return the position of the point, and the platform's R."""
    found = scenario.desired.sample(time)
    R = rotations.matrix(found[3:7])
    return found[:3] + R @ np.array(offset), R


def turned(*angles):
    """R about x, y, z, each alone."""
    return [rotations.matrix(rotations.from_axis_angle(np.eye(3)[k], angles[k])) for k in range(3)]


@pytest.mark.parametrize(
    ("joint", "q", "said"),
    [
        ("SPATIAL_EULER_XYZ", [0.0, 0.0, 1.0, 0.3, -0.2, 0.5], True),
        ("SPATIAL_EULER_XYZ", [0.0] * 6, True),
        ("T_XYZ", [0.0] * 3, False),
    ],
)
@pytest.mark.parametrize("kind", [LINEAR, QUINTIC])
def test_a_position_is_where_a_tool_goes(tmp_path, joint, q, said, kind):
    """Measured from the joint, not from the centre of mass; the platform keeps its first attitude, with a message."""
    y = np.array([[0.0, 0.1, 1.0], [0.5, 0.4, 1.3], [0.5, 0.2, 1.1]])
    scenario, taken = imported(tmp_path, joint, spaces(space()), trajectory(y, kind=kind), q)
    assert scenario.trajectory.tool == "tip"
    x, yy, z = turned(*([0.0] * 3 if joint == "T_XYZ" else q[3:]))
    for time, share, a, b in ((0.0, 0.0, 0, 1), (0.77, 0.385, 0, 1), (2.0, 1.0, 0, 1), (3.2, 0.6, 1, 2)):
        at, R = point(scenario, time)
        wanted = y[a] + (y[b] - y[a]) * (share if kind == LINEAR else smooth(share))
        assert np.allclose(at, wanted, atol=1e-9)
        assert np.allclose(R, x @ yy @ z, atol=1e-9)
    assert np.allclose(np.array(scenario.initial.position) + x @ yy @ z @ OFFSET, y[0], atol=1e-12)
    told = [each for each in taken.warnings if "the attitude of the platform is not defined" in each]
    assert told == (
        [
            "robot_operational_spaces.xml:2: position 'tip': the attitude of the platform is not defined; the "
            "attitude of q_initial is used"
        ]
        if said
        else []
    )


def test_a_pose_in_a_plane(tmp_path):
    """x, z and the angle about y; from speeds that are not 0."""
    y = np.array([[0.0, 1.0, 0.2], [0.5, 1.3, -0.4]])
    rates = [[0.1, -0.2, 0.3], [0.0, 0.0, 0.0]]
    offset = (0.1, 0.0, -0.4)
    chosen = spaces(space("pose_euler_xyz", "xzb", offset))
    scenario, _ = imported(tmp_path, "PLANAR_XZ", chosen, trajectory(y, rates), [0.0, 1.0, 0.0])
    assert scenario.trajectory.kind() == "waypoints"
    for time, row in ((0.0, y[0]), (2.0, y[1])):
        at, R = point(scenario, time, offset)
        assert np.allclose(at, [row[0], PARENT[1], row[1]], atol=1e-9)
        assert np.allclose(R, turned(0.0, row[2], 0.0)[1], atol=1e-9)
    first, step = scenario.initial, 1e-6
    begins = (point(scenario, step, offset)[0] - point(scenario, 0.0, offset)[0]) / step
    assert np.allclose(begins, [0.1, 0.0, -0.2], atol=1e-5)
    assert np.allclose(first.angular_velocity, [0.0, 0.3, 0.0], atol=1e-12)
    assert np.allclose(first.velocity, scenario.desired.sample(0.0)[7:10], atol=1e-9)


@pytest.mark.parametrize(
    ("joint", "kind", "axes"),
    [("SPATIAL_EULER_XYZ", "pose_euler_xyz", "xyzabg"), ("S_EULER_XYZ", "orientation_euler_xyz", "abg")],
)
def test_each_angle_has_a_curve_of_its_own(tmp_path, joint, kind, axes):
    """About fixed axes in a pose, about moving ones in an orientation."""
    y = np.array([[0.2, 0.1, 1.0, 0.9, -0.4, 0.3], [0.3, 0.2, 1.2, -0.7, 0.8, 1.2]])[:, -len(axes) :]
    scenario, _ = imported(tmp_path, joint, spaces(space(kind, axes)), trajectory(y))
    for time in (0.0, 0.5, 1.234, 2.0):
        now = y[0] + (y[1] - y[0]) * smooth(time / 2.0)
        x, yy, z = turned(*now[-3:])
        at, R = point(scenario, time)
        assert np.allclose(R, z @ yy @ x if kind == "pose_euler_xyz" else x @ yy @ z, atol=TABLE)
        assert np.allclose(at, now[:3] if len(axes) == 6 else PARENT + R @ OFFSET, atol=TABLE)


def test_letters_name_the_coordinates(tmp_path):
    y = np.array([[1.0, 0.0, 0.2], [1.3, 0.5, 0.2]])
    scenario, _ = imported(tmp_path, "T_XYZ", spaces(space(axes="zxy")), trajectory(y))
    assert np.allclose(point(scenario, 2.0)[0], [0.5, 0.2, 1.3], atol=1e-9)


def test_coordinates_are_of_the_set_that_is_the_default_one(tmp_path):
    """Named at the root, or within, as one file has it, or the only one."""
    y = np.array([[0.0, 0.1, 1.0], [0.5, 0.4, 1.3]])
    far = space(offset=(0.0, 0.0, 0.7), name="far")
    nested = f'<operational_spaces default_operational_set="">{spaces(space())}</operational_spaces>'
    for k, (text, name) in enumerate(
        (
            (spaces(space(), far), "tip"),
            (spaces(space(), far, default="b"), "far"),
            (spaces(far, default=""), "far"),
            (nested, "tip"),
        )
    ):
        (tmp_path / str(k)).mkdir()
        scenario, _ = imported(tmp_path / str(k), "T_XYZ", text, trajectory(y))
        assert scenario.trajectory.tool == name


@pytest.mark.parametrize(
    ("joint", "chosen", "said"),
    [
        ("T_XYZ", None, "its coordinates are not defined: the model has no operational set"),
        ("T_XYZ", spaces(space(), space(), default=""), "its coordinates are not defined: of a, b none is the default"),
        ("T_XYZ", spaces(space(), default="z"), "its coordinates are of operational set 'z', which does not exist"),
        (
            "T_XYZ",
            spaces(space() + space()),
            "spaces.xml:1: the operational set contains 2 spaces",
        ),
        ("T_XYZ", spaces(space("velocity")), "<velocity> is unknown; allowed: position, pose_euler_xyz"),
        ("T_XYZ", spaces(space(axes="xyx")), "active_axes: expected letters of xyz, once each, got 'xyx'"),
        ("T_XYZ", spaces(space(axes="xya")), "active_axes: expected letters of xyz, once each, got 'xya'"),
        ("T_XYZ", spaces(space(axes="xy")), "it does not define the position along z, along which the joint moves"),
        (
            "SPATIAL_EULER_XYZ",
            spaces(space("orientation_euler_xyz", "abg")),
            "position along x and y and z, along which the joint",
        ),
        ("SPATIAL_EULER_XYZ", spaces(space("pose_euler_xyz", "xyzg")), "angles, not rx and ry, about which"),
        (
            "S_EULER_XYZ",
            spaces(space()),
            "it defines a position but no attitude",
        ),
        ("T_XYZ", spaces(space()), "<y>: expected 3 numbers"),
    ],
)
def test_foreign_motions_are_reported(tmp_path, joint, chosen, said):
    y = np.zeros((2, 4 if "numbers" in said else 3))
    taken = taken_of(tmp_path, joint, chosen, trajectory(y), [0.0] * len(JOINTS[joint]))
    assert list(taken.files) == ["robot.yaml"]
    (text,) = (each for each in taken.left_out if "trajectory 'one'" in each)
    assert said in text


@pytest.mark.parametrize("link", ["7", "0", "one", ""])
@pytest.mark.parametrize(("kind", "axes"), [("position", "xyz"), ("orientation_euler_xyz", "abg")])
def test_loads_on_other_links_do_not_move_the_platform(tmp_path, kind, axes, link):
    other = spaces(space(kind, axes, link=link))
    taken = taken_of(
        tmp_path,
        "SPATIAL_EULER_XYZ" if kind == "position" else "S_EULER_XYZ",
        other,
        trajectory([[0, 0, 0.0], [0, 0, 0.1]]),
    )
    assert list(taken.files) == ["robot.yaml"]
    (text,) = [text for text in taken.left_out if "(trajectory 'one')" in text]
    assert f"it is of link {link or '?'}, and the platform is link 1" in text
