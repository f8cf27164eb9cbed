"""MJCF before MuJoCo sees it: without what is only seen or heard of, and without what reads files or grows.

What is left is written again with each element in its old line, so that MuJoCo's own messages name lines of the file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any
from xml.sax.saxutils import quoteattr

from cdpr.errors import PluginError
from cdpr.fields import MAX_MAGNITUDE
from cdpr.formats.read.xml import Element
from cdpr.problems import shown

UNSEEN = ("visual", "statistic", "size", "asset", "sensor", "custom", "extension", "contact")
NEVER = (*UNSEEN, "lengthrange", "light", "camera")  # sizes and lengthrange say how much memory and time it may take
REFUSED = {
    "include": "files are read alone: save it as one file, as mujoco.mj_saveLastXML does",
    "replicate": "it makes copies: save what it makes, as mujoco.mj_saveLastXML does",
    "attach": "it takes parts of another file: save it as one file, as mujoco.mj_saveLastXML does",
    "composite": "it makes moving bodies; our cables have no bodies of their own",
    "flexcomp": "it makes moving bodies; our platforms are rigid",
    "deformable": "our platforms are rigid",
    "plugin": "what a plugin does does not stand in the file",
}
NAMED = ("class", "childclass", "model", "body", "joint", "geom", "site", "tendon", "actuator", "objname", "refname")
NAMES = ("name", *NAMED)  # attributes that hold no numbers, whatever they look like
SEEN = ("material", "texture")  # attributes that name what is only seen
PICTURED = ("mesh", "hfield")  # attributes of geoms that need another file
PULLING = ("motor", "general")


@dataclass
class Lines:
    """Where things stand.

    Attributes:
        file: its name.
        root: the whole.
        pictured: names of bodies that had a geom of a mesh, which was not looked at, with its line.
        left_out: what was dropped that has an effect.
    """

    file: str
    root: Element
    pictured: dict[str, int] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    def of(self, kinds: tuple[str, ...], name: str) -> int:
        """Return the line of an element of a name, "" of one that has none; that of the root where there is none."""
        for element in self.root.everywhere():
            if element.name in kinds and element.attributes.get("name", "") == name:
                return element.line
        return self.root.line

    def first(self, kind: str) -> int:
        """Return the line of the first element of a kind; that of the root where there is none."""
        return next((element.line for element in self.root.everywhere() if element.name == kind), self.root.line)

    def explicit(self) -> set[str]:
        """Return the names of bodies whose inertia the file says itself."""
        if any(each.attributes.get("inertiafromgeom") == "true" for each in self.root.all("compiler")):
            return set()
        bodies = (each for each in self.root.everywhere() if each.name == "body" and each.all("inertial"))
        return {body.attributes.get("name", "") for body in bodies}

    def find(self, kind: str, name: str) -> Element | None:
        """Return the element of a kind and a name."""
        found = (
            each for each in self.root.everywhere() if each.name == kind and each.attributes.get("name", "") == name
        )
        return next(found, None)


def cleaned(root: Element) -> tuple[str, Lines]:
    """Return what MuJoCo may compile, and where things stand. Raises FormatError for what is refused."""
    lines = Lines(root.file, root)
    for element in root.everywhere():
        if element.name in REFUSED:
            raise element.wrong(f"<{element.name}>: {REFUSED[element.name]}")
        _sound(element)
    for equality in root.all("equality"):
        for element in equality.children:
            if element.attributes.get("active") != "false":
                name = element.attributes.get("name", "")
                raise element.wrong(f"<{element.name}> '{name}': our platforms are held by nothing but their joints")
    for actuators in root.all("actuator"):
        for element in actuators.children:
            _actuator(element, lines)
    for body in (each for each in root.everywhere() if each.name == "body"):
        for geom in body.all("geom"):
            if any(word in geom.attributes for word in PICTURED):
                lines.pictured.setdefault(body.attributes.get("name", ""), geom.line)
    return "".join(_written(root, [1])), lines


def _sound(element: Element) -> None:
    """Refuse numbers that are none, which MuJoCo takes, and those that are beyond all measure."""
    for key, value in element.attributes.items():
        try:
            numbers = [] if key in NAMES else [float(word) for word in value.split()]
        except ValueError:
            continue
        if not all(abs(number) <= MAX_MAGNITUDE for number in numbers):
            raise element.wrong(
                f"{key} of <{element.name}>: numbers of at most {MAX_MAGNITUDE:g} are expected, got {shown(value)}"
            )


def compiled(text: str, lines: Lines) -> tuple[ModuleType, Any]:
    """Return MuJoCo and its model of a text. Raises PluginError without it, FormatError where it does not compile."""
    try:
        import mujoco
    except ImportError as error:
        raise PluginError(
            "MJCF says inertias and poses in ways that MuJoCo's compiler knows: pip install 'cdpr[mujoco]'"
        ) from error
    mujoco.set_mju_user_warning(lambda text: None)  # which it would write into a file of this folder
    try:
        return mujoco, mujoco.MjModel.from_xml_string(text)
    except (ValueError, mujoco.FatalError) as error:
        told = " ".join(str(error).split())
        line = re.search(r"line (\d+)", told)
        wrong = Element("", lines.file, int(line[1]) if line else lines.root.line, {})
        raise wrong.wrong(f"MuJoCo does not compile it: {told}") from None


def _actuator(element: Element, lines: Lines) -> None:
    name = element.attributes.get("name", "")
    if "tendon" not in element.attributes:
        lines.left_out.append(f"{lines.file}:{element.line}: <{element.name}> '{name}': it drives no tendon")
    elif element.name not in PULLING:
        raise element.wrong(
            f"<{element.name}> '{name}': its force is not its control alone; {' or '.join(PULLING)} is expected"
        )


def _kept(element: Element) -> Iterator[Element]:
    for child in element.children:
        tendonless = element.name == "actuator" and "tendon" not in child.attributes
        pictured = child.name == "geom" and any(word in child.attributes for word in PICTURED)
        if child.name not in NEVER and not (child.name == "equality" or tendonless or pictured):
            yield child


def _written(element: Element, line: list[int]) -> Iterator[str]:
    """The element in its own line, as long as those before are."""
    yield "\n" * (element.line - line[0])
    line[0] = max(line[0], element.line)
    dropped = (*SEEN, "ctrl", "act") if element.name == "key" else SEEN
    given = {key: value for key, value in element.attributes.items() if key not in dropped}
    yield f"<{element.name}" + "".join(f" {key}={quoteattr(value)}" for key, value in given.items()) + ">"
    for child in _kept(element):
        yield from _written(child, line)
    yield f"</{element.name}>"
