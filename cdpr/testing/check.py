"""Checks and their execution."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from time import perf_counter
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cdpr.base.errors import one_line

S = TypeVar("S")

Outcome = Literal["passed", "failed", "n/a", "expected"]


class Failed(Exception):  # noqa: N818 - an outcome
    """Failure of a check; the text describes the plugin's behaviour."""


class NotApplicable(Exception):  # noqa: N818 - an outcome
    """Check that does not apply to this plugin; the text is the reason."""


@dataclass(frozen=True)
class CheckResult:
    """Result of one check.

    `outcome` is "passed", "failed", "n/a" (not applicable) or "expected" (failed as declared). `detail` describes the
    findings; `seconds` is the wall time.

    Example:
        >>> from cdpr.testing import CheckResult
        >>> CheckResult("repeats", "same input, same output", "passed", "", 0.01).outcome
        'passed'
    """

    id: str
    reason: str
    outcome: Outcome
    detail: str
    seconds: float


@dataclass(frozen=True)
class Check(Generic[S]):
    """Check of a plugin: a function that returns, optionally with a remark, or raises Failed or NotApplicable.

    Its name is the check's id. The first line of its docstring is the reason, the rest describes details.
    """

    function: Callable[[S], str | None]

    @property
    def id(self) -> str:
        """Id of the check."""
        return self.function.__name__

    @property
    def reason(self) -> str:
        """Purpose of the check in one line."""
        return (self.function.__doc__ or "").strip().splitlines()[0].rstrip(".")

    @property
    def description(self) -> str:
        """Reason and details as one line, for docs/plugin_checks.md."""
        return " ".join((self.function.__doc__ or "").split()).rstrip(".")

    def carry_out(self, subject: AbstractContextManager[S], expected_failures: Mapping[str, str]) -> CheckResult:
        """Run the check; return a result whatever the plugin does."""
        started = perf_counter()
        outcome, detail = self._outcome(subject)
        seconds = perf_counter() - started
        known = expected_failures.get(self.id)
        if known is not None and outcome == "failed":
            outcome, detail = "expected", f"{known} ({detail})"
        elif known is not None and outcome == "passed":
            outcome, detail = "failed", f"passed, but it is declared as an expected failure: {known}"
        return CheckResult(self.id, self.reason, outcome, detail, seconds)

    def _outcome(self, subject: AbstractContextManager[S]) -> tuple[Outcome, str]:
        try:
            # warnings of a plugin on NaN inputs are no failure
            with np.errstate(all="ignore"), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with subject as plugin:
                    return "passed", self.function(plugin) or ""
        except NotApplicable as reason:
            return "n/a", str(reason)
        except Failed as failure:
            return "failed", str(failure)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            return "failed", f"raised {one_line(error)}"


def expect(condition: object, otherwise: str) -> None:
    """Raise Failed with a text unless the condition holds."""
    if not condition:
        raise Failed(otherwise)


def expect_close(actual: ArrayLike, wanted: ArrayLike, tolerance: float, what: str) -> None:
    """Raise Failed unless all entries are finite and within `tolerance` of the wanted ones."""
    distance = float(np.max(np.abs(np.asarray(actual, dtype=float) - np.asarray(wanted, dtype=float)), initial=0.0))
    expect(distance <= tolerance, f"{what}: off by {distance:.3g}, allowed {tolerance:.3g}")


def expect_same_bits(actual: ArrayLike, wanted: ArrayLike, what: str) -> None:
    """Raise Failed unless two arrays have the same bits."""
    a, b = np.asarray(actual), np.asarray(wanted)
    if a.tobytes() != b.tobytes():
        raise Failed(f"{what}: differs by up to {float(np.max(np.abs(a - b))):.3g}, expected identical bits")


def needs(condition: object, otherwise: str) -> None:
    """Raise NotApplicable with a text unless the condition holds."""
    if not condition:
        raise NotApplicable(otherwise)
