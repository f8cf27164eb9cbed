"""Nominal robot, as controller and tension solver know it: the true robot with the changes in `believed`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Path, Problem, dotted, shown
from cdpr.cables import composed
from cdpr.config.describe import describe
from cdpr.config.document import Document, rename_key
from cdpr.config.overrides import Change, apply
from cdpr.config.problems import Problems, exact
from cdpr.model import DOF_NAMES
from cdpr.scenario.appearance import AT_ORIGIN
from cdpr.scenario.robot_schema import RobotSection
from cdpr.scenario.winch_kinds import command_of, kind_of, winch_path

KEY = "believed"
ALTERNATIVE = "nominal"  # accepted spelling of KEY in files and changes
ANOTHER = f"another spelling of '{KEY}', which is given"
ROBOT: Path = ("robot",)
CABLES: Path = ("robot", "cables")

# Sections with one of several forms: another form replaces the section instead of being merged.
WHOLE = ("shape", "orientation")

# Keys without effect on controller and solver.
UNUSED = (
    "name",
    "home",
    "platform.shape",
    "platform.colour",
    "platform.tools",
    "frame.shape",
    "frame.lower",
    "frame.upper",
    "frame.colour",
)

MOST = 4  # differences in one line


def rename_alternative(document: Document, problems: Problems) -> None:
    """Rename the key `nominal` of a scenario to `believed`; report a problem if both are given."""
    if ALTERNATIVE not in document.data:
        return
    if KEY in document.data:
        mark = document.key_mark((ALTERNATIVE,))
        place = str(document.key_mark((KEY,)))
        problems.add(mark, (ALTERNATIVE,), f"{ANOTHER}{place and ' at '}{place}: remove one of them")
        document.drop((ALTERNATIVE,))
        return
    document.rename(ALTERNATIVE, KEY)
    problems.unreadable = {renamed(path) for path in problems.unreadable}


def renamed_data(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a scenario file with the key `believed` in place of `nominal`, unless it has both."""
    return data if KEY in data else rename_key(data, ALTERNATIVE, KEY)


def renamed(path: Path) -> Path:
    """Return a path with the key `believed` in place of `nominal`."""
    return (KEY, *path[1:]) if path[:1] == (ALTERNATIVE,) else path


def renamed_key(key: str) -> str:
    """Return a dotted key with `believed` in place of `nominal`."""
    return f"{KEY}{key.removeprefix(ALTERNATIVE)}" if key.split(".")[0] == ALTERNATIVE else key


def change_nominal(document: Document, change: Change, problems: Problems) -> None:
    """Apply a change of `believed...` to the document.

    A change inside a list item, such as believed.cables[0].frame[2], affects the whole list. Without such a list in the
    file it is the robot's; therefore these changes are applied later.
    """
    if change.path == (KEY,):
        document.waiting = [each for each in document.waiting if each[0][0] != KEY]
        apply(document, change, problems)
        return
    if document.data.get(KEY) is None:
        document.put((KEY,), {}, change.mark)
    if any(str(part).isdecimal() for part in change.path):
        document.waiting.append((change.path, change.value, change.mark))
    else:
        document.waiting = [each for each in document.waiting if each[0][: len(change.path)] != change.path]
        apply(document, change, problems)


def nominal_document(document: Document, found: Problems) -> Document | None:
    """Return the scenario with the nominal robot, with the positions of all values.

    Args:
        document: document of the scenario.
        found: receives the problems of the nominal robot, with paths of the robot.

    Returns:
        The document, or None if `believed` is missing or invalid.
    """
    given = document.data.get(KEY)
    if given is None:
        return None  # null is reported elsewhere
    if not isinstance(given, dict):
        keys = ", ".join(RobotSection.model_fields)
        found.add(document.mark((KEY,)), ROBOT, f"expected a mapping of keys of the robot ({keys}), got {shown(given)}")
        return None
    twin = document.copy()
    twin.drop((KEY,))
    _Overlay(document, twin, found).merge(ROBOT, (KEY,))
    for path, value, mark in document.waiting:
        apply(twin, Change((*ROBOT, *path[1:]), value, mark), found)
    _same_robot(document, twin, found)
    return twin


