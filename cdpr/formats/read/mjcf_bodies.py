"""Platform of an MJCF model (the moving body to which cables are attached) and treatment of other moving bodies.

Moving bodies without cables are fixed. Those on the platform, such as a gripper, become part of it in the model's
position; others are not imported. Constraints within one of these two groups are dropped; constraints between the
platform and anything else are rejected.
"""

from __future__ import annotations

from collections.abc import Iterator

from cdpr.base.errors import FormatError
from cdpr.formats.read.mjcf_text import Lines
from cdpr.formats.read.xml import Element

JOINTS = ("joint", "freejoint")
BOTH = (("body1", "body2"), ("site1", "site2"), ("joint1", "joint2"))


class Bodies:
    """Body tree of a model.

    Attributes:
        platform: the platform's body; None if no cable ends on a moving body.
        dropped: ids of elements that are hidden from MuJoCo: joints, constraints and fixed tendons.
    """

    def __init__(self, lines: Lines) -> None:
        self._lines, self._root = lines, lines.root
        self._above: dict[int, Element | None] = {}  # parent body of each body
        self._of: dict[tuple[str, str], Element | None] = {}  # body of each named site and joint
        self._joints: dict[int, list[Element]] = {}
        self._bodies: list[Element] = []
        for world in self._root.all("worldbody"):
            self._walk(world, None)
        self.dropped: set[int] = set()
        self.platform = self._platform()
        if self.platform is not None:
            self._fix()
            self._constraints()
        self._anchors()

    def _walk(self, element: Element, body: Element | None) -> None:
        for child in element.children:
            if child.name == "body":
                self._above[id(child)] = body
                self._joints[id(child)] = []
                self._bodies.append(child)
                self._walk(child, child)
            elif child.name in ("site", *JOINTS):
                kind = "site" if child.name == "site" else "joint"
                self._of[kind, _name(child)] = body
                if kind == "joint" and body is not None:
                    self._joints[id(body)].append(child)
            elif child.name == "frame":
                self._walk(child, body)

    def _chain(self, body: Element | None) -> Iterator[Element]:
        """Yield a body and its ancestors, outwards."""
        while body is not None:
            yield body
            body = self._above[id(body)]

    def _mover(self, body: Element | None) -> Element | None:
        return next((each for each in self._chain(body) if self._joints[id(each)]), None)

    def _ends(self) -> Iterator[tuple[Element, str, Element | None]]:
        """Yield each cable with each of its sites, and the site's body."""
        for group in self._root.all("tendon"):
            for cable in group.all("spatial"):
                for site in cable.children:
                    name = site.attributes.get("site", "") if site.name == "site" else ""
                    if ("site", name) in self._of:
                        yield cable, name, self._of["site", name]

    def _platform(self) -> Element | None:
        found: Element | None = None
        for cable, site, body in self._ends():
            mover = self._mover(body)
            if mover is None or mover is found:
                continue
            if found is not None:
                raise mover.wrong(
                    f"body '{_name(mover)}' is a second moving body, besides '{_name(found)}', on which cables end "
                    f"(site '{site}' of tendon '{_name(cable)}'); only robots with one platform are supported: "
                    "remove the joints of the bodies at rest, and end cables at their last "
                    "pulley or winch"
                )
            found = mover
        if found is not None and (outer := self._mover(self._above[id(found)])) is not None:
            raise found.wrong(
                f"body '{_name(found)}' is a second moving body, besides '{_name(outer)}', which carries it; only "
                f"robots with one platform are supported: remove the joints of '{_name(outer)}', or put all joints "
                "into one body"
            )
        return found

    def _on_platform(self, body: Element | None) -> bool:
        return any(each is self.platform for each in self._chain(body))

    def _fix(self) -> None:
        """Drop the joints of all bodies except the platform."""
        for body in self._bodies:
            joints = self._joints[id(body)]
            if body is self.platform or not joints:
                continue
            self.dropped |= {id(joint) for joint in joints}
            for joint in joints:
                joint.done()
            names = ", ".join(_name(joint) or joint.attributes.get("type", "unnamed") for joint in joints)
            what = f"{joints[0].at}: body '{_name(body)}' moves on its own ({names})"
            if self._on_platform(body):
                self._lines.warnings.append(
                    f"{what}: fixed at its position in the model; the body is part of the platform"
                )
            else:
                self._lines.left_out.append(f"{what}: no cable ends on it; it is not part of the robot")

    def _constraints(self) -> None:
        for group in self._root.all("equality"):
            for element in group.children:
                if element.attributes.get("active") != "false":
                    self._constraint(element)
        for group in self._root.all("tendon"):
            for element in group.all("fixed"):
                bodies = [self._of.get(("joint", each.attributes.get("joint", ""))) for each in element.children]
                if bodies and all(body is not None and body is not self.platform for body in bodies):
                    self._drop(element, "joints at rest here")

    def _constraint(self, element: Element) -> None:
        sides = list[Element | None]()
        for pair in BOTH:
            kind = pair[0][:-1]
            for word in pair:
                name = element.attributes.get(word, "")
                if name:
                    sides.append(self._lines.find("body", name) if kind == "body" else self._of.get((kind, name)))
        if element.name in ("connect", "weld") and len(sides) == 1:
            sides.append(None)  # to the world
        driven = element.name == "joint" and any(side is self.platform for side in sides)
        on = {self._on_platform(side) for side in sides}
        if not sides or driven or len(on) > 1:
            raise held(element)
        self._drop(element, "parts of the platform" if True in on else "bodies without cables")

    def _drop(self, element: Element, between: str) -> None:
        self.dropped.add(id(element))
        element.done()
        self._lines.left_out.append(f"{element.at}: <{element.name}> '{_name(element)}': between {between}")

    def _anchors(self) -> None:
        """Warn about cables that end on mocap bodies."""
        reported = set[int]()
        for cable, site, body in self._ends():
            moved = next((each for each in self._chain(body) if each.attributes.get("mocap") == "true"), None)
            if moved is not None and id(moved) not in reported:
                reported.add(id(moved))
                self._lines.warnings.append(
                    f"{moved.at}: body '{_name(moved)}' is a mocap body, which a program moves: its anchors (site "
                    f"'{site}' of tendon '{_name(cable)}') are fixed here where the model puts them"
                )


def held(element: Element) -> FormatError:
    """Return the error for a constraint of the platform."""
    words = ("body1", "body2", "site1", "site2", "joint1", "joint2", "tendon1", "tendon2")
    given = ", ".join(f"{word} '{element.attributes[word]}'" for word in words if word in element.attributes)
    return element.wrong(
        f"<{element.name}> '{_name(element)}' ({given or 'no body'}): only joints and cables can hold a platform: "
        "remove it, or join the bodies by writing one inside the other"
    )


def _name(element: Element) -> str:
    return str(element.attributes.get("name", ""))
