"""Files of the editor: their texts, and reading and writing on disk."""

from __future__ import annotations

import contextlib
import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import cdpr
from cdpr.base.errors import CdprError, OutputError
from cdpr.base.files import UnreadableError, read
from cdpr.base.problems import shown
from cdpr.log.files import create, is_name


@dataclass
class File:
    """Edited text.

    Attributes:
        name: file name, as given by the user.
        text: current text.
        saved: text when it was last read or written; None if the file does not exist yet.
        first: initial text of a file that does not exist yet.
        fixed: reason why the file must not be overwritten; "" if it may be.
    """

    name: str
    text: str
    saved: str | None = None
    first: str = ""
    fixed: str = ""

    @property
    def modified(self) -> bool:
        """True if there is something to save."""
        if self.saved is None:
            return not self.fixed or self.text != self.first
        return self.text != self.saved

    @classmethod
    def open(cls, name: str, fixed: str = "") -> File:
        """Read a file.

        Raises:
            CdprError: if it cannot be read.
        """
        text = on_disk(name)
        return cls(name, text, text, fixed=fixed or _installed(name))


@dataclass
class Files:
    """Files by absolute name, including the scenario.

    Attributes:
        main: absolute name of the scenario file.
        files: all files.
    """

    main: str
    files: dict[str, File] = field(default_factory=dict)

    @property
    def scenario(self) -> File:
        """The scenario file."""
        return self.files[self.main]

    def texts(self) -> dict[str, str]:
        """Return all texts by absolute file name."""
        return {key: file.text for key, file in self.files.items()}

    def put(self, texts: dict[str, str]) -> None:
        """Replace these texts."""
        for key, text in texts.items():
            self.files[key].text = text

    def beside(self, name: str) -> File | None:
        """Return a file that the scenario references, read on first use; None if it cannot be read."""
        path = os.path.join(os.path.dirname(self.scenario.name), name)
        key = os.path.abspath(path)
        if key not in self.files:
            try:
                self.files[key] = File.open(path, self.scenario.fixed)
            except CdprError:
                return None  # the loader reports it
        return self.files[key]


def named(name: object) -> str:
    """Return a valid file name from a window.

    Raises:
        CdprError: if it is not a file name.
    """
    if not isinstance(name, str) or not name.strip() or not is_name(name):
        raise CdprError(f"expected the name of a file, got {shown(name)}")
    return name


def on_disk(name: str) -> str:
    """Return the content of a file.

    Raises:
        CdprError: if it cannot be read or is not UTF-8 text.
    """
    try:
        return read(name).decode("utf-8")
    except UnreadableError as error:
        raise CdprError(str(error)) from None
    except UnicodeDecodeError:
        raise CdprError(f"'{name}' is not UTF-8 text; save it as UTF-8") from None


def unsaved(file: File) -> str:
    """Return the reason why a file cannot be saved in place; "" if it can."""
    if file.fixed:
        return file.fixed
    if file.saved is None:
        return (
            f"'{file.name}' already exists in another folder: save under another name"
            if os.path.lexists(file.name)
            else ""
        )
    if not os.access(file.name, os.W_OK):
        return f"'{file.name}' may not be written: save as another file"
    return f"{reason}: revert to that, or save as another file" if (reason := outdated(file)) else ""


def outdated(file: File) -> str:
    """Return how a file on disk differs from what was read; "" if it does not."""
    if file.saved is None:
        return ""
    try:
        same = on_disk(file.name) == file.saved
    except CdprError as error:
        return str(error)
    return "" if same else f"'{file.name}' was changed by another program since it was read"


def write(name: str, text: str, *, new: bool) -> None:
    """Write a file atomically, either a new one or a replacement that keeps the permissions.

    A symbolic link is preserved, and its target is replaced.

    Raises:
        OutputError: if the file cannot be written.
    """
    content = text.encode("utf-8")
    try:
        if new:
            create(Path(name), content)
        else:
            _replace(Path(os.path.realpath(name)), content)
    except FileExistsError:
        raise OutputError(f"'{name}' already exists and is not overwritten: choose another name") from None
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
    """Return a reason not to write a file that belongs to the installation; "" otherwise."""
    package = os.path.dirname(os.path.realpath(cdpr.__file__))
    if os.path.realpath(name).startswith(package + os.sep):
        return f"'{name}' is part of the installation of cdpr: save it under another name"
    return ""
