"""What a check is, and how one is carried out."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from time import perf_counter
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cdpr.errors import one_line

S = TypeVar("S")

Outcome = Literal["passed", "failed", "n/a", "expected"]


class Failed(Exception):  # noqa: N818 - an outcome
    """The plugin does not do what the check asks; the text says what it does instead."""


class NotApplicable(Exception):  # noqa: N818 - an outcome
    """The check does not concern this plugin; the text says why."""


@dataclass(frozen=True)
class CheckResult:
    """What came of one check.

    `outcome` is "passed", "failed", "n/a" (does not concern this plugin) or "expected" (failed, as declared). `detail`
    says what was found; `seconds` is the wall time it took.
    """

    id: str
    reason: str
    outcome: Outcome
    detail: str
    seconds: float


@dataclass(frozen=True)
class Check(Generic[S]):
    """A function of a plugin under test: it returns, perhaps with a remark, or raises Failed or NotApplicable.

    Its name is the check's id, and the first line of its docstring the reason for it.
    """

    function: Callable[[S], str | None]

    @property
    def id(self) -> str:
        """The check's name."""
        return self.function.__name__

    @property
    def reason(self) -> str:
        """What the check is for, in one line."""
        return (self.function.__doc__ or "").strip().splitlines()[0].rstrip(".")

    def carry_out(self, subject: AbstractContextManager[S], expected_failures: Mapping[str, str]) -> CheckResult:
        """Run the check; whatever the plugin does, there is a result."""
        started = perf_counter()
        outcome, detail = self._outcome(subject)
        seconds = perf_counter() - started
        known = expected_failures.get(self.id)
        if known is not None and outcome == "failed":
            outcome, detail = "expected", f"{known} ({detail})"
        elif known is not None and outcome == "passed":
            outcome, detail = "failed", f"passes, though declared to fail: {known}"
        return CheckResult(self.id, self.reason, outcome, detail, seconds)

    def _outcome(self, subject: AbstractContextManager[S]) -> tuple[Outcome, str]:
        try:
            # What a plugin warns of while it is given NaN is no fault, whatever the caller makes of warnings.
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
    """Fail with a text unless the condition holds."""
    if not condition:
        raise Failed(otherwise)


def expect_close(actual: ArrayLike, wanted: ArrayLike, tolerance: float, what: str) -> None:
    """Fail unless all entries are finite and within `tolerance` of those wanted."""
    distance = float(np.max(np.abs(np.asarray(actual, dtype=float) - np.asarray(wanted, dtype=float)), initial=0.0))
    expect(distance <= tolerance, f"{what}: off by {distance:.3g}, allowed {tolerance:.3g}")


def expect_same_bits(actual: ArrayLike, wanted: ArrayLike, what: str) -> None:
    """Fail unless two arrays hold the same bits."""
    a, b = np.asarray(actual), np.asarray(wanted)
    if a.tobytes() != b.tobytes():
        raise Failed(f"{what}: differs by up to {float(np.max(np.abs(a - b))):.3g}, not one bit is allowed")


def needs(condition: object, otherwise: str) -> None:
    """Leave the check as not applicable unless the condition holds."""
    if not condition:
        raise NotApplicable(otherwise)
