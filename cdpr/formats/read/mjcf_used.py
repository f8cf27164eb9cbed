"""Elements and attributes of MJCF that affect the imported robot; all others are reported as not imported.

MuJoCo's compiler rejects unknown ones, so that the table need not be complete: a missing entry is reported although it
was used, never the reverse.
"""

from __future__ import annotations

from cdpr.formats.read.xml import Element

PLACED = "pos quat axisangle xyaxes zaxis euler"
LIMITED = "name class tendon gear ctrllimited ctrlrange forcelimited forcerange"
SERVO = f"{LIMITED} kp kv dampratio timeconst inheritrange"
USED = {
    "mujoco": "model",
    "mujocoinclude": "",
    "compiler": (
        "autolimits boundmass boundinertia settotalmass balanceinertia strippath coordinate angle fitaabb eulerseq "
        "meshdir texturedir assetdir discardvisual usethread fusestatic inertiafromgeom inertiagrouprange saveinertial "
        "alignfree"
    ),
    "option": "gravity density viscosity",
    "flag": "gravity",
    "default": "class",
    "worldbody": "",
    "frame": f"name childclass {PLACED}",
    "body": f"name childclass mocap gravcomp {PLACED}",
    "inertial": f"mass diaginertia fullinertia {PLACED}",
    "joint": "name class type pos axis range limited ref damping armature frictionloss stiffness",
    "freejoint": "name align",
    "geom": f"name class type size fromto mass density rgba mesh hfield shellinertia fitscale {PLACED}",
    "site": f"name class site {PLACED}",
    "tendon": "width range limited stiffness damping frictionloss armature actuatorfrcrange actuatorfrclimited class",
    "spatial": (
        "name class width range limited stiffness damping frictionloss armature actuatorfrcrange actuatorfrclimited"
    ),
    "actuator": "",
    "motor": LIMITED,
    "general": f"{LIMITED} gaintype gainprm biastype biasprm dyntype dynprm actdim",
    "position": SERVO,
    "velocity": SERVO,
    "intvelocity": SERVO,
    "keyframe": "",
}
TABLE = {name: tuple(words.split()) for name, words in USED.items()}

# Parts of cdpr's own export that draw, measure or start a simulation; no robot depends on them. A given value is
# required.
IDLE: dict[str, dict[str, str | None]] = {
    "option": {"timestep": None},
    "flag": {"contact": "disable"},
    "site": {"size": None},
    "geom": {"contype": "0", "conaffinity": "0"},
    "actuatorfrc": {"actuator": None},
    "tendonpos": {"tendon": None},
    "framepos": {"objtype": None, "objname": None},
    "framequat": {"objtype": None, "objname": None},
    "key": {"ctrl": None},
}


def mark(root: Element) -> None:
    """Record effective parts as read."""
    for element in root.everywhere():
        if element.name in TABLE:
            element.touch(*TABLE[element.name])
    for group in root.all("keyframe"):  # the first keyframe is the home pose
        if group.children:
            group.children[0].touch("name", "qpos")
            return


def idle(root: Element) -> list[str]:
    """Return at most one line that lists the parts of `IDLE` in a file, and record them as read."""
    found: dict[str, None] = {}
    for element in root.everywhere():
        if element.name not in IDLE:
            continue
        for key, value in element.attributes.items():
            expected = IDLE[element.name].get(key, "")
            at_rest = element.name == "key" and key == "qvel" and not value.replace("0", "").strip(" .-")
            if key not in element.attributes.read and (at_rest or expected in (None, value)):
                element.touch(key)
                found[f"{key} of <{element.name}>"] = None
    if not found:
        return []
    parts = f"{len(found)} part{'s' * (len(found) > 1)}"
    return [f"{root.file}: {parts} that only draw, measure or start a simulation: {', '.join(found)}"]
