"""Small files on a full disk: one error, and neither an empty file nor a part of one is left."""

from __future__ import annotations

import pytest
from click.testing import CliRunner
from full_disk import file_size_limit

from cdpr.base.errors import OutputError
from cdpr.formats.read.import_files import ImportResult, write
from cdpr.scenario import examples
from cdpr.ui.cli.new import command as new
from cdpr.ui.gui.editor import files


def left(folder):
    return [path for path in folder.rglob("*") if path.is_file()]


@pytest.mark.parametrize("room", [0, 300, 1250])
def test_examples(tmp_path, room):
    with pytest.raises(OutputError, match="cannot be written: File too large"), file_size_limit(room):
        examples.copy("caroca", tmp_path)
    assert left(tmp_path) == []


def test_new(tmp_path):
    with file_size_limit(100):
        done = CliRunner().invoke(new, ["robot", str(tmp_path / "robot.yaml")])
    assert isinstance(done.exception, OutputError)
    assert "cannot write" in str(done.exception)
    assert left(tmp_path) == []


def test_imports_over_older_files(tmp_path):
    """Those that are there stay as they are."""
    (tmp_path / "robot.yaml").write_text("older")
    with pytest.raises(OutputError, match="cannot be written"), file_size_limit(100):
        write(ImportResult("x", {"motion.yaml": "short", "robot.yaml": "long" * 100}), tmp_path, force=True)
    assert [path.name for path in left(tmp_path)] == ["robot.yaml"]
    assert (tmp_path / "robot.yaml").read_text() == "older"


def test_files_of_the_window(tmp_path):
    with pytest.raises(OutputError, match="cannot write"), file_size_limit(100):
        files.write(str(tmp_path / "a.yaml"), "x" * 1000, new=True)
    assert left(tmp_path) == []
    files.write(str(tmp_path / "a.yaml"), "x", new=True)
    with pytest.raises(OutputError, match="already exists"):
        files.write(str(tmp_path / "a.yaml"), "y", new=True)
    assert (tmp_path / "a.yaml").read_text() == "x"
