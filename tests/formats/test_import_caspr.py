"""Models of CASPR, against an evaluation of their files that shares no code, and what our parts cannot be."""

from __future__ import annotations

import re

import numpy as np
import pytest
from caspr_cases import CABLES, CENTRE, INERTIA, JOINTS, bodies, cable, cables, evaluated, model, numbers

import cdpr
from cdpr.base.errors import CdprError
from cdpr.formats import import_file
from cdpr.formats.read.import_files import import_folder, write
from cdpr.mechanics import kinematics
from cdpr.mechanics.kinematics import make_state, wrench_matrix
from cdpr.model import rotations

SAME = 1e-12  # m, and of unit vectors: numbers of both are rounded alone


def loaded(taken, folder):
    """The robot of what was taken, from the file that is written."""
    written = write(taken, folder, force=True)
    return cdpr.load_robot(written[0]), written


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("reference", ["joint", "com"])
def test_every_joint_is_what_it_is_there(tmp_path, joint, reference):
    """The home is q_initial: lengths and wrench matrix are those of the file, however it is turned."""
    rng = np.random.default_rng(3)
    q = rng.uniform(-0.4, 0.4, len(JOINTS[joint]))
    rows = [cable(k, reference) for k in range(len(CABLES))]
    texts = bodies(joint, q), cables(rows)
    robot, _ = loaded(import_file(model(tmp_path, "robot", *texts)), tmp_path / "out")
    lengths, W, p, R = evaluated(*texts, q)
    assert robot.dof == tuple(JOINTS[joint])
    assert np.allclose(robot.home[:3], p, atol=SAME)
    assert np.allclose(rotations.matrix(robot.home[3:]), R, atol=SAME)
    state = make_state(robot.home[:3], robot.home[3:])
    assert np.allclose(kinematics.lengths(robot, state), lengths, atol=SAME)
    assert np.allclose(wrench_matrix(robot, state), W, atol=SAME)
    assert robot.platform.mass == 5.0
    assert np.allclose(robot.platform.center_of_mass, CENTRE)
    assert robot.tension_min.tolist() == [1.5] * len(CABLES)
    assert robot.tension_max.tolist() == [800.0] * len(CABLES)


@pytest.mark.parametrize("said", ["", 'q_initial=" "'])
def test_a_joint_without_first_coordinates_begins_at_zero(tmp_path, said):
    """As CASPR's joints do."""
    text = re.sub('q_initial="[^"]*"', said, bodies())
    robot = cdpr.load_robot(write(import_file(model(tmp_path, bodies_=text)), tmp_path / "out", force=False)[0])
    assert robot.home.tolist() == [0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0]


def test_inertia_about_the_joint_is_moved_to_the_centre_of_mass(tmp_path):
    c = np.array([0.3, -0.2, 0.1])
    plain, _ = loaded(import_file(model(tmp_path, bodies_=bodies(centre=c))), tmp_path / "a")
    moved = np.array(plain.platform.inertia) + 5.0 * (c @ c * np.eye(3) - np.outer(c, c))
    six = (moved[0, 0], moved[1, 1], moved[2, 2], moved[0, 1], moved[0, 2], moved[1, 2])
    other = bodies(centre=c, inertia=[float(value) for value in six], ref="joint")
    robot, _ = loaded(import_file(model(tmp_path, bodies_=other)), tmp_path / "b")
    assert np.allclose(robot.platform.inertia, plain.platform.inertia, atol=SAME)


@pytest.mark.parametrize(
    ("joint", "inertia", "filled", "said"),
    [
        ("SPATIAL_EULER_XYZ", (0, 0, 0, 0, 0, 0), "ball", "ixx, iyy, izz was 0, filled with "),
        ("SPATIAL_EULER_XYZ", (2.0, 3.0, 0, 0, 0, 0), (2.0, 3.0, 3.0), "izz was 0, filled with 3, the largest"),
        ("S_EULER_XYZ", (0, 0.4, 0, 0, 0, 0), (0.4, 0.4, 0.4), "ixx, izz was 0"),
        ("PLANAR_XZ", (0, 0.4, 0, 0, 0, 0), (0.4, 0.4, 0.4), ""),
        ("PLANAR_XZ", (0, 0, 0, 0, 0, 0), "ball", "was 0"),
        ("P_XY", (0, 0, 0, 0, 0, 0), (1.0, 1.0, 1.0), ""),
    ],
)
def test_moments_that_are_zero_are_filled_where_they_matter(tmp_path, joint, inertia, filled, said):
    taken = import_file(model(tmp_path, bodies_=bodies(joint, inertia=inertia)))
    robot, _ = loaded(taken, tmp_path / "out")
    ball = 0.4 * 5.0 * (np.array([b for _, b in CABLES]) - CENTRE)
    wanted = np.full(3, (ball * (np.array([b for _, b in CABLES]) - CENTRE)).sum(axis=1).mean())
    assert np.allclose(np.diag(robot.platform.inertia), wanted if filled == "ball" else filled)
    assert [text for text in taken.warnings if said in text] or not said
    assert bool(taken.warnings) == bool(said)


