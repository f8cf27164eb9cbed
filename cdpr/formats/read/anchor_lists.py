"""Reader of lists of anchors and attachments: JSON, YAML or CSV.

JSON and YAML have the keys `anchors` and `attachments`, lists of points in m, and may have `mass`, `inertia`, `com`,
`t_min`, `t_max`, `dof`, `home`, `name`, `n_cables` and `cable_diameter_m`. CSV has one cable per line: its anchor and,
after it, its attachment, 0 if missing; a first column may have names or numbers. A first line with headings sets
another order.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from cdpr.base.errors import FormatError
from cdpr.base.problems import short_repr
from cdpr.formats.read.import_options import Choice
from cdpr.formats.read.imported import Imported, refuse, slug, unique
from cdpr.formats.read.inertia import filled, six
from cdpr.formats.read.plain_documents import plain_document
from cdpr.formats.read.text_lines import lines_of
from cdpr.formats.read.yaml_reader import Node
from cdpr.model.robot import Array
from cdpr.scenario.robot_schema import ALL_DOF, MAX_CABLES, Inertia

MASS = 1.0  # kg, assumed without one
POINT, PAIR = 3, 6  # numbers of a line of CSV
HEAD = 4096  # bytes that show whether a file is a table
FLAT = 0.1  # height of the anchors relative to their extent, below which the robot hangs
AXES = ("ax", "ay", "az", "bx", "by", "bz")  # columns of an anchor and an attachment
# Columns by their headings, in lower case.
HEADINGS = {"name": "name", "cable": "name"} | {axis: f"a{axis}" for axis in "xyz"}
HEADINGS |= {heading: axis for axis in AXES for heading in (axis, f"{axis[0]}_{axis[1]}")}


def recognise(content: bytes) -> bool:
    """Return True if the content has both lists, or its first lines are three or six numbers."""
    return b"\0" not in content[:HEAD] and (_is_keyed(content) or _is_table(content[:HEAD]))


def is_main_file(path: Path, content: bytes) -> bool:
    """Return True if a robot is read from this file."""
    return True


def read(path: Path, content: bytes, choice: Choice) -> Imported:
    """Read a robot.

    Raises:
        CdprError: if the file is invalid or not representable.
    """
    name = slug(path.stem, "robot")
    found = Imported(name, f"list of anchors: {path.name}", {"name": name}, [])
    if _is_keyed(content):
        _keyed(found, path, content, choice.tension)
    else:
        _table(found, path, content, choice.tension)
    return found


def _is_keyed(content: bytes) -> bool:
    keys = (rb"(?m)(?:^|[{,]\s*|^\s+)\"?" + key + rb"\"?\s*:" for key in (b"anchors", b"attachments"))
    return content.lstrip()[:1] != b"<" and all(re.search(key, content) is not None for key in keys)


def _keyed(found: Imported, path: Path, content: bytes, given: tuple[float, float] | None) -> None:
    """Read JSON or YAML."""
    top = plain_document(content, str(path))
    found.documents.append(top)
    title = (top / "name").value
    if isinstance(title, str):
        found.name = found.robot["name"] = slug(title, found.name)
    points = top / "anchors"
    anchors, ends = ([point.vector(3) for point in (top / key).items()] for key in ("anchors", "attachments"))
    if len(anchors) != len(ends):
        raise (top / "attachments").wrong(f"expected {len(anchors)} points, one per anchor, got {len(ends)}")
    if "n_cables" in top and (top / "n_cables").number() != len(anchors):
        raise (top / "n_cables").wrong(f"expected {len(anchors)}, the number of anchors, got {top.value['n_cables']}")
    dof = _dof(top / "dof", ends)
    mass = _first(top, "mass")
    diameter = _first(top, "cable_diameter_m", "cable_diameter")
    centre = next((top / key for key in ("com", "center_of_mass") if key in top), None)
    place = [0.0, 0.0, 0.0] if centre is None else centre.vector(3)
    _complete(found, path, np.array(anchors), np.array(ends), dof, mass, _tensor(top / "inertia"), place)
    if "home" in top:
        found.robot["home"] = {"position": (top / "home").vector(3)}
        found.comments["home",] = (top / "home").at
    if diameter is not None:
        found.robot["cable"] = {"diameter": diameter.number()}
    found.robot["tension"] = _limits(found, top, len(anchors), given)
    _cables(found, anchors, ends, [f"cable_{k + 1}" for k in range(len(anchors))])
    found.comments |= {("cables", k): f"line {point.line}" for k, point in enumerate(points.items())}
    if mass is not None:
        found.comments["platform", "mass"] = f"kg, {mass.at}"


def _first(top: Node, *keys: str) -> Node | None:
    return next((top / key for key in keys if key in top), None)


def _dof(node: Node, ends: list[list[float]]) -> list[str]:
    """Return the free directions: names, 3 (no rotation) or 6. Default: 3 if all cables end in the origin."""
    if node.value is None:
        return list(ALL_DOF if np.any(ends) else ALL_DOF[:3])
    if isinstance(node.value, list):
        return [str(each) for each in node.value]
    if node.value not in (POINT, PAIR):
        raise node.wrong(f"expected 3 (x, y, z), 6, or names such as [x, z, ry], got {short_repr(node.value)}")
    return list(ALL_DOF[: int(node.value)])


def _tensor(node: Node) -> Inertia:
    """Return the inertia of a matrix, its diagonal, or six numbers ixx, iyy, izz, ixy, ixz, iyz; 0 if missing."""
    if node.value is None:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    items = node.items()
    if len(items) == 3 and all(isinstance(item.value, list) for item in items):
        matrix = np.array([item.vector(3) for item in items])
        if not np.array_equal(matrix, matrix.T):
            raise node.wrong("expected a symmetric matrix")
        return six(matrix)
    values = node.vector(6) if len(items) == 6 else [*node.vector(3), 0.0, 0.0, 0.0]
    return (values[0], values[1], values[2], values[3], values[4], values[5])


def _limits(found: Imported, top: Node, count: int, given: tuple[float, float] | None) -> dict[str, Any]:
    limits: dict[str, Any] = {}
    for k, (ours, key) in enumerate((("min", "t_min"), ("max", "t_max"))):
        node = top / key
        if node.value is not None:
            limits[ours] = node.vector(count) if isinstance(node.value, list) else node.number()
            found.comments["tension", ours] = f"N, {node.at}"
        elif given is not None:
            limits[ours] = given[k]
            found.comments["tension", ours] = "N, given to the import"
        else:
            raise top.wrong(f"expected {key}, N: add it, or give both limits to the import (--tension MIN,MAX)")
    return limits


def _complete(
    found: Imported, path: Path, anchors: Array, ends: Array, dof: Sequence[str], mass: Node | None, inertia: Inertia,
    centre: list[float],
) -> None:  # fmt: skip
    """Add the platform, the directions and an assumed home."""
    weight = MASS if mass is None else mass.number()
    if mass is None:
        found.warnings.append(f"{path}: assumed, because the file does not define it: the mass, {MASS:g} kg")
        found.comments["platform", "mass"] = "kg, assumed"
    elif weight <= 0.0:
        raise mass.wrong(f"expected more than 0 kg, got {weight:g}")
    try:
        whole, note = filled(inertia, weight, ends - np.array(centre), any(name.startswith("r") for name in dof))
    except ValueError as error:
        raise FormatError(f"{path}: inertia: {error}") from None
    if note:
        found.warnings.append(f"{path}: {note}")
    found.robot["dof"] = list(dof)
    found.robot["platform"] = {"mass": weight} | ({} if whole is None else {"inertia": list(whole)})
    if any(centre):
        found.robot["platform"]["center_of_mass"] = centre
    middle = (anchors.max(axis=0) + anchors.min(axis=0)) / 2.0
    extent = np.ptp(anchors, axis=0)
    if extent[2] < FLAT * extent.max():  # it hangs
        middle[2] = anchors[:, 2].min() - extent.max() / 2.0
    found.robot["home"] = {"position": [round(float(value), 9) + 0.0 for value in middle]}
    found.comments["home",] = "assumed: between the anchors, or below them"


def _cables(found: Imported, anchors: Any, ends: Any, names: list[str]) -> None:
    rows = zip(unique(names), anchors, ends, strict=True)
    found.robot["cables"] = [{"name": name, "frame": list(a), "platform": list(b)} for name, a, b in rows]
    found.comments["cables",] = "m: anchors and attachments"


def _words(line: str) -> list[str]:
    """Return the columns of a line of CSV.

    Semicolons, tabs, commas or spaces separate them. Quotes may enclose a column. Between semicolons and tabs, a comma
    in a number is a decimal one.
    """
    text = re.sub(r'^((?:[^"#]|"[^"]*")*)#.*', r"\1", line)  # without a comment
    row = text.strip()
    bare = re.sub(r'"[^"]*"', "", row)
    for separator in (";", "\t", ","):
        if separator in bare:
            words = [word.strip() for word in next(csv.reader([row], delimiter=separator, skipinitialspace=True))]
            return words if separator == "," else [_with_point(word) for word in words]
    return next(csv.reader([" ".join(row.split())], delimiter=" "), [])


def _with_point(word: str) -> str:
    """Return a number with a decimal comma with a point; other words unchanged."""
    return word.replace(",", ".") if _is_number(word.replace(",", ".")) else word


def _is_number(word: str) -> bool:
    return re.fullmatch(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", word) is not None


def _is_table(content: bytes) -> bool:
    lines = (line.decode("latin-1") for line in content.removeprefix(b"\xef\xbb\xbf").splitlines())
    rows = list(islice((words for line in lines if (words := _words(line))), 4))
    headed = bool(rows) and _headings(rows[0])
    rows = rows[headed:]
    valid = _measures if headed else _numbers
    return bool(rows) and all(valid(row) is not None for row in rows[: len(rows) - (len(rows) > 2)])


def _headings(row: list[str]) -> bool:
    """Return True if a line has only known headings, or at least three of `AXES` and others."""
    words = [word.lower() for word in row]
    return not any(map(_is_number, row)) and (
        all(word in HEADINGS for word in words)
        or sum(HEADINGS.get(word) in AXES and len(word) > 1 for word in words) > 2
    )


def _measures(row: list[str]) -> list[str] | None:
    """Return a line of at least three cells, of which one may be a name; None for another."""
    return row if len(row) >= POINT and sum(map(_is_number, row)) >= len(row) - 1 else None


def _columns(row: list[str], path: Path, line: int) -> list[int]:
    """Return the position of the name, -1 without one, and those of the numbers in the order of `AXES`.

    Raises:
        FormatError: if a heading is unknown or occurs twice, or the axes are incomplete.
    """
    names = [HEADINGS.get(word.lower(), "") for word in row]
    axes = [axis for axis in AXES if axis in names]
    if "" in names or len(set(names)) < len(names) or axes not in ([*AXES[:POINT]], [*AXES]):
        raise refuse(
            str(path), line, f"expected the headings {', '.join(AXES)} (or only {', '.join(AXES[:POINT])}), each once, "
            f"in any order, maybe with `name`, got {short_repr(','.join(row))}"
        )  # fmt: skip
    return [names.index("name") if "name" in names else -1, *map(names.index, axes)]


def _numbers(row: list[str], columns: list[int] | None = None) -> tuple[str, list[float]] | None:
    """Return the name and the numbers of a line; None if it has neither three nor six, or other than its `columns`."""
    if columns is not None:
        if len(row) != max(columns) + 1:
            return None
        name, numbers = row[columns[0]] if columns[0] >= 0 else "", [row[k] for k in columns[1:]]
    else:
        named = not _is_number(row[0]) or (row[0].isdecimal() and len(row) in (POINT + 1, PAIR + 1))
        name, numbers = (row[0], row[1:]) if named else ("", row)
    if len(numbers) not in (POINT, PAIR) or not all(map(_is_number, numbers)):
        return None
    return name, [float(word) for word in numbers]


def _table(found: Imported, path: Path, content: bytes, given: tuple[float, float] | None) -> None:
    """Read CSV."""
    rows: list[tuple[str, list[float], int]] = []
    columns: list[int] | None = None
    for line, text in enumerate(lines_of(content, str(path)), 1):
        words = _words(text)
        if not words:
            continue
        if not rows and columns is None and _headings(words):
            columns = _columns(words, path, line)
            continue
        numbers = _numbers(words, columns)
        if numbers is None or (rows and len(numbers[1]) != len(rows[0][1])):
            wanted = f"{len(rows[0][1])}" if rows else "3 or 6" if columns is None else f"{len(columns) - 1}"
            form = "maybe after a name" if columns is None else "one cell per heading"
            raise refuse(str(path), line, f"expected {wanted} numbers, m, {form}, got {short_repr(text)}")
        if len(rows) == MAX_CABLES:
            raise refuse(str(path), line, f"expected at most {MAX_CABLES} cables")
        rows.append((*numbers, line))
    values = np.array([numbers if len(numbers) == PAIR else [*numbers, 0.0, 0.0, 0.0] for _, numbers, _ in rows])
    anchors, ends = values[:, :3], values[:, 3:]
    dof = [*(ALL_DOF if ends.any() else ALL_DOF[:3])]
    _complete(found, path, anchors, ends, dof, None, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), [0.0, 0.0, 0.0])
    if given is None:
        raise FormatError(f"{path}: a list of anchors has no limits of tensions: give them (--tension MIN,MAX)")
    found.robot["tension"] = {"min": given[0], "max": given[1]}
    found.comments["tension",] = "N, given to the import"
    names = [slug(name, f"cable_{k + 1}") for k, (name, _, _) in enumerate(rows)]
    _cables(found, anchors.tolist(), ends.tolist(), names)
    found.comments |= {("cables", k): f"line {line}" for k, (_, _, line) in enumerate(rows)}
