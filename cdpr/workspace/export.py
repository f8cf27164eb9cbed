"""Workspaces as others read them: VTI for ParaView, PLY for viewers of meshes, CSV for tables."""

from __future__ import annotations

import base64
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.errors import CdprError
from cdpr.log.files import unwritable
from cdpr.workspace.result import Workspace
from cdpr.workspace.surface import surface


def vti(found: Workspace) -> bytes:
    """Return a VTK image: value, inside and boundary of each cell (VTK file formats, XML, inline binary)."""
    region = found.region
    extents = [n if i in region.moving else 0 for i, n in enumerate(region.shape)]
    spacing = [(region.upper[i] - region.lower[i]) / region.shape[i] or 1.0 for i in range(3)]
    arrays: dict[str, tuple[str, NDArray[Any]]] = {
        "value": ("Float64", found.value.astype("<f8")),
        "inside": ("UInt8", found.inside.astype(np.uint8)),
        "boundary": ("UInt8", found.boundary.astype(np.uint8)),
    }
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        f'<ImageData WholeExtent="{_extent(extents)}" Origin="{_words(region.lower)}" Spacing="{_words(spacing)}">',
        f'<Piece Extent="{_extent(extents)}">',
        '<CellData Scalars="value">',
    ]
    for name, (kind, array) in arrays.items():
        content = array.tobytes(order="F")
        packed = base64.b64encode(len(content).to_bytes(8, "little") + content).decode()
        lines.append(f'<DataArray type="{kind}" Name="{name}" format="binary">{packed}</DataArray>')
    lines += ["</CellData>", "</Piece>", "</ImageData>", "</VTKFile>", ""]
    return "\n".join(lines).encode()


def ply(found: Workspace) -> bytes:
    """Return the surface as a mesh of triangles in binary PLY. Raises CdprError where it has none."""
    corners, triangles = surface(found)
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"comment {found.kind.name} workspace of {_one_word(found.robot)}, m\n"
        f"element vertex {len(corners)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    return head.encode() + corners.astype("<f8").tobytes() + faces.tobytes()


def csv(found: Workspace) -> bytes:
    """Return a table: x, y, z of the middle of each cell, m, its value, and whether it is inside."""
    region = found.region
    lines = ["x,y,z,value,inside"]
    for cells in region.pieces():
        places = region.positions(cells).tolist()
        values, inside = found.value.ravel()[cells].tolist(), found.inside.ravel()[cells].tolist()
        rows = zip(places, values, inside, strict=True)
        lines += [
            f"{x!r},{y!r},{z!r},{'' if value != value else repr(value)},{int(here)}" for (x, y, z), value, here in rows
        ]
    return ("\n".join(lines) + "\n").encode()


WRITERS: dict[str, Callable[[Workspace], bytes]] = {".vti": vti, ".ply": ply, ".csv": csv}


def export(found: Workspace, path: str | os.PathLike[str]) -> None:
    """Write a workspace in the format that the ending says. Raises OutputError, and CdprError for another ending."""
    target = Path(path)
    if target.suffix not in WRITERS:
        raise CdprError(f"{target}: a name that ends in {', '.join(WRITERS)} is expected")
    content = WRITERS[target.suffix](found)
    part = target.with_name(f".{target.name}.part")
    try:
        part.write_bytes(content)
        part.replace(target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise unwritable(target, error) from error


def _extent(counts: list[int]) -> str:
    return " ".join(f"0 {n}" for n in counts)


def _words(values: NDArray[np.float64] | list[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _one_word(name: str) -> str:
    return "".join(letter if letter.isprintable() and letter.isascii() else "_" for letter in name)
