"""Trust in native code."""

from __future__ import annotations

import hashlib
import multiprocessing
import os

import pytest
from fmu_cases import ELF, make_fmu

from cdpr.base import ownership
from cdpr.base.errors import FmuError, OutputError
from cdpr.fmu.export import archive
from cdpr.fmu.read import trust
from cdpr.fmu.read.archive import open_archive
from cdpr.log.files import ExistingFileError


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    before = os.umask(0o022)
    yield tmp_path
    os.umask(before)


@pytest.fixture
def plant(home):
    return open_archive(make_fmu(home / "plant.fmu"))


def test_untrusted_code_is_rejected_with_a_remedy(plant):
    with pytest.raises(FmuError) as caught:
        trust.require_trust(plant, None)
    told = str(caught.value)
    assert f"\n  sha256: {plant.sha256}\n" in told
    assert f"cdpr fmu trust {plant.path}" in told
    assert "--trust-fmu" in told


def test_the_pin_of_the_scenario_is_enough(plant):
    trust.require_trust(plant, plant.sha256)
    trust.require_trust(plant, plant.sha256.upper())


def test_another_pin_is_refused_even_where_all_is_trusted(plant):
    trust.add(plant.sha256, "plant")
    with trust.any_fmu(), pytest.raises(FmuError, match="not the file that the scenario pins"):
        trust.require_trust(plant, "0" * 64)


def test_trust_for_a_run_ends_with_it(plant):
    with trust.any_fmu():
        trust.require_trust(plant, None)
    with pytest.raises(FmuError):
        trust.require_trust(plant, None)


def test_the_list_trusts_content_not_names(home, plant):
    trust.add(plant.sha256, "plant.fmu")
    trust.require_trust(plant, None)
    changed = open_archive(make_fmu(home / "plant.fmu", library=ELF + b"evil"))
    with pytest.raises(FmuError, match="contains native code"):
        trust.require_trust(changed, None)


def test_the_list_is_text_in_the_users_configuration(home, plant):
    trust.add(plant.sha256, "my plant ä\nevil.fmu")
    trust.add("0" * 64, "other")
    trust.add(plant.sha256, "again")
    path = home / "config/cdpr/trusted_fmus"
    assert path == trust.list_path()
    assert trust.trusted() == {plant.sha256: r"my plant ä\nevil.fmu", "0" * 64: "other"}
    assert path.read_text().startswith("# ")
    trust.remove(plant.sha256)
    assert trust.trusted() == {"0" * 64: "other"}
    assert sorted(each.name for each in path.parent.iterdir()) == ["trusted_fmus", "trusted_fmus.lock"]


def test_without_xdg_it_lies_in_the_home(home, monkeypatch):
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setenv("HOME", str(home))
    assert trust.list_path() == home / ".config/cdpr/trusted_fmus"


@pytest.mark.parametrize("line", ["plant.fmu", "0" * 63, "G" * 64, "0" * 64 + " one space", "0" * 65])
def test_a_malformed_list_is_reported_and_trusts_nothing(plant, line):
    path = trust.list_path()
    path.parent.mkdir(parents=True)
    path.write_text(f"# comment\n\n{plant.sha256}  plant\n{line}\n")
    with pytest.raises(FmuError, match=r"trusted_fmus:4: expected a sha256 and a name"):
        trust.require_trust(plant, None)
    with pytest.raises(FmuError, match=r"trusted_fmus:4:"):
        trust.add("1" * 64, "other")
    trust.require_trust(plant, plant.sha256)  # a pin does not need the list


def test_an_unreadable_list_is_reported(plant):
    trust.list_path().mkdir(parents=True)
    with pytest.raises(FmuError, match="cannot be read: Is a directory; correct or remove it"):
        trust.require_trust(plant, None)


def test_bytes_that_are_no_text_are_reported(plant):
    trust.list_path().parent.mkdir(parents=True)
    trust.list_path().write_bytes(b"\xff\xfe")
    with pytest.raises(FmuError, match="cannot be read"):
        trust.require_trust(plant, None)


def test_a_list_that_cannot_be_written_is_reported(home, plant):
    (home / "config").write_text("a file")
    with pytest.raises(FmuError, match="cannot be read: Not a directory"):
        trust.add(plant.sha256, "plant")
    (home / "config").unlink()
    (home / "config").mkdir()
    (home / "config/cdpr").symlink_to("/proc/self")
    with pytest.raises(OutputError, match="cannot be written"):
        trust.add(plant.sha256, "plant")