def add_problems(found: Problems, problems: Problems) -> None:
    """Add the problems of the nominal robot to `problems`, except those of the true robot."""
    known = {(each.mark, each.path, each.text) for each in problems.items}
    for each in found.items:
        if (each.mark, each.path, each.text) in known:
            continue
        if each.path[:1] == ROBOT:
            problems.add(each.mark, (KEY, *each.path[1:]), each.text)
        else:
            problems.add(each.mark, each.path, f"for the nominal model: {each.text}")


def only_nominal(thought: Iterable[Problem], true: Iterable[Problem]) -> tuple[Problem, ...]:
    """Return the warnings about the nominal robot that do not also apply to the true one."""
    known = {(each.mark, each.text) for each in true}
    return tuple(
        Problem(each.mark, (KEY, *each.path[1:]), each.text)
        for each in thought
        if each.path[:1] == ROBOT and (each.mark, each.text) not in known
    )


class _Overlay:
    """Merge of `believed` into the robot: mappings by key, cables by name, everything else as a whole."""

    def __init__(self, document: Document, twin: Document, found: Problems) -> None:
        self._document, self._twin, self._found = document, twin, found

    def merge(self, at: Path, source: Path) -> None:
        """Merge the value at `source` in the document into the value at `at` in the twin."""
        given, base = self._document.get(source), self._twin.get(at)
        if isinstance(given, dict) and isinstance(base, dict) and not _another_form(at, given, base):
            for key in given:
                self.merge((*at, key), (*source, key))
        elif at == CABLES and isinstance(given, list) and isinstance(base, list):
            for item, index in self._matched(given, base, source):
                self.merge((*at, index), (*source, item))
        else:
            self._twin.transplant(at, self._document, source)

    def _matched(self, given: list[Any], base: list[Any], source: Path) -> Iterator[tuple[int, int]]:
        """Yield the index of each given item, and of its cable."""
        names = cable_names(base)
        taken: dict[str, int] = {}
        for item, entry in enumerate(given):
            path: Path = (*source, item)
            if not isinstance(entry, dict):
                self._report(
                    path, f"expected a mapping (name of a cable, and its different values), got {shown(entry)}"
                )
                continue
            name = entry.get("name")
            if name is None and len(given) == len(base):
                name = names[item]  # all cables in order
            if name is None:
                text = f"required but not given: name of the cable; the robot has {len(base)}, got {len(given)}"
                self._report((*path, "name"), text)
            elif name not in names:
                hint = did_you_mean(str(name), names)
                text = f"unknown cable {shown(name)}: {hint}allowed: {', '.join(names)}"
                self._report((*path, "name"), text)
            elif name in taken:
                self._report((*path, "name"), f"'{name}' is the cable of {dotted((*source, taken[name]))} too")
            else:
                taken[name] = item
                yield item, names.index(name)

    def _report(self, path: Path, text: str) -> None:
        self._found.add(self._document.mark(path), (*ROBOT, *path[1:]), text)


def _another_form(at: Path, given: dict[str, Any], base: dict[str, Any]) -> bool:
    """Return True if a section replaces the base: its form or type differs; types of winches have the same keys."""
    if at[-1] == "winch":
        return False
    return at[-1] in WHOLE or given.get("type", base.get("type")) != base.get("type")


def cable_names(cables: list[Any]) -> list[str]:
    """Return the names of cables, which may be invalid."""
    named = (cable.get("name") if isinstance(cable, dict) else None for cable in cables)
    return [str(name or f"cable_{i + 1}") for i, name in enumerate(named)]


