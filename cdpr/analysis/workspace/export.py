"""Export of workspaces: VTI and VTU for ParaView, PLY for mesh viewers, CSV for tables."""

from __future__ import annotations

import base64
import os
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.workspace.result import Workspace
from cdpr.analysis.workspace.surface import surface
from cdpr.analysis.workspace.turns import Turns
from cdpr.base.errors import CdprError
from cdpr.log.files import replace

BLOCK = 2**20  # size of a compressed block, bytes
LEVEL = 6  # zlib level, identical in all its versions


def vti(found: Workspace) -> bytes:
    """Return a VTK image: value, inside, boundary and turns of each cell (VTK file formats, XML, inline binary)."""
    region = found.region
    extents = [n if i in region.moving else 0 for i, n in enumerate(region.shape)]
    spacing = [(region.upper[i] - region.lower[i]) / region.shape[i] or 1.0 for i in range(3)]
    arrays: dict[str, tuple[str, NDArray[Any]]] = {
        "value": ("Float64", found.value.astype("<f8")),
        "inside": ("UInt8", found.inside.astype(np.uint8)),
        "boundary": ("UInt8", found.boundary.astype(np.uint8)),
    }
    if isinstance(found.detail, Turns):
        arrays |= {"turn_least": ("Float64", found.detail.least), "turn_most": ("Float64", found.detail.most)}
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


# VTK types of 1D, 2D and 3D cells whose corners are ordered by coordinates.
BOX_TYPES = {1: 3, 2: 8, 3: 11}
MOST_BOXES = 4_000_000  # limit of one file; writing takes a gigabyte of memory


def vtu(found: Workspace) -> bytes:
    """Return the boxes of a certified workspace as an unstructured VTK grid: 1 inside, -1 outside, 0 undecided.

    Raises:
        CdprError: if there are none or too many.
    """
    if found.proofs is None:
        raise CdprError("a .vtu file requires boxes of --method certify; write other workspaces as .vti")
    if len(found.proofs.level) > MOST_BOXES:
        raise CdprError(
            f"{len(found.proofs.level)} boxes are more than {MOST_BOXES}, which a .vtu file may hold: "
            "let more --undecided, or choose a smaller box"
        )
    low, high = found.proofs.corners()
    moving, count = found.region.moving, len(low)
    corners = np.repeat(low[:, None], 2 ** len(moving), axis=1)
    for k, axis in enumerate(moving):
        upper = (np.arange(corners.shape[1]) >> k) & 1 == 1
        corners[:, upper, axis] = high[:, None, axis]
    points = corners.reshape(-1, 3).astype("<f4")
    ends = corners.shape[1] * np.arange(1, count + 1, dtype="<i8")
    cells = {
        "connectivity": ("Int64", np.arange(len(points), dtype="<i8")),
        "offsets": ("Int64", ends),
        "types": ("UInt8", np.full(count, BOX_TYPES[len(moving)], dtype=np.uint8)),
    }
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64" '
        'compressor="vtkZLibDataCompressor">',
        "<UnstructuredGrid>",
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">',
        "<Points>",
        f'<DataArray type="Float32" NumberOfComponents="3" format="binary">{_compressed(points)}</DataArray>',
        "</Points>",
        "<Cells>",
        *(
            f'<DataArray type="{kind}" Name="{name}" format="binary">{_compressed(array)}</DataArray>'
            for name, (kind, array) in cells.items()
        ),
        "</Cells>",
        '<CellData Scalars="proved">',
        '<DataArray type="Int8" Name="proved" format="binary">'
        f"{_compressed(found.proofs.proved.astype(np.int8))}</DataArray>",
        "</CellData>",
        "</Piece>",
        "</UnstructuredGrid>",
        "</VTKFile>",
        "",
    ]
    return "\n".join(lines).encode()


def _compressed(array: NDArray[Any]) -> str:
    """Return an array in VTK's compressed blocks: number, size, size of the last, compressed sizes, and the blocks."""
    content = array.tobytes()
    blocks = [content[first : first + BLOCK] for first in range(0, len(content), BLOCK)]
    packed = [zlib.compress(block, LEVEL) for block in blocks]
    last = len(blocks[-1]) % BLOCK if blocks else 0
    head = np.array([len(blocks), BLOCK, last, *map(len, packed)], dtype="<u8").tobytes()
    return base64.b64encode(head).decode() + base64.b64encode(b"".join(packed)).decode()


def ply(found: Workspace) -> bytes:
    """Return the surface as a triangle mesh in binary PLY.

    Raises:
        CdprError: if there is no surface.
    """
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
    """Return a table: x, y, z of the centre of each cell, m, its value, and 1 if it is inside."""
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


WRITERS: dict[str, Callable[[Workspace], bytes]] = {".vti": vti, ".vtu": vtu, ".ply": ply, ".csv": csv}


def export(found: Workspace, path: str | os.PathLike[str], force: bool = True) -> None:
    """Write a workspace in the format of the file name's ending; replace an existing file only with `force`.

    Raises:
        OutputError: if it cannot be written.
        CdprError: if the ending is unknown.
    """
    target = Path(path)
    if target.suffix not in WRITERS:
        raise CdprError(f"{target}: expected a name that ends in {', '.join(WRITERS)}")
    replace(target, WRITERS[target.suffix](found), force)


def _extent(counts: list[int]) -> str:
    return " ".join(f"0 {n}" for n in counts)


def _words(values: NDArray[np.float64] | list[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _one_word(name: str) -> str:
    return "".join(letter if letter.isprintable() and letter.isascii() else "_" for letter in name)