REFUSED = {
    "second body": (
        {"more": '<link_rigid num="2" name="arm"/>'},
        {},
        "bodies.xml:10: link 2 'arm' is a second moving body",
    ),
    "two turns": ({"joint": "U_XY"}, {}, "bodies.xml:6: joint U_XY rotates about two axes"),
    "quaternion": ({"joint": "SPATIAL"}, {}, "bodies.xml:6: joint SPATIAL has a quaternion among its coordinates"),
    "unknown joint": ({"joint": "HELICAL"}, {}, "bodies.xml:6: joint type 'HELICAL' is unknown"),
    "no body's inertia": ({"inertia": (1, 1, 5, 0, 0, 0)}, {}, "bodies.xml:8: no rigid body has this inertia"),
    "actuated": (
        {"joint": 'SPATIAL_EULER_XYZ" actuated="True'},
        {},
        "bodies.xml:6: the joint is actuated: only cables may move a platform",
    ),
    "ref": ({"ref": "link"}, {}, "bodies.xml:8: ref of <inertia>: expected com or joint, got 'link'"),
    "coordinates": ({"q": [1.0, 2.0]}, {}, "bodies.xml:6: q_initial of <joint>: expected 6 numbers"),
    "passive spring": (
        {},
        {"rows": [cable(0), cable(1, kind="cable_passive_linear_spring", properties="<K>5</K><l0>1</l0>")]},
        "cables.xml:5: cable 'cable 2' is a cable_passive_linear_spring: a passive spring",
    ),
    "VSD": (
        {},
        {"rows": [cable(0, kind="cable_vsd_torsion_spring")]},
        "cables.xml:4: cable 'cable 1' is a cable_vsd_torsion_spring: a stiffness that depends on the tension",
    ),
    "screw": (
        {},
        {"rows": [cable(0, first="<screw_base_rotating_pulley/>")]},
        "cables.xml:4: cable 'cable 1' winds on a screw_base_rotating_pulley",
    ),
    "placeholder": (
        {},
        {"rows": [cable(0, first="<attachment><link>0</link><location>9e9 0 0</location></attachment>")]},
        "cables.xml:4: cable 'cable 1' ends 9e+09 m away, beyond 1e+06 m",
    ),
    "three attachments": (
        {},
        {"rows": [cable(0).replace("</attachments>", "<attachment/></attachments>")]},
        "cables.xml:4: cable 'cable 1' has 3 attachments",
    ),
    "other link": (
        {},
        {"rows": [cable(0, last="<attachment><link>2</link><location>0 0 0</location></attachment>")]},
        "cables.xml:4: cable 'cable 1' ends on link 2, and there is one moving body, 1",
    ),
    "both on the platform": (
        {},
        {"rows": [cable(0, first="<attachment><link>1</link><location>0 0 0</location></attachment>")]},
        "cables.xml:4: cable 'cable 1': expected one attachment on the world, link 0, got both on one body",
    ),
    "NaN": (
        {},
        {"rows": [cable(0).replace(">1.5", ">nan")]},
        "cables.xml:4: <force_min>: expected a number, of at most 1e+12, got 'nan'",
    ),
    "limits": (
        {},
        {"rows": [cable(0), cable(1), cable(2).replace(">1.5", ">900")]},
        "cables.xml:6: the robot is invalid: tension.min[2]",
    ),
    "limits of all": (
        {},
        {"rows": [cable(0).replace(">1.5", ">-1")]},
        "cables.xml:4: the robot is invalid: tension.min",
    ),
    "mass": ({"mass": -5}, {}, "bodies.xml:7: the robot is invalid: platform.mass"),
    "no default set": ({}, {"default": "al"}, "cable set 'al', the default, does not exist; did you mean 'all'?"),
    "empty set": ({}, {"rows": []}, "cables.xml:3: cable set 'all' contains no cable"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unsupported_parts_are_rejected_with_their_line(tmp_path, case):
    body, line, said = REFUSED[case]
    with pytest.raises(CdprError) as caught:
        import_file(model(tmp_path, bodies_=bodies(**body), cables_=cables(**line)))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_pulleys_and_springs(tmp_path):
    """The pulley's length is that of CASPR: where the tangent leaves, and the arc before it (its issue 4)."""
    entry, F, r = np.array([0.0, 0.0, 1.0]), np.array(CABLES[0][0]), 0.05
    drawn = (
        f"<base_rotating_pulley><fixed_location>{numbers(F)}</fixed_location><pulley_radius>{r}</pulley_radius>"
        f"<cable_entry_vector>{numbers(entry)}</cable_entry_vector></base_rotating_pulley>"
    )
    rows = [cable(0, first=drawn), cable(1, kind="cable_linear_spring", properties="<K>12000</K>"), cable(2), cable(3)]
    texts = bodies("T_XYZ", [0.0, 0.0, 1.0], parent=(0, 0, 0)), cables(rows)
    robot, _ = loaded(import_file(model(tmp_path, "robot", *texts)), tmp_path / "out")
    assert robot.cables[1].axial_stiffness == 12000.0
    B = np.array([0.0, 0.0, 1.0]) + CABLES[0][1]
    normal = np.cross(entry, B - F)
    C = F + r * np.cross(normal, entry) / np.linalg.norm(np.cross(normal, entry))
    rho, unit = r / np.linalg.norm(B - C), normal / np.linalg.norm(normal)
    leaves = C + rho**2 * (B - C) - rho * np.sqrt(1 - rho**2) * np.cross(unit, B - C)
    arc = r * np.arccos((F - C) @ (leaves - C) / r**2)
    length = kinematics.lengths(robot, make_state(robot.home[:3], robot.home[3:]))[0]
    assert length == pytest.approx(arc + np.linalg.norm(B - leaves), abs=SAME)


def test_sets_of_cables_are_chosen(tmp_path):
    file = model(tmp_path)
    assert loaded(import_file(file, cable_set="other"), tmp_path / "out")[0].m == 2
    with pytest.raises(CdprError, match="cable set 'oter' does not exist; did you mean 'other'"):
        import_file(file, cable_set="oter")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('<!DOCTYPE a [<!ENTITY b "c">]><bodies_system>&b;</bodies_system>', "declares the entity 'b'"),
        (
            '<!DOCTYPE a [<!ATTLIST link_rigid n CDATA "xxx">]><bodies_system/>',
            "bodies.xml:1: it declares a default for the attribute 'n' of <link_rigid>: write it in the element",
        ),
        ("<bodies_system><links>", "invalid XML: no element found"),
        ('<?xml version="1.0"?>\n<bodies_system', "bodies.xml:2: invalid XML: unclosed token"),
        ("<bodies_system>" + "<a>" * 100, "or nested more than 64 deep"),
        ("<bodies_system><links/></bodies_system>", "expected a <link_rigid> within <links>, got none"),
    ],
)
def test_hostile_files_end_in_one_line(tmp_path, text, said):
    file = model(tmp_path)
    file.write_text(text)
    with pytest.raises(CdprError, match=said) as caught:
        import_file(file)
    assert str(caught.value).startswith(f"{file}:")
    assert "\n" not in str(caught.value)


