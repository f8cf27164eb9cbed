"""Editor: opens, edits, undoes and saves files, and returns the form and the scenario."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from typing import Any

from cdpr.base.errors import CdprError, OutputError
from cdpr.base.problems import Mark, Path, Problem, dotted
from cdpr.config.overrides import KEY, Change, path_of, read_overrides
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.config.yaml_text import flow
from cdpr.plugins.registry import Registry, registry
from cdpr.scenario import examples, load_scenario, nominal
from cdpr.scenario.choices import with_choices
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.source import kind_of, open_document, stem
from cdpr.ui.gui.editor import edit, saving
from cdpr.ui.gui.editor.choose import plugin_note
from cdpr.ui.gui.editor.fields import MISSING
from cdpr.ui.gui.editor.files import File, Files, named, outdated, unsaved
from cdpr.ui.gui.editor.form import Subject, placed, tabs
from cdpr.ui.gui.editor.form_edits import ROLES, FormEdits
from cdpr.ui.gui.editor.unsaved import around, new_file

FIRST = "caroca"  # example that is opened by default
UNDOS = 200

Step = tuple[str, Files, dict[str, str]]  # name of the edit, and the files and texts before it


class Editor:
    """Files of a scenario during editing.

    Invalid edits are kept, and the form shows their problems. CdprError is raised only for edits that cannot be
    written.

    Args:
        name: a scenario or robot file, or an example; a robot gets a generated scenario.
        changes: initial edits, as `cdpr.scenario.choices.typed` returns them; they are not saved.
    """

    def __init__(self, name: str | None = None, changes: Sequence[Change | str] = ()) -> None:
        self._plugins: Registry = registry()
        self._undo: list[Step] = []
        self._redo: list[Step] = []
        self._applied: dict[str, str] | None = None
        self._notes: list[Problem] = []  # on the last edit
        self._files = self._opened(FIRST if name is None else name)
        self._parse_texts()
        problems = Problems()
        given = with_choices(read_overrides(changes, problems), problems)
        problems.raise_any()
        for change in given:
            self._set(nominal.renamed(change.path), change.value)

    def open(self, name: str) -> None:
        """Open another scenario or robot; this can be undone.

        Raises:
            ScenarioError: if it cannot be read.
        """
        self._replace_files(f"open {_brief(name)}", self._opened(name))
        self._applied = None

    def new(self, kind: str, /, **arguments: Any) -> None:
        """Create a new robot or scenario; this can be undone. `arguments` are those of `cdpr new`."""
        file, note = new_file(kind, arguments, self._plugins)
        self._replace_files(f"new {kind}", self._files_of(file, robot=kind == "robot"))
        self._applied = None
        if note:
            self._notes = [Problem(Mark(self._files.scenario.name), ("controller", "type"), note)]

    def _opened(self, name: object) -> Files:
        given = named(name)
        path = examples.resolve(given, None)
        document = open_document(path, None, Problems())
        fixed = f"'{given}' is an example of cdpr: save it under another name" if path != given else ""
        return self._files_of(File.open(path, fixed), robot=kind_of(document) == "robot")

    def _files_of(self, file: File, *, robot: bool) -> Files:
        """Return the files of the editor, with a generated scenario for a robot."""
        files = [around(file, self._plugins), file] if robot else [file]
        keyed = {os.path.abspath(each.name): each for each in files}
        return Files(next(iter(keyed)), keyed)

    def _replace_files(self, title: str, files: Files) -> None:
        """Replace the files, which can be undone.

        Raises:
            CdprError: if the scenario is not valid YAML; nothing is replaced then.
        """
        edit.read(files.scenario.text)
        self._remember(title)
        self._files = files
        self._parse_texts()

    # State of the editor.

    def _parse_texts(self) -> None:
        """Parse the texts."""
        main = self._files.scenario
        self._data = nominal.renamed_data(edit.read(main.text))
        self._robot: File | None = None
        name = self._data.get("robot")
        self._robot_file = name if isinstance(name, str) else ""
        if isinstance(name, str) and name and not os.path.isabs(name):
            self._robot = self._files.beside(name)
            document = self._robot and parse(self._robot.text, name, Problems())
            if document:
                self._data["robot"] = document.data
        self._notes = []
        self._form: list[dict[str, Any]] | None = None
        self._loaded: Scenario | CdprError | None = None

    def _load(self) -> Scenario | CdprError:
        """Load the scenario, and cache the result."""
        if self._loaded is None:
            main = self._files.scenario
            try:
                self._loaded = load_scenario(
                    main.name, text=main.text, files=self._files.texts(), plugins=self._plugins
                )
            except CdprError as error:
                self._loaded = error
        return self._loaded

    def scenario(self) -> Scenario:
        """Return the scenario of the form.

        Raises:
            ScenarioError: with all problems of the files.
            PluginError: if a plugin cannot be used.
        """
        loaded = self._load()
        if isinstance(loaded, CdprError):
            raise loaded.with_traceback(None)
        return loaded

    def _problems(self) -> tuple[Sequence[Problem], Sequence[Problem]]:
        """Return the problems and warnings."""
        loaded, whole = self._load(), Mark(self._files.scenario.name)
        if isinstance(loaded, CdprError):
            return loaded.rows or [Problem(whole, (), str(loaded))], []
        idle = "is set, but this run does not use it"
        return [], [*loaded.warnings, *(Problem(whole, tuple(_parts(key)), idle) for key in loaded.unused)]

    def apply(self) -> Scenario:
        """Return the scenario and mark the current texts as applied."""
        notes = self._notes
        self._parse_texts()  # referenced files may have changed
        self._notes = notes
        scenario = self.scenario()
        self._applied = self._shown_texts()
        return scenario

    def form(self) -> dict[str, Any]:
        """Return the message with all fields, their problems and the undo state."""
        tabs, files = self._tabs(), self._shown_files()
        problems, warnings = self._problems()
        reasons = [reason for file in files if file.modified and (reason := unsaved(file))]
        first = next((file for file in files if not file.fixed or file.saved is not None), files[0])
        stale = [(file, reason) for file in files if (reason := outdated(file))]
        elsewhere = [Problem(Mark(file.name), (), f"{reason}: use Revert to reload it") for file, reason in stale]
        return {
            "kind": "form",
            "file": first.name,
            "title": str(self._data.get("name") or stem(first.name)),
            "files": [file.name for file in files],
            "modified": bool(stale) or any(file.modified for file in files),
            "unsaved": reasons[0] if reasons else None,
            "applied": self._applied == self._shown_texts(),
            "undo": self._undo[-1][0] if self._undo else None,
            "redo": self._redo[-1][0] if self._redo else None,
            "tabs": tabs,
            "problems": placed(tabs, problems),
            "warnings": placed(tabs, [*elsewhere, *self._notes, *warnings]),
        }

    def texts(self) -> list[dict[str, str]]:
        """Return the name and text of each file."""
        return [{"name": file.name, "text": file.text} for file in self._shown_files()]

    def _shown_files(self) -> list[File]:
        return [self._files.scenario, *([self._robot] if self._robot else [])]

    def _shown_texts(self) -> dict[str, str]:
        return {os.path.abspath(file.name): file.text for file in self._shown_files()}

    def _tabs(self) -> list[dict[str, Any]]:
        if self._form is None:
            self._form = tabs(Subject(self._data, self._robot_file, self._known(), self._plugins))
        return self._form

    def _known(self) -> Any:
        """Return all sections with their effective values; MISSING if the files are invalid."""
        loaded = self._load()
        return loaded.sections.model_dump(mode="json", by_alias=True) if isinstance(loaded, Scenario) else MISSING

    # Edits.

    def edit(self, path: str, value: Any = None) -> None:
        """Set a key; None removes it, so that its default applies.

        A text such as "circle" for `trajectory`, a section with several types, selects that type.
        """
        if value is None:
            self.remove(path)
        else:
            self._set(_path(path), value)

    def _set(self, key: Path, value: Any) -> None:
        texts, before = self._form_edits().set(key, value), self._data
        self._replace_texts(f"{dotted(key)} = {_brief(value)}", texts)
        for role in ROLES:
            if key[0] == role and (note := plugin_note(self._plugins, role, before.get(role), self._data.get(role))):
                self._notes = [Problem(Mark(self._files.scenario.name), (role, "type"), note)]

    def remove(self, path: str) -> None:
        """Remove a key or a list item; do nothing if it is not present."""
        self._replace_texts(f"remove {path}", self._form_edits().remove(_path(path)))

    def insert(self, path: str, value: Any = None) -> None:
        """Append an item to a list; by default it is generated from the schema or copied from the last item.

        A type name such as "wrench" for `events` appends an item of that type with initial values.
        """
        self._replace_texts(f"insert {path}", self._form_edits().insert(_path(path), value))

    def _form_edits(self) -> FormEdits:
        return FormEdits(self._files, self._data, self._robot_file, self._robot, self._tabs, self._known, self._plugins)

    def _replace_texts(self, title: str, texts: dict[str, str]) -> None:
        """Replace the texts; this can be undone."""
        if texts != self._files.texts():
            self._remember(title)
            self._files.put(texts)
            self._parse_texts()

    def _remember(self, title: str) -> None:
        self._undo = [*self._undo, (title, self._files, self._files.texts())][-UNDOS:]
        self._redo = []

    def undo(self) -> None:
        """Undo the last edit."""
        self._move_step(self._undo, self._redo)

    def redo(self) -> None:
        """Redo the last undone edit."""
        self._move_step(self._redo, self._undo)

    def _move_step(self, source: list[Step], other: list[Step]) -> None:
        if not source:
            raise CdprError("no change to undo" if source is self._undo else "nothing was undone")
        label, files, texts = source.pop()
        other.append((label, self._files, self._files.texts()))
        self._files = files
        self._files.put(texts)
        self._parse_texts()

    # Files.

    def revert(self) -> None:
        """Reload all files from disk; this can be undone.

        Raises:
            CdprError: if a file cannot be read.
        """
        self._replace_texts("revert", saving.reread(self._files, self._shown_files()))

    def save(self) -> list[str]:
        """Write modified texts to their files and return the file names.

        Raises:
            OutputError: if a file was changed by other programs, is an example or already exists; nothing is written
                then.
        """
        changed = [file for file in self._shown_files() if file.modified]
        for file in changed:
            if reason := unsaved(file):
                raise OutputError(reason)
        return saving.save(changed)

    def save_as(self, target: str) -> list[str]:
        """Write all texts to another file or folder, continue there, and return the names of new files.

        Undo returns to the previous files; written files remain. References to files are adjusted. Existing files are
        never overwritten.
        """
        runs = self._applied == self._shown_texts()
        files, names = saving.save_as(self._files, self._robot, target, self._plugins)
        self._replace_files(f"save as {_brief(target)}", files)
        self._applied = self._shown_texts() if runs else None
        return names


def _path(text: str) -> Path:
    if not isinstance(text, str) or not re.fullmatch(KEY, text):
        raise CdprError(f"expected a key such as robot.platform.mass or robot.cables[0].frame, got {text!r:.80}")
    return nominal.renamed(tuple(_parts(text)))


def _parts(text: str) -> list[str | int]:
    return list(path_of(text))


def _brief(value: Any) -> str:
    text = flow(value) if not isinstance(value, str) else value
    return text if len(text) <= 40 else f"{text[:37]}..."
