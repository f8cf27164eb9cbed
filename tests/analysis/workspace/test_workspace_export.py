"""Workspaces in files of others: read again by other means, and a surface that is closed."""

from __future__ import annotations

import base64
import csv
import itertools
import os
import zlib
from collections import Counter
from xml.etree import ElementTree

import numpy as np
import pytest
from workspace_cases import cli, robot_of

from cdpr.analysis.workspace import result
from cdpr.analysis.workspace.combine import combine
from cdpr.analysis.workspace.export import export
from cdpr.analysis.workspace.regions import region
from cdpr.analysis.workspace.result import Workspace, workspace
from cdpr.analysis.workspace.surface import TETRAHEDRA, surface
from cdpr.base.errors import CdprError, OutputError


@pytest.fixture(scope="module")
def cogiro():
    robot = robot_of("cogiro")
    return workspace(robot, "static", region(robot, cells=14))


def volume(corners, triangles):
    """Of a closed surface, by the divergence theorem."""
    a, b, c = np.moveaxis(corners[triangles], 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def closed(triangles):
    """Return True if each edge is passed equally often in both directions."""
    edges = Counter(itertools.chain.from_iterable(itertools.pairwise([*t, t[0]]) for t in triangles.tolist()))
    return all(edges[b, a] == count for (a, b), count in edges.items())


def ball(shape=(24, 20, 18), radius=0.9, empty=False):
    """A workspace whose values are those of a ball, in a box of 2 x 2 x 2 m."""
    robot = robot_of("caroca")
    place = region(robot, lower=[-1, -1, -1], upper=[1, 1, 1], cells=list(shape))
    found = workspace(robot, "static", place)
    x, y, z = np.meshgrid(*place.axes, indexing="ij")
    value = radius - np.sqrt(x**2 + y**2 + z**2)
    if empty:
        value[:] = -1.0
    nothing = np.zeros(shape, dtype=bool)
    return Workspace(found.kind, "a ball", place, value, value >= 0.0, nothing, found.limit, ~nothing, found.about)


def test_a_cube_is_cut_into_tetrahedra_of_the_same_size():
    assert len(TETRAHEDRA) == 6
    assert all(corners[0] == 0 and corners[3] == 7 for corners in TETRAHEDRA)


def test_the_surface_of_a_ball_is_closed_and_encloses_it():
    corners, triangles = surface(ball())
    assert closed(triangles)
    assert volume(corners, triangles) == pytest.approx(4.0 / 3.0 * np.pi * 0.9**3, rel=0.01)
    away = np.linalg.norm(corners, axis=1)
    assert away.min() > 0.88  # between middles 0.1 m apart, linearly
    assert away.max() < 0.91


def test_a_full_box_is_that_box():
    full = ball(radius=9.0)
    corners, triangles = surface(full)
    assert closed(triangles)
    assert corners.min(axis=0) == pytest.approx([-1.0] * 3)
    assert corners.max(axis=0) == pytest.approx([1.0] * 3)
    assert 7.9 < volume(corners, triangles) < 8.0  # its edges are bevelled by half a cell


@pytest.mark.parametrize("radius", [0.05, 0.5, 1.2])
def test_the_surface_is_closed_for_any_cells(radius):
    _, triangles = surface(ball((7, 5, 9), radius))
    assert closed(triangles)


def test_any_cells_make_a_closed_surface_without_values():
    one = ball((6, 6, 6))
    inside = np.random.default_rng(0).random((6, 6, 6)) < 0.5
    mixed = Workspace(
        one.kind,
        "mixed",
        one.region,
        np.full((6, 6, 6), np.nan),
        inside,
        one.boundary,
        one.limit,
        one.evaluated,
        one.about,
    )
    corners, triangles = surface(mixed)
    assert closed(triangles)
    assert 0.0 < volume(corners, triangles) < 8.0


def test_of_nothing_there_is_no_triangle(tmp_path):
    corners, triangles = surface(ball(empty=True))
    assert len(corners) == len(triangles) == 0
    export(ball(empty=True), tmp_path / "w.ply")
    assert b"element face 0" in (tmp_path / "w.ply").read_bytes()


def test_its_volume_is_nearly_that_of_the_cells(cogiro):
    corners, triangles = surface(cogiro)
    assert closed(triangles)
    assert volume(corners, triangles) == pytest.approx(cogiro.volume, rel=0.1)


def test_vti(tmp_path, cogiro):
    export(cogiro, tmp_path / "w.vti")
    root = ElementTree.parse(tmp_path / "w.vti").getroot()
    image = root.find("ImageData")
    assert [int(n) for n in image.get("WholeExtent").split()][1::2] == list(cogiro.region.shape)
    assert [float(n) for n in image.get("Origin").split()] == cogiro.region.lower.tolist()
    spacing = [float(n) for n in image.get("Spacing").split()]
    assert cogiro.region.lower + np.array(spacing) * cogiro.region.shape == pytest.approx(cogiro.region.upper)
    read = {}
    for array in image.iter("DataArray"):
        content = base64.b64decode(array.text)
        size = int.from_bytes(content[:8], "little")
        assert size == len(content) - 8
        kind = {"Float64": "<f8", "UInt8": "u1"}[array.get("type")]
        read[array.get("Name")] = np.frombuffer(content[8:], kind).reshape(cogiro.region.shape, order="F")
    assert np.array_equal(read["value"], cogiro.value, equal_nan=True)
    assert np.array_equal(read["inside"], cogiro.inside)


def unpacked(text):
    """An array's bytes from its text, in compressed blocks."""
    head = base64.b64decode(text)[:24]
    blocks, size, last = np.frombuffer(head, "<u8").tolist()
    cut = 4 * ((8 * (3 + blocks) + 2) // 3)
    sizes = np.frombuffer(base64.b64decode(text[:cut]), "<u8")[3:].tolist()
    body, content = base64.b64decode(text[cut:]), []
    for each in sizes:
        content.append(zlib.decompress(body[:each]))
        body = body[each:]
    assert not body
    assert {len(each) for each in content[:-1]} <= {size}
    assert len(content[-1]) % size == last
    return b"".join(content)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind", "corners"), [("cogiro", 11, 8), ("planar", 8, 4)])
def test_vtu(tmp_path, name, kind, corners):
    robot = robot_of(name)
    found = workspace(robot, "static", region(robot, cells=3), method="certify", undecided=0.5)
    export(found, tmp_path / "w.vtu")
    root = ElementTree.parse(tmp_path / "w.vtu").getroot()
    kinds = {"Float32": "<f4", "Int64": "<i8", "UInt8": "u1", "Int8": "i1"}
    read = {
        each.get("Name", "points"): np.frombuffer(unpacked(each.text), kinds[each.get("type")])
        for each in root.iter("DataArray")
    }
    count = len(found.proofs.level)
    assert [int(root.find(".//Piece").get(key)) for key in ("NumberOfPoints", "NumberOfCells")] == [
        corners * count,
        count,
    ]
    assert np.array_equal(read["proved"], found.proofs.proved)
    assert np.array_equal(read["offsets"], corners * np.arange(1, count + 1))
    assert set(read["types"].tolist()) == {kind}
    places = read["points"].reshape(-1, 3)[read["connectivity"]].reshape(count, corners, 3)
    low, high = found.proofs.corners()
    assert places[:, 0] == pytest.approx(low, abs=1e-5)
    assert places[:, -1] == pytest.approx(high, abs=1e-5)
    moving = found.region.moving
    assert np.ptp(places[:, :2], axis=1)[:, moving[0]] == pytest.approx((high - low)[:, moving[0]], abs=1e-5)


def test_only_proofs_have_boxes(tmp_path, cogiro):
    with pytest.raises(CdprError, match="boxes of --method certify"):
        export(cogiro, tmp_path / "w.vtu")


def test_ply(tmp_path, cogiro):
    export(cogiro, tmp_path / "w.ply")
    head, _, body = (tmp_path / "w.ply").read_bytes().partition(b"end_header\n")
    counts = {
        line.split()[1]: int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")
    }
    corners = np.frombuffer(body[: 24 * counts["vertex"]], "<f8").reshape(-1, 3)
    faces = np.frombuffer(body[24 * counts["vertex"] :], [("n", "u1"), ("corners", "<i4", 3)])
    assert len(faces) == counts["face"]
    assert set(faces["n"].tolist()) == {3}
    expected = surface(cogiro)
    assert np.array_equal(corners, expected[0])
    assert np.array_equal(faces["corners"], expected[1])


def test_csv(tmp_path, cogiro):
    export(cogiro, tmp_path / "w.csv")
    with (tmp_path / "w.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == cogiro.region.cells
    places = np.array([[float(row[axis]) for axis in "xyz"] for row in rows])
    assert np.array_equal(places, cogiro.region.positions(np.arange(cogiro.region.cells)))
    values = np.array([float(row["value"] or "nan") for row in rows])
    assert np.array_equal(values, cogiro.value.ravel(), equal_nan=True)
    assert [row["inside"] == "1" for row in rows] == cogiro.inside.ravel().tolist()


@pytest.mark.parametrize("ending", ["vti", "ply", "csv"])
def test_the_same_workspace_makes_the_same_bytes(tmp_path, cogiro, ending):
    for name in ("a", "b"):
        export(cogiro, tmp_path / f"{name}.{ending}")
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


def test_in_a_plane_there_are_cells_and_no_surface(tmp_path):
    robot = robot_of("planar")
    found = workspace(robot, "static", region(robot, cells=9))
    export(found, tmp_path / "w.vti")
    extent = ElementTree.parse(tmp_path / "w.vti").getroot().find("ImageData").get("WholeExtent")
    assert extent.split()[2:4] == ["0", "0"]
    with pytest.raises(CdprError, match="a surface needs a workspace with three directions, this one has 2"):
        export(found, tmp_path / "w.ply")
    assert [file.name for file in tmp_path.iterdir()] == ["w.vti"]


def test_of_two_workspaces_the_surface_is_half_way(cogiro):
    both = combine(cogiro, "and", cogiro)
    corners, triangles = surface(both)
    assert closed(triangles)
    assert volume(corners, triangles) == pytest.approx(cogiro.volume, rel=0.1)


@pytest.mark.slow
def test_the_command_and_its_errors(tmp_path, cogiro):
    cogiro.save(tmp_path / "w.npz")
    done = cli("workspace", "export", tmp_path / "w.npz", "--out", tmp_path / "new" / "w.vti")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'new' / 'w.vti'}\n")
    done = cli("workspace", "export", tmp_path / "w.npz", "--out", tmp_path / "w.stl")
    assert done.returncode == 2
    assert done.stderr.strip() == f"{tmp_path / 'w.stl'}: expected a name that ends in .vti, .vtu, .ply, .csv"
    with pytest.raises(OutputError):
        export(cogiro, tmp_path / "no such folder" / "w.csv")


def test_interrupted_saves_leave_nothing(cogiro, tmp_path, monkeypatch):
    def interrupt(file):
        raise KeyboardInterrupt

    monkeypatch.setattr(result, "seal_archive", interrupt)
    with pytest.raises(KeyboardInterrupt):
        cogiro.save(tmp_path / "w.npz")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["w.npz", "w.csv"])
def test_special_files_are_not_replaced(cogiro, tmp_path, name):
    os.mkfifo(tmp_path / name)
    write = cogiro.save if name.endswith(".npz") else lambda path: export(cogiro, path)
    with pytest.raises(OutputError, match="it is not a regular file"):
        write(tmp_path / name)
    assert (tmp_path / name).is_fifo()


def test_names_may_have_the_length_that_the_file_system_allows(cogiro, tmp_path):
    name = "n" * 251 + ".npz"
    cogiro.save(tmp_path / name)
    assert os.listdir(tmp_path) == [name]
