"""Archives that were made to do harm: each is refused before anything is written or loaded."""

from __future__ import annotations

import contextlib
import os
import stat
import struct
import zipfile
import zlib

import pytest
from fmu_cases import ELF, description, make_fmu

from cdpr.base.errors import FmuError
from cdpr.base.problems import printable
from cdpr.fmu.read import archive as archives
from cdpr.fmu.read.archive import extract, library, open_archive


def refused(path, *words):
    with pytest.raises(FmuError) as caught:
        open_archive(path)
    told = str(caught.value)
    assert told.startswith(printable(f"{path}: "))
    for word in words:
        assert word in told
    return told


def entry(name, *, mode=0, content=b"x"):
    info = zipfile.ZipInfo("placeholder")
    info.filename = info.orig_filename = name
    info.external_attr = mode << 16
    return info, content


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_sound_archive_is_opened_and_extracted(tmp_path, fmi):
    path = make_fmu(tmp_path / "a plant ä.fmu", fmi=fmi, files={"resources/sub/data.txt": b"data", "sources/a.c": b""})
    opened = open_archive(path)
    assert opened.description.fmi == f"{fmi}.0"
    assert opened.description.sources
    folder = tmp_path / "here"
    folder.mkdir()
    found = extract(opened, folder)
    assert found.read_bytes() == ELF
    assert found.is_relative_to(folder)
    assert (folder / "resources/sub/data.txt").read_bytes() == b"data"


def test_a_file_replaced_after_it_was_checked_changes_nothing(tmp_path):
    path = make_fmu(tmp_path / "plant.fmu")
    opened = open_archive(path)
    make_fmu(path, library=ELF + b"other")
    (tmp_path / "out").mkdir()
    assert extract(opened, tmp_path / "out").read_bytes() == ELF


@pytest.mark.parametrize(
    "name",
    [
        "../../evil", "resources/../../evil", "..", "/etc/evil", "//host/evil", "C:/evil", "C:evil", "a\\..\\evil",
        "resources/./x", "resources//x", "line\nbreak", "bell\x07", "turned\u202e",
    ],
)  # fmt: skip
def test_names_that_lead_out_of_the_folder(tmp_path, name):
    refused(make_fmu(tmp_path / "a.fmu", entries=[entry(name)]), repr(name), "not a plain path")


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR, stat.S_IFBLK, stat.S_IFSOCK])
def test_links_and_devices(tmp_path, kind):
    path = make_fmu(tmp_path / "a.fmu", entries=[entry("resources/link", mode=kind | 0o777, content=b"/etc/passwd")])
    refused(path, "resources/link", "a link or a device")


@pytest.mark.parametrize("identifier", ["../../../elsewhere/evil", "a/b", "a b", "", "1a", "ä", "a\n", "evil.so"])
def test_a_model_identifier_that_is_a_path(tmp_path, identifier):
    refused(make_fmu(tmp_path / "a.fmu", description(identifier=identifier)), "modelIdentifier", "C identifier")


def test_a_zip_bomb_by_ratio(tmp_path):
    path = make_fmu(tmp_path / "a.fmu", files={"resources/zeros": bytes(8 * 2**20)})
    assert path.stat().st_size < 20_000
    refused(path, "resources/zeros", "zip bomb")


