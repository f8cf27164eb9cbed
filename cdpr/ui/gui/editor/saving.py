"""Saving and reloading of files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from cdpr.base.errors import CdprError, OutputError
from cdpr.base.files import seen_from
from cdpr.base.problems import Path
from cdpr.plugins.registry import Registry
from cdpr.scenario.named_files import files_of_robot, files_of_scenario
from cdpr.ui.gui.editor import edit
from cdpr.ui.gui.editor.files import File, Files, named, on_disk, write

ENDINGS = (".yaml", ".yml")


def reread(files: Files, shown: Sequence[File]) -> dict[str, str]:
    """Return the texts of all files on disk.

    Raises:
        CdprError: if a visible file cannot be read.
    """
    texts = {}
    for key, file in files.files.items():
        text = file.first
        try:
            if file.saved is not None:
                text = on_disk(file.name)
            edit.read(text)
        except CdprError as error:
            if file in shown:
                raise CdprError(f"revert: {file.name}: {error}") from None
            continue  # not in use any more
        texts[key] = text
    for key, text in texts.items():
        if files.files[key].saved is not None:
            files.files[key].saved = text
    return files.texts() | texts


def save(files: Iterable[File]) -> list[str]:
    """Write these files and return their names.

    Raises:
        OutputError: if a file cannot be written; earlier ones have been written then.
    """
    names = []
    for file in files:
        write(file.name, file.text, new=file.saved is None)
        file.saved = file.text
        names.append(file.name)
    return names


def save_as(files: Files, robot: File | None, target: str, plugins: Registry) -> tuple[Files, list[str]]:
    """Write a scenario and its modified robot elsewhere; return the new files and their names.

    A robot in an unmodified generated scenario is written alone.
    """
    old = files.scenario
    alone = robot is not None and old.saved is None and bool(old.fixed) and not old.modified
    first = robot if alone and robot else old
    name = _target(target, first)
    folder = os.path.dirname(name)
    _make(folder)
    if alone and robot:
        text = _moved(robot.text, files_of_robot(edit.read(robot.text)), os.path.dirname(robot.name), folder)
        write(name, text, new=True)
        beside = os.path.join(folder, os.path.basename(old.name))
        around = edit.set_value(old.text, ("robot",), os.path.basename(name))
        others = {os.path.abspath(beside): File(beside, around, first=around, fixed=old.fixed)}
        return Files(os.path.abspath(beside), {**others, os.path.abspath(name): File.open(name)}), [name]
    text = _moved(old.text, files_of_scenario(edit.read(old.text), plugins), os.path.dirname(old.name), folder)
    names = [name]
    if robot is not None:
        keep = not robot.modified and not robot.fixed
        place, written = (robot.name, robot.text) if keep else _place_of(robot, old, folder)
        text = edit.set_value(text, ("robot",), seen_from(folder or ".", place))
        if not keep and not os.path.lexists(place):
            _make(os.path.dirname(place))
            write(place, written, new=True)
            names.append(place)
    try:
        write(name, text, new=True)
    except OutputError:
        for place in names[1:]:  # leave nothing behind if saving fails
            os.unlink(place)
        raise
    return Files(os.path.abspath(name), {os.path.abspath(name): File.open(name)}), names


def _make(folder: str) -> None:
    try:
        os.makedirs(folder or ".", exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder '{folder}': {error.strerror or error}") from None


def _target(target: str, first: File) -> str:
    """Return the file name for a target file or folder.

    Raises:
        OutputError: if it exists.
    """
    target = named(target)
    if os.path.isdir(target) or target.endswith(os.sep):
        target = os.path.join(target, os.path.basename(first.name))
    elif not target.endswith(ENDINGS):
        target += ENDINGS[0]
    if os.path.lexists(target):
        raise OutputError(f"'{target}' already exists and is not overwritten: choose another name")
    return target


def _place_of(robot: File, scenario: File, folder: str) -> tuple[str, str]:
    """Return the new place of a robot file, under a free name or one with the same content, and its text.

    Its position relative to the scenario is preserved where possible.
    """
    beside = os.path.relpath(robot.name, os.path.dirname(scenario.name) or ".")
    if beside.startswith(os.pardir):
        beside = os.path.basename(robot.name)
    base, ending = os.path.splitext(os.path.join(folder, beside))
    count, place = 1, f"{base}{ending}"
    while True:
        text = _moved(
            robot.text, files_of_robot(edit.read(robot.text)), os.path.dirname(robot.name), os.path.dirname(place)
        )
        if not os.path.lexists(place) or (os.path.isfile(place) and _holds(place, text)):
            return place, text
        count += 1
        place = f"{base}_{count}{ending}"


def _holds(name: str, text: str) -> bool:
    try:
        return on_disk(name) == text
    except CdprError:
        return False


def _moved(text: str, files: Iterable[tuple[Path, str]], old: str, new: str) -> str:
    """Return a text that names the same files from another folder."""
    if os.path.realpath(old or ".") == os.path.realpath(new or "."):
        return text
    for path, name in files:
        if not os.path.isabs(name):
            text = edit.set_value(text, path, seen_from(new or ".", os.path.join(old, name)))
    return text