def _same_robot(document: Document, twin: Document, found: Problems) -> None:
    """Report cables or degrees of freedom that differ from the robot's."""
    free, other = (each.get((*ROBOT, "dof")) or list(DOF_NAMES) for each in (document, twin))
    if free != other:
        text = f"must be the robot's, {_value(free)}: the nominal model has the same cables and degrees of freedom"
        found.add(twin.mark((*ROBOT, "dof")), (*ROBOT, "dof"), text)
    cables = [each.get(CABLES) for each in (document, twin)]
    if not all(isinstance(each, list) for each in cables):
        return  # reported by their sections
    legs = (*ROBOT, "unilateral")
    if document.get(legs) is not False and twin.get(legs) is False and _commanded(document, cables[0]):
        text = "must be the robot's, true: commands of its ideal cables act unchanged, and they cannot push"
        found.add(twin.mark(legs), legs, text)
    _same_commands(document, twin, cables, found)
    for i, (name, other) in enumerate(zip(*map(cable_names, cables), strict=True)):
        if name != other:
            path = (*CABLES, i, "name")
            found.add(
                twin.mark(path), path, f"must be '{name}', the name of this cable of the robot, got {shown(other)}"
            )


def _same_commands(document: Document, twin: Document, cables: list[Any], found: Problems) -> None:
    """Report winches with another command than that of the robot's: controllers would output another quantity."""
    for i, pair in enumerate(zip(*cables, strict=False)):
        kinds = [kind_of(each, ROBOT, cable) for each, cable in zip((document, twin), pair, strict=True)]
        true, other = (kind and command_of(kind) for kind in kinds)
        if true and other and true != other:
            path = (*winch_path(ROBOT, pair[1], i), "type")
            text = (
                f"must have the command of the robot's winch, a {true}, got a {other}: the nominal model may have "
                "other values of the winch, but not another command"
            )
            found.add(twin.mark(path), path, text)
            return


def _commanded(document: Document, cables: list[Any]) -> bool:
    """Return True if the tension of some cable equals its command."""
    if document.get(("actuators",)) is not None:
        return False
    kinds = [kind_of(document, ROBOT, cable) for cable in cables]
    return any(kind is not None and composed(*kind).immediate for kind in kinds)


def differences(robot: RobotSection, nominal: RobotSection) -> list[str]:
    """Return short descriptions of the differences; sections must have all names."""
    if nominal.frame is not None and robot.frame is None:
        robot = robot.model_copy(update={"frame": AT_ORIGIN})
    true, thought = (each.model_dump(mode="json", by_alias=True, exclude_none=True) for each in (robot, nominal))
    return list(_differences(true, thought, (), thought))


def _differences(true: Any, thought: Any, path: Path, root: dict[str, Any]) -> Iterator[str]:
    if true == thought:
        return
    if isinstance(thought, dict) and isinstance(true, dict | None):
        for key in thought:
            yield from _differences((true or {}).get(key), thought[key], (*path, key), root)
    elif path == ("cables",):
        for i, pair in enumerate(zip(true, thought, strict=True)):
            yield from _differences(*pair, (*path, i), root)
    else:
        unit = describe(RobotSection, path, root).unit
        place = (
            dotted(tuple(root["cables"][part]["name"] if part == path[1] else part for part in path))
            if (path[0] == "cables")
            else dotted(path)
        )
        was = "nothing" if true is None else _value(true)
        yield f"{place} {_value(thought)}{unit and ' '}{unit} instead of {was}"


def _value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float):
        return exact(value)
    return str(value) if isinstance(value, str | int) and not isinstance(value, bool) else shown(value)


def in_a_line(texts: list[str]) -> str:
    """Return the first differences and the number of others."""
    if not texts:
        return "the robot without changes"
    more = f"; and {len(texts) - MOST} more" if len(texts) > MOST else ""
    return "; ".join(texts[:MOST]) + more


def unused(robot: RobotSection, nominal: RobotSection) -> list[str]:
    """Return the keys of `believed` that differ without effect."""
    if nominal.frame is not None and robot.frame is None:
        robot = robot.model_copy(update={"frame": AT_ORIGIN})
    keys = []
    for key in UNUSED:
        one, other = (_inner(each, key) for each in (robot, nominal))
        if one != other:
            keys.append(f"{KEY}.{key}")
    return keys


def _inner(section: Any, key: str) -> Any:
    for part in key.split("."):
        section = getattr(section, part, None)
    return section