def _add_many(start, first):
    start.wait()
    for i in range(10):
        trust.add(f"{first + i:064x}", f"{first + i}.fmu")


@pytest.mark.slow
def test_lists_written_at_once_lose_nothing(home, monkeypatch):
    monkeypatch.setattr(trust, "LOCK_SECONDS", 60.0)  # whatever else the machine does
    context = multiprocessing.get_context("fork")
    start = context.Barrier(8)
    many = [context.Process(target=_add_many, args=(start, 100 * i)) for i in range(8)]
    for each in many:
        each.start()
    for each in many:
        each.join(60)
    assert [each.exitcode for each in many] == [0] * 8
    assert len(trust.trusted()) == 80


def test_a_list_that_others_keep_locked_is_reported(home, plant, monkeypatch):
    monkeypatch.setattr(trust, "LOCK_SECONDS", 0.05)
    with trust._locked(), pytest.raises(OutputError, match="has locked the list of trusted FMUs"):
        trust.add(plant.sha256, "plant")
    trust.add(plant.sha256, "plant")


def test_a_list_that_is_a_pipe_is_refused_at_once(plant):
    trust.list_path().parent.mkdir(parents=True)
    os.mkfifo(trust.list_path())
    with pytest.raises(FmuError, match="is not a regular file"):
        trust.require_trust(plant, None)
    with pytest.raises(FmuError, match="is not a regular file"):
        trust.add(plant.sha256, "plant")


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_list_that_others_may_write_is_refused(plant, mode, monkeypatch):
    monkeypatch.setattr(ownership, "_is_private_group", lambda gid, uid: False)
    trust.add(plant.sha256, "plant")
    path = trust.list_path()
    for each, words in ((path, "write to the list"), (path.parent, r"write to .*config/cdpr ")):
        before = each.stat().st_mode
        each.chmod(mode | before)
        with pytest.raises(FmuError, match=words):
            trust.require_trust(plant, None)
        each.chmod(before)
    trust.require_trust(plant, None)


def test_a_list_of_another_user_is_refused(plant, monkeypatch):
    trust.add(plant.sha256, "plant")
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    os.chown(trust.list_path(), 12345, -1) if os.getuid() == 0 else None
    with pytest.raises(FmuError, match="belongs to another user"):
        trust.require_trust(plant, None)


@pytest.mark.parametrize("umask", [0o000, 0o002, 0o077])
def test_a_list_is_for_its_user_alone_whatever_the_umask(plant, umask):
    before = os.umask(umask)
    try:
        trust.add(plant.sha256, "plant")
    finally:
        os.umask(before)
    assert trust.list_path().stat().st_mode & 0o777 == 0o600
    assert trust.list_path().parent.stat().st_mode & 0o777 == 0o700
    trust.require_trust(plant, None)


def test_a_list_replaced_while_it_is_read_is_read_whole(plant, monkeypatch):
    """The opened file is the one that is checked and read."""
    trust.add("1" * 64, "one")
    path, check = trust.list_path(), trust._fault

    def replaced(*about):
        other = path.with_name("other")
        other.write_text(f"{plant.sha256}  evil\n")
        other.replace(path)
        return check(*about)

    monkeypatch.setattr(trust, "_fault", replaced)
    assert trust.trusted() == {"1" * 64: "one"}


def test_a_huge_list_is_not_read(plant, monkeypatch):
    monkeypatch.setattr(trust, "MOST", 50)
    trust.add("1" * 64, "one")
    with pytest.raises(FmuError, match="more than"):
        trust.trusted()


def test_an_exported_fmu_under_a_second_name_is_trusted(home, monkeypatch):
    (home / "plant.fmu").write_text("of another process")
    monkeypatch.setattr("os.path.lexists", lambda _: False)  # created after the check
    monkeypatch.setattr(archive, "fmu_bytes", lambda *_: b"content")
    with pytest.raises(ExistingFileError, match=r"written to '.*plant-2\.fmu'"):
        archive.write_fmu(None, 3, home / "plant.fmu")
    assert hashlib.sha256((home / "plant-2.fmu").read_bytes()).hexdigest() in trust.trusted()