def test_external_entities_are_never_read(tmp_path):
    (tmp_path / "secret").write_text("42")
    hostile = f'<!DOCTYPE bodies_system [<!ENTITY x SYSTEM "file://{tmp_path}/secret">]>'
    file = model(tmp_path, bodies_=hostile + bodies().partition('.dtd">\n')[2].replace("<mass>5", "<mass>&x;"))
    with pytest.raises(CdprError, match="declares the entity 'x'"):
        import_file(file)


def test_a_folder_reports_what_could_not_be_read(tmp_path):
    (tmp_path / "in").mkdir()
    model(tmp_path / "in", "good")
    model(tmp_path / "in", "Bad", bodies_=bodies("U_XY"))
    model(tmp_path / "in", "alone").unlink()
    (tmp_path / "in" / "other.xml").write_text("<html/>")
    taken = {each.source.rpartition("/")[2]: each for each in import_folder(tmp_path / "in")}
    assert list(taken) == ["Bad_bodies.xml", "alone_cables.xml", "good_bodies.xml", "other.xml"]
    assert "rotates about two axes" in taken["Bad_bodies.xml"].error
    assert "needs a file of its bodies as well, alone_bodies.xml" in taken["alone_cables.xml"].error
    assert list(taken["good_bodies.xml"].files) == ["good.yaml"]
    assert "unknown format" in taken["other.xml"].error


def test_the_inertia_of_the_case_is_one(tmp_path):
    robot, _ = loaded(import_file(model(tmp_path)), tmp_path / "out")
    I = robot.platform.inertia  # noqa: E741
    assert (I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]) == INERTIA
