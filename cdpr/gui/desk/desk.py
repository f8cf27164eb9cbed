"""The desk: opens, edits, undoes, saves, and says what there is as a form and as a scenario."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from cdpr.errors import CdprError, OutputError
from cdpr.gui.desk import believed, choose, edit, saving
from cdpr.gui.desk.fields import ANY, MISSING, ONE_OF, Field, at, branches, every, resolve
from cdpr.gui.desk.files import File, Files, unsaved
from cdpr.gui.desk.form import SCHEMA, Subject, placed, tabs
from cdpr.gui.desk.made import around, new_file
from cdpr.gui.desk.starts import Starts
from cdpr.plugins.registry import Registry, registry
from cdpr.scenario import examples, load_scenario
from cdpr.scenario.document import copied
from cdpr.scenario.overrides import KEY, PART, Change, read_overrides
from cdpr.scenario.problems import Mark, Path, Problem, Problems, dotted
from cdpr.scenario.scenario import Scenario
from cdpr.scenario.source import kind_of, open_document, stem
from cdpr.scenario.yaml_nodes import parse, parse_value
from cdpr.scenario.yaml_text import flow

FIRST = "caroca"  # the example for who names nothing
UNDOS = 200
ROLES = ("controller", "solver")


class Desk:
    """The files of one scenario while they are edited.

    An edit that makes no sense is kept, and the form shows its problem; CdprError is raised for what cannot be written.

    Args:
        name: a scenario or robot file, or the name of an example; a robot alone stands in a scenario made for it.
        changes: edits to begin with, as `cdpr.scenario.overrides.typed` returns them; they are not saved.
    """

    def __init__(self, name: str | None = None, changes: Sequence[Change | str] = ()) -> None:
        self._plugins: Registry = registry()
        self.open(name)
        problems = Problems()
        given = read_overrides(changes, problems)
        problems.raise_any()
        for change in given:
            self._set(change.path, change.value)

    def open(self, name: str | None = None) -> None:
        """Open another scenario or robot; what is here is dropped. ScenarioError where it cannot be read."""
        name = FIRST if name is None else name
        path = examples.resolve(name, None)
        document = open_document(path, None, Problems())
        fixed = f"'{name}' is an example of cdpr: save as a file of your own" if path != name else ""
        self._begin(File.open(path, fixed), robot=kind_of(document) == "robot")

    def new(self, kind: str, **arguments: Any) -> None:
        """Begin a new robot or scenario in place of what is here; `arguments` are those of `cdpr new`."""
        self._begin(new_file(kind, arguments, self._plugins), robot=kind == "robot")

    def _begin(self, file: File, *, robot: bool) -> None:
        key = os.path.abspath(file.name)
        if robot:
            scenario = around(file, self._plugins)
            self._files = Files(os.path.abspath(scenario.name), {os.path.abspath(scenario.name): scenario, key: file})
        else:
            self._files = Files(key, {key: file})
        self._undo: list[tuple[str, dict[str, str]]] = []
        self._redo: list[tuple[str, dict[str, str]]] = []
        self._applied: dict[str, str] | None = None
        self._look()

    # What is on the desk.

    def _look(self) -> None:
        """Read the texts anew."""
        main = self._files.scenario
        self._data = edit.read(main.text)
        self._robot: File | None = None
        name = self._data.get("robot")
        self._robot_file = name if isinstance(name, str) else ""
        if isinstance(name, str) and name and not os.path.isabs(name):
            self._robot = self._files.beside(name)
            document = self._robot and parse(self._robot.text, name, Problems())
            if document:
                self._data["robot"] = {"name": stem(name), **document.data}
        self._form: list[dict[str, Any]] | None = None
        self._loaded: Scenario | CdprError | None = None

    def _load(self) -> Scenario | CdprError:
        """Load what the texts say, once."""
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
        """Return the scenario that the form describes; ScenarioError or PluginError with all problems otherwise."""
        loaded = self._load()
        if isinstance(loaded, CdprError):
            raise loaded.with_traceback(None)
        return loaded

    def _told(self) -> tuple[Sequence[Problem], Sequence[Problem]]:
        """Problems and warnings."""
        loaded, whole = self._load(), Mark(self._files.scenario.name)
        if isinstance(loaded, CdprError):
            return loaded.rows or [Problem(whole, (), str(loaded))], []
        idle = "is given, but this run does not use it"
        return [], [*loaded.warnings, *(Problem(whole, tuple(_parts(key)), idle) for key in loaded.unused)]

    def apply(self) -> Scenario:
        """Return the scenario, which runs from now on: the form says so until it is changed."""
        scenario = self.scenario()
        self._applied = self._files.texts()
        return scenario

    def form(self) -> dict[str, Any]:
        """Return the message with all fields, their problems, and what may be undone."""
        made, files = self._tabs(), self._shown_files()
        problems, warnings = self._told()
        reasons = [reason for file in files if file.modified and (reason := unsaved(file))]
        first = next((file for file in files if not file.fixed or file.saved is not None), files[0])
        return {
            "kind": "form",
            "file": first.name,
            "title": self._data.get("name") or stem(first.name),
            "files": [file.name for file in files],
            "modified": any(file.modified for file in files),
            "unsaved": reasons[0] if reasons else None,
            "applied": self._applied == self._files.texts(),
            "undo": self._undo[-1][0] if self._undo else None,
            "redo": self._redo[-1][0] if self._redo else None,
            "tabs": made,
            "problems": placed(made, problems),
            "warnings": placed(made, warnings),
        }

    def texts(self) -> list[dict[str, str]]:
        """Return name and text of each file."""
        return [{"name": file.name, "text": file.text} for file in self._shown_files()]

    def _shown_files(self) -> list[File]:
        return [self._files.scenario, *([self._robot] if self._robot else [])]

    def _tabs(self) -> list[dict[str, Any]]:
        if self._form is None:
            loaded = self._load()
            known = loaded.sections.model_dump(mode="json", by_alias=True) if isinstance(loaded, Scenario) else MISSING
            self._form = tabs(Subject(self._data, self._robot_file, known, self._plugins))
        return self._form

    def _field(self, path: Path) -> Field | None:
        wanted = dotted(path)
        return next((each for tab in self._tabs() for each in every(tab["fields"]) if each["path"] == wanted), None)

    # Edits.

    def edit(self, path: str, value: Any = None) -> None:
        """Give a key another value; None takes it away, so that its default holds.

        The name of a form for a section that has several, such as "circle" for `trajectory`, chooses that form.
        """
        key = _path(path)
        if value is None:
            self.remove(path)
        else:
            self._set(key, value)

    def remove(self, path: str) -> None:
        """Take a key or an item of a list away; nothing where it is not given."""
        key = _path(path)
        if at(self._data, key) is MISSING and key[0] != "believed":
            return
        with_it = self._texts()
        if len(key) == 3 and key[:2] == ("robot", "cables") and isinstance(key[2], int):
            for limit in ("min", "max"):  # one per cable
                place: Path = ("robot", "tension", limit)
                held = at(self._data, place)
                if isinstance(held, list) and len(held) == len(at(self._data, key[:2])):
                    with_it = self._write(with_it, (*place, key[2]), None, cut=True)
        if key[0] == "believed" and len(key) > 1:
            key = self._believed(key)[0]
            if at(edit.read(self._files.scenario.text), key) is MISSING:
                return
        self._take(f"remove {path}", self._write(with_it, key, None, cut=True))

    def insert(self, path: str, value: Any = None) -> None:
        """Add an item to a list; one made from the schema, or like the last, unless it is given.

        The name of a form, such as "wrench" for `events`, stands for one of that form with plain values.
        """
        key = _path(path)
        items = at(self._data, key)
        texts = self._texts()
        if items is MISSING:
            items = []
        if not isinstance(items, list):
            raise CdprError(f"{path}: is no list, so nothing can be inserted")
        if not isinstance(value, dict):
            value = self._item(key, value, items)
        for limit in ("min", "max") if key == ("robot", "cables") else ():
            place: Path = ("robot", "tension", limit)
            held = at(self._data, place)
            if isinstance(held, list) and held and len(held) == len(items):
                texts = self._write(texts, place, [*held, held[-1]])
        self._take(f"insert {path}[{len(items)}]", self._write(texts, key, value, insert=True))

    def _item(self, key: Path, name: Any, items: list[Any]) -> Any:
        """A new item of a list: of the form that has this name, or like the last."""
        node = self._schema_at(key)
        item = resolve(node.get("items", ANY), SCHEMA) if node else {}
        if isinstance(name, str) and "discriminator" in item:
            return choose.form_section(item, SCHEMA, name, {}, self._starts())
        if name is not None:
            return name
        if key == ("robot", "cables"):
            return self._starts().cable()
        if items:
            last = copied(items[-1])
            if isinstance(last, dict):
                last.pop("name", None)
                if isinstance(last.get("time"), (int, float)):
                    last["time"] += 1.0
            return last
        return self._starts().value(item, str(key[-1]))

    def _set(self, key: Path, value: Any) -> None:
        if len(key) > 1 and key[-1] == "type" and isinstance(value, str):
            key = key[:-1]  # a type chooses a form
            if self._several(key) is None:
                key = (*key, "type")
        texts = self._texts()
        told = f"{dotted(key)} = {_brief(value)}"
        if isinstance(value, str) and key[0] in ROLES and len(key) == 1:
            role: Any = key[0]
            folder = os.path.dirname(self._files.scenario.name)
            section = choose.plugin_section(self._plugins, role, value, self._data.get(role), folder)
            self._take(told, self._write(texts, key, section))
            return
        node = self._several(key) if isinstance(value, str) else None
        if node is not None:
            value = choose.form_section(node, SCHEMA, value, at(self._data, key), self._starts())
        elif isinstance(value, str) and (field := self._field(key)) and field["kind"] == "yaml":
            try:
                value = parse_value(value)
            except ValueError as error:
                raise CdprError(f"{dotted(key)}: {error}") from None
        key, value = self._typed(*self._whole(key, value))
        self._take(told, self._write(texts, key, value))

    def _several(self, key: Path) -> dict[str, Any] | None:
        """Return the schema of a section that has several forms; None where `key` is none."""
        node = self._schema_at(key)
        return node if node and ("discriminator" in node or node.get("name") in ONE_OF) else None

    def _schema_at(self, key: Path) -> dict[str, Any] | None:
        """Return the resolved schema of what stands at a path; None where there is none."""
        node: Any = SCHEMA
        data: Any = self._data
        for part in key:
            node = resolve(node, SCHEMA)
            forms = branches(node, SCHEMA)
            if forms:
                node = forms.get(str(data.get("type")) if isinstance(data, dict) else "", {})
            node = node.get("properties", {}).get(part) if isinstance(part, str) else node.get("items")
            if not isinstance(node, dict):
                return None
            data = at(data, (part,))
        return resolve(node, SCHEMA)

    def _whole(self, key: Path, value: Any) -> tuple[Path, Any]:
        """Where an item is set of a vector that is not given, or given as one number, set all of it."""
        if len(key) < 2 or not isinstance(key[-1], int):
            return key, value
        place = self._believed(key[:-1])[0] if key[0] == "believed" and len(key) > 2 else key[:-1]
        if isinstance(at(self._data, place), list):
            return key, value
        field = self._field(key[:-1])
        held = field["value"] if field else at(self._data, ("robot", *key[1:-1])) if key[0] == "believed" else None
        if field and field["kind"] == "vector" and not isinstance(held, list):
            cables = at(self._data, ("robot", "cables"))
            size = field.get("size") or (len(cables) if isinstance(cables, list) else 0)
            held = [held] * size
        if isinstance(held, list) and key[-1] < len(held):
            return key[:-1], [*held[: key[-1]], value, *held[key[-1] + 1 :]]
        return key, value

    def _typed(self, key: Path, value: Any) -> tuple[Path, Any]:
        """Where a key is set of a section that is not given and may have several types, set its type, too."""
        for end in range(1, len(key)):
            node = self._schema_at(key[:end])
            if node is None or "discriminator" not in node or at(self._data, key[:end]) is not MISSING:
                continue
            forms, default = branches(node, SCHEMA), node.get("default")
            known = default.get("type") if isinstance(default, dict) else None
            name = known or next((each for each, form in forms.items() if key[end] in form["properties"]), None)
            for word in reversed(key[end:]):
                value = {word: value}
            return key[:end], {"type": name, **value} if name else value
        return key, value

    def _starts(self) -> Starts:
        return Starts(self._data, SCHEMA, self._plugins)

    def _texts(self) -> dict[str, str]:
        return self._files.texts()

    def _write(
        self, texts: dict[str, str], key: Path, value: Any, *, cut: bool = False, insert: bool = False
    ) -> dict[str, str]:
        """Return the texts with one value changed, in the file in which it stands."""
        file, path = self._files.main, key
        if key[0] == "robot" and len(key) > 1 and self._robot_file:
            if self._robot is None:
                raise CdprError(f"{dotted(key)}: the robot file '{self._robot_file}' cannot be read")
            file, path = os.path.abspath(self._robot.name), key[1:]
        text = texts[file]
        if key[0] == "believed" and len(key) > 1 and not cut:
            path, entry = self._believed(key)
            if entry is not None:
                text = edit.insert(text, path[:2], entry)
                if len(path) == 3:
                    if not isinstance(value, dict):
                        raise CdprError(f"{dotted(key)}: a mapping of what differs is expected")
                    value = {**entry, **value}
        if cut:
            changed = edit.remove(text, path)
        else:
            changed = edit.insert(text, path, value) if insert else edit.set_value(text, path, value)
        return {**texts, file: changed}

    def _believed(self, key: Path) -> tuple[Path, dict[str, Any] | None]:
        said = at(self._data, ("believed", "cables"))
        path, entry = believed.target(key[1:], said, at(self._data, ("robot", "cables")))
        return ("believed", *path), entry

    def _take(self, told: str, texts: dict[str, str]) -> None:
        """Make these texts the present ones; what was before can be undone."""
        before = self._texts()
        if texts == before:
            return
        self._undo = [*self._undo, (told, before)][-UNDOS:]
        self._redo = []
        self._files.put(texts)
        self._look()

    def undo(self) -> None:
        """Take the last edit back."""
        self._back(self._undo, self._redo)

    def redo(self) -> None:
        """Do again what was undone last."""
        self._back(self._redo, self._undo)

    def _back(self, source: list[tuple[str, dict[str, str]]], other: list[tuple[str, dict[str, str]]]) -> None:
        if not source:
            raise CdprError("there is nothing more to undo" if source is self._undo else "nothing was undone")
        told, texts = source.pop()
        other.append((told, self._texts()))
        self._files.put(texts)
        self._look()

    # Files.

    def revert(self) -> None:
        """Go back to what is on the disk; it can be undone. Raises CdprError where a file cannot be read."""
        self._take("revert", saving.reread(self._files))

    def save(self) -> list[str]:
        """Write what was changed to the files that it came from and return their names.

        Raises OutputError, before anything is written, where one of them may not be written: it was changed by others,
        is an example, or is there by now.
        """
        changed = [file for file in self._shown_files() if file.modified]
        for file in changed:
            if reason := unsaved(file):
                raise OutputError(reason)
        return saving.save(changed)

    def save_as(self, target: str) -> list[str]:
        """Write all into another file or folder, where it goes on from then on, and return the names of what is new.

        Names of files in it are changed so that they mean the same ones; nothing that is there is written over.
        """
        runs = self._applied == self._texts()
        self._files, names = saving.save_as(self._files, self._robot, target, self._plugins)
        self._undo, self._redo = [], []
        self._look()
        self._applied = self._texts() if runs else None
        return names


def _path(text: str) -> Path:
    if not isinstance(text, str) or not KEY.fullmatch(text):
        raise CdprError(f"a key such as robot.platform.mass or robot.cables[0].frame is expected, got {text!r:.80}")
    return tuple(_parts(text))


def _parts(text: str) -> list[str | int]:
    return [int(index) if index else word for index, word in PART.findall(text)]


def _brief(value: Any) -> str:
    text = flow(value) if not isinstance(value, str) else value
    return text if len(text) <= 40 else f"{text[:37]}..."
