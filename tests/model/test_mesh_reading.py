"""Time that reading a mesh or a program may take."""

from __future__ import annotations

from dataclasses import replace

import pytest
from command_line import cdpr_here
from conftest import ROOT

from cdpr.base.files import ContentError, UnreadableError
from cdpr.gcode import path as gcode_path
from cdpr.gcode.program import parse_program
from cdpr.scenario import mesh


def test_lines_of_obj_files_may_be_long(tmp_path, monkeypatch):
    """It is joined once: the square of its length would be minutes. Time is counted in checks, not measured."""
    path = tmp_path / "long.obj"
    corners = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v \\\n" + "\\\n" * 200_000 + "0 0 1"]
    path.write_text("\n".join(corners) + "\n")
    assert mesh.box_around(str(path)) == ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    times = iter(range(0, 1000, 4))
    monkeypatch.setattr("cdpr.base.files.time.thread_time", lambda: float(next(times)))
    path.write_text("\n".join(corners) + "\n\n")
    with pytest.raises(UnreadableError, match=r"reading it takes more than 10 s of CPU time: simplify it"):
        mesh.box_around(str(path))


def clock(monkeypatch, step):
    """Let each question for the CPU time take `step` seconds."""
    times = iter(range(0, 10**6, step))
    monkeypatch.setattr("cdpr.base.files.time.thread_time", lambda: float(next(times)))


@pytest.mark.parametrize("line", [b"M5\n", b"\n", b"(idle)\n", b"M5\n\n"])
def test_a_program_of_idle_lines_is_given_up(monkeypatch, line):
    """Only moves are limited in number: 32 MiB of other lines would take minutes, with or without words."""
    clock(monkeypatch, 6)
    with pytest.raises(ContentError) as caught:
        parse_program(line * 5000, "linuxcnc", "mm", ())
    assert caught.value.faults == [(2000, 0, "reading it takes more than 10 s of CPU time: divide the file")]


ZIGZAG = "G21 G90 F600\n" + "".join(f"G1 X{k % 50} Y{k % 2} Z1200\n" for k in range(2500))
SCENARIO = """robot: caroca.yaml
simulation: {duration: 1.0}
initial: {position: [0, 0, 1.2]}
trajectory: {type: gcode, file: a.ngc, tolerance: 0.001, limits: {velocity: 1.0, acceleration: 2.0, jerk: 20}}
controller: {type: computed_torque, kp: 100, kd: 20}
"""


def test_reading_and_planning_a_program_share_one_budget(tmp_path, monkeypatch):
    """Following lines takes less than 10 s on this clock, after reading for 7 s more; planning has 60 s in all."""
    (tmp_path / "a.ngc").write_text(ZIGZAG)
    (tmp_path / "caroca.yaml").write_bytes((ROOT / "scenarios" / "robots" / "caroca.yaml").read_bytes())
    (tmp_path / "s.yaml").write_text(SCENARIO)
    program = parse_program(ZIGZAG.encode(), "linuxcnc", "mm", ())
    placing = gcode_path.Placing((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 1.0)
    clock(monkeypatch, 4)
    gcode_path.build_path(program, placing, (0.0, 0.0, 1.2), 0.001)
    with pytest.raises(ContentError) as caught:
        gcode_path.build_path(replace(program, spent=7.0), placing, (0.0, 0.0, 1.2), 0.001)
    assert caught.value.faults == [(1001, 0, "reading it takes more than 10 s of CPU time: divide the file")]
    monkeypatch.undo()
    cdpr_here("validate", tmp_path / "s.yaml")
    laid = gcode_path.build_path
    monkeypatch.setattr(gcode_path, "build_path", lambda *arguments: replace(laid(*arguments), spent=60.0))
    said = cdpr_here("validate", tmp_path / "s.yaml", code=2).stderr
    assert "'a.ngc': reading it takes more than 60 s of CPU time: divide the file" in said


def test_reading_a_mesh_and_its_hull_share_one_budget(tmp_path, monkeypatch):
    """On this clock 20 000 lines take 8 s of the 10 s, and the hull has two seconds left."""
    path = tmp_path / "cube.obj"
    corners = [f"v {x} {y} {z}" for x in (0, 2) for y in (0, 2) for z in (0, 2)]
    path.write_text("\n".join([*corners, "\n" * 20_000]))
    clock(monkeypatch, 4)
    assert mesh.box_around(str(path)) == ((0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
    with pytest.raises(UnreadableError, match="more than 10 s of CPU time: simplify it"):
        mesh.hull_of(str(path))
