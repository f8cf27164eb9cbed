"""FMU archive, checked completely before anything is written to disk; no native code is loaded.

The file is read once, and the same bytes are hashed, checked and extracted: replacing the file meanwhile has no effect.
"""

from __future__ import annotations

import hashlib
import io
import os
import platform
import re
import stat
import struct
import sys
import zipfile
import zlib
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from cdpr.base.errors import FmuError
from cdpr.fmu.read.description import parse, read_description, read_terminals
from cdpr.fmu.read.model import ModelDescription

DESCRIPTION = "modelDescription.xml"
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
BUILD = "sources/buildDescription.xml"  # not used here, but FMPy reads it
# Far beyond the needs of robots, and within the capacity of a machine.
MAX_FILE = 256 * 2**20
MAX_TOTAL = 2**30
MAX_ENTRIES = 20_000
MAX_NAME = 1000  # characters
MAX_DIRECTORY = 8 * 2**20  # bytes of the zip's table of contents, read at once
MAX_XML = 16 * 2**20  # at worst reading takes 0.8 GB
MAX_RATIO = 200  # ratio of sizes; text shrinks to a tenth, a zip bomb to a thousandth
SMALL = 2**20  # below this size the ratio is ignored
CHUNK = 2**16

LIBRARY_ENDINGS = {"linux": ".so", "darwin": ".dylib", "windows": ".dll"}
# Folders of binaries/ for a machine, in FMI 2 and 3.
FOLDERS = {
    ("linux", "x86_64"): ("linux64", "x86_64-linux"),
    ("linux", "aarch64"): ("aarch64-linux", "aarch64-linux"),
    ("darwin", "x86_64"): ("darwin64", "x86_64-darwin"),
    ("darwin", "aarch64"): ("aarch64-darwin", "aarch64-darwin"),
    ("windows", "x86_64"): ("win64", "x86_64-windows"),
}
ELF_MACHINES = {"x86_64": 62, "aarch64": 183}
# Exceptions of zipfile for damaged files.
DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError, struct.error)
EOCD, EOCD_SIZE, ZIP64_LOCATOR_SIZE = b"PK\x05\x06", 22, 20


@dataclass(frozen=True)
class Archive:
    """FMU with a checked file."""

    path: Path
    sha256: str
    description: ModelDescription
    content: bytes = field(repr=False)


def open_archive(path: str | Path) -> Archive:
    """Read and check an FMU; nothing is extracted and no native code is loaded.

    Raises:
        FmuError: if a check fails.
    """
    path = Path(path)
    content = _read(path)
    try:
        with _opened(content) as archive:
            entries = _checked(archive)
            description = read_description(_xml(archive, entries, DESCRIPTION))
            terminals = read_terminals(_xml(archive, entries, TERMINALS)) if TERMINALS in entries else ()
            if BUILD in entries:
                parse(_xml(archive, entries, BUILD), BUILD)
    except FmuError as error:
        raise FmuError(f"{path}: {error}") from None
    names = list(entries)
    libraries = re.compile(rf"binaries/([^/]+)/{description.identifier}\.(so|dylib|dll)")
    found = (libraries.fullmatch(name) for name in names)
    description = replace(
        description,
        terminals=terminals,
        platforms=tuple(sorted({match[1] for match in found if match})),
        sources=any(name.startswith("sources/") and name.endswith((".c", ".cpp", ".cc")) for name in names),
    )
    return Archive(path, hashlib.sha256(content).hexdigest(), description, content)


def library(archive: Archive) -> str:
    """Return the entry of the library for this machine, after a check of its header.

    Raises:
        FmuError: if the FMU has none, or its header is of another kind of machine.
    """
    about = archive.description
    system, machine = _machine()
    folders = FOLDERS.get((system, machine))
    here = None if folders is None else folders[about.fmi == "3.0"]
    if here is None or here not in about.platforms:
        raise FmuError(
            f"{archive.path}: has no binary for this machine ({here or f'{machine} {system}'}), only for "
            f"{', '.join(about.platforms) or 'none'}; {_remedy(archive)}"
        )
    name = f"binaries/{here}/{about.identifier}{LIBRARY_ENDINGS[system]}"
    with _opened(archive.content) as opened:
        try:
            with opened.open(name) as file:
                head = file.read(20)
        except (KeyError, *DAMAGE) as error:  # KeyError: a file of that folder, but with the ending of another system
            raise FmuError(f"{archive.path}: {name} cannot be read: {error}; {_remedy(archive)}") from None
    if system == "linux" and not _elf(head, machine):
        raise FmuError(
            f"{archive.path}: {name} is not a shared library for {machine} Linux (it begins with {head[:8].hex(' ')}); "
            f"{_remedy(archive)}"
        )
    return name


def extract(archive: Archive, folder: str | Path) -> Path:
    """Write all files below `folder`, which must exist, and return the path of the library for this machine.

    No entry may exceed its declared size, so that the total stays within the checked limits. Files written before an
    error are left to the owner of the folder.

    Raises:
        FmuError: if an entry is damaged or cannot be written.
    """
    folder = Path(folder).resolve(strict=True)
    name = library(archive)
    try:
        with _opened(archive.content) as opened:
            for entry, info in _checked(opened).items():
                target = folder.joinpath(*entry.split("/"))
                if not target.resolve().is_relative_to(folder):
                    raise FmuError(f"the entry {entry!r} would be written outside its folder")
                target.parent.mkdir(parents=True, exist_ok=True)
                with open(target, "xb") as file:
                    for chunk in _chunks(opened, info):
                        file.write(chunk)
    except FmuError as error:
        raise FmuError(f"{archive.path}: {error}") from None
    except OSError as error:
        raise FmuError(
            f"{archive.path}: cannot be extracted: {error.filename or folder}: {error.strerror or error}"
        ) from None
    return folder.joinpath(*name.split("/"))


