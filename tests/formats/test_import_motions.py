"""Trajectories of CASPR: through their points, with rates that match the poses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from caspr_cases import HEAD, JOINTS, bodies, evaluated, model, numbers
from spread import sampled

import cdpr
from cdpr.base.errors import CdprError
from cdpr.formats import import_file
from cdpr.formats.read.caspr_joints import KINDS, Joint
from cdpr.formats.read.import_files import write
from cdpr.model import rotations

AVERAGE = "cubic_spline_average_velocity_trajectory"
STEP = 1e-5  # s, of central differences
CLOSE = 2e-6  # of rates so found
SPLINES = {
    "linear_spline_trajectory": (),
    "cubic_spline_trajectory": ("q_dot",),
    "quintic_spline_trajectory": ("q_dot", "q_ddot"),
    AVERAGE: ("q_dot",),
    "parabolic_blend_trajectory": (),
}


def turns(joint):
    return sum(name.startswith("r") for name in JOINTS[joint])


class Sample(NamedTuple):
    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray


def trajectory(kind, times, q, rates=None, seconds=None, definition="absolute", step=0.01, more=""):
    points = ""
    for k, (time, at) in enumerate(zip(times, q, strict=True)):
        said = f' time="{time}"' if k else ""
        parts = f"<q>{numbers(at)}</q>"
        for name, rows in (("q_dot", rates), ("q_ddot", seconds)):
            if name in SPLINES[kind]:
                parts += f"<{name}>{numbers(np.zeros(len(at)) if rows is None else rows[k])}</{name}>"
        points += f"<point{said}>{parts}</point>\n"
    head = f'<{kind} id="one" time_definition="{definition}" time_step="{step}" blend_time_default="0.3"{more}>'
    return HEAD.format(root="trajectories") + (
        f"<trajectories><joint_trajectories>{head}<points>{points}</points></{kind}></joint_trajectories></trajectories>"
    )


def imported(folder, joint, text):
    taken = import_file(model(folder, bodies_=bodies(joint), trajectories=text))
    written = write(taken, folder / "out", force=True)
    scenario = next(name for name in written if name.name == "robot_one.yaml")
    return cdpr.load_scenario(scenario), taken


def at(scenario, time):
    """Pose and rates that are desired."""
    found = scenario.desired.sample(time)
    return Sample(found[:3], found[3:7], found[7:10], found[10:13])


@pytest.mark.slow
@sampled(2, "kind", SPLINES)
@sampled(2, "joint", ["SPATIAL_EULER_XYZ", "T_XYZ", "PLANAR_XZ", "S_FIXED_XYZ"])
def test_points_are_reached_when_they_should_be(tmp_path, kind, joint):
    rng = np.random.default_rng(5)
    q = rng.uniform(-0.3, 0.3, (3, len(JOINTS[joint])))
    if kind == AVERAGE and turns(joint) == 3:  # as it takes none that turn on
        q[:, -3:] = q[0, -3:]
    times = [0.0, 2.0, 3.5]
    scenario, _ = imported(tmp_path, joint, trajectory(kind, times, q))
    assert scenario.simulation.duration == 3.5
    for time, row in zip(times, q, strict=True):
        _, _, p, R = evaluated(bodies(joint), "<a><cable_set/></a>", row)
        found = at(scenario, time)
        assert np.allclose(found.position, p, atol=1e-9)
        assert np.allclose(rotations.matrix(found.quaternion), R, atol=1e-9)


@pytest.mark.slow
@sampled(1, "kind", ["cubic_spline_trajectory", "quintic_spline_trajectory"])
@sampled(1, "joint", ["SPATIAL_EULER_XYZ", "S_FIXED_XYZ", "PLANAR_YZ"])
def test_rates_are_those_of_the_poses(tmp_path, kind, joint):
    """Between points, with rates that are not zero there; of three angles CASPR takes none."""
    rng = np.random.default_rng(6)
    n = len(JOINTS[joint])
    q, rates, seconds = (rng.uniform(-0.3, 0.3, (3, n)) for _ in range(3))
    if n != 3 or "FIXED" in joint:
        still = [k for k, name in enumerate(JOINTS[joint]) if name.startswith("r")]
        rates[:, still] = seconds[:, still] = 0.0
    text = trajectory(kind, [0.0, 2.0, 3.5], q, rates, seconds, step=0.002)
    scenario, _ = imported(tmp_path, joint, text)
    begins = at(scenario, 0.0)
    assert np.allclose(scenario.initial.velocity, begins.velocity, atol=1e-12)
    assert np.allclose(scenario.initial.angular_velocity, begins.angular_velocity, atol=1e-12)
    assert np.abs(begins.velocity).max() > 0.01 or joint == "S_FIXED_XYZ"
    for time in (0.371, 1.234, 2.5, 3.3):
        before, here, after = (at(scenario, time + d) for d in (-STEP, 0.0, STEP))
        assert np.allclose((after.position - before.position) / (2 * STEP), here.velocity, atol=CLOSE)
        turned = rotations.multiply(after.quaternion, rotations.conjugate(before.quaternion))
        assert np.allclose(rotations.rotation_vector(turned) / (2 * STEP), here.angular_velocity, atol=CLOSE)


@pytest.mark.parametrize("name", JOINTS)
def test_turning_is_the_derivative_of_the_attitude(name):
    """Angular velocity and acceleration, world axes, of coordinates that all change at once."""
    rng = np.random.default_rng(7)
    n = len(JOINTS[name])
    joint = Joint(name, KINDS[name], (0.0, 0.0, 0.0), (0.0,) * n)
    q, rate, more = rng.uniform(-1.0, 1.0, (3, n))

    def ahead(t):
        return joint.quaternion(q + t * rate + 0.5 * t**2 * more), joint.turning(q + t * rate, rate + t * more, more)

    (before, (slower, _)), (after, (faster, _)) = ahead(-STEP), ahead(STEP)
    turned = rotations.rotation_vector(rotations.multiply(after, rotations.conjugate(before))) / (2 * STEP)
    speed, change = joint.turning(q, rate, more)
    assert np.allclose(turned, speed, atol=CLOSE)
    assert np.allclose((faster - slower) / (2 * STEP), change, atol=CLOSE)


def test_cubics_of_average_velocity_pass_at_the_mean_of_both_slopes(tmp_path):
    q = np.array([[0.0], [1.0], [4.0]])
    scenario, _ = imported(tmp_path, "P_X", trajectory(AVERAGE, [0.0, 2.0, 3.0], q))
    assert at(scenario, 2.0).velocity[0] == pytest.approx(0.5 * (1.0 / 2.0 + 3.0 / 1.0))


def test_quintics_of_points_are_their_polynomials(tmp_path):
    """Of rests at both ends: q0 + (q1 - q0) (10 s^3 - 15 s^4 + 6 s^5)."""
    q = np.array([[0.0, 0.0, 1.0], [0.5, -0.2, 1.4]])
    scenario, _ = imported(tmp_path, "T_XYZ", trajectory("quintic_spline_trajectory", [0.0, 2.0], q))
    for s in (0.1, 0.4, 0.77):
        wanted = q[0] + (q[1] - q[0]) * (10 * s**3 - 15 * s**4 + 6 * s**5) + (0.1, 0.2, 0.3)
        assert np.allclose(at(scenario, 2.0 * s).position, wanted, atol=1e-12)


def test_blends_are_parabolas(tmp_path):
    q = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
    scenario, _ = imported(tmp_path, "T_XYZ", trajectory("parabolic_blend_trajectory", [0.0, 2.0], q))
    top = 1.0 / (2.0 - 0.3)
    for time, x, v in (
        (0.2, 0.5 * top / 0.3 * 0.04, top / 0.3 * 0.2),
        (1.0, 0.5, top),
        (1.9, 1 - top / 0.6 * 0.01, top / 3),
    ):
        assert at(scenario, time).position[0] - 0.1 == pytest.approx(x, abs=1e-9)
        assert at(scenario, time).velocity[0] == pytest.approx(v, abs=1e-9)


def test_relative_times_add_up(tmp_path):
    q = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    text = trajectory("quintic_spline_trajectory", [0.0, 2.0, 3.0], q, definition="relative")
    scenario, _ = imported(tmp_path, "T_XYZ", text)
    assert scenario.simulation.duration == 5.0
    assert at(scenario, 2.0).position[0] == pytest.approx(1.1)


def test_files_of_trajectories(tmp_path):
    rows = ["time_step,0.01", *(f"t,{0.01 * k},p,{0.1 * k},0.5,v,10,0,a,0,0" for k in range(20))]
    (tmp_path / "way.traj").write_text("\n".join(rows))
    named = '<file_trajectory id="one" filename="way.traj"/>'
    text = f"<trajectories><joint_trajectories>{named}</joint_trajectories></trajectories>"
    scenario, _ = imported(tmp_path, "P_XY", text)
    assert scenario.simulation.duration == pytest.approx(0.19)
    assert at(scenario, 0.05).position.tolist() == pytest.approx([0.6, 0.7, 0.3])
    (tmp_path / "way.traj").write_text("\n".join([*rows, "t,0.3,p,1,v,0,a,0"]))
    taken = import_file(tmp_path / "robot_bodies.xml")
    assert len(taken.files) == 1
    assert [
        text for text in taken.left_out if "way.traj:22: expected t,TIME,p,...,v,...,a,... with 2 numbers each" in text
    ]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('time="3.5"', 'time="1.5"'), "time: this point comes -0.5 s after the one before it"),
        (('time_step="0.01"', 'time_step="1e-9"'), "time_step: 1e-09 s makes more than 100000 points"),
        (('time_step="0.01"', 'time_step="1e-320"'), "e-321 s makes more than 100000 points"),
        (("parabolic_blend", "cubic_hermite"), "<cubic_hermite_trajectory>"),
        (('"absolute"', '"both"'), "time_definition: expected absolute or relative, got 'both'"),
        (('blend_time_default="0.3"', 'blend_time_default="2"'), "blend_time: 2 s twice is longer"),
        (('blend_time_default="0.3"', 'blend_time_default="-1"'), "blend_time: expected at least 0 s, got -1"),
        ((' time_definition="absolute"', ""), "has no attribute 'time_definition'"),
        (
            ("joint_trajectories", "operational_trajectories"),
            "<parabolic_blend_trajectory> is not supported in operational space: CASPR has only "
            "linear_spline_trajectory and quintic_spline_trajectory",
        ),
    ],
)
def test_motions_that_cannot_be_are_left_out(tmp_path, change, said):
    q = np.random.default_rng(5).uniform(-0.3, 0.3, (3, 6))
    text = trajectory("parabolic_blend_trajectory", [0.0, 2.0, 3.5], q).replace(*change)
    taken = import_file(model(tmp_path, trajectories=text))
    assert list(taken.files) == ["robot.yaml"]
    assert [each for each in taken.left_out if said in each]
    assert said in taken.files["robot.yaml"].replace("\n# ", " ")


def test_files_of_trajectories_without_times(tmp_path):
    """As older ones are: a row for each step, whose coordinates are named q, and forces behind."""
    rows = ["time_step,0.01", *(f"q,{0.1 * k},0.5,v,10,0,a,0,0,f,1,2" for k in range(20))]
    (tmp_path / "way.traj").write_text("\n".join(rows))
    named = '<file_trajectory id="one" filename="way.traj"/>'
    scenario, _ = imported(tmp_path, "P_XY", f"<trajectories>{named}</trajectories>")
    assert scenario.simulation.duration == pytest.approx(0.19)
    assert at(scenario, 0.05).position.tolist() == pytest.approx([0.6, 0.7, 0.3])
    for wrong, said in (
        (rows[1:], "way.traj:1: expected two or more points of finite numbers, at times that rise"),
        (
            [*rows, "q,1,2,v,0,0,w,0,0"],
            "way.traj:22: expected t,TIME,p,...,v,...,a,... with 2 numbers each, got 'q,",
        ),
        ([*rows, "q,1"], "way.traj:22: expected t,TIME,p,...,v,...,a,... with 2 numbers each, got 'q,1'"),
        (["time_step", *rows[1:]], "way.traj:1: expected t,TIME"),
    ):
        (tmp_path / "way.traj").write_text("\n".join(wrong))
        taken = import_file(tmp_path / "robot_bodies.xml")
        assert [text for text in taken.left_out if said in text], wrong[-1]


@pytest.mark.parametrize("joint", ["SPATIAL_EULER_XYZ", "PLANAR_XZ"])
def test_motions_of_older_files_are_those_of_newer_ones(tmp_path, joint):
    """The root equals the inner element of newer files, and <trajectory> is a quintic with times from the start."""
    q = np.random.default_rng(8).uniform(-0.3, 0.3, (3, len(JOINTS[joint])))
    text = trajectory("quintic_spline_trajectory", [0.0, 2.0, 3.5], q)
    bare = text.replace("<trajectories>", "").replace("</trajectories>", "")
    named = text.replace("quintic_spline_trajectory", "trajectory").replace("joint_trajectories>", "trajectories>")
    named = named.replace("<trajectories><trajectories>", "<trajectories>").replace("</trajectories></tr", "</tr")
    found = []
    for k, each in enumerate((text, bare, named.replace(' time_definition="absolute"', ""))):
        (tmp_path / str(k)).mkdir()
        scenario, taken = imported(tmp_path / str(k), joint, each)
        assert not [said for said in taken.left_out if "trajectory" in said]
        found.append([scenario.desired.sample(time).tolist() for time in (0.0, 0.77, 2.0, 3.1)])
    assert found[0] == found[1] == found[2]


def test_no_motion_alone(tmp_path):
    (tmp_path / "x_trajectories.xml").write_text("<trajectories/>")
    with pytest.raises(CdprError, match="a model needs a file of its bodies as well"):
        import_file(tmp_path / "x_trajectories.xml")


@pytest.mark.slow
@sampled(2, "kind", SPLINES)
@sampled(1, "joint", ["SPATIAL_EULER_XYZ", "S_EULER_XYZ"])
def test_three_angles_go_the_shortest_way(tmp_path, kind, joint):
    """R_s exp(s log(R_s^T R_e)), whose share s is that of a coordinate from 0 to 1."""
    n = len(JOINTS[joint])
    q = np.zeros((2, n))
    q[0, -3:], q[1, -3:] = (0.9, -0.4, 0.3), (-0.7, 0.8, 1.2)
    (tmp_path / "turn").mkdir()
    (tmp_path / "line").mkdir()
    turn, _ = imported(tmp_path / "turn", joint, trajectory(kind, [0.0, 2.0], q))
    line, _ = imported(tmp_path / "line", "P_X", trajectory(kind, [0.0, 2.0], [[0.0], [1.0]]))
    first, last = (evaluated(bodies(joint), "<a><cable_set/></a>", row)[3] for row in q)
    way = rotations.rotation_vector(rotations.from_matrix(first.T @ last))
    angle = np.linalg.norm(way)
    for time in (0.2, 0.77, 1.3, 1.9):
        share = at(line, time).position[0] - 0.1
        wanted = first @ rotations.matrix(rotations.from_axis_angle(way / angle, share * angle))
        assert np.allclose(rotations.matrix(at(turn, time).quaternion), wanted, atol=1e-7)


@sampled(1, "ends", [(0.0, 4.0), (-3.0, 3.0), (0.0, 7.0)])
def test_more_than_half_a_turn_is_one(tmp_path, ends):
    text = trajectory("quintic_spline_trajectory", [0.0, 2.0], [[0.0, 0.0, ends[0]], [0.0, 0.0, ends[1]]])
    scenario, _ = imported(tmp_path, "PLANAR_XY", text)
    middle = at(scenario, 1.0).quaternion
    wanted = rotations.from_axis_angle(np.array([0.0, 0.0, 1.0]), sum(ends) / 2)
    assert abs(abs(middle @ wanted) - 1.0) < 1e-9


def test_a_length_is_rounded_up_to_a_step(tmp_path):
    text = trajectory("quintic_spline_trajectory", [0.0, 1.23456], [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    scenario, taken = imported(tmp_path, "T_XYZ", text)
    assert scenario.simulation.duration == 1.235
    assert not [each for each in taken.left_out if "refuse" in each]


def test_rates_of_three_angles_are_refused(tmp_path):
    q = np.zeros((2, 6))
    text = trajectory("quintic_spline_trajectory", [0.0, 1.0], q, rates=[[0.0] * 5 + [0.1], [0.0] * 6])
    taken = import_file(model(tmp_path, trajectories=text))
    assert [each for each in taken.left_out if "three angles have rates that are not 0" in each]


def test_three_angles_that_turn_on_at_the_mean_of_both_slopes_are_refused(tmp_path):
    """CASPR reads only the values that its kind needs, and supports no rates of three angles."""
    q = np.zeros((3, 6))
    q[1:, 5] = 0.1, 0.3
    taken = import_file(model(tmp_path, trajectories=trajectory(AVERAGE, [0.0, 1.0, 2.0], q)))
    assert [each for each in taken.left_out if "three angles have rates that are not 0" in each]


@pytest.mark.parametrize("kind", ["linear_spline_trajectory", "parabolic_blend_trajectory"])
def test_unneeded_rates_are_ignored(tmp_path, kind):
    q = np.zeros((2, 6))
    q[1] = 0.1
    text = trajectory(kind, [0.0, 1.0], q).replace("</q>", "</q><q_dot>0 0 0 0 0 9</q_dot>")
    plain, _ = imported(tmp_path, "SPATIAL_EULER_XYZ", trajectory(kind, [0.0, 1.0], q))
    said, _ = imported(tmp_path, "SPATIAL_EULER_XYZ", text)
    assert said.desired.sample(0.77).tolist() == plain.desired.sample(0.77).tolist()


def test_the_same_bytes_wherever_the_files_are(tmp_path):
    found = []
    for name in ("here", "elsewhere"):
        (tmp_path / name).mkdir()
        text = trajectory("linear_spline_trajectory", [0.0, 1.0], np.array([[0.0] * 6, [0.1] * 6]))
        found.append(import_file(model(tmp_path / name, trajectories=text)).files)
    assert found[0] == found[1]
