"""Check of an installed plugin, as a test case."""

from __future__ import annotations

import unittest
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Generic, TypeVar

from cdpr.testing.check import Check, CheckResult, Failed

S = TypeVar("S")


@dataclass(frozen=True)
class Case(Generic[S]):
    """One check of one installed plugin; `str(case)` is its id, and a call raises if the plugin fails."""

    check: Check[S]
    make: Callable[[], AbstractContextManager[S]]
    expected_failures: Mapping[str, str]

    def __str__(self) -> str:
        return self.check.id

    def carry_out(self) -> CheckResult:
        """Run the check and return its result."""
        return self.check.carry_out(self.make(), self.expected_failures)

    def __call__(self) -> None:
        """Raise Failed if the plugin fails, and SkipTest if the check does not apply."""
        result = self.carry_out()
        if result.outcome == "failed":
            raise Failed(f"{result.id} ({result.reason}): {result.detail}")
        if result.outcome == "n/a":
            raise unittest.SkipTest(result.detail)
