"""Reports of what importers do not read: an unknown part at each place of each format is among `left_out`.

With CDPR_UNREAD=all every place is tried; a sample of them is otherwise.
"""

from __future__ import annotations

import itertools
import os
import re
import xml.etree.ElementTree as ET
from functools import cache

import pytest
import yaml
from caspr_cases import bodies, cables
from command_line import cdpr_here
from plugin_cases import SUCCESSOR, THESIS, TRAJECTORY, wirex
from sdf_cases import text as sdf_text

from cdpr.base.errors import CdprError
from cdpr.formats import import_file

ALL = os.environ.get("CDPR_UNREAD") == "all"
SAMPLE = 4  # of the places of each fixture, evenly spread, and the first and the last
MOTIONS = """<trajectories>
<joint_trajectories><quintic_spline_trajectory id="a" time_definition="relative" time_step="0.1"><points>
<point><q>0 0 1 0 0 0</q><q_dot>0 0 0 0 0 0</q_dot><q_ddot>0 0 0 0 0 0</q_ddot></point>
<point time="2"><q>0 0 2 0 0 0</q><q_dot>0 0 0 0 0 0</q_dot><q_ddot>0 0 0 0 0 0</q_ddot></point>
</points></quintic_spline_trajectory></joint_trajectories></trajectories>"""
SPACES = """<operational_spaces default_operational_set="t"><operational_set id="t">
<position name="p"><link>1</link><offset>0 0 0.1</offset><axes active_axes="xyz"/></position>
</operational_set></operational_spaces>"""
MJCF = """<mujoco model="m"><compiler autolimits="true"/><option gravity="0 0 -9.81"/>
<default><site size="0.01"/><default class="c"><tendon width="0.01"/></default></default>
<worldbody><geom type="plane" size="1 1 1"/><site name="a1" pos="1 0 2"/><frame pos="0 1 0"><site name="a2"/></frame>
<body name="p"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom size="0.1"/><site name="b1"/>
<body name="g"><joint type="hinge"/><geom size="0.1"/></body></body>
<body name="o" pos="5 0 0"><freejoint/><geom size="0.1"/></body></worldbody>
<tendon><spatial name="c1" class="c"><site site="a1"/><site site="b1"/></spatial>
<spatial name="c2"><site site="a2"/><site site="b1"/></spatial></tendon>
<actuator><motor tendon="c1" gear="-1" ctrlrange="1 9"/><position tendon="c2" forcerange="-9 0"/></actuator>
<sensor><clock/></sensor></mujoco>"""
INCLUDED = '<mujocoinclude><worldbody><site name="x"/></worldbody></mujocoinclude>'
# Name of the file, of the files beside it, and its text.
XML = {
    "WireX": ("r.wcrfx", {}, wirex(0.05, **{"</robot>": '<application max_cable_load="500"/><controller/></robot>'})),
    "CASPR bodies": ("r_bodies.xml", {"r_cables.xml": cables()}, bodies()),
    "CASPR cables": ("r_cables.xml", {"r_bodies.xml": bodies()}, cables()),
    "CASPR motions": ("r_trajectories.xml", {"r_bodies.xml": bodies(), "r_cables.xml": cables()}, MOTIONS),
    "CASPR spaces": ("r_operational_spaces.xml", {"r_bodies.xml": bodies(), "r_cables.xml": cables()}, SPACES),
    "MJCF": ("r.xml", {}, MJCF),
    "MJCF include": ("i.xml", {"r.xml": MJCF.replace("<worldbody>", '<include file="i.xml"/><worldbody>')}, INCLUDED),
    "SDF": ("r.sdf", {}, sdf_text(legs=2)),
}
XML["MJCF include"] = (
    *XML["MJCF include"][:2],
    '<mujocoinclude><worldbody><site name="x"/></worldbody></mujocoinclude>',
)
LEADS = {"MJCF include": "r.xml"}
YAML = {
    "successor": ("r.yaml", {}, SUCCESSOR),
    "thesis": ("r.yaml", {}, THESIS),
    "trajectory": ("t.yaml", {"r.yaml": SUCCESSOR}, TRAJECTORY),
}


def spread(count):
    """Places that are tried."""
    return range(count) if ALL else sorted({round(k * (count - 1) / (SAMPLE - 1)) for k in range(SAMPLE)})


@cache
def plain(text):
    """A text without its document type, which has no content."""
    return re.sub(r"<!DOCTYPE[^>]*>", "", text)


def places(text):
    return len(list(ET.fromstring(plain(text)).iter()))


