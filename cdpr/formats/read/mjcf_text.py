"""Filter of MJCF before compilation: removes visual parts, and everything that reads files or allocates memory.

The rest is written again, one element per line, so that MuJoCo's error messages can be mapped to lines of the original
and included files.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any
from xml.sax.saxutils import quoteattr

from cdpr.base.errors import PluginError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.base.problems import shown
from cdpr.formats.read.xml import Element

UNSEEN = ("visual", "statistic", "size", "asset", "sensor", "custom", "extension", "contact")
NEVER = (*UNSEEN, "lengthrange", "light", "camera")  # size and lengthrange determine memory and time
REFUSED = {
    "replicate": "it creates copies: save the expanded model, for example by mujoco.mj_saveLastXML",
    "attach": "it includes parts of another file: save a single file, for example by mujoco.mj_saveLastXML",
    "composite": "it makes moving bodies; our cables have no bodies of their own",
    "flexcomp": "it makes moving bodies; our platforms are rigid",
    "deformable": "our platforms are rigid",
    "plugin": "the file does not define the behaviour of a plugin",
}
NAMED = ("class", "childclass", "model", "body", "joint", "geom", "site", "tendon", "actuator", "objname", "refname")
NAMES = ("name", *NAMED)  # attributes that are not numeric, whatever they look like
SEEN = ("material", "texture")  # attributes that refer to visual assets
PICTURED = ("mesh", "hfield")  # attributes of geoms that require another file
PULLING = ("motor", "general")
SERVOS = ("position", "velocity", "intvelocity")


@dataclass
class Lines:
    """Index of a model's elements.

    Attributes:
        file: name of the file.
        root: root element.
        pictured: first skipped mesh geom of each body.
        left_out: dropped parts that have an effect.
        warnings: changed parts.
        places: element of each line of the text that MuJoCo compiles.
        qpos: remaining values of the first keyframe, if joints were dropped.
    """

    file: str
    root: Element
    pictured: dict[str, Element] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    places: list[Element] = field(default_factory=list)
    qpos: str = ""

    def __post_init__(self) -> None:
        """Index the names; unnamed bodies get a name."""
        self._named: dict[tuple[str, str], Element] = {}
        self._first: dict[str, Element] = {}
        nameless = list[Element]()
        for element in self.root.everywhere():
            self._first.setdefault(element.name, element)
            name = element.attributes.get("name", "")
            if element.name == "body" and not name:
                nameless.append(element)
            else:
                self._named.setdefault((element.name, name), element)
        for count, element in enumerate(nameless):
            name = f"nameless, line {element.line}"
            if ("body", name) in self._named:
                name = f"nameless {count}, line {element.line}"
            element.attributes["name"] = name
            element.touch("name")
            self._named["body", name] = element

    def find(self, kind: str, name: str) -> Element | None:
        """Return the first element of this kind and name, or None."""
        return self._named.get((kind, name))

    def of(self, kind: str, name: str) -> Element:
        """Return the first element of this kind and name, or the root."""
        return self._named.get((kind, name), self.root)

    def first(self, kind: str) -> Element:
        """Return the first element of this kind, or the root."""
        return self._first.get(kind, self.root)

    def explicit(self) -> set[str]:
        """Return the names of bodies with an explicit inertia."""
        if any(each.attributes.get("inertiafromgeom") == "true" for each in self.root.all("compiler")):
            return set()
        bodies = (each for each in self.root.everywhere() if each.name == "body")
        return {body.attributes.get("name", "") for body in bodies if body.find("inertial") is not None}


def checked(root: Element) -> Lines:
    """Return the index of a model.

    Raises:
        FormatError: if an element is not supported.
    """
    lines = Lines(root.file, root)
    for element in root.everywhere():
        if element.name in REFUSED:
            raise element.wrong(f"<{element.name}>: {REFUSED[element.name]}")
        _sound(element)
    for actuators in root.all("actuator"):
        for element in actuators.children:
            _actuator(element, lines)
    for body in (each for each in root.everywhere() if each.name == "body"):
        for geom in body.children:
            if geom.name == "geom" and any(word in geom.attributes for word in PICTURED):
                lines.pictured.setdefault(body.attributes.get("name", ""), geom)
    return lines


def text_of(lines: Lines, dropped: set[int]) -> str:
    """Return the text for MuJoCo, without elements whose `id` is in `dropped`."""
    lines.places.clear()
    return "".join(_written(lines.root, lines, dropped))


def _sound(element: Element) -> None:
    """Reject non-finite numbers, which MuJoCo accepts, and excessively large ones."""
    for key, value in element.attributes.items():
        try:
            numbers = [] if key in NAMES else [float(word) for word in value.split()]
        except ValueError:
            continue
        if not all(abs(number) <= MAX_MAGNITUDE for number in numbers):
            raise element.wrong(
                f"{key} of <{element.name}>: expected numbers of at most {MAX_MAGNITUDE:g}, got {shown(value)}"
            )


def compiled(text: str, lines: Lines) -> tuple[ModuleType, Any]:
    """Return MuJoCo and its compiled model of a text.

    Raises:
        PluginError: if MuJoCo is missing.
        FormatError: if the text does not compile.
    """
    try:
        import mujoco
    except ImportError as error:
        raise PluginError(
            "only MuJoCo's compiler supports all inertias and poses of MJCF: pip install 'cdpr[mujoco]'"
        ) from error
    mujoco.set_mju_user_warning(lambda text: None)  # MuJoCo would write them to a file in the working folder
    try:
        return mujoco, mujoco.MjModel.from_xml_string(text)
    except (ValueError, mujoco.FatalError) as error:
        message = " ".join(str(error).split())
        given = re.search(r"line (\d+)", message)
        number = int(given[1]) if given else 0
        place = lines.places[number - 1] if 0 < number <= len(lines.places) else lines.root
        if given:  # line of the compiled text
            message = message[: given.start(1)] + str(place.line) + message[given.end(1) :]
        raise place.wrong(f"MuJoCo does not compile it: {message}") from None


def _actuator(element: Element, lines: Lines) -> None:
    name = element.attributes.get("name", "")
    if "tendon" not in element.attributes:
        lines.left_out.append(f"{element.at}: <{element.name}> '{name}': it drives no tendon")
        element.done()
    elif element.name not in (*PULLING, *SERVOS):
        raise element.wrong(
            f"<{element.name}> '{name}': expected {', '.join(PULLING)} or a servo ({', '.join(SERVOS)}): "
            "its force does not depend on its control alone"
        )


def _kept(element: Element, dropped: set[int]) -> Iterator[Element]:
    for child in element.children:
        tendonless = element.name == "actuator" and "tendon" not in child.attributes
        pictured = child.name == "geom" and any(word in child.attributes for word in PICTURED)
        constraint = child.name == "equality" and element.name == "mujoco"
        if child.name not in NEVER and not (constraint or tendonless or pictured or id(child) in dropped):
            yield child


def _written(element: Element, lines: Lines, dropped: set[int]) -> Iterator[str]:
    """Yield the element and its children, one per line."""
    lines.places.append(element)
    cut = (*SEEN, "ctrl", "act") if element.name == "key" else SEEN
    given = {key: value for key, value in element.attributes.items() if key not in cut}
    if element.name == "key" and lines.qpos:
        given = {"name": given.get("name", ""), "qpos": lines.qpos}
    yield f"<{element.name}" + "".join(f" {key}={quoteattr(value)}" for key, value in given.items()) + ">\n"
    for child in _kept(element, dropped):
        if not (child.name == "key" and lines.qpos and child is not lines.first("key")):
            yield from _written(child, lines, dropped)
    lines.places.append(element)
    yield f"</{element.name}>\n"