def _read(path: Path) -> bytes:
    try:
        # Checks use the opened file; without blocking on a pipe.
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise FmuError(f"{path}: is not a regular file; expected an FMU")
            content = file.read(MAX_FILE + 1)
    except IsADirectoryError:
        raise FmuError(f"{path}: is not a regular file; expected an FMU") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FmuError(f"{path}: cannot be read: {reason}") from None
    if len(content) > MAX_FILE:
        raise FmuError(f"{path}: is larger than {MAX_FILE // 2**20} MiB, the limit for an FMU")
    return content


def _opened(content: bytes) -> zipfile.ZipFile:
    """Open the zip, with a limit on its table of contents, which zipfile would read at any size."""
    end = content.rfind(EOCD, max(0, len(content) - EOCD_SIZE - 2**16))
    if end < 0 or len(content) < end + EOCD_SIZE:
        raise FmuError("is not a zip file, or the end of it is missing; an FMU is a zip file")
    if content[max(0, end - ZIP64_LOCATOR_SIZE) : end].startswith(b"PK\x06\x07"):
        raise FmuError("is a zip64 file, which is not supported for FMUs")
    if int.from_bytes(content[end + 12 : end + 16], "little") > MAX_DIRECTORY:
        raise FmuError(f"has a table of contents of more than {MAX_DIRECTORY // 2**20} MiB")
    try:
        return zipfile.ZipFile(io.BytesIO(content))
    except DAMAGE as error:
        raise FmuError(f"is not a sound zip file: {error}") from None


def _checked(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    """Return the files by name, all of them safe to extract."""
    infos = archive.infolist()
    if len(infos) > MAX_ENTRIES:
        raise FmuError(f"has {len(infos)} entries, more than {MAX_ENTRIES}")
    twins: dict[str, list[zipfile.ZipInfo]] = defaultdict(list)
    for info in infos:
        _check_entry(info)
        if not info.is_dir():
            twins[info.filename].append(info)
    files = {name: same[0] for name, same in twins.items()}
    folders = (name[:i] for name in files for i, letter in enumerate(name) if letter == "/")  # not kept: many, and long
    if both := next((folder for folder in folders if folder in files), None):
        raise FmuError(f"has {both!r} as a file and as a folder")
    total = sum(info.file_size for info in infos)
    if total > MAX_TOTAL:
        raise FmuError(f"would unpack to {total / 2**30:.3g} GiB, more than {MAX_TOTAL / 2**30:.3g} GiB")
    for name, same in twins.items():  # packers may add a file twice; another content with the same name is an error
        if len(same) > 1 and len({_digest(archive, info) for info in same}) > 1:
            raise FmuError(f"has two entries {name!r} that differ")
    return files


def _digest(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
    digest = hashlib.sha256()
    for chunk in _chunks(archive, info):
        digest.update(chunk)
    return digest.digest()


def _check_entry(info: zipfile.ZipInfo) -> None:
    name = info.orig_filename
    parts = name.removesuffix("/").split("/")
    if len(name) > MAX_NAME:
        raise FmuError(f"has the entry {name[:80]!r}..., whose name has {len(name)} letters, more than {MAX_NAME}")
    if (
        any(part in ("", ".", "..") for part in parts)
        or any(letter in name for letter in "\\:")
        or not name.isprintable()
    ):
        raise FmuError(
            f"has the entry {name[:80]!r}, which is not a plain path: it could be written outside its folder"
        )
    kind = stat.S_IFMT(info.external_attr >> 16)
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        raise FmuError(f"has the entry {name[:80]!r}, which is a link or a device, not a file")
    if info.flag_bits & 0x1:
        raise FmuError(f"has the entry {name[:80]!r}, which is encrypted")
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise FmuError(f"has the entry {name[:80]!r}, which FMI does not allow: expected stored or deflated")
    if info.file_size > max(SMALL, MAX_RATIO * info.compress_size):
        raise FmuError(
            f"has the entry {name[:80]!r}, which would grow from {info.compress_size} to {info.file_size} bytes: "
            "a zip bomb"
        )


def _xml(archive: zipfile.ZipFile, entries: dict[str, zipfile.ZipInfo], name: str) -> bytes:
    info = entries.get(name)
    if info is None:
        raise FmuError(f"contains no {name}; is it an FMU?")
    if info.file_size > MAX_XML:
        raise FmuError(f"{name} has {info.file_size} bytes, more than {MAX_XML}")
    return b"".join(_chunks(archive, info))


def _chunks(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Iterator[bytes]:
    """Yield the bytes of one entry: zipfile stops at the declared size, and then reports the wrong checksum."""
    try:
        with archive.open(info) as file:
            while chunk := file.read(CHUNK):
                yield chunk
    except DAMAGE as error:
        raise FmuError(f"the entry {info.filename!r} is damaged: {error}") from None


def _machine() -> tuple[str, str]:
    system = {"linux": "linux", "darwin": "darwin", "win32": "windows"}.get(sys.platform, sys.platform)
    machine = platform.machine().lower()
    return system, {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)


def _elf(head: bytes, machine: str) -> bool:
    """Return whether a file with this header is a 64-bit little-endian shared object for `machine`."""
    shared = head[16:18] == b"\x03\x00"
    kind = int.from_bytes(head[18:20], "little")
    return head[:6] == b"\x7fELF\x02\x01" and shared and kind == ELF_MACHINES.get(machine)


def _remedy(archive: Archive) -> str:
    if archive.description.sources:
        return f"it contains its sources: 'fmpy compile {archive.path}' (FMPy and a C compiler) adds the binary"
    return "obtain one, or its sources, from its author"
