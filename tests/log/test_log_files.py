"""Files written in one step."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from cdpr.base.errors import OutputError
from cdpr.log.files import make_folder, replace, replacing, require_new


@pytest.mark.parametrize("content", ["größer\n", b"gr\xc3\xb6\xc3\x9fer\n"])
def test_a_file_is_replaced(tmp_path, content):
    path = tmp_path / "file"
    path.write_text("older and longer than the new one")
    replace(path, content)
    assert path.read_bytes() == b"gr\xc3\xb6\xc3\x9fer\n"
    assert os.listdir(tmp_path) == ["file"]


def test_failed_writes_keep_the_older_file(tmp_path):
    path = tmp_path / "file"
    path.write_text("older")

    def half():
        with replacing(path) as file:
            file.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert path.read_text() == "older"
    assert os.listdir(tmp_path) == ["file"]


def test_blocking_files_are_reported(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "folder", tmp_path / "none" / "file", tmp_path / "file" / "inside"):
        with pytest.raises(OutputError, match=f"{path}: cannot be written: "):
            replace(path, "text")
    with pytest.raises(OutputError, match=r"file: cannot be written: it is a file, not a folder$"):
        make_folder(tmp_path / "file")
    assert sorted(os.listdir(tmp_path)) == ["file", "folder"]


def test_special_files_are_not_replaced(tmp_path):
    """Such as /dev/null, by whoever may."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError, match="it is not a regular file"):
        replace(tmp_path / "pipe", "text")
    assert (tmp_path / "pipe").is_fifo()


def test_links_without_a_file_are_kept(tmp_path):
    """A file would replace the link, not its missing target."""
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "none")
    with pytest.raises(OutputError, match="already exists and is not overwritten"):
        require_new(link, force=False)
    require_new(link, force=True)
    require_new(tmp_path / "none", force=False)


def test_threads_that_write_the_same_file_do_not_mix(tmp_path):
    path, texts = tmp_path / "file.yaml", [letter * 2_000_000 for letter in "abcd"]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda text: replace(path, text), texts * 5))
    assert path.read_text() in texts
    assert os.listdir(tmp_path) == ["file.yaml"]


def test_names_as_long_as_the_file_system_allows(tmp_path):
    path = tmp_path / ("ü" * 127)
    replace(path, "x")
    assert path.read_text() == "x"
    with pytest.raises(OutputError, match="cannot be written: File name too long"):
        replace(tmp_path / ("a" * 256), "x")
