"""Support of a scenario by its uses: of its sections, and of the parts of its loop (see `cdpr.base.needs`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.fields import Kind
from cdpr.base.needs import UNDECLARED, USES, Needs, Support
from cdpr.base.problems import Mark, Path, dotted
from cdpr.cables import chain_of
from cdpr.config.problems import Problems
from cdpr.model import Robot
from cdpr.scenario import Scenario
from cdpr.scenario.needs import in_use
from cdpr.simulation.loop_parts import loop_parts


def require(scenario: Scenario, use: str) -> None:
    """Raise ScenarioError unless a use, one of `USES`, supports all sections in use and all parts of the loop."""
    problems, reasons = Problems(), set()
    for path, needs, value in in_use(scenario):
        support = needs.support(use)
        if support.level == "no":
            problems.add(scenario.mark(*path), path, f"{_unsupported(use, support)}; {_remedy(path, value)}")
            reasons.add(support.why)
    unsupported = dict.fromkeys((title, needs.support(use)) for _, title, needs in _parts(scenario))
    for title, support in unsupported:
        if support.level == "no" and support.why not in reasons:  # the section of the part may have the same
            problems.add(
                Mark(scenario.mark().source), (), f"{title}: {_unsupported(use, support)}; remove it from the loop"
            )
    problems.raise_any()


def require_parts(robot: Robot, use: str) -> None:
    """Raise CdprError unless a use, one of `USES`, supports the winches and spans of a robot without a scenario."""
    for cable in robot.cables:
        chain = chain_of(robot, cable)
        for part in (chain.winch, chain.span):
            support = (part.needs or UNDECLARED).support(use)
            if support.level == "no":
                raise CdprError(f"robot '{robot.name}', cable '{cable.name}': {_unsupported(use, support)}")


def supported(scenario: Scenario, use: str) -> bool:
    """Return True if a use, one of `USES`, supports all sections in use and all parts of the loop."""
    declared = [*(needs for _, needs, _ in in_use(scenario)), *(needs for _, _, needs in _parts(scenario))]
    return all(needs.support(use).level != "no" for needs in declared)


def omitted(scenario: Scenario, use: str) -> list[str]:
    """Return what a use, one of `USES`, leaves out: one line for each section or part and reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for path, needs, value in in_use(scenario):
        support = needs.support(use)
        if support.level == "left out":
            listed = any(isinstance(part, int) for part in path)
            key = dotted(path[: next(i for i, part in enumerate(path) if isinstance(part, int))] if listed else path)
            found.setdefault((key, support.why), []).extend([_title(value)] if listed else [])
    for name, title, needs in _parts(scenario):
        support = needs.support(use)
        if support.level == "left out" and (name, support.why) not in found:  # the section of the part is reported
            found[title, support.why] = []
    return [f"{key}: {why}{_in_brackets(titles)}" for (key, why), titles in found.items()]


def _parts(scenario: Scenario) -> Iterator[tuple[str, str, Needs]]:
    """Yield section or name, title and needs of each part of the loop."""
    for part in loop_parts(scenario):
        for needs in part.all_needs:
            yield part.section or part.name, part.title, needs


def _unsupported(use: str, support: Support) -> str:
    return f"not supported by {USES[use]}{f': {support.why}' if support.why else ''}"


def _remedy(path: Path, value: Any) -> str:
    if isinstance(value, Kind) and not isinstance(path[-1], int):
        return f"choose another type (--set {dotted(path)}.type=TYPE)"
    if isinstance(value, str):
        return f"choose another value (--set {dotted(path)}=VALUE)"
    return "remove it from the file"


def _title(value: Any) -> str:
    """Return a short name of an item of a list, such as "wrench at 0.5 s"."""
    kind, time = getattr(value, "type", ""), getattr(value, "time", None)
    return (f"{kind} at {time:g} s" if isinstance(time, float | int) else kind) or str(getattr(value, "name", "") or "")


def _in_brackets(titles: Sequence[str]) -> str:
    given = [title for title in titles if title]
    return f" ({', '.join(given)})" if given else ""
