"""Models in the format of CASPR: their content, and an independent evaluation of its meaning."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from cdpr.model import rotations

HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE {root} SYSTEM "../../templates/{root}.dtd">\n'
INERTIA = (2.0, 3.0, 4.0, 0.1, -0.2, 0.3)
CENTRE = (0.01, -0.02, 0.03)
CABLES = [
    ((-2.0, -1.5, 3.0), (-0.3, -0.2, 0.1)),
    ((2.0, -1.5, 3.0), (0.3, -0.2, -0.1)),
    ((2.0, 1.5, 3.0), (0.3, 0.2, 0.1)),
    ((-2.0, 1.5, 3.0), (-0.3, 0.2, -0.1)),
    ((-2.0, -1.5, 0.0), (-0.3, -0.2, -0.1)),
    ((2.0, -1.5, 0.0), (0.3, -0.2, 0.1)),
    ((2.0, 1.5, 0.0), (0.3, 0.2, -0.1)),
]
# Directions of each joint, and rotations from angles: as CASPR's joints are documented.
JOINTS = {
    "SPATIAL_EULER_XYZ": ["x", "y", "z", "rx", "ry", "rz"],
    "PLANAR_XY": ["x", "y", "rz"],
    "PLANAR_XZ": ["x", "z", "ry"],
    "PLANAR_YZ": ["y", "z", "rx"],
    "P_X": ["x"],
    "P_XY": ["x", "y"],
    "P_XZ": ["x", "z"],
    "T_XYZ": ["x", "y", "z"],
    "S_EULER_XYZ": ["rx", "ry", "rz"],
    "S_FIXED_XYZ": ["rx", "ry", "rz"],
    "R_Z": ["rz"],
}


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def bodies(
    joint="SPATIAL_EULER_XYZ",
    q=None,
    inertia=INERTIA,
    ref="com",
    centre=CENTRE,
    parent=(0.1, 0.2, 0.3),
    more="",
    mass=5,
):
    q = [0.1] * len(JOINTS.get(joint, "xy")) if q is None else q
    parts = "".join(f"<I{n}>{v!r}</I{n}>" for n, v in zip(("xx", "yy", "zz", "xy", "xz", "yz"), inertia, strict=True))
    return (
        HEAD.format(root="bodies_system")
        + f"""<bodies_system><links display_range="-1 1 -1 1 -1 1" view_angle="1 2">
<!-- <link_rigid num="9" name="not there"/> -->
<link_rigid num="1" name="the platform">
<joint type="{joint}" q_initial="{numbers(q)}" q_min="{numbers(q)}" q_max="{numbers(q)}"/>
<physical><mass>{mass}</mass><com_location>{numbers(centre)}</com_location><end_location>0 0 0</end_location>
<inertia ref="{ref}">{parts}</inertia></physical>
<parent><num>0</num><location>{numbers(parent)}</location></parent>
</link_rigid>{more}</links></bodies_system>"""
    )


def cable(k, reference="joint", kind="cable_ideal", properties="", first=None, last=None):
    a, b = CABLES[k]
    first = first or f"<attachment><link>0</link><location>{numbers(a)}</location></attachment>"
    last = last or f"<attachment><link>1</link><location>{numbers(b)}</location></attachment>"
    limits = "" if "passive" in kind else "<force_min>1.5</force_min><force_max>800</force_max>"
    return (
        f'<{kind} name="cable {k + 1}" attachment_reference="{reference}"><properties>{properties}{limits}</properties>'
        f"<attachments>{first}{last}</attachments></{kind}>"
    )


def cables(rows=None, default="all", name="all"):
    rows = [cable(k) for k in range(len(CABLES))] if rows is None else rows
    text = "\n".join(rows)
    other = f'<cable_set id="other">{cable(0)}{cable(1)}</cable_set>'
    return HEAD.format(root="cables") + (
        f'<cables default_cable_set="{default}"><cable_set id="{name}">\n{text}\n</cable_set>{other}</cables>'
    )


def model(folder, name="robot", bodies_=None, cables_=None, trajectories=None, spaces=None):
    """Write a model, and return the file of its bodies."""
    texts = {"bodies": bodies_ or bodies(), "cables": cables_ or cables()}
    texts |= {"trajectories": trajectories, "operational_spaces": spaces}
    for kind, text in texts.items():
        if text is not None:
            (folder / f"{name}_{kind}.xml").write_text(text, encoding="utf-8")
    return folder / f"{name}_bodies.xml"


def evaluated(bodies_text, cables_text, q):
    """Lengths (m,) and W (6, m), about the joint's frame, of coordinates q: by nothing of ours but rotations."""
    body = ET.fromstring(bodies_text).find(".//link_rigid")
    joint = body.find("joint").get("type")
    along, about = np.zeros(3), np.zeros(3)
    for name, value in zip(JOINTS[joint], q, strict=True):
        if name[0] == "r":
            about["xyz".index(name[1])] = value
        else:
            along["xyz".index(name)] = value
    turns = [rotations.matrix(rotations.from_axis_angle(np.eye(3)[k], about[k])) for k in range(3)]
    R = turns[2] @ turns[1] @ turns[0] if joint == "S_FIXED_XYZ" else turns[0] @ turns[1] @ turns[2]
    p = np.array(list(map(float, body.find("parent/location").text.split()))) + along
    centre = np.array(list(map(float, body.find("physical/com_location").text.split())))
    lengths, columns = [], []
    for each in ET.fromstring(cables_text).find("cable_set"):
        first, last = (np.array(list(map(float, at.text.split()))) for at in each.findall(".//location"))
        arm = R @ (last + (centre if each.get("attachment_reference") == "com" else 0.0))
        line = first - p - arm
        lengths.append(np.linalg.norm(line))
        columns.append([*(line / lengths[-1]), *np.cross(arm, line / lengths[-1])])
    return np.array(lengths), np.array(columns).T, p, R
