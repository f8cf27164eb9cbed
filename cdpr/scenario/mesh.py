"""Meshes of triangles in files, STL or Wavefront OBJ: the box around them, and their convex hull."""

from __future__ import annotations

import os
from functools import lru_cache

import numpy as np

from cdpr.fields import MAX_DISTANCE
from cdpr.model.hull import convex_hull, deepest
from cdpr.model.robot import Array
from cdpr.scenario.files import CpuBudget, UnreadableError, read

ENDINGS = (".stl", ".obj")
MAX_BYTES = 32 * 2**20  # half a million triangles in STL

Point = tuple[float, float, float]
Corners = tuple[Point, Point]

# Binary STL: 80 bytes of comment, the number of triangles, and of each normal, three corners and two bytes more.
HEAD = 84
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])

EACH = 10_000  # lines between two checks of the CPU time
BYTE_ORDER_MARK = b"\xef\xbb\xbf"  # some editors put it before text


def box_around(path: str) -> Corners:
    """Return the lower and the upper corner, m, of the box around a mesh, whose numbers are metres.

    Raises UnreadableError, which says what is wrong with the file.
    """
    return _box(path, _stamp(path))


def hull_of(path: str) -> tuple[tuple[Point, ...], float]:
    """Return the corners, m, of the convex hull of a mesh, and how deep within it others of the mesh are, m.

    Raises UnreadableError likewise, and where there is no such hull, or one of too many corners.
    """
    return _hull(path, _stamp(path))


def _stamp(path: str) -> tuple[int, int]:
    """When a file was changed, and its size."""
    if not path.lower().endswith(ENDINGS):
        raise UnreadableError(f"'{path}': a mesh is expected in a file that ends with {' or '.join(ENDINGS)}")
    try:
        status = os.stat(path)
        return status.st_mtime_ns, status.st_size
    except (OSError, ValueError):
        return 0, 0  # reading says why


@lru_cache(maxsize=64)  # each case of a study asks for it
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
        raise UnreadableError(f"'{path}' is no obstacle: {error}") from None
    return tuple((x, y, z) for x, y, z in corners.tolist()), deepest(points, corners, triangles)


def _corners(path: str, budget: CpuBudget) -> Array:
    """All corners (k, 3) in a file, m."""
    content = read(path, MAX_BYTES, ENDINGS)
    if len(content) > MAX_BYTES:
        raise UnreadableError(f"'{path}' is larger than {MAX_BYTES // 2**20} MiB: draw a coarser mesh")
    try:
        corners = _obj(content, budget) if path.lower().endswith(".obj") else _stl(content, budget)
    except ValueError as error:
        raise UnreadableError(f"'{path}' is no mesh: {error}") from None
    if not len(corners):
        raise UnreadableError(f"'{path}' is no mesh: it has no corner")
    if not (np.abs(corners) <= MAX_DISTANCE).all():  # false also where not finite
        raise UnreadableError(f"'{path}' is no mesh: a corner is not finite or beyond {MAX_DISTANCE:g} m")
    return corners


def _stl(content: bytes, budget: CpuBudget) -> Array:
    """Corners (k, 3) of an STL file, binary or text; the comment of a binary one may begin as a text does."""
    count = int.from_bytes(content[80:HEAD], "little")
    length = HEAD + count * TRIANGLE.itemsize
    if len(content) >= HEAD and len(content) == length:
        triangles = np.frombuffer(content, TRIANGLE, count, HEAD)
        return triangles["corners"].reshape(-1, 3).astype(np.float64)
    text = content.removeprefix(BYTE_ORDER_MARK)
    if text[:5].lower() != b"solid":
        raise ValueError("neither binary STL of the length that it says, nor text that begins with 'solid'")
    if b"\0" in text:
        told = f"of {length} bytes, as the {count} triangles that it says take" if len(content) >= HEAD else "whole"
        raise ValueError(f"it holds bytes that no text has, and is no binary STL {told}: it has {len(content)} bytes")
    if b"endsolid" not in text.lower():
        raise ValueError("it is text that does not end with 'endsolid': a part of it is missing")
    return _vectors(text, b"vertex", budget)


def _obj(content: bytes, budget: CpuBudget) -> Array:
    """Corners (k, 3) of a Wavefront OBJ file; a line that ends with a backslash goes on in the next."""
    return _vectors(content.removeprefix(BYTE_ORDER_MARK), b"v", budget, goes_on=b"\\")


def _vectors(content: bytes, word: bytes, budget: CpuBudget, goes_on: bytes = b"") -> Array:
    """The three numbers behind `word`, in small letters or capitals, in each line that begins with it, (k, 3)."""
    found = []
    lines = iter(enumerate(content.splitlines(), 1))
    for number, line in lines:
        if number % EACH == 0:
            budget.check()
        if goes_on and line.rstrip().endswith(goes_on):
            parts = list[bytes]()  # joined once: a file of such lines would else take the square of its length
            while line.rstrip().endswith(goes_on):
                if len(parts) % EACH == 0:
                    budget.check()
                parts.append(line.rstrip()[: -len(goes_on)])
                line = next(lines, (0, b""))[1]
            line = b" ".join([*parts, line])
        words = line.split()
        if words and words[0].lower() == word:
            try:
                x, y, z = map(float, (each.replace(b"_", b"?") for each in words[1:4]))  # 1_0 is one in Python alone
            except ValueError:
                raise ValueError(f"three numbers are expected after '{word.decode()}' in line {number}") from None
            found.append((x, y, z))
    return np.array(found, dtype=np.float64).reshape(-1, 3)
