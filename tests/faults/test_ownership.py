"""Compiled code in caches is used only if it is intact and no other user can have written it."""

from __future__ import annotations

import grp
import os
import pwd
import stat

import pytest

from cdpr.base import ownership
from cdpr.base.errors import OutputError
from cdpr.fmu.export import archive
from cdpr.fmu.export import library as exported

STRANGER = 12345
ROOT_ONLY = pytest.mark.skipif(os.geteuid() != 0, reason="gives files to another user")
SOURCE = {"cdpr.cpp": b"int cdpr() { return 1; }\n"}


def given_away(path):
    os.chown(path, STRANGER, STRANGER)


def open_to_all(path):
    path.chmod(0o666)


def cut(path):
    path.write_bytes(path.read_bytes()[:1000])


def replaced_by_a_link(path):
    path.unlink()
    path.symlink_to("/dev/null")


SPOILT = [pytest.param(given_away, marks=ROOT_ONLY), open_to_all, cut, replaced_by_a_link]


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "cdpr" / "fmu"


@pytest.mark.parametrize("spoil", SPOILT)
def test_a_library_that_is_not_ours_or_not_whole_is_compiled_again(cache, spoil):
    whole = exported.library(SOURCE)
    (path,) = cache.glob("*.so")
    spoil(path)
    with pytest.warns(UserWarning, match=r"\.so.*: it is not used, and compiled again"):
        assert exported.library(SOURCE) == whole
    assert exported.library(SOURCE) == whole
    (path,) = cache.glob("*.so")
    assert ownership.fault(path) == ""


@pytest.mark.parametrize("spoil", SPOILT)
def test_an_fmu_that_is_not_ours_or_not_whole_is_made_again(cache, monkeypatch, spoil):
    monkeypatch.setattr(archive, "fmu_bytes", lambda model, fmi: bytes(5000))
    path = archive.cached_fmu(None)
    spoil(path)
    with pytest.warns(UserWarning, match=r"\.fmu.*: it is replaced by a new one"):
        assert archive.cached_fmu(None).read_bytes() == bytes(5000)
    assert ownership.fault(path) == ""


@ROOT_ONLY
@pytest.mark.parametrize("which", ["cdpr", "cdpr/fmu"])
def test_a_folder_of_another_user_is_no_cache(cache, tmp_path, which):
    exported.library(SOURCE)
    given_away(tmp_path / which)
    with pytest.raises(OutputError, match=r"belongs to another user.*XDG_CACHE_HOME"):
        exported.library(SOURCE)


def test_a_folder_on_the_way_that_others_may_write_to_is_no_cache(cache, tmp_path):
    tmp_path.chmod(0o777)
    with pytest.raises(OutputError, match=r"others may write to .* \(chmod go-w\)"):
        exported.library(SOURCE)
    tmp_path.chmod(0o1777)  # as /tmp: others cannot replace what is in it
    assert exported.library(SOURCE)


def test_our_own_folders_become_private(cache):
    exported.library(SOURCE)
    cache.chmod(0o777)
    exported.library(SOURCE)
    assert stat.S_IMODE(cache.stat().st_mode) == 0o755


def test_folders_are_private_whatever_the_umask(tmp_path):
    before = os.umask(0)
    try:
        ownership.make_private(tmp_path / "a" / "b" / "c", tmp_path / "a")
    finally:
        os.umask(before)
    assert ownership.fault(tmp_path / "a" / "b" / "c") == ""


def test_a_link_is_as_good_as_where_it_leads(tmp_path):
    open_folder = tmp_path / "open"
    open_folder.mkdir()
    (open_folder / "file").touch()
    open_folder.chmod(0o777)
    (tmp_path / "link").symlink_to(open_folder)
    assert "others may write to" in ownership.fault(tmp_path / "link" / "file")


@pytest.fixture
def without_root(tmp_path, monkeypatch):
    """A user namespace that maps one user, no root: files of the system's root appear to belong to another user."""
    for name, text in (("UID_MAP", "      1000       1000          1\n"), ("OVERFLOW", f"{STRANGER}\n")):
        monkeypatch.setattr(ownership, name, tmp_path / name)
        (tmp_path / name).write_text(text)


@ROOT_ONLY
def test_folders_of_a_root_that_is_not_mapped_may_lie_above_the_own_folder(tmp_path, without_root):
    file = tmp_path / "system" / "own" / "file"
    file.parent.mkdir(parents=True)
    file.touch()
    given_away(tmp_path / "system")
    assert ownership.fault(file) == ownership.fault(file.parent) == ""
    (tmp_path / "system").chmod(0o777)
    assert "others may write to" in ownership.fault(file)
    (tmp_path / "system").chmod(0o755)
    given_away(file.parent)
    assert "own belongs to another user" in ownership.fault(file)
    assert "own belongs to another user" in ownership.fault(file.parent)


@ROOT_ONLY
@pytest.mark.parametrize("rows", ["0 0 4294967295", "1000 1000 1\n0 100000 1000", "", "what is this"])
def test_the_overflow_user_is_untrusted_with_mapped_root(tmp_path, without_root, rows):
    ownership.UID_MAP.write_text(rows)
    (tmp_path / "system" / "own").mkdir(parents=True)
    given_away(tmp_path / "system")
    assert "belongs to another user" in ownership.fault(tmp_path / "system" / "own")


@pytest.mark.parametrize(
    ("group", "members", "primary", "private"),
    [
        ("ann", [], [("ann", 1000)], True),
        ("ann", ["ann"], [("ann", 1000)], True),
        ("users", [], [("ann", 1000)], False),
        ("ann", ["ben"], [("ann", 1000)], False),
        ("ann", [], [("ann", 1000), ("ben", 1000)], False),
        ("ann", [], [("ann", 100)], False),
    ],
)
def test_a_group_of_one_user_is_that_user(tmp_path, monkeypatch, group, members, primary, private):
    gid, uid = tmp_path.stat().st_gid, os.geteuid()
    users = [
        pwd.struct_passwd((name, "x", uid + i, gid if number == 1000 else gid + 1, "", "/", "/bin/sh"))
        for i, (name, number) in enumerate(primary)
    ]
    monkeypatch.setattr(pwd, "getpwuid", lambda number: users[number - uid])
    monkeypatch.setattr(pwd, "getpwall", lambda: users)
    monkeypatch.setattr(grp, "getgrgid", lambda number: grp.struct_group((group, "x", number, members)))
    ownership._is_private_group.cache_clear()
    (tmp_path / "cache").mkdir()
    tmp_path.chmod(0o775)  # as ~/.cache with umask 002
    found = ownership.fault(tmp_path / "cache")
    tmp_path.chmod(0o777)
    everyone = ownership.fault(tmp_path / "cache")
    ownership._is_private_group.cache_clear()
    assert (found == "") == private
    assert "others may write to" in everyone