def with_unknown(text, k, kind):
    """A text with an unknown part at its k-th element, and the names of that element and those around it."""
    root = ET.fromstring(plain(text))
    around = {child: parent for parent in root.iter() for child in parent}
    at = list(root.iter())[k]
    if kind == "element":
        ET.SubElement(at, "unheard_of")
    elif kind == "attribute":
        at.set("unheard_of", "1")
    else:
        at.text = f"{at.text or ''} unheard_of"
    chain = [at]
    while chain[-1] in around:
        chain.append(around[chain[-1]])
    return ET.tostring(root, encoding="unicode"), [each.tag for each in chain]


# Elements that are omitted with their content, by one line each.
WHOLE = {
    "cable_set": "cable set 'other': ",
    "plugin": "plugin 'libcdpr_plugin.so'",
    "joint": "no cable ends on it|fixed at its position in the model",
    "freejoint": "no cable ends on it",
    # numbers of legs, with any suffix
    **dict.fromkeys(["mass", "ixx", "iyy", "izz", "ixy", "ixz", "iyz", "xyz", "effort", "velocity"], "of the legs"),
}


def told(chain, taken):
    """Return True if it is reported, or an enclosing element is omitted as a whole."""
    said = [*taken.left_out, *taken.warnings]
    if any("unheard_of" in each for each in said):
        return True
    wholes = [f": <{name}> in <{above}>: not imported" for name, above in itertools.pairwise(chain)]
    wholes += [WHOLE[name] for name in chain if name in WHOLE]
    return any(re.search(whole, each) for whole in wholes for each in said)


CASES = [
    (name, k, kind) for name in XML for k in spread(places(XML[name][2])) for kind in ("element", "attribute", "text")
]


@pytest.mark.parametrize(("name", "k", "kind"), CASES)
@pytest.mark.usual("*-0-*", "*-7-*", "SDF-*")
def test_an_unknown_part_of_xml_is_reported(tmp_path, name, k, kind):
    file, others, text = XML[name]
    changed, chain = with_unknown(text, k, kind)
    for other, content in others.items():
        (tmp_path / other).write_text(content)
    (tmp_path / file).write_text(changed)
    try:
        taken = import_file(tmp_path / LEADS.get(name, file))
    except CdprError as error:  # MuJoCo's compiler, or a number with a suffix: also reported by an error
        said = str(error)
    else:
        said = "" if told(chain, taken) else "nothing"
    assert not said or re.search(rf"{file}:\d+: .*(unheard_of|expected|unrecognized|cables here have two)", said), said


def mappings(value, path=()):
    """Paths of all mappings of a document."""
    found = [path] if isinstance(value, dict) else []
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return found + [each for key, part in inner for each in mappings(part, (*path, key))]


YAML_CASES = [(name, path) for name in YAML for path in mappings(yaml.safe_load(YAML[name][2]))]


@pytest.mark.parametrize(("name", "path"), YAML_CASES)
def test_an_unknown_key_of_yaml_is_reported(tmp_path, name, path):
    file, others, text = YAML[name]
    document = yaml.safe_load(text)
    at = document
    for key in path:
        at = at[key]
    at["unheard_of"] = {"deep": [1, 2]}
    for other, content in others.items():
        (tmp_path / other).write_text(content)
    (tmp_path / file).write_text(yaml.safe_dump(document))
    trajectory = {"trajectory": str(tmp_path / "t.yaml")} if name == "trajectory" else {}
    taken = import_file(tmp_path / "r.yaml", **trajectory)
    around = [".".join(str(key) for key in path[:k] if isinstance(key, str)) for k in range(1, len(path) + 1)]
    said = [text.split(": ", 1)[1] for text in taken.left_out]
    assert any("unheard_of" in each for each in said) or any(
        re.search(rf"(^|\W){re.escape(one.split('.')[-1])}\W", each) for one in around for each in said
    ), said


def test_the_terminal_and_the_file_list_them(tmp_path):
    (tmp_path / "r.wcrfx").write_text(wirex(**{"<platform name": '<platform unheard_of="1" name'}))
    done = cdpr_here("import", tmp_path / "r.wcrfx", "--out", tmp_path / "out", code=0)
    said = "attribute 'unheard_of' of <platform> in <robot>: not imported"
    assert f"left out: {tmp_path}/r.wcrfx:7: {said}" in done.stderr
    head = " ".join(line.lstrip("# ") for line in (tmp_path / "out" / "Crane_1.yaml").read_text().splitlines())
    assert f"- r.wcrfx:7: {said}" in head