def test_a_zip_bomb_by_total_size(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_TOTAL", 10_000)
    content = bytes(i * i % 251 for i in range(3000))
    refused(make_fmu(tmp_path / "a.fmu", files={f"resources/{i}": content for i in range(4)}), "unpack to")


def test_too_many_entries(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_ENTRIES", 10)
    refused(make_fmu(tmp_path / "a.fmu", files={f"resources/{i}": b"" for i in range(11)}), "entries")


def test_a_huge_table_of_contents_is_not_even_read(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_DIRECTORY", 1000)
    refused(make_fmu(tmp_path / "a.fmu", files={f"resources/{i:0100}": b"" for i in range(20)}), "table of contents")


def test_a_huge_file_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_FILE", 100)
    refused(make_fmu(tmp_path / "a.fmu"), "larger than")


def test_an_entry_that_holds_more_than_it_declares(tmp_path):
    """The declared sizes, which were checked, may lie."""
    path = make_fmu(tmp_path / "a.fmu", files={"resources/lie": bytes(100_000)})
    content = bytearray(path.read_bytes())
    # The uncompressed size is in the local header and in the table of contents.
    for signature, place in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        at = -1
        while (at := content.find(signature, at + 1)) >= 0:
            if struct.unpack_from("<I", content, at + place)[0] == 100_000:
                struct.pack_into("<I", content, at + place, 10)
    path.write_bytes(content)
    opened = open_archive(path)
    (tmp_path / "out").mkdir()
    with pytest.raises(FmuError, match="'resources/lie' is damaged"):
        extract(opened, tmp_path / "out")
    assert (tmp_path / "out/resources/lie").stat().st_size <= 10


def test_a_damaged_entry(tmp_path):
    path = make_fmu(tmp_path / "a.fmu", files={"resources/x": bytes(range(256)) * 4})
    content = bytearray(path.read_bytes())
    content[content.find(b"resources/x") + 30] ^= 0xFF
    path.write_bytes(content)
    (tmp_path / "out").mkdir()
    with pytest.raises(FmuError, match=r"'resources/x' is damaged"):
        extract(open_archive(path), tmp_path / "out")


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_two_entries_of_one_name(tmp_path):
    """Reference FMUs of Roberts hold one file twice: that is harmless, as long as both are the same."""
    twice = [entry("resources/x.txt", content=b"same"), entry("resources/x.txt", content=b"same")]
    path = make_fmu(tmp_path / "a.fmu", entries=twice)
    (tmp_path / "out").mkdir()
    extract(open_archive(path), tmp_path / "out")
    assert (tmp_path / "out/resources/x.txt").read_bytes() == b"same"
    other = [entry("resources/x.txt", content=b"same"), entry("resources/x.txt", content=b"else")]
    refused(make_fmu(tmp_path / "a.fmu", entries=other), "two entries 'resources/x.txt' that differ")
    path = make_fmu(tmp_path / "a.fmu", entries=[entry("modelDescription.xml", content=b"<other/>")])
    refused(path, "two entries 'modelDescription.xml' that differ")


def test_entries_of_one_name_and_checksum_that_differ(tmp_path):
    """A CRC is easily forged: contents are compared, not the data of the archive's directory."""
    one, two = b"plumless", b"buckeroo"  # both of CRC-32 0x4DDB0C25
    path = tmp_path / "a.fmu"
    assert zlib.crc32(one) == zlib.crc32(two)
    with pytest.warns(UserWarning, match="Duplicate"):
        make_fmu(path, entries=[entry("resources/x", content=one), entry("resources/x", content=two)])
    refused(path, "two entries 'resources/x' that differ")


def test_names_without_end(tmp_path):
    """A name of 30 000 folders once took 0.9 GB, and a directory has room for a hundred of them."""
    refused(make_fmu(tmp_path / "a.fmu", files={"resources/" + "d/" * 30_000 + "x": b""}), "60011 letters, more than")


def test_names_that_differ_by_case_are_two_files(tmp_path):
    path = make_fmu(tmp_path / "a.fmu", files={"resources/a": b"1", "resources/A": b"2"})
    (tmp_path / "out").mkdir()
    extract(open_archive(path), tmp_path / "out")
    assert [(tmp_path / "out/resources" / name).read_bytes() for name in "aA"] == [b"1", b"2"]


def test_a_file_that_is_also_a_folder(tmp_path):
    refused(make_fmu(tmp_path / "a.fmu", files={"resources": b"", "resources/x": b""}), "'resources'")


def test_an_encrypted_entry(tmp_path):
    path = make_fmu(tmp_path / "a.fmu")
    content = bytearray(path.read_bytes())
    at = content.rfind(b"PK\x01\x02")  # the library
    content[at + 8] |= 1
    path.write_bytes(content)
    refused(path, "encrypted")


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_unusual_compression(tmp_path, method):
    path = make_fmu(tmp_path / "a.fmu")
    with zipfile.ZipFile(path, "a", method) as archive:
        archive.writestr("resources/x", b"x")
    refused(path, "expected stored or deflated")


def test_no_model_description(tmp_path):
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    refused(path, "contains no modelDescription.xml")


@pytest.mark.parametrize("cut", [1, 10, 100, 400])
def test_a_truncated_file(tmp_path, cut):
    path = make_fmu(tmp_path / "a.fmu")
    path.write_bytes(path.read_bytes()[:-cut])
    refused(path, "zip file")


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x05\x06", bytes(1000), b"PK\x05\x06" + bytes(18)])
def test_rejected_zip_files(tmp_path, content):
    path = tmp_path / "a.fmu"
    path.write_bytes(content)
    refused(path)


def test_every_byte_may_be_wrong(tmp_path):
    """A change of any byte of an archive gives an FMU or an FmuError, never another exception."""
    path = make_fmu(tmp_path / "a.fmu", library=None)
    sound = path.read_bytes()
    for at in range(0, len(sound), 3):
        content = bytearray(sound)
        content[at] ^= 0x5A
        path.write_bytes(content)
        with contextlib.suppress(FmuError):
            open_archive(path)


def test_a_zip64_file(tmp_path):
    path = make_fmu(tmp_path / "a.fmu")
    content = path.read_bytes()
    end = content.rfind(b"PK\x05\x06")
    path.write_bytes(content[:end] + b"PK\x06\x07" + bytes(16) + content[end:])
    refused(path, "zip64")


def test_special_files_are_rejected(tmp_path):
    refused(tmp_path, "not a regular file")
    os.mkfifo(tmp_path / "pipe.fmu")
    refused(tmp_path / "pipe.fmu", "not a regular file")
    refused(tmp_path / "nowhere.fmu", "cannot be read")
    refused("a\0b", "cannot be read")


DTD = '<!DOCTYPE fmiModelDescription [<!ENTITY a "aaaaaaaaaa">{}]>'
BOMB = "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefghi", "bcdefghij", strict=True))


@pytest.mark.parametrize(
    "head",
    [
        "<!DOCTYPE fmiModelDescription>",
        DTD.format(BOMB),
        '<!DOCTYPE x SYSTEM "file:///etc/passwd">',
        '<!DOCTYPE x [<!ENTITY % p SYSTEM "file:///etc/passwd"> %p;]>',
    ],
    ids=["bare", "bomb", "external", "parameter"],
)
def test_a_doctype(tmp_path, head):
    refused(make_fmu(tmp_path / "a.fmu", description(head=head)), "DOCTYPE")


def test_a_doctype_in_another_encoding(tmp_path):
    xml = description(head="<!DOCTYPE fmiModelDescription>").replace("UTF-8", "UTF-16")
    refused(make_fmu(tmp_path / "a.fmu", xml.encode("utf-16")), "UTF-8")
    # As UTF-7, these letters would be a DOCTYPE; they are always read as UTF-8.
    xml = description(head="+ADwAIQ-DOCTYPE x+AD4-").replace('encoding="UTF-8"', 'encoding="UTF-7"')
    refused(make_fmu(tmp_path / "a.fmu", xml), "not sound XML")


def test_a_doctype_in_the_terminals(tmp_path):
    files = {"terminalsAndIcons/terminalsAndIcons.xml": b"<!DOCTYPE x><x/>"}
    refused(make_fmu(tmp_path / "a.fmu", files=files), "terminalsAndIcons.xml", "DOCTYPE")
    files = {"sources/buildDescription.xml": b"<!DOCTYPE x><x/>"}
    refused(make_fmu(tmp_path / "a.fmu", files=files), "buildDescription.xml", "DOCTYPE")


def test_a_huge_description(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_XML", 5000)
    refused(
        make_fmu(tmp_path / "a.fmu", description(more="<!-- " + "x y z " * 1000 + "-->")), "modelDescription.xml has"
    )


@pytest.mark.slow
def test_a_deep_description(tmp_path):
    names = [f"a{i * i % 99991}" for i in range(200_000)]  # various: it must not shrink like a bomb
    xml = "".join(f"<{name}>" for name in names) + "".join(f"</{name}>" for name in reversed(names))
    refused(make_fmu(tmp_path / "a.fmu", xml), "got <a0>")


@pytest.mark.parametrize(
    ("content", "word"),
    [(b"", "begins with"), (b"MZ" + bytes(100), "4d 5a"), (ELF[:18] + b"\xb7\x00" + bytes(44), "x86_64"),
     (ELF[:4] + b"\x01" + ELF[5:], "not a shared library"), (ELF[:16] + b"\x02" + ELF[17:], "not a shared library")],
    ids=["empty", "windows", "arm", "32 bit", "program"],
)  # fmt: skip
def test_a_library_of_another_kind(tmp_path, monkeypatch, content, word):
    monkeypatch.setattr(archives, "_machine", lambda: ("linux", "x86_64"))
    opened = open_archive(make_fmu(tmp_path / "a.fmu", library=content))
    with pytest.raises(FmuError, match="not a shared library for x86_64 Linux") as caught:
        extract(opened, tmp_path)
    assert word in str(caught.value)
    assert [each.name for each in tmp_path.iterdir()] == ["a.fmu"]  # nothing was extracted


@pytest.mark.parametrize(("fmi", "other"), [(2, "win64"), (3, "x86_64-windows")])
def test_only_other_platforms(tmp_path, fmi, other):
    opened = open_archive(make_fmu(tmp_path / "a.fmu", fmi=fmi, platform=other))
    with pytest.raises(FmuError, match=f"only for {other}; obtain one"):
        library(opened)
    opened = open_archive(make_fmu(tmp_path / "a.fmu", fmi=fmi, platform=other, files={"sources/a.c": b""}))
    with pytest.raises(FmuError, match=r"'fmpy compile .*a.fmu'"):
        library(opened)
    here = "linux64" if fmi == 2 else "x86_64-linux"
    opened = open_archive(
        make_fmu(tmp_path / "a.fmu", fmi=fmi, library=None, files={f"binaries/{here}/plant.dll": b""})
    )
    with pytest.raises(FmuError, match=r"plant\.so' in the archive|plant\.so cannot be read"):
        library(opened)
    opened = open_archive(make_fmu(tmp_path / "a.fmu", fmi=fmi, library=None))
    with pytest.raises(FmuError, match="only for none"):
        library(opened)


def test_extracting_twice_into_one_folder_is_refused(tmp_path):
    opened = open_archive(make_fmu(tmp_path / "a.fmu"))
    (tmp_path / "out").mkdir()
    extract(opened, tmp_path / "out")
    with pytest.raises(FmuError, match="File exists"):
        extract(opened, tmp_path / "out")


def test_a_link_in_the_folder_is_not_followed(tmp_path):
    opened = open_archive(make_fmu(tmp_path / "a.fmu"))
    (tmp_path / "out").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out/binaries").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FmuError, match="outside its folder"):
        extract(opened, tmp_path / "out")
    assert not any((tmp_path / "elsewhere").iterdir())
