"""Problems in the files of a scenario, collected into one error."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from cdpr.base.errors import PluginError, ScenarioError
from cdpr.base.problems import MAX_PROBLEMS, Mark, Path, Problem, dotted, first_ones

MERGED = 4  # number of similar problems in list items that are merged into one line
VALUE = r"-?\d[\w.+-]*|'[^']*'"  # differences between similar problems


@dataclass
class Problems:
    """Collection of a scenario's problems."""

    items: list[Problem] = field(default_factory=list)
    paths: set[Path] = field(default_factory=set)
    unreadable: set[Path] = field(default_factory=set)

    def add(self, mark: Mark, path: Path, text: str, *, plugin: bool = False) -> None:
        """Add a problem, unless it is a consequence of an unreadable value."""
        if not _within(path, self.unreadable):
            self.items.append(Problem(mark, path, text, plugin))
            self.paths.add(path)

    def include(self, other: Problems) -> None:
        """Add all problems of another collection."""
        self.items += other.items
        self.paths |= other.paths
        self.unreadable |= other.unreadable

    def has(self, path: Path) -> bool:
        """Return True if a problem of this key or an enclosing section was added."""
        return _within(path, self.paths)

    def raise_any(self) -> None:
        """Raise ScenarioError with all problems, if any; PluginError if all are missing plugins."""
        if not self.items:
            return
        rows, lines = in_order(self.items), problem_lines(self.items)
        if all(problem.plugin for problem in self.items):
            raise PluginError("\n".join(lines), rows)
        raise ScenarioError(lines, rows)


def in_order(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Return the problems in the order of the files, without duplicates."""
    ordered = sorted(problems, key=lambda problem: (problem.mark, _rank(problem.path), problem.text))
    return tuple(dict.fromkeys(ordered))


def _rank(path: Path) -> tuple[tuple[str, int], ...]:
    """Return the sort key of a path: names as text, list items by number."""
    return tuple(("", part) if isinstance(part, int) else (part, 0) for part in path)


def problem_lines(problems: Iterable[Problem]) -> list[str]:
    """Return the problems as lines, with similar ones merged, and limited in number."""
    return first_ones(_merged(in_order(problems)), MAX_PROBLEMS)


def judged(warnings: Sequence[Problem], *, strict: bool) -> list[str]:
    """Return a line for each warning; with `strict`, raise ScenarioError if there are warnings."""
    if warnings and strict:
        raise ScenarioError(problem_lines(warnings), in_order(warnings))
    return [f"warning: {line}" for line in problem_lines(warnings)]


def _merged(problems: Sequence[Problem]) -> list[str]:
    """Return one line per problem, with similar problems in list items merged."""
    alike: dict[tuple[object, ...], list[Problem]] = {}
    for problem in problems:
        path = tuple("[]" if isinstance(part, int) else part for part in problem.path)
        alike.setdefault((problem.mark.source, path, re.sub(VALUE, "", problem.text)), []).append(problem)
    lines: list[str] = []
    for problem in problems:
        path = tuple("[]" if isinstance(part, int) else part for part in problem.path)
        group = alike[(problem.mark.source, path, re.sub(VALUE, "", problem.text))]
        if len(group) < MERGED or "[]" not in path:
            lines.append(str(problem))
        elif problem is group[0]:
            last = group[-1]
            place = f" in line {last.mark.line}" if last.mark.line else ""
            lines.append(f"{problem}; and {len(group) - 1} more like this, the last at {dotted(last.path)}{place}")
    return list(dict.fromkeys(lines))


def _within(path: Path, roots: set[Path]) -> bool:
    return any(path[:end] in roots for end in range(1, len(path) + 1))


def exact(value: float) -> str:
    """Return a number with all its digits, because rounding could hide the error."""
    return repr(float(value)).removesuffix(".0")
