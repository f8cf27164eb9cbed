"""Plan of a study: from the study file to its checked cases."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from cdpr.analysis.jobs.draw import MAX_COUNT
from cdpr.analysis.study.figures import FIGURES
from cdpr.analysis.study.points import Label, Point, Reader, product_of
from cdpr.analysis.study.schema import Axis, Block, Keep, StudyFile
from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.base.files import UnreadableError, read
from cdpr.base.problems import MAX_PROBLEMS, Mark, Path, dotted, first_ones, shown
from cdpr.config.document import Document
from cdpr.config.overrides import Change, Overrides, read_overrides
from cdpr.config.problems import Problems
from cdpr.config.validation import report_nulls, validate
from cdpr.scenario import Scenario, examples, nominal
from cdpr.scenario.loader import Source, load_scenario, open_with
from cdpr.scenario.repeatable import check_repeatable
from cdpr.scenario.source import stem
from cdpr.simulation.header import plugins_of, versions_of

SEED: Path = ("simulation", "seed")
RESERVED = ("case", "block", "status", "message", *FIGURES)  # columns of the table

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Checked:
    """Result of checking a case."""

    given: str  # digest of the input: the scenario and all changes of the case
    resolved: str  # digest of the resolved scenario
    plugins: tuple[str, ...]  # as `cdpr.simulation.header.plugins_of`


@dataclass(frozen=True)
class StudyCase:
    """One run of a study."""

    id: str  # hash of the scenario and its changes, independent of labels, except those of random axes
    block: str | None
    labels: Mapping[str, Label]  # by axis
    scenario: str  # path, for messages and relative file names
    text: str = field(repr=False)  # resolved scenario; empty if the case has a result that is still valid
    versions: Mapping[str, str] = field(repr=False)  # versions of the software that would compute it here
    checked: Checked = field(repr=False)

    def __str__(self) -> str:
        parts = [self.block] if self.block else []
        parts += [f"{axis} {shown(label)}" for axis, label in self.labels.items()]
        return ", ".join(parts) or "the only case"


@dataclass(frozen=True)
class Study:
    """Checked study."""

    name: str
    source: str
    keep: Keep
    blocks: tuple[Grid, ...]
    cases: tuple[StudyCase, ...]
    notes: tuple[str, ...] = ()  # messages on replaced controller or solver options, without duplicates

    def __repr__(self) -> str:
        return f"<Study {self.name}: {len(self.cases)} cases>"

    @property
    def digest(self) -> str:
        """Hash of the study, which identifies it."""
        return _digest([[case.id, case.checked.resolved] for case in self.cases])


@dataclass(frozen=True)
class Grid:
    """Part of a study: a scenario and its axes. A study without blocks has one part without a name."""

    name: str | None
    scenario: Scenario
    base: str  # resolved scenario before any change
    changes: tuple[Change, ...]
    axes: tuple[Axis, ...]
    columns: tuple[list[Point], ...]  # points of each axis

    @property
    def size(self) -> int:
        """Number of cases."""
        return math.prod(len(points) for points in self.columns)


def load_study(
    path: Source,
    *,
    overrides: Overrides = (),
    progress: Progress = lambda done, total: None,
    ended: Mapping[str, tuple[Checked, Mapping[str, str]]] = MappingProxyType({}),
) -> Study:
    """Load a study and check all its cases.

    Args:
        path: study file, name of an example, or data with the keys of a study file, whose scenario may be a Scenario or
            a dict.
        overrides: changes of the scenario in all cases, as in `load_scenario`, applied after the study's own `changes`.
            They cannot change keys that an axis varies.
        progress: called with the number of checked cases and their total.
        ended: cases with a result, by id: their check and the versions that computed them. If both are unchanged, a
            case is not checked again.

    Returns:
        The study with all its cases.

    Raises:
        ScenarioError: with all errors of the file and the cases.
        PluginError: if the only errors are missing plugins.

    Example:
        >>> from cdpr.analysis.study import load_study
        >>> load_study("thesis_belief", overrides={"simulation.duration": 0.1})
        <Study thesis_belief: 128 cases>
    """
    problems = Problems()
    document, scenario = open_with(path, "study", "scenario", load_scenario, problems)
    section = validate(StudyFile, document.data, document, problems)
    report_nulls(document.data, (), document, problems)
    problems.raise_any()
    assert section is not None
    grids = list(_grids(section, document, scenario, read_overrides(overrides, problems), problems))
    total = sum(grid.size for grid in grids)
    if total > MAX_COUNT:
        problems.add(document.mark(("axes",)), (), f"{total} cases; at most {MAX_COUNT} are allowed")
    problems.raise_any()
    notes: dict[str, None] = {}
    cases = _checked(grids, section.seed, total, progress, ended, notes)
    name = section.name or stem(document.source)
    return Study(name, document.source, section.keep, tuple(grids), cases, tuple(notes))


def _grids(
    section: StudyFile, document: Document, scenario: Scenario | None, given: list[Change], problems: Problems
) -> Iterator[Grid]:
    """Yield the parts of a study, with the changes `given` added; errors are collected in `problems`."""
    reader = Reader(document, problems, section.seed)
    loaded: dict[str, Scenario] = {}
    names: set[str] = set()
    for i, block in enumerate(section.blocks or [Block(name="study")]):
        path: Path = ("blocks", i) if section.blocks else ()
        if block.name in names:
            problems.add(document.mark((*path, "name")), (*path, "name"), "another block has this name")
        names.add(block.name)
        axes: dict[Path, Axis] = {("axes", k): axis for k, axis in enumerate(section.axes)}
        axes |= {(*path, "axes", k): axis for k, axis in enumerate(block.axes)}
        targets = _check_axes(axes, document, problems)
        for change in given:
            if dotted(nominal.renamed(change.path)) in targets:
                problems.add(change.mark, change.path, "an axis of the study varies this key; edit the axis instead")
        columns = tuple(reader.axis(axis, place) for place, axis in axes.items())
        changes = reader.changes(section.changes, ("changes",))
        changes += reader.changes(block.changes, (*path, "changes")) + tuple(given)
        place = (*path, "scenario") if block.scenario else ("scenario",)
        file = block.scenario or section.scenario
        base: Scenario | None = None
        if scenario is not None and not block.scenario:
            base = scenario
        elif file is None:
            problems.add(document.mark(place), place, "required but not given: scenario file, relative to this file")
        elif os.path.isabs(file) and document.source:  # a study in Python may give any
            problems.add(document.mark(place), place, "expected a file name relative to this file")
        elif file not in loaded and (text := _unreadable(found := examples.beside(document.folder, file, "scenario"))):
            near = "" if os.path.lexists(found) else examples.hint(file, "scenario")
            problems.add(document.mark(place), place, f"{text}{near}")
        else:
            base = loaded.get(file) or load_scenario(found)
            loaded[file] = base
        if base is not None:
            title = block.name if section.blocks else None
            yield Grid(title, base, base.resolved_yaml(), changes, tuple(axes.values()), columns)


def _unreadable(path: str) -> str:
    """Return why a file cannot be read; "" if it can."""
    try:
        read(path)
    except UnreadableError as error:
        return str(error)
    return ""


def _check_axes(axes: Mapping[Path, Axis], document: Document, problems: Problems) -> set[str]:
    """Check that axis names are unique and that no key is set by two axes; return the keys."""
    names: set[str] = set()
    targets: set[str] = set()
    for place, axis in [(place, leaf) for place, given in axes.items() for leaf in given.leaves()]:
        name = axis.label
        given = {key for point in axis.points.values() for key in point} if axis.points else set(axis.targets)
        keys = {nominal.renamed_key(key) for key in given}
        if name in RESERVED:
            problems.add(
                document.mark(place), place, f"an axis cannot be named {name}: the table already has this column"
            )
        if name in names:
            problems.add(document.mark(place), place, f"two axes are named {shown(name)}: rename one")
        for key in sorted(keys & targets):
            problems.add(document.mark(place), place, f"two axes set {key}")
        names.add(name)
        targets |= keys
    return targets


def _checked(
    grids: list[Grid],
    seed: int,
    total: int,
    progress: Progress,
    ended: Mapping[str, tuple[Checked, Mapping[str, str]]],
    notes: dict[str, None],
) -> tuple[StudyCase, ...]:
    """Return all cases.

    Raises:
        ScenarioError or PluginError: with each distinct error and the first case that has it.
    """
    cases: list[StudyCase] = []
    wrong: dict[str, tuple[int, Point]] = {}  # error line -> first case with it
    counts: Counter[str] = Counter()
    only_plugins = True
    known: Counter[str] = Counter()
    versions: dict[tuple[str, ...], dict[str, str]] = {}
    number = 0
    for grid in grids:
        for point in product_of(grid.columns):
            progress(number, total)
            number += 1
            try:
                cases.append(_case(grid, point, seed, known, versions, ended, notes))
            except CdprError as error:
                only_plugins &= isinstance(error, PluginError)
                for line in str(error).splitlines():
                    wrong.setdefault(line, (number, point))
                    counts[line] += 1
    if wrong:
        every = [_problem_line(line, *found, counts[line], total) for line, found in wrong.items()]
        lines = first_ones(every, MAX_PROBLEMS)
        raise PluginError("\n".join(lines)) if only_plugins else ScenarioError(lines)
    return tuple(cases)


def _case(
    grid: Grid,
    point: Point,
    seed: int,
    known: Counter[str],
    versions: dict[tuple[str, ...], dict[str, str]],
    ended: Mapping[str, tuple[Checked, Mapping[str, str]]],
    notes: dict[str, None],
) -> StudyCase:
    """Return one case.

    `known` counts the cases with identical changes; `notes` collects the notes of the scenarios.

    Raises:
        CdprError: if the case is invalid.
    """
    changes = [*grid.changes, *point.changes]
    same = _digest([{dotted(change.path): change.value for change in changes}, grid.base])
    key = _digest([same, known[same]])[:12]
    known[same] += 1
    if all(change.path != SEED for change in changes):
        changes.append(Change(SEED, int(_digest([seed, key])[:16], 16) >> 1, Mark("seed")))
    given = _digest([same, next(change.value for change in changes if change.path == SEED)])

    def here(plugins: tuple[str, ...]) -> dict[str, str]:
        if plugins not in versions:
            versions[plugins] = versions_of(grid.scenario.plugins, plugins)
        return versions[plugins]

    if key in ended and not any(_names_a_file(change.value, grid.scenario.origin) for change in changes):
        before, computed_by = ended[key]
        if before.given == given and here(before.plugins) == computed_by:
            return StudyCase(key, grid.name, point.labels, grid.scenario.origin, "", here(before.plugins), before)
    scenario = grid.scenario.with_changes(changes)
    check_repeatable(scenario, "a study")
    notes |= dict.fromkeys(scenario.notes)
    plugins, text = plugins_of(scenario), scenario.resolved_yaml()
    found = Checked(given, _digest(text), plugins)
    return StudyCase(key, grid.name, point.labels, scenario.origin, text, here(plugins), found)


def _names_a_file(value: object, scenario: str) -> bool:
    """Return True if a change names an existing file, whose content may have changed."""
    if isinstance(value, str):
        return os.path.exists(os.path.join(os.path.dirname(scenario), value))
    inner = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return any(_names_a_file(each, scenario) for each in inner)


def _problem_line(line: str, number: int, point: Point, count: int, total: int) -> str:
    if total == 1:
        return line
    labels = ", ".join(f"{axis} {shown(label)}" for axis, label in point.labels.items())
    more = f" and {count - 1} more" if count > 1 else ""
    return f"{line} (case {number}{more}: {labels})"


def _digest(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
