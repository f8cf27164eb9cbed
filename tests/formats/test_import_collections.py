"""Files like those of public robot collections: each observed form, and its expected result.

The original files were tested by hand and are not included: see docs/import.md for numbers and results.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
import pytest
from caspr_cases import CABLES, bodies, cable, cables, evaluated, model, numbers
from command_line import cdpr_here
from conftest import ROOT
from plugin_cases import SUCCESSOR, THESIS, wirex
from spread import sampled

import cdpr
from cdpr.base.errors import CdprError
from cdpr.formats import import_file
from cdpr.formats.read.import_files import import_folder, write
from cdpr.mechanics import kinematics
from cdpr.mechanics.kinematics import make_state, wrench_matrix

SAME = 1e-12  # m, and of unit vectors: numbers of both are rounded alone
LINK = '<link_rigid num="2" name="Lower Arm"/>'
LINEAR = {"kind": "cable_linear_spring", "properties": "<K>700</K>"}
VSD = {
    "kind": "cable_vsd_polynomial",
    "properties": "<K_cable>4e4</K_cable><stiffness_poly_coeff>5e3 1</stiffness_poly_coeff>",
}
TORSION = {"kind": "cable_vsd_torsion_spring"}
PASSIVE = {"kind": "cable_passive_linear_spring", "properties": "<K>5</K><l0>1</l0>"}
SCREW = "<screw_base_rotating_pulley><pulley_radius>0.025</pulley_radius></screw_base_rotating_pulley>"
INTERNAL = "<!DOCTYPE cables [\n  <!ATTLIST cable_set id ID #REQUIRED>\n]>\n"


def older(text):
    """Bodies as older files have them: without type, `links` is the root."""
    return '<?xml version="1.0" encoding="utf-8"?>\n' + re.search(r"<links.*</links>", text, re.DOTALL)[0]


def sets(**rows):
    """A file of several sets, the first of which is its default, with a type of its own as some have it."""
    inner = "".join(f'<cable_set id="{name}">\n' + "\n".join(of) + "\n</cable_set>\n" for name, of in rows.items())
    return f'<?xml version="1.0"?>\n{INTERNAL}<cables default_cable_set="{next(iter(rows))}">\n{inner}</cables>\n'


def every(**how):
    return [cable(k, **how) for k in range(4)]


class Seen(NamedTuple):
    """Files of a model and the expected result: number of cables, or the message."""

    bodies: str
    cables: str
    verdict: int | str


SPHERE = bodies("S_EULER_XYZ", [0.1, 0.0, 0.0])
POINT = bodies("P_XY", [0.2, 0.3], inertia=[0] * 6)
PLANE = bodies("PLANAR_YZ", [0.0, 0.1, 0.0], inertia=(0.1, 0, 0, 0, 0, 0))
FIXED = "cables.xml:7: cable 'cable 1' is a cable_vsd_torsion_spring: a stiffness that depends on the tension, which"
SEEN = {
    "2_DoF_VSD": Seen(
        POINT,
        sets(vsd=every(**TORSION), basic_linear=every(**LINEAR), stiff=every()),
        f"{FIXED} is not supported; its cable sets basic_linear, stiff can be imported: "
        "choose cable set 'basic_linear' (--cable-set)",
    ),
    "CAROCA": Seen(bodies(), sets(original=[cable(k) for k in range(7)]), 7),
    "CoGiRo": Seen(bodies(centre=(-0.03, -0.01, 0.26)), sets(original=every(reference="com")), 4),
    "Example_2S": Seen(
        SPHERE.replace("</links>", f"{LINK}</links>"), cables(), "link 2 'Lower Arm' is a second moving"
    ),
    "Example_spherical": Seen(SPHERE, sets(basic=every(), vsd=every(**VSD)), 4),
    "IPAnema_1": Seen(bodies(), sets(original=every(), IROS_2016=[cable(k) for k in range(3)]), 4),
    "Passive_springs_planar": Seen(
        PLANE,
        sets(four=[*every(), cable(4, **PASSIVE)], one=[cable(4, **PASSIVE)]),
        "cables.xml:11: cable 'cable 5' is a cable_passive_linear_spring: a passive spring, which is not supported",
    ),
    "older": Seen(older(bodies()), cables(), 7),
    "older, two links": Seen(older(bodies(more=LINK)), cables(), "bodies.xml:9: link 2 'Lower Arm' is a second moving"),
    "screws": Seen(bodies(), sets(a=every(first=SCREW)), "cable 'cable 1' winds on a screw_base_rotating_pulley"),
    "Inf": Seen(
        older(PLANE),
        sets(a=[each.replace(">800<", ">Inf<") for each in every()]),
        "cables.xml:7: <force_max>: expected a number, of at most 1e+12, got 'Inf'",
    ),
    "names twice, and text astray": Seen(
        bodies(),
        sets(a=[each.replace("cable 2", "cable 1").replace("<properties>", "<properties>s") for each in every()]),
        4,
    ),
    "two cables of six directions": Seen(bodies(), sets(a=every()[:2]), 2),
    "without words on limits": Seen(re.sub(r' q_m\w+="[^"]*"', "", bodies()), cables(), 7),
}


@pytest.mark.parametrize("name", SEEN)
def test_verdicts(tmp_path, name):
    seen = SEEN[name]
    file = model(tmp_path, "robot", seen.bodies, seen.cables)
    if isinstance(seen.verdict, str):
        with pytest.raises(CdprError) as caught:
            import_file(file)
        assert seen.verdict in str(caught.value)
        assert re.match(rf"{tmp_path}/robot_\w+\.xml:\d+: ", str(caught.value))
        assert str(caught.value).endswith(seen.verdict) or "can be imported" not in seen.verdict
        assert "\n" not in str(caught.value)
        return
    robot = cdpr.load_robot(write(import_file(file), tmp_path / "out", force=True)[0])
    assert robot.m == seen.verdict
    assert len({each.name for each in robot.cables}) == robot.m


def test_a_set_that_is_named_can_be_imported(tmp_path):
    seen = SEEN["2_DoF_VSD"]
    taken = import_file(model(tmp_path, "robot", seen.bodies, seen.cables), cable_set="basic_linear")
    robot = cdpr.load_robot(write(taken, tmp_path / "out", force=True)[0])
    assert robot.cables[0].axial_stiffness == 700.0


def test_older_files_are_the_same_robot(tmp_path):
    q = [0.2, -0.1, 0.9, 0.3, -0.2, 0.4]
    texts = bodies("SPATIAL_EULER_XYZ", q), sets(a=[cable(k, "com") for k in range(len(CABLES))])
    lengths, W, p, _ = evaluated(*texts, q)
    taken = import_file(model(tmp_path, "robot", older(texts[0]), texts[1]))
    robot = cdpr.load_robot(write(taken, tmp_path / "out", force=True)[0])
    state = make_state(robot.home[:3], robot.home[3:])
    assert np.allclose(robot.home[:3], p, atol=SAME)
    assert np.allclose(kinematics.lengths(robot, state), lengths, atol=SAME)
    assert np.allclose(wrench_matrix(robot, state), W, atol=SAME)


def test_other_xml_with_a_root_of_links_is_none_of_caspr(tmp_path):
    (tmp_path / "page.xml").write_text("<links><link href='x'/></links>")
    with pytest.raises(CdprError, match="unknown format"):
        import_file(tmp_path / "page.xml")


def test_files_of_our_own_need_no_import():
    with pytest.raises(CdprError, match=r"unknown format.*; our own .* need no import"):
        import_file(ROOT / "scenarios" / "robots" / "caroca.yaml")


def test_points_of_operational_spaces_are_tools_wherever_they_are(tmp_path):
    """Nested, as one file has them, and beside the links, as older ones; of attitudes alone there is no point."""
    point = '<{kind} marker_id="1" name="{name}"><link>{link}</link>{offset}<axes active_axes="xyz"/></{kind}>'

    def one(name, kind="position", link=1, offset="<offset>0.1 0 -0.4</offset>"):
        return (
            f'<operational_set id="a">{point.format(kind=kind, name=name, link=link, offset=offset)}</operational_set>'
        )

    several = [
        one("tip"),
        one("tip", "pose_euler_xyz"),
        one("turn", "orientation_euler_xyz", offset=""),
        one("arm", link=2),
    ]
    spaces = f"<operational_spaces><operational_spaces>\n{''.join(several)}</operational_spaces></operational_spaces>"
    beside = bodies().replace("</bodies_system>", f"{one('old one')}</bodies_system>")
    taken = import_file(model(tmp_path, bodies_=beside, spaces=spaces))
    tools = cdpr.load_robot(write(taken, tmp_path / "out", force=False)[0]).platform.tools
    assert list(tools) == ["old_one", "tip", "tip_2"]
    assert all(place.tolist() == [0.1, 0.0, -0.4] for place in tools.values())
    (text,) = (text for text in taken.left_out if "operational space" in text)
    assert text.endswith("operational_spaces.xml:2: operational space 'arm': a point of link 2, not the platform's")


def test_a_collection_in_one_folder(tmp_path):
    """Files of the same name are all imported; unreadable ones are reported with the reason."""
    for k, name in enumerate(("2_DoF_VSD", "CAROCA", "older")):
        (tmp_path / str(k)).mkdir()
        model(tmp_path / str(k), "robot", SEEN[name].bodies, SEEN[name].cables)
    (tmp_path / "2" / "robot.wcrfx").write_text(wirex(**{"Crane 1": "robot"}))
    taken = list(import_folder(tmp_path))
    assert [list(each.files) for each in taken] == [[], ["robot.yaml"], ["robot_2.yaml"], ["robot_3.yaml"]]
    assert "choose cable set 'basic_linear'" in taken[0].error
    assert "name: robot_2\n" in taken[2].files["robot_2.yaml"]


def test_own_files_in_a_folder_are_skipped_in_one_line(tmp_path):
    """Nothing is left where nothing could be read; YAML that is in no known format keeps a line of its own."""
    out = tmp_path / "out"
    done = cdpr_here("import", ROOT / "scenarios", "--out", out, code=2)
    (line,) = done.stdout.splitlines()
    count = len(list((ROOT / "scenarios").rglob("*.yaml")))
    assert line.endswith(f"scenarios: skipped {count} YAML files of cdpr's own format: no import needed")
    assert not out.exists()
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "robot.yaml").write_bytes((ROOT / "scenarios" / "robots" / "caroca.yaml").read_bytes())
    (tmp_path / "in" / "other.yaml").write_text("greeting: hello\n")
    (tmp_path / "in" / "plug.yaml").write_text(SUCCESSOR)
    unknown, read, own = import_folder(tmp_path / "in")
    assert "unknown format" in unknown.error
    assert read.files
    assert own.own == 1


HOSTILE = {
    "robot_bodies.xml": "",
    "robot_cables.xml": "",
    "crane.wcrfx": wirex(0.05),
    "thesis.yaml": THESIS,
    "plug.yaml": SUCCESSOR,
}
NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(?![\w.])")


def plain(taken):
    """Return the imported content without comments, which contain lines, and names, which are arbitrary."""
    return [re.sub(r'#.*|name: ("[^"]*"|[\w-]+)', "", text) for text in taken.files.values()]


def refusal(file):
    """Return the one-line message about a file; "" if it is imported, and the imported content."""
    try:
        return "", plain(import_file(file))
    except CdprError as error:
        assert "\n" not in str(error)  # noqa: PT017 - most of what is tried is refused, and not all
        return str(error), []


@pytest.mark.slow
@sampled(1, "bad", ["nan", "1e400", "zzz"])
@pytest.mark.parametrize("name", HOSTILE)
def test_no_number_that_is_none_comes_through(tmp_path, name, bad):
    """Each changed number has no effect, or ends in a one-line message with its place."""
    lead = (
        model(tmp_path, "robot", bodies(centre=(0, 0, 0)), sets(a=every(reference="com")))
        if "xml" in name
        else tmp_path / name
    )
    file = tmp_path / name
    text = file.read_text() if "xml" in name else HOSTILE[name]
    file.write_text(text)
    sound, refused = plain(import_file(lead)), 0
    places = list(NUMBER.finditer(text))
    for place in places[:: max(1, len(places) // 40)]:
        new = f".{bad}" if bad == "nan" and "yaml" in name else bad
        file.write_text(text[: place.start()] + new + text[place.end() :])
        said, came = refusal(lead)
        assert came == sound or re.match(rf"{re.escape(str(file))}:\d+:", said), said or new
        refused += bool(said)
    assert refused > 10


def test_a_folder_of_which_nothing_can_be_read_is_an_error(tmp_path):
    (tmp_path / "a.xml").write_text("<html/>")
    (tmp_path / "b.xml").write_text("<html>")
    done = cdpr_here("import", tmp_path, "--out", tmp_path / "out", code=2)
    assert done.stdout.count("not read: ") == 2
    assert done.stdout.endswith("0 of 2 could be read\n")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["robot_cables.xml", "crane.wcrfx"])
def test_no_part_that_is_missing_or_twice_comes_as_a_fault_of_ours(tmp_path, name):
    lead = model(tmp_path) if "xml" in name else tmp_path / name
    file = tmp_path / name
    text = file.read_text() if "xml" in name else wirex(0.05)
    parts = list(re.finditer(r' \w+="[^"]*"|<(\w+)[^<>]*>[^<]*</\1>|<\w+[^<>]*/>', text))
    refused = 0
    for part in parts[:: max(1, len(parts) // 25)]:
        for new in ("", 2 * part[0], part[0].replace(part[0].strip(" <")[:3], "zzz", 1)):
            file.write_text(text[: part.start()] + new + text[part.end() :])
            said, _ = refusal(lead)
            assert not said or re.match(rf"{re.escape(str(tmp_path))}/[\w.]+(:\d+: |: is in no format)", said), said
            refused += bool(said)
    assert refused > 10


def test_lengths_of_numbers_are_checked(tmp_path):
    texts = bodies(), cables([cable(0).replace(numbers(CABLES[0][0]), "1 2")])
    with pytest.raises(CdprError, match=r"cables.xml:4: <location>: expected 3 numbers, of at most 1e\+12, got '1 2'"):
        import_file(model(tmp_path, "robot", *texts))
