"""Triangle meshes in STL or Wavefront OBJ files: bounding box and convex hull."""

from __future__ import annotations

import os
from functools import lru_cache

import numpy as np

from cdpr.base.fields import MAX_DISTANCE
from cdpr.base.files import CpuBudget, UnreadableError, read
from cdpr.model.hull import convex_hull, deepest
from cdpr.model.robot import Array

ENDINGS = (".stl", ".obj")
MAX_BYTES = 32 * 2**20  # half a million triangles in STL

Point = tuple[float, float, float]
Corners = tuple[Point, Point]

# Binary STL: 80 bytes of comment, number of triangles; per triangle the normal, three corners and two more bytes.
HEAD = 84
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])

EACH = 10_000  # lines between two checks of the CPU time
BYTE_ORDER_MARK = b"\xef\xbb\xbf"  # some editors write it at the start of a text


def box_around(path: str) -> Corners:
    """Return the lower and upper corner, m, of a mesh's bounding box.

    Raises:
        UnreadableError: if the file is invalid.
    """
    return _box(path, _stamp(path))


def hull_of(path: str) -> tuple[tuple[Point, ...], float]:
    """Return the corners of the convex hull of a mesh, m, and the largest depth of its other corners inside, m.

    Raises:
        UnreadableError: if the file is invalid, or its hull is degenerate or too complex.
    """
    return _hull(path, _stamp(path))


def _stamp(path: str) -> tuple[int, int]:
    """Return the modification time and the size of a file, as cache key."""
    if not path.lower().endswith(ENDINGS):
        raise UnreadableError(f"'{path}': expected a mesh file that ends with {' or '.join(ENDINGS)}")
    try:
        status = os.stat(path)
        return status.st_mtime_ns, status.st_size
    except (OSError, ValueError):
        return 0, 0  # reading reports the reason


@lru_cache(maxsize=64)  # each case of a study calls it
def _box(path: str, stamp: tuple[int, int]) -> Corners:
    corners = _corners(path, CpuBudget(path))
    x, y, z = corners.min(axis=0).tolist()
    X, Y, Z = corners.max(axis=0).tolist()
    return (x, y, z), (X, Y, Z)


@lru_cache(maxsize=64)
def _hull(path: str, stamp: tuple[int, int]) -> tuple[tuple[Point, ...], float]:
    budget = CpuBudget(path)
    points = _corners(path, budget)
    try:
        corners, triangles = convex_hull(points, budget.check)
    except ValueError as error:
        raise UnreadableError(f"'{path}' is not an obstacle: {error}") from None
    return tuple((x, y, z) for x, y, z in corners.tolist()), deepest(points, corners, triangles)


def _corners(path: str, budget: CpuBudget) -> Array:
    """Return all corners (k, 3) in a file, m."""
    content = read(path, MAX_BYTES, ENDINGS)
    if len(content) > MAX_BYTES:
        raise UnreadableError(f"'{path}' is larger than {MAX_BYTES // 2**20} MiB: draw a coarser mesh")
    try:
        corners = _obj(content, budget) if path.lower().endswith(".obj") else _stl(content, budget)
    except ValueError as error:
        raise UnreadableError(f"'{path}' is not a mesh: {error}") from None
    if not len(corners):
        raise UnreadableError(f"'{path}' is not a mesh: it has no vertices")
    if not (np.abs(corners) <= MAX_DISTANCE).all():  # False also if not finite
        raise UnreadableError(f"'{path}' is not a mesh: a corner is not finite or beyond {MAX_DISTANCE:g} m")
    return corners


def _stl(content: bytes, budget: CpuBudget) -> Array:
    """Return the corners (k, 3) of an STL file, binary or text; a binary file may start like text."""
    count = int.from_bytes(content[80:HEAD], "little")
    length = HEAD + count * TRIANGLE.itemsize
    if len(content) >= HEAD and len(content) == length:
        triangles = np.frombuffer(content, TRIANGLE, count, HEAD)
        return triangles["corners"].reshape(-1, 3).astype(np.float64)
    text = content.removeprefix(BYTE_ORDER_MARK)
    if text[:5].lower() != b"solid":
        raise ValueError("expected binary STL of the declared length, or text that begins with 'solid'")
    if b"\0" in text:
        expected = f" of {length} bytes, as its {count} declared triangles require" if len(content) >= HEAD else ""
        raise ValueError(
            f"it contains bytes that are not text, and is not a binary STL{expected}: it has {len(content)} bytes"
        )
    if b"endsolid" not in text.lower():
        raise ValueError("it is text that does not end with 'endsolid': a part of it is missing")
    return _vectors(text, b"vertex", budget)


def _obj(content: bytes, budget: CpuBudget) -> Array:
    """Return the corners (k, 3) of a Wavefront OBJ file; a backslash at the end continues a line."""
    return _vectors(content.removeprefix(BYTE_ORDER_MARK), b"v", budget, goes_on=b"\\")


def _vectors(content: bytes, word: bytes, budget: CpuBudget, goes_on: bytes = b"") -> Array:
    """Return the three numbers after `word` (case-insensitive) in each line that starts with it, (k, 3)."""
    found = []
    lines = iter(enumerate(content.splitlines(), 1))
    for number, line in lines:
        if number % EACH == 0:
            budget.check()
        if goes_on and line.rstrip().endswith(goes_on):
            parts = list[bytes]()  # joined once, which avoids quadratic time
            while line.rstrip().endswith(goes_on):
                if len(parts) % EACH == 0:
                    budget.check()
                parts.append(line.rstrip()[: -len(goes_on)])
                line = next(lines, (0, b""))[1]
            line = b" ".join([*parts, line])
        words = line.split()
        if words and words[0].lower() == word:
            try:
                x, y, z = map(float, (each.replace(b"_", b"?") for each in words[1:4]))  # 1_0 is valid only in Python
            except ValueError:
                raise ValueError(f"expected three numbers after '{word.decode()}' in line {number}") from None
            found.append((x, y, z))
    return np.array(found, dtype=np.float64).reshape(-1, 3)
