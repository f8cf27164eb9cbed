"""The files on the desk: their texts, what is on the disk, and how one gets there."""

from __future__ import annotations

import contextlib
import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import cdpr
from cdpr.errors import CdprError, OutputError
from cdpr.log.files import create, is_name
from cdpr.problems import shown
from cdpr.scenario.files import UnreadableError, read


@dataclass
class File:
    """A text that is edited.

    Attributes:
        name: the file, as the user named it.
        text: what it says now.
        saved: what it said when it was read or written last; None where there is no such file yet.
        first: what it said first, of one that is not there yet.
        fixed: why it is not written where it is; "" where it is.
    """

    name: str
    text: str
    saved: str | None = None
    first: str = ""
    fixed: str = ""

    @property
    def modified(self) -> bool:
        """Whether there is something to save."""
        if self.saved is None:
            return not self.fixed or self.text != self.first
        return self.text != self.saved

    @classmethod
    def open(cls, name: str, fixed: str = "") -> File:
        """Read a file; CdprError where that cannot be."""
        text = on_disk(name)
        return cls(name, text, text, fixed=fixed or _installed(name))


@dataclass
class Files:
    """Files by their absolute names, the first of them the scenario.

    Attributes:
        main: the name of the scenario's file, absolute.
    """

    main: str
    files: dict[str, File] = field(default_factory=dict)

    @property
    def scenario(self) -> File:
        """The scenario's file."""
        return self.files[self.main]

    def texts(self) -> dict[str, str]:
        """Return all texts, by absolute names."""
        return {key: file.text for key, file in self.files.items()}

    def put(self, texts: dict[str, str]) -> None:
        """Take these texts in place of those there are."""
        for key, text in texts.items():
            self.files[key].text = text

    def beside(self, name: str) -> File | None:
        """Return the file that the scenario names, read when it is asked for first; None where it cannot be read."""
        path = os.path.join(os.path.dirname(self.scenario.name), name)
        key = os.path.abspath(path)
        if key not in self.files:
            try:
                self.files[key] = File.open(path, self.scenario.fixed)
            except CdprError:
                return None  # the loader tells
        return self.files[key]


def named(name: object) -> str:
    """Return the name of a file as it came from a window; CdprError where it is none."""
    if not isinstance(name, str) or not name.strip() or not is_name(name):
        raise CdprError(f"the name of a file is expected, got {shown(name)}")
    return name


def on_disk(name: str) -> str:
    """Return what a file holds; CdprError where it cannot be read, or is no text."""
    try:
        return read(name).decode("utf-8")
    except UnreadableError as error:
        raise CdprError(str(error)) from None
    except UnicodeDecodeError:
        raise CdprError(f"'{name}' is not UTF-8 text; save it as UTF-8") from None


def unsaved(file: File) -> str:
    """Return why a file is not written where it is; "" where it may be."""
    if file.fixed:
        return file.fixed
    if file.saved is None:
        return f"'{file.name}' is there already, from elsewhere: save as another" if os.path.lexists(file.name) else ""
    if not os.access(file.name, os.W_OK):
        return f"'{file.name}' may not be written: save as another file"
    return f"{reason}: revert to that, or save as another file" if (reason := outdated(file)) else ""


def outdated(file: File) -> str:
    """Return how a file is no longer what was read; "" where it is."""
    if file.saved is None:
        return ""
    try:
        same = on_disk(file.name) == file.saved
    except CdprError as error:
        return str(error)
    return "" if same else f"'{file.name}' was changed by another program since it was read"


def write(name: str, text: str, *, new: bool) -> None:
    """Write a file in one step, a new one or in place of what is there, whose rights stay. Raises OutputError.

    Where the name is a link, what it leads to is replaced.
    """
    content = text.encode("utf-8")
    try:
        if new:
            create(Path(name), content)
        else:
            _replace(Path(os.path.realpath(name)), content)
    except FileExistsError:
        raise OutputError(f"'{name}' is there already: it is not written over; choose another name") from None
    except OSError as error:
        raise OutputError(f"cannot write '{name}': {error.strerror or error}") from None


def _replace(path: Path, content: bytes) -> None:
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, path.stat().st_mode & 0o7777)
        os.replace(temporary, path)
    finally:
        with contextlib.suppress(OSError):
            os.unlink(temporary)


def _installed(name: str) -> str:
    """Return what forbids to write into an installation."""
    package = os.path.dirname(os.path.realpath(cdpr.__file__))
    if os.path.realpath(name).startswith(package + os.sep):
        return f"'{name}' belongs to the installation of cdpr: save as a file of your own"
    return ""
