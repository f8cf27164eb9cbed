"""Time that reading a mesh or a program may take."""

from __future__ import annotations

import pytest

from cdpr.scenario import mesh
from cdpr.scenario.files import UnreadableError
from cdpr.scenario.motions.gcode_program import parse_program
from cdpr.scenario.motions.table import TableError


def test_a_line_of_an_obj_file_may_go_on_for_long(tmp_path, monkeypatch):
    """It is joined once: the square of its length would be minutes. Time is counted in checks, not measured."""
    path = tmp_path / "long.obj"
    corners = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v \\\n" + "\\\n" * 200_000 + "0 0 1"]
    path.write_text("\n".join(corners) + "\n")
    assert mesh.box_around(str(path)) == ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    times = iter(range(0, 1000, 4))
    monkeypatch.setattr("cdpr.scenario.files.time.thread_time", lambda: float(next(times)))
    path.write_text("\n".join(corners) + "\n\n")
    with pytest.raises(UnreadableError, match=r"reading it takes more than 10 s of CPU time: simplify it"):
        mesh.box_around(str(path))


def test_a_program_of_idle_lines_is_given_up(monkeypatch):
    """Only moves are limited in number: 32 MiB of other lines would take minutes."""
    times = iter(range(0, 1000, 6))
    monkeypatch.setattr("cdpr.scenario.motions.gcode_program.time.thread_time", lambda: float(next(times)))
    with pytest.raises(TableError) as caught:
        parse_program(b"M5\n" * 5000, "linuxcnc", "mm", ())
    assert caught.value.faults == [(2000, 0, "reading it takes more than 10 s of CPU time: divide the file")]
