"""Files written in one step."""

from __future__ import annotations

import errno
import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from cdpr.base.errors import ExitCode, OutputError
from cdpr.log.files import ExistingFileError, make_folder, replace, replace_all, replacing, require_new


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


def test_both_of_two_results_with_one_name_are_kept(tmp_path):
    path = tmp_path / "race.npz"

    def second():
        require_new(path, force=False)
        with replacing(path, force=False) as file:
            file.write(b"second")
            replace(path, b"first", force=False)  # another process is faster

    with pytest.raises(ExistingFileError) as caught:
        second()
    assert str(caught.value) == (
        f"'{path}' was created meanwhile and is not overwritten; this result was written to '{tmp_path}/race-2.npz'"
    )
    assert caught.value.exit_code == ExitCode.NOT_WRITABLE
    with pytest.raises(ExistingFileError, match=r"/race-3\.npz'$"):
        replace(path, b"third", force=False)
    found = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert found == {"race.npz": "first", "race-2.npz": "second", "race-3.npz": "third"}


def test_file_systems_without_hard_links(tmp_path, monkeypatch):
    def link(*_):
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "link", link)
    replace(tmp_path / "file", "first", force=False)
    with pytest.raises(ExistingFileError, match=r"was written to '.*/file-2'"):
        replace(tmp_path / "file", "second", force=False)
    assert [(tmp_path / name).read_text() for name in sorted(os.listdir(tmp_path))] == ["first", "second"]


def test_all_files_of_a_result_are_kept(tmp_path):
    (tmp_path / "a.json").write_text("older")
    (tmp_path / "b.svg").write_text("older")
    with pytest.raises(ExistingFileError, match=r"a-2\.json'\n.*b-2\.svg'"):
        replace_all(tmp_path, {"a.json": "1", "b.svg": b"2", "c": "3"}, force=False)
    found = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert found == {"a.json": "older", "b.svg": "older", "a-2.json": "1", "b-2.svg": "2", "c": "3"}


def test_folders_and_devices_are_not_replaced(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    for force in (False, True):
        for name, kind in (("", "a folder"), ("link", "a folder"), ("pipe", "not a regular file")):
            with pytest.raises(OutputError, match=f"is {kind}; choose another name$"):
                require_new(tmp_path / name, force)
    with pytest.raises(OutputError, match=r"cannot be written: it is a folder$"):
        replace(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink()


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
    with pytest.raises(ExistingFileError, match=r"ü{40}-2'$"):
        replace(path, "y", force=False)
