"""Robots of CDPyR and lists of anchors: numbers of the original, errors with their line."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import yaml
from conftest import ROOT
from plain_robot_cases import FRAME, PLATFORM, anchor_list, as_xml, cdpyr_robot

import cdpr
from cdpr.base.errors import CdprError, FormatError
from cdpr.formats import import_file
from cdpr.formats.read import anchor_lists, cdpyr
from cdpr.formats.read.import_files import write
from cdpr.formats.read.import_options import Choice


def imported(tmp_path, text, name, **options):
    """Return the robot and the messages of an import."""
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    found = import_file(path, **options)
    return cdpr.load_robot(write(found, tmp_path / "out", force=True)[0]), "\n".join(found.warnings + found.left_out)


WRITERS = {
    "robot.json": lambda robot: json.dumps(robot, indent=2),
    "one_line.json": json.dumps,
    "robot.yaml": yaml.safe_dump,
    "robot.xml": as_xml,
}


@pytest.mark.parametrize("name", WRITERS)
def test_the_numbers_of_cdpyr(tmp_path, name):
    robot, said = imported(tmp_path, WRITERS[name](cdpyr_robot()), name)
    assert robot.name == "Sample_3R3T_robot"
    assert robot.dof == ("x", "y", "z", "rx", "ry", "rz")
    np.testing.assert_array_equal([cable.frame for cable in robot.cables], FRAME)
    np.testing.assert_array_equal(
        [cable.platform for cable in robot.cables], PLATFORM[::-1]
    )  # in the order of the chains
    assert robot.platform.mass == 5.0
    np.testing.assert_array_equal(robot.platform.inertia, [[0.3, 0.01, 0], [0.01, 0.4, 0], [0, 0, 0.5]])
    assert robot.platform.center_of_mass.tolist() == [0, 0, 0.02]
    np.testing.assert_allclose(robot.home, [0.1, 0.2, 0.3, math.sqrt(0.5), 0, 0, math.sqrt(0.5)], atol=1e-15)
    assert robot.tension_max.tolist() == [1000, 2000, 1000, 2000]
    area = math.pi * 0.003**2
    np.testing.assert_allclose([cable.axial_stiffness for cable in robot.cables], [2e9 * area] * 4, rtol=1e-12)
    assert robot.cables[1].exit.radius == 0.1
    np.testing.assert_allclose(robot.cables[1].exit.axis, [0, -1, 0], atol=1e-15)
    assert robot.cables[0].exit is None
    assert "the largest tension is the breaking load" in said
    assert "material" in said


def test_missing_limits_of_cdpyr_are_given_to_the_import(tmp_path):
    robot = cdpyr_robot()
    for cable in robot["cables"]:
        cable["breaking_load"] = math.inf
    text = json.dumps(robot, indent=2)
    assert "Infinity" in text
    with pytest.raises(FormatError, match=r"robot\.json:\d+: kinematic_chains\[0\]: its cable has no breaking_load"):
        imported(tmp_path, text, "robot.json")
    found, _ = imported(tmp_path, text, "robot.json", tension=(5, 300))
    assert (found.tension_min.tolist(), found.tension_max.tolist()) == ([5] * 4, [300] * 4)


def changed(keys, value):
    robot = cdpyr_robot()
    inner = robot
    for key in keys[:-1]:
        inner = inner[key]
    inner[keys[-1]] = value
    return json.dumps(robot, indent=1)


@pytest.mark.parametrize(
    ("keys", "value", "said"),
    [
        (("kinematic_chains", 0, "cable"), 7, r"json:\d+: kinematic_chains\[0\]\.cable: expected an index from 0 to 1"),
        (("kinematic_chains", 0, "platform"), 1, r"chains\[0\]\.platform: expected an index from 0 to 0, got 1"),
        (("kinematic_chains", 0, "frame_anchor"), None, r"frame_anchor: expected an index from 0 to 3, got None"),
        (("platforms",), [1, 2], r"platforms: expected one platform, got 2"),
        (("platforms", 0, "inertia"), None, r"inertia: expected the mass of the platform"),
        (("platforms", 0, "motion_pattern"), {"translation": 3, "rotation": 2}, r"expected one of 1T, .*, got 2R3T"),
        (("frame", "anchors", 1, "dcm"), [[1, 0, 0]] * 3, r"dcm: expected a rotation matrix"),
        (("frame", "anchors", 1, "position"), [1, 2], r"anchors\[1\]\.position: expected 3 numbers, got a list of 2"),
        (("frame", "anchors"), [], r"frame\.anchors: expected a list with one item or more"),
        (("cables", 0, "diameter"), "thick", r"diameter: expected a number"),
        (("platforms", 0, "inertia", "angular"), [[1, 0, 0], [0, 1, 0], [0, 0, 9]], r"no rigid body has this inertia"),
    ],
)  # fmt: skip
def test_errors_of_cdpyr_have_their_place(tmp_path, keys, value, said):
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, changed(keys, value), "robot.json")


def test_gravity_of_cdpyr_is_reported(tmp_path):
    _, said = imported(tmp_path, changed(("gravity",), [0, -9.81, 0]), "robot.json")
    assert "gravity [0, -9.81, 0]: set world.gravity in scenarios" in said


@pytest.mark.parametrize(
    ("pattern", "dof"), [("3T", "xyz"), ((3, 0), "xyz"), ((2, 0), "xy"), ("1R2T", ("x", "y", "rz"))]
)
def test_directions_of_cdpyr(tmp_path, pattern, dof):
    given = pattern if isinstance(pattern, str) else dict(zip(("translation", "rotation"), pattern, strict=True))
    robot = cdpyr_robot()
    robot["platforms"][0] |= {"motion_pattern": given, "pose": None}
    robot, _ = imported(tmp_path, json.dumps(robot), "robot.json")
    assert robot.dof == tuple(dof)


@pytest.mark.parametrize(
    ("keys", "value", "said"),
    [
        (("inertia", "linear"), [[3, 0, 0], [0, 5, 0], [0, 0, 3]], r"inertia\.linear: expected a diagonal matrix with"),
        (("inertia", "linear"), [[3, 9, 0], [0, 3, 0], [0, 0, 3]], r"inertia\.linear: expected a diagonal matrix with"),
        (("inertia", "linear"), [[3, 0, 0], [0, 3, 0], [0, 0]], r"inertia\.linear: expected a diagonal matrix with"),
        (("inertia", "linear"), 0, r"inertia\.linear: expected a mass of more than 0 kg, got 0"),
        (("inertia", "linear"), [3, 4, 5], r"json:\d+: platforms\[0\]\.inertia\.linear: .* equal masses, kg"),
        (
            ("motion_pattern",),
            {"translation": 3.7, "rotation": 3},
            r"motion_pattern: expected whole numbers .* 3\.7 and 3",
        ),
        (("frame",), {}, r"frame\.anchors\[0\]\.position: expected 3 numbers, got"),
        (("frame",), {"position": None}, r"frame\.anchors\[0\]\.position: expected 3 numbers, got"),
        (("radius",), -0.1, r"anchors\[1\]\.pulley\.radius: expected at least 0, got -0\.1"),
        (("elasticity",), -2e9, r"cables\[0\]\.modulus\.elasticities\[0\]: expected at least 0, got -2e\+09"),
    ],
)
def test_wrong_values_of_platform_and_cables_are_an_error(tmp_path, keys, value, said):
    where = {
        "frame": ("frame", "anchors", 0),
        "radius": ("frame", "anchors", 1, "pulley", "radius"),
        "elasticity": ("cables", 0, "modulus", "elasticities", 0),
    }
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, changed(where.get(keys[0], ("platforms", 0, *keys)), value), "robot.json")


@pytest.mark.parametrize("linear", [3, [3, 3, 3], [[3, 0, 0], [0, 3, 0], [0, 0, 3]]])
def test_equal_masses_are_one_mass(tmp_path, linear):
    robot, _ = imported(tmp_path, changed(("platforms", 0, "inertia", "linear"), linear), "robot.json")
    assert robot.platform.mass == 3.0


def test_a_missing_end_of_a_cable_is_listed_as_assumed(tmp_path):
    robot, said = imported(tmp_path, changed(("platforms", 0, "anchors", 1), {}), "robot.json")
    assert robot.cables[2].platform.tolist() == [0.0, 0.0, 0.0]
    assert said.count("platforms[0].anchors[1].position, the platform's origin") == 1


def test_the_numbers_of_a_list_of_anchors(tmp_path):
    robot, said = imported(tmp_path, anchor_list(), "robot.json")
    assert robot.name == "tabletop-light-4cable"
    assert robot.dof == ("x", "y", "z")
    assert robot.cables[1].frame.tolist() == [-0.3, 0.3, 0.4]
    assert robot.platform.mass == 0.2
    assert (robot.tension_min[0], robot.tension_max[0], robot.cables[0].diameter) == (0.5, 50, 0.001)
    assert robot.home[:3].tolist() == [0, 0, 0.1]  # it hangs: half its extent below
    assert not said


def test_defaults_of_a_list_of_anchors(tmp_path):
    ends = [[0.1, 0.1, 0], [-0.1, 0.1, 0], [-0.1, -0.1, 0], [0.1, -0.1, 0]]
    text = anchor_list(mass=None, inertia=None, com=None, t_min=None, t_max=None, dof=None, attachments=ends)
    with pytest.raises(FormatError, match=r"expected t_min, N: add it, or give both limits to the import"):
        imported(tmp_path, text, "robot.json")
    robot, said = imported(tmp_path, text, "robot.json", tension=(1, 9))
    assert len(robot.dof) == 6
    assert robot.platform.mass == 1.0
    np.testing.assert_allclose(np.diag(robot.platform.inertia), [0.4 * 0.02] * 3, rtol=1e-12)  # a ball of rms |B|
    assert "the mass, 1 kg" in said
    assert "ixx, iyy, izz was 0" in said


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"attachments": [[0, 0, 0]] * 3}, r"robot\.json:\d+: attachments: expected 4 points, one per anchor, got 3"),
        ({"n_cables": 5}, r"robot\.json:3: n_cables: expected 4, the number of anchors, got 5"),
        ({"dof": 4}, r"robot\.json:4: dof: expected 3 \(x, y, z\), 6, or names"),
        ({"dof": ["x", "q"]}, r"the robot is invalid: dof"),
        ({"mass": "heavy"}, r"mass: expected a number"),
        ({"mass": -1}, r"robot\.json:\d+: mass: expected more than 0 kg, got -1"),
        ({"dof": 6, "inertia": None, "mass": 0}, r"robot\.json:\d+: mass: expected more than 0 kg, got 0"),
        ({"t_max": [1, 2]}, r"t_max: expected 4 numbers, got a list of 2"),
        ({"dof": 6, "inertia": [[1, 2, 0], [0, 1, 0], [0, 0, 1]]}, r"inertia: expected a symmetric matrix"),
        ({"anchors": [[0, 0, 1e30]] * 4}, r"anchors\[0\]\[2\]: expected a number of at most"),
    ],
)
def test_errors_of_a_list_of_anchors_have_their_place(tmp_path, change, said):
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, anchor_list(**change), "robot.json")


TABLE = "# anchors\nname,ax,ay,az,bx,by,bz\nleft,-1,0,2,-0.1,0,0\nright,1,0,2,0.1,0,0\nback,0,1e0,2.,0,.1,0\n"


@pytest.mark.parametrize("separator", [",", ";", "\t", "  "])
def test_a_table_of_anchors(tmp_path, separator):
    robot, said = imported(tmp_path, TABLE.replace(",", separator), "robot.csv", tension=(1, 100))
    assert [cable.name for cable in robot.cables] == ["left", "right", "back"]
    np.testing.assert_array_equal([cable.frame for cable in robot.cables], [[-1, 0, 2], [1, 0, 2], [0, 1, 2]])
    np.testing.assert_array_equal([cable.platform for cable in robot.cables], [[-0.1, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])
    assert len(robot.dof) == 6
    assert "the mass, 1 kg" in said


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("1,-1,0,2\n2,1,0,2\n3,0,1,2\n", ["1", "2", "3"]),
        ("7 -1 0 2\n11 1 0 2\n13 0 1 2\n", ["7", "11", "13"]),
        ('"left, top";-1,0;0;2\n"right # 2";"1,0";0,0;2 # behind\n\'back\';0;1;2,0\n', ["left_top", "right_2", "back"]),
        ('"left top" -1 0 2\n"right"  1 0 2\nback 0\t1 2\n'.replace("\t", "  "), ["left_top", "right", "back"]),
        ('"name","ax","ay","az"\n"1","-1","0","2"\n"2","1","0","2"\n"3","0","1","2"\n', ["1", "2", "3"]),
    ],
)
def test_numbered_and_quoted_names_and_decimal_commas(tmp_path, text, names):
    robot, _ = imported(tmp_path, text, "robot.csv", tension=(1, 100))
    assert [cable.name for cable in robot.cables] == names
    np.testing.assert_array_equal([cable.frame for cable in robot.cables], [[-1, 0, 2], [1, 0, 2], [0, 1, 2]])


def test_a_table_of_anchors_alone_is_a_point(tmp_path):
    robot, _ = imported(tmp_path, "-1 0 2\n1 0 2\n0 1 2\n", "robot.csv", tension=(1, 100))
    assert robot.dof == ("x", "y", "z")
    assert [cable.name for cable in robot.cables] == ["cable_1", "cable_2", "cable_3"]


@pytest.mark.parametrize("headings", ["name,bx,by,bz,ax,ay,az", "ax,az,ay,cable,b_z,b_x,b_y", "BX,Z,X,Y,BZ,BY"])
def test_headings_set_the_order_of_columns(tmp_path, headings):
    keys = [heading.lower().replace("_", "") for heading in headings.split(",")]
    keys = ["name" if key == "cable" else f"a{key}" if len(key) == 1 else key for key in keys]
    lines = TABLE.splitlines()[2:]
    cells = [dict(zip(("name", "ax", "ay", "az", "bx", "by", "bz"), line.split(","), strict=True)) for line in lines]
    text = "\n".join([headings, *(",".join(row[key] for key in keys) for row in cells)])
    robot, _ = imported(tmp_path, text, "robot.csv", tension=(1, 100))
    names = ["left", "right", "back"] if "name" in keys else ["cable_1", "cable_2", "cable_3"]
    assert [cable.name for cable in robot.cables] == names
    np.testing.assert_array_equal([cable.frame for cable in robot.cables], [[-1, 0, 2], [1, 0, 2], [0, 1, 2]])
    np.testing.assert_array_equal([cable.platform for cable in robot.cables], [[-0.1, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])


@pytest.mark.parametrize(
    ("headings", "row"),
    [
        ("name,ax,ay,az,bx,by,width", "left,1,2,3,4,5,6"),
        ("name,ax,ay,az,bx,by", "left,1,2,3,4,5"),
        ("ax,ay,az,ax,by,bz", "1,2,3,4,5,6"),
        ("bx,by,bz", "1,2,3"),
    ],
)
def test_unknown_and_incomplete_headings_are_an_error(tmp_path, headings, row):
    said = rf"robot\.csv:1: expected the headings ax, ay, az, bx, by, bz \(or only ax, ay, az\).*, got '{headings}'"
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, f"{headings}\n{row}\n", "robot.csv", tension=(1, 100))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TABLE, r"robot\.csv: a list of anchors has no limits of tensions: give them \(--tension MIN,MAX\)"),
        (TABLE + "more,1,2\n", r"robot\.csv:6: expected 6 numbers, m, one cell per heading, got 'more,1,2'"),
        (TABLE + '"more,1,2,3,4,5,6\n', r"robot\.csv:6: expected 6 numbers"),
        ("0.5,1,2,3\n1.5,2,2,3\n", "unknown format"),  # samples of a motion
        (TABLE + "more,1,2,3,4,5,x\n", r"robot\.csv:6: expected 6 numbers"),
        (TABLE + "more,1,2,3,4,5,1e99\n", r"the robot is invalid"),
        ("1,2,3\n" * 300, r"robot\.csv:257: expected at most 256 cables"),
        ("1,2,3\n" * 250_000, r"robot\.csv: expected at most 200000 lines"),
        ("t,x,y\n1,2,3\n", "unknown format"),
        ("1,2\n1,2\n", "unknown format"),
        ("\0" * 99, "unknown format"),
        (TABLE.encode("utf-16"), "unknown format"),
    ],
)
def test_errors_of_tables_have_their_line(tmp_path, text, said):
    options = {} if "tensions" in said else {"tension": (1, 100)}
    with pytest.raises(FormatError, match=said):
        imported(tmp_path, text, "robot.csv", **options)


def test_damaged_files_end_in_one_line_or_a_robot(tmp_path):
    random = np.random.default_rng(0)
    texts = [write(cdpyr_robot()) for write in WRITERS.values()] + [anchor_list(), TABLE]
    for text in texts:
        content = text.encode()
        variants = [content[:end] for end in range(0, len(content), len(content) // 12)]
        for _ in range(12):
            damaged = bytearray(content)
            for place in random.integers(0, len(content), 4):
                damaged[place] = random.integers(0, 256)
            variants.append(bytes(damaged))
        for variant in variants:
            for module in (cdpyr, anchor_lists):
                if module.recognise(variant):
                    try:
                        module.read(tmp_path / "f", variant, Choice(tension=(1.0, 2.0)))
                    except CdprError as error:
                        assert str(error)  # noqa: PT017


def test_our_own_robots_are_no_list_of_anchors():
    for path in (ROOT / "scenarios").rglob("*.yaml"):
        assert not anchor_lists.recognise(path.read_bytes()), path
        assert not cdpyr.recognise(path.read_bytes()), path
